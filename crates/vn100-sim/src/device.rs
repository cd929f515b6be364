//! The sensor as seen from its serial line: it receives commands and the time, and returns output.
//!
//! ```
//! use std::time::Duration;
//! use vn100_sim::device::{Device, DeviceConfig};
//!
//! let mut device = Device::new(DeviceConfig::default());
//! let mut now = Duration::from_secs(2);
//! device.poll_output(now);
//! device.receive(b"$VNASY,0*4F\r\n$VNRRG,04*77\r\n", now);
//! now += Duration::from_millis(20);
//! let output = device.poll_output(now);
//! assert!(output.ends_with(b"$VNASY,0*4F\r\n$VNRRG,04,3.1.0.0*77\r\n"));
//! ```
//!
//! Nothing here waits or has a clock: every call passes the time since power-up, and executes
//! everything that is due by then. Equal configuration and equal calls at equal times give equal
//! bytes.
//!
//! # Choices that the maker leaves open
//!
//! - Check digits of a command may be of either kind; all output has the kind that register 30
//!   requests.
//! - A command is answered at once; an answer follows the bytes that are being sent. `VNWNV` is
//!   answered when the flash is written.
//! - A write is answered with the settings as a read would print them.
//! - Without a signal on SyncIn, its count and its time stay 0.
//! - The load of the line is checked on writes of registers 5, 6, 7 and 75 to 77.
//! - `VNIMU` prints pressure ten wide.

pub(crate) mod binary;
mod command;
mod execute;
mod output;
mod register_table;
mod registers;
mod uart;

use std::{collections::VecDeque, time::Duration};

use command::{CommandBuffer, RECEIVE_BUFFER};
use output::SyncOut;
use registers::Registers;
use uart::Uart;
use vn100_protocol::DeviceError;
pub use {register_table::Firmware, uart::SentByte};

use crate::{
    profile::Profile,
    sensor::{Deltas, Processing, SensorModel},
    sensor_clock::SensorClock,
};

/// The time from power-up, or from the answer to a restart, to the first output.
pub const BOOT: Duration = Duration::from_millis(1250);

const FLASH_WRITE: Duration = Duration::from_millis(500);

const TICK_HZ: u64 = 800;

/// The configuration of an emulated sensor.
#[derive(Debug, Clone)]
pub struct DeviceConfig {
    /// The truth of its channels, and the settings with which it is delivered: rate and averaging
    /// window. A density of the output ([`AveragingWindow::None`](crate::AveragingWindow::None)) is
    /// that at the rate of the profile after the factory default of the window.
    pub profile: Profile,
    /// Seed of all noise.
    pub seed: u64,
    /// Serial number (register 3).
    pub serial: u32,
    /// Firmware version (register 4), with the differences that come with it.
    pub firmware: Firmware,
    /// Error of the clock of the sensor in ppm; with a positive error the clock runs fast, and
    /// sentences come early.
    pub clock_error_ppm: f64,
}

impl Default for DeviceConfig {
    /// The sensor of the data sheet with firmware 3.1, seed 1, serial number 0100000001 and an
    /// exact clock.
    fn default() -> Self {
        Self {
            profile: Profile::datasheet(),
            seed: 1,
            serial: 100_000_001,
            firmware: Firmware::default(),
            clock_error_ppm: 0.0,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum BootPhase {
    /// Neither sends nor receives.
    Booting { until_ns: u64 },
    /// Ticks are counted.
    Running { since_ns: u64 },
}

/// An emulated VN-100 on its first serial port.
#[derive(Debug, Clone)]
pub struct Device {
    config: DeviceConfig,
    now_ns: u64,
    phase: BootPhase,
    run: Run,
    registers: Registers,
    flash: Registers,
    sensor: SensorModel,
    clock: SensorClock,
    processing: Processing,
    deltas: Deltas,
    uart: Uart,
}

/// The state that ends with a restart.
#[derive(Debug, Clone, Default)]
struct Run {
    ticks: u64,
    deltas_tick: Option<u64>,
    /// The reading of the clock at the last requested tick.
    device_time: Option<(u64, u64)>,
    buffer: CommandBuffer,
    restart_ns: Option<u64>,
    flash_until_ns: Option<u64>,
    /// Commands that wait for the flash.
    waiting: VecDeque<Vec<u8>>,
    paused: bool,
    sync_out: SyncOut,
}

/// The port at which the sensor is connected: the first.
const PORT: usize = 0;

impl Device {
    /// A sensor that is switched on at time zero, with the factory default of all settings.
    pub fn new(config: DeviceConfig) -> Self {
        let mut registers = Registers::delivered(config.firmware, config.serial);
        registers.set_like(&config.profile);
        Self {
            now_ns: 0,
            phase: BootPhase::Booting { until_ns: ns(BOOT) },
            run: Run::default(),
            flash: registers.clone(),
            sensor: SensorModel::new(&config.profile, config.seed),
            clock: SensorClock::new(config.seed),
            processing: registers.processing(),
            deltas: Deltas::default(),
            uart: Uart::new(registers.ports[PORT].baud),
            registers,
            config,
        }
    }

    /// The baud rate at which the sensor receives; pending bytes may have another rate: see
    /// [`SentByte::baud`].
    pub fn baud(&self) -> u32 {
        self.uart.baud
    }

    /// Takes bytes that reach the sensor at `now`, split in any way. A time before that of an
    /// earlier call counts as the time of that call.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        self.advance(ns(now));
        for byte in bytes {
            // it receives nothing during a restart
            if self.run.restart_ns.is_some() || matches!(self.phase, BootPhase::Booting { .. }) {
                return;
            }
            match self.run.buffer.push(*byte) {
                Some(Ok(line)) if self.run.flash_until_ns.is_some() => self.queue(line),
                Some(Ok(line)) => self.execute_line(&line),
                Some(Err(code)) => self.report(code),
                None => {}
            }
        }
    }

    /// The bytes that were on the line by `now` and are not yet taken.
    pub fn poll_output(&mut self, now: Duration) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.poll_bytes(now, |sent| bytes.push(sent.byte));
        bytes
    }

    /// Like [`poll_output`](Self::poll_output), but each byte with the time at which it was on the
    /// line, and its baud rate.
    pub fn poll_bytes(&mut self, now: Duration, mut sink: impl FnMut(SentByte)) {
        self.advance(ns(now));
        self.uart.take(self.now_ns, &mut sink);
    }

    /// When to poll again: at most a second after the last call, so that a silent sensor need not
    /// compute all its ticks at once.
    pub fn next_wakeup(&self) -> Duration {
        let tick_ns = match self.phase {
            BootPhase::Running { since_ns } if self.run.restart_ns.is_none() => {
                let idle_tick = self.run.ticks + TICK_HZ;
                let tick = self.next_output_tick().map_or(idle_tick, |tick| tick.min(idle_tick));
                Some(self.tick_ns(since_ns, tick))
            }
            _ => None,
        };
        let times = [self.uart.next_piece_ns(), tick_ns, self.next_event_ns()];
        // one of the three always exists
        Duration::from_nanos(times.into_iter().flatten().min().unwrap_or(self.now_ns))
    }

    /// Makes the firmware of the sensor fail: the sensor reports a hard fault (`$VNERR,01`) and
    /// restarts with the settings in its flash.
    pub fn crash(&mut self, now: Duration) {
        self.advance(ns(now));
        if matches!(self.phase, BootPhase::Running { .. }) && self.run.restart_ns.is_none() {
            self.report(DeviceError::HardFault);
            self.restart();
        }
    }

    /// Interrupts the power for an instant: bytes that were not sent are lost, and the sensor
    /// restarts with the settings in its flash.
    pub fn power_cycle(&mut self, now: Duration) {
        self.advance(ns(now));
        self.uart = Uart::new(self.flash.ports[PORT].baud);
        self.start(self.now_ns);
    }

    /// Makes the line run at another rate, as if another program had requested it; any rate but
    /// zero.
    pub(crate) fn force_baud(&mut self, baud: std::num::NonZeroU32, now: Duration) {
        self.advance(ns(now));
        self.registers.ports[PORT].baud = baud.get();
        self.uart.baud = baud.get();
    }

    fn advance(&mut self, now_ns: u64) {
        let now_ns = self.now_ns.max(now_ns);
        while let Some(event_ns) = self.next_event_ns().filter(|event_ns| *event_ns <= now_ns) {
            self.run_until(event_ns);
            self.now_ns = self.now_ns.max(event_ns);
            if self.run.restart_ns == Some(event_ns) {
                self.start(event_ns);
            } else if self.run.flash_until_ns == Some(event_ns) {
                self.end_flash_write();
            } else {
                self.phase = BootPhase::Running { since_ns: event_ns };
            }
        }
        self.run_until(now_ns);
        self.now_ns = now_ns;
    }

    /// The end of a boot, of writing the flash, or of the answer to a restart.
    fn next_event_ns(&self) -> Option<u64> {
        let boot_ns = match self.phase {
            BootPhase::Booting { until_ns } => Some(until_ns),
            BootPhase::Running { .. } => None,
        };
        [self.run.restart_ns, self.run.flash_until_ns, boot_ns].into_iter().flatten().min()
    }

    /// Restarts as soon as the pending bytes have been sent.
    fn restart(&mut self) {
        self.run.restart_ns = Some(self.uart.idle_ns().max(self.now_ns));
    }

    /// Starts from flash: the first output follows after the boot.
    fn start(&mut self, now_ns: u64) {
        self.registers = self.flash.clone();
        self.processing = self.registers.processing();
        self.uart.baud = self.registers.ports[PORT].baud;
        self.phase = BootPhase::Booting { until_ns: now_ns + ns(BOOT) };
        self.run = Run::default();
    }

    fn end_flash_write(&mut self) {
        self.run.flash_until_ns = None;
        self.flash = self.registers.clone();
        self.answer("VNWNV");
        // commands received meanwhile
        while self.run.flash_until_ns.is_none() && self.run.restart_ns.is_none() {
            let Some(line) = self.run.waiting.pop_front() else { break };
            self.execute_line(&line);
        }
    }

    /// A command waits its turn while the flash is written, in the receive buffer.
    fn queue(&mut self, line: Vec<u8>) {
        let waiting: usize = self.run.waiting.iter().map(Vec::len).sum();
        if waiting + line.len() > RECEIVE_BUFFER {
            self.report(DeviceError::ReceiveBufferOverflow);
        } else {
            self.run.waiting.push_back(line);
        }
    }
}

pub(crate) fn ns(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}
