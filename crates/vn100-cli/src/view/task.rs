//! The thread that has the terminal: listens to it, gathers what is shown, draws. Whatever it waits
//! for, nobody waits for it.

use std::{
    io,
    sync::{Arc, atomic::Ordering},
    time::{Duration, Instant},
};

use ratatui::{
    buffer::Buffer,
    crossterm::event::{Event, KeyEventKind},
};
use tokio_util::sync::CancellationToken;
use vn100_analysis::Assessments;
use vn100_report::Evaluation;

use super::{
    Signals,
    draw::draw,
    feed::{Feed, Notices, SourceStage},
    mouse::mouse,
    save::save,
    scene::{Regions, Scene},
    source::{Playback, Source, Stage},
    state::{Request, SourceRequest, State},
    terminal::{Screen, next_event},
    theme::Theme,
};

/// At most fifteen screens a second.
const FRAME: Duration = Duration::from_millis(67);

/// How often new results are looked for: numbers that change faster cannot be read.
const LOOK: Duration = Duration::from_millis(250);

/// How long a message stands where the keys are otherwise.
const TOLD_FOR: Duration = Duration::from_secs(6);

/// What the view and the program tell each other.
pub(crate) struct Shared {
    /// The view asks for the end.
    pub(crate) stop: CancellationToken,
    /// The program asks the view to end.
    pub(crate) close: CancellationToken,
    pub(crate) signals: Signals,
    pub(crate) notices: Notices,
    pub(crate) evaluation: Arc<Evaluation>,
}

/// How the view ended.
#[derive(Debug)]
pub(crate) enum Ended {
    /// It was closed; with the last screen to be left on the terminal, if asked.
    Closed(Option<String>),
    /// The terminal is gone.
    TerminalGone,
}

/// One source, as the view follows it.
struct Followed {
    feed: Feed,
    assessments: Assessments,
    shown: Source,
}

impl Followed {
    /// Takes what is new; tells whether anything was.
    fn look(&mut self, elapsed: Duration, evaluation: &Evaluation) -> bool {
        let before = self.shown.elapsed.as_secs();
        self.shown.elapsed = elapsed;
        let mut changed = elapsed.as_secs() != before;
        let stage = self.feed.stage.borrow_and_update().clone();
        let (live, stage) = match stage {
            SourceStage::Preparing => (None, Stage::Preparing),
            SourceStage::Measuring(live) => (Some(live), Stage::Measuring),
            SourceStage::Ended(reason, live) => (live, Stage::Ended(reason)),
        };
        if matches!(stage, Stage::Ended(_)) {
            // its time stands still
            changed |= self.shown.stage != stage;
        }
        self.shown.stage = stage;
        let Some(live) = live else { return changed };
        self.shown.origin = Arc::clone(&live.origin);
        let link = live.link.as_ref().map(|link| link.borrow().clone());
        changed |= self.shown.link != link;
        self.shown.link = link;
        self.shown.recording = live.recording.as_ref().map(|recording| recording.borrow().clone());
        let playback = live
            .playback
            .as_ref()
            .map(|(position, total)| Playback { position: *position.borrow(), total: *total.borrow() });
        changed |= self.shown.playback != playback;
        self.shown.playback = playback;
        let snapshot = Arc::clone(&live.latest.borrow());
        if !Arc::ptr_eq(&snapshot, &self.shown.snapshot) {
            let assessment = self.assessments.of(&snapshot);
            if !Arc::ptr_eq(&assessment, &self.shown.assessment) {
                self.shown.verdicts = evaluation.verdicts(&snapshot, &assessment);
            }
            self.shown.show(snapshot, assessment);
            changed = true;
        }
        changed
    }
}

/// Runs until it is closed, or the terminal is gone.
pub(crate) fn run(mut screen: Screen, feeds: Vec<Feed>, confidence: f64, theme: Theme, shared: &Shared) -> Ended {
    let started = Instant::now();
    let mut followed: Vec<Followed> = feeds
        .into_iter()
        .map(|feed| {
            let shown = feed.nothing(confidence);
            Followed { feed, assessments: Assessments::new(confidence), shown }
        })
        .collect();
    let mut state = State::new(followed.len());
    let mut shown: Vec<Source> = followed.iter().map(|followed| followed.shown.clone()).collect();
    let mut regions = Regions::default();
    let mut last_screen = None;
    let mut keep_screen = false;
    let mut dirty = true;
    let mut told_at: Option<Instant> = None;
    let mut drawn_at: Option<Instant> = None;
    let mut looked_at: Option<Instant> = None;
    loop {
        if shared.signals.hung_up.is_cancelled() {
            return Ended::TerminalGone;
        }
        if shared.close.is_cancelled() || !screen.is_ours() {
            let kept = last_screen.filter(|_| keep_screen);
            return Ended::Closed(kept.as_ref().map(text));
        }
        if shared.signals.continued.swap(false, Ordering::Relaxed) {
            if screen.take_again().is_err() {
                return Ended::TerminalGone;
            }
            dirty = true;
        }
        if looked_at.is_none_or(|at| at.elapsed() >= LOOK) {
            let looked = Instant::now();
            looked_at = Some(looked);
            let elapsed = started.elapsed();
            let changed =
                followed.iter_mut().fold(false, |changed, source| source.look(elapsed, &shared.evaluation) | changed);
            if changed && !state.frozen {
                shown = followed.iter().map(|followed| followed.shown.clone()).collect();
                dirty = true;
            }
            if let Some(notice) = shared.notices.news() {
                state.message = Some(notice);
                dirty = true;
            }
            told_at = told_at.filter(|_| state.message.is_some()).or_else(|| state.message.as_ref().map(|_| looked));
            if told_at.is_some_and(|at| at.elapsed() > TOLD_FOR) {
                state.message = None;
                dirty = true;
            }
        }
        if dirty && drawn_at.is_none_or(|at| at.elapsed() >= FRAME) {
            let scene = Scene { state: &state, sources: &shown, theme };
            match screen.draw(|frame| regions = draw(frame, scene)) {
                Ok(buffer) => last_screen = Some(buffer),
                Err(_) => return Ended::TerminalGone,
            }
            // from its end: a terminal that takes its time gets its time
            drawn_at = Some(Instant::now());
            dirty = false;
        }
        let frame = drawn_at.filter(|_| dirty).map(|at| FRAME.saturating_sub(at.elapsed()));
        let look = looked_at.map_or(Duration::ZERO, |at| LOOK.saturating_sub(at.elapsed()));
        let request = match next_event(frame.map_or(look, |frame| frame.min(look))) {
            Ok(Some(Event::Key(key))) if key.kind != KeyEventKind::Release => {
                dirty = true;
                state.key(key, &shown)
            }
            Ok(Some(Event::Mouse(event))) => {
                let request = mouse(event, &mut state, &regions, &shown);
                dirty |= request.is_some() || !matches!(event.kind, ratatui::crossterm::event::MouseEventKind::Moved);
                request
            }
            Ok(Some(Event::Resize(..))) => {
                dirty = true;
                None
            }
            Ok(_) => None,
            Err(_) => return Ended::TerminalGone,
        };
        match request {
            Some(Request::Quit { keep_screen: keep }) => {
                keep_screen = keep;
                state.message = Some("Ending: the result follows.".into());
                shared.stop.cancel();
            }
            Some(Request::Suspend) => {
                if screen.suspend().is_err() {
                    return Ended::TerminalGone;
                }
                dirty = true;
            }
            Some(Request::Save) => {
                let saved = shown.get(state.source).map(|source| save(&state, source, &shared.evaluation));
                state.message = saved;
            }
            Some(Request::Control(request)) => {
                if let Some(followed) = followed.get(state.source) {
                    state.message = control(followed, request);
                }
            }
            None => {}
        }
    }
}

/// Passes a wish on to whoever measures; the answer for the user, if there is one.
fn control(followed: &Followed, request: SourceRequest) -> Option<String> {
    let stage = followed.feed.stage.borrow();
    let SourceStage::Measuring(live) = &*stage else { return Some("nothing is measured there".into()) };
    // whoever is too busy to take it is asked once more by a second key
    live.controls.try_send(request).err().map(|_| "that cannot be done now".into())
}

/// The screen as text.
fn text(buffer: &Buffer) -> String {
    let width = usize::from(buffer.area.width).max(1);
    let mut out = String::new();
    for row in buffer.content.chunks(width) {
        let line: String = row.iter().map(|cell| cell.symbol()).collect();
        out.push_str(line.trim_end());
        out.push('\n');
    }
    out
}

/// What a terminal that does not obey is answered with.
pub(crate) fn cannot_show(error: &io::Error) -> String {
    format!("the terminal cannot be drawn on: {error}; pipe the output through `cat` for text alone")
}
