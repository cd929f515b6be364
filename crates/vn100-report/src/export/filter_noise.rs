//! White noise N and random walk K of gyroscope and accelerometer as a filter takes them: one
//! number for all axes, each with what it is, from a record or from a data sheet.

use thiserror::Error;
use vn100_analysis::noise::{Claim, Sensor, Status, Term, si_unit};
use vn100_analysis::protocol::Quantity;
use vn100_analysis::{
    ChannelResult, Datasheet, DatasheetFigure, Inflation, LongTauValidity, Remedy, RemedyWords, Setting, SourceResult,
    WALK_OF_FLICKER, axes_name, letter, sensor_name, uncompensated_message,
};

use crate::printable;

/// The time in seconds over which a filter integrates, where the user does not give one.
pub const DEFAULT_SPAN_S: f64 = 60.0;

const SHEET_WALK: &str =
    "K by a data sheet, which prints none: B/sqrt(T) of its bias instability B, the upper end at T = 60 s";

/// The times in seconds over which a walk drifts as the bias instability of a sheet does: no sheet
/// prints a walk.
const SHEET_WALK_S: (f64, f64) = (60.0, 1000.0);

/// N and K of the two inertial sensors, the rate of their samples, and what the file of a filter needs
/// beside them.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterNoise {
    /// Sample rate of the stream in hertz; `None` if it is not known.
    pub rate_hz: Option<f64>,
    /// Topic of the sensor in the bag that was measured; `None` for any other source.
    pub topic: Option<String>,
    /// Error of the scale factor in ppm, which no record at rest shows; `None` if the user gave none.
    pub scale_factor_ppm: Option<f64>,
    /// What is said at the head of a file that takes a term: with N all that is not of K alone.
    remarks: Vec<(Term, String)>,
    /// Of the accelerometer and the gyroscope, each N and K.
    values: Vec<FilterValue>,
    /// The sensors of which the stream has no channel.
    absent: Vec<Sensor>,
    was_moved: bool,
}

/// N or K of a sensor.
#[derive(Debug, Clone, PartialEq)]
struct FilterValue {
    sensor: Sensor,
    term: Term,
    /// The value, or why it is not known.
    found: Result<KnownValue, Missing>,
    /// What inflation gives; 0 if there is none.
    least: f64,
}

/// A value in SI units.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct KnownValue {
    pub(super) value: f64,
    /// What it is, with its axis.
    pub(super) label: String,
}

/// What the file of a filter needs and a source does not show.
#[derive(Debug, Clone, PartialEq)]
pub struct Missing {
    /// The value, such as `K of the gyroscope`.
    pub value: String,
    /// Why it is not known.
    pub why: String,
    /// What would give it.
    pub remedies: Vec<Remedy>,
}

/// Why a file for a filter is not written.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NotWritten {
    /// The sensor was moved.
    #[error("the sensor was moved in this record, which shows none of its noise")]
    Moved,
    /// The values that the filter needs and that are not known.
    #[error("{}", words_of(.0))]
    Lacks(Vec<Missing>),
}

fn words_of(missing: &[Missing]) -> String {
    missing.iter().map(|Missing { value, why, .. }| format!("{value} is missing: {why}")).collect::<Vec<_>>().join("; ")
}

impl NotWritten {
    /// What would give the missing values, each remedy once, in the words of a face.
    pub fn advice(&self, words: RemedyWords) -> String {
        let Self::Lacks(missing) = self else { return "record it at rest".into() };
        let mut all: Vec<String> = Vec::new();
        for remedy in missing.iter().flat_map(|missing| &missing.remedies) {
            let words = words(remedy);
            if !all.contains(&words) {
                all.push(words);
            }
        }
        all.join(", or ")
    }
}

/// How the samples of a sensor are made of what its data sheet specifies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetStream {
    /// Samples per second.
    pub rate_hz: f64,
    /// Density of white noise in the stream over that of the sensor: 1 without aliasing.
    pub aliasing: f64,
}

const QUANTITIES: [(Quantity, Sensor); 2] =
    [(Quantity::Acceleration, Sensor::Accelerometer), (Quantity::AngularRate, Sensor::Gyroscope)];
pub(crate) const TERMS: [Term; 2] = [Term::White, Term::RateRandomWalk];

impl FilterNoise {
    /// For each sensor the values of its noisiest axis: N, and as K the larger of K and 1.15
    /// B/√span, the walk that drifts in `span_s` seconds as much as the bias instability. A value
    /// without an estimate is an upper bound; if there is no bound, it is missing.
    pub fn of(record: &SourceResult, span_s: f64) -> Self {
        let source = &record.source;
        let message = source.message.as_deref().unwrap_or("no message");
        let rate = record.timing.rate_hz.map_or_else(|| "an unknown rate".into(), |hz| format!("{hz} Hz"));
        let started = source.recording.as_ref().and_then(|recording| recording.started());
        let serial = source.device.as_ref().and_then(|device| device.serial_number.as_ref());
        let mut origin = format!("record {}", printable(&source.name));
        origin.extend(started.map(|started| format!(", started {started}")));
        origin.extend(serial.map(|serial| format!(", serial number {}", printable(serial))));
        let counted = format!(
            "{} samples of {} at {rate}; upper bounds at a confidence of {}",
            record.timing.samples,
            printable(message),
            record.confidence
        );
        let mut remarks = vec![
            (Term::White, origin),
            (Term::White, counted),
            (Term::White, "values of the noisiest axis, as measured in this stream at this rate".into()),
            (Term::RateRandomWalk, format!("K: the larger of the random walk and 1.15 B/sqrt({span_s} s)")),
        ];
        if record.timing.is_rate_assumed() {
            remarks.push((Term::White, "the rate is assumed, and the values with it".into()));
        }
        if source.compensated.is_none() {
            let unknown = "if the rates are bias-compensated, which is not known, B and K are too small";
            remarks.push((Term::RateRandomWalk, unknown.into()));
        }
        let has = |of| record.streamed().any(|channel| channel.quantity == of);
        Self {
            rate_hz: record.timing.rate_hz,
            // no filter reads another type
            topic: source.bag.as_ref().filter(|bag| bag.type_name.ends_with("/Imu")).map(|bag| bag.topic.clone()),
            scale_factor_ppm: None,
            remarks,
            values: QUANTITIES.into_iter().flat_map(|of| measured(record, of, span_s)).collect(),
            absent: QUANTITIES.into_iter().filter(|(of, _)| !has(*of)).map(|(_, sensor)| sensor).collect(),
            was_moved: record.motion.is_some(),
        }
    }

    /// Those that a data sheet gives: N as the upper end of its figure times the aliasing, and as K
    /// the walk that drifts in a minute as much as the bias instability B of the sheet: of the range
    /// B/√T with T from 1000 to 60 s the upper end. A figure that the sheet lacks is missing.
    pub fn of_datasheet(sheet: &Datasheet, stream: SheetStream) -> Self {
        let SheetStream { rate_hz, aliasing } = stream;
        let aliased = match aliasing {
            1.0 => "N as printed: nothing aliases".into(),
            factor => format!("N is {factor:.3} times the printed one, by aliasing in a stream of {rate_hz} Hz"),
        };
        let of_sensor = |(_, sensor)| {
            TERMS.map(|term| FilterValue { sensor, term, found: printed(sheet, sensor, term, aliasing), least: 0.0 })
        };
        let note = sheet.note.as_deref().map(|note| format!("the sheet: {}", printable(note)));
        let of_all = [Some(format!("from a data sheet: {}", printable(&sheet.name))), Some(aliased), note];
        let of_all = of_all.into_iter().flatten().map(|remark| (Term::White, remark));
        Self {
            rate_hz: Some(rate_hz),
            topic: None,
            scale_factor_ppm: None,
            remarks: of_all.chain([(Term::RateRandomWalk, SHEET_WALK.into())]).collect(),
            values: QUANTITIES.into_iter().flat_map(of_sensor).collect(),
            absent: Vec::new(),
            was_moved: false,
        }
    }

    /// Takes the sensor that this stream lacks from another stream of the same capture. A stream that lacks
    /// both is none that a filter reads.
    pub fn join(&mut self, other: &Self) {
        let is_read = self.absent.len() < QUANTITIES.len();
        let in_other = |sensor: &Sensor| !other.absent.contains(sensor);
        for sensor in self.absent.clone().into_iter().filter(in_other) {
            let both = self.values.iter_mut().zip(&other.values).filter(|(value, _)| value.sensor == sensor);
            both.for_each(|(value, found)| match &mut value.found {
                Err(missing) if !is_read => {
                    missing.why += ", which another stream of the capture has";
                    missing.remedies = vec![Remedy::GiveTopic];
                }
                _ => value.clone_from(found),
            });
            if is_read {
                let origin: Vec<_> = other.remarks.iter().take(2).map(|(_, remark)| &**remark).collect();
                let remark = format!("the {} is that of another stream: {}", sensor_name(sensor), origin.join(", "));
                self.remarks.push((Term::White, remark));
                self.was_moved |= other.was_moved;
                self.absent.clear();
            }
        }
    }

    /// Takes from a data sheet what a record does not show.
    pub fn fill(&mut self, sheet: &Datasheet, aliasing: f64) {
        for value in self.values.iter_mut().filter(|value| value.found.is_err()) {
            let term = value.term;
            if let Ok(known) = printed(sheet, value.sensor, term, aliasing) {
                let (name, sheet) = (name_of(value.sensor, term), printable(&sheet.name));
                let aliased = match term {
                    Term::White if aliasing > 1.0 => format!(", {aliasing:.3} times the printed one by aliasing"),
                    Term::White => ", as printed: what aliases in this stream is not known".into(),
                    _ => String::new(),
                };
                self.remarks.push((term, format!("not measured, from the data sheet of {sheet}: {name}{aliased}")));
                if term == Term::RateRandomWalk && !self.remarks.iter().any(|(_, remark)| remark == SHEET_WALK) {
                    self.remarks.push((term, SHEET_WALK.into()));
                }
                value.found = Ok(known);
            }
        }
    }

    /// No data sheet is known that would give what a record does not show: one is to be named.
    pub(crate) fn lacks_datasheet(&mut self) {
        for missing in self.values.iter_mut().filter_map(|value| value.found.as_mut().err()) {
            missing.remedies.retain(|remedy| *remedy != Remedy::FillFromDatasheet);
            missing.remedies.push(Remedy::GiveDatasheet);
        }
    }

    /// N or K of a sensor; `None` for one that is not known, and for any other.
    pub fn value(&self, sensor: Sensor, term: Term) -> Option<f64> {
        let value = self.values.iter().find(|value| (value.sensor, value.term) == (sensor, term))?;
        Some(value.found.as_ref().ok()?.value)
    }

    fn of_terms(&self, terms: &[Term]) -> impl Iterator<Item = &FilterValue> {
        self.values.iter().filter(|value| terms.contains(&value.term))
    }

    /// The values of these terms that are missing.
    pub(super) fn missing(&self, terms: &[Term]) -> Result<Vec<Missing>, NotWritten> {
        if self.was_moved {
            return Err(NotWritten::Moved);
        }
        Ok(self.of_terms(terms).filter_map(|value| value.found.as_ref().err().cloned()).collect())
    }

    /// What is said at the head of a file that takes these terms. A filter with less than the inflated
    /// values is too sure; if the file has more, they say nothing.
    pub(super) fn remarks(&self, terms: &[Term]) -> Vec<String> {
        let of_term = |term| self.remarks.iter().filter(move |(of, _)| of == term).map(|(_, remark)| remark.clone());
        let is_more = |of: &&FilterValue| of.found.as_ref().is_ok_and(|known| of.least > known.value);
        let more = self.of_terms(terms).filter(is_more);
        let more =
            more.map(|of| format!("{} {:.3e} {}", name_of(of.sensor, of.term), of.least, si_unit(of.sensor, of.term)));
        let more = more.collect::<Vec<_>>().join(", ");
        let more = (!more.is_empty())
            .then(|| format!("by the fit, a filter that shall not be too sure takes at least: {more}"));
        terms.iter().flat_map(of_term).chain(more).collect()
    }

    /// Each value of these terms with its SI unit and what it is, as lines.
    pub(crate) fn labels(&self, terms: &[Term]) -> Vec<String> {
        let label = |FilterValue { sensor, term, found, .. }: &FilterValue| {
            let KnownValue { value, label } = found.as_ref().ok()?;
            Some(format!("{} = {value:.5e} {}: {label}", name_of(*sensor, *term), si_unit(*sensor, *term)))
        };
        self.of_terms(terms).filter_map(label).collect()
    }
}

/// Such as `K of the gyroscope`.
fn name_of(sensor: Sensor, term: Term) -> String {
    format!("{} of the {}", letter(term), sensor_name(sensor))
}

/// N and K of one sensor of a record.
fn measured(record: &SourceResult, (quantity, sensor): (Quantity, Sensor), span_s: f64) -> [FilterValue; 2] {
    let largest = |of: fn(&Inflation) -> f64| {
        record.of(quantity).iter().filter_map(|axis| axis.inflation.as_ref()).map(of).fold(0.0, f64::max)
    };
    let white = |found| FilterValue { sensor, term: Term::White, found, least: largest(|bound| bound.white) };
    let walk = |found| FilterValue { sensor, term: Term::RateRandomWalk, found, least: largest(|bound| bound.walk) };
    let axes: Vec<_> = record.streamed().filter(|channel| channel.quantity == quantity).collect();
    let missing = |term, why: &str, remedies: &[Remedy]| {
        let remedies = remedies.iter().cloned().chain([Remedy::FillFromDatasheet]).collect();
        Err(Missing { value: name_of(sensor, term), why: why.into(), remedies })
    };
    let Some(noise) = axes.first().and_then(|axis| axis.noise.as_ref()) else {
        let why = format!("the stream has no channel {}", axes_name(sensor));
        let missing = |term| missing(term, &why, &[Remedy::MapColumns(None)]);
        return [white(missing(Term::White)), walk(missing(Term::RateRandomWalk))];
    };
    let uncompensated = uncompensated_message(record.source.message.as_deref().unwrap_or_default());
    let another_message = [Remedy::MeasureWith(Setting::Message(uncompensated))];
    let (no_walk, cure): (_, &[Remedy]) = match noise.long_taus {
        LongTauValidity::Sensor => not_shown(&axes, Term::RateRandomWalk),
        LongTauValidity::Compensated => ("B and K are not measurable in a bias-compensated message", &another_message),
        LongTauValidity::LooksCompensated => {
            ("a filter removes the bias from this stream, and B and K with it", &[Remedy::SayCompensated])
        }
        LongTauValidity::Surroundings | LongTauValidity::Motion | LongTauValidity::Spoiled => {
            ("B and K are not the sensor's", &[])
        }
    };
    let (no_white, white_cure) = not_shown(&axes, Term::White);
    let density = noisiest(&axes, density).map_or_else(|| missing(Term::White, no_white, white_cure), Ok);
    let slow = noisiest(&axes, |axis| random_walk(axis, span_s)).filter(|_| noise.long_taus == LongTauValidity::Sensor);
    [white(density), walk(slow.map_or_else(|| missing(Term::RateRandomWalk, no_walk, cure), Ok))]
}

/// Why a record whose long averaging times are those of the sensor shows a term on no axis, and what would
/// show it.
fn not_shown(axes: &[&ChannelResult], term: Term) -> (&'static str, &'static [Remedy]) {
    let mut statuses = axes.iter().filter_map(|axis| Some(axis.noise.as_ref()?.parameter(term)?.status));
    match statuses.find(|status| *status != Status::NotObservable) {
        Some(Status::NotMeasurable) => ("the rounding of its samples hides it, and more digits show it", &[]),
        Some(Status::ModelRejected) => ("its deviation follows the noise model over no range of averaging times", &[]),
        _ => ("neither an estimate nor an upper bound; the record is too short", &[Remedy::Plan]),
    }
}

/// The largest value of the axes; an axis without a value is named.
fn noisiest(axes: &[&ChannelResult], of: impl Fn(&ChannelResult) -> Option<KnownValue>) -> Option<KnownValue> {
    let unknown: Vec<&str> = axes.iter().filter(|axis| of(axis).is_none()).map(|axis| axis.name.as_str()).collect();
    let known = axes.iter().filter_map(|axis| of(axis)).max_by(|a, b| a.value.total_cmp(&b.value))?;
    let except = if unknown.is_empty() { String::new() } else { format!("; not known: {}", unknown.join(", ")) };
    Some(KnownValue { label: known.label + &except, ..known })
}

/// The estimate of a parameter, or else its upper bound; and whether it is an estimate.
fn known(axis: &ChannelResult, term: Term) -> Option<(f64, bool)> {
    let parameter = axis.noise.as_ref()?.parameter(term)?;
    let estimate = parameter.value.filter(|_| parameter.status == Status::Estimated);
    estimate.map(|value| (value, true)).or_else(|| Some((parameter.upper?, false)))
}

fn density(axis: &ChannelResult) -> Option<KnownValue> {
    let (value, is_estimate) = known(axis, Term::White)?;
    let status = if is_estimate { "estimated" } else { "upper bound, N is not estimated" };
    Some(KnownValue { value, label: format!("{}, {status}", printable(&axis.name)) })
}

/// Bias instability that was not detected says nothing beside a K that was.
fn random_walk(axis: &ChannelResult, span_s: f64) -> Option<KnownValue> {
    let walk = known(axis, Term::RateRandomWalk);
    let flicker = known(axis, Term::BiasInstability);
    let flicker = flicker.map(|(b, is_estimate)| (WALK_OF_FLICKER * b / span_s.sqrt(), is_estimate));
    let flicker = flicker.filter(|(_, is_estimate)| *is_estimate || !walk.is_some_and(|(_, is_estimate)| is_estimate));
    let by_flicker = match (walk, flicker) {
        (Some((walk, _)), Some((flicker, _))) => flicker > walk,
        (walk, _) => walk.is_none(),
    };
    let (value, is_estimate) = if by_flicker { flicker? } else { walk? };
    let axis = printable(&axis.name);
    let label = match (by_flicker, is_estimate) {
        (false, true) => format!("{axis}, estimated"),
        (false, false) => format!("{axis}, random walk not detected, upper bound"),
        (true, true) => format!("{axis}, by its bias instability over {span_s} s, B estimated"),
        (true, false) => format!("{axis}, by its bias instability over {span_s} s, B not detected, upper bound"),
    };
    Some(KnownValue { value, label })
}

/// N or K by a data sheet.
fn printed(sheet: &Datasheet, sensor: Sensor, term: Term, aliasing: f64) -> Result<KnownValue, Missing> {
    let of = |term: &Term| {
        let figure = figure(sheet, sensor, *term)?;
        let (smallest, largest) = figure.claim.ends();
        let figures = printable(&figure.printed);
        let (value, label) = match term {
            Term::White if figure.is_of_unknown_sides => {
                (largest * aliasing, format!("{figures}, taken as two-sided; as one-sided 0.707 times"))
            }
            Term::White => (largest * aliasing, figures),
            Term::BiasInstability => {
                let (high, low) = (largest / SHEET_WALK_S.0.sqrt(), smallest / SHEET_WALK_S.1.sqrt());
                (high, format!("upper end of {low:.2e} to {high:.2e}, B/sqrt(T) of B {figures}"))
            }
            _ => (largest, figures),
        };
        Some(KnownValue { value, label: format!("data sheet, {label}") })
    };
    let (asked, terms): (_, &[Term]) = match term {
        Term::White => ("density of the white noise", &[Term::White]),
        _ => ("bias instability", &[Term::RateRandomWalk, Term::BiasInstability]),
    };
    terms.iter().find_map(of).ok_or_else(|| Missing {
        value: name_of(sensor, term),
        why: format!("the data sheet {} gives no {asked} of this sensor", printable(&sheet.name)),
        remedies: vec![Remedy::GiveDatasheet, Remedy::Record],
    })
}

/// The figure of a term that says the most: a typical value of one meaning before any other.
fn figure(sheet: &Datasheet, sensor: Sensor, term: Term) -> Option<&DatasheetFigure> {
    let figures = sheet.figures.iter().filter(|figure| figure.sensor == sensor && figure.term == term);
    figures.min_by_key(|figure| (figure.is_of_unknown_sides, matches!(figure.claim, Claim::Limit(_))))
}
