//! From counts to the unit of a channel.

/// A value in counts, in the unit of a channel with `decimals` digits behind the point: one count
/// is 10^-decimals.
///
/// Divides once by a power of ten, which is exact up to 22 decimals. Variances take twice the
/// decimals.
///
/// ```
/// assert_eq!(imu_noise::counts_to_unit(-9813.0, 3), -9.813);
/// ```
#[must_use]
pub fn counts_to_unit(counts: f64, decimals: u8) -> f64 {
    counts / 10_f64.powi(decimals.into())
}
