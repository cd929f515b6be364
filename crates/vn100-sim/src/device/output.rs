//! The output of the sensor, by itself and in replies, and the end of every sentence.

use std::mem;

use vn100_protocol::{Check, DeviceError};

use super::{BootPhase, Device, PORT, TICK_HZ, binary::PacketContents, registers::Registers};
use crate::{
    message::{MESSAGES, Message},
    sensor::Deltas,
};

#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SyncOut {
    /// The value at the last setting, and the tick of that setting.
    pub(super) count: u32,
    pub(super) since_tick: u64,
}

impl SyncOut {
    /// The value after a number of ticks: one edge per tick if register 32 selects the sensors, one
    /// in two ticks if it selects the attitude, and fewer by the skip factor.
    pub(super) fn count_at(&self, ticks: u64, registers: &Registers) -> u32 {
        let ticks_per_edge = match registers.whole(32, 4) {
            1 | 2 => 1,
            3 => 2,
            _ => return self.count,
        };
        let skipped = u64::from(registers.whole(32, 6)) + 1;
        let edges = (ticks - self.since_tick) / (ticks_per_edge * skipped);
        // the counter wraps
        self.count.wrapping_add(edges as u32)
    }
}

impl Device {
    pub(super) fn run_until(&mut self, until_ns: u64) {
        let BootPhase::Running { since_ns } = self.phase else { return };
        // nothing is sent after the answer to a restart
        while self.run.restart_ns.is_none() && self.tick_ns(since_ns, self.run.ticks) <= until_ns {
            let tick = self.run.ticks;
            self.run.ticks += 1;
            self.sensor.advance(self.processing.windows);
            if !self.run.paused {
                self.send_due(tick, self.tick_ns(since_ns, tick));
            }
        }
    }

    /// The time of a tick. A fast clock is early.
    pub(super) fn tick_ns(&self, since_ns: u64, tick: u64) -> u64 {
        let exact_ns = tick * 1_000_000_000 / TICK_HZ;
        let early_ns = exact_ns as f64 * self.config.clock_error_ppm * 1e-6;
        (since_ns + exact_ns).saturating_add_signed(-(early_ns as i64))
    }

    pub(super) fn next_output_tick(&self) -> Option<u64> {
        if self.run.paused {
            return None;
        }
        let packets = self.registers.binary.iter().filter_map(|output| output.divisor_on(PORT));
        let ticks_apart = packets.chain(self.message().map(|(_, ticks_apart)| ticks_apart));
        ticks_apart.map(|apart| self.run.ticks.next_multiple_of(apart)).min()
    }

    /// The sentence that is sent by itself, and its interval in ticks.
    fn message(&self) -> Option<(&'static Message, u64)> {
        let port = self.registers.ports[PORT];
        let message = MESSAGES.iter().find(|message| message.code == port.message)?;
        Some((message, TICK_HZ.checked_div(u64::from(port.rate_hz))?))
    }

    /// Sends packets before the line of the same tick.
    fn send_due(&mut self, tick: u64, at_ns: u64) {
        for index in 0..3 {
            let apart = self.registers.binary[index].divisor_on(PORT);
            if apart.is_some_and(|apart| tick.is_multiple_of(apart)) {
                let packet = self.packet(index);
                self.send(at_ns, packet);
            }
        }
        let Some((message, ticks_apart)) = self.message() else { return };
        if tick.is_multiple_of(ticks_apart) {
            let mut body = message.header.to_owned();
            self.print_values(message, &mut body);
            self.print_suffix(&mut body);
            let line = self.closed(&body);
            self.send(at_ns, line);
        }
    }

    pub(super) fn print_values(&mut self, message: &Message, body: &mut String) {
        let deltas = if message.has_deltas() { self.take_deltas() } else { Deltas::default() };
        message.print(&self.sensor.measure(&self.processing), &deltas, body);
    }

    pub(super) fn packet(&mut self, index: usize) -> Vec<u8> {
        let deltas = if self.registers.binary[index].has_deltas() { self.take_deltas() } else { Deltas::default() };
        let time_ns = self.device_ns();
        self.registers.binary[index].packet(&PacketContents {
            measured: &self.sensor.measure(&self.processing),
            deltas: &deltas,
            time_ns,
            sync_out_count: self.sync_out_count(),
        })
    }

    /// The time of this tick by the sensor's own clock, which runs from the start of the boot;
    /// equal for all packets of the tick.
    fn device_ns(&mut self) -> u64 {
        let tick = self.run.ticks.saturating_sub(1);
        match self.run.device_time {
            Some((at_tick, time_ns)) if at_tick == tick => time_ns,
            _ => {
                let time_ns = self.clock.read(super::ns(super::BOOT) + tick * 1_000_000_000 / TICK_HZ);
                self.run.device_time = Some((tick, time_ns));
                time_ns
            }
        }
    }

    /// Integrals since the last output with integrals; equal for all output of one tick.
    fn take_deltas(&mut self) -> Deltas {
        if self.run.deltas_tick != Some(self.run.ticks) {
            self.run.deltas_tick = Some(self.run.ticks);
            self.deltas = mem::take(&mut self.sensor.deltas);
        }
        self.deltas
    }

    pub(super) fn sync_out_count(&self) -> u32 {
        self.run.sync_out.count_at(self.run.ticks, &self.registers)
    }

    /// Count and status after the values, as selected in register 30.
    fn print_suffix(&self, body: &mut String) {
        match self.registers.whole(30, 0) {
            0 => {}
            3 => body.push_str(&format!(",T{}", self.sync_out_count())),
            // nothing is connected to SyncIn, and there is no satellite receiver
            _ => body.push_str(",T0"),
        }
        if self.registers.whole(30, 1) > 0 {
            body.push_str(",S0000");
        }
    }

    fn closed(&self, body: &str) -> Vec<u8> {
        let check = if self.registers.whole(30, 4) == 3 { Check::Crc16 } else { Check::Xor8 };
        check.sentence(body).into_bytes()
    }

    /// Queues a whole message, or drops it and reports the loss.
    pub(super) fn send(&mut self, at_ns: u64, message: Vec<u8>) {
        if !self.uart.send(at_ns, message) && self.registers.whole(30, 6) > 0 {
            let error = self.closed(&error_body(DeviceError::OutputBufferOverflow));
            // if the report does not fit either, it is dropped silently
            _ = self.uart.send(at_ns, error);
        }
    }

    pub(super) fn answer(&mut self, body: &str) {
        let line = self.closed(body);
        self.send(self.now_ns, line);
    }

    /// Reports an error, according to ErrorMode: not at all, by a sentence, or by a sentence that
    /// also stops the lines.
    pub(super) fn report(&mut self, code: DeviceError) {
        let mode = self.registers.whole(30, 6);
        if mode > 0 {
            self.answer(&error_body(code));
        }
        if mode == 2 {
            self.registers.ports[PORT].message = 0;
        }
    }
}

fn error_body(code: DeviceError) -> String {
    format!("VNERR,{:02X}", code.code())
}
