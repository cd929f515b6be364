//! Sums of integer-valued `f64` in vector registers, and the bound that proves them exact.
//!
//! Functions that are always inlined are compiled for each width of registers, in `multiversion`
//! functions.

/// Integer-valued `f64` below 2^53 are not rounded. Sums of terms that are not negative never
/// decrease, so a sum that ends below this was never rounded, in any order of additions.
pub(crate) const EXACT_BELOW: f64 = (1_u64 << 53) as f64;

/// 1.5 · 2^52: added to a float below 2^51 and subtracted again, it gives the nearest integer, which
/// vector instructions of any processor can do.
pub(crate) const ROUND: f64 = 6_755_399_441_055_744.0;

/// Independent partial sums, so that additions are independent and can be vectorised.
const LANES: usize = 8;

/// Sum of `term` over the places of `slices`, which are equally long.
#[inline(always)]
pub(crate) fn lane_sum<T: Copy, const S: usize>(slices: [&[T]; S], term: impl Fn([T; S]) -> f64) -> f64 {
    // one length for all of them spares the loop its checks
    let len = slices[0].len();
    let chunks = slices.map(|slice| slice[..len].as_chunks::<LANES>());
    let mut lanes = [0.0_f64; LANES];
    for chunk in 0..chunks[0].0.len() {
        let chunk = chunks.map(|(whole, _)| &whole[chunk]);
        for (lane, sum) in lanes.iter_mut().enumerate() {
            *sum += term(chunk.map(|values| values[lane]));
        }
    }
    let whole: f64 = lanes.iter().sum();
    let rest: f64 = (0..chunks[0].1.len()).map(|i| term(chunks.map(|(_, rest)| rest[i]))).sum();
    whole + rest
}

/// The sum of the products of two slices that are equally long.
#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    lane_sum([a, b], |[a, b]| a * b)
}

/// Converts a value in counts to the unit of a channel with `decimals` digits after the point: one
/// count is 10^-decimals.
///
/// Divides once by a power of ten, which is exact up to 22 decimals. For a variance, give twice the
/// decimals of the channel.
///
/// ```
/// assert_eq!(imu_noise::counts_to_unit(-9813.0, 3), -9.813);
/// ```
pub fn counts_to_unit(counts: f64, decimals: u8) -> f64 {
    counts / 10_f64.powi(decimals.into())
}
