//! The settings of the sensor: one set in memory, one in flash.

use std::collections::BTreeMap;

use vn100_protocol::{BaudRate, DeviceError, OUTPUT_RATES_HZ};

use super::{
    binary::PacketOutput,
    command::check_count,
    register_table::{Field, Firmware, ROWS},
};
use crate::{message::MESSAGES, onboard::AveragingWindow, profile::Profile, sensor::Processing};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PortSettings {
    pub(crate) baud: u32,
    /// Register 6.
    pub(crate) message: u32,
    pub(crate) rate_hz: u32,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Registers {
    pub(crate) firmware: Firmware,
    serial: u32,
    /// The fields of the registers of the table, as they are printed.
    values: BTreeMap<u16, Vec<String>>,
    pub(crate) ports: [PortSettings; 2],
    pub(crate) binary: [PacketOutput; 3],
}

impl Registers {
    pub(crate) fn delivered(firmware: Firmware, serial: u32) -> Self {
        let values = ROWS.iter().map(|row| {
            let default = match (row.number, firmware) {
                (44, Firmware::V2_1) => "1,3,5",
                _ => row.default,
            };
            let default: Vec<&str> = default.split(',').collect();
            (row.number, printed_values(row.fields, &default).unwrap_or_default())
        });
        Self {
            firmware,
            serial,
            values: values.collect(),
            ports: [PortSettings { baud: 115_200, message: 14, rate_hz: 40 }; 2],
            binary: std::array::from_fn(|_| PacketOutput::off(firmware)),
        }
    }

    /// Sets rate and averaging window as the profile was measured, if the sensor has them.
    pub(crate) fn set_like(&mut self, profile: &Profile) {
        let rate = OUTPUT_RATES_HZ.into_iter().find(|hz| f64::from(*hz) == profile.rate_hz);
        for port in &mut self.ports {
            port.rate_hz = rate.unwrap_or(port.rate_hz);
        }
        for port in 0..self.ports.len() {
            if !self.fits(port) {
                self.ports[port].baud = 921_600;
            }
        }
        for (field, channel) in [(1, 6), (2, 9)] {
            if let AveragingWindow::Boxcar { samples, .. } = profile.channels[channel].window
                && let Some(value) = self.values.get_mut(&85).and_then(|values| values.get_mut(field))
            {
                *value = samples.to_string();
            }
        }
    }

    /// The settings as a read would print them; `None` if no such register is kept here.
    ///
    /// `port` is the port that the command names, or on which it arrived.
    pub(crate) fn print(&self, number: u16, port: usize) -> Option<String> {
        let port = &self.ports[port];
        Some(match number {
            3 => format!("{:010}", self.serial),
            4 => self.firmware.version().to_owned(),
            5 => port.baud.to_string(),
            6 => port.message.to_string(),
            7 => port.rate_hz.to_string(),
            75..=77 => self.binary[usize::from(number - 75)].print(self.firmware),
            _ => self.values.get(&number)?.join(","),
        })
    }

    /// Accepts new settings, or leaves all unchanged.
    pub(crate) fn write(&mut self, number: u16, parameters: &[&str], port: usize) -> Result<(), DeviceError> {
        let mut new = self.clone();
        let fits = match number {
            3 | 4 => return Err(DeviceError::Unauthorized),
            5..=7 => {
                new.set_port(number, parameters, port)?;
                new.fits(port)
            }
            75..=77 => {
                new.binary[usize::from(number - 75)] = PacketOutput::parse(parameters)?;
                new.fits(0) && new.fits(1)
            }
            _ => {
                let row = ROWS.iter().find(|row| row.number == number).ok_or(DeviceError::InvalidRegister)?;
                if row.read_only {
                    return Err(DeviceError::Unauthorized);
                }
                new.values.insert(number, printed_values(row.fields, parameters)?);
                true
            }
        };
        if !fits {
            return Err(DeviceError::InsufficientBaudRate);
        }
        *self = new;
        Ok(())
    }

    fn set_port(&mut self, number: u16, parameters: &[&str], port: usize) -> Result<(), DeviceError> {
        check_count(parameters, 1)?;
        let value: u32 = parameters[0].parse().map_err(|_| DeviceError::InvalidParameter)?;
        let (setting, allowed) = match number {
            5 => (&mut self.ports[port].baud, BaudRate::new(value).is_some()),
            6 => (&mut self.ports[port].message, value == 0 || MESSAGES.iter().any(|message| message.code == value)),
            _ => {
                let off = value == 0 && self.firmware == Firmware::V3_1;
                (&mut self.ports[port].rate_hz, off || OUTPUT_RATES_HZ.contains(&value))
            }
        };
        if !allowed {
            return Err(DeviceError::InvalidParameter);
        }
        *setting = value;
        Ok(())
    }

    /// Whether all output of a port fits its line: the sum of bytes times rate is at most baud/10.
    fn fits(&self, port: usize) -> bool {
        let settings = &self.ports[port];
        let lines = MESSAGES
            .iter()
            .find(|message| message.code == settings.message)
            .map_or(0, |message| message.usual_bytes * settings.rate_hz);
        // in units of bytes per second times 800, because 800/divisor need not be an integer
        let packets: u64 = self.binary.iter().map(|output| output.bytes_per_800_s(port)).sum();
        u64::from(lines) * 800 + packets <= u64::from(settings.baud) / 10 * 800
    }

    pub(crate) fn set_start_up_bias(&mut self, bias_rad_s: [f64; 3]) {
        self.values.insert(43, bias_rad_s.map(|bias| printed_rate(bias as f32)).to_vec());
    }

    /// An integer of a register, by the index of its field; 0 if there is none.
    pub(crate) fn whole(&self, number: u16, field: usize) -> u32 {
        let value = self.values.get(&number).and_then(|values| values.get(field)?.parse().ok());
        value.unwrap_or_default()
    }

    pub(crate) fn processing(&self) -> Processing {
        let modes = [0, 1, 2].map(|triad| self.whole(85, 5 + triad));
        Processing {
            windows: [0, 1, 2].map(|triad| self.whole(85, triad)),
            averages_uncompensated: modes.map(|mode| mode & 1 != 0),
            averages_compensated: modes.map(|mode| mode & 2 != 0),
        }
    }
}

fn printed_values(fields: &[Field], parameters: &[&str]) -> Result<Vec<String>, DeviceError> {
    check_count(parameters, fields.len())?;
    fields
        .iter()
        .zip(parameters)
        .map(|(field, text)| printed(*field, text).ok_or(DeviceError::InvalidParameter))
        .collect()
}

/// A setting as it is printed; `None` if it is not allowed.
fn printed(field: Field, text: &str) -> Option<String> {
    let whole = || text.parse::<u32>().ok();
    let real = || text.parse::<f32>().ok().filter(|value| value.is_finite());
    match field {
        Field::Text(longest) => (text.len() <= longest).then(|| text.to_owned()),
        Field::Whole(least, most) => {
            whole().filter(|value| (least..=most).contains(value)).map(|value| value.to_string())
        }
        Field::OneOf(allowed) => whole().filter(|value| allowed.contains(value)).map(|value| value.to_string()),
        Field::Real(most) => real().filter(|value| value.abs() <= most).map(|value| value.to_string()),
        Field::Rate => real().map(printed_rate),
    }
}

fn printed_rate(value: f32) -> String {
    format!("{value:+010.6}")
}
