//! The sentences of measurements, one row of the table each, in the print format of the sensor.
//!
//! This table shares nothing with the parser of this project, so each can be tested against the
//! other.

use std::fmt::Write;

use crate::sensor::{Deltas, SensorValues, single};

/// Yaw, pitch and roll, magnetic field and so on, in the order of a sentence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FieldGroup {
    Angles,
    Quaternion,
    Mag,
    Accel,
    Rate,
    /// Uncompensated field, acceleration and rate, temperature and pressure.
    Uncompensated,
    Deltas,
}

/// A sentence that the sensor can send.
///
/// Widths are minimum widths, and negative zero keeps its sign: the text equals that of the C
/// formats of the maker, such as `%+08.3f` for an angle.
#[derive(Debug)]
pub struct Message {
    /// Its number in register 6.
    pub(crate) code: u32,
    pub(crate) header: &'static str,
    /// The register with the same contents.
    pub(crate) register: u16,
    /// Its length with CR LF and two check digits, if all values have their usual widths.
    pub(crate) usual_bytes: u32,
    groups: &'static [FieldGroup],
}

use FieldGroup::{Accel, Angles, Mag, Quaternion, Rate, Uncompensated};

const fn message(
    code: u32,
    header: &'static str,
    register: u16,
    usual_bytes: u32,
    groups: &'static [FieldGroup],
) -> Message {
    Message { code, header, register, usual_bytes, groups }
}

/// The sentences of a VN-100 that register 6 selects.
pub(crate) const MESSAGES: [Message; 10] = [
    message(1, "VNYPR", 8, 38, &[Angles]),
    message(2, "VNQTN", 9, 51, &[Quaternion]),
    message(8, "VNQMR", 15, 135, &[Quaternion, Mag, Accel, Rate]),
    message(10, "VNMAG", 17, 38, &[Mag]),
    message(11, "VNACC", 18, 35, &[Accel]),
    message(12, "VNGYR", 19, 44, &[Rate]),
    message(13, "VNMAR", 20, 95, &[Mag, Accel, Rate]),
    message(14, "VNYMR", 27, 122, &[Angles, Mag, Accel, Rate]),
    message(19, "VNIMU", 54, 112, &[Uncompensated]),
    message(30, "VNDTV", 80, 75, &[FieldGroup::Deltas]),
];

impl Message {
    /// The sentence with this header, such as `VNYMR`; `None` for any other text.
    pub fn named(header: &str) -> Option<&'static Self> {
        MESSAGES.iter().find(|message| message.header == header)
    }

    pub(crate) fn has_surroundings(&self) -> bool {
        self.groups.contains(&Uncompensated)
    }

    /// Whether it carries integrals since its last sentence.
    pub(crate) fn has_deltas(&self) -> bool {
        self.groups.contains(&FieldGroup::Deltas)
    }

    /// Appends its values, a comma before each.
    pub(crate) fn print(&self, measured: &SensorValues, deltas: &Deltas, out: &mut String) {
        for group in self.groups {
            // width and decimals from the maker's formats
            match group {
                Angles => print(out, measured.ypr_deg, 8, 3),
                Quaternion => print(out, measured.quaternion(), 9, 6),
                Mag => print(out, measured.mag_gauss, 8, 4),
                Accel => print(out, measured.accel_m_s2, 7, 3),
                Rate => print(out, measured.gyro_rad_s, 10, 6),
                Uncompensated => {
                    print(out, measured.uncompensated_mag_gauss, 8, 4);
                    print(out, measured.uncompensated_accel_m_s2, 7, 3);
                    print(out, measured.uncompensated_gyro_rad_s, 10, 6);
                    print(out, [measured.temperature_c], 5, 1);
                    print(out, [measured.pressure_kpa], 10, 3);
                }
                FieldGroup::Deltas => {
                    print(out, [deltas.time_s as f32], 9, 6);
                    print(out, single(deltas.theta_deg), 8, 3);
                    print(out, single(deltas.velocity_m_s), 8, 3);
                }
            }
        }
    }
}

fn print<const N: usize>(out: &mut String, values: [f32; N], width: usize, decimals: usize) {
    for value in values {
        // writing to a String cannot fail
        _ = write!(out, ",{value:+0width$.decimals$}");
    }
}
