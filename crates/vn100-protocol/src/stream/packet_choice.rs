//! The choice of the packets that are measured if a sensor sends several binary outputs.

use alloc::vec::Vec;

use crate::{Packet, PacketForm, PacketHeader};

/// How long packets without angular rates, or without accelerations, wait for packets with both: by
/// then each output has sent, because none is slower than 1 Hz.
const LONGEST_NS: i64 = 1_200_000_000;

/// The same limit if no time is known: two outputs of 800 Hz send as many packets in that time.
const MOST_PACKETS: usize = 1920;

/// Packets that are measured unless packets with more quantities come in time.
#[derive(Debug, Default)]
pub(super) struct PacketChoice {
    held: Vec<HeldPacket>,
    /// The form of the first of them.
    form: Option<PacketForm>,
    first_ns: Option<i64>,
}

/// The outcome of a packet.
pub(super) enum Chosen {
    /// The choice is made; the packet follows the pending ones.
    Now,
    /// The packet stays pending.
    NotYet,
    /// The packet cannot be measured.
    NotMeasured,
}

/// A packet with its arrival time.
#[derive(Debug)]
pub(super) struct HeldPacket {
    raw: Vec<u8>,
    offset: u64,
    pub(super) at_ns: Option<i64>,
}

impl HeldPacket {
    pub(super) fn packet(&self) -> Packet<'_> {
        Packet { raw: &self.raw, offset: self.offset }
    }
}

impl PacketChoice {
    /// Takes the next packet.
    pub(super) fn push(&mut self, packet: &Packet<'_>, at_ns: Option<i64>) -> Chosen {
        let Some(form) = PacketForm::of(packet) else { return Chosen::NotMeasured };
        let time = at_ns.or_else(|| form.device_ns(packet)?.try_into().ok());
        let is_complete = form.is_complete();
        match &mut self.form {
            Some(chosen) if is_complete => *chosen = form,
            Some(_) => {}
            none => (*none, self.first_ns) = (Some(form), time),
        }
        let waited_ns = time.zip(self.first_ns).map_or(0, |(time, first)| time.saturating_sub(first));
        if is_complete || waited_ns >= LONGEST_NS || self.held.len() >= MOST_PACKETS {
            return Chosen::Now;
        }
        self.held.push(HeldPacket { raw: packet.raw.into(), offset: packet.offset, at_ns });
        Chosen::NotYet
    }

    /// The form to measure, if there is one, and the pending packets.
    pub(super) fn take(&mut self) -> (Option<PacketForm>, Vec<HeldPacket>) {
        let Self { held, form, .. } = core::mem::take(self);
        (form, held)
    }

    pub(super) fn headers(&self) -> impl Iterator<Item = PacketHeader> {
        self.held.iter().map(|held| PacketHeader::of(&held.packet()))
    }
}
