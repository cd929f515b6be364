//! Windowed Fourier transforms of segments, and the exact sums of their powers.

use std::{fmt, iter, mem, sync::Arc};

use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex};

use super::{Count, Powers};

/// Bits of the fraction of summed powers.
const FRACTION_BITS: u32 = 12;
const SCALE: f64 = (1_u64 << FRACTION_BITS) as f64;

/// 1.5 · 2^52 and its bits: added to a float below 2^51, it leaves the nearest integer in the low
/// bits, which vector instructions of any processor can do; larger floats leave larger bits.
const SHIFTER: f64 = 6_755_399_441_055_744.0;
const SHIFTER_BITS: u64 = 0x4338_0000_0000_0000;
const SHIFTED_BELOW: u64 = 1 << 51;

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

/// The power sums of segments of `N` values. The power of a segment is below 2^80 counts² for
/// samples of 32 bits: the sums are exact for 2^40 samples of full scale and more.
#[derive(Clone, Debug)]
pub(super) struct SegmentPowerSums<const N: usize> {
    /// For k = 0..=N/2, in multiples of 2^-12 counts²: `low` has the latest sums, `high` the
    /// earlier ones if all would not fit into `low`, else it is empty.
    low: Vec<u64>,
    high: Vec<u128>,
    /// An upper bound of the low parts.
    most: u64,
    pub(super) segments: u64,
    weight: u64,
    weight_squares: u128,
}

impl<const N: usize> SegmentPowerSums<N> {
    pub(super) fn new() -> Self {
        Self { low: vec![0; N / 2 + 1], high: Vec::new(), most: 0, segments: 0, weight: 0, weight_squares: 0 }
    }

    /// Each power is rounded once.
    pub(super) fn add<T: Count>(&mut self, transform: &Transform<N>, segment: &[T; N], stands_for: u64) {
        let sum: i64 = segment.iter().map(|&count| count.into()).sum();
        let mean = sum as f64 / N as f64;
        let mut input = transform.window;
        for (value, &count) in input.iter_mut().zip(segment) {
            *value *= (count.as_f64() - mean) as f32;
        }
        // One place more than N/2 + 1, because a length cannot be computed from N here.
        let mut output = [Complex::new(0.0, 0.0); N];
        let output = &mut output[..=N / 2];
        // Fails only for other lengths than the planned one. Does not allocate, because powers of two need no
        // scratch room.
        if transform.fft.process(&mut input, output).is_ok() {
            self.add_powers(output, stands_for);
        }
        self.segments += 1;
        self.weight += stands_for;
        self.weight_squares += u128::from(stands_for) * u128::from(stands_for);
    }

    #[inline]
    fn add_powers(&mut self, output: &[Complex<f32>], stands_for: u64) {
        let shift = stands_for.ilog2();
        let all = self.change_low(output, |sum, power| sum.wrapping_add(power << shift));
        // all bits of the powers: no power is larger
        let most = (all < SHIFTED_BELOW).then(|| all.checked_mul(stands_for)).flatten();
        match most.and_then(|most| self.most.checked_add(most)) {
            Some(most) => self.most = most,
            None => {
                self.change_low(output, |sum, power| sum.wrapping_sub(power << shift));
                let power = |value: &Complex<f32>| (f64::from(value.norm_sqr()) * SCALE + 0.5) as u128;
                self.add_to_high(output.iter().map(|value| power(value) * u128::from(stands_for)));
            }
        }
    }

    /// Changes the low parts; returns the bits that any of the powers has, in fixed point.
    #[inline]
    fn change_low(&mut self, output: &[Complex<f32>], change: impl Fn(u64, u64) -> u64) -> u64 {
        let mut all = 0;
        for (sum, value) in self.low.iter_mut().zip(output) {
            let power = (f64::from(value.norm_sqr()) * SCALE + SHIFTER).to_bits().wrapping_sub(SHIFTER_BITS);
            all |= power;
            *sum = change(*sum, power);
        }
        all
    }

    /// Adds these numbers and the low parts to the high parts.
    #[cold]
    fn add_to_high(&mut self, more: impl Iterator<Item = u128>) {
        self.high.resize(self.low.len(), 0);
        for ((high, low), more) in self.high.iter_mut().zip(&mut self.low).zip(more) {
            *high = high.saturating_add(u128::from(mem::take(low)).saturating_add(more));
        }
        self.most = 0;
    }

    fn squares(&self) -> impl Iterator<Item = u128> {
        let high = self.high.iter().copied().chain(iter::repeat(0));
        self.low.iter().zip(high).map(|(low, high)| high.saturating_add((*low).into()))
    }

    pub(super) fn powers(&self) -> Powers {
        // The squares of a Gaussian process in half overlapping Hann segments have a correlation of 1/36
        // (Welch 1967).
        let weight = self.weight as f64;
        let equal_weights = weight * weight / self.weight_squares as f64;
        let averages = if self.segments < 2 { equal_weights } else { (equal_weights / (1.0 + 2.0 / 36.0)).max(1.0) };
        let divisor = weight * (N << FRACTION_BITS) as f64;
        let powers = self.squares().map(|sum| sum as f64 / divisor).collect();
        Powers { segment_samples: N, segments: self.segments, averages, powers }
    }
}
