//! A sensor on the bench: text in, lines out.

use std::time::Duration;

use vn100_sim::{Device, DeviceConfig};

pub(crate) struct Bench {
    pub(crate) device: Device,
    pub(crate) now: Duration,
}

impl Bench {
    /// Switched on, through its boot, output paused, nothing waiting.
    pub(crate) fn quiet(config: DeviceConfig) -> Self {
        let mut bench = Self::switched_on(config);
        bench.wait_ms(1300);
        assert!(bench.ask("VNASY,0").contains(&"$VNASY,0*4F".to_owned()));
        bench
    }

    pub(crate) fn switched_on(config: DeviceConfig) -> Self {
        Self { device: Device::new(config), now: Duration::ZERO }
    }

    /// All output of a time, as text.
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

    /// The answers to one command; output must be paused.
    pub(crate) fn ask(&mut self, body: &str) -> Vec<String> {
        self.send(&format!("${body}*XX\r\n"));
        let output = self.wait_ms(100);
        output.split_terminator("\r\n").map(str::to_owned).collect()
    }
}
