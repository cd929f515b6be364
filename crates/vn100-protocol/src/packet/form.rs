//! The form of a packet: its fields, and the places of the measured ones.

use alloc::{borrow::Cow, sync::Arc, vec::Vec};
use core::{fmt, ops::Range};

use multiversion::multiversion;
use thiserror::Error;

use super::field::{Correction, FieldContent, GROUPS, Numbers, present};
use crate::{
    framing::packet::{Packet, PacketRun},
    message::{
        layout::{Channel, Layout, Quantity},
        quantity::rounded,
    },
};

/// The name of packets as a message, in layouts.
pub const BINARY: &str = "BINARY";

/// `FA`, groups and a word for each of the four groups.
const MAX_HEADER: usize = 2 + 2 * GROUPS.len();

/// The groups and words at the beginning of a packet, which distinguish the packets of one binary
/// output from those of another.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct PacketHeader([u8; MAX_HEADER]);

impl PacketHeader {
    /// The header of packets with these groups and a word of fields for each, as in registers 75 to
    /// 77; further words than four are ignored.
    pub fn new(groups: u8, words: &[u16]) -> Self {
        let mut header = [0; MAX_HEADER];
        (header[0], header[1]) = (crate::framing::packet::START, groups);
        for (bytes, word) in header[2..].chunks_exact_mut(2).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        Self(header)
    }

    /// The groups, and their words.
    pub fn parts(&self) -> (u8, Vec<u16>) {
        let words = self.0[2..].chunks_exact(2).map(|word| u16::from_le_bytes([word[0], word[1]]));
        (self.0[1], words.take(self.0[1].count_ones() as usize).collect())
    }

    /// The header of a packet.
    pub fn of(packet: &Packet<'_>) -> Self {
        let mut header = [0; MAX_HEADER];
        let groups = packet.raw.get(1).map_or(0, |groups| groups.count_ones() as usize);
        let length = (2 + 2 * groups).min(packet.raw.len()).min(MAX_HEADER);
        header[..length].copy_from_slice(&packet.raw[..length]);
        Self(header)
    }
}

/// The known fields by their names in the manual, in the order of the wire.
impl fmt::Display for PacketHeader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (groups, words) = self.parts();
        let names: Vec<_> = present(groups, &words).map(|field| field.name).filter(|name| !name.is_empty()).collect();
        f.write_str(&names.join(", "))
    }
}

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
    header: [u8; MAX_HEADER],
    header_length: usize,
    /// The channels that are measured.
    pub layout: Arc<Layout>,
    runs: Vec<Run>,
    device_time_at: Option<usize>,
    saturation_at: Option<usize>,
}

/// Floats of consecutive channels of one quantity in the bytes of a packet.
#[derive(Debug, Clone, PartialEq)]
struct Run {
    channels: &'static [Channel],
    bytes: Range<usize>,
    /// The place of the interval by which they are divided.
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

/// A run of channels in the bytes of a packet.
struct Found {
    numbers: Numbers,
    at: usize,
    interval_at: Option<usize>,
}

impl PacketForm {
    /// The form of a packet; `None` if it has neither angular rate nor acceleration, so it is not
    /// measured.
    pub fn of(packet: &Packet<'_>) -> Option<Self> {
        let groups = *packet.raw.get(1)?;
        let header_length = 2 + 2 * groups.count_ones() as usize;
        let header = packet.raw.get(..header_length).filter(|header| header.len() <= MAX_HEADER)?;
        let words: Vec<u16> = header[2..].chunks_exact(2).map(|word| u16::from_le_bytes([word[0], word[1]])).collect();
        Self::new(groups, &words)
    }

    /// The form of packets with these groups and a word of fields for each, as in registers 75 to
    /// 77; `None` if it has neither angular rate nor acceleration, if a field is unknown, or if the
    /// numbers of groups and words differ.
    pub fn new(groups: u8, words: &[u16]) -> Option<Self> {
        crate::framing::packet::length(groups, words)?;
        let PacketHeader(header) = PacketHeader::new(groups, words);
        let header_length = 2 + 2 * words.len();
        let (mut at, mut interval_at) = (header_length, None);
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
        Self { header, header_length, device_time_at, saturation_at, ..Self::measuring(found)? }.into()
    }

    /// The best source of each quantity, in the order of the quantities.
    fn measuring(mut found: Vec<Found>) -> Option<Self> {
        let quantity = |found: &Found| found.numbers.channels[0].quantity;
        let has_angles = found.iter().any(|found| quantity(found) == Quantity::Angle);
        found.sort_by_key(|found| (quantity(found), found.numbers.processing));
        let (mut runs, mut channels) = (Vec::new(), Vec::new());
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
            let first = &found.numbers.channels[0];
            runs.push(Run {
                channels: found.numbers.channels,
                bytes: found.at..found.at + 4 * found.numbers.channels.len(),
                interval_at: found.interval_at,
                counts: found.numbers.unit_scale / first.scale,
                limit_counts: first.limit_counts.into(),
            });
            channels.extend(found.numbers.channels.iter().cloned());
        }
        channels.iter().any(|channel| is_motion(channel.quantity)).then(|| Self {
            header: [0; MAX_HEADER],
            header_length: 0,
            layout: Arc::new(Layout {
                message: Cow::Borrowed(BINARY),
                compensated,
                channels: channels.into(),
                columns: None,
            }),
            runs,
            device_time_at: None,
            saturation_at: None,
        })
    }

    /// The header of its packets.
    pub const fn header(&self) -> PacketHeader {
        PacketHeader(self.header)
    }

    /// Whether the packet has this form.
    #[inline]
    pub fn is_of(&self, packet: &Packet<'_>) -> bool {
        // a comparison of two numbers if there are enough bytes, as nearly always
        match (packet.raw.first_chunk(), self.header.first_chunk()) {
            (Some(begin), Some(header)) if self.header_length <= 8 => {
                let unused = 64 - 8 * self.header_length as u32;
                let differing = u64::from_le_bytes(*begin) ^ u64::from_le_bytes(*header);
                differing << unused == 0
            }
            _ => packet.raw.starts_with(&self.header[..self.header_length]),
        }
    }

    /// Appends the counts of a packet of this form, one for each channel of the layout.
    ///
    /// # Errors
    /// For the first number that is infinite, no number or beyond the limit of its channel, and for
    /// increments over an interval that is not positive. No count is appended then.
    pub fn read(&self, packet: &Packet<'_>, counts: &mut Vec<i32>) -> Result<(), RejectedPacket> {
        if self.read_run(&packet.into(), counts) {
            return Ok(());
        }
        self.runs.iter().find_map(|run| run.rejected(packet.raw)).map_or(Ok(()), Err)
    }

    /// Appends the counts of packets of this form, as [`read`](Self::read) does for each. If one is
    /// rejected, no count is appended and the result is false.
    #[inline]
    pub(crate) fn read_run(&self, packets: &PacketRun<'_>, counts: &mut Vec<i32>) -> bool {
        let (before, width) = (counts.len(), self.layout.channels.len());
        counts.resize(before + packets.count() * width, 0);
        let mut rows = Columns { counts: &mut counts[before..], width, first: 0 };
        let mut is_good = true;
        for run in &self.runs {
            is_good &= run.read(packets, &mut rows);
            rows.first += run.channels.len();
        }
        if !is_good {
            counts.truncate(before);
        }
        is_good
    }

    /// Appends the device times of these packets, if they contain them; returns whether no packet
    /// has the time of the one before it, or the first packet `last_ns`.
    #[inline]
    pub(crate) fn read_device_times(
        &self,
        packets: &PacketRun<'_>,
        last_ns: Option<u64>,
        times: &mut Vec<u64>,
    ) -> bool {
        let Some(at) = self.device_time_at else { return true };
        let before = times.len();
        let packets = packets.bytes.chunks_exact(packets.length);
        times.extend(packets.map(|raw| raw[at..].first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes))));
        let times = &times[before..];
        let is_first_new = times.first().copied() != last_ns;
        is_first_new && times.iter().zip(&times[1.min(times.len())..]).all(|(before, now)| before != now)
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

/// The columns of rows of counts, from the first one on.
struct Columns<'a> {
    counts: &'a mut [i32],
    width: usize,
    first: usize,
}

impl Run {
    /// Reads the counts of these channels in each packet; returns whether all are numbers that a
    /// sensor measures.
    #[inline]
    fn read(&self, packets: &PacketRun<'_>, rows: &mut Columns<'_>) -> bool {
        match self.channels.len() {
            3 => read_channels::<3, 4>(self, 0, packets, rows),
            4 => read_channels::<4, 4>(self, 0, packets, rows),
            channels => (0..channels).all(|channel| read_channels::<1, 1>(self, channel, packets, rows)),
        }
    }

    /// Counts of one unit in this packet; NaN if no increments can have its interval.
    #[inline]
    fn counts_per_one(&self, raw: &[u8]) -> f64 {
        match self.interval_s(raw) {
            None => self.counts,
            Some(interval_s) if interval_s > 0.0 && interval_s <= LONGEST_INTERVAL_S => self.counts / interval_s,
            Some(_) => f64::NAN,
        }
    }

    /// The interval of increments.
    #[inline]
    fn interval_s(&self, raw: &[u8]) -> Option<f64> {
        self.interval_at.and_then(|at| floats(raw, &(at..at + 4)).next())
    }

    #[cold]
    fn rejected(&self, raw: &[u8]) -> Option<RejectedPacket> {
        let per_one = self.counts_per_one(raw);
        if let (Some(value), true) = (self.interval_s(raw), per_one.is_nan()) {
            return Some(RejectedPacket {
                channel: "the interval of the increments",
                value,
                limit: LONGEST_INTERVAL_S,
            });
        }
        let mut scaled = floats(raw, &self.bytes).map(|float| float * per_one).zip(self.channels);
        let is_bad = |scaled: f64| scaled.is_nan() || scaled.abs() > self.limit_counts;
        let (scaled, channel) = scaled.find(|(scaled, _)| is_bad(*scaled))?;
        Some(RejectedPacket {
            channel: &channel.name,
            value: channel.in_unit(scaled),
            limit: channel.value(channel.limit_counts),
        })
    }
}

/// The counts of `COUNT` channels of a run, from this one on; returns whether all are numbers that
/// a sensor measures. `LANES` are computed together, which is no slower than three.
#[multiversion(targets("x86_64+avx2"))]
fn read_channels<const COUNT: usize, const LANES: usize>(
    run: &Run,
    first: usize,
    packets: &PacketRun<'_>,
    rows: &mut Columns<'_>,
) -> bool {
    let (at, column) = (run.bytes.start + 4 * first, rows.first + first);
    let mut bad = [0; LANES];
    for (raw, row) in packets.bytes.chunks_exact(packets.length).zip(rows.counts.chunks_exact_mut(rows.width)) {
        let per_one = run.counts_per_one(raw);
        let (floats, _) = raw[at..].as_chunks();
        let Some(counts) = row[column..].first_chunk_mut::<COUNT>().filter(|_| floats.len() >= COUNT) else {
            return false;
        };
        let floats = match floats.first_chunk::<LANES>() {
            // the bytes after the channels have no effect
            Some(floats) => *floats,
            None => core::array::from_fn(|lane| floats.get(lane).copied().unwrap_or_default()),
        };
        let scaled = floats.map(|float| f64::from(f32::from_le_bytes(float)) * per_one);
        for (bad, scaled) in bad.iter_mut().zip(scaled) {
            // a comparison with NaN is false
            *bad |= if scaled.abs() <= run.limit_counts { 0 } else { u64::MAX };
        }
        counts.copy_from_slice(&scaled.map(rounded)[..COUNT]);
    }
    bad[..COUNT] == [0; COUNT]
}

#[inline]
fn floats(raw: &[u8], bytes: &Range<usize>) -> impl Iterator<Item = f64> {
    let (floats, _) = raw[bytes.clone()].as_chunks();
    floats.iter().map(|bytes| f32::from_le_bytes(*bytes).into())
}
