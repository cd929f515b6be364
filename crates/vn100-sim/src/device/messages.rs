//! The sentences of measurements, printed as the sensor prints them.

use std::fmt::Write;

use super::attitude::{linear_accel_body, linear_accel_ned, quaternion};
use crate::sensor::{Deltas, Measurement};

/// Yaw, pitch and roll, magnetic field and so on, in the order of a sentence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Group {
    Angles,
    Quaternion,
    Mag,
    Accel,
    Rate,
    LinearBody,
    LinearNed,
    /// Uncompensated field, acceleration and rate, temperature and pressure.
    Uncompensated,
    Deltas,
}

/// A sentence the sensor can send.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Message {
    /// Its number in register 6.
    pub(crate) code: u32,
    pub(crate) header: &'static str,
    /// The register that reads the same.
    pub(crate) register: u16,
    /// Its length with CR LF, all values within their usual widths, with two check digits.
    pub(crate) usual_bytes: u32,
    groups: &'static [Group],
}

use Group::{Accel, Angles, LinearBody, LinearNed, Mag, Quaternion, Rate, Uncompensated};

const fn message(
    code: u32,
    header: &'static str,
    register: u16,
    usual_bytes: u32,
    groups: &'static [Group],
) -> Message {
    Message { code, header, register, usual_bytes, groups }
}

/// The sentences of a VN-100 that register 6 selects.
pub(crate) const MESSAGES: [Message; 12] = [
    message(1, "VNYPR", 8, 38, &[Angles]),
    message(2, "VNQTN", 9, 51, &[Quaternion]),
    message(8, "VNQMR", 15, 135, &[Quaternion, Mag, Accel, Rate]),
    message(10, "VNMAG", 17, 38, &[Mag]),
    message(11, "VNACC", 18, 35, &[Accel]),
    message(12, "VNGYR", 19, 44, &[Rate]),
    message(13, "VNMAR", 20, 95, &[Mag, Accel, Rate]),
    message(14, "VNYMR", 27, 122, &[Angles, Mag, Accel, Rate]),
    message(16, "VNYBA", 239, 95, &[Angles, LinearBody, Rate]),
    message(17, "VNYIA", 240, 95, &[Angles, LinearNed, Rate]),
    message(19, "VNIMU", 54, 112, &[Uncompensated]),
    message(30, "VNDTV", 80, 75, &[Group::Deltas]),
];

impl Message {
    /// Whether it carries integrals since it was last sent.
    pub(crate) fn has_deltas(&self) -> bool {
        self.groups.contains(&Group::Deltas)
    }

    /// Appends its values, a comma before each.
    pub(crate) fn print(&self, measured: &Measurement, deltas: &Deltas, out: &mut String) {
        for group in self.groups {
            match group {
                Angles => angles(out, measured.ypr_deg),
                Quaternion => {
                    for element in quaternion(measured.ypr_deg) {
                        _ = write!(out, ",{element:+09.6}");
                    }
                }
                Mag => mag(out, measured.mag_gauss),
                Accel => accel(out, measured.accel_m_s2),
                Rate => rate(out, measured.gyro_rad_s),
                LinearBody => accel(out, linear_accel_body(measured)),
                LinearNed => accel(out, linear_accel_ned(measured)),
                Uncompensated => {
                    mag(out, measured.uncompensated_mag_gauss);
                    accel(out, measured.uncompensated_accel_m_s2);
                    rate(out, measured.uncompensated_gyro_rad_s);
                    _ = write!(out, ",{:+05.1},{:+010.3}", measured.temperature_c, measured.pressure_kpa);
                }
                Group::Deltas => {
                    _ = write!(out, ",{:+09.6}", deltas.time_s as f32);
                    angles(out, deltas.theta_deg.map(|angle| angle as f32));
                    angles(out, deltas.velocity_m_s.map(|velocity| velocity as f32));
                }
            }
        }
    }
}

// writing to a String cannot fail

fn angles(out: &mut String, values: [f32; 3]) {
    for value in values {
        _ = write!(out, ",{value:+08.3}");
    }
}

fn mag(out: &mut String, values: [f32; 3]) {
    for value in values {
        _ = write!(out, ",{value:+08.4}");
    }
}

fn accel(out: &mut String, values: [f32; 3]) {
    for value in values {
        _ = write!(out, ",{value:+07.3}");
    }
}

fn rate(out: &mut String, values: [f32; 3]) {
    for value in values {
        _ = write!(out, ",{value:+010.6}");
    }
}
