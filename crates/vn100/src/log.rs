//! Diagnostics: link events, commands and replies, rejected lines and why.
//!
//! A thread of its own writes them: measuring never waits for it. Entries that it does not take in
//! time are dropped, and counted.

use std::{
    io::{self, IsTerminal},
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
        mpsc::{self as blocking, SyncSender},
    },
    thread::{self, JoinHandle},
    time::SystemTime,
};

use anyhow::{Context, Result};
use tokio::runtime::Builder;
use vn100_capture::Event;
use vn100_driver::LinkState;
use vn100_protocol::stream::{FileReport, LinkEventKind, ReadOptions, RejectedRows};
use vn100_session::EventObserver;

use crate::{args::LogArgs, exit::report};

/// Entries that may wait; a stream of nothing but refused lines fills them in a second.
const WAITING_ENTRIES: usize = 4096;

/// Diagnostics as the options ask for them, from here on until it is dropped.
struct Log {
    entries: Entries,
    writer: Option<JoinHandle<()>>,
}

/// Where diagnostics go; nowhere by default.
#[derive(Clone, Default)]
pub(crate) struct Entries {
    sender: Option<SyncSender<Option<String>>>,
    lost: Arc<AtomicU64>,
}

impl Log {
    fn open(args: &LogArgs) -> Result<Self> {
        if !args.verbose {
            return Ok(Self { entries: Entries::default(), writer: None });
        }
        let (sender, inbox) = blocking::sync_channel(WAITING_ENTRIES);
        let entries = Entries { sender: Some(sender), lost: Arc::default() };
        let lost = Arc::clone(&entries.lost);
        // ends with the log
        let writer = thread::Builder::new().name("log".into()).spawn(move || {
            while let Ok(Some(entry)) = inbox.recv() {
                report(&entry);
                let lost = lost.swap(0, Ordering::Relaxed);
                if lost > 0 {
                    report(&format!("{lost} entries are missing here: they arrived faster than the log is written"));
                }
            }
        });
        Ok(Self { entries, writer: Some(writer.context("cannot start the thread of the log")?) })
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        if let Some(sender) = &self.entries.sender {
            // after all entries; a writer that has ended needs no end mark
            let _ = sender.send(None);
        }
        if let Some(writer) = self.writer.take() {
            // one that panicked has nothing more to write
            let _ = writer.join();
        }
    }
}

impl Entries {
    pub(crate) fn asked(&self, read: ReadOptions) -> ReadOptions {
        ReadOptions { diagnostics: self.sender.is_some(), ..read }
    }

    /// What sees the events of the source of that name; nothing if no log is kept.
    pub(crate) fn observer(&self, name: &str) -> Option<EventObserver> {
        self.sender.as_ref()?;
        let (entries, name) = (self.clone(), name.to_owned());
        Some(Arc::new(move |event| entries.event(&name, event)))
    }

    fn event(&self, name: &str, event: &Event) {
        match event {
            Event::Batch(batch) => {
                batch.diagnostics.iter().for_each(|diagnostic| self.put(name, &diagnostic.to_string()));
            }
            Event::Link(event) => self.put(name, &link_event(&event.kind)),
            Event::End(end) => {
                if let Some(FileReport::Csv(csv)) = &end.report {
                    csv.rejected.iter().for_each(|rows| self.put(name, &refused_rows(rows)));
                }
                match &end.error {
                    Some(error) => self.put(name, &format!("ended: {error}")),
                    None => self.put(name, "ended"),
                }
            }
        }
    }

    pub(crate) fn link_state(&self, name: &str, state: &LinkState) {
        if let LinkState::Down { cause, retry_in, .. } = state {
            self.put(name, &format!("retrying in {} ms: {cause}", retry_in.as_millis()));
        }
    }

    fn put(&self, name: &str, text: &str) {
        let Some(sender) = &self.sender else { return };
        let now = humantime::format_rfc3339_millis(SystemTime::now());
        if sender.try_send(Some(format!("{now} {name}: {text}"))).is_err() {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// Runs `work` on that runtime, with a log as the options ask for it.
pub(crate) fn run_logged<T>(
    runtime: &mut Builder,
    args: &LogArgs,
    work: impl AsyncFnOnce(Entries) -> Result<T>,
) -> Result<T> {
    let log = Log::open(args)?;
    let runtime = runtime.enable_all().build().context("cannot start the worker threads")?;
    let result = runtime.block_on(work(log.entries.clone()));
    // a thread may hang in a read of standard input that is no longer needed
    runtime.shutdown_background();
    result
}

/// Whether diagnostics would be written over what else is shown on the terminal.
pub(crate) fn takes_terminal(args: &LogArgs) -> bool {
    args.verbose && io::stderr().is_terminal()
}

fn link_event(kind: &LinkEventKind) -> String {
    match kind {
        LinkEventKind::Up { port, baud: Some(baud) } => format!("connected: {port} at {baud} baud"),
        LinkEventKind::Up { port, baud: None } => format!("connected: {port}"),
        LinkEventKind::Down { cause } => format!("disconnected: {cause}"),
        LinkEventKind::DiscardedDuringBaudScan { bytes } => {
            format!("{bytes} bytes arrived before the sensor was identified")
        }
        LinkEventKind::Overrun { bytes } => format!("{bytes} bytes were lost before they were read"),
        LinkEventKind::UnsolicitedError { error } => {
            format!("unsolicited device error: {error}")
        }
        LinkEventKind::OutputResumed => "the output of the sensor was paused, and is resumed".into(),
        LinkEventKind::Marked { text } => format!("marked: {text}"),
        LinkEventKind::PortShared { program } => format!("{program} has the port open too"),
        LinkEventKind::Closed => "closed while it was lost".into(),
        LinkEventKind::OutputPaused => "the output of the sensor is paused again, as before".into(),
    }
}

fn refused_rows(RejectedRows { count, reason, first_line, first_text }: &RejectedRows) -> String {
    format!("rejected {count} rows, {reason}: the first in line {first_line}: {first_text}")
}
