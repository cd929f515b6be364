//! The packets of one form as rows.

use alloc::{collections::BTreeMap, vec::Vec};

use crate::{MeasuredPackets, Packet, PacketForm, PacketHeader, RejectedPacket};

/// The most other headers that are counted separately: a sensor has three binary outputs, whose
/// settings may change.
const MOST_OTHER_HEADERS: usize = 16;

/// Reads the packets of the form that is measured. Other packets are counted only by the framer.
#[derive(Debug, Default)]
pub(super) struct PacketReader {
    pub(super) form: Option<PacketForm>,
    pub(super) counts: MeasuredPackets,
    others: BTreeMap<PacketHeader, u64>,
    pub(super) first_other: Option<PacketHeader>,
    last_device_ns: Option<u64>,
    /// Space for decoding a packet to test whether it is a row.
    tried: Vec<i32>,
}

pub(super) enum PacketOutcome {
    /// A row, whose counts were appended.
    Sample { device_ns: Option<u64>, saturation: u16 },
    /// No row, because a number in it is beyond the range of a sensor.
    Rejected(RejectedPacket),
    /// No row, because it repeats the one before or has another form.
    None,
}

impl PacketReader {
    #[inline]
    pub(super) fn read(&mut self, packet: &Packet<'_>, counts: &mut Vec<i32>) -> PacketOutcome {
        let Some(form) = self.form.as_ref().filter(|form| form.is_of(packet)) else {
            self.count_other(packet);
            return PacketOutcome::None;
        };
        let device_ns = form.device_ns(packet);
        if is_repeated(self.last_device_ns, device_ns) {
            self.counts.repeated += 1;
            return PacketOutcome::None;
        }
        match form.read(packet, counts) {
            Ok(()) => {
                self.counts.samples += 1;
                self.last_device_ns = device_ns;
                PacketOutcome::Sample { device_ns, saturation: form.saturation(packet) }
            }
            Err(rejected) => {
                self.counts.rejected += 1;
                PacketOutcome::Rejected(rejected)
            }
        }
    }

    #[cold]
    fn count_other(&mut self, packet: &Packet<'_>) {
        let header = PacketHeader::of(packet.raw);
        self.first_other.get_or_insert(header);
        if self.others.len() < MOST_OTHER_HEADERS || self.others.contains_key(&header) {
            *self.others.entry(header).or_default() += 1;
        }
    }

    /// Packets of each form so far, except those that wait for the choice of the form.
    pub(super) fn packets(&self) -> impl Iterator<Item = (PacketHeader, u64)> {
        let MeasuredPackets { samples, rejected, repeated, .. } = self.counts;
        let measured = self.form.as_ref().map(|form| (form.header, samples + rejected + repeated));
        let others = self.others.iter().map(|(header, packets)| (*header, *packets));
        others.chain(measured)
    }

    /// Whether the packet is a row without marks.
    pub(super) fn is_one_more_row(&mut self, packet: &Packet<'_>) -> bool {
        let Some(form) = self.form.as_ref().filter(|form| form.is_of(packet)) else { return false };
        self.tried.clear();
        let is_read = form.read(packet, &mut self.tried).is_ok();
        is_read && form.saturation(packet) == 0 && !is_repeated(self.last_device_ns, form.device_ns(packet))
    }
}

fn is_repeated(last_ns: Option<u64>, device_ns: Option<u64>) -> bool {
    device_ns.is_some() && device_ns == last_ns
}
