//! The magnitude of the measured vectors, sample by sample, which does not depend on the
//! orientation.

use std::ops::Range;

use imu_noise::counts_to_unit;
use vn100_protocol::{Channel, Layout, Quantity};

use crate::sensor::sensor_of;

/// Decimals of a magnitude in addition to those of its components.
const MORE_DECIMALS: u8 = 2;
const MORE: f64 = 100.0;

/// The magnitude of one sensor's vector, √(x² + y² + z²).
#[derive(Debug, Clone, PartialEq)]
pub struct Magnitude {
    /// The quantity of the vector.
    pub quantity: Quantity,
    /// Unit of the magnitude.
    pub unit: String,
    /// A count of 1 is 10^-`decimals` · `scale` units.
    pub decimals: u8,
    /// The scale, as that of [`Channel::scale`].
    pub scale: f64,
    /// Number of magnitudes.
    pub count: u64,
    /// Exact sums and extremes in counts. A magnitude of three axes of 32 bits has 39 bits, so that the
    /// squares of 2^50 of them fit.
    sum: i128,
    squares: i128,
    min: i64,
    max: i64,
    /// Place of the x axis in a row; y and z follow.
    first: usize,
    /// The count of each axis in counts of the coarsest one.
    factors: [f64; 3],
}

impl Magnitude {
    /// One for every three neighbouring channels of one sensor, in hundredths of the coarsest count.
    pub(crate) fn all(layout: &Layout) -> Vec<Self> {
        let vectors = layout.channels.windows(3).enumerate().filter_map(|(first, axes)| {
            let [x, y, z] = axes else { return None };
            let quantity = x.quantity;
            let begins = first == 0 || layout.channels[first - 1].quantity != quantity;
            let is_vector = sensor_of(quantity).is_some() && [y, z].map(|axis| axis.quantity) == [quantity; 2];
            let count = |axis: &Channel| axis.in_unit(1.0);
            let coarsest = [y, z].into_iter().fold(x, |of, axis| if count(axis) > count(of) { axis } else { of });
            (begins && is_vector).then(|| Self {
                quantity,
                unit: x.unit.to_string(),
                decimals: coarsest.decimals + MORE_DECIMALS,
                scale: coarsest.scale,
                count: 0,
                sum: 0,
                squares: 0,
                min: i64::MAX,
                max: 0,
                first,
                factors: [x, y, z].map(|axis| count(axis) / count(coarsest)),
            })
        });
        vectors.collect()
    }

    /// Places of the three axes in a row.
    pub(crate) fn axes(&self) -> Range<usize> {
        self.first..self.first + 3
    }

    /// Adds frame-major rows of `width` counts.
    pub(crate) fn push(&mut self, counts: &[i32], width: usize) {
        // each begins with the three axes
        for axes in counts.get(self.first..).unwrap_or_default().chunks(width) {
            let axes: [i32; 3] = axes.first_chunk().copied().unwrap_or_default();
            let [x, y, z] = [0, 1, 2].map(|axis| self.factors[axis] * f64::from(axes[axis]));
            // rounded, as none is negative
            let length = (MORE * (x * x + y * y + z * z).sqrt() + 0.5) as i64;
            self.count += 1;
            self.sum += i128::from(length);
            self.squares += i128::from(length) * i128::from(length);
            (self.min, self.max) = (self.min.min(length), self.max.max(length));
        }
    }

    /// Smallest and largest magnitude in the unit; `None` without one.
    pub fn extremes(&self) -> Option<(f64, f64)> {
        (self.count > 0).then(|| (self.in_unit(self.min as f64), self.in_unit(self.max as f64)))
    }

    /// Mean in the unit; `None` without a magnitude.
    pub fn mean(&self) -> Option<f64> {
        let (centre, rest, _) = self.centred()?;
        Some(self.in_unit(centre as f64 + rest / self.count as f64))
    }

    /// Standard deviation in the unit, with n - 1 in the denominator; `None` below two magnitudes.
    pub fn std(&self) -> Option<f64> {
        let (_, rest, squares) = self.centred().filter(|_| self.count > 1)?;
        let n = self.count as f64;
        Some(self.in_unit(((squares - rest * rest / n) / (n - 1.0)).sqrt()))
    }

    /// The count nearest the mean, and the sums of the differences from it and of their squares.
    fn centred(&self) -> Option<(i128, f64, f64)> {
        let n = i128::from(self.count);
        let centre = (2 * self.sum + n).checked_div_euclid(2 * n)?;
        let squares = self.squares - centre * (2 * self.sum - n * centre);
        Some((centre, (self.sum - n * centre) as f64, squares as f64))
    }

    fn in_unit(&self, counts: f64) -> f64 {
        counts_to_unit(counts, self.decimals) * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use vn100_protocol::VNYMR;

    #[test]
    fn three_axes_of_one_sensor_are_a_vector() {
        let vectors = |channels: &[Channel]| {
            Magnitude::all(&Layout { channels: channels.to_vec().into(), ..VNYMR.clone() }).len()
        };
        let axes = &VNYMR.channels[6..9];
        assert_eq!((vectors(axes), vectors(&axes[..2]), vectors(&VNYMR.channels[..3])), (1, 0, 0));
        assert_eq!(vectors(&[axes, axes].concat()), 1, "the first three");
        for axis in 0..3 {
            let with = |change: fn(&mut Channel)| {
                let mut axes = axes.to_vec();
                change(&mut axes[axis]);
                vectors(&axes)
            };
            assert_eq!(with(|axis| axis.decimals += 1), 1, "axis {axis}");
            assert_eq!(with(|axis| axis.scale *= 2.0), 1, "axis {axis}");
            assert_eq!(with(|axis| axis.quantity = Quantity::Temperature), 0, "axis {axis}");
        }
    }

    #[test]
    fn axes_may_have_powers_of_two_of_their_own_and_all_of_their_bits() {
        let mut axes = VNYMR.channels[6..9].to_vec();
        for (axis, power) in axes.iter_mut().zip([30, 28, 27]) {
            (axis.decimals, axis.scale) = (0, 2_f64.powi(-power));
        }
        let layout = Layout { channels: axes.into(), ..VNYMR.clone() };
        let mut magnitude = Magnitude::all(&layout).remove(0);
        // 1.5, 6 and -14 m/s²
        magnitude.push(&[3 << 29, 6 << 28, -14 << 27], 3);
        let (_, longest) = magnitude.extremes().unwrap();
        assert!((longest - 15.305_227_86_f64).abs() < 1e-7, "{longest}");
    }

    proptest! {
        /// Rows of any size, up to the largest counts, around a level or not.
        #[test]
        fn no_length_is_too_long(
            level in proptest::array::uniform3(-i32::MAX..=i32::MAX),
            bits in 0_u32..31,
            steps in proptest::collection::vec(proptest::array::uniform3(-1.0_f64..1.0), 2..40),
        ) {
            let row = |steps: [f64; 3]| [0, 1, 2].map(|axis| level[axis].saturating_add((steps[axis] * f64::from(1 << bits)) as i32));
            let rows: Vec<[i32; 3]> = steps.into_iter().map(row).collect();
            let mut magnitude = Magnitude::all(&Layout { channels: VNYMR.channels[6..9].to_vec().into(), ..VNYMR.clone() }).remove(0);
            magnitude.push(rows.as_flattened(), 3);
            let lengths = rows.iter().map(|row| row.map(|count| f64::from(count).powi(2)).iter().sum::<f64>().sqrt() / 1e3);
            let (n, lengths) = (rows.len() as f64, lengths.collect::<Vec<_>>());
            let mean = lengths.iter().sum::<f64>() / n;
            let std = (lengths.iter().map(|length| (length - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
            let of = |fold: fn(f64, f64) -> f64| lengths.iter().copied().reduce(fold).unwrap();
            let (shortest, longest) = magnitude.extremes().unwrap();
            let found = [magnitude.mean().unwrap(), magnitude.std().unwrap(), shortest, longest];
            for (found, expected) in found.into_iter().zip([mean, std, of(f64::min), of(f64::max)]) {
                // a hundredth of a count, and what floats round
                prop_assert!((found - expected).abs() < 1.1e-5 + 1e-14 * mean, "{found} {expected}");
            }
        }
    }

    #[test]
    fn lengths_are_those_of_pythagoras() {
        let mut magnitude = Magnitude::all(&VNYMR).remove(1);
        let mut row = [0; 12];
        row[6..9].copy_from_slice(&[2000, 3000, 6000]);
        let mut rows = row.to_vec();
        row[6..9].copy_from_slice(&[0, 0, -1]);
        rows.extend(row);
        magnitude.push(&rows, 12);
        assert_eq!((magnitude.count, magnitude.decimals), (2, 5));
        assert_eq!(magnitude.extremes(), Some((1e-3, 7.0)));
    }
}
