//! One stream of a file, measured from its opening to its result, on this thread.

use std::{
    ops::ControlFlow,
    sync::{Arc, atomic::Ordering},
};

use serde::Serialize;
use vn100_analysis::{
    Analysis, Assessment, End, Goal, GoalCheck, Parts, RateFrom, RecordingEndFacts, RecordingFacts, Settings,
    Shortfall, Snapshot, SourceFacts, SourceResult, StartCure,
    protocol::stream::{Batch, FileReport, MeasuredFrames, ReadOptions},
    recorded_settings,
    timebase::Refusal,
};
use vn100_capture::{
    Capture, CaptureOptions, Event, FileEvents, OpenError, OpenHint, Recorded, StoredFile, with_causes,
};
use vn100_report::{Ended, remedies::page_words};

/// A stream that was measured; its result is one without samples if nothing could be measured.
pub(crate) struct Measured {
    pub(crate) result: SourceResult,
    pub(crate) cure: Option<Cure>,
}

/// What the user can say of a file so that it can be read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Cure {
    /// The field of the page.
    pub field: &'static str,
    /// A guess for it; `None` for none.
    pub guess: Option<String>,
    /// All that may be chosen; empty if it is free text.
    pub choices: Vec<String>,
}

/// A file that is to be measured, with what is said of it.
pub(crate) struct Stream {
    pub(crate) file: Box<dyn StoredFile>,
    pub(crate) name: String,
    /// Whether the topic is one of several streams of the file.
    pub(crate) is_one_of_several: bool,
    pub(crate) options: CaptureOptions,
    pub(crate) settings: Settings,
    pub(crate) accept_unchecked: bool,
}

/// How far a file was read, in stored bytes.
pub(crate) type Progress<'a> = &'a mut dyn FnMut(u64);

pub(crate) fn measure(stream: Stream, progress: Progress<'_>) -> Measured {
    let Stream { file, name, is_one_of_several, options, settings, accept_unchecked } = stream;
    let topic = options.topic.as_ref().filter(|_| is_one_of_several);
    let shown = topic.map_or_else(|| name.clone(), |topic| format!("{name} {topic}"));
    let facts = SourceFacts { name: shown, ..SourceFacts::default() };
    let capture = match Capture::of_file(file, &name, &options) {
        Ok(capture) => capture,
        Err(error) => {
            let hint = match &error {
                OpenError::Unusable { problem, .. } => problem.hint().cloned(),
                _ => None,
            };
            let field = hint.as_ref().map(cure_of);
            let cure = hint.map(StartCure::Capture);
            let end = End::NotStarted { text: with_causes(&error), names_source: true, is_of_recording: false, cure };
            return not_started(facts, end, field, settings);
        }
    };
    if capture.lacks_times() && settings.rate_hz.is_none() {
        return rate_unknown(facts, None, settings);
    }
    let recorded = capture.recorded.clone();
    let facts = SourceFacts {
        kind: Some(capture.format.code()),
        meta: recorded.as_ref().and_then(|recorded| recorded_settings::conditions(&recorded.metadata)),
        csv: capture.csv.clone(),
        stream: capture.topic.clone(),
        ..facts
    };
    let holds_values = capture.holds_values;
    let run = Run::of(capture, recorded.as_ref(), &settings, accept_unchecked, progress);
    let timing = &run.snapshot.timing;
    if holds_values && timing.rate_from == RateFrom::Assumed && timing.samples > 1 {
        return rate_unknown(facts, run.snapshot.arrivals.and_then(|arrivals| arrivals.refusal), settings);
    }
    let recording = recorded.map(|recorded| run.recording_facts(&recorded));
    run.ended(SourceFacts { recording, ..facts })
}

/// A capture that was read.
struct Run {
    snapshot: Snapshot,
    settings: Settings,
    end: End,
    report: Option<Arc<FileReport>>,
    shortfall: Option<Shortfall>,
    /// Whether a recording was read to its end.
    is_whole: bool,
}

impl Run {
    fn of(
        capture: Capture,
        recorded: Option<&Recorded>,
        asked: &Settings,
        accept_unchecked: bool,
        progress: Progress<'_>,
    ) -> Self {
        let ends_as_recorded = asked.duration.is_none() && asked.until.is_empty();
        let settings = match recorded {
            Some(recorded) if recorded.is_one_measurement() => {
                recorded_settings::with_end(asked.clone(), &recorded.metadata)
            }
            _ => asked.clone(),
        };
        let frames = |recorded: &Recorded| recorded_settings::frames(MeasuredFrames::First, &recorded.metadata);
        let read = ReadOptions {
            accept_unchecked,
            line_by_line: settings.ends_between_reads(),
            measured: recorded.map_or(MeasuredFrames::First, frames),
            ..ReadOptions::default()
        };
        let stored_bytes_read = Arc::clone(&capture.stored_bytes_read);
        let mut loop_ = Loop { analysis: Analysis::new(settings.clone()), goals: GoalCheck::default(), report: None };
        let end = match capture.events(read) {
            Err(error) => End::SourceFailed(error.to_string()),
            Ok(mut events) => {
                let ended = loop_.read(&mut events, &mut || progress(stored_bytes_read.load(Ordering::Relaxed)));
                // the recorded reason of the end is after the last sample
                if ends_as_recorded {
                    events.for_each(drop);
                }
                ended
            }
        };
        let Loop { mut analysis, report, .. } = loop_;
        while analysis.finish_to_second() {}
        let snapshot = analysis.final_snapshot();
        let is_reached = matches!(end, End::DurationReached | End::GoalsDecided);
        let wanted = settings.duration.filter(|_| !(is_reached || analysis.is_complete()));
        let shortfall = wanted.map(|wanted| Shortfall { wanted, measured: analysis.data_time() });
        Self { snapshot, settings, end, report, shortfall, is_whole: ends_as_recorded || !is_reached }
    }

    fn recording_facts(&self, recorded: &Recorded) -> RecordingFacts {
        RecordingFacts {
            program: recorded.program.clone(),
            started_ns: recorded.started_ns,
            end: recorded.end.get().filter(|_| self.is_whole).map(|end| RecordingEndFacts {
                ended_ns: end.ended_ns,
                complete: end.complete,
                reason: end.reason.clone(),
            }),
        }
    }

    fn ended(self, facts: SourceFacts) -> Measured {
        let Self { mut snapshot, settings, end, report, shortfall, .. } = self;
        let facts = facts.at_end(report.map(Arc::unwrap_or_clone), end.kind());
        let assessment = Assessment::new(&snapshot, settings.confidence);
        snapshot.warnings.extend(facts.recording.as_ref().and_then(|recording| recording.end.as_ref()?.warning()));
        let unmet = Goal::unmet(&settings.until, &snapshot, &assessment);
        let result = SourceResult::new(facts, Arc::new(snapshot), Arc::new(assessment), Parts::All);
        let ended =
            Ended { end: &end, shortfall: shortfall.as_ref(), unmet: &unmet, is_live: false, words: page_words };
        Measured { result: ended.complete(result), cure: None }
    }
}

/// The samples of a file on their way into the analysis.
struct Loop {
    analysis: Analysis,
    goals: GoalCheck,
    /// What the file tells of its content up to the last row.
    report: Option<Arc<FileReport>>,
}

impl Loop {
    /// Reads to the end of the file, or of the measurement.
    fn read(&mut self, events: &mut FileEvents, progress: &mut dyn FnMut()) -> End {
        for event in events {
            progress();
            let ended = match event {
                Event::Batch(batch) => self.take(*batch),
                Event::Link(event) => {
                    self.analysis.take_link_event(&event);
                    self.look()
                }
                Event::End(end) => {
                    self.report = end.report.map(Arc::new);
                    return end.error.map_or(End::SourceEnded, |error| End::SourceFailed(error.to_string()));
                }
            };
            if let ControlFlow::Break(end) = ended {
                return end;
            }
        }
        End::SourceEnded
    }

    fn take(&mut self, batch: Batch) -> ControlFlow<End> {
        self.report.clone_from(&batch.report);
        if batch.tallies.is_empty() {
            self.analysis.absorb(&batch);
            return self.look();
        }
        let mut lines = batch.lines();
        while let Some(line) = lines.next_line() {
            self.analysis.absorb(line);
            self.look()?;
        }
        ControlFlow::Continue(())
    }

    fn look(&mut self) -> ControlFlow<End> {
        self.goals.end(&mut self.analysis).map_or(ControlFlow::Continue(()), ControlFlow::Break)
    }
}

fn rate_unknown(facts: SourceFacts, refusal: Option<Refusal>, settings: Settings) -> Measured {
    let why = refusal.map_or_else(String::new, |refusal| format!(": {refusal}"));
    let cure = Some(match refusal {
        Some(Refusal::Pairs { .. }) => StartCure::OneSource,
        refusal => StartCure::Rate { has_times: refusal.is_some() },
    });
    let text = format!("its sample rate is unknown{why}");
    let end = End::NotStarted { text, names_source: false, is_of_recording: false, cure };
    not_started(facts, end, Some(Cure { field: "rate", guess: None, choices: Vec::new() }), settings)
}

fn not_started(facts: SourceFacts, end: End, cure: Option<Cure>, settings: Settings) -> Measured {
    let snapshot = Analysis::new(settings.clone()).snapshot();
    let run = Run { snapshot, settings, end, report: None, shortfall: None, is_whole: true };
    Measured { cure, ..run.ended(facts) }
}

/// What would make a file readable, for the fields of the page.
fn cure_of(hint: &OpenHint) -> Cure {
    let field = |field, guess: Option<&String>| Cure { field, guess: guess.cloned(), choices: Vec::new() };
    let topic = |choices: &Vec<String>| Cure { field: "topic", guess: None, choices: choices.clone() };
    match hint {
        OpenHint::Columns(map) => field("columns", map.as_ref()),
        OpenHint::DateOrder(map) | OpenHint::StampUnit(map) => field("columns", Some(map)),
        OpenHint::Topic(topics) | OpenHint::TopicAndColumns(topics) => topic(topics),
        OpenHint::ColumnsOfTopic => field("columns", None),
    }
}
