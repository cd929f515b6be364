//! Options of every command that talks to a live sensor.

use std::{convert::Infallible, fmt, path::PathBuf, str::FromStr, time::Duration};

use clap::{Args, ValueEnum};
use vn100_capture::Rotation;
use vn100_driver::OutputSettings;
use vn100_protocol::{
    AsyncType, BaudRate, MEASUREMENTS_PER_S, MESSAGES, OUTPUT_RATES_HZ, PACKET_MESSAGES, PacketMessage,
    stream::MeasuredFrames,
};
use vn100_sim::{Thermal, fault::FaultPlan};

use super::{LogArgs, duration::length};

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum SourceName {
    Port(String),
    Sim,
    Tcp(String),
    Stdin,
}

impl SourceName {
    /// Its form, as documents name it.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Port(_) => "serial",
            Self::Sim => "sim",
            Self::Tcp(_) => "tcp",
            Self::Stdin => "stdin",
        }
    }
}

impl FromStr for SourceName {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(match text {
            "sim" => Self::Sim,
            "-" => Self::Stdin,
            _ if text.starts_with("tcp://") => Self::Tcp(text.to_owned()),
            _ => Self::Port(text.to_owned()),
        })
    }
}

impl fmt::Display for SourceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Port(name) | Self::Tcp(name) => f.write_str(name),
            Self::Sim => f.write_str("sim"),
            Self::Stdin => f.write_str("-"),
        }
    }
}

/// A baud rate; `None` is found by listening and asking.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Baud(pub(crate) Option<u32>);

impl FromStr for Baud {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            _ if text == "auto" => Ok(Self(None)),
            Ok(baud) if baud > 0 => Ok(Self(Some(baud))),
            _ => Err("expected a baud rate, such as 115200, or \"auto\"".into()),
        }
    }
}

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Link")]
pub(crate) struct LinkArgs {
    /// Baud rate, or "auto" to probe all nine of the sensor
    #[arg(long, value_name = "N", default_value = "auto")]
    pub(crate) baud: Baud,

    /// Send nothing to the sensor, for shared or one-way cables
    #[arg(long)]
    pub(crate) listen_only: bool,

    #[command(flatten)]
    pub(crate) sim: SimSensorArgs,

    #[command(flatten)]
    pub(crate) log: LogArgs,
}

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Emulated sensor")]
pub(crate) struct SimSensorArgs {
    /// Sensor to emulate: "datasheet", "lab3", or the sensor of a measurement of an uncompensated
    /// message, by its JSON document or its capture: mean, N, B, K, R, correlated noise, spectral
    /// lines, low pass and resolution of each axis, rate, averaging window and temperature; no
    /// steps, warm-up, cycles or influence of the temperature
    #[arg(long, alias = "profile", value_name = "NAME|FILE", default_value = "datasheet")]
    pub(crate) like: PathBuf,

    /// Seed of the emulated sensor; the same seed gives the same noise. Further sources of one
    /// command take the next ones
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,

    /// Temperature of the emulated sensor and the bias that follows it, as in
    /// "gyro=0.002 accel=0.1 lag=60 cycle=1.5 period=900": deg/s and mg per degC, s, degC; also
    /// heating, warm-up, age
    #[arg(long, value_name = "TRUTH")]
    pub(crate) thermal: Option<Thermal>,

    /// Faults to inject into the emulated link, as in "flip@1% unplug@20s+3s"; times count from
    /// power-up
    #[arg(long, value_name = "PLAN", default_value = "", hide_default_value = true)]
    pub(crate) faults: FaultPlan,
}

/// Settings of the sensor during the measurement, restored afterwards.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Sensor settings")]
pub(crate) struct ChangeArgs {
    /// Set the output rate in hertz: 1 2 4 5 10 20 25 40 50 100 200, of packets any whole part of
    /// 800; the baud rate is raised for packets that need it
    #[arg(long, value_name = "HZ", conflicts_with = "listen_only", value_parser = any_rate)]
    pub(crate) set_rate: Option<u32>,

    /// Set the message to be sent, such as VNYMR, VNIMU or BINARY: packets with the time of the
    /// sensor, uncompensated; BINARY+MAG has magnetic field and pressure as well. On this port
    /// packets replace sentences, and sentences packets
    #[arg(long, value_name = "NAME", conflicts_with = "listen_only", value_parser = message)]
    pub(crate) set_message: Option<String>,

    /// Averaging window of gyroscope and accelerometer, in samples at 800 Hz; 800/rate avoids
    /// aliasing
    #[arg(long, value_name = "N", conflicts_with = "listen_only", value_parser = clap::value_parser!(u32).range(1..=800))]
    pub(crate) window: Option<u32>,
}

impl ChangeArgs {
    /// What they ask for; `None` for nothing.
    pub(crate) fn settings(&self) -> Option<OutputSettings> {
        let settings = OutputSettings {
            message: self.set_message.clone(),
            rate_hz: self.set_rate,
            window: self.window,
            ..OutputSettings::default()
        };
        (settings != OutputSettings::default()).then_some(settings)
    }

    /// What they set the sensor to send; `None` where they leave it as it is.
    pub(crate) fn measured(&self) -> Option<MeasuredFrames> {
        let name = self.set_message.as_ref()?;
        Some(if PacketMessage::named(name).is_some() { MeasuredFrames::Packets } else { MeasuredFrames::Sentences })
    }

    /// Why what they ask for cannot be measured.
    pub(super) fn not_measured(&self) -> Option<String> {
        let name = self.set_message.as_ref().filter(|name| PacketMessage::named(name).is_none())?;
        let refusal = || {
            let sentences = MESSAGES.iter().map(|layout| &*layout.message);
            let measured: Vec<_> = sentences.chain(PACKET_MESSAGES.map(|message| message.name)).collect();
            format!("{name} cannot be measured; --set-message takes {}", measured.join(" or "))
        };
        MESSAGES.iter().all(|layout| layout.message != *name).then(refusal)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OnHangup {
    /// End as by Ctrl-C, with whole recordings and the settings restored
    Stop,
    /// Go on until the end of the data, or of the time asked for
    Continue,
}

const SIZES: [(&str, u64); 6] =
    [("GiB", 1 << 30), ("MiB", 1 << 20), ("KiB", 1 << 10), ("GB", 1_000_000_000), ("MB", 1_000_000), ("kB", 1000)];

/// Parts of less would be more files than a folder is made for.
const SMALLEST_PART: f64 = 10_000.0;

pub(super) fn rotation(text: &str) -> Result<Rotation, String> {
    let size = |(unit, bytes): &(&str, u64)| Some(text.strip_suffix(unit)?.trim().parse::<f64>().ok()? * *bytes as f64);
    match SIZES.iter().find_map(size) {
        Some(bytes) if bytes.is_finite() && bytes >= SMALLEST_PART => Ok(Rotation::Bytes(bytes as u64)),
        Some(_) => {
            Err("parts of less than 10 kB are too small; give a size such as 500MB, or a time such as 1h".into())
        }
        None => match length(text) {
            Ok(time) if time >= Duration::from_secs(1) => Ok(Rotation::Time(time)),
            Ok(_) => Err("parts of less than a second are too short; give a time such as 1h".into()),
            Err(_) => Err("neither a size, such as 500MB or 1GiB, nor a time, such as 1h".into()),
        },
    }
}

/// Of sentences or packets.
fn any_rate(text: &str) -> Result<u32, String> {
    let of_packets = |hz: &u32| *hz > 0 && MEASUREMENTS_PER_S.is_multiple_of(*hz);
    text.parse().ok().filter(|hz| of_packets(hz) || OUTPUT_RATES_HZ.contains(hz)).ok_or_else(|| {
        let of_sentences = OUTPUT_RATES_HZ.map(|hz| hz.to_string()).join(", ");
        let of_packets = (1..=MEASUREMENTS_PER_S).rev().filter(of_packets).map(|hz| hz.to_string());
        let of_packets = of_packets.collect::<Vec<_>>().join(", ");
        format!("sentences come at {of_sentences} Hz, packets at {of_packets} Hz")
    })
}

pub(super) fn baud_rate(text: &str) -> Result<BaudRate, String> {
    let speeds = || BaudRate::ALL.map(|speed| speed.bits_per_s().to_string()).join(", ");
    text.parse().ok().and_then(BaudRate::new).ok_or_else(|| format!("the sensor's baud rates are {}", speeds()))
}

fn message(text: &str) -> Result<String, String> {
    let name = text.to_ascii_uppercase();
    let sentences = (0..=u8::MAX).map(AsyncType).filter_map(AsyncType::header);
    let names = || sentences.chain(PACKET_MESSAGES.map(|message| message.name)).collect::<Vec<_>>().join(", ");
    if PacketMessage::named(&name).is_some() || AsyncType::from_header(name.as_bytes()).is_some() {
        return Ok(name);
    }
    Err(format!("the sensor's messages are {}", names()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_known_by_their_names() {
        for (text, source) in [
            ("/dev/ttyUSB0", SourceName::Port("/dev/ttyUSB0".into())),
            ("COM3", SourceName::Port("COM3".into())),
            ("sim", SourceName::Sim),
            ("./sim", SourceName::Port("./sim".into())),
            ("tcp://bench:2000", SourceName::Tcp("tcp://bench:2000".into())),
            ("-", SourceName::Stdin),
        ] {
            assert_eq!(text.parse(), Ok(source.clone()));
            assert_eq!(source.to_string(), text);
        }
    }

    #[test]
    fn a_rate_that_neither_sentences_nor_packets_have_is_answered_with_those_of_both() {
        assert_eq!((any_rate("50"), any_rate("800")), (Ok(50), Ok(800)));
        let error = any_rate("300").unwrap_err();
        assert!(error.contains("50, 100, 200 Hz, packets at 800, 400, 200, 160, "), "{error}");
    }

    #[test]
    fn parts_are_of_a_size_or_a_time() {
        for (text, expected) in [
            ("500MB", Rotation::Bytes(500_000_000)),
            ("1.5 GiB", Rotation::Bytes(1_610_612_736)),
            ("10kB", Rotation::Bytes(10_000)),
            ("1h", Rotation::Time(Duration::from_secs(3600))),
            ("90", Rotation::Time(Duration::from_secs(90))),
        ] {
            assert_eq!(rotation(text), Ok(expected), "{text}");
        }
        for wrong in ["", "9kB", "-1GB", "nanMB", "infGB", "0", "10ms", "5 apples", "MB"] {
            assert!(rotation(wrong).unwrap_err().contains("1h"), "{wrong}");
        }
    }

    #[test]
    fn a_speed_is_a_number_or_auto() {
        assert_eq!("auto".parse(), Ok(Baud(None)));
        assert_eq!("921600".parse(), Ok(Baud(Some(921_600))));
        for wrong in ["0", "-1", "fast", "115200 "] {
            assert!(wrong.parse::<Baud>().unwrap_err().contains("baud"), "{wrong}");
        }
    }
}
