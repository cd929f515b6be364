//! Samples that are dropped from the first one on, with any lateness of the others, at each rate.

use std::time::Duration;

use imu_noise::timebase::{GapDetector, GapEvent, TimebaseSummary};
use proptest::prelude::*;

use crate::link::RATES_HZ;

/// The source of the rate.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Known {
    Told,
    Reported,
    Unknown,
}

#[derive(Clone, Debug)]
struct Lossy {
    rate_hz: f64,
    clock_ppm: f64,
    sent: usize,
    /// In [0, 1) for each sample: whether it is dropped, and its lateness.
    chances: Vec<(f64, f64)>,
    dropped: f64,
    jitter_s: f64,
    is_exponential: bool,
}

impl Lossy {
    /// The arrivals, and the number of missing samples between the first and the last.
    fn arrivals_s(&self) -> (Vec<f64>, i64) {
        let (mut kept, mut places, mut latest_s) = (Vec::new(), Vec::new(), 0.0_f64);
        for place in 0..self.sent {
            let (drop, late) = self.chances[(place * 7919 + place / self.chances.len()) % self.chances.len()];
            let late = if self.is_exponential { -(1.0 - late).ln() } else { late };
            let sent_s = 3.0 + place as f64 / (self.rate_hz * (1.0 + self.clock_ppm * 1e-6));
            // the bytes of a line never overtake those of another
            latest_s = latest_s.max(sent_s + self.jitter_s * late);
            if drop >= self.dropped {
                kept.push(latest_s);
                places.push(place);
            }
        }
        let missing = places.last().zip(places.first()).map_or(0, |(last, first)| last - first + 1 - places.len());
        (kept, missing as i64)
    }
}

fn lossy() -> impl Strategy<Value = Lossy> {
    let chances = prop::collection::vec((0.0..1.0, 0.0..1.0), 1500..3000);
    (
        prop::sample::select(RATES_HZ.to_vec()),
        -100.0..100.0,
        chances,
        prop_oneof![Just(0.0), 0.0..0.8],
        0.0..0.03,
        any::<bool>(),
    )
        .prop_map(|(rate_hz, clock_ppm, chances, dropped, jitter_s, is_exponential)| {
            let sent = chances.len();
            Lossy { rate_hz, clock_ppm, sent, chances, dropped, jitter_s, is_exponential }
        })
}

/// The summary, the missing samples, and the seconds until the first sample was decided.
fn detected(known: Known, rate_hz: f64, arrivals_s: &[f64]) -> (TimebaseSummary, i64, Option<f64>) {
    let mut detector = GapDetector::new(&RATES_HZ, (known == Known::Told).then_some(rate_hz));
    if known == Known::Reported {
        detector.set_reported_rate(rate_hz);
    }
    let (mut missing, mut first_s) = (0, None);
    let mut take = |detector: &mut GapDetector, at_s: f64| {
        while let Some(event) = detector.poll() {
            match event {
                GapEvent::Missing(more) => missing += more as i64,
                GapEvent::Samples(_) => {
                    first_s.get_or_insert(at_s - arrivals_s[0]);
                }
                _ => {}
            }
        }
    };
    for &at_s in arrivals_s {
        detector.push(Duration::from_secs_f64(at_s), None);
        take(&mut detector, at_s);
    }
    detector.finish();
    take(&mut detector, f64::INFINITY);
    (detector.summary().unwrap(), missing, first_s)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn dropped_samples_are_counted_from_the_first_one_on(
        stream in lossy(),
        known in prop::sample::select(vec![Known::Told, Known::Reported, Known::Unknown]),
    ) {
        let (arrivals_s, expected) = stream.arrivals_s();
        prop_assume!(arrivals_s.len() > 60);
        let (summary, missing, first_s) = detected(known, stream.rate_hz, &arrivals_s);
        let what = format!("{missing} of {expected}, {known:?}, {} Hz, {:.2} dropped, {:.4} s {}: {summary:?}",
            stream.rate_hz, stream.dropped, stream.jitter_s, stream.is_exponential);
        if known == Known::Unknown && summary.nominal.is_none_or(|nominal| nominal.hz() != stream.rate_hz) {
            // a refusal is allowed only if samples are more than half a period late
            prop_assert!(stream.jitter_s * stream.rate_hz > 0.2, "{}", what);
            return Ok(());
        }
        let off = (missing - expected).abs() as f64;
        // the first and the last samples may be late by several periods
        let late = 2.0 * stream.jitter_s * stream.rate_hz;
        // the phase of few samples that are late by many periods may slip: once in some ten thousand streams
        let slip = if stream.dropped > 0.6 && late > 6.0 { 0.02 * stream.sent as f64 } else { 0.0 };
        prop_assert!(off <= 3.0 + 0.01 * stream.sent as f64 + late + slip, "{}", what);
        if known != Known::Unknown {
            prop_assert!(first_s.is_some_and(|first_s| first_s <= 2.0), "{}", what);
        }
    }
}

#[test]
fn a_known_rate_decides_the_first_sample_at_once() {
    for rate_hz in RATES_HZ {
        for known in [Known::Told, Known::Reported] {
            let (summary, missing, first_s) = detected(known, rate_hz, &[5.0, 5.0 + 4.0 / rate_hz]);
            assert_eq!((summary.refusal, missing, first_s), (None, 3, Some(0.0)), "{rate_hz} Hz");
        }
    }
}

#[test]
fn faster_arrivals_contradict_a_known_rate_and_slower_ones_if_they_are_even() {
    for (known_hz, stream_hz) in [(20.0, 40.0), (50.0, 200.0), (200.0, 40.0), (40.0, 20.0)] {
        let arrivals_s: Vec<f64> = (0..600).map(|place| 2.0 + f64::from(place) / stream_hz).collect();
        let (summary, ..) = detected(Known::Told, known_hz, &arrivals_s);
        assert!(summary.refusal.is_some(), "{stream_hz} Hz for {known_hz} Hz: {summary:?}");
        let (summary, ..) = detected(Known::Reported, known_hz, &arrivals_s);
        assert_eq!(summary.nominal.map(|nominal| nominal.hz()), Some(stream_hz), "{known_hz} Hz reported");
    }
}
