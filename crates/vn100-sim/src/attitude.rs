//! Other forms of yaw, pitch and roll (Euler 3-2-1, north-east-down to body), and what needs them.

use crate::sensor::{SensorValues, rotated};

const STANDARD_GRAVITY_M_S2: f64 = 9.80665;

/// The quaternion of the attitude; its scalar comes last.
pub(crate) fn quaternion(ypr_deg: [f32; 3]) -> [f32; 4] {
    let [(sy, cy), (sp, cp), (sr, cr)] = ypr_deg.map(|angle| (f64::from(angle).to_radians() / 2.0).sin_cos());
    [sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy]
        .map(|element| element as f32)
}

/// The direction cosine matrix, north-east-down to body, row by row.
pub(crate) fn direction_cosines(ypr_deg: [f32; 3]) -> [f64; 9] {
    let [(sy, cy), (sp, cp), (sr, cr)] = ypr_deg.map(|angle| f64::from(angle).to_radians().sin_cos());
    [
        cp * cy,
        cp * sy,
        -sp,
        sr * sp * cy - cr * sy,
        sr * sp * sy + cr * cy,
        sr * cp,
        cr * sp * cy + sr * sy,
        cr * sp * sy - sr * cy,
        cr * cp,
    ]
}

/// A vector of the body in north-east-down.
pub(crate) fn to_ned(ypr_deg: [f32; 3], body: [f32; 3]) -> [f32; 3] {
    let matrix = direction_cosines(ypr_deg);
    let transposed = std::array::from_fn(|index| matrix[index % 3 * 3 + index / 3]);
    rotated(&transposed, body.map(f64::from)).map(|component| component as f32)
}

/// Acceleration without gravity, north-east-down. The sensor reads -g on its z axis at rest.
pub(crate) fn linear_accel_ned(measured: &SensorValues) -> [f32; 3] {
    let [north, east, down] = to_ned(measured.ypr_deg, measured.accel_m_s2);
    [north, east, (f64::from(down) + STANDARD_GRAVITY_M_S2) as f32]
}

/// Acceleration without gravity, in axes of the body.
pub(crate) fn linear_accel_body(measured: &SensorValues) -> [f32; 3] {
    let gravity = rotated(&direction_cosines(measured.ypr_deg), [0.0, 0.0, STANDARD_GRAVITY_M_S2]);
    [0, 1, 2].map(|axis| (f64::from(measured.accel_m_s2[axis]) + gravity[axis]) as f32)
}
