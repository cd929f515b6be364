//! The parts of the page. Curves and parameters are drawn again for a new assessment, the recent
//! signal every few seconds, and all other parts at each look.

#[cfg(test)]
mod tests;

use std::{
    sync::Arc,
    time::{Duration, SystemTime},
};

use axum::body::Bytes;
use tokio::{sync::watch, time::Instant};
use vn100_analysis::{Assessment, Parts, SourceFacts, SourceResult};
use vn100_report::html::{
    LiveStage, PagePart, PageSource, live_page, now_part, result_parts, signal_part, sources_part, write_page,
};
use vn100_report::{
    Document, Evaluation, MeasuredSource, MetricsForm, figure::Figures, goals::Goals, json_line, metrics_text,
    run_name, run_prefix,
};
use vn100_report::{
    remedies::{page_words, remedy_words},
    words::end,
};
use vn100_session::{SourceState, Stage};

use crate::serve::{ReportSettings, ServedSource};

/// A drawn result is kept at least this long; at first for a third of the time since the start.
const RESULT_LASTS: Duration = Duration::from_secs(10);
const SIGNAL_LASTS: Duration = Duration::from_secs(10);
/// A drawn page is kept this long, however often it is requested.
const PAGE_LASTS: Duration = Duration::from_millis(250);
const REPORT_LASTS: Duration = Duration::from_secs(5);
/// A drawn part that no reader requests is dropped after this time.
const DRAWN_LASTS: Duration = Duration::from_secs(30);

/// The shortest silence of a stream that the page mentions.
const SILENT: Duration = Duration::from_secs(3);

/// The page at one moment.
#[derive(Debug, Clone, Default)]
pub(crate) struct PageState {
    /// Identifies this run of the program: its start in microseconds since 1970.
    run: u64,
    version: u64,
    parts: Vec<Arc<Versioned>>,
}

#[derive(Debug)]
struct Versioned {
    /// The version of the page in which the part changed last.
    version: u64,
    part: Arc<PagePart>,
}

impl PageState {
    pub(crate) const fn run(&self) -> u64 {
        self.run
    }

    pub(crate) const fn version(&self) -> u64 {
        self.version
    }

    /// The parts that have changed since that version.
    pub(crate) fn since(&self, version: u64) -> impl Iterator<Item = Arc<PagePart>> {
        self.parts.iter().filter(move |part| part.version > version).map(|part| Arc::clone(&part.part))
    }

    /// The page without its parts; those drawn next are new to every reader.
    fn forgotten(&self) -> Self {
        Self { parts: Vec::new(), ..*self }
    }

    /// The next version of the page, with these parts.
    fn next(&self, parts: Vec<Arc<PagePart>>) -> Self {
        let version = self.version + 1;
        let drawn = |part: Arc<PagePart>| match self.parts.iter().find(|old| old.part.id == part.id) {
            Some(old) if Arc::ptr_eq(&old.part, &part) || old.part == part => Arc::clone(old),
            _ => Arc::new(Versioned { version, part }),
        };
        let parts: Vec<Arc<Versioned>> = parts.into_iter().map(drawn).collect();
        let has_changed = parts.iter().any(|part| part.version == version);
        Self { run: self.run, version: if has_changed { version } else { self.version }, parts }
    }
}

/// Draws the page, and makes the documents of the same states.
pub(crate) struct Drawer {
    sources: Vec<SourceDrawer>,
    evaluation: Arc<Evaluation>,
    report_settings: ReportSettings,
    page: Arc<PageState>,
    drawn_at: Option<Instant>,
    documents: Kept,
    report: Kept,
    prometheus: Kept,
    open_metrics: Kept,
}

/// A rendered answer that is kept for a while.
#[derive(Debug, Default)]
struct Kept(Option<(Instant, Bytes)>);

impl Kept {
    fn get(&mut self, now: Instant, lasts: Duration, make: impl FnOnce() -> String) -> Bytes {
        self.forget(now, lasts);
        self.0.get_or_insert_with(|| (now, make().into())).1.clone()
    }

    /// Drops an answer that was rendered at least `lasts` ago.
    fn forget(&mut self, now: Instant, lasts: Duration) {
        self.0.take_if(|(at, _)| now.saturating_duration_since(*at) >= lasts);
    }
}

impl Drawer {
    pub(crate) fn new(
        sources: Vec<ServedSource>,
        evaluation: Arc<Evaluation>,
        report_settings: ReportSettings,
        now: Instant,
    ) -> Self {
        let is_alone = sources.len() == 1;
        let of = |(place, source): (usize, ServedSource)| {
            let prefix = if is_alone { String::new() } else { run_prefix(place) };
            SourceDrawer::new(source, prefix, now)
        };
        // a later run has another number, unless the clock was set back by exactly that time
        let run = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_micros() as u64;
        Self {
            sources: sources.into_iter().enumerate().map(of).collect(),
            evaluation,
            report_settings,
            page: Arc::new(PageState { run, ..PageState::default() }),
            drawn_at: None,
            documents: Kept::default(),
            report: Kept::default(),
            prometheus: Kept::default(),
            open_metrics: Kept::default(),
        }
    }

    /// Notes which sources have given samples, and drops what no reader asks for.
    pub(crate) fn look(&mut self, now: Instant) {
        self.sources.iter_mut().for_each(|source| source.look(now));
        for kept in [&mut self.documents, &mut self.report, &mut self.prometheus, &mut self.open_metrics] {
            kept.forget(now, REPORT_LASTS);
        }
        if self.drawn_at.is_some_and(|at| now.saturating_duration_since(at) >= DRAWN_LASTS) {
            self.drawn_at = None;
            self.page = Arc::new(self.page.forgotten());
            self.sources.iter_mut().for_each(|source| (source.results, source.signal) = (None, None));
        }
    }

    /// Whether any drawn part is kept.
    pub(crate) const fn is_drawn(&self) -> bool {
        self.drawn_at.is_some()
    }

    /// The page as it is now, or was a moment ago.
    pub(crate) fn page(&mut self, now: Instant) -> Arc<PageState> {
        if self.drawn_at.is_none_or(|at| now.saturating_duration_since(at) >= PAGE_LASTS) {
            self.draw(now);
        }
        Arc::clone(&self.page)
    }

    pub(crate) fn draw(&mut self, now: Instant) -> Arc<PageState> {
        self.drawn_at = Some(now);
        let evaluation = &self.evaluation;
        let seen: Vec<Seen> = self.sources.iter_mut().map(|source| source.see(evaluation, now)).collect();
        let live: Vec<(String, PageSource<'_>)> = (self.sources.iter().zip(&seen))
            .map(|(source, seen)| {
                (source.prefix.clone(), seen.live(&source.goals, now.saturating_duration_since(source.began)))
            })
            .collect();
        let mut parts = vec![Arc::new(sources_part(&live))];
        for ((prefix, source), drawer) in live.iter().zip(&self.sources) {
            parts.push(Arc::new(now_part(source, prefix)));
            parts.extend(drawer.results.iter().flat_map(|results| results.parts.iter().cloned()));
            parts.extend(drawer.signal.iter().map(|(_, part)| Arc::clone(part)));
        }
        self.page = Arc::new(self.page.next(parts));
        Arc::clone(&self.page)
    }

    /// The whole page.
    pub(crate) fn html(&mut self, now: Instant) -> String {
        let page = self.page(now);
        let parts: Vec<&PagePart> = page.parts.iter().map(|part| &*part.part).collect();
        let name = |source: &SourceDrawer| (source.prefix.clone(), source.state.borrow().name().to_owned());
        let names: Vec<(String, String)> = self.sources.iter().map(name).collect();
        live_page(&names, &parts, &format!("{}-{}", page.run, page.version), self.report_settings.program.name)
    }

    /// The JSON document of `--json`; of several sources an array of their documents.
    pub(crate) fn documents(&mut self, now: Instant) -> Bytes {
        let (sources, evaluation) = (&self.sources, &self.evaluation);
        self.documents.get(now, PAGE_LASTS, || {
            let document = |source: &SourceDrawer| {
                let is_over = source.state.borrow().facts().ended;
                let parts = if is_over { Parts::All } else { Parts::WithoutSignals };
                let result = evaluation.complete(result_of(&source.state.borrow().clone(), parts));
                // numbers and texts alone are serialised
                serde_json::to_string(&Document::new(&result, remedy_words)).unwrap_or_default()
            };
            let documents: Vec<String> = sources.iter().map(document).collect();
            json_line(&if let [only] = &documents[..] { only.clone() } else { format!("[{}]", documents.join(",")) })
        })
    }

    /// The report so far.
    pub(crate) fn report(&mut self, now: Instant) -> Bytes {
        let (sources, evaluation) = (&self.sources, &self.evaluation);
        let options = self.report_settings.options();
        self.report.get(now, REPORT_LASTS, || {
            let result = |source: &SourceDrawer| result_of(&source.state.borrow().clone(), Parts::All);
            let records: Vec<SourceResult> = sources.iter().map(|source| evaluation.complete(result(source))).collect();
            let is_alone = records.len() == 1;
            let prefix = |place| if is_alone { String::new() } else { run_prefix(place) };
            let figures: Vec<Figures> =
                records.iter().enumerate().map(|(place, record)| Figures::of(record, &prefix(place))).collect();
            let names: Vec<String> = (0..records.len()).map(run_name).collect();
            let together = if is_alone { Figures::default() } else { Figures::together(&records, &names) };
            let mut page = Vec::new();
            // writing into memory does not fail
            let _ = write_page(&mut page, &records, &figures, &together, options);
            String::from_utf8_lossy(&page).into_owned()
        })
    }

    /// The metrics of all sources.
    pub(crate) fn metrics(&mut self, now: Instant, form: MetricsForm) -> Bytes {
        self.look(now);
        let sources = &self.sources;
        let kept = match form {
            MetricsForm::Prometheus => &mut self.prometheus,
            MetricsForm::OpenMetrics => &mut self.open_metrics,
        };
        kept.get(now, PAGE_LASTS, || {
            let result = |source: &SourceDrawer| result_of(&source.state.borrow().clone(), Parts::WithoutSignals);
            let seen: Vec<_> = sources.iter().map(|source| (result(source), source.last_sample_age(now))).collect();
            let sources: Vec<MeasuredSource<'_>> = (seen.iter())
                .map(|(result, last_sample_age)| MeasuredSource { result, last_sample_age: *last_sample_age })
                .collect();
            metrics_text(&sources, form)
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

struct SourceDrawer {
    state: watch::Receiver<SourceState>,
    goals: Goals,
    prefix: String,
    began: Instant,
    /// Number of samples at the last change of it that a look has found, and the time of that look.
    samples: (u64, Instant),
    results: Option<Results>,
    signal: Option<(Instant, Arc<PagePart>)>,
}

/// The parts drawn from one assessment.
struct Results {
    assessment: Arc<Assessment>,
    is_over: bool,
    at: Instant,
    parts: Vec<Arc<PagePart>>,
}

/// What one look at a source has found.
struct Seen {
    result: SourceResult,
    stage: Stage,
    silent: Option<Duration>,
}

impl Seen {
    fn live<'a>(&'a self, goals: &'a Goals, elapsed: Duration) -> PageSource<'a> {
        PageSource {
            result: &self.result,
            goals,
            elapsed,
            stage: match self.stage {
                Stage::Preparing => LiveStage::Preparing,
                Stage::Measuring | Stage::Finishing => LiveStage::Measuring,
                Stage::Ended(_) => LiveStage::Ended(self.result.source.error.as_deref()),
            },
            silent: self.silent,
        }
    }
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
    fn new(source: ServedSource, prefix: String, now: Instant) -> Self {
        let ServedSource { state, goals } = source;
        Self { state, goals, prefix, began: now, samples: (0, now), results: None, signal: None }
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

    fn see(&mut self, evaluation: &Evaluation, now: Instant) -> Seen {
        self.look(now);
        let state = self.state.borrow().clone();
        let (is_over, snapshot) = (is_over(&state), &state.snapshot);
        let lasts = RESULT_LASTS.min(now.saturating_duration_since(self.began) / 3);
        let fits = |results: &&Results| {
            results.is_over == is_over
                && results.assessment.channels.len() == snapshot.channels.len()
                && results.assessment.samples <= snapshot.timing.samples
                && now.saturating_duration_since(results.at) < lasts
        };
        let assessment = match self.results.as_ref().filter(fits) {
            Some(results) => Arc::clone(&results.assessment),
            None => state.assessment(),
        };
        let is_drawn = |results: &&Results| results.is_over == is_over && Arc::ptr_eq(&results.assessment, &assessment);
        if self.results.as_ref().filter(is_drawn).is_none() {
            let so_far = SourceResult::new(facts_of(&state), Arc::clone(snapshot), Arc::clone(&assessment), Parts::All);
            let parts = result_parts(&evaluation.complete(so_far), page_words, &self.prefix);
            let parts = parts.into_iter().map(Arc::new).collect();
            self.results = Some(Results { assessment: Arc::clone(&assessment), is_over, at: now, parts });
        }
        let result = SourceResult::new(facts_of(&state), Arc::clone(snapshot), assessment, Parts::WithoutSignals);
        let signal_lasts = SIGNAL_LASTS.min(now.saturating_duration_since(self.began) / 3);
        let is_drawn =
            |(at, _): &(Instant, Arc<PagePart>)| !is_over && now.saturating_duration_since(*at) < signal_lasts;
        if !self.signal.as_ref().is_some_and(is_drawn) {
            self.signal = Some((now, Arc::new(signal_part(&result, &self.prefix))));
        }
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
