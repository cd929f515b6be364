//! A record as a stream brings it, and what is said of it.

use std::{
    f64::consts::TAU,
    sync::{Arc, LazyLock},
    time::Instant,
};

use rustix::time::{ClockId, clock_gettime};
use vn100_analysis::{Analysis, Assessment, Settings, Snapshot};
use vn100_protocol::{
    Channel, Layout, Quantity, Register, RegisterContents, RegisterFields, VNIMU,
    stream::{Batch, RowCounter},
};

use super::{
    families::Cell,
    generators::{Flicker, Part},
    random::Random,
};

/// The channels that are scored.
pub(crate) const SCORED: usize = 6;

/// Digits behind the point of these: noise of any kind stays far below what a moved sensor reads.
const DECIMALS: u8 = 7;

/// `$VNIMU` with more digits.
static LAYOUT: LazyLock<Arc<Layout>> = LazyLock::new(|| {
    let mut layout = VNIMU.clone();
    for channel in layout.channels.to_mut().iter_mut().filter(|channel| is_scored(channel)) {
        channel.decimals = DECIMALS;
        channel.limit_counts = i32::MAX;
    }
    Arc::new(layout)
});

fn is_scored(channel: &Channel) -> bool {
    matches!(channel.quantity, Quantity::Acceleration | Quantity::AngularRate)
}

/// Counts in the unit of a scored channel.
pub(crate) fn counts_per_unit() -> f64 {
    10_f64.powi(DECIMALS.into())
}

/// The scored channels by their places in the layout, with their names.
pub(crate) fn scored() -> impl Iterator<Item = (usize, &'static str)> {
    let channels = LAYOUT.channels.iter().enumerate().filter(|(_, channel)| is_scored(channel));
    channels.map(|(place, channel)| (place, &*channel.name))
}

/// The values of a record.
pub(crate) struct Record {
    /// In standard deviations of the white part.
    pub(crate) series: [Vec<f64>; SCORED],
    /// In periods of the first slow cycle; the temperature follows it by 1 K.
    cycle_s: Option<f64>,
    cycle_phase: f64,
    /// Readings of the temperature, where it does not follow a cycle.
    pub(crate) temperature_c: Option<Vec<f64>>,
    kept: Option<Vec<bool>>,
}

/// What an assessment took.
#[derive(Clone, Copy)]
pub(crate) struct Took {
    /// CPU time, that of whatever else the program did meanwhile included.
    pub(crate) cpu_s: f64,
    /// By the clock.
    pub(crate) wall_s: f64,
}

pub(crate) struct Assessed {
    pub(crate) snapshot: Snapshot,
    pub(crate) assessment: Assessment,
    pub(crate) took: Took,
}

impl Record {
    pub(crate) fn of(cell: &Cell, flicker: &Flicker, random: &mut Random) -> Self {
        let samples = cell.samples();
        let cycle_phase = random.uniform();
        let series = std::array::from_fn(|_| {
            let mut series = cell.white.series(samples, random);
            for part in &cell.parts {
                part.add_to(&mut series, cell.rate_hz, flicker, cycle_phase, random);
            }
            series
        });
        let cycle_s = cell.parts.iter().find_map(|part| match part {
            Part::Cycle { period_s, .. } => Some(*period_s),
            _ => None,
        });
        let kept = cell.loss.map(|loss| loss.kept(samples, random));
        Self { series, cycle_s, cycle_phase, temperature_c: None, kept }
    }

    /// Read and assessed as that of a sensor at rest.
    pub(crate) fn assess(&self, cell: &Cell, random: &mut Random) -> Assessed {
        let mut analysis = Analysis::new(Settings { rate_hz: Some(cell.rate_hz), ..Settings::default() });
        analysis.absorb(&self.batch(cell, random));
        analysis.finish();
        let snapshot = analysis.snapshot();
        let (start, start_s) = (Instant::now(), process_cpu_s());
        let assessment = Assessment::new(&snapshot, 0.95);
        let took = Took { cpu_s: process_cpu_s() - start_s, wall_s: start.elapsed().as_secs_f64() };
        Assessed { snapshot, assessment, took }
    }

    fn batch(&self, cell: &Cell, random: &mut Random) -> Batch {
        let gravity = 9.81 * counts_per_unit();
        // where in a step the mean lies is chance
        let means = LAYOUT.channels.iter().map(|channel| match channel.quantity {
            Quantity::Acceleration if channel.name.ends_with('z') => random.uniform() - gravity,
            Quantity::MagneticField if channel.name.ends_with('x') => 5000.0,
            Quantity::Temperature => 250.0,
            Quantity::Pressure => 101_300.0,
            _ => random.uniform(),
        });
        let means: Vec<f64> = means.collect();
        let mut batch = Batch { layout: Some(Arc::clone(&LAYOUT)), ..Batch::default() };
        for sample in 0..self.series[0].len() {
            if let Some(kept) = &self.kept {
                if !kept[sample] {
                    continue;
                }
                let row = batch.row_count();
                batch.counters.push(RowCounter { row, count: sample as u64 });
            }
            let mut series = self.series.iter();
            for (channel, mean) in LAYOUT.channels.iter().zip(&means) {
                let value = match channel.quantity {
                    Quantity::Temperature => match &self.temperature_c {
                        Some(readings_c) => 10.0 * readings_c[sample] - mean,
                        None => self.temperature(sample, cell) + 0.5 * random.normal(),
                    },
                    Quantity::Pressure => 5.0 * random.normal(),
                    Quantity::MagneticField => 30.0 * random.normal(),
                    _ => series.next().unwrap()[sample] / cell.step,
                };
                batch.counts.push((mean + value).round() as i32);
            }
        }
        if let Some(window) = cell.known_window {
            let fields = RegisterFields::new(format!("0,{window},{window},4,0,0,3,3,3,0")).unwrap();
            batch.registers.push(RegisterContents { register: Register::IMU_FILTER, fields });
        }
        batch.link.tally.samples = batch.row_count() as u64;
        batch
    }

    /// In tenths of a degree.
    fn temperature(&self, sample: usize, cell: &Cell) -> f64 {
        let cycle = |period_s: f64| (TAU * (sample as f64 / (cell.rate_hz * period_s) + self.cycle_phase)).sin();
        10.0 * self.cycle_s.map_or(0.0, cycle)
    }
}

fn process_cpu_s() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
