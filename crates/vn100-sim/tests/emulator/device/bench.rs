//! A sensor for tests: text in, lines out.

use std::time::Duration;

use vn100_sim::{Device, DeviceConfig};

/// The time from power-up to the first tick.
pub(crate) const BOOT_MS: u64 = 1250;

pub(crate) struct Bench {
    pub(crate) device: Device,
    pub(crate) now: Duration,
}

impl Bench {
    pub(crate) fn switched_on(config: DeviceConfig) -> Self {
        Self { device: Device::new(config), now: Duration::ZERO }
    }

    /// A sensor with factory defaults, booted, with its output paused and nothing pending.
    pub(crate) fn quiet() -> Self {
        Self::quiet_with(DeviceConfig::default())
    }

    pub(crate) fn quiet_with(config: DeviceConfig) -> Self {
        let mut bench = Self::switched_on(config);
        bench.wait_ms(BOOT_MS + 50);
        assert!(bench.ask("VNASY,0").contains("$VNASY,0*4F\r\n"));
        bench
    }

    /// All output during a time, as text.
    pub(crate) fn wait_ms(&mut self, milliseconds: u64) -> String {
        String::from_utf8(self.wait(Duration::from_millis(milliseconds))).unwrap()
    }

    pub(crate) fn wait(&mut self, time: Duration) -> Vec<u8> {
        self.now += time;
        self.device.poll_output(self.now)
    }

    pub(crate) fn send(&mut self, text: &str) {
        self.device.receive(text.as_bytes(), self.now);
    }

    /// All output in the 300 ms after a command, which suffice even for the slowest line.
    pub(crate) fn ask(&mut self, body: &str) -> String {
        self.send(&format!("${body}*XX\r\n"));
        self.wait_ms(300)
    }

    /// A write that must be accepted.
    pub(crate) fn set(&mut self, settings: &str) {
        let answer = self.ask(&format!("VNWRG,{settings}"));
        assert!(answer.contains(&format!("$VNWRG,{settings}*")), "{settings}: {answer}");
    }

    /// The code of the error that must answer a command.
    pub(crate) fn error(&mut self, body: &str) -> String {
        let answer = self.ask(body);
        let code = answer.strip_prefix("$VNERR,").unwrap_or_else(|| panic!("{body}: {answer}"));
        code[..2].to_owned()
    }
}
