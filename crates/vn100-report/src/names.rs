//! Names of quantities and results in words, the same in text, documents and reports.

use vn100_analysis::noise::{Deviation, Grade, Parameter, Sensor, Term, Verdict};
use vn100_analysis::protocol::Quantity;
use vn100_analysis::{
    Aliasing, DecidedBy, FigureVerdict, Graded, LinkCounts, Motion, NoGrade, NoPrediction, Onboard, Ranking, RateFrom,
    Ratio, TimeBase, WhiteBudget, WindowFrom,
};

use crate::{
    codes::{name_of, word_of},
    numbers::plain::{counted, digits, grouped},
    units::parameter_unit,
};

/// The quantities, in the order of results.
pub const QUANTITIES: [Quantity; 8] = [
    Quantity::AngularRate,
    Quantity::Acceleration,
    Quantity::MagneticField,
    Quantity::Angle,
    Quantity::Quaternion,
    Quantity::Temperature,
    Quantity::Pressure,
    Quantity::Value,
];

/// The names of a quantity.
#[derive(Debug, Clone, Copy)]
pub struct QuantityNames {
    /// The shortest name of the sensor that measures the quantity.
    pub short: &'static str,
    /// The quantity, in a sentence.
    pub quantity: &'static str,
    /// The sensor that measures the quantity, as a title.
    pub title: &'static str,
}

/// The names of a quantity.
pub fn names_of(quantity: Quantity) -> QuantityNames {
    let (short, quantity, title) = match quantity {
        Quantity::AngularRate => ("gyro", "angular rate", "Gyroscope"),
        Quantity::Acceleration => ("accel", "acceleration", "Accelerometer"),
        Quantity::MagneticField => ("mag", "magnetic field", "Magnetometer"),
        Quantity::Angle => ("angle", "orientation", "Orientation"),
        Quantity::Quaternion => ("quat", "orientation", "Orientation quaternion"),
        Quantity::Temperature => ("temp", "temperature", "Temperature"),
        Quantity::Pressure => ("baro", "pressure", "Pressure"),
        Quantity::Value => ("value", "series of values", "Series of values"),
    };
    QuantityNames { short, quantity, title }
}

/// Which deviation a [`Quantity::Value`] has.
pub const NEUTRAL_SERIES: &str = "The deviation is that of the numbers as rate data, such as fractional frequency or an angular rate; a series of \
                                  phase or angle is to be differenced first. Nothing about a sensor is concluded from them.";

/// The name of a deviation, as the title of a plot.
pub fn deviation_name(deviation: Deviation) -> &'static str {
    match deviation {
        Deviation::Allan => "Allan deviation",
        Deviation::Hadamard => "Hadamard deviation",
    }
}

/// The names of a noise parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ParameterNames {
    /// The name in IEEE Std 952, capitalised.
    pub name: &'static str,
    /// The abbreviation in use; empty if there is none.
    pub short: &'static str,
    /// Abbreviation or name in at most 12 characters, with the letter.
    pub label: &'static str,
    /// The slope of its line in the log-log plot of the deviation.
    pub slope: &'static str,
}

/// The names of a parameter of a sensor.
pub fn parameter_names(sensor: Sensor, term: Term) -> ParameterNames {
    let of = |name, short, label, slope| ParameterNames { name, short, label, slope };
    match (term, sensor) {
        (Term::White, Sensor::Gyroscope) => of("Angle Random Walk", "ARW", "ARW N", "-1/2"),
        (Term::White, Sensor::Accelerometer) => of("Velocity Random Walk", "VRW", "VRW N", "-1/2"),
        (Term::White, Sensor::Magnetometer) => of("Noise Density", "", "Density N", "-1/2"),
        (Term::BiasInstability, _) => of("Bias Instability", "BI", "Instab. B", "0"),
        (Term::RateRandomWalk, Sensor::Gyroscope) => of("Rate Random Walk", "RRW", "RRW K", "+1/2"),
        (Term::RateRandomWalk, Sensor::Accelerometer) => of("Accel. Random Walk", "", "Walk K", "+1/2"),
        (Term::RateRandomWalk, Sensor::Magnetometer) => of("Random Walk", "", "Walk K", "+1/2"),
        (Term::RateRamp, Sensor::Gyroscope) => of("Rate Ramp", "RR", "Ramp R", "+1"),
        (Term::RateRamp, _) => of("Ramp", "", "Ramp R", "+1"),
        (Term::Quantization, _) => of("Quantization Noise", "QN", "Quantiz. Q", "-1"),
    }
}

/// The rows of the budget of N that all axes of a sensor share: the name and the amount of each.
pub fn budget_rows(budget: &WhiteBudget, nominal_hz: f64) -> [(&'static str, String); 3] {
    let rate = match (budget.rate.relative, budget.rate.from) {
        (Some(relative), _) => {
            let off = match 100.0 * relative {
                ..0.005 => "below ±0.01 %".to_owned(),
                percent => format!("±{} %", digits(percent, 2)),
            };
            format!("{off}, by the arrival times against {nominal_hz} Hz; within the interval")
        }
        (None, RateFrom::DeviceTime) => "by the clock of the sensor: ±0.002 % as quoted".into(),
        (None, RateFrom::Device) => "not verified without arrival times: as reported by the sensor".into(),
        (None, RateFrom::Option) => "not verified without arrival times: as given".into(),
        (None, RateFrom::Arrival) => "not verified".into(),
        (None, RateFrom::Assumed) => "unknown, the rate is assumed: 1 % of it is 0.5 % of N".into(),
    };
    let aliasing = match budget.aliasing {
        None => "unknown: what is averaged before a sample is sent is not known".into(),
        Some(Aliasing { most: ..1.005, .. }) => "none at this rate, with any averaging window".into(),
        Some(Aliasing { factor, window_from: WindowFrom::Default, most, .. }) => format!(
            "N is {factor:.2} times the sensor's own at the factory default of register 85, 1 to {most:.2} times at others: not known"
        ),
        Some(Aliasing { factor, relative: None | Some(0.0), .. }) => {
            format!("none: N is {factor:.2} times the sensor's own")
        }
        Some(Aliasing { factor, relative: Some(uncertainty), .. }) => {
            format!("N is {factor:.2} times the sensor's own, ±{:.0} %", 100.0 * uncertainty)
        }
    };
    [
        ("sample rate", rate),
        ("aliasing on board", aliasing),
        ("scale factor", "not verified: a record at rest does not show it".into()),
    ]
}

/// How many sentences were rejected, and for which reasons.
pub fn rejected_lines(link: &LinkCounts) -> String {
    let present = rejected_kinds(link).into_iter().filter(|(_, count)| *count > 0);
    let present: Vec<_> = present.map(|(kind, count)| format!("{count} {}", kind.replace('-', " "))).collect();
    if present.is_empty() { "0".into() } else { format!("{} ({})", link.rejected.total(), present.join(", ")) }
}

/// The reasons for which sentences are rejected, each with its count.
pub(crate) fn rejected_kinds(link: &LinkCounts) -> [(&'static str, u64); 6] {
    let rejected = &link.rejected;
    [
        ("checksum", rejected.checksum),
        ("unchecked", rejected.unchecked),
        ("grammar", rejected.grammar),
        ("range", rejected.range),
        ("truncated", rejected.truncated),
        ("too-long", rejected.too_long),
    ]
}

/// How many packets fail their checksum, after the rejected lines; empty for none.
pub fn damaged_packets(link: &LinkCounts) -> String {
    match link.damaged_packets {
        0 => String::new(),
        count => format!(", {}", counted(count, "damaged packet")),
    }
}

/// The outages of a link; `None` for none.
pub fn outages(link: &LinkCounts) -> Option<String> {
    (link.outages.times > 0).then(|| link.outages.to_string())
}

/// The samples known to be missing, or that they are not known.
pub fn missing_text(timing: &TimeBase) -> String {
    match (timing.missing, timing.missing_at_least) {
        (Some(missing), _) => grouped(missing),
        (None, 0) => "unknown".into(),
        (None, at_least) => format!("at least {}", grouped(at_least)),
    }
}

/// How many samples are pending: `, 3 pending`; empty for none.
pub fn pending_text(timing: &TimeBase) -> String {
    if timing.pending == 0 { String::new() } else { format!(", {} pending", grouped(timing.pending)) }
}

/// The verdict in words, or how a typical figure compares: `pass`, `1.05 x typical`.
pub fn verdict_name(judged: &FigureVerdict) -> String {
    match judged.verdict {
        Some(verdict) => word_of("verdict", verdict),
        None => ratio(&judged.ratio).map_or_else(|| "not known".into(), |ratio| format!("{ratio} x typical")),
    }
}

/// The same in a narrow column: `pass`, `1.05 x typ`, `0.49-2.70 x`.
pub fn short_verdict(judged: &FigureVerdict) -> String {
    match (judged.verdict, ratio(&judged.ratio)) {
        (Some(Verdict::Fail), _) => "FAIL".into(),
        (Some(Verdict::NotComparable), _) => "n/a".into(),
        (Some(verdict), _) => word_of("verdict", verdict),
        (None, None) => "-".into(),
        (None, Some(ratio)) if judged.ratio.value.is_some() => format!("{ratio} x typ"),
        (None, Some(ratio)) => format!("{ratio} x"),
    }
}

/// What would decide an open verdict, as a noun; empty for any other.
pub fn decided_by(verdict: &FigureVerdict) -> String {
    match (verdict.decided_by, verdict.deciding_record_s) {
        (Some(DecidedBy::LongerRecord), Some(length_s)) => format!("a record of about {}", rough_duration(length_s)),
        (by, _) => by.map_or_else(String::new, |by| word_of("decided_by", by)),
    }
}

/// In two digits of its unit.
fn rough_duration(seconds: f64) -> String {
    let units = [(86_400.0, "days"), (3600.0, "h"), (60.0, "min"), (1.0, "s")];
    let (factor, unit) = units.into_iter().find(|(factor, _)| seconds >= 2.0 * factor).unwrap_or((1.0, "s"));
    format!("{} {unit}", digits(seconds / factor, 2))
}

/// The number of a ratio, or its ends if it has more than one reading; `None` if it is not known.
fn ratio(ratio: &Ratio) -> Option<String> {
    let digits = |value: f64| if value < 0.1 { digits(value, 1) } else { format!("{value:.2}") };
    match *ratio {
        Ratio { value: Some(value), .. } => Some(digits(value)),
        Ratio { lower: Some(lower), upper: Some(upper), .. } => Some(format!("{}-{}", digits(lower), digits(upper))),
        Ratio { upper: Some(upper), .. } => Some(format!("≤ {}", digits(upper))),
        Ratio { .. } => None,
    }
}

/// Why a gyroscope has no grade, in words.
fn no_grade(reason: NoGrade) -> &'static str {
    match reason {
        NoGrade::Moved => "the sensor was moved",
        NoGrade::BiasNotInStream => "the stream does not carry the sensor's bias instability",
        NoGrade::RateAssumed => "the sample rate is assumed",
        NoGrade::WhiteNotKnown => "the record says nothing of the angle random walk",
        NoGrade::BiasNotKnown => "the record says nothing of the bias instability",
    }
}

/// The grades that a gyroscope may have, or why no grade can be given.
pub fn grade_text(graded: &Graded) -> String {
    match (graded.best, graded.worst, graded.reason) {
        (_, _, Some(reason)) => format!("none, {}", no_grade(reason)),
        (best, Some(worst), None) if best == Some(worst) => name_of(worst),
        (_, Some(Grade::Consumer) | None, None) => "not known to be better than consumer".into(),
        (_, Some(worst), None) => format!("at least {}", name_of(worst)),
    }
}

/// How grades are defined, in words.
pub fn grade_scheme() -> String {
    let edges = Grade::ALL.into_iter().filter(|grade| *grade != Grade::Consumer).map(|grade| {
        let (bias, white) = grade.limits();
        format!("{} below {bias} deg/h and {white} deg/sqrt(h)", name_of(grade))
    });
    format!(
        "grade by B and by the sensor's own N, without aliasing, the worse one counting ({}, else consumer; no standard defines these)",
        edges.collect::<Vec<_>>().join(", ")
    )
}

/// The measured value, and that expected of a sensor at the figure, in a sentence.
pub fn sentence(sensor: Sensor, verdict: &FigureVerdict) -> String {
    let figure = &verdict.figure;
    let (unit, factor) = parameter_unit(sensor, figure.term);
    let number = |value: f64| digits(value * factor, 4);
    let Parameter { value, lower, upper, .. } = verdict.measured;
    let minimum = if figure.is_curve_minimum() { " as the minimum of the curve" } else { "" };
    let measured = match (value, lower, upper) {
        (Some(value), Some(lower), Some(upper)) => {
            format!("measured {} {unit} ({} to {}){minimum}", number(value), number(lower), number(upper))
        }
        (None, Some(lower), Some(upper)) => format!("measured {} to {} {unit}{minimum}", number(lower), number(upper)),
        (_, _, Some(upper)) => format!("measured: upper bound {} {unit}{minimum}", number(upper)),
        (_, Some(lower), None) => format!("measured: lower bound {} {unit}{minimum}", number(lower)),
        _ if verdict.verdict == Some(Verdict::NotComparable) => "not measurable in this stream".into(),
        _ => "unknown from this record".into(),
    };
    let mut expected = format!("data sheet: {}", figure.printed);
    if verdict.expected != figure.claim.ends() {
        let (low, high) = verdict.expected;
        expected = format!("expected in this stream: {} to {} {unit} ({expected})", number(low), number(high));
    }
    let interval = match verdict.ratio {
        Ratio { value: Some(_), lower: Some(lower), upper: Some(upper) } => format!(" ({lower:.2} to {upper:.2})"),
        _ => String::new(),
    };
    let times = match (verdict.verdict, ratio(&verdict.ratio)) {
        (None, Some(ratio)) => format!(": {ratio} x typical{interval}, which is no guarantee"),
        _ => String::new(),
    };
    let open = verdict.decided_by.map_or_else(String::new, |_| format!(": {} would decide", decided_by(verdict)));
    format!("{measured}; {expected}{times}{open}")
}

/// The name of a record among several, by its place from 0: `run 1` for the first.
pub fn run_name(number: usize) -> String {
    format!("run {}", number + 1)
}

/// The prefix of the figures of a record, by its place from 0: `run1-` for the first.
pub fn run_prefix(number: usize) -> String {
    format!("run{}-", number + 1)
}

/// Why there is no prediction of the next sensor or recording.
pub fn no_prediction(why: NoPrediction) -> &'static str {
    match why {
        NoPrediction::Bound => "a recording only bounds it: record longer",
        NoPrediction::Lengths => "the longest recording is more than twice as long as the shortest: take like lengths",
        NoPrediction::Streams => "the recordings differ in message or rate: take those of one stream",
        NoPrediction::Few => "it takes three sensors, or three recordings of one",
    }
}

/// That a sensor was moved, by the axis that shows it most.
pub(crate) fn motion_text(Motion { channel, std, limit, unit, .. }: &Motion) -> String {
    format!("sensor moved: standard deviation of {channel} {std:.3} {unit}, at rest below {limit}")
}

/// Why N is not compared if white noise aliases differently.
pub fn folding(ranking: &Ranking) -> String {
    let own: Vec<String> = (ranking.records.iter())
        .map(|ranked| match ranked.white_factor {
            Some(factor) => format!("{} {factor:.2}, {}", run_name(ranked.record), digits(ranked.own(), 4)),
            None => format!("{} unknown, {} undivided", run_name(ranked.record), digits(ranked.own(), 4)),
        })
        .collect();
    let percent = 100.0 * Onboard::UNCERTAINTY;
    let known = ranking.records.iter().filter(|ranked| ranked.white_factor.is_some()).count();
    let factor = match known {
        0 => "aliasing may raise it differently in them, by unknown factors".to_owned(),
        _ if known == ranking.records.len() => {
            format!("aliasing raises it differently in them, by a factor known to ±{percent:.0} %")
        }
        _ => format!(
            "aliasing may raise it differently in them, by a factor unknown in some, and else known to ±{percent:.0} %"
        ),
    };
    format!(
        "N is not compared: {factor}. The factor, and N over it, by which they are ordered: {}. Compare records of one rate and averaging window",
        own.join("; ")
    )
}
