//! The noise parameters of each sensor, its axes side by side, one unit for each parameter, beside
//! the figures of the data sheet and the readings of the graphical slope method.

use vn100_analysis::noise::{Claim, Parameter, Sensor, Status, Term, Verdict};
use vn100_analysis::{
    ChannelResult, DecidedBy, FigureVerdict, LongTauValidity, NoiseResult, Onboard, Remedy, Setting, SourceResult,
    letter, sensor_of,
};

use super::{AXES, Notes, ParameterRow, SensorTable, VerdictWord};
use crate::{
    codes::word_of,
    graphical::GRAPHICAL,
    names::{ParameterNames, QUANTITIES, decided_by, names_of, parameter_names, short_verdict},
    numbers::plain::digits_trimmed,
    units::parameter_unit,
};

/// A factor on N below which the sensor's own is not given apart.
const LEAST_FACTOR: f64 = 1.02;

/// Whether a term has a row: all that have an estimate, and those that everyone asks for.
fn is_shown(sensor: Sensor, term: Term, axes: &[Axis<'_>]) -> bool {
    let has = |test: fn(&Parameter) -> bool| {
        axes.iter().any(|axis| axis.noise.parameter(term).is_some_and(|found| test(&found)))
    };
    match term {
        Term::White => true,
        Term::BiasInstability | Term::RateRandomWalk => sensor != Sensor::Magnetometer && has(|_| true),
        Term::Quantization | Term::RateRamp => has(|found| found.value.is_some()),
    }
}

struct Axis<'a> {
    channel: &'a ChannelResult,
    noise: &'a NoiseResult,
}

impl Axis<'_> {
    /// The factor of aliasing on N; `None` if there is none, or none is known.
    fn aliasing(&self) -> Option<f64> {
        let window = self.channel.onboard?.window;
        let factor = window.white_factor();
        (factor > LEAST_FACTOR && !window.overlaps()).then_some(factor)
    }
}

pub(super) fn tables(result: &SourceResult, notes: &mut Notes) -> Vec<SensorTable> {
    let axes: Vec<Axis<'_>> =
        (result.channels.iter()).filter_map(|channel| Some(Axis { channel, noise: channel.noise.as_ref()? })).collect();
    let of_quantity = |quantity| {
        axes.chunk_by(|a, b| a.channel.quantity == b.channel.quantity)
            .filter(move |group| group[0].channel.quantity == quantity)
    };
    let groups = QUANTITIES.into_iter().flat_map(of_quantity).flat_map(|group| group.chunks(AXES));
    groups.filter_map(|group| table(group, notes)).collect()
}

fn table(axes: &[Axis<'_>], notes: &mut Notes) -> Option<SensorTable> {
    let quantity = axes.first()?.channel.quantity;
    let sensor = sensor_of(quantity)?;
    let has_datasheet = axes.iter().any(|axis| !axis.channel.verdicts().is_empty());
    // N, B and K first
    let terms = Term::ALL.into_iter().skip(1).chain([Term::Quantization]).filter(|term| is_shown(sensor, *term, axes));
    let rows = terms.flat_map(|term| parameter_rows(sensor, term, axes)).collect();
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

/// What would decide the first open verdict; there is room for one note.
fn undecided_note(axes: &[Axis<'_>], notes: &mut Notes) -> Option<usize> {
    let is_open = |found: &&FigureVerdict| found.decided_by.is_some();
    let (axis, open) = axes.iter().find_map(|axis| Some((axis, axis.channel.verdicts().iter().find(is_open)?)))?;
    let remedy = match (open.decided_by?, axis.channel.onboard) {
        (DecidedBy::Rate, _) => Some(Remedy::GiveRate(None)),
        (DecidedBy::Window, Some(_)) => Some(Remedy::GiveWindow),
        (DecidedBy::Unaliased, Some(onboard)) => Some(Remedy::MeasureWith(Setting::Window(onboard.unaliased_window()))),
        (DecidedBy::LongerRecord, _) => Some(Remedy::Plan),
        _ => None,
    };
    let remedy = remedy.map_or_else(String::new, |remedy| format!("; {}", (notes.words)(&remedy)));
    Some(notes.place(format!("undecided: {} would decide{remedy}", decided_by(open))))
}

/// What the data sheet is multiplied by, and how that is avoided.
fn alias_note(axes: &[Axis<'_>], notes: &mut Notes) -> Option<usize> {
    let (onboard, factor) = axes.iter().find_map(|axis| axis.channel.onboard.zip(axis.aliasing()))?;
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
            format!(
                "1 to {most:.2} by aliasing, a range because the averaging window is unknown ({factor:.2} at its factory default)"
            )
        }
    };
    Some(notes.place(format!("data sheet N x {aliasing}{remedies}")))
}

fn parameter_rows(sensor: Sensor, term: Term, axes: &[Axis<'_>]) -> Vec<ParameterRow> {
    let ParameterNames { name, label, .. } = parameter_names(sensor, term);
    let (unit, factor) = parameter_unit(sensor, term);
    let detail = |label: &str, short_label, cells| ParameterRow {
        label: label.into(),
        short_label,
        unit: "",
        is_detail: true,
        cells,
        figure: None,
    };
    let of = |parameter: &dyn Fn(&NoiseResult) -> Option<Parameter>| -> Vec<Option<Parameter>> {
        axes.iter().map(|axis| parameter(axis.noise)).collect()
    };
    let cells =
        |parameters: &[Option<Parameter>]| parameters.iter().map(|found| cell(*found, factor)).collect::<Vec<_>>();
    let is_known = |found: &Option<Parameter>| found.is_some_and(|found| found.value.or(found.upper).is_some());
    let parameters = of(&|noise| noise.parameter(term));
    let status = |found: &Option<Parameter>| found.map(|found| found.status);
    let first = parameters.first().and_then(status);
    let value_cells = match first {
        Some(of_all) if parameters.iter().all(|other| !is_known(other) && status(other) == first) => {
            vec![word_of("status", of_all)]
        }
        _ => cells(&parameters),
    };
    let value = detail(&format!("{name} {}", letter(term)), label, value_cells);
    let mut rows = vec![ParameterRow { unit, is_detail: false, ..value }];
    // the row that the data sheet is compared with
    let mut compared = 0;
    if term == Term::White && axes.iter().any(|axis| axis.aliasing().is_some()) {
        rows.push(detail("sensor's own N", "  own N", cells(&of(&NoiseResult::unaliased_white))));
    }
    let minima = of(&NoiseResult::curve_minimum);
    if term == Term::BiasInstability && minima.iter().any(is_known) {
        compared = rows.len();
        rows.push(detail("minimum of the curve", "  curve minimum", cells(&minima)));
    }
    if let Some((_, rule, short_rule)) = GRAPHICAL.iter().find(|(graphical, ..)| *graphical == term) {
        let is_of_sensor = |axis: &Axis<'_>| term == Term::White || axis.noise.long_taus == LongTauValidity::Sensor;
        let read = |axis: &Axis<'_>| axis.noise.classical.reading(term)?.value.filter(|_| is_of_sensor(axis));
        if axes.iter().any(|axis| read(axis).is_some()) {
            let cell = |axis: &Axis<'_>| read(axis).map_or("-".into(), |value| number(value * factor));
            rows.push(detail(&format!("graphical: {rule}"), short_rule, axes.iter().map(cell).collect()));
        }
    }
    // each further figure has a row without values: those of the next row are not compared with it
    let mut figures = figures(term, axes, factor).into_iter();
    rows[compared].figure = figures.next();
    let further = figures.map(|figure| ParameterRow {
        figure: Some(figure),
        ..detail("another figure", "  another figure", Vec::new())
    });
    rows.splice(compared + 1..compared + 1, further);
    rows
}

/// A value with the larger half of its interval, `0.350 ±3%`; a bound, `≤ 0.16`.
fn cell(parameter: Option<Parameter>, factor: f64) -> String {
    let Some(Parameter { status, value, lower, upper, .. }) = parameter else { return "-".into() };
    match (value, lower, upper) {
        (Some(value), Some(lower), Some(upper)) => {
            let percent = 100.0 * ((upper - value).max(value - lower) / value).abs();
            let decimals = usize::from(percent < 0.95);
            if percent < 99.5 {
                format!("{} ±{percent:.decimals$}%", number(value * factor))
            } else {
                let end = |value: f64| digits_trimmed(value * factor, 2);
                format!("{}-{}", end(lower), end(upper))
            }
        }
        (Some(value), ..) => number(value * factor),
        // a bound is worth two digits
        (None, _, Some(upper)) => format!("≤ {}", digits_trimmed(upper * factor, 2)),
        (None, ..) if status == Status::ModelRejected => "no fit".into(),
        (None, ..) => "-".into(),
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

/// The figures of the data sheet for a term, as they show in this stream, with the worst verdict.
fn figures(term: Term, axes: &[Axis<'_>], factor: f64) -> Vec<(String, VerdictWord)> {
    let of = |axis: &Axis<'_>| axis.channel.verdicts().iter().filter(|verdict| verdict.figure.term == term).count();
    let count = axes.iter().map(of).max().unwrap_or(0);
    (0..count)
        .filter_map(|place| {
            let verdicts: Vec<(usize, &FigureVerdict)> = (axes.iter().enumerate())
                .filter_map(|(number, axis)| {
                    let mut same = axis.channel.verdicts().iter().filter(|verdict| verdict.figure.term == term);
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

/// The worst verdict, with the letters of its axes; of a typical figure the largest ratio.
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

    #[test]
    fn cells_have_room_in_their_column() {
        for (found, text) in [
            (Parameter::estimated(2.0, 1.96, 2.05), "2.00 ±2%"),
            (Parameter::estimated(2.0, 1.99, 2.01), "2.00 ±0.5%"),
            (Parameter::estimated(0.085, 0.081, 0.09), "0.0850 ±6%"),
            (Parameter::estimated(3.7, 2.3, 5.6), "3.70 ±51%"),
            (Parameter::estimated(2.0, 0.5, 9.0), "0.5-9"),
            (Parameter::bounded(1.24), "≤ 1.2"),
            (Parameter::bounded(0.000_26), "≤ 2.6e-4"),
            (Parameter::without_value(Status::ModelRejected), "no fit"),
            (Parameter::without_value(Status::NotObservable), "-"),
        ] {
            let cell = cell(Some(found), 1.0);
            assert_eq!(cell, text);
            assert!(cell.chars().count() <= 11, "{cell}");
        }
        assert_eq!(cell(None, 1.0), "-");
        assert_eq!([12_345.6, 0.001_234, 0.000_123_4].map(number), ["12346", "0.00123", "1.2e-4"]);
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
}
