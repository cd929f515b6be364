//! The samples as ROS 2 messages in an MCAP file: `Imu`, `MagneticField`, `Temperature` and
//! `FluidPressure` of `sensor_msgs/msg`, in plain CDR.
//!
//! Axes and frame are those of the sensor, x forward, y right, z down, with the orientation against
//! north, east, down; or both are converted to what ROS assumes (REP 103).

mod stamps;

use std::{collections::BTreeMap, io::Write};

use mcap::{
    Compression, WriteOptions, Writer,
    records::{MessageHeader, Metadata},
    write::NoSeek,
};
use thiserror::Error;
use vn100_analysis::EndKind;
use vn100_analysis::noise::{Status, Term};
use vn100_analysis::protocol::{Layout, Quantity, stream::Batch};

use self::stamps::Clock;
pub use self::stamps::Stamps;
use crate::measured::Record;

/// The topic of the samples as `sensor_msgs/msg/Imu`.
pub(crate) const IMU_TOPIC: &str = "/imu/data";

const TESLA_PER_GAUSS: f64 = 1e-4;
const PASCAL_PER_KILOPASCAL: f64 = 1e3;

/// The axes of vectors, and the reference of the orientation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RosFrame {
    /// Those of the sensor: forward, right, down, against north, east, down.
    #[default]
    Ned,
    /// Forward, left, up, against east, north, up: a level sensor at rest has +9.8 m/s² on z, and a
    /// yaw of 90° where the sensor reports 0°.
    Enu,
}

impl RosFrame {
    /// Names the body's axes.
    const fn id(self) -> &'static str {
        match self {
            Self::Ned => "vn100_frd",
            Self::Enu => "vn100_flu",
        }
    }

    /// A diagonal covariance is the same in both.
    fn vector(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Ned => [x, y, z],
            Self::Enu => [x, -y, -z],
        }
    }

    /// Of x, y, z, w. Half turns: of the world about the axis between north and east, of the body
    /// about its own x.
    fn quaternion(self, [x, y, z, w]: [f64; 4]) -> [f64; 4] {
        match self {
            Self::Ned => [x, y, z, w],
            Self::Enu => [x + y, x - y, w - z, w + z].map(|part| part * std::f64::consts::FRAC_1_SQRT_2),
        }
    }
}

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
const TEMPERATURE: &str = "std_msgs/Header header
float64 temperature
float64 variance";
const PRESSURE: &str = "std_msgs/Header header
float64 fluid_pressure
float64 variance";
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

/// A file that is being written. It takes the batches of the capture in a second reading from the
/// beginning, because the time base of the result is needed for the first message. Memory is that
/// of one chunk of the file.
pub struct Ros2Messages<W: Write> {
    mcap: Writer<NoSeek<W>>,
    imu: u16,
    magnetic_field: u16,
    temperature: Option<u16>,
    pressure: Option<u16>,
    frame: RosFrame,
    clock: Clock,
    samples: u64,
    /// Where the measurement ended, if that was before the end of the capture.
    most_samples: Option<u64>,
    rate_covariance: [f64; 9],
    acceleration_covariance: [f64; 9],
    metadata: BTreeMap<String, String>,
}

type MeasuredVector = Option<[f64; 3]>;

impl<W: Write> Ros2Messages<W> {
    /// The file of the capture that `record` was measured from, written by `program`, such as
    /// `vn100 1.0.0`.
    ///
    /// # Errors
    /// [`Ros2Error`] when `out` cannot be written to.
    pub fn new(out: W, record: &Record<'_>, program: &str, frame: RosFrame, stamps: Stamps) -> Result<Self, Ros2Error> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(program)
            .compression(Some(Compression::Zstd))
            .disable_seeking(true);
        let mut mcap = options.create(NoSeek::new(out))?;
        let mut channel = |name: &str, schema: &str, topic: &str| {
            let schema = mcap.add_schema(name, "ros2msg", format!("{schema}{HEADER}").as_bytes())?;
            mcap.add_channel(schema, topic, "cdr", &BTreeMap::new())
        };
        let imu = channel("sensor_msgs/msg/Imu", IMU, IMU_TOPIC)?;
        let magnetic_field = channel("sensor_msgs/msg/MagneticField", MAGNETIC_FIELD, "/imu/mag")?;
        let has = |quantity| !record.of(quantity).is_empty();
        let mut where_measured = |quantity, name, schema, topic| {
            if has(quantity) { channel(name, schema, topic).map(Some) } else { Ok(None) }
        };
        let temperature =
            where_measured(Quantity::Temperature, "sensor_msgs/msg/Temperature", TEMPERATURE, "/imu/temperature")?;
        let pressure = where_measured(Quantity::Pressure, "sensor_msgs/msg/FluidPressure", PRESSURE, "/imu/pressure")?;
        let frame_text = match frame {
            RosFrame::Ned => "body forwards, right, down; orientation against north, east, down",
            RosFrame::Enu => "body forwards, left, up; orientation against east, north, up (REP 103)",
        };
        let measured = record.measured;
        let timing = &measured.snapshot.timing;
        let is_cut = measured.facts.end == Some(EndKind::Duration);
        let unknown = || "not recorded".to_owned();
        let entries = [
            ("capture", measured.facts.name.clone()),
            ("sha256", measured.facts.file.as_ref().map_or_else(unknown, |file| file.sha256.clone())),
            ("message", measured.snapshot.layout.as_ref().map_or_else(unknown, |layout| layout.message.to_string())),
            ("frame", frame_text.into()),
            ("units", "rad/s, m/s^2, tesla, degrees Celsius, pascal".into()),
            (
                "covariances",
                "rate and acceleration: N^2 * rate per axis; zero where N is not estimated on each; orientation and field unknown (zero); -1 first where there is no such quantity"
                    .into(),
            ),
        ];
        Ok(Self {
            mcap,
            imu,
            magnetic_field,
            temperature,
            pressure,
            frame,
            clock: Clock::new(record, stamps),
            samples: 0,
            most_samples: is_cut.then_some(timing.samples + timing.excluded + record.measured.snapshot.false_times),
            rate_covariance: covariance(record, Quantity::AngularRate),
            acceleration_covariance: covariance(record, Quantity::Acceleration),
            metadata: entries.into_iter().map(|(name, value)| (name.to_owned(), value)).collect(),
        })
    }

    /// Takes the next batch of the capture.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn push(&mut self, batch: &Batch) -> Result<(), Ros2Error> {
        let Some(layout) = &batch.layout else { return Ok(()) };
        for (row, counts) in batch.rows().enumerate() {
            if self.most_samples.is_some_and(|most| self.samples >= most) {
                return Ok(());
            }
            let arrival =
                batch.arrivals.iter().rev().find(|arrival| arrival.from_row <= row).map(|arrival| arrival.at_ns);
            let at_ns = self.clock.stamp(self.samples, arrival, batch.device_ns.get(row).copied());
            self.sample(layout, counts, |channel| batch.is_absent(row, channel), at_ns)?;
            self.samples += 1;
        }
        Ok(())
    }

    /// A vector that lacks a component is not written.
    fn sample(
        &mut self,
        layout: &Layout,
        counts: &[i32],
        is_absent: impl Fn(usize) -> bool,
        at_ns: u64,
    ) -> Result<(), Ros2Error> {
        let frame = self.frame;
        let vector = |quantity| -> MeasuredVector { values(layout, counts, &is_absent, quantity) };
        let turned = |quantity| vector(quantity).map(|axes| frame.vector(axes));
        let (rate, acceleration) = (turned(Quantity::AngularRate), turned(Quantity::Acceleration));
        if rate.is_some() || acceleration.is_some() {
            let mut message = Cdr::new(at_ns, frame.id());
            let orientation = vector(Quantity::Angle)
                .map(quaternion)
                .or_else(|| values(layout, counts, &is_absent, Quantity::Quaternion))
                .map(|attitude| frame.quaternion(attitude));
            message.floats(&orientation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
            message.floats(if orientation.is_some() { &UNKNOWN } else { &NOT_PROVIDED });
            for (vector, covariance) in [(rate, &self.rate_covariance), (acceleration, &self.acceleration_covariance)] {
                message.floats(&vector.unwrap_or_default());
                message.floats(if vector.is_some() { covariance } else { &NOT_PROVIDED });
            }
            self.write(self.imu, at_ns, &message.bytes)?;
        }
        if let Some(field) = turned(Quantity::MagneticField) {
            let mut message = Cdr::new(at_ns, frame.id());
            message.floats(&field.map(|gauss| gauss * TESLA_PER_GAUSS));
            message.floats(&UNKNOWN);
            self.write(self.magnetic_field, at_ns, &message.bytes)?;
        }
        for (quantity, channel, factor) in
            [(Quantity::Temperature, self.temperature, 1.0), (Quantity::Pressure, self.pressure, PASCAL_PER_KILOPASCAL)]
        {
            if let (Some(channel), Some([value])) = (channel, values(layout, counts, &is_absent, quantity)) {
                let mut message = Cdr::new(at_ns, frame.id());
                let unknown_variance = 0.0;
                message.floats(&[value * factor, unknown_variance]);
                self.write(channel, at_ns, &message.bytes)?;
            }
        }
        Ok(())
    }

    fn write(&mut self, channel_id: u16, at_ns: u64, message: &[u8]) -> Result<(), Ros2Error> {
        let sequence = u32::try_from(self.samples).unwrap_or(u32::MAX);
        let header = MessageHeader { channel_id, sequence, log_time: at_ns, publish_time: at_ns };
        Ok(self.mcap.write_to_known_channel(&header, message)?)
    }

    /// Ends the file, and returns its writer.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<W, Ros2Error> {
        let mut metadata = std::mem::take(&mut self.metadata);
        metadata.insert("stamps".into(), self.clock.text());
        self.mcap.write_metadata(&Metadata { name: "vn100.decoded".into(), metadata })?;
        self.mcap.finish()?;
        Ok(self.mcap.into_inner().into_inner())
    }
}

/// The values of a quantity in a row; `None` where one of them is missing.
fn values<const N: usize>(
    layout: &Layout,
    counts: &[i32],
    is_absent: impl Fn(usize) -> bool,
    quantity: Quantity,
) -> Option<[f64; N]> {
    let cells = layout.channels.iter().zip(counts).enumerate();
    let axes = cells.filter(|(_, (channel, _))| channel.quantity == quantity).take(N);
    let values: Option<Vec<f64>> =
        axes.map(|(place, (channel, count))| (!is_absent(place)).then(|| channel.value(*count))).collect();
    values?.try_into().ok()
}

/// The variance of a sample by the white noise of its axis, N² times its rate, on the diagonal;
/// unknown unless N is estimated on all three.
fn covariance(record: &Record<'_>, quantity: Quantity) -> [f64; 9] {
    let variances: Option<Vec<f64>> = (record.of(quantity).into_iter())
        .map(|channel| {
            let white = channel.noise.as_ref()?.parameter(Term::White)?;
            Some(white.value.filter(|_| white.status == Status::Estimated)?.powi(2) * channel.rate_hz)
        })
        .collect();
    match variances.as_deref() {
        Some(&[x, y, z]) => [x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z],
        _ => UNKNOWN,
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

    fn product([ax, ay, az, aw]: [f64; 4], [bx, by, bz, bw]: [f64; 4]) -> [f64; 4] {
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ]
    }

    fn rotated(q: [f64; 4], [x, y, z]: [f64; 3]) -> [f64; 3] {
        let conjugate = [-q[0], -q[1], -q[2], q[3]];
        let [x, y, z, _] = product(product(q, [x, y, z, 0.0]), conjugate);
        [x, y, z]
    }

    #[test]
    fn turned_vectors_point_the_same_way_in_the_turned_world() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        assert_eq!(RosFrame::Enu.vector([0.1, 0.2, -9.8]), [0.1, -0.2, 9.8], "level at rest, z up");
        let north = RosFrame::Enu.quaternion([0.0, 0.0, 0.0, 1.0]);
        assert!(north.iter().zip([0.0, 0.0, half, half]).all(|(a, b)| (a - b).abs() < 1e-15), "yaw 90: {north:?}");
        for angles in [[0.0, 0.0, 0.0], [30.0, -20.0, 70.0], [-170.0, 80.0, -120.0]] {
            let attitude = quaternion(angles);
            let turned = RosFrame::Enu.quaternion(attitude);
            assert!((turned.iter().map(|part| part * part).sum::<f64>() - 1.0).abs() < 1e-12);
            for vector in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, -0.4, 0.5]] {
                let [north, east, down] = rotated(attitude, vector);
                let found = rotated(turned, RosFrame::Enu.vector(vector));
                let expected = [east, north, -down];
                assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{angles:?} {found:?}");
            }
        }
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
