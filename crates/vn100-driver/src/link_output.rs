//! What becomes of everything that a link delivers: a copy for the recording, the parser, the events.

use std::{
    io,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use tokio::sync::mpsc;

use crate::{
    event::{End, Event},
    lossy_sender::LossySender,
    read_samples::{Parser, ReadOptions},
    source::Input,
};

/// Nobody receives the events any more.
#[derive(Debug)]
pub(crate) struct NobodyListens;

pub(crate) struct LinkOutput {
    parser: Parser,
    events: mpsc::Sender<Event>,
    recording: Option<LossySender>,
    unrecorded_bytes: Arc<AtomicU64>,
}

impl LinkOutput {
    pub(crate) fn new(
        options: ReadOptions,
        recording: Option<mpsc::Sender<Input>>,
        events: mpsc::Sender<Event>,
        unrecorded_bytes: Arc<AtomicU64>,
    ) -> Self {
        Self { parser: Parser::new(options), events, recording: recording.map(LossySender::new), unrecorded_bytes }
    }

    /// Takes the next input of the link.
    pub(crate) async fn put(&mut self, input: Input, now_ns: i64) -> Result<(), NobodyListens> {
        if let Some(recording) = &mut self.recording {
            // bytes are shared, not copied
            recording.send(input.clone(), now_ns);
            self.unrecorded_bytes.store(recording.lost_bytes(), Ordering::Relaxed);
        }
        for event in self.parser.take_input(input) {
            self.events.send(event).await.map_err(|_| NobodyListens)?;
        }
        Ok(())
    }

    /// Lines and packets so far whose checksum was right, whatever else may be wrong with them: the link carries a sensor.
    pub(crate) fn understood(&self) -> u64 {
        let tally = self.parser.tally();
        tally.good_lines() + tally.packets + tally.bad.grammar + tally.bad.range
    }

    /// Waits until nobody receives the events any more.
    pub(crate) async fn nobody_listens(&self) {
        self.events.closed().await;
    }

    /// Ends the stream.
    pub(crate) async fn finish(mut self, error: Option<io::Error>) {
        for batch in self.parser.finish() {
            // a receiver that left has no use for the end either
            let _ = self.events.send(Event::Batch(batch)).await;
        }
        let _ = self.events.send(Event::End(End { error, csv: None })).await;
    }
}
