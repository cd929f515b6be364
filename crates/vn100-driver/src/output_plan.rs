//! From what a sensor is set to send to what it shall send: which registers to write, and in which order. Pure.

use std::collections::BTreeMap;

use thiserror::Error;
use vn100_protocol::OUTPUT_RATES_HZ;

use crate::autobaud::BAUD_RATES;

/// What the sensor shall send. `None` leaves a setting as it is.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct OutputSettings {
    /// Speed of the line in baud.
    pub baud: Option<u32>,
    /// The message, such as `VNYMR` or `VNIMU`.
    pub message: Option<String>,
    /// How many a second.
    pub rate_hz: Option<u32>,
    /// How many of its 800 samples a second the sensor averages for a measurement, of acceleration and angular rate (register 85).
    pub window: Option<u32>,
    /// Whether each line carries a count of the sensor's samples (registers 32 and 30), so that lost lines can be told.
    pub count: Option<bool>,
    /// Whether the sensor keeps the settings, these and all it has, when it is switched off.
    pub save: bool,
}

/// Registers by their numbers, as they read.
pub(crate) type Current = BTreeMap<u8, String>;

/// A register to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Write {
    pub(crate) register: u8,
    pub(crate) before: String,
    pub(crate) after: String,
}

/// Why a sensor cannot be set as asked.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The line is too slow.
    #[error(
        "{message} at {rate_hz} Hz needs {needed} bytes a second and {baud} baud carry {}; {}",
        baud / 10,
        highest_hz.map_or_else(|| "take a faster line".into(), |hz| format!("at most {hz} Hz fit, or take a faster line"))
    )]
    DoesNotFit {
        /// The message.
        message: String,
        /// The rate asked for.
        rate_hz: u32,
        /// The speed of the line.
        baud: u32,
        /// Bytes a second.
        needed: u32,
        /// The highest rate of the sensor that fits.
        highest_hz: Option<u32>,
    },
    /// The sensor has no such value.
    #[error("{setting} can be {allowed}, not {asked}")]
    NotAllowed {
        /// What was to be set.
        setting: &'static str,
        /// The value asked for.
        asked: String,
        /// What there is.
        allowed: String,
    },
    /// A binary output takes its part of the line, how much is not known here.
    #[error("binary output {} is on and takes its part of the line; turn it off first (register {register})", register - 74)]
    BinaryOutput {
        /// Its register, 75 to 77.
        register: u8,
    },
    /// The sensor does not have, or does not say as expected, what would have to be changed.
    #[error("register {register} of this sensor reads {fields:?}, which is not understood")]
    Register {
        /// Its number.
        register: u8,
        /// Its fields; empty where the sensor has none such.
        fields: String,
    },
}

/// The messages a VN-100 sends: number for register 6, name, bytes of the usual line with an 8-bit checksum.
const MESSAGES: [(u32, &str, u32); 12] = [
    (1, "VNYPR", 38),
    (2, "VNQTN", 51),
    (8, "VNQMR", 135),
    (10, "VNMAG", 38),
    (11, "VNACC", 35),
    (12, "VNGYR", 44),
    (13, "VNMAR", 95),
    (14, "VNYMR", 122),
    (16, "VNYBA", 95),
    (17, "VNYIA", 95),
    (19, "VNIMU", 112),
    (30, "VNDTV", 75),
];

/// A 16-bit checksum has two digits more; a count suffix is `,T` and up to ten digits.
const CRC_BYTES: u32 = 2;
const COUNT_BYTES: u32 = 12;

/// The sensor measures so often; every `800 / rate`th measurement is sent.
const SAMPLES_PER_S: u32 = 800;

const BAUD: u8 = 5;
const MESSAGE: u8 = 6;
const RATE: u8 = 7;
const PROTOCOL: u8 = 30;
const SYNCHRONISATION: u8 = 32;
const BINARY: [u8; 3] = [75, 76, 77];
const FILTER: u8 = 85;

impl OutputSettings {
    /// The registers that the plan must know.
    pub(crate) fn registers(&self) -> Vec<u8> {
        let mut registers = vec![BAUD, MESSAGE, RATE, PROTOCOL];
        registers.extend(BINARY);
        registers.extend(self.count.map(|_| SYNCHRONISATION));
        registers.extend(self.window.map(|_| FILTER));
        registers
    }
}

/// The registers to write in their order, and the rate in hertz that the sensor then has.
///
/// At no step more is asked for than the line carries: a faster line comes before more output, less output before a slower line.
pub(crate) fn plan(current: &Current, settings: &OutputSettings) -> Result<(Vec<Write>, u32), PlanError> {
    let old = (number(current, BAUD)?, number(current, MESSAGE)?, number(current, RATE)?);
    let baud = settings.baud.unwrap_or(old.0);
    let code = settings.message.as_deref().map_or(Ok(old.1), message_code)?;
    let rate_hz = settings.rate_hz.unwrap_or(old.2);
    allowed("the speed", baud, &BAUD_RATES)?;
    allowed("the rate", rate_hz, &OUTPUT_RATES_HZ)?;
    let protocol = protocol(current, settings)?;
    check_fit(current, baud, code, rate_hz, &protocol)?;

    let mut writes = Vec::new();
    let mut write = |register: u8, after: String| {
        let before = current.get(&register).cloned().unwrap_or_default();
        // a rate that was lowered first is not written again
        let planned = writes.iter().any(|write: &Write| write.register == register);
        if before != after && !planned {
            writes.push(Write { register, before, after });
        }
    };
    if baud > old.0 {
        write(BAUD, baud.to_string());
    }
    if rate_hz < old.2 {
        write(RATE, rate_hz.to_string());
    }
    write(MESSAGE, code.to_string());
    write(RATE, rate_hz.to_string());
    if let Some(count) = settings.count {
        let mut fields = fields(current, SYNCHRONISATION, 9)?;
        // the output pulse marks the start of every measurement that is sent, and is what is counted
        (fields[4], fields[6]) =
            if count { ("1".into(), (SAMPLES_PER_S / rate_hz - 1).to_string()) } else { ("0".into(), "0".into()) };
        write(SYNCHRONISATION, fields.join(","));
    }
    write(PROTOCOL, protocol.join(","));
    if let Some(window) = settings.window {
        let mut fields = fields(current, FILTER, 10)?;
        if window == 0 || window > SAMPLES_PER_S {
            let allowed = format!("1 to {SAMPLES_PER_S} samples");
            return Err(PlanError::NotAllowed { setting: "the window", asked: window.to_string(), allowed });
        }
        (fields[1], fields[2]) = (window.to_string(), window.to_string());
        write(FILTER, fields.join(","));
    }
    if baud < old.0 {
        write(BAUD, baud.to_string());
    }
    Ok((writes, rate_hz))
}

/// Register 30 as it shall be.
fn protocol(current: &Current, settings: &OutputSettings) -> Result<Vec<String>, PlanError> {
    let mut fields = fields(current, PROTOCOL, 7)?;
    if let Some(count) = settings.count {
        // 3 appends the count of output pulses
        fields[0] = if count { "3" } else { "0" }.into();
    }
    Ok(fields)
}

fn check_fit(current: &Current, baud: u32, code: u32, rate_hz: u32, protocol: &[String]) -> Result<(), PlanError> {
    let is_on = |fields: &String| fields.split(',').take(2).all(|field| field.parse() != Ok(0));
    if let Some(register) = BINARY.into_iter().find(|register| current.get(register).is_some_and(is_on)) {
        return Err(PlanError::BinaryOutput { register });
    }
    // what is off, or not known here, the sensor itself judges
    let Some((_, name, bytes)) = MESSAGES.into_iter().find(|(other, ..)| *other == code) else { return Ok(()) };
    let count = if protocol[0] == "0" { 0 } else { COUNT_BYTES };
    let crc = if protocol[4] == "3" { CRC_BYTES } else { 0 };
    let line = bytes + count + crc;
    let fits = |hz: u32| line * hz <= baud / 10;
    if fits(rate_hz) {
        return Ok(());
    }
    let highest_hz = OUTPUT_RATES_HZ.into_iter().filter(|hz| fits(*hz)).max();
    Err(PlanError::DoesNotFit { message: name.into(), rate_hz, baud, needed: line * rate_hz, highest_hz })
}

fn message_code(name: &str) -> Result<u32, PlanError> {
    let found = MESSAGES.into_iter().find(|(_, other, _)| *other == name);
    found.map(|(code, ..)| code).ok_or_else(|| PlanError::NotAllowed {
        setting: "the message",
        asked: name.into(),
        allowed: MESSAGES.map(|(_, name, _)| name).join(", "),
    })
}

fn allowed(setting: &'static str, asked: u32, values: &[u32]) -> Result<(), PlanError> {
    if values.contains(&asked) {
        return Ok(());
    }
    let mut values = values.to_vec();
    values.sort_unstable();
    let allowed = values.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
    Err(PlanError::NotAllowed { setting, asked: asked.to_string(), allowed })
}

/// A register's first field as a number; behind it the sensor may name the port.
fn number(current: &Current, register: u8) -> Result<u32, PlanError> {
    let text = current.get(&register).map_or("", String::as_str);
    let first = text.split(',').next().unwrap_or_default();
    first.parse().map_err(|_| PlanError::Register { register, fields: text.into() })
}

fn fields(current: &Current, register: u8, count: usize) -> Result<Vec<String>, PlanError> {
    let text = current.get(&register).map_or("", String::as_str);
    let fields: Vec<_> = text.split(',').map(ToOwned::to_owned).collect();
    if fields.len() == count { Ok(fields) } else { Err(PlanError::Register { register, fields: text.into() }) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn current(baud: u32, code: u32, rate_hz: u32) -> Current {
        let registers = [
            (BAUD, baud.to_string()),
            (MESSAGE, code.to_string()),
            (RATE, rate_hz.to_string()),
            (PROTOCOL, "0,0,0,0,1,0,1".into()),
            (SYNCHRONISATION, "3,0,0,0,0,0,0,100000000,0".into()),
            (75, "0,0,00".into()),
            (FILTER, "0,4,4,4,0,0,3,3,3,0".into()),
        ];
        registers.into()
    }

    fn planned(current: &Current, settings: &OutputSettings) -> Vec<(u8, String)> {
        let (writes, _) = plan(current, settings).unwrap();
        writes.into_iter().map(|write| (write.register, write.after)).collect()
    }

    fn list(writes: &[(u8, &str)]) -> Vec<(u8, String)> {
        writes.iter().map(|(register, fields)| (*register, (*fields).to_owned())).collect()
    }

    #[test]
    fn the_line_is_never_asked_for_more_than_it_carries() {
        let settings =
            |baud, rate_hz| OutputSettings { baud: Some(baud), rate_hz: Some(rate_hz), ..OutputSettings::default() };
        let faster = planned(&current(115_200, 14, 40), &settings(921_600, 200));
        assert_eq!(faster, list(&[(5, "921600"), (7, "200")]));
        let slower = planned(&current(921_600, 14, 200), &settings(57_600, 40));
        assert_eq!(slower, list(&[(7, "40"), (5, "57600")]));
        assert_eq!(planned(&current(115_200, 14, 40), &settings(115_200, 40)), []);
    }

    #[test]
    fn window_and_count_keep_the_other_fields() {
        let settings = OutputSettings {
            message: Some("VNIMU".into()),
            rate_hz: Some(20),
            window: Some(40),
            count: Some(true),
            ..OutputSettings::default()
        };
        let expected = [
            (7, "20"),
            (6, "19"),
            (32, "3,0,0,0,1,0,39,100000000,0"),
            (30, "3,0,0,0,1,0,1"),
            (85, "0,40,40,4,0,0,3,3,3,0"),
        ];
        assert_eq!(planned(&current(115_200, 14, 40), &settings), list(&expected));
    }

    #[test]
    fn the_highest_rates_are_those_of_the_sheet() {
        // VNYMR: what the sensor takes at each speed
        let table = [
            (9600, 5),
            (19_200, 10),
            (38_400, 25),
            (57_600, 40),
            (115_200, 50),
            (128_000, 100),
            (230_400, 100),
            (460_800, 200),
            (921_600, 200),
        ];
        for (baud, highest) in table {
            for rate_hz in OUTPUT_RATES_HZ {
                let settings = OutputSettings { rate_hz: Some(rate_hz), ..OutputSettings::default() };
                let result = plan(&current(baud, 14, 1), &settings);
                if rate_hz <= highest {
                    assert!(result.is_ok(), "{rate_hz} Hz at {baud}");
                } else {
                    let Err(PlanError::DoesNotFit { highest_hz, .. }) = result else {
                        panic!("{rate_hz} Hz at {baud}")
                    };
                    assert_eq!(highest_hz, Some(highest));
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_says_what_can() {
        let error = |current: &Current, settings: &OutputSettings| plan(current, settings).unwrap_err().to_string();
        let rate = |hz| OutputSettings { rate_hz: Some(hz), ..OutputSettings::default() };
        assert_eq!(
            error(&current(115_200, 14, 40), &rate(100)),
            "VNYMR at 100 Hz needs 12200 bytes a second and 115200 baud carry 11520; at most 50 Hz fit, or take a faster line"
        );
        assert_eq!(
            error(&current(115_200, 14, 40), &rate(30)),
            "the rate can be 1, 2, 4, 5, 10, 20, 25, 40, 50, 100, 200, not 30"
        );
        let mut binary = current(115_200, 14, 40);
        binary.insert(76, "2,4,01,0739".into());
        assert!(error(&binary, &rate(50)).starts_with("binary output 2 is on"));
        let mut damaged = current(115_200, 14, 40);
        damaged.remove(&FILTER);
        let window = OutputSettings { window: Some(20), ..OutputSettings::default() };
        assert!(error(&damaged, &window).starts_with("register 85 of this sensor reads \"\""));
    }

    proptest! {
        #[test]
        fn every_step_fits(from in 0..9_usize, to in 0..9_usize, codes in (0..12_usize, 0..12_usize), rates in (0..11_usize, 0..11_usize)) {
            let bytes = |code| MESSAGES.iter().find(|(other, ..)| *other == code).map_or(0, |(_, _, bytes)| *bytes);
            let fits = |state: &BTreeMap<u8, u32>| bytes(state[&MESSAGE]) * state[&RATE] <= state[&BAUD] / 10;
            let old = current(BAUD_RATES[from], MESSAGES[codes.0].0, OUTPUT_RATES_HZ[rates.0]);
            let settings = OutputSettings {
                baud: Some(BAUD_RATES[to]),
                message: Some(MESSAGES[codes.1].1.into()),
                rate_hz: Some(OUTPUT_RATES_HZ[rates.1]),
                ..OutputSettings::default()
            };
            let mut state: BTreeMap<u8, u32> = [BAUD, MESSAGE, RATE].map(|register| (register, old[&register].parse().unwrap())).into();
            prop_assume!(fits(&state));
            if let Ok((writes, _)) = plan(&old, &settings) {
                for write in writes {
                    state.insert(write.register, write.after.parse().unwrap());
                    prop_assert!(fits(&state), "{:?}", state);
                }
                prop_assert_eq!(state[&RATE], OUTPUT_RATES_HZ[rates.1]);
            }
        }
    }
}
