//! A result that is over: whether it is complete, and why not.

use vn100_analysis::{
    Completion, End, Finding, Goal, RemedyWords, Severity, Shortfall, SourceResult, StartCure, Warning,
};

use crate::words;

/// How a session ended, besides its result.
#[derive(Debug, Clone, Copy)]
pub struct Ended<'a> {
    /// Why the measurement ended.
    pub end: &'a End,
    /// How much shorter it is than was asked for; `None` if it is not.
    pub shortfall: Option<&'a Shortfall>,
    /// The goals that were not met.
    pub unmet: &'a [Goal],
    /// Whether the source is live: one that ends early has failed, and a capture has no more data.
    pub is_live: bool,
    /// The words of the face for remedies.
    pub words: RemedyWords,
}

impl Ended<'_> {
    /// Puts into the result why it is not complete, if it is not.
    pub fn complete(self, mut result: SourceResult) -> SourceResult {
        let Self { end, shortfall, unmet, is_live, words } = self;
        let early = words::ended_early(end, shortfall, !unmet.is_empty(), result.timing.duration_s);
        let why = words::end(&result.source.name, end, result.link.framed_bytes, words);
        let is_of_source = matches!(end, End::NotStarted { .. } | End::SourceFailed(_));
        if let Some(error) = why.clone().filter(|_| is_of_source) {
            result.note_failure(error);
        }
        let out_of_reach = unmet.iter().any(|goal| result.out_of_reach(goal).is_some());
        // if a goal is out of reach the measurement ended before there had to be a sample
        if result.timing.samples == 0 && !out_of_reach {
            let text = no_sample(&result);
            result.source.error.get_or_insert(text);
            result.completion = Completion::NoData;
        }
        let not_met: Vec<String> = unmet.iter().map(|goal| not_met(&result, goal)).collect();
        result.unmet.extend(not_met);
        if !result.unmet.is_empty() {
            result.completion = result.completion.max(Completion::NotMet);
        }
        match end {
            // the source itself may be fine
            End::NotStarted { is_of_recording: true, .. } => result.completion = Completion::Failed,
            End::NotStarted { cure: Some(StartCure::Rate { .. } | StartCure::OneSource), .. } => {
                result.completion = Completion::NotGiven
            }
            _ => {}
        }
        if let Some(cut_short) = why.filter(|_| !is_of_source) {
            result.note_failure(cut_short);
        }
        if let Some((text, details)) = early {
            let said = if details.is_empty() { text.clone() } else { format!("{text}. {details}") };
            let mut warning = Warning::new(Finding::Said(said));
            if is_live {
                result.note_failure(format!("{}: {text}", result.source.name));
            } else {
                warning.severity = Severity::Note;
            }
            result.warn(warning);
        }
        if !result.timing.missing_times.is_empty() {
            result.note_failure(format!("{}: {}", result.source.name, result.timing.missing_times.join("; ")));
        }
        result
    }
}

/// Notes that the recording is incomplete for the reason `text`: the measurement has failed.
pub fn note_failed_recording(result: &mut SourceResult, text: String) {
    result.warn(Warning::new(Finding::Said(text)));
    result.completion = result.completion.max(Completion::Failed);
}

/// Notes that the result was interrupted, although an interrupt ends it like the end of the data; if
/// no sample came, the interrupt is the reason.
pub fn note_interrupted(result: &mut SourceResult) {
    let is_unknown = result.source.error.as_ref().is_none_or(|error| *error == no_sample(result));
    if is_unknown {
        result.source.error = Some(format!("{}: interrupted, the result holds what came before", result.source.name));
    }
}

/// Why a source that ended without a sample gave none, in words.
pub fn no_sample(result: &SourceResult) -> String {
    let name = &result.source.name;
    match result.timing.excluded {
        0 => format!("{name}: no valid sample in {} bytes", result.link.bytes),
        1 => format!("{name}: its only sample lies in the excluded time"),
        excluded => format!("{name}: all {excluded} samples lie in the excluded time"),
    }
}

fn not_met(result: &SourceResult, goal: &Goal) -> String {
    let name = &result.source.name;
    if let Some(why) = result.out_of_reach(goal) {
        return format!("{name}: {goal} cannot be reached: {why}");
    }
    let known: Vec<String> = (result.half_widths(goal).iter())
        .map(|(axis, width)| match width {
            Some(width) => format!("{axis} ±{:.1} %", 100.0 * width),
            None => format!("{axis} is not estimated"),
        })
        .collect();
    let known = if known.is_empty() { "the stream has no such channel".into() } else { known.join(", ") };
    format!("{name}: the measurement ended before {goal} was reached: {known}")
}

#[cfg(test)]
mod tests {
    use std::{sync::Arc, time::Duration};

    use vn100_analysis::{Assessment, SourceFacts, WarningKind, protocol::VNIMU};

    use super::*;
    use crate::{
        remedies::page_words,
        tests::fixture::{ended, facts, nothing, result},
        warnings::headline,
    };

    #[test]
    fn a_source_without_samples_says_why() {
        let nothing_came = ended(facts("a.csv"), nothing(), &[]);
        assert_eq!(nothing_came.completion, Completion::NoData);
        assert_eq!(nothing_came.source.error.as_deref(), Some("a.csv: no valid sample in 0 bytes"));
        for (excluded, text) in [(1, "its only sample lies in"), (7, "all 7 samples lie in")] {
            let mut snapshot = nothing();
            snapshot.timing.excluded = excluded;
            let error = ended(facts("a.csv"), snapshot, &[]).source.error.unwrap();
            assert!(error.contains(text), "{error}");
        }
    }

    #[test]
    fn a_goal_that_was_not_reached_is_reported_with_what_is_known() {
        let goals = ["gyro N ±5%".parse().unwrap()];
        let mut snapshot = nothing();
        snapshot.layout = Some(Arc::new(VNIMU.clone()));
        snapshot.timing.samples = 3;
        let unmet = Goal::unmet(&goals, &snapshot, &Assessment::new(&snapshot, 0.95));
        let result = ended(facts("a.csv"), snapshot, &unmet);
        assert_eq!(result.completion, Completion::NotMet);
        let [unmet] = &result.unmet[..] else { panic!("{:?}", result.unmet) };
        assert!(unmet.starts_with("a.csv: the measurement ended before gyro N ±5 % was reached: "), "{unmet}");
    }

    #[test]
    fn an_early_end_fails_a_live_source_and_is_a_note_of_a_capture() {
        let shortfall = Shortfall { wanted: Duration::from_secs(9), measured: Duration::from_secs(3) };
        for (is_live, completion, severity) in
            [(true, Completion::Failed, Severity::Problem), (false, Completion::Complete, Severity::Note)]
        {
            let mut snapshot = nothing();
            snapshot.timing.samples = 3;
            let ended =
                Ended { end: &End::SourceEnded, shortfall: Some(&shortfall), unmet: &[], is_live, words: page_words };
            let result = ended.complete(result(facts("a.csv"), snapshot));
            let early = result.warnings.iter().find(|warning| warning.kind == WarningKind::Incomplete).unwrap();
            assert_eq!((result.completion, early.severity), (completion, severity));
            let text = headline(early);
            assert!(text.contains("after 3 s of data of the 9 s asked for"), "{text}");
            assert_eq!(result.source.error.is_some(), is_live);
        }
    }

    #[test]
    fn later_events_are_noted_and_the_worst_completion_stays() {
        let refused = SourceFacts { error: Some("no such port".into()), ..facts("a.csv") };
        let mut refused = ended(refused, nothing(), &[]);
        refused.note_failure("cut short".into());
        note_interrupted(&mut refused);
        note_failed_recording(&mut refused, "the disk is full".into());
        assert_eq!(refused.completion, Completion::NoData);
        assert_eq!(refused.source.error.as_deref(), Some("no such port"));
        assert!(refused.warnings.iter().any(|warning| headline(warning) == "the disk is full"));
        let mut whole = result(facts("a.csv"), nothing());
        note_interrupted(&mut whole);
        let interrupted = Some("a.csv: interrupted, the result holds what came before");
        assert_eq!((whole.completion, whole.source.error.as_deref()), (Completion::Complete, interrupted));
        let mut none = ended(facts("a.csv"), nothing(), &[]);
        note_interrupted(&mut none);
        assert_eq!((none.completion, none.source.error.as_deref()), (Completion::NoData, interrupted));
        note_failed_recording(&mut whole, "x".into());
        assert_eq!(whole.completion, Completion::Failed);
    }
}
