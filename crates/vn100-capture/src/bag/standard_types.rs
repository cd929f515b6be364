//! The standard messages of sensors, and those of the driver for VectorNav sensors: their definitions, for bags without
//! any, and the numbers that are channels.
//!
//! Units and conventions: <https://www.ros.org/reps/rep-0103.html> and the comments in the
//! definitions of `sensor_msgs`.

use super::topic::Encoding;

pub(super) const IMU: &str = "sensor_msgs/Imu";
pub(super) const MAGNETIC_FIELD: &str = "sensor_msgs/MagneticField";
pub(super) const TEMPERATURE: &str = "sensor_msgs/Temperature";
pub(super) const FLUID_PRESSURE: &str = "sensor_msgs/FluidPressure";

/// Messages of the ROS 2 driver for VectorNav sensors: the fields of their binary outputs.
const IMU_GROUP: &str = "vectornav_msgs/ImuGroup";
const COMMON_GROUP: &str = "vectornav_msgs/CommonGroup";

/// Numbers of a standard message that are present together or not at all.
pub(super) struct Part {
    pub(super) message: &'static str,
    /// The prefix of the names of their channels.
    pub(super) channel: &'static str,
    /// The field that holds the numbers.
    pub(super) field: &'static str,
    /// The axes, a letter for each; empty if the field is itself the number.
    axes: &'static str,
    /// The unit of the message in units of the channel.
    pub(super) unit_scale: f64,
    /// A count is 2^-`bits` of the unit of the message: all bits that the range of a sensor leaves
    /// of 32 (64 rad/s, 256 m/s², 2 mT, 256 °C, 262 kPa).
    pub(super) bits: u8,
}

impl Part {
    /// The channels, and the paths of their numbers.
    pub(super) fn channels(&self) -> impl Iterator<Item = (String, String)> {
        let Self { channel, field, axes, .. } = self;
        let whole = axes.is_empty().then(|| (channel.to_string(), field.to_string()));
        whole.into_iter().chain(axes.chars().map(move |axis| (format!("{channel}_{axis}"), format!("{field}.{axis}"))))
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

pub(super) const PARTS: [Part; 18] = [
    Part { message: IMU, channel: "quat", field: "orientation", axes: "xyzw", unit_scale: 1.0, bits: 30 },
    Part { message: IMU, channel: "accel", field: "linear_acceleration", axes: "xyz", unit_scale: 1.0, bits: 23 },
    Part { message: IMU, channel: "gyro", field: "angular_velocity", axes: "xyz", unit_scale: 1.0, bits: 25 },
    // gauss in a tesla
    Part { message: MAGNETIC_FIELD, channel: "mag", field: "magnetic_field", axes: "xyz", unit_scale: 1e4, bits: 40 },
    Part { message: TEMPERATURE, channel: "temperature", field: "temperature", axes: "", unit_scale: 1.0, bits: 23 },
    // kilopascals in a pascal
    Part {
        message: FLUID_PRESSURE,
        channel: "pressure",
        field: "fluid_pressure",
        axes: "",
        unit_scale: 1e-3,
        bits: 13,
    },
    vectornav(IMU_GROUP, "mag", "uncompmag", "xyz", 26),
    vectornav(IMU_GROUP, "accel", "uncompaccel", "xyz", 23),
    vectornav(IMU_GROUP, "gyro", "uncompgyro", "xyz", 25),
    vectornav(IMU_GROUP, "accel", "accel", "xyz", 23),
    vectornav(IMU_GROUP, "gyro", "angularrate", "xyz", 25),
    vectornav(IMU_GROUP, "temperature", "temp", "", 23),
    vectornav(IMU_GROUP, "pressure", "pres", "", 23),
    vectornav(COMMON_GROUP, "mag", "magpres_mag", "xyz", 26),
    vectornav(COMMON_GROUP, "accel", "imu_accel", "xyz", 23),
    vectornav(COMMON_GROUP, "gyro", "imu_rate", "xyz", 25),
    vectornav(COMMON_GROUP, "accel", "accel", "xyz", 23),
    vectornav(COMMON_GROUP, "gyro", "angularrate", "xyz", 25),
];

/// Numbers of a message of the driver for VectorNav sensors, in the units of the channels.
const fn vectornav(
    message: &'static str,
    channel: &'static str,
    field: &'static str,
    axes: &'static str,
    bits: u8,
) -> Part {
    Part { message, channel, field, axes, unit_scale: 1.0, bits }
}

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
