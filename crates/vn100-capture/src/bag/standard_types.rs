//! The standard messages of sensors, and those of the driver for VectorNav sensors: their definitions, for bags without
//! any, and the numbers that are channels.
//!
//! Units and conventions: <https://www.ros.org/reps/rep-0103.html> and the comments in the
//! definitions of `sensor_msgs`.

use super::topic::Encoding;
use crate::csv::{names, quantity_word};

pub(super) const IMU: &str = "sensor_msgs/Imu";
pub(super) const MAGNETIC_FIELD: &str = "sensor_msgs/MagneticField";
pub(super) const TEMPERATURE: &str = "sensor_msgs/Temperature";
pub(super) const FLUID_PRESSURE: &str = "sensor_msgs/FluidPressure";

/// Messages of the ROS 2 driver for VectorNav sensors: the fields of their binary outputs.
const IMU_GROUP: &str = "vectornav_msgs/ImuGroup";
const COMMON_GROUP: &str = "vectornav_msgs/CommonGroup";

/// Numbers of a standard message that are present together or not at all.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) message: &'static str,
    /// The quantity of their channels, as written in names of streams.
    pub(super) channel: &'static str,
    /// The field that holds the numbers.
    pub(super) field: &'static str,
}

impl Part {
    /// The channels, and the paths of their numbers.
    pub(super) fn channels(&self) -> impl Iterator<Item = (usize, String)> {
        let of_quantity = names().enumerate().filter(|(_, name)| quantity_word(name) == self.channel);
        of_quantity.map(|(channel, name)| match name.split_once('_') {
            Some((_, axis)) => (channel, format!("{}.{axis}", self.field)),
            None => (channel, self.field.to_owned()),
        })
    }

    /// The unit of the numbers, by name; `None` for the channels' own.
    pub(super) fn unit(&self) -> Option<&'static str> {
        match self.message {
            MAGNETIC_FIELD => Some("T"),
            FLUID_PRESSURE => Some("Pa"),
            _ => None,
        }
    }

    /// Whether the sensor has compensated the numbers; `None` if the message does not say so.
    pub(super) fn compensated(&self) -> Option<bool> {
        let is_of_vectornav = self.message == IMU_GROUP || self.message == COMMON_GROUP;
        is_of_vectornav.then_some(matches!(self.field, "accel" | "angularrate"))
    }

    /// The path of their covariance: -1 in its first element means that the sensor does not measure
    /// them.
    pub(super) fn covariance(&self) -> Option<String> {
        (self.message == IMU).then(|| format!("{}_covariance[0]", self.field))
    }
}

/// In a message with several parts of one channel, the first is preferred; it is not compensated.
pub(super) const PARTS: [Part; 18] = [
    Part { message: IMU, channel: "quat", field: "orientation" },
    Part { message: IMU, channel: "accel", field: "linear_acceleration" },
    Part { message: IMU, channel: "gyro", field: "angular_velocity" },
    Part { message: MAGNETIC_FIELD, channel: "mag", field: "magnetic_field" },
    Part { message: TEMPERATURE, channel: "temperature", field: "temperature" },
    Part { message: FLUID_PRESSURE, channel: "pressure", field: "fluid_pressure" },
    Part { message: IMU_GROUP, channel: "mag", field: "uncompmag" },
    Part { message: IMU_GROUP, channel: "accel", field: "uncompaccel" },
    Part { message: IMU_GROUP, channel: "gyro", field: "uncompgyro" },
    Part { message: IMU_GROUP, channel: "accel", field: "accel" },
    Part { message: IMU_GROUP, channel: "gyro", field: "angularrate" },
    Part { message: IMU_GROUP, channel: "temperature", field: "temp" },
    Part { message: IMU_GROUP, channel: "pressure", field: "pres" },
    Part { message: COMMON_GROUP, channel: "mag", field: "magpres_mag" },
    Part { message: COMMON_GROUP, channel: "accel", field: "imu_accel" },
    Part { message: COMMON_GROUP, channel: "gyro", field: "imu_rate" },
    Part { message: COMMON_GROUP, channel: "accel", field: "accel" },
    Part { message: COMMON_GROUP, channel: "gyro", field: "angularrate" },
];

/// The definition of a standard type in the language of its encoding.
pub(super) fn definition(type_name: &str, encoding: &Encoding) -> Option<String> {
    const VECTOR: &str = "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
    const QUATERNION: &str = "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";
    let fields = match type_name {
        IMU => {
            "geometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
             geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
             geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n"
        }
        MAGNETIC_FIELD => "geometry_msgs/Vector3 magnetic_field\nfloat64[9] magnetic_field_covariance\n",
        TEMPERATURE => "float64 temperature\nfloat64 variance\n",
        FLUID_PRESSURE => "float64 fluid_pressure\nfloat64 variance\n",
        _ => return None,
    };
    let header = match encoding {
        Encoding::Ros1 => "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n",
        Encoding::Cdr | Encoding::Other(_) => "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n",
    };
    Some(["std_msgs/Header header\n", fields, VECTOR, QUATERNION, header].concat())
}
