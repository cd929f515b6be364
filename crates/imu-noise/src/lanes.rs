//! Sums of integer-valued `f64` in vector registers, and the bound that proves them exact.

/// An integer-valued `f64` below 2^53 has not been rounded. Sums of terms that are not negative
/// never fall, so one that ends below this bound was never rounded on the way, in any order of
/// additions.
pub(crate) const EXACT_BELOW: f64 = (1_u64 << 53) as f64;

/// Independent partial sums, so that additions neither wait for each other nor stay scalar.
const LANES: usize = 8;

/// Sum of `term` over the places of `slices`, which are equally long.
#[inline]
pub(crate) fn sum<T: Copy, const S: usize>(slices: [&[T]; S], term: impl Fn([T; S]) -> f64) -> f64 {
    let chunks = slices.map(|slice| slice.as_chunks::<LANES>());
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
