//! Degrees of freedom and kinds of noise at averaging factors.

use std::{
    collections::HashMap,
    sync::{Mutex, PoisonError},
};

use imu_noise::{Interval, Octave, OctaveSum, PowerLaw, RecordShape, edf};

use super::{LEAST_EDF, OctaveAssessment, OctaveVariances};
use crate::snapshot::ChannelSnapshot;

/// Samples of the channel, averaging factor and windows, and the kind of noise.
type OctaveInNoise = (u64, u64, u64, PowerLaw);

/// Degrees of freedom in noise of one kind: most channels of a record ask for the same.
#[derive(Debug)]
pub(super) struct KnownEdf {
    pub(super) confidence: f64,
    known: Mutex<HashMap<OctaveInNoise, Option<f64>>>,
}

impl KnownEdf {
    pub(super) fn new(confidence: f64) -> Self {
        Self { confidence, known: Mutex::default() }
    }

    pub(super) fn of(&self, octave: &Octave, shape: &RecordShape, law: PowerLaw) -> Option<f64> {
        let key = (shape.samples, octave.m, octave.terms, law);
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(edf) = known().get(&key) {
            return *edf;
        }
        // without the lock: another thread may find the same
        let edf = edf(octave, shape, law);
        known().insert(key, edf);
        edf
    }

    /// Of a deviation of 1; `None` below [`LEAST_EDF`] degrees of freedom.
    pub(super) fn interval(&self, edf: f64) -> Option<Interval> {
        Some(edf).filter(|edf| *edf >= LEAST_EDF).and_then(|edf| Interval::new(1.0, edf, self.confidence))
    }

    /// The assessments of the points of `results`, from those of its `octaves`. The kind of noise
    /// is that of the nearest octave. The degrees of freedom are those in noise of this kind alone
    /// at this very averaging factor, times what the mixture of noises has more or less than it at
    /// the octaves around: exact at an octave, with the logarithm of that ratio linear between two.
    pub(super) fn points(
        &self,
        results: &ChannelSnapshot,
        curve: &OctaveVariances,
        octaves: &[OctaveAssessment],
    ) -> Vec<OctaveAssessment> {
        let point = |sum: &OctaveSum| {
            let place = (sum.m as f64).log2().min(octaves.len().checked_sub(1)? as f64);
            let nearest = place.round() as usize;
            let law = octaves[..=nearest].iter().rev().find_map(|octave| octave.alpha).map(PowerLaw::nearest);
            let ratio = |index: usize| {
                let mixture = octaves.get(index)?.relative?.edf;
                Some((mixture / self.of(curve.octaves.get(index)?, &curve.shape, law?)?).ln())
            };
            let (below, above) = (ratio(place.floor() as usize), ratio(place.ceil() as usize));
            let ratio = match (below, above) {
                (Some(below), Some(above)) => below + (above - below) * place.fract(),
                (one, other) => one.or(other).unwrap_or(0.0),
            };
            let edf = self.of(&sum.octave(), &curve.shape, law?).map(|edf| edf * ratio.exp());
            let relative = edf.and_then(|edf| self.interval(edf));
            Some(OctaveAssessment { m: sum.m, alpha: octaves[nearest].alpha, relative })
        };
        let unknown = |sum: &OctaveSum| OctaveAssessment { m: sum.m, alpha: None, relative: None };
        results.points.iter().map(|sum| point(sum).unwrap_or_else(|| unknown(sum))).collect()
    }
}

#[cfg(test)]
mod tests {
    use imu_noise::{Deviation, Estimator};

    use super::*;
    use crate::{Assessment, AveragingTimes, Settings, Snapshot, accumulate::analysis::Analysis};
    use vn100_protocol::{VNYMR, stream::Batch};

    /// Every whole number of samples at 40 Hz, up to half of 4000.
    fn all_factors() -> AveragingTimes {
        AveragingTimes::List((1..=2000).map(|m| f64::from(m) / 40.0).collect())
    }

    /// White noise of a linear congruential generator on every channel, as many samples.
    fn snapshot(samples: usize, times: AveragingTimes) -> Snapshot {
        let settings =
            Settings { estimator: Estimator::Full, averaging_times: times, rate_hz: Some(40.0), ..Settings::default() };
        let mut analysis = Analysis::new(settings);
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 22) as i32
        };
        let counts = (0..samples * VNYMR.channels.len()).map(|_| next()).collect();
        analysis.absorb(&Batch { layout: Some(std::sync::Arc::new(VNYMR.clone())), counts, ..Batch::default() });
        analysis.finish();
        analysis.final_snapshot()
    }

    fn assessed(
        samples: usize,
        times: AveragingTimes,
    ) -> (Vec<OctaveSum>, Vec<OctaveAssessment>, Vec<OctaveAssessment>) {
        let snapshot = snapshot(samples, times);
        let assessment = Assessment::new(&snapshot, 0.95);
        let last = assessment.channels.last().unwrap();
        (snapshot.channels.last().unwrap().points.clone(), last.points.clone(), last.octaves.clone())
    }

    #[test]
    fn a_point_at_an_octave_is_that_octave() {
        let (sums, points, octaves) = assessed(4000, all_factors());
        let mut seen = 0;
        for octave in &octaves {
            let place = sums.iter().position(|sum| sum.m == octave.m).unwrap();
            let (found, expected) = (points[place].relative.map(|r| r.edf), octave.relative.map(|r| r.edf));
            let (Some(found), Some(expected)) = (found, expected) else {
                assert_eq!((found, points[place].alpha), (expected, octave.alpha));
                continue;
            };
            assert!((found / expected - 1.0).abs() < 1e-12, "m = {}: {found}, not {expected}", octave.m);
            assert_eq!(points[place].alpha, octave.alpha);
            seen += 1;
        }
        assert!(seen >= 10);
        // and between them they fall, as the theory of one kind of noise does
        let edf: Vec<f64> = points.iter().filter_map(|point| point.relative).map(|relative| relative.edf).collect();
        assert!(edf.windows(2).all(|pair| pair[1] < 1.02 * pair[0]), "{edf:?}");
    }

    #[test]
    fn between_two_octaves_a_mixture_is_between_theirs() {
        let snapshot = snapshot(4000, all_factors());
        let (channel, results) = snapshot.measured().last().unwrap();
        let curve = OctaveVariances::new(channel, results, snapshot.shape_of(results));
        let white = Assessment::new(&snapshot, 0.95).channels.pop().unwrap().octaves;
        let mut mixed = white.clone();
        let more = mixed.iter_mut().find(|octave| octave.m == 16).unwrap();
        more.relative = Interval::new(1.0, 2.0 * more.relative.unwrap().edf, 0.95);
        let points = |octaves: &[OctaveAssessment]| KnownEdf::new(0.95).points(results, &curve, octaves);
        for (mixed, white) in points(&mixed).into_iter().zip(points(&white)).filter(|(point, _)| point.m <= 64) {
            let m = white.m as f64;
            let expected = (m / 8.0).min(32.0 / m).max(1.0);
            let found = mixed.relative.unwrap().edf / white.relative.unwrap().edf;
            assert!((found / expected - 1.0).abs() < 1e-9, "m = {m}: {found} times, not {expected}");
        }
    }

    #[test]
    fn the_degrees_of_freedom_of_white_noise_are_those_of_the_handbook() {
        // NIST SP 1065, table 5: overlapping Allan variance of white noise of the rate
        let (sums, points, _) = assessed(4000, AveragingTimes::Decade);
        let n = 4001.0;
        for (sum, point) in sums.iter().zip(&points).filter(|(sum, _)| (10..=400).contains(&sum.m)) {
            let m = sum.m as f64;
            let published = (3.0 * (n - 1.0) / (2.0 * m) - 2.0 * (n - 2.0) / n) * 4.0 * m * m / (4.0 * m * m + 5.0);
            let found = point.relative.unwrap().edf;
            assert!((found / published - 1.0).abs() < 0.1, "m = {m}: {found}, not {published}");
        }
    }

    #[test]
    fn known_degrees_of_freedom_are_those_of_the_octave() {
        let shape = RecordShape {
            samples: 5000,
            interval_s: 0.025,
            estimator: Estimator::Strided,
            deviation: Deviation::Hadamard,
        };
        let known = KnownEdf::new(0.9);
        let octaves = [(16, 5000), (16, 4000), (2048, 5)].map(|(m, terms)| Octave::whole(m, terms));
        for octave in octaves.iter().cycle().take(6) {
            for law in [PowerLaw::White, PowerLaw::RandomWalk] {
                assert_eq!(known.of(octave, &shape, law), edf(octave, &shape, law), "{octave:?} {law:?}");
            }
        }
        assert_eq!((known.interval(1.9), known.interval(9.0)), (None, Interval::new(1.0, 9.0, 0.9)));
    }
}
