//! Records of a sensor at rest, by numbers that are the same everywhere.

use std::{f64::consts::TAU, sync::Arc};

use crate::{Asked, Evaluation, Measured};
use vn100_analysis::{
    Analysis, Assessment, Settings, SourceFacts,
    protocol::{Layout, VNIMU, VNYMR, stream::Batch},
};

/// Near normal: the sum of four uniform numbers.
fn noise(state: &mut u64) -> f64 {
    let uniform = |_| {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..4).map(uniform).sum::<f64>() * 0.75_f64.sqrt()
}

/// Of a message whose channels have these means and standard deviations, in counts. `more`: what is
/// added to each channel at a sample.
fn measured(
    (layout, rate_hz): (&Layout, f64),
    samples: u32,
    channels: &[(f64, f64)],
    more: impl Fn(usize, f64) -> f64,
) -> Measured {
    let mut state = 1;
    let mut counts = Vec::new();
    for sample in 0..samples {
        for (place, (mean, std)) in channels.iter().enumerate() {
            counts.push((mean + std * noise(&mut state) + more(place, f64::from(sample))).round() as i32);
        }
    }
    let mut analysis = Analysis::new(Settings { rate_hz: Some(rate_hz), ..Settings::default() });
    let mut batch = Batch { layout: Some(Arc::new(layout.clone())), counts, ..Batch::default() };
    batch.link.tally.samples = u64::from(samples);
    analysis.absorb(&batch);
    let snapshot = Arc::new(analysis.snapshot());
    let assessment = Assessment::new(&snapshot, 0.95);
    let facts = SourceFacts { name: "rest.csv".into(), ..SourceFacts::default() };
    Evaluation::new(None, Asked::default()).unwrap().complete(Measured::ended(facts, snapshot, assessment, &[]))
}

/// Magnetic field, acceleration and rate of a sensor that stands upright.
const AXES: [(f64, f64); 9] = [
    (2100.0, 5.0),
    (-300.0, 5.0),
    (4100.0, 5.0),
    (120.0, 4.0),
    (-80.0, 4.0),
    (-9800.0, 4.0),
    (900.0, 200.0),
    (-500.0, 200.0),
    (300.0, 200.0),
];

/// In a room whose temperature rises and falls by 3 °C twice, and with it the bias of the x axis of
/// the gyroscope.
pub(crate) fn in_a_warming_room(samples: u32) -> Measured {
    let channels = [&AXES[..], &[(251.0, 1.0), (101_325.0, 8.0)]].concat();
    let sway = |sample: f64| (2.0 * TAU * sample / f64::from(samples)).sin();
    measured((&VNIMU, 40.0), samples, &channels, |place, sample| match place {
        6 => 150.0 * sway(sample),
        9 => 30.0 * sway(sample),
        _ => 0.0,
    })
}

/// With the attitude, at this rate.
pub(crate) fn with_attitude(samples: u32, rate_hz: f64) -> Measured {
    let channels = [&[(-85_000.0, 90.0), (500.0, 20.0), (-300.0, 30.0)], &AXES[..]].concat();
    measured((&VNYMR, rate_hz), samples, &channels, |_, _| 0.0)
}
