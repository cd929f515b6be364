//! What a laboratory's report has of a noise measurement: the Allan deviation of one axis of each sensor
//! with the readings of the graphical slope method, and the grade of the gyroscope.

use crate::{
    figure::Figures,
    glossary::{Explanation, explain},
    names::{grade_scheme, grade_text},
    numbers::digits,
    units::{in_unit, laboratory_unit, pretty_unit},
};
use maud::{Markup, html};
use vn100_analysis::noise::{Deviation, Parameter, Term};
use vn100_analysis::{ChannelResult, NoiseResult, RemedyWords, SENSORS, SourceResult};

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
    if axes.is_empty() || record.settings().deviation != Deviation::Allan {
        return html! { p.absent { "The graphical slope method reads the Allan deviation of gyroscopes and accelerometers, which this result has not." } };
    }
    if record.motion.is_some() {
        return html! { p { (MOVED) } };
    }
    html! {
        p {
            "The graphical slope method [4], as laboratory reports give it: a line of slope −½ read at 1 s, of slope +½, behind the minimum, at 3 s, and the minimum over 0.664. \
             Its values have no interval, white noise and random walk alone leave a minimum that looks like B, and the last octaves wander: \
             they are for comparison with other reports. Use the fitted values of the table above."
        }
        (grid(&figures.graphical, captions))
        @for (channel, noise) in &axes {
            @if let Some(reason) = long_taus_reason(noise.long_taus) { p { (channel.name) ": " (reason) } }
        }
        (grades(record))
        p { "What the parameters mean: " a href="#background" { "Background" } "." }
    }
}

/// Of each axis of the gyroscope, with the values that decide.
fn grades(record: &SourceResult) -> Markup {
    let graded = record.channels.iter().filter_map(|channel| {
        let (noise, graded) = (channel.noise.as_ref()?, channel.grade.as_ref()?);
        let why = if graded.reason.is_none() { format!(" ({})", deciding(noise)) } else { String::new() };
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

/// What the terms of a report mean; only for a VN-100 with what concerns its settings.
pub(crate) fn background(words: RemedyWords, is_of_vn100: bool) -> Markup {
    const OF_VN100: &str = "aliasing";
    let entry = |code: &str| explain(code).into_iter().next();
    let entries: Vec<(&str, Explanation)> = ["N", "B", "K", "allan", "edf", "confidence interval", OF_VN100]
        .into_iter()
        .filter(|code| is_of_vn100 || *code != OF_VN100)
        .filter_map(|code| Some((code, entry(code)?)))
        .collect();
    html! {
        dl.background {
            @for (code, entry) in &entries {
                div id={ "background-" (code.replace(' ', "-")) } {
                    dt { b { (entry.code) } @if !entry.title.eq_ignore_ascii_case(&entry.code) { ", " (with_minus(&entry.title)) } }
                    dd {
                        (with_code(&with_minus(&entry.meaning))) " " (with_code(entry.why))
                        @if is_of_vn100 { " " (with_code(&entry.advice(words))) }
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
