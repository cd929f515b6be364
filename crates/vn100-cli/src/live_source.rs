//! Live sources by their names on the command line.

use std::io;

use anyhow::{Context, Result};
use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;
use vn100_driver::{
    Clock, Event, LinkHandle, LinkOptions, ReadOptions, ReaderSource, SerialPorts, TcpServer, open_link, read_samples,
};

use crate::args::{Baud, LinkArgs, SourceName};

/// A source that is being opened; what comes of that, the events tell.
pub(crate) struct LiveSource {
    /// Its form, as documents name it.
    pub(crate) kind: &'static str,
    /// `None` for a stream that is no link: nothing can be sent there, and it does not come back.
    pub(crate) link: Option<LinkHandle>,
    pub(crate) events: mpsc::Receiver<Event>,
}

impl LiveSource {
    /// Begins to open a source. What it delivers is stamped, so that it goes on until `stop`.
    pub(crate) fn open(
        source: &SourceName,
        args: &LinkArgs,
        read: ReadOptions,
        stop: CancellationToken,
    ) -> Result<Self> {
        let clock = Clock::start();
        let baud = match args.baud {
            Baud::Auto => None,
            Baud::Fixed(baud) => Some(baud),
        };
        let options = LinkOptions { baud, listen_only: args.listen_only, read, ..LinkOptions::default() };
        let (kind, (link, events)) = match source {
            SourceName::Port(name) => ("serial", open_link(SerialPorts::new(name, clock), options, stop)),
            SourceName::Tcp(address) => ("tcp", open_link(TcpServer::new(address, clock)?, options, stop)),
            SourceName::Stdin => {
                let reader = ReaderSource::spawn_live(io::stdin(), clock).context("cannot start the reading thread")?;
                return Ok(Self { kind: "stdin", link: None, events: read_samples(reader, read, stop) });
            }
        };
        Ok(Self { kind, link: Some(link), events })
    }
}
