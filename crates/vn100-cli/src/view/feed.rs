//! What whoever measures lets the view see of a source, and how the view is heard.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use tokio::sync::{mpsc, watch};
use vn100_analysis::{Analysis, Assessment, Settings, Snapshot, SourceFacts};
use vn100_capture::RecordingState;
use vn100_driver::LinkState;
use vn100_pipeline::{Controls, Position};
use vn100_report::printable;

use super::{source::Source, state::SourceRequest};

/// Wishes of the view that may wait; more are refused, and told so.
const WAITING_REQUESTS: usize = 8;

/// Messages that are kept until the end; the oldest go first.
const MOST_NOTICES: usize = 100;

/// How far a source has come.
#[derive(Debug, Clone)]
pub(crate) enum SourceStage {
    Preparing,
    Measuring(Live),
    /// With what ended it, unless it was asked for, and what was measured.
    Ended(Option<String>, Option<Live>),
}

/// A measurement under way. The view looks at the latest of everything and delays nobody.
#[derive(Debug, Clone)]
pub(crate) struct Live {
    /// Where the samples come from, as the result will say.
    pub(crate) origin: Arc<SourceFacts>,
    pub(crate) latest: watch::Receiver<Arc<Snapshot>>,
    pub(crate) link: Option<watch::Receiver<LinkState>>,
    pub(crate) recording: Option<watch::Receiver<RecordingState>>,
    /// Where a replay is, and how many samples its capture has.
    pub(crate) playback: Option<(watch::Receiver<Position>, watch::Receiver<Option<u64>>)>,
    pub(crate) controls: mpsc::Sender<SourceRequest>,
}

/// A source as the view sees it.
#[derive(Debug)]
pub(crate) struct Feed {
    pub(crate) name: String,
    pub(crate) kind: Option<&'static str>,
    pub(crate) stage: watch::Receiver<SourceStage>,
}

impl Feed {
    /// The source before anything is known of it.
    pub(crate) fn nothing(&self, confidence: f64) -> Source {
        let snapshot = Analysis::new(Settings::default()).snapshot();
        let assessment = Assessment::new(&snapshot, confidence);
        let origin = SourceFacts { name: self.name.clone(), kind: self.kind, ..SourceFacts::default() };
        Source::new(self.name.clone(), origin, Arc::new(snapshot), Arc::new(assessment))
    }
}

/// Where whoever measures a source shows how it stands.
#[derive(Debug)]
pub(crate) struct Stand {
    stage: watch::Sender<SourceStage>,
}

/// A source that nobody measures yet, for both sides.
pub(crate) fn feed(name: &str, kind: Option<&'static str>) -> (Stand, Feed) {
    let (sender, stage) = watch::channel(SourceStage::Preparing);
    (Stand { stage: sender }, Feed { name: printable(name), kind, stage })
}

/// Wishes of the view, for both sides.
pub(crate) fn controls() -> (mpsc::Sender<SourceRequest>, mpsc::Receiver<SourceRequest>) {
    mpsc::channel(WAITING_REQUESTS)
}

impl Stand {
    /// It is being measured.
    pub(crate) fn measuring(&self, live: Live) {
        self.stage.send_replace(SourceStage::Measuring(live));
    }

    /// Nothing more comes.
    pub(crate) fn ended(&self, reason: Option<String>) {
        self.stage.send_modify(|stage| {
            let live = match stage {
                SourceStage::Preparing => None,
                SourceStage::Measuring(live) => Some(live.clone()),
                SourceStage::Ended(_, live) => live.clone(),
            };
            *stage = SourceStage::Ended(reason.as_deref().map(printable), live);
        });
    }
}

/// What would be written to the terminal if it were free: shown in the view, and written when it is
/// over.
#[derive(Debug, Clone, Default)]
pub(crate) struct Notices {
    inner: Arc<Mutex<NoticesInner>>,
}

#[derive(Debug, Default)]
struct NoticesInner {
    all: VecDeque<String>,
    seen: bool,
}

impl Notices {
    /// Adds one.
    pub(crate) fn tell(&self, notice: String) {
        let mut inner = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        if inner.all.len() == MOST_NOTICES {
            inner.all.pop_front();
        }
        inner.all.push_back(notice);
        inner.seen = false;
    }

    /// The latest, if it was not asked for before.
    pub(crate) fn news(&self) -> Option<String> {
        let mut inner = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        if std::mem::replace(&mut inner.seen, true) { None } else { inner.all.back().map(|notice| printable(notice)) }
    }

    /// All, to be written down.
    pub(crate) fn take(&self) -> Vec<String> {
        let mut inner = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        inner.all.drain(..).collect()
    }
}

/// What was left out by hand while a source was measured.
#[derive(Debug, Default)]
pub(crate) struct LeftOut {
    /// Data time before the measurement was last started over.
    before: Duration,
    /// Data time behind that, which was warm-up.
    warm_up: Duration,
    /// The measurement began with this as its skip.
    carried: bool,
}

impl LeftOut {
    /// Passes a wish on to the measurement; what to tell of it. Wishes for a capture are not its
    /// business.
    pub(crate) async fn obey(&mut self, wish: SourceRequest, controls: &Controls) -> Option<String> {
        let time = |time: Duration| super::format::time(time.as_secs_f64());
        match wish {
            SourceRequest::EndWarmUp => {
                self.warm_up = controls.end_warm_up().await?;
                Some(format!("the first {} are left out, as by {}", time(self.warm_up), self.option()?))
            }
            SourceRequest::StartOver => {
                let past = controls.start_over().await?;
                self.before = self.before.saturating_add(past);
                // a skip that was carried would count again from here
                self.warm_up = if self.carried { controls.end_warm_up().await? } else { Duration::ZERO };
                Some(format!("started over after {}", time(past)))
            }
            _ => None,
        }
    }

    /// The same for another measurement from the beginning of the record that is to come as far as
    /// `place` of data time, with what to tell of it. A mark that lies behind that place is
    /// dropped.
    pub(crate) fn carried_to(&self, place: Duration) -> (Self, Option<String>) {
        let skip = self.skip();
        let time = super::format::time(skip.as_secs_f64());
        if skip.is_zero() {
            (Self::default(), None)
        } else if skip <= place {
            let told = format!("the first {time} are still left out");
            (Self { before: Duration::ZERO, warm_up: skip, carried: true }, Some(told))
        } else {
            (
                Self::default(),
                Some(format!("nothing is left out by hand any more: the mark was at {time}, behind this place")),
            )
        }
    }

    /// The skip a measurement has from its start that leaves out the same; `asked` where nothing
    /// was left out by hand.
    pub(crate) fn skip_or(&self, asked: Duration) -> Duration {
        if self.skip().is_zero() { asked } else { self.skip() }
    }

    fn skip(&self) -> Duration {
        self.before.saturating_add(self.warm_up)
    }

    /// The option by which the whole record gives the same samples; `None` where nothing was left
    /// out.
    pub(crate) fn option(&self) -> Option<String> {
        let skip = self.skip();
        (!skip.is_zero()).then(|| format!("--skip {:.3}s", skip.as_secs_f64()))
    }
}
