//! Streaming power spectral density by Welch's method.

use std::{fmt, sync::Arc};

use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex};

use super::counts::counts_to_unit;

const LONG: usize = 512;

/// Samples of a segment of records too short to average over long ones.
const SHORT: usize = 128;

/// Fewest averages of long segments; below, the short ones are read out.
const MIN_LONG_SEGMENTS: u64 = 8;

/// Samples within which every segment is taken.
const DENSE_SAMPLES: u64 = 32_768;

/// Streaming power spectral density: Welch (1967), Hann window, segments of 512 samples without
/// their mean, half overlapping; of 128 samples for a record shorter than 8 segments (2304 samples
/// without gap). A gap restarts the segment.
///
/// Beyond 32 768 samples, those missing not counted, the segments are spread evenly: every second
/// up to twice that length, every fourth up to four times, and so on, each with a weight of as many
/// as it stands for. So the cost grows with the logarithm of the length, and the
/// [averages](Density::averages) stay above 120. Sums are single precision: densities are good to
/// 1e-5 of the largest, and the same bits in any division over calls.
#[derive(Clone, Debug)]
pub struct Spectrum<T = i32> {
    plan: SpectrumPlan,
    segment: Vec<T>,
    samples: u64,
    /// Where the next segment may start; where `segment` starts when it is not empty.
    start: u64,
    long: PowerSums<LONG>,
    short: PowerSums<SHORT>,
}

/// A whole number of counts: a sample, or a sum of samples below 2^53.
pub trait Count: Copy + Into<i64> {
    /// The same number.
    fn as_f64(self) -> f64;
}

impl Count for i32 {
    fn as_f64(self) -> f64 {
        self.into()
    }
}

impl Count for i64 {
    fn as_f64(self) -> f64 {
        self as f64
    }
}

impl<T: Count> Spectrum<T> {
    pub(crate) fn new(plan: &SpectrumPlan) -> Self {
        Self {
            plan: plan.clone(),
            segment: Vec::with_capacity(LONG),
            samples: 0,
            start: 0,
            long: PowerSums::new(),
            short: PowerSums::new(),
        }
    }

    pub(crate) fn push(&mut self, mut counts: &[T]) {
        while !counts.is_empty() {
            if self.segment.is_empty() {
                let skipped = self.start.saturating_sub(self.samples).min(counts.len() as u64) as usize;
                counts = &counts[skipped..];
                self.samples += skipped as u64;
                if counts.is_empty() {
                    return;
                }
                self.start = self.samples;
            }
            // In steps of half a short segment, whose ends fall on the same places in any division.
            let step = SHORT / 2 - self.segment.len() % (SHORT / 2);
            let (head, tail) = counts.split_at(step.min(counts.len()));
            self.segment.extend_from_slice(head);
            counts = tail;
            self.samples += head.len() as u64;
            if head.len() == step {
                self.step_filled();
            }
        }
    }

    pub(crate) fn gap(&mut self) {
        self.segment.clear();
    }

    pub(crate) fn powers(&self) -> Option<Powers> {
        if self.long.segments >= MIN_LONG_SEGMENTS {
            Some(self.long.powers())
        } else {
            (self.short.segments > 0).then(|| self.short.powers())
        }
    }

    fn step_filled(&mut self) {
        if self.long.segments < MIN_LONG_SEGMENTS
            && let Some(last) = self.segment.last_chunk()
        {
            // Gaps may keep every long segment from filling: the short ones must not grow without bound either.
            let stands_for = stands_for(self.samples);
            if (self.samples / (SHORT / 2) as u64).is_multiple_of(stands_for) {
                self.short.add(&self.plan.short, last, stands_for);
            }
        }
        if let Some(segment) = self.segment.first_chunk() {
            let stands_for = stands_for(self.start);
            self.long.add(&self.plan.long, segment, stands_for);
            self.start += (LONG / 2) as u64 * stands_for;
            if stands_for == 1 {
                self.segment.copy_within(LONG / 2.., 0);
                self.segment.truncate(LONG / 2);
            } else {
                self.segment.clear();
            }
        }
    }
}

/// Segments in place of which one at this number of samples is taken: 1, 2, 4, ...
fn stands_for(samples: u64) -> u64 {
    match (samples / DENSE_SAMPLES).checked_ilog2() {
        None => 1,
        Some(octave) => 2 << octave,
    }
}

/// Which frequencies a density counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sides {
    /// Positive ones only, as spectrum analysers show it: √2 times the two-sided amplitude, twice
    /// its power. White noise has the power density 2 N².
    One,
    /// Negative ones too (IEEE Std 952): the amplitude density is N itself, the power density N².
    Two,
}

/// A power spectral density at evenly spaced frequencies.
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    /// Which frequencies it is spread over.
    pub sides: Sides,
    /// Samples of a segment.
    pub segment_samples: usize,
    /// Segments transformed.
    pub segments: u64,
    /// Independent segments that average as well. Each point has about twice as many degrees of
    /// freedom (the last point, at half the sampling rate, as many).
    pub averages: f64,
    /// From 1/(segment_samples·interval) to half the sampling rate. Windowing spreads a line over
    /// four points; the first point is low, since each segment lost its mean.
    pub points: Vec<DensityPoint>,
}

/// One point of a [`Density`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DensityPoint {
    /// Frequency in Hz.
    pub frequency_hz: f64,
    /// Density in unit²/Hz.
    pub density_unit2_hz: f64,
}

#[derive(Clone, Debug)]
pub(crate) struct Powers {
    pub(crate) segment_samples: usize,
    pub(crate) segments: u64,
    pub(crate) averages: f64,
    /// Means of |X_k|²/n for k = 0..=n/2.
    pub(crate) powers: Vec<f64>,
}

impl Spectrum {
    /// The density of a channel sampled every `interval_s` seconds with `decimals` digits. `None`
    /// before the first segment is full, and where `interval_s` is not positive.
    #[must_use]
    pub fn density(&self, sides: Sides, interval_s: f64, decimals: u8) -> Option<Density> {
        let Powers { segment_samples, segments, averages, powers } = self.powers()?;
        if interval_s.is_nan() || interval_s <= 0.0 {
            return None;
        }
        let step_hz = 1.0 / (segment_samples as f64 * interval_s);
        let points = powers.iter().enumerate().skip(1).map(|(k, power)| {
            // At half the sampling rate too: it is its own negative, in a point half as wide.
            let counts2_hz = power * interval_s * if sides == Sides::One { 2.0 } else { 1.0 };
            let density_unit2_hz = counts_to_unit(counts_to_unit(counts2_hz, decimals), decimals);
            DensityPoint { frequency_hz: k as f64 * step_hz, density_unit2_hz }
        });
        Some(Density { sides, segment_samples, segments, averages, points: points.collect() })
    }

    /// Autocovariances within segments in counts² (Wiener and Khinchin), from lag 0 to a quarter of
    /// a segment: so far the window takes at most 35 % of them. `None` before four segments are
    /// full.
    pub(crate) fn autocovariances_counts2(&self) -> Option<Vec<f64>> {
        let Powers { segment_samples, powers, .. } = self.powers().filter(|powers| powers.segments >= 4)?;
        // a power of two, so that a mask is the remainder
        let last = segment_samples - 1;
        let step = std::f64::consts::TAU / segment_samples as f64;
        let cosines: Vec<_> = (0..segment_samples).map(|i| (step * i as f64).cos()).collect();
        let covariance = |lag: usize| {
            let both_sides = powers.iter().enumerate().skip(1).map(|(k, power)| {
                let sides = if 2 * k == segment_samples { 1.0 } else { 2.0 };
                sides * power * cosines[lag * k & last]
            });
            both_sides.sum::<f64>() / segment_samples as f64
        };
        Some((0..=segment_samples / 4).map(covariance).collect())
    }
}

/// Window and Fourier transform, made once and shared by the channels: a copy is a reference.
#[derive(Clone, Debug)]
pub struct SpectrumPlan {
    long: Arc<Transform<LONG>>,
    short: Arc<Transform<SHORT>>,
}

impl SpectrumPlan {
    /// Windows and transforms for both lengths of segments.
    #[must_use]
    pub fn new() -> Self {
        let mut planner = RealFftPlanner::new();
        Self { long: Arc::new(Transform::new(&mut planner)), short: Arc::new(Transform::new(&mut planner)) }
    }
}

impl Default for SpectrumPlan {
    fn default() -> Self {
        Self::new()
    }
}

struct Transform<const N: usize> {
    fft: Arc<dyn RealToComplex<f32>>,
    /// Hann: periodic, and scaled to a mean square of 1.
    window: [f32; N],
}

impl<const N: usize> Transform<N> {
    fn new(planner: &mut RealFftPlanner<f32>) -> Self {
        // The mean square of (1 - cos)/2 over whole periods is 3/8.
        let scale = (8.0_f64 / 3.0).sqrt() / 2.0;
        let hann = |i: usize| scale * (1.0 - (std::f64::consts::TAU * i as f64 / N as f64).cos());
        Self { fft: planner.plan_fft_forward(N), window: std::array::from_fn(|i| hann(i) as f32) }
    }
}

impl<const N: usize> fmt::Debug for Transform<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Transform").field("samples", &N).finish_non_exhaustive()
    }
}

#[derive(Clone, Debug)]
struct PowerSums<const N: usize> {
    /// For k = 0..=N/2, in counts².
    squares: Vec<f32>,
    segments: u64,
    weight: f64,
    weight_squares: f64,
}

impl<const N: usize> PowerSums<N> {
    fn new() -> Self {
        Self { squares: vec![0.0; N / 2 + 1], segments: 0, weight: 0.0, weight_squares: 0.0 }
    }

    fn add<T: Count>(&mut self, transform: &Transform<N>, segment: &[T; N], stands_for: u64) {
        let sum: i64 = segment.iter().map(|&count| count.into()).sum();
        let mean = sum as f64 / N as f64;
        let mut input = transform.window;
        for (value, &count) in input.iter_mut().zip(segment) {
            *value *= (count.as_f64() - mean) as f32;
        }
        let weight = stands_for as f64;
        // One place more than N/2 + 1, since a length cannot be computed from N here.
        let mut output = [Complex::new(0.0, 0.0); N];
        let output = &mut output[..=N / 2];
        // Fails for other lengths than the planned one only. Does not allocate: powers of two need no scratch room.
        if transform.fft.process(&mut input, output).is_ok() {
            for (sum, value) in self.squares.iter_mut().zip(&*output) {
                *sum += weight as f32 * value.norm_sqr();
            }
        }
        self.segments += 1;
        self.weight += weight;
        self.weight_squares += weight * weight;
    }

    fn powers(&self) -> Powers {
        // The squares of a Gaussian process in half overlapping Hann segments correlate by 1/36 (Welch 1967).
        let equal_weights = self.weight * self.weight / self.weight_squares;
        let averages = if self.segments < 2 { equal_weights } else { (equal_weights / (1.0 + 2.0 / 36.0)).max(1.0) };
        let divisor = self.weight * N as f64;
        let powers = self.squares.iter().map(|&sum| f64::from(sum) / divisor).collect();
        Powers { segment_samples: N, segments: self.segments, averages, powers }
    }
}
