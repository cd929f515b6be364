//! The form of a packet: its fields, and the places of the measured ones.

use alloc::{borrow::Cow, sync::Arc, vec::Vec};

use thiserror::Error;

use super::{
    field::{Correction, FieldContent, Numbers, present},
    header::PacketHeader,
};
use crate::{
    framing::packet::Packet,
    message::{
        layout::{Channel, Layout, Quantity},
        quantity::rounded,
    },
};

/// The name of packets as a message, in layouts.
pub const BINARY: &str = "BINARY";

/// The fields of packets that begin with the same groups and words, and the rules for reading them.
///
/// Attitude, magnetic field, acceleration, angular rate, temperature and pressure are measured,
/// each once: uncompensated is preferred to compensated, and increments are used only if there is
/// no other source. The attitude is that of the angles if a packet has them, else the quaternion.
///
/// A count is the float rounded to the nearest multiple of its size, ties to even: 2^-21 deg, 2^-29
/// of a quaternion, 2^-27 gauss, 2^-23 m/s², °C and kPa, 2^-25 rad/s.
#[derive(Debug, Clone, PartialEq)]
pub struct PacketForm {
    /// The header of its packets.
    pub header: PacketHeader,
    /// The channels that are measured.
    pub layout: Arc<Layout>,
    numbers: Vec<MeasuredNumber>,
    device_time_at: Option<usize>,
    saturation_at: Option<usize>,
}

/// The float of a channel in the bytes of a packet.
#[derive(Debug, Clone, PartialEq)]
struct MeasuredNumber {
    channel: &'static Channel,
    at: usize,
    /// The place of the interval by which it is divided.
    interval_at: Option<usize>,
    /// Counts of one unit of the packet.
    counts: f64,
    limit_counts: f64,
}

/// A number that no VN-100 measures, in a packet with a correct CRC.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("{channel} is {value}, beyond ±{limit}")]
pub struct RejectedPacket {
    /// The channel, or the interval of increments.
    pub channel: &'static str,
    /// Its number in the unit of the channel; it may be infinite or no number.
    pub value: f64,
    /// The largest magnitude it may have.
    pub limit: f64,
}

/// The longest interval of the increments of a packet, and of `$VNDTV`.
const LONGEST_INTERVAL_S: f64 = 2000.0;

struct Found {
    numbers: Numbers,
    at: usize,
    interval_at: Option<usize>,
}

impl PacketForm {
    /// The form of a packet; `None` if it has neither angular rate nor acceleration, so it is not
    /// measured.
    pub fn of(packet: &Packet<'_>) -> Option<Self> {
        let (groups, words) = PacketHeader::of(packet.raw).parts();
        Self::new(groups, &words)
    }

    /// The form of packets with these groups and a word of fields for each, as in registers 75 to
    /// 77; `None` if it has neither angular rate nor acceleration, if a field is unknown, or if the
    /// numbers of groups and words differ.
    pub fn new(groups: u8, words: &[u16]) -> Option<Self> {
        crate::framing::packet::length(groups, words)?;
        let (mut at, mut interval_at) = (2 + 2 * words.len(), None);
        let (mut device_time_at, mut saturation_at) = (None, None);
        let mut found = Vec::new();
        for field in present(groups, words) {
            let mut put = |runs: &[Numbers], mut at: usize, interval_at: Option<usize>| {
                for numbers in runs {
                    found.push(Found { numbers: *numbers, at, interval_at });
                    at += 4 * numbers.channels.len();
                }
            };
            match field.content {
                FieldContent::Numbers(runs) => put(runs, at, None),
                FieldContent::Increments(runs) => {
                    interval_at = Some(at);
                    put(runs, at + 4, interval_at);
                }
                FieldContent::MoreIncrements(runs) if interval_at.is_some() => put(runs, at, interval_at),
                FieldContent::DeviceTime => device_time_at = device_time_at.or(Some(at)),
                FieldContent::Saturation => saturation_at = Some(at),
                FieldContent::MoreIncrements(_) | FieldContent::Other => {}
            }
            at += usize::from(field.bytes);
        }
        Self { header: PacketHeader::new(groups, words), device_time_at, saturation_at, ..Self::measuring(found)? }
            .into()
    }

    /// The best source of each quantity, in the order of the quantities.
    fn measuring(mut found: Vec<Found>) -> Option<Self> {
        let quantity = |found: &Found| found.numbers.channels[0].quantity;
        let has_angles = found.iter().any(|found| quantity(found) == Quantity::Angle);
        found.sort_by_key(|found| (quantity(found), found.numbers.processing));
        let (mut numbers, mut channels) = (Vec::new(), Vec::new());
        let is_motion = |quantity: Quantity| matches!(quantity, Quantity::AngularRate | Quantity::Acceleration);
        let (mut compensated, mut before) = (None, None);
        for found in found {
            let quantity = quantity(&found);
            if before == Some(quantity) || has_angles && quantity == Quantity::Quaternion {
                continue;
            }
            before = Some(quantity);
            // if both are present, the rates decide, which come last: a filter removes their bias
            if is_motion(quantity) {
                compensated = match found.numbers.processing {
                    Correction::Uncompensated => Some(false),
                    Correction::Compensated | Correction::Undocumented => Some(true),
                    Correction::Integrated => None,
                };
            }
            numbers.extend(found.numbers.channels.iter().enumerate().map(|(place, channel)| MeasuredNumber {
                channel,
                at: found.at + 4 * place,
                interval_at: found.interval_at,
                counts: found.numbers.unit_scale / channel.scale,
                limit_counts: channel.limit_counts.into(),
            }));
            channels.extend(found.numbers.channels.iter().cloned());
        }
        channels.iter().any(|channel| is_motion(channel.quantity)).then(|| Self {
            header: PacketHeader::default(),
            layout: Arc::new(Layout {
                message: Cow::Borrowed(BINARY),
                compensated,
                channels: channels.into(),
                columns: None,
            }),
            numbers,
            device_time_at: None,
            saturation_at: None,
        })
    }

    /// Whether the packet has this form.
    #[inline]
    pub fn is_of(&self, packet: &Packet<'_>) -> bool {
        PacketHeader::of(packet.raw) == self.header
    }

    /// Appends the counts of a packet of this form, one for each channel of the layout.
    ///
    /// # Errors
    /// For the first number that is infinite, no number or beyond the limit of its channel, and for
    /// increments over an interval that is not positive. No count is appended then.
    pub fn read(&self, packet: &Packet<'_>, counts: &mut Vec<i32>) -> Result<(), RejectedPacket> {
        let before = counts.len();
        let mut are_measured = true;
        // without a branch for each number
        counts.extend(self.numbers.iter().map(|number| {
            let scaled = number.scaled(packet.raw);
            are_measured &= number.is_measured(scaled);
            rounded(scaled)
        }));
        if !are_measured && let Some(rejected) = self.numbers.iter().find_map(|number| number.rejected(packet.raw)) {
            counts.truncate(before);
            return Err(rejected);
        }
        Ok(())
    }

    /// The time of the measurement in nanoseconds since the sensor started; `None` if the packet
    /// does not contain it.
    #[inline]
    pub fn device_ns(&self, packet: &Packet<'_>) -> Option<u64> {
        let bytes = packet.raw[self.device_time_at?..].first_chunk()?;
        Some(u64::from_le_bytes(*bytes))
    }

    /// The axes that were at the end of their range: bits 0 to 2 magnetic field x y z, 3 to 5
    /// acceleration, 6 to 8 angular rate, 9 pressure; 0 if the packet does not tell.
    #[inline]
    pub fn saturation(&self, packet: &Packet<'_>) -> u16 {
        let bytes = self.saturation_at.and_then(|at| packet.raw[at..].first_chunk());
        bytes.map_or(0, |bytes| u16::from_le_bytes(*bytes))
    }
}

impl MeasuredNumber {
    /// Its counts before rounding; NaN if no increments can have its interval.
    #[inline]
    fn scaled(&self, raw: &[u8]) -> f64 {
        let per_one = match self.interval_at.map(|at| float(raw, at)) {
            None => self.counts,
            Some(interval_s) if is_interval(interval_s) => self.counts / interval_s,
            Some(_) => f64::NAN,
        };
        float(raw, self.at) * per_one
    }

    /// Whether a sensor can measure this count; false for NaN.
    #[inline]
    fn is_measured(&self, scaled: f64) -> bool {
        scaled.abs() <= self.limit_counts
    }

    #[cold]
    fn rejected(&self, raw: &[u8]) -> Option<RejectedPacket> {
        let (channel, scaled) = (self.channel, self.scaled(raw));
        if let Some(value) = self.interval_at.map(|at| float(raw, at)).filter(|interval_s| !is_interval(*interval_s)) {
            let channel = "the interval of the increments";
            return Some(RejectedPacket { channel, value, limit: LONGEST_INTERVAL_S });
        }
        (!self.is_measured(scaled)).then(|| RejectedPacket {
            channel: &channel.name,
            value: channel.in_unit(scaled),
            limit: channel.value(channel.limit_counts),
        })
    }
}

fn is_interval(interval_s: f64) -> bool {
    interval_s > 0.0 && interval_s <= LONGEST_INTERVAL_S
}

/// The float at this place, which lies within a packet of the form.
#[inline]
fn float(raw: &[u8], at: usize) -> f64 {
    raw.get(at..).and_then(|rest| rest.first_chunk()).map_or(f64::NAN, |bytes| f32::from_le_bytes(*bytes).into())
}
