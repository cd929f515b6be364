//! The parts of the pages: the state of a source at each look, and the parts of its report for a new
//! assessment; and the documents of the same states.

#[cfg(test)]
mod tests;

use std::{
    collections::HashMap,
    sync::Arc,
    time::{Duration, SystemTime},
};

use axum::body::Bytes;
use tokio::{sync::watch, time::Instant};
use vn100_analysis::{Assessment, Parts, SourceFacts, SourceResult};
use vn100_report::{
    DEFAULT_SPAN_S, Document, Evaluation,
    figure::ReportFigures,
    goals::Goals,
    html::{
        PageOptions, PagePart, PageSource, ShownPage, live_page, report_page, result_parts, sources_part, state_part,
    },
    json_line, metrics_text,
    remedies::{page_words, remedy_words},
    words::end,
};
use vn100_session::{SourceState, Stage};

use crate::serve::{PROGRAM, ServedSource};

/// An answer is kept this long, however often it is requested.
const KEPT: Duration = Duration::from_millis(250);
const REPORT_KEPT: Duration = Duration::from_secs(5);

/// The shortest silence of a stream that the page mentions.
const SILENT: Duration = Duration::from_secs(3);

/// How long the parts of a report are shown in a measurement of that age: half of it at first, and a
/// twentieth of a long one, which changes slowly.
fn result_lasts(age: Duration) -> Duration {
    (age / 2).min(Duration::from_secs(20)).max(age / 20).min(Duration::from_secs(60))
}

/// All pages at one moment: that of a single source, or a list of several, each with a page of its own.
#[derive(Debug, Clone, Default)]
pub(crate) struct PageState {
    /// Identifies this run of the program: its start in microseconds since 1970.
    pub(crate) run: u64,
    pub(crate) version: u64,
    parts: Vec<DrawnPart>,
}

#[derive(Debug, Clone)]
struct DrawnPart {
    /// The page that it belongs to: 0 is the first, and `n` that of the `n`th of several sources.
    page: usize,
    /// The version of the state in which the part changed last.
    version: u64,
    part: Arc<PagePart>,
}

impl PageState {
    /// The parts of a page that have changed since that version.
    pub(crate) fn since(&self, version: u64, page: usize) -> impl Iterator<Item = &PagePart> {
        self.parts.iter().filter(move |part| part.page == page && part.version > version).map(|part| &*part.part)
    }

    /// The next version, with these parts by the numbers of their pages.
    fn next(&self, parts: Vec<(usize, Arc<PagePart>)>) -> Self {
        let version = self.version + 1;
        let drawn = |(page, part): (usize, Arc<PagePart>)| {
            let same = self.parts.iter().find(|old| old.page == page && old.part == part);
            DrawnPart { page, version: same.map_or(version, |old| old.version), part }
        };
        let parts: Vec<DrawnPart> = parts.into_iter().map(drawn).collect();
        let has_changed = parts.iter().any(|part| part.version == version);
        Self { run: self.run, version: if has_changed { version } else { self.version }, parts }
    }
}

/// Draws the pages, and makes the documents of the same states.
pub(crate) struct Drawer {
    sources: Vec<SourceDrawer>,
    evaluation: Arc<Evaluation>,
    /// The command line, as a user would repeat it.
    asked: String,
    confidence: f64,
    state: Arc<PageState>,
    drawn_at: Option<Instant>,
    /// The latest answers by their addresses.
    kept: HashMap<&'static str, (Instant, Bytes)>,
}

impl Drawer {
    pub(crate) fn new(
        sources: Vec<ServedSource>,
        evaluation: Arc<Evaluation>,
        asked: String,
        confidence: f64,
        now: Instant,
    ) -> Self {
        // a later run has another number, unless the clock was set back by exactly that time
        let run = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_micros() as u64;
        Self {
            sources: sources.into_iter().map(|source| SourceDrawer::new(source, now)).collect(),
            evaluation,
            asked,
            confidence,
            state: Arc::new(PageState { run, ..PageState::default() }),
            drawn_at: None,
            kept: HashMap::new(),
        }
    }

    /// Notes which sources have given samples.
    pub(crate) fn look(&mut self, now: Instant) {
        self.sources.iter_mut().for_each(|source| source.look(now));
    }

    /// The pages as they are now, or were a moment ago.
    pub(crate) fn state(&mut self, now: Instant) -> Arc<PageState> {
        if self.drawn_at.is_none_or(|at| now.saturating_duration_since(at) >= KEPT) {
            self.draw(now);
        }
        Arc::clone(&self.state)
    }

    pub(crate) fn draw(&mut self, now: Instant) -> Arc<PageState> {
        self.drawn_at = Some(now);
        let (evaluation, options) = (&self.evaluation, page_options(&self.asked, self.confidence));
        let seen: Vec<Seen> = self.sources.iter_mut().map(|source| source.see(evaluation, options, now)).collect();
        let live: Vec<PageSource<'_>> = (self.sources.iter().zip(&seen))
            .map(|(source, seen)| PageSource {
                result: &seen.result,
                goals: &source.goals,
                is_preparing: matches!(seen.stage, Stage::Preparing),
                elapsed: now.saturating_duration_since(source.began),
                silent: seen.silent,
            })
            .collect();
        let first = usize::from(live.len() > 1);
        let mut parts = Vec::new();
        if first > 0 {
            parts.push((0, Arc::new(sources_part(&live))));
        }
        for (place, (source, drawer)) in live.iter().zip(&self.sources).enumerate() {
            parts.push((first + place, Arc::new(state_part(source))));
            let of_result = drawer.drawn.iter().flat_map(|drawn| &drawn.parts);
            parts.extend(of_result.map(|part| (first + place, Arc::clone(part))));
        }
        self.state = Arc::new(self.state.next(parts));
        Arc::clone(&self.state)
    }

    /// Whether there is a page of this number.
    pub(crate) fn has_page(&self, page: usize) -> bool {
        page < self.sources.len() + usize::from(self.sources.len() > 1)
    }

    /// The whole page of this number; `None` if there is none.
    pub(crate) fn html(&mut self, now: Instant, page: usize) -> Option<String> {
        let state = self.state(now);
        let count = self.sources.len();
        let source = if count == 1 { page } else { page.wrapping_sub(1) };
        let name = self.sources.get(source).map(|source| source.state.borrow().name().to_owned());
        let shown = match &name {
            _ if !self.has_page(page) => return None,
            None => ShownPage::List(count),
            Some(name) if count == 1 => ShownPage::Source(name),
            Some(name) => ShownPage::SourceOfSeveral(name),
        };
        let part = |id: &str| Some(&*state.since(0, page).find(|part| part.id == id)?.html);
        Some(live_page(shown, part, &format!("{}-{}", state.run, state.version), PROGRAM.name))
    }

    /// The answer at an address, made anew if it is older than `lasts`.
    fn kept(&mut self, at: &'static str, now: Instant, lasts: Duration, make: impl FnOnce(&Self) -> String) -> Bytes {
        if let Some((_, answer)) = self.kept.get(at).filter(|(made, _)| now.saturating_duration_since(*made) < lasts) {
            return answer.clone();
        }
        let answer = Bytes::from(make(self));
        self.kept.insert(at, (now, answer.clone()));
        answer
    }

    /// The JSON document of `--json`; of several sources an array of their documents.
    pub(crate) fn documents(&mut self, now: Instant) -> Bytes {
        self.kept("snapshot", now, KEPT, |drawer| {
            let document = |source: &SourceDrawer| {
                let state = source.state.borrow().clone();
                let parts = if state.facts().end.is_some() { Parts::All } else { Parts::WithoutSignals };
                let result = drawer.evaluation.complete(result_of(&state, parts));
                // numbers and texts alone are serialised
                serde_json::to_string(&Document::new(&result, remedy_words)).unwrap_or_default()
            };
            let documents: Vec<String> = drawer.sources.iter().map(document).collect();
            json_line(&if let [only] = &documents[..] { only.clone() } else { format!("[{}]", documents.join(",")) })
        })
    }

    pub(crate) fn report(&mut self, now: Instant) -> Bytes {
        self.kept("report", now, REPORT_KEPT, |drawer| {
            let result = |source: &SourceDrawer| result_of(&source.state.borrow().clone(), Parts::All);
            let records: Vec<SourceResult> =
                drawer.sources.iter().map(|source| drawer.evaluation.complete(result(source))).collect();
            report_page(&records, &ReportFigures::of(&records), page_options(&drawer.asked, drawer.confidence))
        })
    }

    pub(crate) fn metrics(&mut self, now: Instant) -> Bytes {
        self.look(now);
        self.kept("metrics", now, KEPT, |drawer| {
            let result = |source: &SourceDrawer| result_of(&source.state.borrow().clone(), Parts::WithoutSignals);
            let results: Vec<SourceResult> = drawer.sources.iter().map(result).collect();
            let sources: Vec<_> = (results.iter().zip(&drawer.sources))
                .map(|(result, source)| (result, source.last_sample_age(now)))
                .collect();
            metrics_text(&sources)
        })
    }

    /// Whether every source gives samples, and a line for each.
    pub(crate) fn health(&self, now: Instant) -> (bool, String) {
        let mut is_healthy = true;
        let mut text = String::new();
        for source in &self.sources {
            let state = source.state.borrow().clone();
            let word = source.health(&state, now);
            is_healthy &= word.is_ok();
            let word = word.unwrap_or_else(|word| word);
            text.push_str(&format!("{}: {word}\n", vn100_report::printable(state.name())));
        }
        (is_healthy, text)
    }
}

fn page_options(asked: &str, confidence: f64) -> PageOptions<'_> {
    PageOptions { confidence, asked, words: page_words, program: PROGRAM, span_s: DEFAULT_SPAN_S }
}

struct SourceDrawer {
    state: watch::Receiver<SourceState>,
    goals: Goals,
    began: Instant,
    /// Number of samples at the last change of it that a look has found, and the time of that look.
    samples: (u64, Instant),
    drawn: Option<DrawnResult>,
}

struct DrawnResult {
    assessment: Arc<Assessment>,
    is_over: bool,
    at: Instant,
    parts: Vec<Arc<PagePart>>,
}

struct Seen {
    result: SourceResult,
    stage: Stage,
    silent: Option<Duration>,
}

/// Whether the measurement has ended, so that no more samples follow.
fn is_over(state: &SourceState) -> bool {
    matches!(state.stage, Stage::Ended(_)) || state.playback.is_some_and(|playback| playback.at_end)
}

/// The facts of the source, with the reason in words why its result is not complete.
fn facts_of(state: &SourceState) -> SourceFacts {
    let error = match &state.stage {
        Stage::Ended(reason) => end(state.name(), reason, state.snapshot.link.tally.bytes(), page_words),
        _ => None,
    };
    SourceFacts { error, ..state.facts() }
}

fn result_of(state: &SourceState, parts: Parts) -> SourceResult {
    SourceResult::new(facts_of(state), Arc::clone(&state.snapshot), state.assessment(), parts)
}

impl SourceDrawer {
    fn new(ServedSource { state, goals }: ServedSource, now: Instant) -> Self {
        Self { state, goals, began: now, samples: (0, now), drawn: None }
    }

    fn look(&mut self, now: Instant) {
        let samples = self.state.borrow().snapshot.link.samples();
        if samples != self.samples.0 {
            self.samples = (samples, now);
        }
    }

    /// For how long no sample has come in a stream that should carry some; `None` where samples
    /// come.
    fn silent(&self, state: &SourceState, now: Instant) -> Option<Duration> {
        let is_paused = state.playback.is_some_and(|playback| playback.paused);
        let silent = now.saturating_duration_since(self.samples.1);
        let is_due = matches!(state.stage, Stage::Measuring) && !is_over(state) && !is_paused;
        (is_due && silent >= SILENT).then_some(silent)
    }

    fn see(&mut self, evaluation: &Evaluation, options: PageOptions<'_>, now: Instant) -> Seen {
        self.look(now);
        let state = self.state.borrow().clone();
        let (is_over, snapshot) = (is_over(&state), &state.snapshot);
        let lasts = result_lasts(now.saturating_duration_since(self.began));
        let fits = |drawn: &&DrawnResult| {
            drawn.is_over == is_over
                && drawn.assessment.channels.len() == snapshot.channels.len()
                && drawn.assessment.samples <= snapshot.timing.samples
                && (is_over || now.saturating_duration_since(drawn.at) < lasts)
        };
        let assessment = match self.drawn.as_ref().filter(fits) {
            Some(drawn) => Arc::clone(&drawn.assessment),
            None => {
                let assessment = state.assessment();
                let so_far =
                    SourceResult::new(facts_of(&state), Arc::clone(snapshot), Arc::clone(&assessment), Parts::All);
                let parts = result_parts(&evaluation.complete(so_far), options).into_iter().map(Arc::new).collect();
                self.drawn = Some(DrawnResult { assessment: Arc::clone(&assessment), is_over, at: now, parts });
                assessment
            }
        };
        let result = SourceResult::new(facts_of(&state), Arc::clone(snapshot), assessment, Parts::WithoutSignals);
        let silent = self.silent(&state, now);
        Seen { result, stage: state.stage, silent }
    }

    fn last_sample_age(&self, now: Instant) -> Option<Duration> {
        (self.samples.0 > 0).then(|| now.saturating_duration_since(self.samples.1))
    }

    fn health(&self, state: &SourceState, now: Instant) -> Result<String, String> {
        if let Some(silent) = self.silent(state, now) {
            return Err(format!("no sample for {} s", silent.as_secs()));
        }
        match &state.stage {
            Stage::Preparing => Err("preparing".into()),
            Stage::Ended(_) => Err("ended".into()),
            Stage::Measuring | Stage::Finishing if is_over(state) => Ok("replayed to its end".into()),
            Stage::Measuring | Stage::Finishing => Ok("measuring".into()),
        }
    }
}
