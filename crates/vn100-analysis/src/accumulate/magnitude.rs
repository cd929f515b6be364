//! The magnitude of the measured vectors, sample by sample: it does not depend on the orientation.

use imu_noise::Moments;
use vn100_protocol::{Channel, Layout, Quantity};

use crate::sensor::sensor_of;

/// Decimals of a magnitude beyond those of its components.
const MORE_DECIMALS: u8 = 2;

/// The length of one sensor's vector.
#[derive(Debug, Clone)]
pub struct Magnitude {
    /// What the vector is of.
    pub quantity: Quantity,
    /// Unit of the length.
    pub unit: String,
    /// A count of 1 is 10^-`decimals` · `scale` units.
    pub decimals: u8,
    /// As [`Channel::scale`].
    pub scale: f64,
    /// Mean, spread and extremes, in counts.
    pub moments: Moments,
    /// Place of the first of its three axes in a row.
    first: usize,
}

impl Magnitude {
    /// For every three neighbouring channels of one sensor with the same decimals and scale.
    pub(crate) fn all(layout: &Layout) -> Vec<Self> {
        let vectors = layout.channels.windows(3).enumerate().filter_map(|(first, axes)| {
            let [x, y, z] = axes else { return None };
            let quantity = x.quantity;
            let is_vector = sensor_of(quantity).is_some();
            let alike = |other: &Channel| {
                (other.quantity, other.decimals, other.scale) == (quantity, x.decimals, x.scale) && is_vector
            };
            let begins = first == 0 || layout.channels[first - 1].quantity != quantity;
            (begins && alike(y) && alike(z)).then(|| Self {
                quantity,
                unit: x.unit.to_string(),
                decimals: x.decimals + MORE_DECIMALS,
                scale: x.scale,
                moments: Moments::new(),
                first,
            })
        });
        vectors.collect()
    }

    /// Takes frame-major rows of `width` counts; `column` is for its own use.
    pub(crate) fn push(&mut self, counts: &[i32], width: usize, column: &mut Vec<i32>) {
        const MORE: f64 = 100.0;
        column.clear();
        column.extend(counts.chunks_exact(width).map(|row| {
            let [x, y, z] = [0, 1, 2].map(|axis| f64::from(row[self.first + axis]));
            // magnitudes beyond the range of a count saturate
            (MORE * (x * x + y * y + z * z).sqrt()).round() as i32
        }));
        self.moments.push(column);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vn100_protocol::{VNIMU, VNYMR};

    #[test]
    fn every_vector_of_a_message_has_a_length() {
        let quantities = |layout| Magnitude::all(layout).iter().map(|magnitude| magnitude.quantity).collect::<Vec<_>>();
        let expected = [Quantity::MagneticField, Quantity::Acceleration, Quantity::AngularRate];
        assert_eq!(quantities(&VNYMR), expected);
        assert_eq!(quantities(&VNIMU), expected);
    }

    #[test]
    fn three_axes_of_one_sensor_with_the_same_decimals_and_scale_are_a_vector() {
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
            assert_eq!(with(|axis| axis.decimals += 1), 0, "axis {axis}");
            assert_eq!(with(|axis| axis.scale *= 2.0), 0, "axis {axis}");
            assert_eq!(with(|axis| axis.quantity = Quantity::Temperature), 0, "axis {axis}");
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
        magnitude.push(&rows, 12, &mut Vec::new());
        assert_eq!((magnitude.moments.count(), magnitude.decimals), (2, 5));
        assert_eq!((magnitude.moments.min_counts(), magnitude.moments.max_counts()), (Some(100), Some(700_000)));
    }
}
