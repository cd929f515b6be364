//! The path between the sensor and its host, on a clock that is passed in: the baud rates of both
//! ends, and faults.

use std::{collections::VecDeque, num::NonZeroU32, time::Duration};

use crate::{
    device::{Device, SentByte},
    fault::{FaultPlan, Injector, PlugEvent, ScheduledEvent},
    receiver::Receiver,
};

/// The highest baud rate of adapters. The compiler evaluates it, and would reject a zero.
const FASTEST_BAUD: NonZeroU32 = NonZeroU32::new(4_000_000).unwrap();

/// An emulated sensor, its cable and its adapter.
#[derive(Debug, Clone)]
pub struct Wire {
    device: Device,
    faults: Injector,
    /// Receives the output of the sensor, at the rate of the host.
    receiver: Receiver,
    host_baud: NonZeroU32,
    host_is_there: bool,
    plugged: bool,
    /// Bytes that a stall delays.
    stalled: VecDeque<(Duration, u8)>,
}

impl Wire {
    /// A wire whose port is not open yet.
    pub fn new(device: Device, plan: &FaultPlan, seed: u64, host_baud: NonZeroU32) -> Self {
        let host_baud = host_baud.min(FASTEST_BAUD);
        Self {
            device,
            faults: Injector::new(plan, seed),
            receiver: Receiver::new(host_baud.get()),
            host_baud,
            host_is_there: false,
            plugged: true,
            stalled: VecDeque::new(),
        }
    }

    /// The sensor at the end of the wire.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// The host opens the port, and receives the output of the sensor from now on. Returns the
    /// bytes that the host reads at once: old ones, if the fault plan says so.
    pub fn open(&mut self, now: Duration) -> Vec<u8> {
        _ = self.poll(now);
        self.host_is_there = true;
        self.faults.open()
    }

    /// The host closes the port.
    pub fn close(&mut self, now: Duration) {
        _ = self.poll(now);
        self.host_is_there = false;
    }

    /// The host reads and writes at this baud rate from now on; 4 Mbaud at most.
    pub fn set_host_baud(&mut self, baud: NonZeroU32) {
        let baud = baud.min(FASTEST_BAUD);
        self.host_baud = baud;
        self.receiver.baud = baud.get();
    }

    /// The host writes. The sensor has the bytes at once, or garbled ones if it listens at another
    /// rate.
    pub fn write(&mut self, bytes: &[u8], now: Duration) {
        if !self.plugged {
            return;
        }
        let mut received = Vec::new();
        let baud = self.host_baud.get();
        let mut listener = Receiver::new(self.device.baud());
        let mut at = Duration::from_secs(1);
        for byte in bytes {
            at += Duration::from_nanos(10_000_000_000 / u64::from(baud));
            listener.push(SentByte { at, byte: *byte, baud });
        }
        listener.poll(at + Duration::from_secs(1), |_, byte| received.push(byte));
        self.device.receive(&received, now);
    }

    /// The bytes that reach the host by `now`; none while it is away.
    pub fn poll(&mut self, now: Duration) -> Vec<u8> {
        self.device.poll_bytes(now, |byte| self.receiver.push(byte));
        let (faults, stalled) = (&mut self.faults, &mut self.stalled);
        self.receiver.poll(now, |at, byte| stalled.extend(faults.pass(at, byte)));
        if !(self.host_is_there && self.plugged) {
            stalled.clear();
        }
        let due = self.stalled.partition_point(|(at, _)| *at <= now);
        self.stalled.drain(..due).map(|(_, byte)| byte).collect()
    }

    /// Applies the faults of the whole link due by `now`; call it until it returns `None`.
    pub fn poll_plug(&mut self, now: Duration) -> Option<PlugEvent> {
        while let Some((at, event)) = self.faults.take_event(now) {
            match event {
                ScheduledEvent::Reboot => self.device.crash(at),
                ScheduledEvent::Baud(baud) => self.device.force_baud(baud, at),
                ScheduledEvent::Plug(event) => {
                    self.plugged = event != PlugEvent::Unplugged;
                    if self.plugged {
                        self.device.power_cycle(at)
                    } else {
                        self.stalled.clear()
                    }
                    return Some(event);
                }
            }
        }
        None
    }

    /// The time of the next poll; rare while no host reads.
    pub fn next_wakeup(&self, now: Duration) -> Duration {
        let idle = now + Duration::from_secs(1);
        let bytes = [Some(self.device.next_wakeup()), self.stalled.front().map(|(at, _)| *at)];
        let bytes = bytes.into_iter().flatten().filter(|_| self.host_is_there && self.plugged);
        bytes.chain(self.faults.next_event()).fold(idle, Duration::min)
    }
}
