//! The noise parameters of each sensor, its axes side by side, one unit for each parameter, beside
//! the figures of the data sheet.

use vn100_analysis::noise::{Claim, Parameter, Sensor, Status, Term, Verdict};
use vn100_analysis::{ChannelNoise, DecidedBy, FigureVerdict, Onboard, Remedy, Setting, sensor_of};

use super::{AXES, Cells, Notes, ParameterRow, SensorTable, VerdictWord};
use crate::{
    codes::code_of_status,
    measured::Record,
    names::{ParameterNames, QUANTITIES, decided_by, names_of, parameter_names, parameter_unit, short_verdict},
    numbers::plain::{digits_trimmed, short},
    units::ChannelValues,
};

/// Half of an interval, relative, beyond which its ends are given.
const ENDS_BEYOND: f64 = 0.1;

/// A factor on N below which the sensor's own is not given apart.
const LEAST_FACTOR: f64 = 1.02;

/// Whether a term has a row: all that have an estimate, and those that everyone asks for.
fn is_shown(sensor: Sensor, term: Term, axes: &[Axis<'_>]) -> bool {
    let has =
        |test: fn(&Parameter) -> bool| axes.iter().any(|axis| axis.parameter(term).is_some_and(|found| test(&found)));
    match term {
        Term::White => true,
        Term::BiasInstability | Term::RateRandomWalk => sensor != Sensor::Magnetometer && has(|_| true),
        Term::Quantization | Term::RateRamp => has(|found| found.value.is_some()),
    }
}

struct Axis<'a> {
    channel: &'a ChannelValues,
    noise: &'a ChannelNoise,
    verdicts: &'a [FigureVerdict],
    onboard: Option<Onboard>,
}

impl Axis<'_> {
    fn parameter(&self, term: Term) -> Option<Parameter> {
        self.noise.parameter(term)
    }

    /// The factor of aliasing on N; `None` if there is none, or none is known.
    fn aliasing(&self) -> Option<f64> {
        let window = self.onboard?.window;
        let factor = window.white_factor();
        (factor > LEAST_FACTOR && !window.overlaps()).then_some(factor)
    }
}

pub(super) fn tables(record: &Record<'_>, notes: &mut Notes) -> Vec<SensorTable> {
    let assessed = record.channels.iter().zip(&record.measured.assessment.channels);
    let axes: Vec<Axis<'_>> = assessed
        .filter_map(|(channel, assessed)| {
            let noise = channel.noise.as_ref()?;
            Some(Axis { channel, noise, verdicts: record.verdicts(channel), onboard: assessed.onboard })
        })
        .collect();
    let of_quantity = |quantity| {
        axes.chunk_by(|a, b| a.channel.quantity == b.channel.quantity)
            .filter(move |group| group[0].channel.quantity == quantity)
    };
    let groups = QUANTITIES.into_iter().flat_map(of_quantity).flat_map(|group| group.chunks(AXES));
    groups.filter_map(|group| table(record, group, notes)).collect()
}

fn table(record: &Record<'_>, axes: &[Axis<'_>], notes: &mut Notes) -> Option<SensorTable> {
    let quantity = axes.first()?.channel.quantity;
    let sensor = sensor_of(quantity)?;
    let has_datasheet = axes.iter().any(|axis| !axis.verdicts.is_empty());
    let mut rows = Vec::new();
    let level = format!("{} % interval", short(100.0 * record.measured.assessment.confidence));
    for term in [Term::White, Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp, Term::Quantization] {
        if is_shown(sensor, term, axes) {
            rows.extend(parameter_rows(sensor, term, axes, &level));
        }
    }
    let mut places = Vec::new();
    if has_datasheet {
        places.extend(alias_note(axes, notes));
        places.extend(undecided_note(axes, notes));
    }
    let axis_name = |axis: &Axis<'_>| match axis.channel.name.rsplit_once('_') {
        Some((_, letter)) if letter.len() == 1 => letter.to_owned(),
        _ => axis.channel.name.clone(),
    };
    Some(SensorTable {
        title: names_of(quantity).title,
        axes: axes.iter().map(axis_name).collect(),
        has_datasheet,
        notes: places,
        rows,
    })
}

/// What would decide the first open verdict: one note, since the head of the table has room for two
/// marks.
fn undecided_note(axes: &[Axis<'_>], notes: &mut Notes) -> Option<usize> {
    let (axis, by) =
        axes.iter().find_map(|axis| Some((axis, axis.verdicts.iter().find_map(|found| found.decided_by)?)))?;
    let remedy = match (by, axis.onboard) {
        (DecidedBy::Rate, _) => Some(Remedy::GiveRate(None)),
        (DecidedBy::Window, Some(_)) => Some(Remedy::GiveWindow),
        (DecidedBy::Unaliased, Some(onboard)) => Some(Remedy::MeasureWith(Setting::Window(onboard.unaliased_window()))),
        (DecidedBy::LongerRecord, _) => Some(Remedy::Plan),
        _ => None,
    };
    let remedy = remedy.map_or_else(String::new, |remedy| format!("; {}", (notes.words)(&remedy)));
    Some(notes.place(format!("undecided: {} would decide{remedy}", decided_by(by))))
}

/// What the data sheet is multiplied by, and how that is avoided.
fn alias_note(axes: &[Axis<'_>], notes: &mut Notes) -> Option<usize> {
    let (onboard, factor) = axes.iter().find_map(|axis| axis.onboard.zip(axis.aliasing()))?;
    let window = onboard.unaliased_window();
    let is_imu = onboard.refresh_hz > Onboard::MAG_REFRESH_HZ;
    let words = notes.words;
    let unknown = (is_imu && !onboard.window_known()).then_some(Remedy::GiveWindow);
    let avoided = is_imu.then_some(Remedy::MeasureWith(Setting::Window(window)));
    let remedies: String = avoided.iter().chain(&unknown).map(|remedy| format!("; {}", words(remedy))).collect();
    let percent = 100.0 * Onboard::UNCERTAINTY;
    let aliasing = match onboard.window_known() {
        true => format!("{factor:.2} (±{percent:.0} %) by aliasing"),
        false => {
            let most = onboard.window.decimation.sqrt();
            format!("1 to {most:.2} by aliasing, {factor:.2} at the factory default of its window")
        }
    };
    Some(notes.place(format!("data sheet N x {aliasing}{remedies}")))
}

fn parameter_rows(sensor: Sensor, term: Term, axes: &[Axis<'_>], level: &str) -> Vec<ParameterRow> {
    let ParameterNames { name, symbol, .. } = parameter_names(sensor, term);
    let (unit, factor) = parameter_unit(sensor, term);
    let parameters: Vec<Option<Parameter>> = axes.iter().map(|axis| axis.parameter(term)).collect();
    let status = |parameter: &Option<Parameter>| parameter.map(|parameter| parameter.status);
    let first = parameters.first().and_then(status);
    let valueless =
        |parameter: &Option<Parameter>| parameter.is_none_or(|parameter| parameter.value.or(parameter.upper).is_none());
    let cells = match first {
        Some(of_all) if parameters.iter().all(|other| valueless(other) && status(other) == first) => {
            Cells::All(code_of_status(of_all).word)
        }
        _ => Cells::Axes(parameters.iter().map(|parameter| cell(*parameter, factor)).collect()),
    };
    let row = |label: &str, cells| ParameterRow { label: label.into(), unit: "", is_detail: true, cells, figure: None };
    let mut rows = vec![ParameterRow { label: format!("{name} {symbol}"), unit, is_detail: false, ..row("", cells) }];
    if parameters.iter().flatten().any(|parameter| parameter.value.is_some() && parameter.upper.is_some()) {
        let cells = parameters.iter().map(|parameter| interval(*parameter, factor)).collect();
        rows.push(row(level, Cells::Axes(cells)));
    }
    // the row that the data sheet is compared with
    let mut compared = 0;
    match term {
        Term::White if axes.iter().any(|axis| axis.aliasing().is_some()) => {
            let own = axes.iter().zip(&parameters).map(|(axis, parameter)| {
                let own = parameter.and_then(|parameter| parameter.value).zip(axis.aliasing());
                own.map_or("-".into(), |(value, aliasing)| number(value * factor / aliasing))
            });
            rows.push(row("sensor's own N, ±10 %", Cells::Axes(own.collect())));
        }
        Term::BiasInstability => {
            let minima: Vec<Option<Parameter>> = axes.iter().map(|axis| axis.noise.curve_minimum()).collect();
            if !minima.iter().all(valueless) {
                compared = rows.len();
                let cells = minima.iter().map(|minimum| cell(*minimum, factor));
                rows.push(ParameterRow { unit, ..row("minimum of the curve", Cells::Axes(cells.collect())) });
            }
        }
        _ => {}
    }
    let figures = figures(term, axes, factor);
    for (place, figure) in figures.into_iter().enumerate() {
        match rows.get_mut(compared + place) {
            Some(row) => row.figure = Some(figure),
            None => rows.push(ParameterRow { figure: Some(figure), ..row("", Cells::Axes(Vec::new())) }),
        }
    }
    rows
}

fn cell(parameter: Option<Parameter>, factor: f64) -> String {
    match parameter.map(|parameter| (parameter.value, parameter.upper, parameter.status)) {
        Some((Some(value), ..)) => number(value * factor),
        Some((None, Some(upper), _)) => {
            // a bound is worth two digits
            let bound = digits_trimmed(upper * factor, 2);
            if bound.len() < 5 { format!("≤ {bound}") } else { format!("≤{bound}") }
        }
        Some((None, None, Status::ModelRejected)) => "no fit".into(),
        _ => "-".into(),
    }
}

/// To three digits, in at most seven characters.
fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        magnitude if (1e-3..1e5).contains(&magnitude) => {
            let decimals = (2 - magnitude.log10().floor() as i32).max(0) as usize;
            format!("{value:.decimals$}")
        }
        _ => format!("{value:.1e}"),
    }
}

/// `±3.2 %`, or the ends of the interval if they are far apart.
fn interval(parameter: Option<Parameter>, factor: f64) -> String {
    let Some(Parameter { value: Some(value), lower: Some(lower), upper: Some(upper), .. }) = parameter else {
        return "-".into();
    };
    let half = (upper - value).max(value - lower) / value;
    if half <= ENDS_BEYOND {
        return format!("±{:.1} %", 100.0 * half);
    }
    let end = |value: f64| digits_trimmed(value * factor, 2);
    format!("{}-{}", end(lower), end(upper))
}

/// The figures of the data sheet for a term: in its unit, as a sensor at the figure shows in this
/// stream, with the worst verdict of the axes.
fn figures(term: Term, axes: &[Axis<'_>], factor: f64) -> Vec<(String, VerdictWord)> {
    let of = |axis: &Axis<'_>| axis.verdicts.iter().filter(|verdict| verdict.figure.term == term).count();
    let count = axes.iter().map(of).max().unwrap_or(0);
    (0..count)
        .filter_map(|place| {
            let verdicts: Vec<(usize, &FigureVerdict)> = (axes.iter().enumerate())
                .filter_map(|(number, axis)| {
                    let mut same = axis.verdicts.iter().filter(|verdict| verdict.figure.term == term);
                    Some((number, same.nth(place)?))
                })
                .collect();
            let (_, first) = verdicts.first()?;
            Some((claim(first, factor), word(&verdicts, axes)))
        })
        .enumerate()
        // what cannot be compared is said once
        .filter(|(place, (_, verdict))| *place == 0 || verdict.word != "n/a")
        .map(|(_, figure)| figure)
        .collect()
}

/// A limit as the lowest that it may be in this stream, and what is typical as a range.
fn claim(verdict: &FigureVerdict, factor: f64) -> String {
    let (from, to) = verdict.figure.claim.ends();
    let (low, high) = verdict.expected;
    // in the middle of what aliasing is known to
    let guard = (to * verdict.factor.1 / high).min(1.0);
    let smaller = if verdict.figure.is_of_unknown_sides { std::f64::consts::FRAC_1_SQRT_2 } else { 1.0 };
    let middle = (from * smaller * verdict.factor.0, high * guard);
    match verdict.figure.claim {
        Claim::Typical { .. } => format!("typ {}", range(middle.0 * factor, middle.1 * factor)),
        Claim::Limit(_) => format!("max {}", range(low.min(middle.0) * factor, middle.1 * factor)),
    }
}

/// Both ends to two digits, or one number if they are the same; with fewer digits of the lower
/// end if there is no room.
fn range(low: f64, high: f64) -> String {
    const ROOM: usize = 9;
    let [mut from, to] = [low, high].map(|value| digits_trimmed(value, 2));
    if from == to {
        return to;
    }
    if from.len() + to.len() + 1 > ROOM {
        let decimals = to.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let shorter = format!("{low:.decimals$}");
        let shorter = if decimals > 0 { shorter.trim_end_matches('0').trim_end_matches('.') } else { &shorter };
        if shorter != "0" && shorter != to {
            from = shorter.to_owned();
        }
    }
    format!("{from}-{to}")
}

/// The worst verdict, with the letters of its axes if others are better; of a typical figure the
/// largest ratio.
fn word(verdicts: &[(usize, &FigureVerdict)], axes: &[Axis<'_>]) -> VerdictWord {
    let rank = |verdict: Verdict| Verdict::ALL.iter().position(|other| *other == verdict).unwrap_or(usize::MAX);
    let judged = verdicts.iter().filter_map(|(_, judged)| judged.verdict);
    let Some(worst) = judged.min_by_key(|verdict| rank(*verdict)) else {
        let upper = |(_, judged): &&(usize, &FigureVerdict)| judged.ratio.upper.unwrap_or(0.0);
        let largest = verdicts.iter().max_by(|a, b| upper(a).total_cmp(&upper(b)));
        let word = largest.map_or_else(String::new, |(_, judged)| short_verdict(judged));
        return VerdictWord { word, is_failed: false };
    };
    let of_worst = verdicts.iter().filter(|(_, verdict)| verdict.verdict == Some(worst));
    let letters: Vec<&str> =
        of_worst.clone().filter_map(|(number, _)| axes[*number].channel.name.rsplit('_').next()).collect();
    let name = of_worst.clone().next().map_or_else(String::new, |(_, judged)| short_verdict(judged));
    let short = name.len() + 1 + letters.len();
    let word = match of_worst.count() == verdicts.len() || short > 12 || letters.iter().any(|letter| letter.len() != 1)
    {
        true => name,
        false => format!("{name} {}", letters.concat()),
    };
    VerdictWord { word, is_failed: worst == Verdict::Fail }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(value: f64, lower: f64, upper: f64) -> Option<Parameter> {
        let known = Parameter::without_value(Status::Estimated);
        Some(Parameter { value: Some(value), lower: Some(lower), upper: Some(upper), ..known })
    }

    #[test]
    fn an_interval_is_relative_while_narrow_and_else_given_by_its_ends() {
        assert_eq!(interval(parameter(2.0, 1.96, 2.05), 1.0), "±2.5 %");
        assert_eq!(interval(parameter(2.0, 1.81, 2.19), 1.0), "±9.5 %");
        assert_eq!(interval(parameter(3.7, 2.3, 5.6), 1.0), "2.3-5.6");
        assert_eq!(interval(parameter(2.0, 1.9, 2.21), 10.0), "19-22");
        assert_eq!(interval(None, 1.0), "-");
    }

    #[test]
    fn figures_of_a_data_sheet_fit_their_column() {
        for (low, high, text) in [
            (0.0991, 0.14, "0.1-0.14"),
            (0.221, 0.313, "0.22-0.31"),
            (5.0, 7.0, "5-7"),
            (10.0, 10.0, "10"),
            (0.42, 0.52, "0.42-0.52"),
        ] {
            assert_eq!(range(low, high), text);
        }
    }

    #[test]
    fn cells_are_seven_characters_at_most() {
        let bound = |upper| Some(Parameter { upper: Some(upper), ..Parameter::without_value(Status::Bounded) });
        for (cell, text) in [
            (cell(parameter(0.480_4, 0.4, 0.5), 1.0), "0.480"),
            (cell(parameter(12_345.6, 1.0, 2.0), 1.0), "12346"),
            (cell(parameter(0.001_234, 1.0, 2.0), 1.0), "0.00123"),
            (cell(parameter(0.000_123_4, 1.0, 2.0), 1.0), "1.2e-4"),
            (cell(bound(1.24), 1.0), "≤ 1.2"),
            (cell(bound(0.026), 1.0), "≤0.026"),
            (cell(bound(0.000_26), 1.0), "≤2.6e-4"),
            (cell(None, 1.0), "-"),
        ] {
            assert_eq!(cell, text);
            assert!(cell.chars().count() <= 7, "{cell}");
        }
    }
}
