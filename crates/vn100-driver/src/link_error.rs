//! The reasons why a link is lost or cannot be connected, in words for its user.

use std::io::{self, ErrorKind};

use thiserror::Error;
use vn100_protocol::{DeviceError, RequestFailure};

use crate::{
    connect::{ConnectError, PortProblem},
    question::without_echoes,
};

/// The reason why a link is lost or cannot be connected.
#[derive(Debug, Error)]
pub(crate) enum LinkError {
    #[error(transparent)]
    Open(#[from] ConnectError),
    #[error("{}", lost(.0))]
    Lost(#[from] io::Error),
    #[error("no sensor found on {port}{}: {}", at_speeds(tried), received_instead(*bytes, *echoes))]
    NoSensor {
        port: String,
        tried: Vec<u32>,
        bytes: u64,
        /// Copies of the question of the baud scan that are among the bytes.
        echoes: u64,
        asked: bool,
    },
    #[error("no sensor found on {port}{}, but {}", at_speeds(baud.as_slice()), other_device(sentences))]
    OtherDevice { port: String, baud: Option<u32>, sentences: Vec<String> },
    #[error("{bytes} bytes received in {ms} ms contain no valid sentence")]
    Garbled { bytes: u64, ms: u128 },
    #[error("the server closed the connection: it stopped, or serves the port to another program")]
    Disconnected,
    #[error("the sensor sends nothing and does not reply")]
    NoAnswer,
    #[error("{0}")]
    Restarted(DeviceError),
    #[error("the sensor was silent, and may have restarted")]
    SettingsLost,
    #[error("another sensor is on the port: serial number {serial}, expected {known}")]
    OtherSensor { serial: String, known: String },
    #[error("the sensor reconnected, but its settings cannot be reapplied: {0}")]
    NotSet(#[from] RequestFailure),
}

/// The remedies for the user if no sensor answers. An application puts each hint into words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LinkHint {
    /// Let the link send a question, because the output of the sensor may be paused: the link only
    /// listens, and receives nothing.
    AskSensor,
    /// Find the connection between the two directions of the line: it echoes.
    FindEcho,
    /// Check the cable, the power, and the baud rate at which the server has opened its port.
    CheckServerBaudRate,
    /// Check the cable, the power, and the baud rate of the port.
    CheckBaudRate,
    /// Choose another port: another device is on this one.
    ChoosePort,
    /// Choose another port of the server: another device is on this one.
    ChooseServerPort,
}

impl LinkHint {
    /// The hint in words; an application may have [others](crate::LinkOptions::hint_text).
    pub fn text(self) -> &'static str {
        match self {
            Self::AskSensor => {
                "its output may be paused, which only a request can show: allow sending, or check the \
                 cable and the power of the sensor"
            }
            Self::FindEcho => "take a loopback plug off; on RS-485 check the wires and the power of the sensor",
            Self::CheckServerBaudRate => {
                "check the cable and the power of the sensor, and the baud rate set on the server"
            }
            Self::CheckBaudRate => "check the cable, the power of the sensor and the baud rate",
            Self::ChoosePort => "choose the port of the sensor",
            Self::ChooseServerPort => "choose the port of the server behind which the sensor is",
        }
    }
}

impl LinkError {
    /// Whether another attempt can succeed only after the user has done something.
    pub(crate) fn needs_help(&self) -> bool {
        use PortProblem::{Busy, Denied};
        matches!(self, Self::Open(ConnectError::Port { problem: Busy(_) | Denied(_), .. }) | Self::NotSet(_))
    }

    /// The remedy for the user, unless the text of the error contains it.
    pub(crate) fn hint(&self) -> Option<LinkHint> {
        Some(match self {
            Self::OtherDevice { baud: Some(_), .. } => LinkHint::ChoosePort,
            Self::OtherDevice { baud: None, .. } => LinkHint::ChooseServerPort,
            Self::NoSensor { bytes: 0, asked: false, .. } => LinkHint::AskSensor,
            Self::NoSensor { echoes: 1.., .. } => LinkHint::FindEcho,
            Self::NoSensor { tried, .. } if tried.is_empty() => LinkHint::CheckServerBaudRate,
            Self::NoSensor { .. } => LinkHint::CheckBaudRate,
            _ => return None,
        })
    }
}

fn lost(error: &io::Error) -> String {
    // a write to an unplugged adapter fails with EIO, ENXIO or ENODEV
    let is_gone = cfg!(unix) && matches!(error.raw_os_error(), Some(5 | 6 | 19));
    match error.kind() {
        _ if is_gone => GONE.into(),
        ErrorKind::BrokenPipe => GONE.into(),
        ErrorKind::UnexpectedEof | ErrorKind::ConnectionReset | ErrorKind::ConnectionAborted => {
            LinkError::Disconnected.to_string()
        }
        _ => format!("disconnected: {error}"),
    }
}

const GONE: &str = "the port disappeared, as when the cable is unplugged or the adapter loses power";

/// A device that sends these sentences, in words. Names of NMEA 0183 have two letters for the talker
/// and three for the message, or a `P` and the letters of a maker.
fn other_device(names: &[String]) -> String {
    let is_nmea =
        |name: &String| name.starts_with('P') || name.len() == 5 && !name.contains(|c: char| c.is_ascii_digit());
    let device = match names.iter().all(is_nmea) {
        true => "a device that sends NMEA sentences, such as a GPS",
        false => "another device that sends sentences",
    };
    format!("{device}: ${}", names.join(", $"))
}

fn at_speeds(tried: &[u32]) -> String {
    match tried {
        [] => String::new(),
        [baud] => format!(" at {baud} baud"),
        several => format!(" at {} baud rates", several.len()),
    }
}

/// The words for `bytes` that were received in place of a sensor, including `echoes` copies of the
/// question.
fn received_instead(bytes: u64, echoes: u64) -> String {
    let others = without_echoes(bytes, echoes);
    match (echoes, others) {
        (0, 0) => "no data received".into(),
        (0, bytes) => format!("{bytes} bytes received without a valid sentence"),
        (_, 0) => "the line echoes, and only the sent bytes were received".into(),
        (_, bytes) => format!("the line echoes, and {bytes} other bytes were received without a valid sentence"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_port_is_described_without_the_words_of_the_system() {
        let gone = [5, 6, 19].map(io::Error::from_raw_os_error);
        let closed = [ErrorKind::UnexpectedEof, ErrorKind::ConnectionReset, ErrorKind::ConnectionAborted];
        for error in gone.into_iter().chain([ErrorKind::BrokenPipe.into()]) {
            assert_eq!(LinkError::from(error).to_string(), GONE);
        }
        for kind in closed {
            assert_eq!(LinkError::from(io::Error::from(kind)).to_string(), LinkError::Disconnected.to_string());
        }
        let other = LinkError::from(io::Error::other("a fault")).to_string();
        assert_eq!(other, "disconnected: a fault");
    }

    #[test]
    fn another_device_is_named_by_its_output() {
        let error = |baud, sentences: &[&str]| {
            let sentences = sentences.iter().copied().map(String::from).collect();
            LinkError::OtherDevice { port: "x".into(), baud, sentences }.to_string()
        };
        assert_eq!(
            error(Some(9600), &["GPGGA", "GPRMC"]),
            "no sensor found on x at 9600 baud, but a device that sends NMEA sentences, such as a GPS: $GPGGA, $GPRMC"
        );
        assert_eq!(error(None, &["IMU"]), "no sensor found on x, but another device that sends sentences: $IMU");
        assert!(error(None, &["PUBX"]).contains("NMEA"));
    }

    #[test]
    fn the_hint_fits_the_received_bytes() {
        let no_sensor = |tried: &[u32], bytes, echoes, asked| {
            let tried = tried.into();
            LinkError::NoSensor { port: "x".into(), tried, bytes, echoes, asked }
        };
        let cases = [
            (no_sensor(&[9600], 0, 0, true), LinkHint::CheckBaudRate, "x at 9600 baud: no data received"),
            (no_sensor(&[9600], 1, 0, false), LinkHint::CheckBaudRate, "1 bytes received without a valid sentence"),
            (no_sensor(&[9600, 19_200], 0, 0, false), LinkHint::AskSensor, "x at 2 baud rates: no data received"),
            (no_sensor(&[], 0, 0, true), LinkHint::CheckServerBaudRate, "x: no data received"),
            (no_sensor(&[], 28, 2, true), LinkHint::FindEcho, "echoes, and only the sent bytes were received"),
            (no_sensor(&[], 29, 2, true), LinkHint::FindEcho, "echoes, and 1 other bytes were received without a"),
        ];
        for (error, hint, text) in cases {
            assert_eq!(error.hint(), Some(hint), "{error}");
            assert!(error.to_string().contains(text), "{error}");
            assert!(!hint.text().contains("--"), "names no flag");
        }
        assert_eq!(LinkError::NoAnswer.hint(), None);
    }
}
