//! The magnitude of the measured vectors, sample by sample, which does not depend on the
//! orientation.

use std::ops::Range;

use imu_noise::Moments;
use vn100_protocol::{Channel, Layout, Quantity};

use crate::sensor::sensor_of;

/// Decimals of a magnitude in addition to those of its components.
const MORE_DECIMALS: u8 = 2;
const MORE: f64 = 100.0;

/// The magnitude of one sensor's vector, √(x² + y² + z²).
#[derive(Debug, Clone)]
pub struct Magnitude {
    /// The quantity of the vector.
    pub quantity: Quantity,
    /// Unit of the magnitude.
    pub unit: String,
    /// A count of 1 is 10^-`decimals` · `scale` units.
    pub decimals: u8,
    /// The scale, as that of [`Channel::scale`].
    pub scale: f64,
    /// Mean, spread and extremes, in counts.
    pub moments: Moments,
    /// Place of the x axis in a row; y and z follow.
    first: usize,
    /// Factors from the counts of each axis to those of the magnitude.
    factors: [f64; 3],
    factor: f64,
}

impl Magnitude {
    /// One for every three neighbouring channels of one sensor. Axes of different decimals or
    /// scales, each of which uses all 32 bits, are summed in units of two of the coarsest counts.
    pub(crate) fn all(layout: &Layout) -> Vec<Self> {
        let vectors = layout.channels.windows(3).enumerate().filter_map(|(first, axes)| {
            let [x, y, z] = axes else { return None };
            let quantity = x.quantity;
            let begins = first == 0 || layout.channels[first - 1].quantity != quantity;
            let is_vector = sensor_of(quantity).is_some() && [y, z].map(|axis| axis.quantity) == [quantity; 2];
            let is_alike = |other: &Channel| (other.decimals, other.scale) == (x.decimals, x.scale);
            let (decimals, scale, factors, factor) = if x.decimals > 0 && is_alike(y) && is_alike(z) {
                (x.decimals + MORE_DECIMALS, x.scale, [1.0; 3], MORE)
            } else {
                let units = [x, y, z].map(|axis| axis.in_unit(1.0));
                let coarsest = 2.0 * units.into_iter().fold(0.0, f64::max);
                (0, coarsest, units.map(|unit| unit / coarsest), 1.0)
            };
            let (unit, moments) = (x.unit.to_string(), Moments::new());
            (begins && is_vector).then_some(Self { quantity, unit, decimals, scale, moments, first, factors, factor })
        });
        vectors.collect()
    }

    /// Places of the three axes in a row.
    pub(crate) fn axes(&self) -> Range<usize> {
        self.first..self.first + 3
    }

    /// Adds frame-major rows of `width` counts; `column` is scratch memory.
    pub(crate) fn push(&mut self, counts: &[i32], width: usize, column: &mut Vec<i32>) {
        let Self { factors, factor, .. } = *self;
        column.clear();
        // each begins with the three axes
        column.extend(counts.get(self.first..).unwrap_or_default().chunks(width).map(|axes| {
            let axes: [i32; 3] = axes.first_chunk().copied().unwrap_or_default();
            let [x, y, z] = [0, 1, 2].map(|axis| factors[axis] * f64::from(axes[axis]));
            // rounded, as none is negative; magnitudes beyond the range of a count saturate
            (factor * (x * x + y * y + z * z).sqrt() + 0.5) as i32
        }));
        self.moments.push(column);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
        let counts = [3 << 29, 6 << 28, -14 << 27];
        magnitude.push(&counts, 3, &mut Vec::new());
        let length = f64::from(magnitude.moments.max_counts().unwrap()) * magnitude.scale;
        assert!((length - 15.305_227_86_f64).abs() < 1e-7, "{length}");
        assert_eq!(magnitude.decimals, 0);
    }

    #[test]
    fn lengths_are_those_of_pythagoras() {
        let mut magnitude = Magnitude::all(&VNYMR).remove(1);
        let mut row = [0; 12];
        row[6..9].copy_from_slice(&[2000, 3000, 6000]);
        let mut rows = row.to_vec();
        row[6..9].copy_from_slice(&[0, 0, -1]);
        rows.extend(row);
        magnitude.push(&rows, 12, &mut Vec::new());
        assert_eq!((magnitude.moments.count(), magnitude.decimals), (2, 5));
        assert_eq!((magnitude.moments.min_counts(), magnitude.moments.max_counts()), (Some(100), Some(700_000)));
    }
}
