//! The parts of one record, the same in its report and on its live page.

use maud::{Markup, PreEscaped, html};
use vn100_analysis::{NoiseResult, RemedyWords, SENSORS, SourceResult, noise::Sensor};

use crate::html::{
    caption::Captions, elements::text_of, facts, figures, filters, glance, lab, options::PageOptions, parameters,
    statistics,
};
use crate::{
    evaluation::is_of_vn100,
    figure::Figures,
    goals::warm_up,
    summary::Summary,
    warnings::{details, headline},
};

/// The content of one element of a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PagePart {
    /// The `id` of the element.
    pub id: &'static str,
    /// The content of the element; empty if there is nothing to say.
    pub html: Box<str>,
}

impl PagePart {
    pub(super) fn new(id: &'static str, content: Markup) -> Self {
        Self { id, html: text_of(content).into() }
    }
}

/// What the sections of a record are made of.
struct Parts<'a> {
    record: &'a SourceResult,
    figures: &'a Figures,
    summary: Summary,
    options: PageOptions<'a>,
    captions: &'a Captions,
}

/// A part with a heading.
struct Section {
    id: &'static str,
    heading: &'static str,
    /// Whether it says something while the record is measured.
    is_live: bool,
    content: fn(&Parts<'_>) -> Markup,
}

const fn section(id: &'static str, heading: &'static str, is_live: bool, content: fn(&Parts<'_>) -> Markup) -> Section {
    Section { id, heading, is_live, content }
}

/// In the order of a page.
const SECTIONS: [Section; 13] = [
    section("allan", "Allan deviation", true, |of| figures::together(of.record, of.figures, of.captions)),
    section("parameters", "Noise parameters", true, |of| {
        html! {
            (glance::parameters(&of.summary, of.captions))
            details { summary { "All units and fit quality" } (parameters::parameters(of.record, of.captions)) }
        }
    }),
    section("cautions", "Cautions", true, |of| warnings(of.record, of.options.words)),
    section("signal", "Last minutes", true, |of| {
        html! { @if !of.figures.recent.is_empty() { (figures::grid(&of.figures.recent, of.captions)) } }
    }),
    section("datasheet", "Comparison with the data sheet", true, |of| {
        parameters::verdicts(of.record, of.options.words, of.captions)
    }),
    section("axes", "Allan deviation of each axis", true, |of| figures::axes(of.record, of.figures, of.captions)),
    section("lab", "Lab report", false, |of| lab::lab(of.record, of.figures, of.captions)),
    section("statistics", "Descriptive statistics", true, |of| {
        statistics::statistics(of.record, of.figures, of.options.words, of.captions)
    }),
    section("drift", "Drift while coasting", false, |of| filters::drift(of.record, of.figures, of.captions)),
    section("spectrum", "Spectrum and deviation per segment", true, |of| figures::spectrum(of.figures, of.captions)),
    section("advice", "What to do, and what was not tested", false, |of| advice(of.record, &of.summary)),
    section("filters", "Values for filters and simulators", false, |of| filters::filters(of.record, of.options.span_s)),
    section("record", "Record and method", true, |of| facts::facts(of.record, of.options, of.captions)),
];

/// What is seen first, in columns where there is room.
const TOP: [&[&str]; 3] = [&["now", "identity", "statuses"], &["allan"], &["parameters"]];

/// The parts of a record. A record under way has those that say something then, and each of them.
pub(super) fn parts(
    record: &SourceResult,
    figures: &Figures,
    options: PageOptions<'_>,
    captions: &Captions,
    is_live: bool,
) -> Vec<PagePart> {
    let of = Parts { record, figures, summary: Summary::new(record, options.words), options, captions };
    let is_empty = record.timing.samples == 0;
    let mut parts = vec![
        PagePart::new("identity", glance::identity(record)),
        PagePart::new("statuses", html! { @if !is_empty { (glance::statuses(&of.summary)) } }),
    ];
    for section in SECTIONS.iter().filter(|section| section.is_live || !is_live) {
        let content = match section.id {
            "allan" if is_empty => nothing(record, is_live),
            "record" | "cautions" => (section.content)(&of),
            _ if is_empty => html! {},
            _ => (section.content)(&of),
        };
        let content = content.into_string();
        let content = html! { @if !content.is_empty() { h2 { (section.heading) } (PreEscaped(content)) } };
        parts.push(PagePart::new(section.id, content));
    }
    parts
}

/// In place of the curves of a record without a sample.
fn nothing(record: &SourceResult, is_live: bool) -> Markup {
    match warm_up(&record.timing) {
        _ if !is_live => {
            html! { p.warning.problem { (record.source.error.as_deref().unwrap_or("No valid sample in this capture.")) } p { "There are no results. What is known of the capture follows." } }
        }
        Some(_) => html! { p.absent { "The warm-up is excluded: the curves begin after it." } },
        None => html! { p.absent { "No sample yet." } },
    }
}

/// The parts of a record in their places; `prefix` makes their ids unique. A live page has a place for
/// each part that may come.
pub(super) fn arranged<'a>(part: impl Fn(&str) -> Option<&'a str>, prefix: &str) -> Markup {
    let place = |id: &str| html! { @if let Some(content) = part(id) { section id={ (prefix) (id) } { (PreEscaped(content)) } } };
    let has_content = |section: &&Section| part(section.id).is_some_and(|content| !content.is_empty());
    html! {
        div.top { @for column in TOP { div { @for id in column { (place(id)) } } } }
        nav aria-label={ "Sections" @if !prefix.is_empty() { " of " (prefix.trim_end_matches('-')) } } {
            @for section in SECTIONS.iter().filter(has_content) { a href={ "#" (prefix) (section.id) } { (section.heading) } " " }
        }
        @for section in SECTIONS.iter().filter(|section| !TOP.concat().contains(&section.id)) { (place(section.id)) }
    }
}

/// Whether a live page has a place for this part.
pub(super) fn is_live(id: &str) -> bool {
    ["now", "identity", "statuses"].contains(&id) || SECTIONS.iter().any(|section| section.is_live && section.id == id)
}

/// The notes of the summary, and the limits of any record at rest.
fn advice(record: &SourceResult, summary: &Summary) -> Markup {
    let inertial = || SENSORS.iter().filter(|(_, sensor)| *sensor != Sensor::Magnetometer);
    let mut axes = inertial().flat_map(|(quantity, _)| record.of(*quantity)).filter_map(|axis| axis.noise.as_ref());
    let has_coefficient = |noise: &NoiseResult| noise.temperature.as_ref().is_some_and(|found| found.reason.is_none());
    let temperature = if axes.all(has_coefficient) { "" } else { "temperature, " };
    html! {
        @if !summary.notes.is_empty() { ul { @for note in &summary.notes { li { (glance::with_code(note)) } } } }
        p {
            "One record at rest does not show bias from turn-on to turn-on, scale factor, misalignment, or the sensitivity to " (temperature)
            "supply and acceleration. Slow motion that looks like noise is not detected. "
            @if record.source.device.is_none() && is_of_vn100(record) {
                "The record does not hold the registers of the sensor: its averaging window, calibration and filter modes are unknown. "
            }
            @if record.source.meta.is_none() { "Place, mounting, ambient temperature and supply were not recorded." }
        }
    }
}

fn warnings(record: &SourceResult, words: RemedyWords) -> Markup {
    html! {
        @if record.warnings.is_empty() && record.timing.samples > 0 { p { "None." } }
        @for warning in &record.warnings {
            @let class = glance::severity_class(Some(warning.severity));
            details class={ "warning " (class) } {
                summary { b class={ "badge " (class) } { (warning.severity.name()) } " " (headline(warning)) " " code { (warning.kind.name()) } }
                p { (glance::with_code(&details(warning, words))) }
            }
        }
    }
}
