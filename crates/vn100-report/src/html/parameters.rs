//! The noise parameters, each sensor's axes side by side, in every unit in use; and beside the
//! figures of the data sheet.

use crate::html::glance;
use crate::{
    codes::word_of,
    names::{QUANTITIES, budget_rows, decided_by, motion_text, names_of, parameter_names, verdict_name},
    numbers::{
        NOTHING, digits, p_value,
        plain::{digits_trimmed, short},
        trimmed, with_interval,
    },
    units::{parameter_unit, pretty_unit},
};
use maud::{Markup, html};
use vn100_analysis::noise::{Convention, Parameter, Sensor, Sides, Term, conventions, temperature_conventions};
use vn100_analysis::{
    ChannelResult, DatasheetFigure, DecidedBy, FigureVerdict, LongTauValidity, NoiseResult, Remedy, RemedyWords,
    SENSORS, SourceResult, TemperatureResult, letter,
};

use crate::html::{caption::Captions, elements::table};

/// What stands for the noise parameters of a sensor that was moved.
pub(crate) const MOVED: &str = "Not given: the sensor was moved, and what the model fits is its motion. Record it at rest, or exclude the time in which it moved.";

type AxisNoise<'a> = (&'a ChannelResult, &'a NoiseResult);

pub(crate) fn parameters(record: &SourceResult, captions: &Captions) -> Markup {
    if record.motion.is_some() {
        return html! { p { (MOVED) } };
    }
    html! {
        @for (quantity, sensor) in SENSORS {
            @let channels = record.of(quantity);
            @let axes: Vec<AxisNoise<'_>> = channels.into_iter().filter_map(|channel| Some((channel, channel.noise.as_ref()?))).collect();
            @if let Some((_, first)) = axes.first() {
                @let caption = captions.table(&format!("{}: noise parameters in all units, and fit quality", names_of(quantity).title));
                (sensor_table(&axes, sensor, &caption))
                (budget(first, record.timing.rate_hz))
                @if let Some(reason) = long_taus_reason(first.long_taus) { p { (reason) } }
            }
        }
    }
}

fn sensor_table(axes: &[AxisNoise<'_>], sensor: Sensor, caption: &Markup) -> Markup {
    let given = |term: Term| axes.iter().any(|(_, noise)| noise.parameter(term).is_some());
    html! {
        div.scroll {
            table.parameters {
                (caption)
                thead {
                    tr {
                        th scope="col" { "parameter" } th scope="col" { "unit" }
                        @for (channel, _) in axes { th scope="col" { (channel.name) } }
                    }
                }
                @for term in Term::ALL {
                    @if given(term) {
                        tbody {
                            (in_units(axes, conventions(sensor, term), html! { (parameter_names(sensor, term).name) " " b { (letter(term)) } }, |noise| noise.parameter(term)))
                            @match term {
                                Term::White => {
                                    (row(axes, "sampling uncertainty", "%", sampling))
                                    (by_sample(axes, term, "standard deviation of a sample, N √rate"))
                                }
                                Term::Quantization => {}
                                Term::BiasInstability | Term::RateRandomWalk | Term::RateRamp => {
                                    @if term == Term::RateRandomWalk { (by_sample(axes, term, "step of the walk per sample, K/√rate")) }
                                    @if axes.iter().any(|(_, noise)| proved(noise, term).is_some()) {
                                        (row(axes, &format!("p without {}", letter(term)), "", |noise| proved(noise, term).map(p_value)))
                                    }
                                }
                            }
                        }
                        @if term == Term::BiasInstability {
                            tbody { (in_units(axes, conventions(sensor, term), html! { "minimum of the curve" }, NoiseResult::curve_minimum)) }
                        }
                    }
                }
                @if axes.iter().any(|(_, noise)| noise.temperature.is_some()) { (temperature(axes, sensor)) }
                tbody {
                    (row(axes, "fitted τ range", "s", |noise| noise.fit.map(|fit| format!("{} to {}", trimmed(fit.tau_min_s, 3), trimmed(fit.tau_max_s, 1)))))
                    (row(axes, "χ² / degrees of freedom", "", |noise| noise.fit.map(|fit| format!("{:.1} / {}", fit.chi2, fit.dof))))
                    (row(axes, "goodness of fit, p", "", |noise| noise.fit.map(|fit| format!("{:.2}", fit.p))))
                }
            }
        }
    }
}

/// N or K at the rate of the stream.
fn by_sample(axes: &[AxisNoise<'_>], term: Term, name: &str) -> Markup {
    let of = |noise: &NoiseResult| noise.parameter_in_units(term)?.discrete;
    let Some(first) = axes.iter().find_map(|(_, noise)| of(noise)) else { return html! {} };
    row(axes, &format!("{name} at {} Hz", short(first.rate_hz)), &pretty_unit(first.unit), |noise| {
        let found = of(noise)?;
        found.value.map(|value| digits(value, 3)).or_else(|| Some(format!("≤ {}", digits(found.upper?, 3))))
    })
}

/// The coefficient of the bias, its lag, and how much of the level is the temperature's.
fn temperature(axes: &[AxisNoise<'_>], sensor: Sensor) -> Markup {
    let found = |noise: &NoiseResult| noise.temperature.clone().filter(|found| found.reason.is_none());
    let of = |noise: &NoiseResult| noise.temperature.as_ref().map(|found| found.parameter);
    let why = axes.iter().find_map(|(_, noise)| noise.temperature.as_ref()?.why);
    let share = |found: TemperatureResult| found.largest_share.map(|share| format!("{:.0}", 100.0 * share));
    html! {
        tbody {
            (in_units(axes, temperature_conventions(sensor), html! { "temperature coefficient of the bias" }, of))
            @if axes.iter().any(|(_, noise)| found(noise).is_some()) {
                (row(axes, "lag behind the temperature", "s", |noise| found(noise).and_then(|found| lag(&found))))
                (row(axes, "p without the coefficient", "", |noise| found(noise)?.parameter.p.map(p_value)))
                (row(axes, "largest share of temperature in an octave of the level", "%", |noise| found(noise).and_then(share)))
            }
            @if let Some(why) = why {
                tr { th colspan=(axes.len() + 2) scope="rowgroup" { span { "No temperature coefficient: " (why.to_string()) } } }
            }
        }
    }
}

/// The most likely lag and its range, in seconds; `None` if the record does not show it: without a
/// significant coefficient, or if the range reaches the longest lag searched.
fn lag(found: &TemperatureResult) -> Option<String> {
    let TemperatureResult { proved: true, lag_open: false, lag_s, lag_lower_s, lag_upper_s, .. } = found else {
        return None;
    };
    let seconds = |lag_s: f64| short(if lag_s < 10.0 { (10.0 * lag_s).round() / 10.0 } else { lag_s.round() });
    Some(format!("{} ({} to {})", seconds((*lag_s)?), seconds((*lag_lower_s)?), seconds((*lag_upper_s)?)))
}

/// A parameter in every unit in use, in one alone if nothing is known of it.
fn in_units(
    axes: &[AxisNoise<'_>],
    units: &[Convention],
    name: Markup,
    of: impl Fn(&NoiseResult) -> Option<Parameter>,
) -> Markup {
    let says = axes.iter().any(|(_, noise)| of(noise).is_some_and(|found| found.value.or(found.upper).is_some()));
    html! {
        @for (index, unit) in units.iter().enumerate().take(if says { units.len() } else { 1 }) {
            tr.more[index > 0] {
                @if index == 0 { th scope="row" { (name) } } @else { td {} }
                td.unit { (pretty_unit(unit.unit)) @if unit.sides == Some(Sides::One) { " one-sided" } }
                @for (_, noise) in axes { td { (cell(of(noise), unit.factor, index == 0)) } }
            }
        }
    }
}

fn sampling(noise: &NoiseResult) -> Option<String> {
    let (below, above) = noise.budget()?.parts.sampling?;
    Some(format!("−{} +{}", digits(100.0 * below, 2), digits(100.0 * above, 2)))
}

/// Of an estimate, the probability that noise without the term would show as much.
fn proved(noise: &NoiseResult, term: Term) -> Option<f64> {
    noise.parameter(term).filter(|found| found.value.is_some())?.p
}

/// The uncertainty of N besides that of sampling, the same for all axes.
fn budget(noise: &NoiseResult, nominal_hz: Option<f64>) -> Markup {
    let rows = noise.budget().zip(nominal_hz).map(|(budget, nominal_hz)| budget_rows(&budget.parts, nominal_hz));
    html! {
        @if let Some(rows) = rows {
            p { "Further uncertainty of N:" }
            ul { @for (what, amount) in rows { li { (what) ": " (amount) "." } } }
        }
    }
}

fn row(axes: &[AxisNoise<'_>], name: &str, unit: &str, cell: impl Fn(&NoiseResult) -> Option<String>) -> Markup {
    html! {
        tr {
            th scope="row" { (name) }
            td.unit { (unit) }
            @for (_, noise) in axes { td { (cell(noise).unwrap_or_else(|| NOTHING.into())) } }
        }
    }
}

fn cell(parameter: Option<Parameter>, factor: f64, first: bool) -> String {
    let Some(parameter) = parameter else { return NOTHING.into() };
    match (parameter.value, parameter.lower, parameter.upper) {
        (Some(value), Some(lower), Some(upper)) if first => {
            with_interval(value * factor, lower * factor, upper * factor)
        }
        (Some(value), ..) => digits(value * factor, 4),
        (None, Some(lower), Some(upper)) => {
            format!("{} to {}", digits(lower * factor, 4), digits(upper * factor, 4))
        }
        (None, _, Some(upper)) => format!("≤ {}", digits(upper * factor, 4)),
        (None, ..) if first => word_of("status", parameter.status),
        (None, ..) => NOTHING.into(),
    }
}

pub(crate) fn long_taus_reason(long_taus: LongTauValidity) -> Option<&'static str> {
    match long_taus {
        LongTauValidity::Sensor => None,
        LongTauValidity::Compensated => Some(
            "B, K and R of the gyroscope are not measurable in this message: the attitude filter removes the bias. The minimum of the curve and the shoulder before \
             it belong to the filter.",
        ),
        LongTauValidity::LooksCompensated => Some(
            "B, K and R are not given: at long averaging times the curve falls below its own white noise, because a filter removes the bias.",
        ),
        LongTauValidity::Surroundings => {
            Some("Only the white noise is the sensor's: at long averaging times the ambient field dominates.")
        }
        LongTauValidity::Spoiled => {
            Some("N, B, K and R are not given, because the axis has one value for long, or a sample far out.")
        }
        LongTauValidity::Motion => Some("N, B, K and R are not given, because the sensor was moved."),
    }
}

pub(crate) fn verdicts(record: &SourceResult, words: RemedyWords, captions: &Captions) -> Markup {
    let Some(sheet) = &record.datasheet else {
        return html! {
            p { "None was compared: the built-in figures are for the VN-100's own messages; " (glance::with_code(&words(&Remedy::GiveDatasheet))) "." }
        };
    };
    if let Some(motion) = &record.motion {
        return html! {
            p { b { (sheet.name) } }
            p { "Nothing is compared: " (pretty_unit(&motion_text(motion))) "." }
        };
    }
    let rows: Vec<(&ChannelResult, &FigureVerdict)> = (QUANTITIES.into_iter())
        .flat_map(|quantity| record.of(quantity))
        .flat_map(|channel| channel.verdicts().iter().map(move |verdict| (channel, verdict)))
        .collect();
    let columns = ["channel", "parameter", "unit", "data sheet", "expected in this stream", "measured", "verdict"];
    let compared = html! {
        @for (channel, verdict) in &rows {
            @if let Some(noise) = &channel.noise {
                @let (unit, factor) = parameter_unit(noise.sensor, verdict.figure.term);
                tr {
                    th scope="row" { (channel.name) }
                    td { (letter(verdict.figure.term)) }
                    td.unit { (pretty_unit(unit)) }
                    td { (pretty_unit(&verdict.figure.printed)) @if let Some(same) = in_shown_unit(&verdict.figure, unit, factor) { br; (same) } }
                    td { (range(verdict.expected, factor)) }
                    td { (cell(Some(verdict.measured), factor, true)) }
                    td {
                        b { (verdict_name(verdict)) }
                        @if verdict.decided_by.is_some() { br; (decided_by(verdict)) " would decide" }
                    }
                }
            }
        }
    };
    html! {
        @if let Some(note) = &sheet.note { p { "Its figures are " (note) "." } }
        (table(&captions.table(&format!("Comparison with the data sheet: {}", sheet.name)), Some("verdicts"), &columns, &compared))
        p {
            "A limit passes if the whole confidence interval lies below the lowest that a sensor at the limit may read in this stream, and fails if it lies above the highest. "
            "Typical figures are no guarantee: the ratio says how the sensor compares. "
            @if rows.iter().any(|(_, verdict)| verdict.figure.is_of_unknown_sides) {
                "A sheet that does not say whether its densities are two-sided or one-sided has a range of both readings. "
            }
            @if rows.iter().any(|(_, verdict)| verdict.decided_by == Some(DecidedBy::Window)) {
                "The record does not contain the averaging window (" (glance::with_code(&words(&Remedy::GiveWindow))) "). "
            }
            "In-run bias is compared as data sheets define it: the minimum of the fitted curve."
        }
    }
}

/// The figure of a data sheet in the unit of the row, where it is printed in another.
fn in_shown_unit(figure: &DatasheetFigure, unit: &str, factor: f64) -> Option<String> {
    let unit = pretty_unit(unit);
    let is_same = pretty_unit(&figure.printed).split_whitespace().any(|word| word.trim_end_matches(',') == unit);
    let (low, high) = figure.claim.ends();
    let [low, high] = [low, high].map(|value| digits_trimmed(value * factor, 3));
    let number = if low == high { low } else { format!("{low} to {high}") };
    (!is_same).then(|| format!("= {number} {unit}"))
}

fn range((low, high): (f64, f64), factor: f64) -> String {
    if low == high {
        digits(low * factor, 3)
    } else {
        format!("{} to {}", digits(low * factor, 3), digits(high * factor, 3))
    }
}
