//! The options of `sim`.

use std::{
    net::{Ipv4Addr, SocketAddr},
    path::PathBuf,
    time::Duration,
};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use vn100_protocol::{AsyncType, MESSAGES, PACKET_MESSAGES, PacketMessage};
use vn100_sim::Message;

use super::{ForceArgs, duration::duration, link::SimSensorArgs};

#[derive(Debug, clap::Args)]
pub(crate) struct SimArgs {
    /// Write a capture at once instead of emulating a port, with a time for each line where the
    /// name ends in .mcap; "-" is standard output
    #[arg(short, long, help_heading = "Capture", value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    /// Length of the capture [default: 60s], or how long to emulate the port [default: until
    /// stopped]; for example 5h; a number without a unit is seconds
    #[arg(short, long, help_heading = "Capture", value_name = "T", value_parser = duration)]
    pub(crate) duration: Option<Duration>,

    /// Output rate of the capture in hertz, one the sensor has: 1 2 4 5 10 20 25 40 50 100 200, of
    /// packets any whole part of 800 [default: 40, or that of the measurement]
    #[arg(short, long, help_heading = "Capture", value_name = "HZ", requires = "output")]
    pub(crate) rate: Option<u32>,

    /// Message of the capture
    #[arg(long, help_heading = "Capture", value_name = "NAME", value_parser = sim_message(), ignore_case = true, default_value = "VNYMR", requires = "output")]
    pub(crate) message: CaptureMessage,

    #[command(flatten)]
    pub(crate) sensor: SimSensorArgs,

    /// Symbolic link to the emulated port, a pseudo-terminal of Linux; PATH-1 after an unplugging with `:other`
    #[arg(long, help_heading = "Emulated port", value_name = "PATH", conflicts_with = "output")]
    pub(crate) link: Option<PathBuf>,

    /// Serve the sensor at a TCP address instead of a pseudo-terminal, as on systems other than
    /// Linux [default: 127.0.0.1 and a free port]
    #[arg(long, help_heading = "Emulated port", value_name = "ADDRESS:PORT", num_args = 0..=1, default_missing_value = ANY_PORT,
        conflicts_with_all = ["output", "link"])]
    tcp: Option<SocketAddr>,

    #[command(flatten)]
    pub(crate) existing: ForceArgs,
}

/// This machine alone can open it, at a port that the system chooses.
const ANY_PORT: &str = "127.0.0.1:0";

impl SimArgs {
    /// The address at which the sensor is served: the one asked for, or one of this machine alone if the system has no pseudo-terminals
    /// that report their openings. `None` for a pseudo-terminal.
    pub(crate) fn tcp_address(&self) -> Option<SocketAddr> {
        let own = || (cfg!(not(target_os = "linux")) && self.link.is_none()).then_some((Ipv4Addr::LOCALHOST, 0).into());
        self.tcp.or_else(own)
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum CaptureMessage {
    Sentence(&'static Message),
    Packets(PacketMessage),
}

/// The messages of emulated captures: those that are measured.
fn sim_message() -> impl TypedValueParser<Value = CaptureMessage> {
    let described = MESSAGES.iter().map(|layout| {
        let message = AsyncType::from_header(layout.message.as_bytes());
        PossibleValue::new(&*layout.message).help(message.and_then(AsyncType::description).unwrap_or_default())
    });
    let packets = PACKET_MESSAGES.map(|packets| PossibleValue::new(packets.name).help(packets.description));
    PossibleValuesParser::new(described.chain(packets)).try_map(|name| {
        let packets = PacketMessage::named(&name).map(CaptureMessage::Packets);
        let sentence = || Message::named(&name.to_ascii_uppercase()).map(CaptureMessage::Sentence);
        packets.or_else(sentence).ok_or("the emulated sensor does not send it")
    })
}
