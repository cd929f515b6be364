//! The samples that the sensor reports as measured with an axis at the end of its range.

use std::time::Duration;

/// Names of the axes by their bits (VN-100 User Manual, binary output group IMU, SensSat).
const AXES: [&str; 10] =
    ["mag_x", "mag_y", "mag_z", "accel_x", "accel_y", "accel_z", "gyro_x", "gyro_y", "gyro_z", "pressure"];

/// Number and times of the saturated samples of a record.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Saturation {
    /// Samples with any axis at the end of its range.
    pub samples: u64,
    /// Number of such samples by axis, in the order of the bits.
    by_axis: [u64; AXES.len()],
    /// Data time of the first such sample; `None` without one.
    pub first_at: Option<Duration>,
    /// Data time of the last such sample; `None` without one.
    pub last_at: Option<Duration>,
}

impl Saturation {
    pub(crate) fn push(&mut self, axes: u16, at: Duration) {
        self.samples += 1;
        for (bit, count) in self.by_axis.iter_mut().enumerate() {
            *count += u64::from(axes >> bit & 1);
        }
        self.first_at.get_or_insert(at);
        self.last_at = Some(at);
    }

    /// The axes that were at the end of their range, each with its number of samples.
    pub fn axes(&self) -> impl Iterator<Item = (&'static str, u64)> {
        AXES.into_iter().zip(self.by_axis).filter(|(_, count)| *count > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_counted_by_name_and_time() {
        let mut saturation = Saturation::default();
        assert_eq!((saturation.axes().count(), saturation.first_at), (0, None));
        saturation.push(0x48, Duration::from_secs(3));
        saturation.push(0x40, Duration::from_secs(5));
        assert_eq!(saturation.axes().collect::<Vec<_>>(), [("accel_x", 1), ("gyro_x", 2)]);
        let times = (saturation.first_at, saturation.last_at);
        assert_eq!((saturation.samples, times), (2, (Some(Duration::from_secs(3)), Some(Duration::from_secs(5)))));
        // a bit without an axis counts as a sample
        saturation.push(0x8000, Duration::from_secs(6));
        assert_eq!((saturation.samples, saturation.axes().count()), (3, 2));
    }
}
