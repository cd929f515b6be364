//! Options of every command that talks to a live sensor.

use std::{convert::Infallible, fmt, str::FromStr};

use clap::Args;

/// Where a live stream comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum SourceName {
    /// A serial port by its path or name.
    Port(String),
    /// A serial server, `tcp://host:port`.
    Tcp(String),
    /// Bytes on standard input.
    Stdin,
}

impl FromStr for SourceName {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(match text {
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
            Self::Stdin => f.write_str("-"),
        }
    }
}

/// Speed of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Baud {
    /// Found by listening and asking.
    Auto,
    /// Given.
    Fixed(u32),
}

impl FromStr for Baud {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            _ if text == "auto" => Ok(Self::Auto),
            Ok(baud) if baud > 0 => Ok(Self::Fixed(baud)),
            _ => Err("not a speed in baud, such as 115200, and not \"auto\"".into()),
        }
    }
}

/// How the link is opened.
#[derive(Debug, Args)]
pub(crate) struct LinkArgs {
    /// Speed of the line in baud, or "auto": the nine speeds of the sensor are tried
    #[arg(long, value_name = "N", default_value = "auto")]
    pub(crate) baud: Baud,

    /// Send nothing to the sensor: for shared or one-way cables
    #[arg(long)]
    pub(crate) listen_only: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_come_back_by_their_names() {
        for (text, source) in [
            ("/dev/ttyUSB0", SourceName::Port("/dev/ttyUSB0".into())),
            ("COM3", SourceName::Port("COM3".into())),
            ("tcp://bench:2000", SourceName::Tcp("tcp://bench:2000".into())),
            ("-", SourceName::Stdin),
        ] {
            assert_eq!(text.parse(), Ok(source.clone()));
            assert_eq!(source.to_string(), text);
        }
    }

    #[test]
    fn a_speed_is_a_number_or_auto() {
        assert_eq!("auto".parse(), Ok(Baud::Auto));
        assert_eq!("921600".parse(), Ok(Baud::Fixed(921_600)));
        for wrong in ["0", "-1", "fast", "115200 "] {
            assert!(wrong.parse::<Baud>().unwrap_err().contains("baud"), "{wrong}");
        }
    }
}
