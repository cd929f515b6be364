//! The fields of a packet, one row each: their bytes, and the numbers in them that are measured.
//!
//! Sources: VN-100 User Manual (UM001, revisions 2.02 and 2.22), the tables of the binary output
//! groups; sizes that the manual omits are from the maker's public library.

use crate::message::{
    layout::Channel,
    quantity::{ACCELERATION, ANGLE, ANGULAR_RATE, ELEMENT, MAGNETIC_FIELD, PRESSURE, TEMPERATURE},
};

#[derive(Debug, Clone, Copy)]
pub(crate) struct PacketField {
    /// Its bytes; 0 if no field is known.
    pub(crate) bytes: u8,
    pub(crate) name: &'static str,
    pub(crate) content: FieldContent,
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum FieldContent {
    /// Floats; these runs of channels are measured.
    Numbers(&'static [Numbers]),
    /// An interval in seconds and increments over it, which become rates after the division.
    Increments(&'static [Numbers]),
    /// Increments over the interval of an earlier such field.
    MoreIncrements(&'static [Numbers]),
    /// Nanoseconds since the sensor started.
    DeviceTime,
    /// A bit for each axis at the end of its range.
    Saturation,
    /// Content that is not measured.
    Other,
}

/// Floats of consecutive channels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Numbers {
    /// The channels, in the order of the wire.
    pub(crate) channels: &'static [Channel],
    pub(crate) processing: Correction,
    /// The unit of the packet in units of the channels.
    pub(crate) unit_scale: f64,
}

/// The correction that the sensor has applied; of several sources of a quantity, the first in this
/// order is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Correction {
    /// Only factory and user calibration and rotation.
    Uncompensated,
    /// With the estimated bias subtracted, and corrected for hard and soft iron.
    Compensated,
    /// Not documented: treated as compensated.
    Undocumented,
    /// Increments, with the correction that register 82 sets.
    Integrated,
}

static ATTITUDE: [Channel; 3] = [ANGLE.binary("yaw"), ANGLE.binary("pitch"), ANGLE.binary("roll")];
static QUATERNION: [Channel; 4] =
    [ELEMENT.binary("quat_x"), ELEMENT.binary("quat_y"), ELEMENT.binary("quat_z"), ELEMENT.binary("quat_w")];
static MAG: [Channel; 3] =
    [MAGNETIC_FIELD.binary("mag_x"), MAGNETIC_FIELD.binary("mag_y"), MAGNETIC_FIELD.binary("mag_z")];
static ACCEL: [Channel; 3] =
    [ACCELERATION.binary("accel_x"), ACCELERATION.binary("accel_y"), ACCELERATION.binary("accel_z")];
static GYRO: [Channel; 3] =
    [ANGULAR_RATE.binary("gyro_x"), ANGULAR_RATE.binary("gyro_y"), ANGULAR_RATE.binary("gyro_z")];
static MEAN_ACCEL: [Channel; 3] = [
    ACCELERATION.integrated("accel_x", 0.0),
    ACCELERATION.integrated("accel_y", 0.0),
    ACCELERATION.integrated("accel_z", 0.0),
];
static MEAN_GYRO: [Channel; 3] = [
    ANGULAR_RATE.integrated("gyro_x", 0.0),
    ANGULAR_RATE.integrated("gyro_y", 0.0),
    ANGULAR_RATE.integrated("gyro_z", 0.0),
];
static THERMOMETER: [Channel; 1] = [TEMPERATURE.binary("temperature")];
static BAROMETER: [Channel; 1] = [PRESSURE.binary("pressure")];

const fn numbers(channels: &'static [Channel], processing: Correction) -> Numbers {
    Numbers { channels, processing, unit_scale: 1.0 }
}

const fn degrees(channels: &'static [Channel]) -> Numbers {
    Numbers { channels, processing: Integrated, unit_scale: core::f64::consts::PI / 180.0 }
}

use Correction::{Compensated, Integrated, Uncompensated, Undocumented};
use FieldContent::{DeviceTime, Increments, MoreIncrements, Numbers as Floats, Other, Saturation};

const fn field(bytes: u8, name: &'static str, content: FieldContent) -> PacketField {
    PacketField { bytes, name, content }
}

/// The fields of a packet with these groups and a word of fields for each, in the order of the wire.
pub(crate) fn present(groups: u8, words: &[u16]) -> impl Iterator<Item = &'static PacketField> {
    let present = GROUPS.iter().filter(move |(bit, _)| groups & bit != 0);
    present.zip(words).flat_map(|((_, fields), word)| {
        fields.iter().enumerate().filter(move |(bit, _)| word >> bit & 1 == 1).map(|(_, field)| field)
    })
}

const NONE: PacketField = field(0, "", Other);

/// The groups of a VN-100: the bit of each, and its fields by bit.
///
/// Bit 7 of the groups and bit 15 of a field word announce one more byte or word; no packet with
/// them is known. A VN-100 has no satellite receiver: fields of a receiver are zero.
#[rustfmt::skip]
pub(crate) static GROUPS: [(u8, [PacketField; 16]); 4] = [
    (0x01, [
        field(8, "TimeStartup", DeviceTime),
        field(8, "TimeGps", Other),
        field(8, "TimeSyncIn", Other),
        field(12, "YawPitchRoll", Floats(&[numbers(&ATTITUDE, Compensated)])),
        field(16, "Quaternion", Floats(&[numbers(&QUATERNION, Compensated)])),
        field(12, "AngularRate", Floats(&[numbers(&GYRO, Compensated)])),
        field(24, "Position", Other),
        field(12, "Velocity", Other),
        field(12, "Accel", Floats(&[numbers(&ACCEL, Compensated)])),
        // revision 2.02 prints the rate first; sensors and both public libraries send it second
        field(24, "Imu", Floats(&[numbers(&ACCEL, Undocumented), numbers(&GYRO, Undocumented)])),
        field(20, "MagPres", Floats(&[
            numbers(&MAG, Compensated), numbers(&THERMOMETER, Uncompensated), numbers(&BAROMETER, Uncompensated),
        ])),
        field(28, "Deltas", Increments(&[degrees(&MEAN_GYRO), numbers(&MEAN_ACCEL, Integrated)])),
        field(2, "VpeStatus", Other),
        field(4, "SyncInCnt", Other),
        field(8, "TimeGpsPps", Other),
        NONE,
    ]),
    (0x02, [
        field(8, "TimeStartup", DeviceTime),
        field(8, "TimeGps", Other),
        field(8, "GpsTow", Other),
        field(2, "GpsWeek", Other),
        field(8, "TimeSyncIn", Other),
        field(8, "TimeGpsPps", Other),
        field(8, "TimeUtc", Other),
        field(4, "SyncInCnt", Other),
        field(4, "SyncOutCnt", Other),
        field(1, "TimeStatus", Other),
        NONE, NONE, NONE, NONE, NONE, NONE,
    ]),
    (0x04, [
        field(2, "ImuStatus", Other),
        field(12, "UncompMag", Floats(&[numbers(&MAG, Uncompensated)])),
        field(12, "UncompAccel", Floats(&[numbers(&ACCEL, Uncompensated)])),
        field(12, "UncompGyro", Floats(&[numbers(&GYRO, Uncompensated)])),
        field(4, "Temp", Floats(&[numbers(&THERMOMETER, Uncompensated)])),
        field(4, "Pres", Floats(&[numbers(&BAROMETER, Uncompensated)])),
        field(16, "DeltaTheta", Increments(&[degrees(&MEAN_GYRO)])),
        field(12, "DeltaVel", MoreIncrements(&[numbers(&MEAN_ACCEL, Integrated)])),
        field(12, "Mag", Floats(&[numbers(&MAG, Compensated)])),
        field(12, "Accel", Floats(&[numbers(&ACCEL, Compensated)])),
        field(12, "AngularRate", Floats(&[numbers(&GYRO, Compensated)])),
        field(2, "SensSat", Saturation),
        field(40, "Raw", Other),
        NONE, NONE, NONE,
    ]),
    (0x10, [
        field(2, "VpeStatus", Other),
        field(12, "YawPitchRoll", Floats(&[numbers(&ATTITUDE, Compensated)])),
        field(16, "Quaternion", Floats(&[numbers(&QUATERNION, Compensated)])),
        field(36, "Dcm", Other),
        field(12, "MagNed", Other),
        field(12, "AccelNed", Other),
        field(12, "LinearAccelBody", Other),
        field(12, "LinearAccelNed", Other),
        field(12, "YprU", Other),
        field(12, "undocumented", Other),
        field(28, "undocumented", Other),
        field(24, "undocumented", Other),
        field(12, "Heave", Other),
        field(4, "AttU", Other),
        NONE, NONE,
    ]),
];
