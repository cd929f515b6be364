//! What a laboratory's report has of a noise measurement: the Allan deviation of one axis of each
//! sensor with the lines of the graphical slope method, what is read off them beside the fitted
//! parameters, and the grade of the gyroscope.

use crate::{
    figure::Figures,
    glossary::{Explanation, explain},
    graphical::{GRAPHICAL, not_read},
    names::{grade_scheme, grade_text, in_words, parameter_names},
    numbers::{NOTHING, digits, four_digits, trimmed, with_interval},
    units::{in_unit, laboratory_unit, pretty_unit},
};
use maud::{Markup, html};
use vn100_analysis::noise::{Deviation, Parameter, SlopeLine, Term};
use vn100_analysis::{ChannelResult, NoiseResult, RemedyWords, SENSORS, SourceResult, letter};

use crate::html::{
    caption::Captions,
    figures::grid,
    glance::{with_code, with_whole_units},
    parameters::{MOVED, long_taus_reason},
};

pub(crate) fn lab(record: &SourceResult, figures: &Figures, captions: &Captions) -> Markup {
    let axes: Vec<(&ChannelResult, &NoiseResult)> = SENSORS
        .into_iter()
        .filter_map(|(quantity, _)| record.of(quantity).into_iter().find(|channel| channel.name.ends_with("_y")))
        .filter_map(|channel| Some((channel, channel.noise.as_ref()?)))
        .filter(|(_, noise)| laboratory_unit(noise.sensor, Term::White).is_some())
        .collect();
    if axes.is_empty() || record.deviation() != Deviation::Allan {
        return html! { p.absent { "The graphical slope method reads the Allan deviation of gyroscopes and accelerometers, which this result has not." } };
    }
    let lines =
        axes.iter().flat_map(|(channel, noise)| GRAPHICAL.map(|(term, _)| (*channel, noise.classical.of(term))));
    let rests_on_few = lines.into_iter().any(|(channel, line)| line.is_ok_and(|line| rests_on_unknown(channel, line)));
    if record.motion.is_some() {
        return html! { p { (MOVED) } };
    }
    html! {
        p {
            "The graphical slope method [4], as laboratory reports give it: a line of slope −½ read at 1 s, of slope +½, behind the minimum, at 3 s, and the minimum over 0.664. \
             Its values have no interval, white noise and random walk alone leave a minimum that looks like B, and the last octaves wander: \
             they are for comparison with other reports. Use the fitted values beside them."
        }
        (grid(&figures.graphical, captions))
        (readings(&axes, record.confidence, &captions.table("Graphical readings beside the fitted parameters")))
        @if rests_on_few {
            p { "† Read off octaves of fewer than two equivalent degrees of freedom, which wander by chance: another record would give another value." }
        }
        @for (channel, noise) in &axes {
            @if let Some(reason) = long_taus_reason(noise.long_taus) { p { (channel.name) ": " (reason) } }
        }
        (grades(record))
        p { "What the parameters mean: " a href="#background" { "Background" } "." }
    }
}

fn readings(axes: &[(&ChannelResult, &NoiseResult)], confidence: f64, caption: &Markup) -> Markup {
    let level = format!("fitted ({} % interval)", trimmed(100.0 * confidence, 2));
    let columns = ["axis", "parameter", "unit", "graphical", &level, "rule", "line touches at τ (s)"];
    html! {
        div.scroll {
            table.lab {
                (caption)
                thead { tr { @for name in columns { th scope="col" { (name) } } } }
                @for (channel, noise) in axes {
                    tbody {
                        @for (place, (term, rule)) in GRAPHICAL.into_iter().enumerate() {
                            @if let Some((unit, factor)) = laboratory_unit(noise.sensor, term) {
                                @let names = parameter_names(noise.sensor, term);
                                tr {
                                    @if place == 0 { th scope="rowgroup" rowspan=(GRAPHICAL.len()) { (channel.name) } }
                                    th scope="row" { a href={ "#background-" (names.symbol) } { (names.name) " " (letter(term)) } }
                                    td.unit { (pretty_unit(unit)) }
                                    @match noise.classical.of(term) {
                                        Ok(line) => td { (four_digits(line.value * factor)) },
                                        Err(why) => td.words { (not_read(term, why)) },
                                    }
                                    td { (fitted(noise.parameter(term), factor)) }
                                    td.words { (rule) }
                                    td {
                                        @if let Ok(line) = noise.classical.of(term) {
                                            (digits(line.tau_s, 3)) @if rests_on_unknown(channel, line) { " †" }
                                        } @else { (NOTHING) }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Whether the line rests on an octave without an interval: one of its pair, or beside the minimum.
fn rests_on_unknown(channel: &ChannelResult, line: SlopeLine) -> bool {
    let is_near = |tau_s: f64| (0.45..2.2).contains(&(tau_s / line.tau_s));
    channel.octaves().iter().any(|point| is_near(point.tau_s) && !point.is_known())
}

fn fitted(parameter: Option<Parameter>, factor: f64) -> String {
    let Some(Parameter { status, value, lower, upper, .. }) = parameter else { return NOTHING.into() };
    match (value, lower, upper) {
        (Some(value), Some(lower), Some(upper)) => with_interval(value * factor, lower * factor, upper * factor),
        (Some(value), ..) => four_digits(value * factor),
        (None, _, Some(upper)) => format!("≤ {}", four_digits(upper * factor)),
        (None, ..) => in_words(status),
    }
}

/// Of each axis of the gyroscope, with the values that decide.
fn grades(record: &SourceResult) -> Markup {
    let graded = record.channels.iter().filter_map(|channel| {
        let (noise, graded) = (channel.noise.as_ref()?, channel.grade.as_ref()?);
        let why = match graded.reason {
            None => format!(" ({})", deciding(noise)),
            Some(_) => String::new(),
        };
        Some(format!("{}: {}{why}", channel.name, grade_text(graded)))
    });
    let graded: Vec<String> = graded.collect();
    html! {
        @if !graded.is_empty() {
            p { b { "Grade" } ". " (with_whole_units(&graded.join("; "))) "." }
            p { "The " (with_whole_units(&pretty_unit(&grade_scheme()))) "." }
        }
    }
}

/// B, and N without aliasing.
fn deciding(noise: &NoiseResult) -> String {
    let of = |name: &str, term, parameter: Option<Parameter>| {
        let (unit, factor) =
            in_unit(noise.sensor, term, laboratory_unit(noise.sensor, term).map_or("", |(unit, _)| unit));
        let value = match parameter {
            Some(Parameter { value: Some(value), .. }) => digits(value * factor, 3),
            Some(Parameter { upper: Some(upper), .. }) => format!("≤ {}", digits(upper * factor, 3)),
            _ => return format!("{name} not known"),
        };
        format!("{name} {value} {}", pretty_unit(unit))
    };
    let bias = of("B", Term::BiasInstability, noise.parameter(Term::BiasInstability));
    format!("{bias}, {}", of("the sensor's own N", Term::White, noise.unaliased_white()))
}

/// What the parameters and terms of a report mean, from the glossary.
pub(crate) fn background(words: RemedyWords) -> Markup {
    let entry = |code: &str| explain(code).into_iter().next();
    let entries: Vec<(&str, Explanation)> = ["N", "B", "K", "allan", "edf", "confidence interval", "aliasing"]
        .into_iter()
        .filter_map(|code| Some((code, entry(code)?)))
        .collect();
    html! {
        dl.background {
            @for (code, entry) in &entries {
                div id={ "background-" (code.replace(' ', "-")) } {
                    dt { b { (entry.code) } @if !entry.title.eq_ignore_ascii_case(entry.code) { ", " (with_minus(&entry.title)) } }
                    dd {
                        (with_code(&with_minus(&entry.meaning))) " " (with_code(entry.why)) " " (with_code(&entry.advice(words)))
                        @if !entry.source.is_empty() { " (" (entry.source) ")" }
                    }
                }
            }
        }
    }
}

/// The text with slopes such as -1/2 as figures write them.
fn with_minus(text: &str) -> String {
    text.replace(" -1", " −1")
}
