//! The result of the measurement of one source. It is completed with verdicts against a data sheet,
//! and whether the parameters that must pass do, and converted to the units
//! of a report.

use std::sync::Arc;

use vn100_analysis::noise::Claim;
use vn100_analysis::protocol::{BINARY, Quantity, Register, stream::AbsentValues};
use vn100_analysis::{
    Assessment, ComparedRecord, Datasheet, DatasheetFigure, FigureVerdict, Finding, NoiseFigure, Remedy, Severity,
    Snapshot, SourceFacts, UnmetGoal, Verdicts, Warning, WarningKind, WhyUnmet, not_passed,
};

use crate::{
    datasheet::{DatasheetError, vn100_datasheet},
    names::{sentence, verdict_name},
    units::{ChannelValues, NormValues, channel_values, norm_values},
};

/// The result of one source. If nothing could be read it has no samples, and `facts` hold the
/// reason.
#[derive(Debug, Clone)]
pub struct Measured {
    /// The facts of the source.
    pub facts: SourceFacts,
    /// The numbers of the measurement.
    pub snapshot: Arc<Snapshot>,
    /// The assessment of the snapshot.
    pub assessment: Assessment,
    /// The verdicts; `None` without a data sheet for the sensor.
    pub verdicts: Option<Verdicts>,
    /// Goals that were not reached, and parameters that did not pass, in words.
    pub unmet: Vec<String>,
    /// Whether the measurement is complete and its goals are met.
    pub completion: Completion,
}

/// The outcome of a measurement, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Completion {
    /// The source was read to its end.
    Complete,
    /// The source was read to its end, and a goal was not reached or a parameter did not pass.
    NotMet,
    /// The measurement could not be finished.
    Failed,
    /// The source could not be opened, or gave no valid sample.
    NoData,
    /// The user did not give what only the user knows, such as the rate.
    NotGiven,
}

impl Measured {
    /// The result of a source under way as if it ended now; `assessment` is that of this snapshot.
    #[must_use]
    pub fn so_far(facts: SourceFacts, snapshot: Arc<Snapshot>, assessment: Assessment) -> Self {
        let (unmet, completion) = (Vec::new(), Completion::Complete);
        let mut measured = Self { facts, snapshot, assessment, verdicts: None, unmet, completion };
        measured.warn_of_unread();
        measured
    }

    /// What was taken for absent by the first messages of a bag, and is not; and the numbers of a
    /// table that the counts of its first rows do not hold, if they are more than single glitches.
    fn warn_of_unread(&mut self) {
        let beyond = self.facts.csv.iter().flat_map(|csv| {
            let is_often = |absent: &&AbsentValues| 1000 * absent.out_of_range > csv.rows;
            csv.absent.iter().filter(is_often).map(|absent| {
                let found = Warning::new(WarningKind::Gaps, Finding::OutOfRange(absent.out_of_range, csv.rows));
                found.of([absent.channel.clone()]).as_severe_as(Severity::Problem)
            })
        });
        let beyond: Vec<Warning> = beyond.collect();
        let unread = self.facts.bag.iter().flat_map(|bag| &bag.unread);
        let warnings: Vec<Warning> = unread
            .filter(|unread| unread.nonzero_messages > 0)
            .map(|unread| {
                let found = Warning::new(WarningKind::Gaps, Finding::Unread(unread.clone()));
                found.as_severe_as(Severity::Problem).cured_by(Remedy::MapColumns(None))
            })
            .chain(beyond)
            .collect();
        if !warnings.is_empty() {
            Arc::make_mut(&mut self.snapshot).warnings.extend(warnings);
        }
    }

    /// The result of a source that ended without meeting the goals in `unmet`; if the source
    /// could not be opened, or an error ended it, `facts` hold the reason.
    #[must_use]
    pub fn ended(
        facts: SourceFacts,
        snapshot: Arc<Snapshot>,
        assessment: Assessment,
        unmet_goals: &[UnmetGoal],
    ) -> Self {
        let mut measured = Self::so_far(facts, snapshot, assessment);
        let Self { facts, snapshot, unmet, completion, .. } = &mut measured;
        if facts.error.is_some() {
            *completion = Completion::Failed;
        }
        let out_of_reach = unmet_goals.iter().any(|unmet| matches!(unmet.why, WhyUnmet::OutOfReach(_)));
        // if a goal is out of reach, the measurement ended before there had to be a sample
        if snapshot.timing.samples == 0 && !out_of_reach {
            facts.error.get_or_insert_with(|| no_sample(&facts.name, snapshot));
            *completion = Completion::NoData;
        }
        unmet.extend(unmet_goals.iter().map(|unmet| not_met(&facts.name, unmet)));
        if !unmet.is_empty() {
            *completion = (*completion).max(Completion::NotMet);
        }
        measured
    }

    /// Notes that the recording is incomplete for the reason `text`: adds a warning, and the
    /// measurement has failed.
    pub fn note_failed_recording(&mut self, text: String) {
        let warning = Warning::new(WarningKind::Incomplete, Finding::Said(text));
        Arc::make_mut(&mut self.snapshot).warnings.insert(0, warning);
        self.completion = self.completion.max(Completion::Failed);
    }

    /// Notes that the measurement ended before what was asked for: adds a warning. For a live
    /// source it is a problem and the measurement has failed; for a capture, which has no more
    /// data, it is a note.
    pub fn note_ended_early(&mut self, text: String, details: &str, is_live: bool) {
        let said = if details.is_empty() { text.clone() } else { format!("{text}. {details}") };
        let mut warning = Warning::new(WarningKind::Incomplete, Finding::Said(said));
        if is_live {
            self.note_failure(format!("{}: {text}", self.facts.name));
        } else {
            warning.severity = Severity::Note;
        }
        Arc::make_mut(&mut self.snapshot).warnings.insert(0, warning);
    }

    /// Notes that the result is incomplete because of a fault that is no error of the source: the
    /// measurement has failed.
    pub fn note_failure(&mut self, text: String) {
        self.facts.error.get_or_insert(text);
        self.completion = self.completion.max(Completion::Failed);
    }

    /// All warnings of snapshot and assessment, the gravest first.
    #[must_use]
    pub fn warnings(&self) -> Vec<&Warning> {
        let mut all: Vec<&Warning> = self.snapshot.warnings.iter().chain(&self.assessment.warnings).collect();
        all.sort_by_key(|warning| warning.severity);
        all
    }

    /// The record for a comparison with others.
    #[must_use]
    pub fn compared(&self) -> ComparedRecord<'_> {
        ComparedRecord {
            name: &self.facts.name,
            snapshot: &self.snapshot,
            assessment: &self.assessment,
            started_ns: self.facts.recording.as_ref().and_then(|recording| recording.started_ns),
        }
    }

    /// Notes that the result was interrupted, although an interrupt ends it like the end of the
    /// data; if no sample came, the interrupt is the reason.
    pub fn note_interrupted(&mut self) {
        let SourceFacts { name, error, .. } = &mut self.facts;
        if error.as_ref().is_none_or(|error| *error == no_sample(name, &self.snapshot)) {
            *error = Some(format!("{name}: interrupted, the result holds what came before"));
        }
    }
}

/// Why a source that ended without a sample gave none, in words.
#[must_use]
pub fn no_sample(name: &str, snapshot: &Snapshot) -> String {
    let bytes = snapshot.link.bytes();
    match snapshot.timing.excluded {
        0 => format!("{name}: no valid sample in {bytes} bytes"),
        1 => format!("{name}: its only sample lies in the excluded time"),
        excluded => format!("{name}: all {excluded} samples lie in the excluded time"),
    }
}

fn not_met(name: &str, UnmetGoal { goal, why }: &UnmetGoal) -> String {
    let axes = match why {
        WhyUnmet::OutOfReach(why) => return format!("{name}: {goal} cannot be reached: {why}"),
        WhyUnmet::EndedBefore(axes) => axes,
    };
    let known: Vec<String> = (axes.iter())
        .map(|(axis, width)| match width {
            Some(width) => format!("{axis} ±{:.1} %", 100.0 * width),
            None => format!("{axis} is not estimated"),
        })
        .collect();
    let known = if known.is_empty() { "the stream has no such channel".into() } else { known.join(", ") };
    format!("{name}: the data ended before {goal} was reached: {known}")
}

/// The data sheet and requirements that every result is completed with.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// The user's; applies to any sensor.
    datasheet: Option<Datasheet>,
    /// The VN-100's; applies to its messages.
    vn100: Datasheet,
    fail_on: Vec<NoiseFigure>,
}

/// What the user wants a data sheet to decide.
#[derive(Debug, Clone, Default)]
pub struct Asked {
    /// Parameters that must pass.
    pub fail_on: Vec<NoiseFigure>,
    /// Whether typical figures pass and fail, as limits do.
    pub typical_is_limit: bool,
}

impl Evaluation {
    /// Compares with `datasheet`, whatever the sensor is; without one, compares VectorNav sentences
    /// and packets with the data sheet of the VN-100, except those of a sensor that reports another
    /// model.
    ///
    /// # Errors
    /// None, unless this program was built with an invalid data sheet.
    pub fn new(
        datasheet: Option<Datasheet>,
        Asked { fail_on, typical_is_limit }: Asked,
    ) -> Result<Self, DatasheetError> {
        let judged = |sheet| Datasheet { typical_is_limit, ..sheet };
        let vn100 = judged(vn100_datasheet()?);
        Ok(Self { datasheet: datasheet.map(judged), vn100, fail_on })
    }

    /// The parameters that must pass although the data sheet gives only a typical value, so that no
    /// verdict can decide; each with the name of the sheet.
    pub fn not_deciding(&self) -> impl Iterator<Item = (&NoiseFigure, &str)> {
        let sheet = self.datasheet.as_ref().unwrap_or(&self.vn100);
        let without_limit = self.fail_on.iter().filter(move |asked| {
            let concerns = |figure: &&DatasheetFigure| (figure.sensor, figure.term) == (asked.sensor, asked.term);
            let mut figures = sheet.figures.iter().filter(concerns).peekable();
            let has_some = figures.peek().is_some();
            has_some && !sheet.typical_is_limit && figures.all(|figure| matches!(figure.claim, Claim::Typical { .. }))
        });
        without_limit.map(|asked| (asked, sheet.name.as_str()))
    }

    /// Completes a result; a parameter that must pass and does not is added to `unmet`.
    #[must_use]
    pub fn complete(&self, mut measured: Measured) -> Measured {
        let (snapshot, assessment) = (&measured.snapshot, &measured.assessment);
        measured.verdicts = self.verdicts(snapshot, assessment);
        // a source that gave nothing has failed worse
        let gave_nothing = measured.completion == Completion::NoData;
        for figure in self.fail_on.iter().filter(|_| !gave_nothing) {
            let reasons = not_passed(figure, &measured.snapshot, measured.verdicts.as_ref());
            if !reasons.is_empty() {
                let reasons: Vec<_> = match &measured.assessment.motion {
                    Some(motion) => vec![motion.to_string()],
                    None => {
                        let absent = why_absent(figure, &measured.snapshot, measured.verdicts.as_ref());
                        reasons.iter().map(|(name, verdict)| reason(name, *verdict, absent)).collect()
                    }
                };
                let text = format!("{}: {figure} does not pass: {}", measured.facts.name, reasons.join(". "));
                measured.unmet.push(text);
                measured.completion = measured.completion.max(Completion::NotMet);
            }
        }
        measured
    }

    /// Verdicts on all channels; `None` without a data sheet for the sensor.
    #[must_use]
    pub fn verdicts(&self, snapshot: &Snapshot, assessment: &Assessment) -> Option<Verdicts> {
        let message = snapshot.layout.as_ref().map_or("", |layout| layout.message.as_ref());
        let model = snapshot.registers.get(&Register::MODEL.0);
        let says_vn100 = model.map(|model| model.trim().starts_with("VN-100"));
        let may_be_vn100 = (message.starts_with("VN") || message == BINARY) && snapshot.link.other_model.is_none();
        let is_vn100 = says_vn100.unwrap_or(may_be_vn100);
        let sheet = self.datasheet.as_ref().or_else(|| is_vn100.then_some(&self.vn100));
        sheet.map(|sheet| sheet.verdicts(snapshot, assessment))
    }
}

fn reason(name: &str, verdict: Option<&FigureVerdict>, absent: &str) -> String {
    match verdict {
        Some(judged) => format!("{name} is {}, {}", verdict_name(judged), sentence(judged.figure.sensor, judged)),
        None => format!("{name} {absent}"),
    }
}

/// Why nothing is decided on a figure.
fn why_absent(figure: &NoiseFigure, snapshot: &Snapshot, verdicts: Option<&Verdicts>) -> &'static str {
    if !snapshot.layout_channels().iter().any(|channel| figure.concerns(channel)) {
        "is not in the stream"
    } else if verdicts.is_none() {
        "cannot be compared: the sensor is not known to be a VN-100, and no other data sheet is given"
    } else {
        "has no such figure in the data sheet"
    }
}

/// A result in the units of a report.
#[derive(Debug, Clone)]
pub struct Record<'a> {
    /// The result.
    pub measured: &'a Measured,
    /// All channels: those of the stream in its order, then those read from registers.
    pub channels: Vec<ChannelValues>,
    /// The magnitude of the vector of each sensor that has three axes in the stream.
    pub norms: Vec<NormValues>,
}

impl<'a> Record<'a> {
    /// Converts a result to the units of a report.
    #[must_use]
    pub fn new(measured: &'a Measured) -> Self {
        let channels = channel_values(&measured.snapshot, &measured.assessment);
        Self { measured, channels, norms: norm_values(&measured.snapshot) }
    }

    /// The verdicts on the data sheet's figures for `channel`; none without a sheet.
    #[must_use]
    pub fn verdicts(&self, channel: &ChannelValues) -> &[FigureVerdict] {
        let place = self.channels.iter().position(|other| other.name == channel.name);
        let verdicts = self.measured.verdicts.as_ref().zip(place);
        verdicts.and_then(|(verdicts, place)| verdicts.channels.get(place)).map_or(&[][..], Vec::as_slice)
    }

    /// The channels of that quantity, in the order of [`channels`](Self::channels).
    #[must_use]
    pub fn of(&self, quantity: Quantity) -> Vec<&ChannelValues> {
        self.channels.iter().filter(|channel| channel.quantity == quantity).collect()
    }
}

/// The name of a record among several, by its place from 0: `run 1` for the first.
#[must_use]
pub fn run_name(number: usize) -> String {
    format!("run {}", number + 1)
}

/// The prefix of the figures of a record, by its place from 0: `run1-` for the first.
#[must_use]
pub fn run_prefix(number: usize) -> String {
    format!("run{}-", number + 1)
}

#[cfg(test)]
mod tests {
    use vn100_analysis::protocol::stream::{BagReport, StampSource, UnreadNumbers};
    use vn100_analysis::protocol::{PACKET_MESSAGES, VNIMU, stream::MessageName};
    use vn100_analysis::{Analysis, Settings};

    use super::*;

    fn ended(facts: SourceFacts, snapshot: Arc<Snapshot>) -> Measured {
        let assessment = Assessment::new(&snapshot, 0.95);
        Measured::ended(facts, snapshot, assessment, &[])
    }

    fn facts(error: Option<&str>) -> SourceFacts {
        SourceFacts { name: "a.csv".into(), error: error.map(str::to_owned), ..SourceFacts::default() }
    }

    fn nothing() -> Arc<Snapshot> {
        Arc::new(Analysis::new(Settings::default()).snapshot())
    }

    #[test]
    fn packets_are_compared_unless_the_sensor_says_it_is_another() {
        let evaluation = Evaluation::new(None, Asked::default()).unwrap();
        let by_model = [(None, true), (Some("VN-100S-CR"), true), (Some("VN-200T-CR"), false)];
        let layouts = [PACKET_MESSAGES[0].layout(), Some(Arc::new(VNIMU.clone()))];
        for (layout, (model, is_compared)) in layouts.iter().flat_map(|layout| by_model.map(|model| (layout, model))) {
            let mut snapshot = nothing();
            Arc::make_mut(&mut snapshot).layout = layout.clone();
            let registers = &mut Arc::make_mut(&mut snapshot).registers;
            registers.extend(model.map(|model| (Register::MODEL.0, model.into())));
            let assessment = Assessment::new(&snapshot, 0.95);
            assert_eq!(evaluation.verdicts(&snapshot, &assessment).is_some(), is_compared, "{model:?}");
            // sentences that no VN-100 sends
            let name = MessageName::new(b"VNINS");
            Arc::make_mut(&mut snapshot).link.other_model = Some(name);
            let is_compared = evaluation.verdicts(&snapshot, &assessment).is_some();
            assert_eq!(is_compared, model == Some("VN-100S-CR"), "{model:?}");
        }
    }

    #[test]
    fn what_is_not_decided_on_has_one_reason() {
        let mut snapshot = nothing();
        let figure = "mag N".parse().unwrap();
        assert_eq!(why_absent(&figure, &snapshot, None), "is not in the stream");
        Arc::make_mut(&mut snapshot).layout = Some(Arc::new(VNIMU.clone()));
        assert!(why_absent(&figure, &snapshot, None).starts_with("cannot be compared"));
        let evaluation = Evaluation::new(None, Asked::default()).unwrap();
        let verdicts = evaluation.verdicts(&snapshot, &Assessment::new(&snapshot, 0.95));
        assert_eq!(why_absent(&figure, &snapshot, verdicts.as_ref()), "has no such figure in the data sheet");
    }

    #[test]
    fn a_source_without_samples_says_why() {
        let measured = ended(facts(None), nothing());
        assert_eq!(measured.completion, Completion::NoData);
        assert_eq!(measured.facts.error.as_deref(), Some("a.csv: no valid sample in 0 bytes"));
        for (excluded, text) in [(1, "its only sample lies in"), (7, "all 7 samples lie in")] {
            let mut snapshot = nothing();
            Arc::make_mut(&mut snapshot).timing.excluded = excluded;
            let error = ended(facts(None), snapshot).facts.error.unwrap();
            assert!(error.contains(text), "{error}");
        }
    }

    #[test]
    fn numbers_taken_for_absent_that_are_not_are_warned_of() {
        for (nonzero_messages, warnings) in [(0, 0), (50, 1)] {
            let unread =
                vec![UnreadNumbers { path: "linear_acceleration".into(), zero_messages: 100, nonzero_messages }];
            let bag = BagReport {
                messages: 200,
                used: 200,
                unread,
                ..BagReport::of("/imu", "sensor_msgs/Imu", StampSource::Recorded)
            };
            let measured = ended(SourceFacts { bag: Some(bag), ..facts(None) }, nothing());
            let warned = measured.warnings().into_iter().filter(|warning| warning.kind == WarningKind::Gaps);
            assert_eq!(warned.count(), warnings);
        }
    }

    #[test]
    fn an_error_of_the_source_is_kept_and_fails_it() {
        let mut snapshot = nothing();
        Arc::make_mut(&mut snapshot).timing.samples = 3;
        let failed = ended(facts(Some("unplugged")), Arc::clone(&snapshot));
        assert_eq!((failed.completion, failed.facts.error.as_deref()), (Completion::Failed, Some("unplugged")));
        let good = ended(facts(None), snapshot);
        assert_eq!((good.completion, good.facts.error), (Completion::Complete, None));
    }

    #[test]
    fn a_goal_that_was_not_reached_is_reported_with_what_is_known() {
        let goals = ["gyro N ±5%".parse().unwrap()];
        let mut snapshot = nothing();
        {
            let snapshot = Arc::make_mut(&mut snapshot);
            snapshot.layout = Some(Arc::new(VNIMU.clone()));
            snapshot.timing.samples = 3;
        }
        let assessment = Assessment::new(&snapshot, 0.95);
        let unmet = UnmetGoal::of(&goals, &snapshot, &assessment);
        let measured = Measured::ended(facts(None), snapshot, assessment, &unmet);
        assert_eq!(measured.completion, Completion::NotMet);
        let [unmet] = &measured.unmet[..] else { panic!("{:?}", measured.unmet) };
        assert!(unmet.starts_with("a.csv: the data ended before gyro N ±5 % was reached: "), "{unmet}");
    }

    #[test]
    fn an_early_end_fails_a_live_source_and_is_a_note_of_a_capture() {
        for (is_live, completion, severity) in
            [(true, Completion::Failed, Severity::Problem), (false, Completion::Complete, Severity::Note)]
        {
            let mut measured = Measured::so_far(facts(None), nothing(), Assessment::new(&nothing(), 0.95));
            measured.note_ended_early("it was stopped after 3 s of 9 s".into(), "The link is down", is_live);
            let [warning] = &measured.snapshot.warnings[..] else { panic!() };
            assert_eq!((measured.completion, warning.severity), (completion, severity));
            assert_eq!(warning.finding, Finding::Said("it was stopped after 3 s of 9 s. The link is down".into()));
            let error = is_live.then_some("a.csv: it was stopped after 3 s of 9 s");
            assert_eq!(measured.facts.error.as_deref(), error);
        }
    }

    #[test]
    fn later_events_are_noted_and_the_worst_completion_stays() {
        let mut measured = ended(facts(Some("no such port")), nothing());
        measured.note_failure("cut short".into());
        measured.note_interrupted();
        measured.note_failed_recording("the disk is full".into());
        assert_eq!(measured.completion, Completion::NoData);
        assert_eq!(measured.facts.error.as_deref(), Some("no such port"));
        let [warning] = &measured.snapshot.warnings[..] else { panic!() };
        assert_eq!(warning.finding, Finding::Said("the disk is full".into()));
        let mut whole = Measured::so_far(facts(None), nothing(), Assessment::new(&nothing(), 0.95));
        whole.note_interrupted();
        assert_eq!(whole.completion, Completion::Complete);
        assert_eq!(whole.facts.error.as_deref(), Some("a.csv: interrupted, the result holds what came before"));
        let mut none = ended(facts(None), nothing());
        none.note_interrupted();
        assert_eq!((none.completion, none.facts.error), (Completion::NoData, whole.facts.error.clone()));
        whole.note_failed_recording("x".into());
        assert_eq!(whole.completion, Completion::Failed);
    }
}
