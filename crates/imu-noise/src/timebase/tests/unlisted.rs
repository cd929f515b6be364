//! The rate of a sensor of which none are listed.

use super::*;

struct Random(u64);

impl Random {
    /// From 0 to 1.
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Of mean 0 and standard deviation 1, nearly normal.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    fn jittered(&mut self, stamps_s: &[f64], deviation_s: f64) -> Vec<f64> {
        stamps_s.iter().map(|stamp_s| stamp_s + deviation_s * self.normal()).collect()
    }
}

fn rate_of(stamps_s: &[f64]) -> (f64, TimebaseSummary) {
    let (sequence, summary) = polled(GapDetector::new(&[], None), stamps_s, &[1]);
    let GapEvent::Rate(NominalRate::Measured(hz)) = sequence[0] else { panic!("{sequence:?}") };
    (hz, summary)
}

/// All but every `nth`.
fn thinned(stamps_s: &[f64], nth: usize) -> Vec<f64> {
    stamps_s.iter().enumerate().filter(|(index, _)| index % nth != nth - 1).map(|(_, &stamp_s)| stamp_s).collect()
}

#[test]
fn samples_missing_evenly_are_gaps() {
    for rate_hz in [7.3, 25.0, 40.0, 101.7, 400.0] {
        for nth in 3..=5 {
            let kept = thinned(&steady(rate_hz, 3000), nth);
            let (hz, summary) = rate_of(&kept);
            assert!((hz / rate_hz - 1.0).abs() < 1e-4, "{hz} of {rate_hz} Hz, every {nth}th missing");
            let sent = summary.samples + summary.missing;
            assert!(sent.abs_diff(3000) <= 2, "{sent} of 3000 at {rate_hz} Hz, every {nth}th missing");
        }
        // without every second one there is no other step
        let (hz, summary) = rate_of(&thinned(&steady(rate_hz, 3000), 2));
        assert!((hz / rate_hz - 0.5).abs() < 1e-4 && summary.missing == 0);
    }
}

#[test]
fn the_step_is_found_whatever_is_missing_and_late() {
    for (seed, percent) in [5, 10, 20, 30, 40].into_iter().enumerate() {
        for deviation in [0.0, 0.05, 0.1, 0.2] {
            let mut random = Random(seed as u64);
            let kept: Vec<f64> =
                steady(40.0, 4000).into_iter().filter(|_| random.uniform() >= f64::from(percent) / 100.0).collect();
            let (hz, _) = rate_of(&random.jittered(&kept, deviation / 40.0));
            assert!((hz / 40.0 - 1.0).abs() < 2e-3, "{hz} Hz, {percent} % missing, {deviation} periods");
        }
    }
    for nth in 3..=5 {
        for deviation in [0.05, 0.1, 0.2] {
            let kept = thinned(&steady(40.0, 4000), nth);
            let (hz, _) = rate_of(&Random(nth as u64).jittered(&kept, deviation / 40.0));
            assert!((hz / 40.0 - 1.0).abs() < 2e-3, "{hz} Hz, every {nth}th missing, {deviation} periods");
        }
    }
}

#[test]
fn late_samples_and_batches_are_no_missing_ones() {
    for rate_hz in [20.0, 40.0, 50.0, 100.0, 200.0, 333.0] {
        let sent = steady(rate_hz, 4000);
        let reads_s = [0.001, 0.002, 0.004, 0.008, 0.016, 0.05];
        let arrivals = reads_s.map(|read_s| (format!("read each {read_s} s"), bunched(&sent, read_s)));
        let jittered = [0.0, 0.05, 0.1, 0.2]
            .map(|deviation| (format!("late by {deviation} periods"), Random(5).jittered(&sent, deviation / rate_hz)));
        let mut random = Random(6);
        let delayed: Vec<f64> = sent.iter().map(|sent_s| sent_s + 0.8 / rate_hz * random.uniform()).collect();
        let delayed = [("late by up to 0.8 periods".into(), delayed)];
        for (what, stamps_s) in arrivals.into_iter().chain(jittered).chain(delayed) {
            let (hz, summary) = rate_of(&stamps_s);
            assert!((hz / rate_hz - 1.0).abs() < 0.01, "{hz} of {rate_hz} Hz, {what}");
            assert_eq!(summary.missing, 0, "{rate_hz} Hz, {what}");
        }
    }
}
