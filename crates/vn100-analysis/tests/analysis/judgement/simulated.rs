//! A sensor that lies still, simulated, and what is read of its record.

use std::sync::Arc;

use vn100_analysis::{Analysis, Assessment, Finding, Settings, Snapshot, Warning, WarningKind};
use vn100_protocol::stream::{Batch, StreamCounts};
use vn100_protocol::{Channel, Layout, Quantity, Register, RegisterContents, RegisterFields, VNIMU};

use crate::noise_shapes::Lcg;

/// Windows of four refreshes, averaged in both outputs.
pub(crate) const WINDOWS_OF_4: (u8, &str) = (85, "0,4,4,4,0,0,3,3,3,0");

/// Mean and standard deviation, in counts, of a sensor that lies still.
pub(crate) fn still(channel: &Channel) -> (f64, f64) {
    match channel.quantity {
        Quantity::AngularRate => (0.0, 300.0),
        Quantity::Acceleration => (if channel.name.ends_with('z') { -9806.0 } else { 0.0 }, 20.0),
        Quantity::MagneticField => (if channel.name.ends_with('x') { 5000.0 } else { 0.0 }, 30.0),
        _ => (21_000.0, 5.0),
    }
}

/// Ten minutes of white noise at 40 Hz, unless the settings say otherwise.
pub(crate) struct Simulated {
    pub(crate) layout: Layout,
    pub(crate) settings: Settings,
    pub(crate) samples: u64,
    pub(crate) seed: u64,
    pub(crate) registers: Vec<(u8, &'static str)>,
    pub(crate) level: fn(&Channel) -> (f64, f64),
    /// What is added to the noise, in counts, by the number of the sample.
    pub(crate) added: fn(&Channel, u64) -> f64,
    pub(crate) link: StreamCounts,
}

impl Default for Simulated {
    fn default() -> Self {
        let settings = Settings { rate_hz: Some(40.0), ..Settings::default() };
        let registers = vec![WINDOWS_OF_4];
        Self {
            layout: VNIMU.clone(),
            settings,
            samples: 24_000,
            seed: 1,
            registers,
            level: still,
            added: |_, _| 0.0,
            link: StreamCounts::default(),
        }
    }
}

impl Simulated {
    pub(crate) fn record(self) -> (Snapshot, Assessment) {
        let mut random = Lcg(self.seed);
        let levels: Vec<_> = self.layout.channels.iter().map(self.level).collect();
        let mut counts = Vec::new();
        for sample in 0..self.samples {
            for (channel, (mean, std)) in self.layout.channels.iter().zip(&levels) {
                counts.push((mean + std * random.normal() + (self.added)(channel, sample)).round() as i32);
            }
        }
        let reply = |&(register, fields): &(u8, &str)| RegisterContents {
            register: Register(register),
            fields: RegisterFields::new(fields).unwrap(),
        };
        let registers = self.registers.iter().map(reply).collect();
        let layout = Some(Arc::new(self.layout));
        let mut batch = Batch { layout, counts, registers, link: self.link, ..Batch::default() };
        batch.link.tally.samples = self.samples;
        let mut analysis = Analysis::new(self.settings);
        analysis.absorb(&batch);
        let snapshot = analysis.snapshot();
        let assessment = Assessment::new(&snapshot, 0.95);
        (snapshot, assessment)
    }
}

pub(crate) const LOUDER: fn(&Channel) -> (f64, f64) = |channel| {
    let (mean, std) = still(channel);
    (mean, if channel.quantity == Quantity::AngularRate { 1.5 * std } else { std })
};

pub(crate) fn named(warnings: &[Warning], kind: WarningKind) -> Vec<&str> {
    warnings.iter().filter(|warning| warning.kind == kind).flat_map(|w| &w.channels).map(String::as_str).collect()
}

pub(crate) fn findings(warnings: &[Warning], kind: WarningKind) -> Vec<Finding> {
    warnings.iter().filter(|warning| warning.kind == kind).map(|warning| warning.finding.clone()).collect()
}
