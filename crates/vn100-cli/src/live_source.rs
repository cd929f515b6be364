//! Live sources by their names on the command line.

use std::io;

use anyhow::Result;
use vn100_capture::Clock;
use vn100_driver::{LinkHint, SerialPorts, TcpServer};
use vn100_pipeline::LiveSource;

use crate::{
    args::{Baud, LinkArgs, SourceName},
    emulated_port::EmulatedPort,
    log::Entries,
};

/// A source made ready, with the emulated sensor if it is one: that stays on as long as it is kept.
pub(crate) fn live_source(
    name: &SourceName,
    link: &LinkArgs,
    log: &Entries,
) -> Result<(LiveSource, Option<EmulatedPort>)> {
    let clock = Clock::start();
    let (mut source, emulated) = match name {
        SourceName::Stdin => (LiveSource::stream(io::stdin()), None),
        SourceName::Tcp(address) => (LiveSource::link(TcpServer::new(address, clock)?), None),
        SourceName::Port(port) => (LiveSource::link(SerialPorts::new(port, clock)), None),
        SourceName::Sim => {
            let emulated = EmulatedPort::start(&link.sim)?;
            (LiveSource::link(emulated.ports(clock)), Some(emulated))
        }
    };
    source.baud = match link.baud {
        Baud::Auto => None,
        Baud::Fixed(baud) => Some(baud),
    };
    source.hint_text = Some(link_hint);
    source.listen_only = link.listen_only;
    source.diagnostics = log.is_open();
    source.observer = log.observer(&name.to_string());
    Ok((source, emulated))
}

/// A hint of the link in the terms of the command line.
fn link_hint(hint: LinkHint) -> &'static str {
    match hint {
        LinkHint::AskSensor => {
            "its output may be paused, which cannot be told without asking it: leave --listen-only out, or check the cable and the power \
             of the sensor"
        }
        LinkHint::CheckBaudRate => "check the cable, the power of the sensor and --baud",
        hint => hint.text(),
    }
}
