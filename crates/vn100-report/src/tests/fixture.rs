//! Records of a sensor at rest, by numbers that are the same everywhere.

use std::{
    f64::consts::TAU,
    sync::{Arc, OnceLock},
};

use vn100_analysis::{
    Analysis, Assessment, End, Goal, Parts, Settings, Snapshot, SourceFacts, SourceResult,
    protocol::{
        Layout, VNIMU, VNYMR,
        stream::{Arrival, Batch},
    },
};

use crate::{Ended, Evaluation, remedies::page_words};

/// Near normal: the sum of four uniform numbers.
fn noise(state: &mut u64) -> f64 {
    let uniform = |_| {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..4).map(uniform).sum::<f64>() * 0.75_f64.sqrt()
}

/// The facts of a source of this name.
pub(crate) fn facts(name: &str) -> SourceFacts {
    SourceFacts { name: name.into(), ..SourceFacts::default() }
}

/// A snapshot of no data.
pub(crate) fn nothing() -> Snapshot {
    Analysis::new(Settings::default()).snapshot()
}

/// The result of a snapshot as if it ended now.
pub(crate) fn result(facts: SourceFacts, snapshot: Snapshot) -> SourceResult {
    let snapshot = Arc::new(snapshot);
    let assessment = Arc::new(Assessment::new(&snapshot, 0.95));
    SourceResult::new(facts, snapshot, assessment, Parts::All)
}

/// The result of a capture that was read to its end.
pub(crate) fn ended(facts: SourceFacts, snapshot: Snapshot, unmet: &[Goal]) -> SourceResult {
    Ended { end: &End::SourceEnded, shortfall: None, unmet, is_live: false, words: page_words }
        .complete(result(facts, snapshot))
}

/// The result of a sensor that has this message at this rate, whose channels have these means and
/// standard deviations in counts. `more`: what is added to each channel at a sample.
pub(crate) fn measured(
    (layout, rate_hz): (&Layout, f64),
    samples: u64,
    channels: &[(f64, f64)],
    mut more: impl FnMut(usize, f64, &mut u64) -> f64,
) -> SourceResult {
    let mut state = 1;
    let mut counts = Vec::new();
    for sample in 0..samples {
        for (place, (mean, std)) in channels.iter().enumerate() {
            let more = more(place, sample as f64, &mut state);
            counts.push((mean + std * noise(&mut state) + more).round() as i32);
        }
    }
    let mut analysis = Analysis::new(Settings { rate_hz: Some(rate_hz), ..Settings::default() });
    let at_ns = |sample| (sample as f64 * 1e9 / rate_hz) as i64;
    let arrivals = (0..samples as usize).map(|from_row| Arrival { from_row, at_ns: at_ns(from_row) }).collect();
    let mut batch = Batch { layout: Some(Arc::new(layout.clone())), counts, arrivals, ..Batch::default() };
    batch.link.tally.samples = samples;
    analysis.absorb(&batch);
    let evaluation = Evaluation::new(None, Vec::new(), false).unwrap();
    evaluation.complete(ended(facts("rest.csv"), analysis.snapshot(), &[]))
}

/// Magnetic field, acceleration with this standard deviation, and rate of a sensor that stands
/// upright.
fn axes(accel_std: f64) -> Vec<(f64, f64)> {
    let mag = [2100.0, -300.0, 4100.0].map(|mean| (mean, 5.0));
    let accel = [120.0, -80.0, -9800.0].map(|mean| (mean, accel_std));
    let gyro = [900.0, -500.0, 300.0].map(|mean| (mean, 200.0));
    [mag, accel, gyro].concat()
}

/// Temperature and pressure.
const SURROUNDINGS: [(f64, f64); 2] = [(251.0, 1.0), (101_325.0, 8.0)];

/// With noise of the accelerometer beyond the data sheet. The z axis of the gyroscope drifts, and
/// that of the accelerometer vibrates with each of these frequencies in hertz and amplitudes in
/// counts.
pub(crate) fn at_rest(samples: u64, vibrations: &[(f64, f64)]) -> SourceResult {
    let mut drift = 0.0;
    measured((&VNIMU, 40.0), samples, &[&axes(40.0)[..], &SURROUNDINGS].concat(), |place, sample, state| {
        if place == 0 {
            drift += 5.0 * noise(state);
        }
        match place {
            5 => vibrations.iter().map(|(hz, counts)| counts * (TAU * hz * sample / 40.0).sin()).sum(),
            8 => drift,
            _ => 0.0,
        }
    })
}

/// Fourteen minutes of it without vibration, measured once for all tests.
pub(crate) fn long_at_rest() -> &'static SourceResult {
    static MEASURED: OnceLock<SourceResult> = OnceLock::new();
    MEASURED.get_or_init(|| at_rest(32_768, &[]))
}

/// In a room whose temperature rises and falls by 3 °C twice, and with it the bias of the x axis of
/// the gyroscope.
pub(crate) fn in_a_warming_room(samples: u64) -> SourceResult {
    let sway = |sample: f64| (2.0 * TAU * sample / samples as f64).sin();
    measured((&VNIMU, 40.0), samples, &[&axes(4.0)[..], &SURROUNDINGS].concat(), |place, sample, _| match place {
        6 => 150.0 * sway(sample),
        9 => 30.0 * sway(sample),
        _ => 0.0,
    })
}

/// With the attitude, at this rate.
pub(crate) fn with_attitude(samples: u64, rate_hz: f64) -> SourceResult {
    let attitude = [(-85_000.0, 90.0), (500.0, 20.0), (-300.0, 30.0)];
    measured((&VNYMR, rate_hz), samples, &[&attitude[..], &axes(4.0)].concat(), |_, _, _| 0.0)
}
