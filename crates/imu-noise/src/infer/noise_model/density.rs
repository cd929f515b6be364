//! Densities of the components of the noise, by frequency, by octave and by cosine coefficient of the
//! level. Units are those of one sample; frequencies are cycles per sample.

use core::f64::consts::TAU;

use super::boxcar::{BoxcarWindow, phase_covariance};
use crate::accumulate::record::{Deviation, Octave, RecordShape};
use crate::infer::power_law::{PowerLaw, expected_variance, flicker_variance, walk_variance};

/// A component of the density, which is a multiple of it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Component {
    /// Density 1 at frequency 0, with the autocovariances that averaging on board makes.
    White(Vec<f64>),
    Flicker,
    Walk,
    Quantization,
    /// With this correlation time, and density 1 at frequency 0.
    GaussMarkov(f64),
    /// 1 - cos 2πjf, the part of a filter that forgets within j samples.
    Cosine(usize),
}

/// The places of the first components.
pub(super) const WHITE: usize = 0;
pub(super) const FLICKER: usize = 1;
pub(super) const WALK: usize = 2;

impl Component {
    pub(super) fn white(window: Option<BoxcarWindow>) -> Self {
        Self::White(window.map_or_else(|| vec![1.0], BoxcarWindow::autocovariance))
    }

    pub(super) fn density(&self, frequency: f64) -> f64 {
        let angle = TAU * frequency;
        match self {
            Self::White(autocovariance) => {
                let sides = autocovariance.iter().enumerate().skip(1);
                let sides: f64 = sides.map(|(lag, value)| 2.0 * value * (lag as f64 * angle).cos()).sum();
                // the first outputs of a long window that overlaps are zeros of the density
                (autocovariance[0] + sides).max(1e-9)
            }
            Self::Flicker => 0.5 / (0.5 * angle).sin(),
            Self::Walk => 0.25 / (0.5 * angle).sin().powi(2),
            Self::Quantization => 4.0 * (0.5 * angle).sin().powi(2),
            Self::GaussMarkov(time) => {
                let correlation = (-1.0 / time).exp();
                let at_zero = (1.0 - correlation).powi(2);
                at_zero / (at_zero + 4.0 * correlation * (0.5 * angle).sin().powi(2))
            }
            Self::Cosine(number) => 1.0 - (*number as f64 * angle).cos(),
        }
    }

    /// The mean over some neighbouring `points` about `frequency` of the powers of segments of so many
    /// samples, whose window passes each autocovariance in part.
    pub(super) fn density_of_points(&self, frequency: f64, points: f64, samples: f64) -> f64 {
        let part = |lag: f64| factor_of_lag(lag, points, samples) * (lag * TAU * frequency).cos();
        match self {
            Self::Cosine(number) => 1.0 - part(*number as f64),
            Self::White(autocovariance) => {
                let sides = autocovariance.iter().enumerate().skip(1);
                let sides = sides.map(|(lag, value)| 2.0 * value * part(lag as f64));
                (autocovariance[0] + sides.sum::<f64>()).max(1e-9)
            }
            other => other.density(frequency),
        }
    }

    /// What an octave shows of it, where a formula says so.
    pub(super) fn exact_octave(&self, octave: &Octave, deviation: Deviation) -> Option<f64> {
        let law = match self {
            Self::White(autocovariance) => {
                return Some(expected_variance(octave, deviation, |lag| phase_covariance(autocovariance, lag)));
            }
            Self::Flicker => PowerLaw::Flicker,
            Self::Walk => PowerLaw::RandomWalk,
            Self::Quantization => PowerLaw::WhitePhase,
            _ => return None,
        };
        Some(octave.expected_variance(deviation, law))
    }

    pub(super) const fn process_time(&self) -> Option<f64> {
        match self {
            Self::GaussMarkov(time) => Some(*time),
            _ => None,
        }
    }

    /// Variance of coefficient `k` of the means of so many blocks of `length` samples.
    pub(super) fn of_level(&self, k: usize, blocks: usize, length: f64) -> f64 {
        match self {
            Self::White(_) => 1.0 / length,
            // the slowest coefficients of flicker noise share some of what the folded spectrum counts twice
            Self::Flicker => (1.0 - 0.2 / k as f64) * flicker_variance(k, blocks),
            Self::Walk => length * walk_variance(k, blocks),
            // differences of the ends of the blocks
            Self::Quantization => 2.0 * self.between_blocks(k, blocks) / (length * length),
            Self::GaussMarkov(time) => {
                // white noise at averages longer than the correlation time, a walk at shorter ones
                let walk = walk_variance(k, blocks) * length / (time * time);
                1.0 / (length + 1.0 / walk)
            }
            Self::Cosine(number) => {
                let lag = (*number as f64).min(length);
                lag * self.between_blocks(k, blocks) / (length * length)
            }
        }
    }

    /// 1 - cos of coefficient `k`: what differs from one block to the next.
    fn between_blocks(&self, k: usize, blocks: usize) -> f64 {
        1.0 - (0.5 * TAU * k as f64 / blocks as f64).cos()
    }
}

/// The process of variance 1 with density 1 at 0 has this variance.
pub(super) fn variance_of_process(time: f64) -> f64 {
    let correlation = (-1.0 / time).exp();
    (1.0 - correlation) / (1.0 + correlation)
}

/// By the window of the segments, and by the mean over so many neighbouring points.
fn factor_of_lag(lag: f64, points: f64, samples: f64) -> f64 {
    let turn = TAU * lag / samples;
    let window = (1.0 - lag / samples) * (2.0 + turn.cos()) / 3.0 + turn.sin() / TAU;
    window * if points > 1.0 { (0.5 * points * turn).sin() / (points * (0.5 * turn).sin()) } else { 1.0 }
}

/// What an octave takes of the density, twice, as both signs of a frequency count: the mean over
/// frequencies from `from` to `to`, times their distance.
///
/// The Allan variance takes 2 sin⁴(πfm)/(m sin πf)², the Hadamard variance (8/3) sin⁶(πfm)/(m sin
/// πf)². Of missing samples an octave shows what [`Octave::expected`] says.
pub(super) fn octave_filter(octave: &Octave, deviation: Deviation, from: f64, to: f64) -> f64 {
    let whole = filter(deviation, octave.m, from, to);
    octave.expected(whole, |m| filter(Deviation::Allan, m, from, to))
}

fn filter(deviation: Deviation, m: u64, from: f64, to: f64) -> f64 {
    // sin⁴ and sin⁶ by cosines of even multiples
    let (factor, scale, cosines): (f64, f64, &[f64]) = match deviation {
        Deviation::Allan => (2.0, 8.0, &[3.0, -4.0, 1.0]),
        Deviation::Hadamard => (8.0 / 3.0, 32.0, &[10.0, -15.0, 6.0, -1.0]),
    };
    let m = m as f64;
    let half_turn = 0.5 * TAU;
    let (low, high) = (half_turn * from * m, half_turn * to * m);
    let middle = (half_turn * 0.5 * (from + to)).sin();
    let mean = if high - low < 0.05 {
        (0.5 * (low + high)).sin().powi(if deviation == Deviation::Allan { 4 } else { 6 })
    } else {
        let integral = |x: f64| {
            let others = cosines.iter().enumerate().skip(1);
            let others: f64 = others.map(|(k, c)| c * (2.0 * k as f64 * x).sin() / (2.0 * k as f64)).sum();
            (cosines[0] * x + others) / scale
        };
        (integral(high) - integral(low)) / (high - low)
    };
    2.0 * (to - from) * factor * mean / (m * middle).powi(2)
}

/// Frequencies between which the density is taken to be even, from what the longest octave of a
/// record does not show up to half a cycle per sample.
pub(super) fn cells(shape: &RecordShape) -> Vec<f64> {
    const COARSE: f64 = 4.0;
    const FINE: f64 = 12.0;
    let samples = shape.samples.max(2) as f64;
    // a walk adds below this a thousandth to an octave of the whole record
    let (lowest, fine) = (1e-3 / samples, 1.0 / (16.0 * samples));
    let mut edges = vec![0.5];
    let mut edge: f64 = 0.5;
    while edge > lowest {
        edge /= (1.0 / if edge > fine { FINE } else { COARSE }).exp2();
        edges.push(edge);
    }
    edges.reverse();
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::record::Estimator;

    #[test]
    fn octaves_of_a_density_are_those_of_its_noise() {
        for (deviation, samples) in [(Deviation::Allan, 10_000), (Deviation::Hadamard, 10_000)] {
            let shape = RecordShape { samples, interval_s: 1.0, estimator: Estimator::Strided, deviation };
            let edges = cells(&shape);
            for (m, share_present) in [(1, 1.0), (2, 0.8), (16, 0.8), (256, 1.0), (2048, 0.8)] {
                let octave = Octave { m, terms: 100, share_present };
                for (component, law) in [
                    (Component::white(None), PowerLaw::White),
                    (Component::Flicker, PowerLaw::Flicker),
                    (Component::Walk, PowerLaw::RandomWalk),
                ] {
                    let of = |edges: &[f64]| {
                        octave_filter(&octave, deviation, edges[0], edges[1])
                            * component.density((edges[0] * edges[1]).sqrt())
                    };
                    let found: f64 = edges.windows(2).map(of).sum();
                    let expected = octave.expected_variance(deviation, law);
                    assert!((found / expected - 1.0).abs() < 0.01, "{law:?} {octave:?}: {found} {expected}");
                }
            }
        }
    }
}
