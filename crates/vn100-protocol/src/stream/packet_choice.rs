//! Which packets are measured where a sensor sends several binary outputs.

use alloc::vec::Vec;

use crate::{Packet, PacketForm, PacketHeader};

/// How long packets without angular rates, or without accelerations, wait for those of an output
/// that has both: each output has sent by then, as none is slower than 1 Hz.
const LONGEST_NS: i64 = 1_200_000_000;

/// The same where no time is known: as many as two outputs of 800 Hz send in it.
const MOST_PACKETS: usize = 1920;

/// Packets that are measured if none with more comes in time.
#[derive(Debug, Default)]
pub(super) struct PacketChoice {
    held: Vec<HeldPacket>,
    /// The first of them.
    form: Option<PacketForm>,
    first_ns: Option<i64>,
}

/// Whether the choice is made with a packet.
pub(super) enum Chosen {
    /// It is; the packet follows those that waited.
    Now,
    /// The packet waits.
    NotYet,
    /// The packet is none that can be measured.
    NotMeasured,
}

/// A packet, and when it was received.
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

    /// The form to measure, if there is one, and the packets that waited for it.
    pub(super) fn take(&mut self) -> (Option<PacketForm>, Vec<HeldPacket>) {
        let Self { held, form, .. } = core::mem::take(self);
        (form, held)
    }

    /// Of the packets that wait.
    pub(super) fn headers(&self) -> impl Iterator<Item = PacketHeader> {
        self.held.iter().map(|held| PacketHeader::of(&held.packet()))
    }
}
