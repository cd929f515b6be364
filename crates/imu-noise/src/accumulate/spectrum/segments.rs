//! From a segment of samples to sums of squared Fourier coefficients.

use std::{fmt, sync::Arc};

use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex};

use super::{LONG, SHORT};

/// Window and Fourier transform, made once and shared by the channels: a copy is a reference.
#[derive(Clone, Debug)]
pub struct SpectrumPlan {
    pub(super) long: Arc<Transform<LONG>>,
    pub(super) short: Arc<Transform<SHORT>>,
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

/// The transform of a segment of N samples.
pub(super) struct Transform<const N: usize> {
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

    /// |X_k|² for k = 0..=N/2 of real input, handed to `each` in rising k.
    pub(super) fn squares(&self, mut input: [f32; N], mut each: impl FnMut(usize, f32)) {
        // One place more than N/2 + 1, since a length cannot be computed from N here.
        let mut output = [Complex::new(0.0, 0.0); N];
        let output = &mut output[..=N / 2];
        // Fails for other lengths than the planned one only. Does not allocate: powers of two need no scratch room.
        if self.fft.process(&mut input, output).is_ok() {
            for (k, value) in output.iter().enumerate() {
                each(k, value.norm_sqr());
            }
        }
    }
}

impl<const N: usize> fmt::Debug for Transform<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Transform").field("samples", &N).finish_non_exhaustive()
    }
}

/// Weighted sums of the squared coefficients of segments of N samples.
#[derive(Clone, Debug)]
pub(super) struct PowerSums<const N: usize> {
    /// For k = 0..=N/2, in counts².
    squares: Vec<f32>,
    segments: u64,
    weight: f64,
    weight_squares: f64,
}

impl<const N: usize> PowerSums<N> {
    pub(super) fn new() -> Self {
        Self { squares: vec![0.0; N / 2 + 1], segments: 0, weight: 0.0, weight_squares: 0.0 }
    }

    pub(super) fn add(&mut self, transform: &Transform<N>, segment: &[i32; N], stands_for: u64) {
        let sum: i64 = segment.iter().map(|&count| i64::from(count)).sum();
        let mean = sum as f64 / N as f64;
        let mut input = transform.window;
        for (value, &count) in input.iter_mut().zip(segment) {
            *value *= (f64::from(count) - mean) as f32;
        }
        let weight = stands_for as f64;
        let squares = &mut self.squares;
        transform.squares(input, |k, square| squares[k] += weight as f32 * square);
        self.segments += 1;
        self.weight += weight;
        self.weight_squares += weight * weight;
    }

    pub(super) const fn segments(&self) -> u64 {
        self.segments
    }

    /// Segments of equal weight without overlap that average as well: the squares of a Gaussian
    /// process in half overlapping Hann segments correlate by 1/36 (Welch 1967).
    pub(super) fn averages(&self) -> f64 {
        let equal_weights = self.weight * self.weight / self.weight_squares;
        if self.segments < 2 { equal_weights } else { (equal_weights / (1.0 + 2.0 / 36.0)).max(1.0) }
    }

    /// Weighted means of |X_k|²/N: for white noise, its variance.
    pub(super) fn powers(&self) -> impl Iterator<Item = f64> {
        let divisor = self.weight * N as f64;
        self.squares.iter().map(move |&sum| f64::from(sum) / divisor)
    }
}
