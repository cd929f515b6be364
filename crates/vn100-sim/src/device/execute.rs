//! The effect of each command.

use vn100_protocol::DeviceError;

use super::{
    Device, FLASH_WRITE, Firmware, PORT,
    command::{check_count, split},
    ns,
    output::SyncOut,
    registers::Registers,
};
use crate::message::MESSAGES;

/// The names of the ports in commands.
const PORTS: [&str; 2] = ["1", "2"];

impl Device {
    pub(super) fn execute_line(&mut self, line: &[u8]) {
        let outcome = split(line).and_then(|(name, parameters)| self.execute(name, &parameters));
        if let Err(code) = outcome {
            self.report(code);
        }
    }

    fn execute(&mut self, name: &str, parameters: &[&str]) -> Result<(), DeviceError> {
        match name {
            "RRG" => return self.read_register(parameters),
            "WRG" => return self.write_register(parameters),
            "BOM" => {
                let output = one_of(parameters, &["1", "2", "3"])?;
                let packet = self.packet(output);
                self.send(self.now_ns, packet);
                return Ok(());
            }
            "ASY" => self.run.paused = !flag(parameters)?,
            "SGB" => {
                check_count(parameters, 0)?;
                self.registers.set_start_up_bias(self.sensor.bias_rad_s);
            }
            "TAR" if self.registers.firmware != Firmware::V3_1 => check_count(parameters, 0)?,
            "WNV" => {
                check_count(parameters, 0)?;
                self.run.flash_until_ns = Some(self.now_ns + ns(FLASH_WRITE));
                return Ok(());
            }
            "RST" | "RFS" => {
                check_count(parameters, 0)?;
                if name == "RFS" {
                    self.flash = Registers::delivered(self.config.firmware, self.config.serial);
                }
                self.answer(&format!("VN{name}"));
                self.restart();
                return Ok(());
            }
            _ => return Err(DeviceError::InvalidCommand),
        }
        let parameters: String = parameters.iter().map(|parameter| format!(",{parameter}")).collect();
        self.answer(&format!("VN{name}{parameters}"));
        Ok(())
    }

    fn read_register(&mut self, parameters: &[&str]) -> Result<(), DeviceError> {
        let (number, rest) = register_number(parameters)?;
        let (port, echo) = match rest {
            [] => (PORT, String::new()),
            [port] if matches!(number, 5..=7) => (one_of(&[port], &PORTS)?, format!(",{port}")),
            _ => return Err(DeviceError::TooManyParameters),
        };
        let mut body = format!("VNRRG,{number:02}");
        if let Some(message) = MESSAGES.iter().find(|message| message.register == number) {
            self.print_values(message, &mut body);
        } else {
            let settings = match number {
                33 => Some(format!("0,0,{}", self.sync_out_count())),
                _ => self.registers.print(number, port),
            };
            body = format!("{body},{}{echo}", settings.ok_or(DeviceError::InvalidRegister)?);
        }
        self.answer(&body);
        Ok(())
    }

    fn write_register(&mut self, parameters: &[&str]) -> Result<(), DeviceError> {
        let (number, rest) = register_number(parameters)?;
        if MESSAGES.iter().any(|message| message.register == number) {
            return Err(DeviceError::Unauthorized);
        }
        let (rest, port, echo) = match rest {
            [value, port] if matches!(number, 5..=7) => {
                (std::slice::from_ref(value), one_of(&[port], &PORTS)?, format!(",{port}"))
            }
            _ => (rest, PORT, String::new()),
        };
        let count = self.sync_out_count();
        if number == 33 {
            self.clear_sync_status(rest)?;
        } else {
            self.registers.write(number, rest, port)?;
        }
        self.processing = self.registers.processing();
        match number {
            33 => {
                self.answer("VNWRG,33,0,0,0");
                return Ok(());
            }
            // the count continues at another rate
            32 => self.run.sync_out = SyncOut { count, since_tick: self.run.ticks },
            _ => {}
        }
        let settings = self.registers.print(number, port).unwrap_or_default();
        self.answer(&format!("VNWRG,{number:02},{settings}{echo}"));
        if number == 5 && port == PORT {
            self.uart.baud = self.registers.ports[PORT].baud;
        }
        Ok(())
    }

    /// Register 33 accepts only zeros.
    fn clear_sync_status(&mut self, parameters: &[&str]) -> Result<(), DeviceError> {
        check_count(parameters, 3)?;
        if parameters != ["0"; 3] {
            return Err(DeviceError::InvalidParameter);
        }
        self.run.sync_out = SyncOut { count: 0, since_tick: self.run.ticks };
        Ok(())
    }
}

/// The number of a register, with or without leading zeros, and the parameters after it.
fn register_number<'a, 'b>(parameters: &'a [&'b str]) -> Result<(u16, &'a [&'b str]), DeviceError> {
    let (number, rest) = parameters.split_first().ok_or(DeviceError::TooFewParameters)?;
    Ok((number.parse().map_err(|_| DeviceError::InvalidRegister)?, rest))
}

/// The place of the only parameter in the list of allowed values.
fn one_of(parameters: &[&str], allowed: &[&str]) -> Result<usize, DeviceError> {
    check_count(parameters, 1)?;
    allowed.iter().position(|text| parameters == [*text]).ok_or(DeviceError::InvalidParameter)
}

fn flag(parameters: &[&str]) -> Result<bool, DeviceError> {
    Ok(one_of(parameters, &["0", "1"])? == 1)
}
