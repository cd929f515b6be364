//! What becomes of everything that a link delivers: a copy for the recording, the parser, the
//! events.

use std::{
    collections::BTreeMap,
    io,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};

use tokio::{sync::mpsc, time::timeout};
use vn100_protocol::{AsyncType, Reply};

use crate::health::Seen;
use vn100_capture::{End, Event, LossySender};
use vn100_protocol::stream::{Input, ReadOptions, SampleReader};

/// How long a recording that is full may take to make room for the last link events.
const LAST_EVENTS: Duration = Duration::from_secs(1);

/// Nobody receives the events any more.
#[derive(Debug)]
pub(crate) struct NobodyListens;

/// What others may look up at any time.
#[derive(Debug, Default)]
pub(crate) struct Counters {
    /// Bytes that the recording did not take in time.
    pub(crate) unrecorded_bytes: AtomicU64,
    /// Good lines so far, by the code of their message.
    lines: Mutex<BTreeMap<u8, u64>>,
}

impl Counters {
    /// Good lines of this message so far; for one without a name all that have none.
    pub(crate) fn lines(&self, message: AsyncType) -> u64 {
        let message = if message.header().is_some() { message } else { AsyncType::OFF };
        self.all_lines().get(&message.0).copied().unwrap_or_default()
    }

    /// Good lines so far, whatever their message.
    pub(crate) fn lines_of_all(&self) -> u64 {
        self.all_lines().values().sum()
    }

    fn all_lines(&self) -> MutexGuard<'_, BTreeMap<u8, u64>> {
        // counts are whole whoever panicked over them
        self.lines.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

pub(crate) struct LinkOutput {
    parser: SampleReader,
    events: mpsc::Sender<Event>,
    recording: Option<LossySender>,
    counters: Arc<Counters>,
}

impl LinkOutput {
    pub(crate) fn new(
        options: ReadOptions,
        recording: Option<mpsc::Sender<Input>>,
        events: mpsc::Sender<Event>,
        counters: Arc<Counters>,
    ) -> Self {
        let mut parser = SampleReader::new(options);
        parser.keep_replies();
        Self { parser, events, recording: recording.map(LossySender::new), counters }
    }

    /// Takes the next input of the link.
    pub(crate) async fn put(&mut self, input: Input, now_ns: i64) -> Result<(), NobodyListens> {
        if let Some(recording) = &mut self.recording {
            // bytes are shared, not copied
            recording.send(input.clone(), now_ns);
            self.counters.unrecorded_bytes.store(recording.lost_bytes(), Ordering::Relaxed);
        }
        let events = Event::from_input(&mut self.parser, input);
        self.counters.all_lines().extend(self.parser.lines());
        for event in events {
            self.events.send(event).await.map_err(|_| NobodyListens)?;
        }
        Ok(())
    }

    /// Notes that a command was written.
    pub(crate) fn note_sent(&mut self, line: &[u8]) {
        self.parser.note_sent(line);
    }

    /// What the stream has carried so far. A line with a right checksum counts, whatever else may
    /// be wrong with it: the link carries a sensor.
    pub(crate) fn seen(&self) -> Seen {
        let tally = self.parser.tally();
        let unasked = tally.samples + tally.other + tally.packets + tally.bad.grammar + tally.bad.range;
        Seen { understood: unasked + tally.replies, unasked }
    }

    /// The sensor's answers since the last call.
    pub(crate) fn take_replies(&mut self) -> Vec<Reply> {
        self.parser.take_replies()
    }

    /// Waits until nobody receives the events any more.
    pub(crate) fn nobody_listens(&self) -> impl Future<Output = ()> + use<> {
        let events = self.events.clone();
        async move { events.closed().await }
    }

    /// Ends the stream.
    pub(crate) async fn finish(self, error: Option<io::Error>) {
        let Self { mut parser, events, recording, .. } = self;
        for batch in parser.finish() {
            // a receiver that left has no use for the end either
            let _ = events.send(Event::Batch(batch)).await;
        }
        let _ = events.send(Event::End(End { error, csv: None })).await;
        drop(events);
        if let Some(mut recording) = recording {
            let _ = timeout(LAST_EVENTS, recording.send_waiting_async()).await;
        }
    }
}
