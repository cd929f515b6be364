//! A record of a sensor at rest, by numbers that are the same everywhere.

use std::{f64::consts::TAU, sync::Arc};

use vn100_analysis::{
    Analysis, Assessment, Settings, SourceFacts,
    protocol::{
        VNIMU,
        stream::{Arrival, Batch},
    },
};

use crate::{Asked, Evaluation, Measured};

const RATE_HZ: u64 = 40;

/// Mean and standard deviation of each channel of the message, in its counts: the magnetic field,
/// the acceleration, whose noise is beyond the data sheet, the rate, temperature and pressure.
const CHANNELS: [(f64, f64); 11] = [
    (2100.0, 5.0),
    (-300.0, 5.0),
    (4100.0, 5.0),
    (120.0, 40.0),
    (-80.0, 40.0),
    (-9800.0, 40.0),
    (900.0, 200.0),
    (-500.0, 200.0),
    (300.0, 200.0),
    (251.0, 1.0),
    (101_325.0, 8.0),
];

/// Near normal: the sum of four uniform numbers.
fn noise(state: &mut u64) -> f64 {
    let uniform = |_| {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..4).map(uniform).sum::<f64>() * 0.75_f64.sqrt()
}

/// So many samples. The z axis of the gyroscope drifts, and that of the accelerometer vibrates with
/// each of these frequencies in hertz and amplitudes in counts.
pub(crate) fn at_rest(samples: u64, vibrations: &[(f64, f64)]) -> Measured {
    let (mut state, mut drift) = (1, 0.0);
    let mut counts = Vec::new();
    for sample in 0..samples {
        drift += 5.0 * noise(&mut state);
        let swing = |(hz, counts): &(f64, f64)| counts * (TAU * hz * sample as f64 / RATE_HZ as f64).sin();
        for (place, (mean, std)) in CHANNELS.into_iter().enumerate() {
            let more = match place {
                5 => vibrations.iter().map(swing).sum(),
                8 => drift,
                _ => 0.0,
            };
            counts.push((mean + std * noise(&mut state) + more).round() as i32);
        }
    }
    let at_ns = |sample| sample as i64 * 25_000_000;
    let arrivals = (0..samples as usize).map(|from_row| Arrival { from_row, at_ns: at_ns(from_row) }).collect();
    let mut analysis = Analysis::new(Settings { rate_hz: Some(RATE_HZ as f64), ..Settings::default() });
    let mut batch = Batch { layout: Some(Arc::new(VNIMU.clone())), counts, arrivals, ..Batch::default() };
    batch.link.tally.samples = samples;
    analysis.absorb(&batch);
    let snapshot = Arc::new(analysis.snapshot());
    let assessment = Assessment::new(&snapshot, 0.95);
    let facts = SourceFacts { name: "rest.csv".into(), ..SourceFacts::default() };
    let evaluation = Evaluation::new(None, Asked::default()).unwrap();
    evaluation.complete(Measured::ended(facts, snapshot, assessment, &[]))
}
