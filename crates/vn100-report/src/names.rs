//! Names of what is measured and found, in words: the same in text, documents and reports.

use vn100_analysis::noise::{Claim, Deviation, Grade, Parameter, Sensor, Status, Term, Verdict, conventions};
use vn100_analysis::protocol::{Quantity, Tally};
use vn100_analysis::{ChannelNoise, FigureVerdict, LongTauValidity, Onboard, Ranking, StreamUnknown};

use crate::{measured::record_letter, numbers::plain::four_digits};

/// What is measured, in the order of results.
pub const QUANTITIES: [Quantity; 7] = [
    Quantity::AngularRate,
    Quantity::Acceleration,
    Quantity::MagneticField,
    Quantity::Angle,
    Quantity::Quaternion,
    Quantity::Temperature,
    Quantity::Pressure,
];

/// The names of a quantity.
#[derive(Debug, Clone, Copy)]
pub struct QuantityNames {
    /// The shortest word for what measures it.
    pub short: &'static str,
    /// Itself, in a sentence.
    pub quantity: &'static str,
    /// What measures it, as a title.
    pub title: &'static str,
}

/// The names of that quantity.
#[must_use]
pub fn names_of(quantity: Quantity) -> QuantityNames {
    let (short, quantity, title) = match quantity {
        Quantity::AngularRate => ("gyro", "angular rate", "Gyroscope"),
        Quantity::Acceleration => ("accel", "acceleration", "Accelerometer"),
        Quantity::MagneticField => ("mag", "magnetic field", "Magnetometer"),
        Quantity::Angle => ("angle", "orientation", "Orientation"),
        Quantity::Quaternion => ("quat", "orientation", "Orientation quaternion"),
        Quantity::Temperature => ("temp", "temperature", "Temperature"),
        Quantity::Pressure => ("baro", "pressure", "Pressure"),
    };
    QuantityNames { short, quantity, title }
}

/// What is plotted over averaging time.
#[must_use]
pub fn deviation_name(deviation: Deviation) -> &'static str {
    match deviation {
        Deviation::Allan => "Allan deviation",
        Deviation::Hadamard => "Hadamard deviation",
    }
}

/// The parameters of the noise, from short averaging times to long ones.
pub const TERMS: [(Term, &str); 5] = [
    (Term::Quantization, "quantisation"),
    (Term::White, "white noise"),
    (Term::BiasInstability, "bias instability"),
    (Term::RateRandomWalk, "rate random walk"),
    (Term::RateRamp, "rate ramp"),
];

/// A status of a parameter, in words.
#[must_use]
pub fn in_words(status: Status) -> &'static str {
    match status {
        Status::Estimated => "estimated",
        Status::Bounded => "at most",
        Status::NotObservable => "not observable",
        Status::NotMeasurable => "not measurable",
        Status::ModelRejected => "no model fits",
    }
}

/// How many, and of which kinds.
#[must_use]
pub fn rejected_lines(tally: &Tally) -> String {
    let bad = &tally.rejected;
    let kinds = [
        ("checksum", bad.checksum),
        ("unchecked", bad.unchecked),
        ("grammar", bad.grammar),
        ("range", bad.range),
        ("truncated", bad.truncated),
        ("too long", bad.too_long),
    ];
    let present: Vec<_> =
        kinds.iter().filter(|(_, count)| *count > 0).map(|(kind, count)| format!("{count} {kind}")).collect();
    if present.is_empty() { "0".into() } else { format!("{} ({})", bad.total(), present.join(", ")) }
}

/// How many questions the line brought back; nothing on a line that does not echo.
#[must_use]
pub fn echoes(count: u64) -> String {
    if count == 0 { String::new() } else { format!("{count} echoed questions, ") }
}

/// The verdict's name in results.
#[must_use]
pub fn verdict_name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "pass",
        Verdict::Fail => "fail",
        Verdict::Undecided => "undecided",
        Verdict::Consistent => "consistent",
        Verdict::NotComparable => "not-comparable",
    }
}

/// Best and worst grade a gyroscope may be of, or why none is given; `None` for other sensors.
pub(crate) fn grade(noise: &ChannelNoise) -> Option<Result<(Grade, Grade), &'static str>> {
    if noise.sensor != Sensor::Gyroscope {
        return None;
    }
    let bias_instability = noise.parameter(Term::BiasInstability);
    Some(match noise.long_taus {
        LongTauValidity::Sensor => {
            let range = bias_instability.as_ref().and_then(Grade::range);
            range.ok_or("the record says nothing of the bias instability")
        }
        LongTauValidity::Compensated | LongTauValidity::LooksCompensated | LongTauValidity::Surroundings => {
            Err("the stream does not carry the sensor's bias instability")
        }
        LongTauValidity::Motion => Err("the sensor was moved"),
    })
}

/// The grades a gyroscope may be of, or why that cannot be said; `None` for any other sensor.
#[must_use]
pub fn grade_text(noise: &ChannelNoise) -> Option<String> {
    Some(match grade(noise)? {
        Ok((best, worst)) if best == worst => grade_name(best).to_owned(),
        Ok((best, worst)) => format!("{} to {}", grade_name(best), grade_name(worst)),
        Err(reason) => format!("none, {reason}"),
    })
}

/// The name of a grade in results.
pub(crate) fn grade_name(grade: Grade) -> &'static str {
    match grade {
        Grade::Navigation => "navigation",
        Grade::Tactical => "tactical",
        Grade::Commercial => "commercial",
    }
}

/// What was measured and what a sensor at the figure reads in this stream.
#[must_use]
pub fn sentence(sensor: Sensor, verdict: &FigureVerdict) -> String {
    let figure = &verdict.figure;
    let shown = shown_in(sensor, figure.term);
    let number = |value: f64| four_digits(value * shown.1);
    let Parameter { value, lower, upper, .. } = verdict.measured;
    let minimum =
        if figure.is_minimum && figure.term == Term::BiasInstability { " as the minimum of the curve" } else { "" };
    let measured = match (value, lower, upper) {
        (Some(value), Some(lower), Some(upper)) => {
            format!("measured {} {} ({} to {}){minimum}", number(value), shown.0, number(lower), number(upper))
        }
        (None, Some(lower), Some(upper)) => {
            format!("measured {} to {} {}{minimum}", number(lower), number(upper), shown.0)
        }
        (_, _, Some(upper)) => format!("measured at most {} {}{minimum}", number(upper), shown.0),
        (_, Some(lower), None) => format!("measured at least {} {}{minimum}", number(lower), shown.0),
        _ if verdict.verdict == Verdict::NotComparable => "not in this stream".into(),
        _ => "not known from this record".into(),
    };
    let (low, high) = verdict.expected;
    let window = if verdict.unknown == Some(StreamUnknown::Window) { "the default window" } else { "window" };
    let expected = if verdict.stream.factor == 1.0 {
        format!("the data sheet says {}", figure.printed)
    } else {
        let (middle, half) = ((low + high) / 2.0 * shown.1, (high - low) / 2.0 * shown.1);
        let decimals = (-half.log10().floor()).clamp(0.0, 9.0) as usize;
        format!(
            "a sensor of {} reads {middle:.decimals$} ± {half:.decimals$} at this rate and {window}",
            figure.printed
        )
    };
    format!("{measured}; {expected}{}", why(verdict))
}

/// Why what speaks for a figure does not let it pass.
pub const WHY_CONSISTENT: &str = "nothing speaks against the figure, and nothing can pass or fail, for the averaging on board (register \
                                         85) or the rate is not known, or a line was removed";

fn why(verdict: &FigureVerdict) -> &'static str {
    match (verdict.verdict, verdict.figure.claim) {
        (Verdict::Fail, Claim::Typical { .. }) => ": above what is typical, which is no guarantee",
        (Verdict::Undecided, _) if verdict.measured.lower.is_some() => match (verdict.unknown, verdict.figure.term) {
            (Some(StreamUnknown::Window), Term::White) => ": more than the usual averaging on board explains",
            (Some(StreamUnknown::Window), _) => {
                ": above the figure, and cannot fail, for the averaging on board is not known"
            }
            (Some(StreamUnknown::Rate), _) => ": above the figure, and cannot fail, for the rate is assumed",
            (Some(StreamUnknown::LineRemoved), _) => ": above the figure, and cannot fail, for a line was removed",
            (None, _) => "",
        },
        _ => "",
    }
}

/// The unit people compare this figure in.
#[must_use]
pub fn shown_in(sensor: Sensor, term: Term) -> (&'static str, f64) {
    let unit = match (sensor, term) {
        (Sensor::Gyroscope, Term::White) => "deg/sqrt(h)",
        (Sensor::Gyroscope, Term::BiasInstability) => "deg/h",
        (Sensor::Gyroscope, Term::RateRandomWalk) => "deg/h^1.5",
        (Sensor::Accelerometer, Term::White) => "mg/sqrt(Hz)",
        (Sensor::Accelerometer, Term::BiasInstability) => "mg",
        _ => "",
    };
    in_unit(sensor, term, unit)
}

/// That unit and its factor; the SI unit where the parameter has no such unit.
pub(crate) fn in_unit(sensor: Sensor, term: Term, unit: &str) -> (&'static str, f64) {
    let all = conventions(sensor, term);
    let convention = all.iter().find(|convention| convention.unit == unit).or(all.first());
    convention.map_or(("", 1.0), |convention| (convention.unit, convention.factor))
}

/// Why none is the quietest where white noise does not fold alike.
#[must_use]
pub fn folding(ranking: &Ranking) -> String {
    let own: Vec<String> = (ranking.records.iter())
        .map(|ranked| match ranked.white_factor {
            Some(factor) => format!("{} {factor:.2}, {}", record_letter(ranked.record), four_digits(ranked.own())),
            None => format!("{} not known", record_letter(ranked.record)),
        })
        .collect();
    format!(
        "none is named the quietest: white noise folds differently in them, by a factor known to ±{:.0} %. The factor, and N over it, by which \
         they are ordered: {}. Compare records of one rate and averaging window",
        100.0 * Onboard::UNCERTAINTY,
        own.join("; ")
    )
}
