//! Live sources by their names on the command line; "sim" is an emulated sensor of this program's
//! own, on a port in memory.

use std::{io, num::NonZeroU32, time::Duration};

use anyhow::Result;
use vn100_capture::Clock;
use vn100_driver::{LinkHint, LinkOptions, SerialPorts, TcpServer};
use vn100_protocol::stream::ReadOptions;
use vn100_session::{EmulatedPort, LiveSource};
use vn100_sim::{
    device::{Device, DeviceConfig},
    wire::Wire,
};

use crate::{
    args::{LinkArgs, SimSensorArgs, SourceName},
    log::Entries,
    twin::profile,
};

/// A source made ready. An emulated sensor is on as long as the source is kept.
pub(crate) fn live_source(name: &SourceName, link: &LinkArgs, read: ReadOptions, log: &Entries) -> Result<LiveSource> {
    let clock = Clock::start();
    let source = match name {
        SourceName::Stdin => LiveSource::stream(io::stdin()),
        SourceName::Tcp(address) => LiveSource::link(TcpServer::new(address, clock)?),
        SourceName::Port(port) => LiveSource::link(SerialPorts::new(port, clock)),
        SourceName::Sim => LiveSource::link(emulated_port(&link.sim, clock)?.0),
    };
    Ok(as_asked(source, name, link, read, log))
}

/// The source, opened and read as the options say.
pub(crate) fn as_asked(
    mut source: LiveSource,
    name: &SourceName,
    link: &LinkArgs,
    read: ReadOptions,
    log: &Entries,
) -> LiveSource {
    source.options = LinkOptions {
        baud: link.baud.0,
        listen_only: link.listen_only,
        read: log.asked(read),
        hint_text: Some(link_hint),
        ..LinkOptions::default()
    };
    source.observer = log.observer(&name.to_string());
    source
}

/// A hint of the link in the terms of the command line.
fn link_hint(hint: LinkHint) -> &'static str {
    match hint {
        LinkHint::AskSensor => {
            "its output may be paused, which only a request shows: remove --listen-only, or check the cable and the power of the sensor"
        }
        LinkHint::CheckBaudRate => "check the cable, the power of the sensor and --baud",
        LinkHint::ChoosePort => "\"vn100 ports\" lists the ports, those of a sensor first",
        hint => hint.text(),
    }
}

/// The sensor itself, switched off.
pub(crate) fn device(args: &SimSensorArgs) -> Result<Device> {
    // each seed is a sensor of its own
    let serial = 100_000_000 + (args.seed % 100_000_000) as u32;
    Ok(Device::new(DeviceConfig { profile: profile(args)?, seed: args.seed, serial, ..DeviceConfig::default() }))
}

/// An emulated sensor that a command starts for itself is past its boot of 1.25 s.
const ON_FOR: Duration = Duration::from_secs(2);

/// The port of the sensor that the options describe, and its baud rate.
pub(crate) fn emulated_port(args: &SimSensorArgs, clock: Clock) -> Result<(EmulatedPort, u32)> {
    let device = device(args)?;
    let host_baud = NonZeroU32::new(device.baud()).unwrap_or(NonZeroU32::MIN);
    let wire = Wire::new(device, &args.faults, args.seed, host_baud);
    Ok((EmulatedPort::new(wire, ON_FOR, clock.now_ns()), host_baud.get()))
}
