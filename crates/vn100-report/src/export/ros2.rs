//! The samples as ROS 2 messages in an MCAP file: `sensor_msgs/msg/Imu` and
//! `sensor_msgs/msg/MagneticField`, in plain CDR.
//!
//! Axes and frame are the sensor's own: x forwards, y to the right, z down; the orientation is
//! against north, east, down.

use std::{collections::BTreeMap, io::Write};

use mcap::{
    Compression, WriteOptions, Writer,
    records::{MessageHeader, Metadata},
    write::NoSeek,
};
use thiserror::Error;
use vn100_analysis::protocol::{Layout, Quantity, stream::Batch};

use crate::measured::Record;

const FRAME: &str = "vn100";
const TESLA_PER_GAUSS: f64 = 1e-4;

/// As the public interface packages define them.
const HEADER: &str = "
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
";
const IMU: &str = "std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
================================================================================
MSG: geometry_msgs/Quaternion
float64 x 0
float64 y 0
float64 z 0
float64 w 1";
const MAGNETIC_FIELD: &str = "std_msgs/Header header
geometry_msgs/Vector3 magnetic_field
float64[9] magnetic_field_covariance";

/// REP 145: all zeros for a covariance that is not known.
const UNKNOWN: [f64; 9] = [0.0; 9];

/// Sensor messages: -1 in the first place for a quantity that is not provided.
const NOT_PROVIDED: [f64; 9] = [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];

/// The file cannot be written.
#[derive(Debug, Error)]
#[error(transparent)]
pub struct Ros2Error(#[from] mcap::McapError);

/// A file that is being written: takes the batches of the capture once more, from its beginning, as
/// the time base of the result is in it. Memory is that of one chunk of the file.
pub struct Ros2Messages<W: Write> {
    mcap: Writer<NoSeek<W>>,
    imu: u16,
    magnetic_field: u16,
    rate_hz: f64,
    samples: u64,
    /// Of the first row; the stamps of a capture may begin anywhere, before 1970 too.
    origin_ns: Option<i64>,
    stamped: bool,
}

type MeasuredVector = Option<[f64; 3]>;

impl<W: Write> Ros2Messages<W> {
    /// Of the capture behind `record`, by `program`, such as `vn100 1.0.0`.
    ///
    /// # Errors
    /// When `out` cannot be written to.
    pub fn new(out: W, record: &Record<'_>, program: &str) -> Result<Self, Ros2Error> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(program)
            .compression(Some(Compression::Zstd))
            .disable_seeking(true);
        let mut mcap = options.create(NoSeek::new(out))?;
        let stamped = record.measured.snapshot.arrivals.is_some();
        let rate_hz = record.measured.snapshot.timing.rate_hz;
        let imu = mcap.add_schema("sensor_msgs/msg/Imu", "ros2msg", format!("{IMU}{HEADER}").as_bytes())?;
        let field = mcap.add_schema(
            "sensor_msgs/msg/MagneticField",
            "ros2msg",
            format!("{MAGNETIC_FIELD}{HEADER}").as_bytes(),
        )?;
        let imu = mcap.add_channel(imu, "/imu/data", "cdr", &BTreeMap::new())?;
        let magnetic_field = mcap.add_channel(field, "/imu/mag", "cdr", &BTreeMap::new())?;
        let stamps = if stamped {
            "when the read that completed the line arrived, as the capture has it".to_owned()
        } else {
            format!("number of the sample / {rate_hz} Hz from 0: the capture has no arrival times")
        };
        let entries = [
            ("capture", record.measured.facts.name.clone()),
            (
                "sha256",
                record.measured.facts.file.as_ref().map_or_else(|| "not recorded".into(), |file| file.sha256.clone()),
            ),
            (
                "message",
                record.measured.snapshot.layout.as_ref().map_or_else(String::new, |layout| layout.message.to_string()),
            ),
            ("stamps", stamps),
            ("frame", "axes of the sensor: x forwards, y right, z down; orientation against north, east, down".into()),
            ("units", "rad/s, m/s^2, tesla".into()),
            ("covariances", "zero where unknown (REP 145), -1 first where there is no orientation".into()),
        ];
        let metadata = entries.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        mcap.write_metadata(&Metadata { name: "vn100.decoded".into(), metadata })?;
        Ok(Self { mcap, imu, magnetic_field, rate_hz, samples: 0, origin_ns: None, stamped })
    }

    /// Takes the next batch of the capture.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn push(&mut self, batch: &Batch) -> Result<(), Ros2Error> {
        let Some(layout) = &batch.layout else { return Ok(()) };
        for (row, counts) in batch.rows().enumerate() {
            let arrival =
                batch.arrivals.iter().rev().find(|arrival| arrival.from_row <= row).map(|arrival| arrival.at_ns);
            let at_ns = self.stamp(arrival);
            self.sample(layout, counts, |channel| batch.is_absent(row, channel), at_ns)?;
            self.samples += 1;
        }
        Ok(())
    }

    /// Stamps before 1970 are those of a capture without a date: they begin at 0.
    fn stamp(&mut self, arrival_ns: Option<i64>) -> u64 {
        let by_number = (self.samples as f64 / self.rate_hz * 1e9).round() as u64;
        let Some(arrival_ns) = arrival_ns.filter(|_| self.stamped) else { return by_number };
        let origin_ns = *self.origin_ns.get_or_insert(arrival_ns);
        let from = if origin_ns < 0 { origin_ns } else { 0 };
        u64::try_from(arrival_ns.saturating_sub(from)).unwrap_or(0)
    }

    /// A vector that lacks a component is not written.
    fn sample(
        &mut self,
        layout: &Layout,
        counts: &[i32],
        is_absent: impl Fn(usize) -> bool,
        at_ns: u64,
    ) -> Result<(), Ros2Error> {
        let of = |quantity: Quantity| -> MeasuredVector {
            let cells = layout.channels.iter().zip(counts).enumerate();
            let axes = cells.filter(|(_, (channel, _))| channel.quantity == quantity).take(3);
            let values: Option<Vec<f64>> =
                axes.map(|(place, (channel, count))| (!is_absent(place)).then(|| channel.value(*count))).collect();
            values?.try_into().ok()
        };
        let (rate, acceleration) = (of(Quantity::AngularRate), of(Quantity::Acceleration));
        if rate.is_some() || acceleration.is_some() {
            let mut message = Cdr::new(at_ns, FRAME);
            let orientation = of(Quantity::Angle).map(quaternion);
            message.floats(&orientation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
            message.floats(if orientation.is_some() { &UNKNOWN } else { &NOT_PROVIDED });
            for vector in [rate, acceleration] {
                message.floats(&vector.unwrap_or_default());
                message.floats(if vector.is_some() { &UNKNOWN } else { &NOT_PROVIDED });
            }
            self.write(self.imu, at_ns, &message.bytes)?;
        }
        if let Some(field) = of(Quantity::MagneticField) {
            let mut message = Cdr::new(at_ns, FRAME);
            message.floats(&field.map(|gauss| gauss * TESLA_PER_GAUSS));
            message.floats(&UNKNOWN);
            self.write(self.magnetic_field, at_ns, &message.bytes)?;
        }
        Ok(())
    }

    fn write(&mut self, channel_id: u16, at_ns: u64, message: &[u8]) -> Result<(), Ros2Error> {
        let sequence = u32::try_from(self.samples).unwrap_or(u32::MAX);
        let header = MessageHeader { channel_id, sequence, log_time: at_ns, publish_time: at_ns };
        Ok(self.mcap.write_to_known_channel(&header, message)?)
    }

    /// Ends the file; gives back what it was written to.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<W, Ros2Error> {
        self.mcap.finish()?;
        Ok(self.mcap.into_inner().into_inner())
    }
}

/// x, y, z, w of the rotation from the body to north, east, down: yaw about z, then pitch about y,
/// then roll about x, in degrees.
fn quaternion([yaw, pitch, roll]: [f64; 3]) -> [f64; 4] {
    let [(sy, cy), (sp, cp), (sr, cr)] = [yaw, pitch, roll].map(|angle| (angle.to_radians() / 2.0).sin_cos());
    [sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy]
}

/// The header of every message: the encoding, and two bytes of options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A message being written; numbers are aligned to their size, counted from the end of the
/// encapsulation.
struct Cdr {
    bytes: Vec<u8>,
}

impl Cdr {
    /// With its `std_msgs/msg/Header`: the time in nanoseconds, and the frame.
    fn new(stamp_ns: u64, frame: &str) -> Self {
        const SECOND_NS: u64 = 1_000_000_000;
        let mut message = Self { bytes: ENCAPSULATION.to_vec() };
        // seconds are an int32 there: enough until 2038
        message.put(&i32::try_from(stamp_ns / SECOND_NS).unwrap_or(i32::MAX).to_le_bytes());
        message.put(&((stamp_ns % SECOND_NS) as u32).to_le_bytes());
        message.put(&(frame.len() as u32 + 1).to_le_bytes());
        message.bytes.extend(frame.as_bytes());
        message.bytes.push(0);
        message
    }

    fn floats(&mut self, values: &[f64]) {
        for value in values {
            self.put(&value.to_le_bytes());
        }
    }

    fn put(&mut self, number: &[u8]) {
        while !(self.bytes.len() - ENCAPSULATION.len()).is_multiple_of(number.len()) {
            self.bytes.push(0);
        }
        self.bytes.extend(number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_about_one_axis_are_half_angles_there() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        for (angles, expected) in [
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]),
            ([90.0, 0.0, 0.0], [0.0, 0.0, half, half]),
            ([0.0, 90.0, 0.0], [0.0, half, 0.0, half]),
            ([0.0, 0.0, 180.0], [1.0, 0.0, 0.0, 0.0]),
        ] {
            let found = quaternion(angles);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{angles:?}: {found:?}");
        }
        // body x after yaw 90 and pitch 90 points up: rotate (1, 0, 0) by q
        let [x, y, z, w] = quaternion([90.0, 90.0, 0.0]);
        let forwards = [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)];
        assert!((forwards[2] + 1.0).abs() < 1e-12, "{forwards:?}");
    }

    #[test]
    fn numbers_stand_where_their_size_asks() {
        let mut message = Cdr::new(1_500_000_002_000_000_003, "imu");
        message.floats(&[1.0]);
        let bytes = message.bytes;
        assert_eq!(bytes[4..8], 1_500_000_002_i32.to_le_bytes());
        assert_eq!(bytes[8..12], 3_u32.to_le_bytes());
        assert_eq!(bytes[12..20], *b"\x04\0\0\0imu\0");
        assert_eq!(bytes[20..28], 1.0_f64.to_le_bytes(), "16 bytes in, no filling");
        let mut padded = Cdr::new(0, "vn100");
        padded.floats(&[2.0]);
        assert_eq!(padded.bytes[28..36], 2.0_f64.to_le_bytes(), "18 bytes in, filled to 24");
    }
}
