//! Windowed Fourier transforms of segments, and the sums of their powers.

use std::{fmt, sync::Arc};

use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex};

use super::Powers;
use crate::accumulate::counts::ROUND;

/// Powers are rounded to a multiple of the inverse of this, so that their sums are those of integers.
const SCALE: f64 = (1_u64 << 12) as f64;

pub(super) struct Transform<const N: usize> {
    fft: Arc<dyn RealToComplex<f32>>,
    /// Hann: periodic, and scaled to a mean square of 1.
    window: [f32; N],
}

impl<const N: usize> Transform<N> {
    pub(super) fn new(planner: &mut RealFftPlanner<f32>) -> Self {
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

/// The power sums of segments of `N` values: exact below 2^41 counts², and beyond as exact as floats are.
#[derive(Clone, Debug)]
pub(super) struct SegmentPowerSums<const N: usize> {
    /// For k = 0..=N/2, in multiples of 2^-12 counts².
    sums: Vec<f64>,
    pub(super) segments: u64,
    weight: f64,
    weight_squares: f64,
}

impl<const N: usize> SegmentPowerSums<N> {
    pub(super) fn new() -> Self {
        Self { sums: vec![0.0; N / 2 + 1], segments: 0, weight: 0.0, weight_squares: 0.0 }
    }

    /// Each power is rounded once.
    pub(super) fn add<T: Copy + Into<i64>>(&mut self, transform: &Transform<N>, segment: &[T; N], stands_for: u64) {
        let sum: i64 = segment.iter().map(|&count| count.into()).sum();
        let mean = sum as f64 / N as f64;
        let mut input = transform.window;
        for (value, &count) in input.iter_mut().zip(segment) {
            *value *= (count.into() as f64 - mean) as f32;
        }
        // One place more than N/2 + 1, because a length cannot be computed from N here.
        let mut output = [Complex::new(0.0, 0.0); N];
        let output = &mut output[..=N / 2];
        // Fails only for other lengths than the planned one. Does not allocate, because powers of two need no
        // scratch room.
        let weight = stands_for as f64;
        if transform.fft.process(&mut input, output).is_ok() {
            for (sum, value) in self.sums.iter_mut().zip(output) {
                *sum += weight * (f64::from(value.norm_sqr()) * SCALE + ROUND - ROUND);
            }
        }
        self.segments += 1;
        self.weight += weight;
        self.weight_squares += weight * weight;
    }

    pub(super) fn powers(&self) -> Powers {
        // The squares of a Gaussian process in half overlapping Hann segments have a correlation of 1/36
        // (Welch 1967).
        let equal_weights = self.weight * self.weight / self.weight_squares;
        let averages = if self.segments < 2 { equal_weights } else { (equal_weights / (1.0 + 2.0 / 36.0)).max(1.0) };
        let divisor = self.weight * N as f64 * SCALE;
        let powers = self.sums.iter().map(|sum| sum / divisor).collect();
        Powers { segment_samples: N, segments: self.segments, averages, powers }
    }
}
