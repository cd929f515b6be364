//! The standard messages of sensors: their definitions, where a bag has none, and which of their
//! numbers are channels.
//!
//! Units and conventions: <https://www.ros.org/reps/rep-0103.html> and the comments in the
//! definitions of `sensor_msgs`.

use super::topic::Encoding;

pub(super) const IMU: &str = "sensor_msgs/Imu";
pub(super) const MAGNETIC_FIELD: &str = "sensor_msgs/MagneticField";
pub(super) const TEMPERATURE: &str = "sensor_msgs/Temperature";
pub(super) const FLUID_PRESSURE: &str = "sensor_msgs/FluidPressure";

/// Numbers of a standard message that are present together or not at all.
pub(super) struct Part {
    pub(super) message: &'static str,
    /// What the names of their channels begin with.
    pub(super) channel: &'static str,
    /// The field that holds the numbers.
    pub(super) field: &'static str,
    /// The axes, a letter for each; none where the field is itself the number.
    axes: &'static str,
    /// How many units of the channel are one unit of the message.
    pub(super) unit_scale: f64,
    /// A count is 2^-`bits` of the unit of the message: as many bits as the range of a sensor
    /// leaves of 32 (64 rad/s, 256 m/s², 2 mT, 256 °C, 262 kPa).
    pub(super) bits: u8,
}

impl Part {
    /// The channels, and the paths of their numbers.
    pub(super) fn channels(&self) -> impl Iterator<Item = (String, String)> {
        let Self { channel, field, axes, .. } = self;
        let whole = axes.is_empty().then(|| (channel.to_string(), field.to_string()));
        whole.into_iter().chain(axes.chars().map(move |axis| (format!("{channel}_{axis}"), format!("{field}.{axis}"))))
    }

    /// The path of their covariance: -1 in its first element means that the sensor does not measure
    /// them.
    pub(super) fn covariance(&self) -> Option<String> {
        (self.message == IMU).then(|| format!("{}_covariance[0]", self.field))
    }
}

pub(super) const PARTS: [Part; 6] = [
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
