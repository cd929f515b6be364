//! The result of the measurement of one source: what every face shows of it, as plain data in SI
//! units.

mod channel;
mod drift;
mod history;
mod inflation;
mod noise;
mod time_base;
mod unread;
mod verdict;

use std::sync::Arc;

use imu_noise::{Deviation, Term, Verdict};
use schemars::JsonSchema;
use serde::Serialize;
use vn100_protocol::Quantity;

pub use channel::{BlockValues, ChannelResult, Curve, Norm, Point, Spectrum, Statistics};
pub use drift::{DriftResult, Drifting, angle_drift};
pub use history::History;
pub use inflation::{Inflation, WALK_OF_FLICKER};
pub use noise::{Budget, Discrete, Graded, InUnit, NoiseResult, ParameterResult, TemperatureResult};
pub use time_base::{LinkCounts, TimeBase};
use verdict::deciding_record_s;

use crate::{
    assessment::Assessment,
    datasheet::{Datasheet, DecidedBy, FigureVerdict},
    goal::Goal,
    motion::Motion,
    noise_figure::NoiseFigure,
    settings::Settings,
    snapshot::Snapshot,
    source_facts::{Device, EndKind, SourceFacts},
    warning::Warning,
};

/// Result of a measurement of one source. SI units; angles in degrees, magnetic field in gauss; null
/// if a number is not known. Fields may be added.
#[derive(Debug, Clone, JsonSchema, Serialize)]
pub struct SourceResult {
    /// The source.
    pub source: SourceFacts,
    /// The time base.
    pub timing: TimeBase,
    /// What the link or file carried.
    pub link: LinkCounts,
    /// Motion of the sensor, which hides its noise; null if the record shows the sensor at rest.
    pub motion: Option<Motion>,
    /// The channels: those of the message in its order, then those read from registers.
    pub channels: Vec<ChannelResult>,
    /// Magnitudes of the vectors of sensors with three axes.
    pub norms: Vec<Norm>,
    /// Drift of angle, velocity and position while the sensor coasts after a rest; only at the end.
    pub drift: Vec<DriftResult>,
    /// Data sheet that the channels are compared with; null without one for the sensor.
    pub datasheet: Option<ComparedSheet>,
    /// Goals that were not reached, and parameters that did not pass, in words.
    pub unmet: Vec<String>,
    /// Why the measurement ended; null while it is under way.
    pub end_reason: Option<EndKind>,
    /// Whether the measurement is complete and its goals are met; while it is under way, as if it
    /// ended now.
    pub completion: Completion,
    /// Limits of the result, the gravest first. A document has them in words.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
    /// Level of all intervals, 0 to 1; a document has it with each curve.
    #[serde(skip)]
    pub confidence: f64,
    #[serde(skip)]
    pub(crate) basis: Arc<Basis>,
}

/// The sums from which a result was made.
#[derive(Debug)]
pub(crate) struct Basis {
    pub(crate) snapshot: Arc<Snapshot>,
    pub(crate) assessment: Arc<Assessment>,
}

/// A data sheet that a result is compared with.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema, Serialize)]
pub struct ComparedSheet {
    /// Name of the sheet.
    pub name: String,
    /// How far the figures of the sheet can be trusted; null if it says nothing about that.
    pub note: Option<String>,
    /// Whether typical figures pass and fail, as limits do.
    pub typical_is_limit: bool,
}

/// The outcome of a measurement, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
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

impl Completion {
    /// Every outcome, the best first.
    pub const ALL: [Self; 5] = [Self::Complete, Self::NotMet, Self::Failed, Self::NoData, Self::NotGiven];
}

/// The parts of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parts {
    /// All parts.
    All,
    /// All but spectra, blocks and histograms, which take as long to make as all others.
    WithoutSignals,
}

impl SourceResult {
    /// The result of a source as if it ended now; without a sample there are no channels. The intervals of
    /// an assessment of an earlier snapshot of the same measurement are taken for those of this one.
    pub fn new(facts: SourceFacts, snapshot: Arc<Snapshot>, assessment: Arc<Assessment>, parts: Parts) -> Self {
        let source = with_stream(facts, &snapshot);
        let unread = unread::warnings(&source);
        let mut warnings: Vec<Warning> =
            snapshot.warnings.iter().chain(&unread).chain(&assessment.warnings).cloned().collect();
        warnings.sort_by_key(|warning| warning.severity);
        let channels = channel::of(&snapshot, &assessment, parts);
        let is_final = parts == Parts::All && snapshot.settings.deviation == Deviation::Allan;
        let drift = if is_final { drift::of(&channels, &snapshot.settings.coasts, &assessment) } else { Vec::new() };
        Self {
            timing: TimeBase::of(&snapshot),
            link: LinkCounts::of(&snapshot),
            motion: assessment.motion.clone(),
            channels,
            drift,
            norms: snapshot.magnitudes.iter().map(|norm| Norm::of(norm, &snapshot)).collect(),
            datasheet: None,
            unmet: Vec::new(),
            end_reason: source.end,
            completion: Completion::Complete,
            warnings,
            confidence: assessment.confidence,
            basis: Arc::new(Basis { snapshot, assessment }),
            source,
        }
    }

    /// The settings of the measurement.
    pub fn settings(&self) -> &Settings {
        &self.basis.snapshot.settings
    }

    /// The result of the same samples, assessed anew: without the intervals of an earlier snapshot.
    pub fn exact(&self) -> Self {
        let snapshot = Arc::clone(&self.basis.snapshot);
        let assessment = Arc::new(Assessment::new(&snapshot, self.confidence));
        Self::new(self.source.clone(), snapshot, assessment, Parts::All)
    }

    /// Takes newer facts of the source: its link, recording and replay change while no sample comes.
    pub fn update(&mut self, facts: SourceFacts) {
        self.source = with_stream(facts, &self.basis.snapshot);
    }

    /// The same with verdicts by this data sheet, without the records that would decide them.
    pub fn judge(&mut self, sheet: &Datasheet) {
        let Datasheet { name, note, typical_is_limit, .. } = sheet.clone();
        self.datasheet = Some(ComparedSheet { name, note, typical_is_limit });
        let verdicts = sheet.verdicts(&self.basis.snapshot, &self.basis.assessment);
        for (channel, verdicts) in self.channels.iter_mut().zip(verdicts) {
            channel.verdict = Some(verdicts).filter(|verdicts| !verdicts.is_empty());
        }
    }

    /// Finds the lengths of the records that would decide its open verdicts. A result
    /// [`Parts::WithoutSignals`] gets none: the search takes too long while a record grows.
    pub fn find_deciding_records(&mut self) {
        for (channel, assessed) in self.channels.iter_mut().zip(&self.basis.assessment.channels) {
            let Some(noise) = assessed.noise.as_ref().filter(|_| channel.spectrum.is_some()) else { continue };
            // how long slow noise must be averaged is known by the white noise that hides it
            let shows_white = noise.parameter(Term::White).is_some_and(|white| white.value.is_some());
            let is_open = |verdict: &&mut FigureVerdict| {
                let is_white = verdict.figure.term == Term::White;
                verdict.decided_by == Some(DecidedBy::LongerRecord) && (shows_white || is_white)
            };
            for verdict in channel.verdict.iter_mut().flatten().filter(is_open) {
                let length_s = deciding_record_s(verdict, noise, channel.rate_hz.recip(), self.confidence);
                verdict.deciding_record_s = length_s.filter(|length_s| *length_s > self.timing.duration_s);
                verdict.decided_by = length_s.map(|_| DecidedBy::LongerRecord).or(Some(DecidedBy::Nothing));
            }
        }
    }

    /// The channels of `figure` whose verdicts are not all a pass, each with such a verdict; empty if
    /// all pass. `None` stands for a channel without a limit, such as one with a typical figure alone,
    /// and, under the name of the figure, for a record without such a channel or for no data sheet.
    pub fn not_passed(&self, figure: &NoiseFigure) -> Vec<(String, Option<&FigureVerdict>)> {
        if self.datasheet.is_none() || !self.has_channel_of(figure) {
            return vec![(figure.to_string(), None)];
        }
        let mut reasons = Vec::new();
        for channel in self.channels_of(figure) {
            let of_term = || channel.verdicts().iter().filter(|verdict| verdict.figure.term == figure.term);
            if of_term().all(|judged| judged.verdict.is_none()) {
                reasons.push((channel.name.clone(), None));
            }
            let worse = of_term().filter(|judged| judged.verdict.is_some_and(|verdict| verdict != Verdict::Pass));
            reasons.extend(worse.map(|verdict| (channel.name.clone(), Some(verdict))));
        }
        reasons
    }

    fn channels_of(&self, figure: &NoiseFigure) -> impl Iterator<Item = &ChannelResult> {
        self.streamed().filter(|channel| figure.concerns(&channel.name, channel.quantity))
    }

    /// Whether the stream has a channel of this figure.
    pub fn has_channel_of(&self, figure: &NoiseFigure) -> bool {
        self.basis.snapshot.layout.as_ref().is_some_and(|layout| figure.is_in(layout))
    }

    /// Whether the channel of this figure is in another stream of the file alone.
    pub fn is_elsewhere(&self, figure: &NoiseFigure) -> bool {
        figure.is_only_in(&self.source.other_streams, self.basis.snapshot.layout.as_deref())
    }

    /// Why no record of this message shows the parameter of the goal; see [`Goal::out_of_reach`].
    pub fn out_of_reach(&self, goal: &Goal) -> Option<String> {
        goal.out_of_reach(&self.basis.snapshot)
    }

    /// How well the parameter of a goal is known by axis; see [`Goal::relative_half_widths`].
    pub fn half_widths(&self, goal: &Goal) -> Vec<(String, Option<f64>)> {
        goal.relative_half_widths(&self.basis.snapshot, &self.basis.assessment)
    }

    /// The channels of that quantity, in their order.
    pub fn of(&self, quantity: Quantity) -> Vec<&ChannelResult> {
        self.channels.iter().filter(|channel| channel.quantity == quantity).collect()
    }

    /// The channels of the stream, without those read from registers.
    pub fn streamed(&self) -> impl Iterator<Item = &ChannelResult> {
        self.channels.iter().filter(|channel| channel.is_streamed())
    }

    /// The latest samples of the channel at this place.
    pub fn history(&self, channel: usize, columns: usize, most_slots: usize) -> Option<History> {
        History::of(&self.basis.snapshot, channel, columns, most_slots)
    }

    /// The latest temperature that was read from a register, in °C; `None` without a reading.
    pub fn polled_temperature_c(&self) -> Option<f64> {
        self.basis.snapshot.polled_temperature_c()
    }

    /// Why it is not what was asked for, in words: its error, and what was not reached or did not pass.
    pub fn failures(&self) -> impl Iterator<Item = &String> {
        self.source.error.iter().chain(&self.unmet)
    }

    /// Adds a warning, at its place by severity, before others as grave.
    pub fn warn(&mut self, warning: Warning) {
        let place = self.warnings.partition_point(|other| other.severity < warning.severity);
        self.warnings.insert(place, warning);
    }

    /// Notes that the measurement has failed by no error of the source; an earlier one is kept.
    pub fn note_failure(&mut self, text: String) {
        self.source.error.get_or_insert(text);
        self.completion = self.completion.max(Completion::Failed);
    }
}

/// The facts with what the stream itself carries.
fn with_stream(facts: SourceFacts, snapshot: &Snapshot) -> SourceFacts {
    let layout = snapshot.layout.as_ref();
    SourceFacts {
        message: layout.map(|layout| layout.message.to_string()),
        compensated: layout.and_then(|layout| layout.compensated),
        device: Device::of(&snapshot.registers),
        marks: snapshot.marks.clone(),
        ..facts
    }
}
