//! The live page: the parts of a report that make sense during a measurement, each drawn
//! separately, and the page around them.

use std::{fmt::Write, time::Duration};

use crate::warnings::headline;
use crate::{
    figure::{Figure, Figures, last_minutes},
    goals::{Goals, warm_up},
    health::{FaultKind, line_load, link_word, next_octave, playback_word, rate_from_word, up_word},
    names::{damaged_packets, missing_text, outages, pending_text, rejected_lines},
    numbers::{
        plain::{counted, digits_trimmed, grouped, ppm, tau, time},
        with_powers,
    },
    summary::{Summary, mean_temperature},
};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use vn100_analysis::{ChannelResult, LinkStatus, RemedyWords, Severity, SourceResult};

use crate::html::{
    caption::Captions,
    elements::{FIGURES_SCRIPT, STYLE, text_of},
    facts, figures, glance, parameters,
    report::warnings,
    statistics,
};

/// Columns of the last minutes: a narrow screen has no more.
const COLUMNS: usize = 121;

/// The content of one element of the page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PagePart {
    /// The `id` of the element.
    pub id: String,
    /// The content of the element, in one line.
    pub html: Box<str>,
    /// The prefix of the source to whose details the part belongs, which a page shows when they are
    /// opened; `None` for a part that is always shown, and for a single source.
    pub detail_of: Option<Box<str>>,
}

/// What is shown of each of several sources before its details are asked for.
const BRIEF: [&str; 4] = ["now", "identity", "verdicts", "cautions"];

impl PagePart {
    fn new(prefix: &str, name: &str, content: Markup) -> Self {
        let html = text_of(content);
        // between words a new line is a space, and elsewhere there is none
        let html = if html.contains(['\n', '\r']) { html.replace(['\n', '\r'], " ") } else { html };
        let is_detail = !prefix.is_empty() && !BRIEF.contains(&name);
        Self { id: format!("{prefix}{name}"), html: html.into(), detail_of: is_detail.then(|| prefix.into()) }
    }
}

/// One source at one moment.
#[derive(Debug, Clone, Copy)]
pub struct PageSource<'a> {
    /// The result so far.
    pub result: &'a SourceResult,
    /// What its measurement ends by.
    pub goals: &'a Goals,
    /// How far the measurement has come.
    pub stage: LiveStage<'a>,
    /// Time by the clock since the command began.
    pub elapsed: Duration,
    /// How long no sample has come; `None` if that is too short to mention.
    pub silent: Option<Duration>,
}

/// How far a measurement has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LiveStage<'a> {
    /// The source is being opened.
    Preparing,
    /// Samples are measured.
    Measuring,
    /// The measurement is over; why its result is not complete, `None` if it is.
    Ended(Option<&'a str>),
}

/// The style sheet, the same for all pages of one program.
#[must_use]
pub fn live_style() -> String {
    format!("{STYLE}{}", include_str!("../../assets/live.css"))
}

/// The script that keeps the parts up to date, and makes the figures interactive.
#[must_use]
pub fn live_script() -> String {
    format!("{FIGURES_SCRIPT}{}", include_str!("../../assets/live.js"))
}

/// What one word says of a source, and how grave it is.
fn state(source: &PageSource<'_>) -> (String, Option<Severity>) {
    let facts = &source.result.source;
    match (source.stage, &facts.link, facts.playback) {
        (LiveStage::Preparing, ..) => ("preparing".into(), Some(Severity::Note)),
        (LiveStage::Ended(Some(_)), ..) => ("ENDED".into(), Some(Severity::Problem)),
        (LiveStage::Ended(None), ..) => ("ended".into(), Some(Severity::Note)),
        (LiveStage::Measuring, Some(link), _) => {
            if link.status == LinkStatus::Connected {
                (up_word(link.baud), None)
            } else {
                (link_word(link), Some(Severity::Problem))
            }
        }
        (LiveStage::Measuring, None, playback) => {
            let playback = playback.unwrap_or_default();
            (playback_word(playback).into(), (playback.paused || playback.at_end).then_some(Severity::Note))
        }
    }
}

fn badge(source: &PageSource<'_>) -> Markup {
    let (word, severity) = state(source);
    html! { b class={ "badge " (glance::severity_class(severity)) } { (word) } }
}

/// The part that changes with every sample: the link, samples and losses, and what is to come.
#[must_use]
pub fn now_part(source: &PageSource<'_>, prefix: &str) -> PagePart {
    let SourceResult { source: facts, timing, link: counts, .. } = source.result;
    let is_over = source.stage != LiveStage::Measuring || facts.playback.is_some_and(|playback| playback.at_end);
    let intervals = timing.arrivals.map(|times| {
        let ms = |us: u64| digits_trimmed(us as f64 / 1e3, 3);
        format!("median {}, 99 % within {}, longest {} ms", ms(times.p50_us), ms(times.p99_us), ms(times.max_us))
    });
    let measured = timing.measured_hz.map(|hz| {
        let off = |offset| format!(" ({})", ppm(offset));
        format!("{hz:.3} Hz{}", timing.offset_ppm.map_or_else(String::new, off))
    });
    let dropped = match timing.gaps {
        0 => missing_text(timing),
        gaps => format!("{} in {}", missing_text(timing), counted(gaps, "gap")),
    } + &pending_text(timing);
    let recorder =
        facts.recorder.as_ref().map(|recorder| format!("{}, {} bytes", recorder.path, grouped(recorder.bytes)));
    let progress = facts.playback.and_then(|playback| {
        let part = playback.samples as f64 / playback.total.filter(|total| *total > 0)? as f64;
        Some(format!("{:.0} %", 100.0 * part))
    });
    let next = next_octave(source.result).filter(|_| !is_over);
    let rate = timing.rate_hz.zip(timing.rate_from);
    let rate = rate.map(|(hz, from)| format!("{} Hz {}", digits_trimmed(hz, 6), rate_from_word(from)));
    let rows = [
        ("Samples", Some(format!("{} in {}", grouped(timing.samples), time(timing.duration_s)))),
        ("Rate", rate.filter(|_| timing.samples > 0)),
        ("Measured rate", measured),
        ("Intervals", intervals),
        ("Line load", line_load(source.result).map(|load| format!("{:.0} %", 100.0 * load))),
        ("Rejected", Some(rejected_lines(counts) + &damaged_packets(counts))),
        ("Dropped samples", Some(dropped)),
        ("Excluded samples", (timing.excluded > 0).then(|| grouped(timing.excluded))),
        ("Link", outages(counts)),
        ("Recording", recorder),
        ("Replayed", progress),
        ("Temperature, mean", mean_temperature(source.result)),
        ("Next octave", next.map(|next| format!("τ {} s {}", tau(next.tau_s), next.when()))),
    ];
    let goals = source.goals.texts(source.result, source.elapsed);
    let faults = if is_over { Vec::new() } else { FaultKind::of(facts) };
    // of a link that never was
    let is_fault = faults.iter().any(|(fault, _)| *fault != FaultKind::RecordingFailed);
    let cause = facts.link.as_ref().and_then(|link| link.cause.as_ref()).filter(|_| !is_over && !is_fault);
    let error = match source.stage {
        LiveStage::Ended(error) => error,
        LiveStage::Preparing | LiveStage::Measuring => None,
    };
    let content = html! {
        p.state {
            (badge(source))
            @if let Some(cause) = cause { " " (cause) }
            @if let Some(silent) = source.silent { " no sample for " (time(silent.as_secs_f64().floor())) }
        }
        @for (fault, cause) in faults { p.warning.problem { b.badge.problem { (fault.name()) } " " (cause) ". " (fault.details()) } }
        @if let Some(error) = error { p.warning.problem { (error) } }
        (glance::rows(rows.into_iter().map(|(name, value)| (name, value.map(|value| with_powers(&value))))))
        @if let Some(passed) = warm_up(timing) { p.goal { b { "Warm-up excluded: " } (passed) } }
        @for goal in goals { p.goal { b { "Goal: " } (goal) } }
    };
    PagePart::new(prefix, "now", content)
}

/// The parts made from an assessment: identity, cautions, curves, parameters and verdicts,
/// spectrum, marks. The names of their figures begin with `prefix`.
#[must_use]
pub fn result_parts(record: &SourceResult, words: RemedyWords, prefix: &str) -> Vec<PagePart> {
    let captions = Captions::without_numbers();
    let part = |name: &str, content: Markup| PagePart::new(prefix, name, content);
    // those change with every sample
    let is_fixed = |name: &str| !matches!(name, "Length" | "Sample rate");
    let rows = glance::identity_rows(record).into_iter().filter(|(name, _)| is_fixed(name));
    let identity = glance::rows(rows.map(|(name, value)| (if name == "Capture" { "Source" } else { name }, value)));
    let is_empty = record.timing.samples == 0;
    let warned = if is_empty && record.warnings.is_empty() {
        html! {}
    } else {
        warnings(record, words)
    };
    if is_empty {
        // how far it is stands above, where it changes with every sample
        let waiting = match warm_up(&record.timing) {
            Some(_) => "The warm-up is excluded: the curves begin after it.",
            None => "No sample yet.",
        };
        let waiting = html! { p.absent { (waiting) } };
        // what was there before the measurement was started over
        let others = ["verdicts", "parameters", "axes", "spectrum", "statistics", "datasheet", "marks"];
        let parts = [part("identity", identity), part("cautions", warned), part("allan", waiting)];
        return parts.into_iter().chain(others.map(|name| part(name, html! {}))).collect();
    }
    let summary = Summary::new(record, words);
    let figures = Figures::live(record, prefix);
    let marks = facts::marks(record);
    vec![
        part("identity", identity),
        part("verdicts", glance::verdicts(&summary)),
        part("cautions", warned),
        part("allan", with_readings(figures::together(record, &figures, &captions), &figures.allan_sensors)),
        part("parameters", glance::parameters(&summary, &captions)),
        part(
            "datasheet",
            html! { details { summary { "Comparison with the data sheet" } (parameters::verdicts(record, words, &captions)) } },
        ),
        part("axes", with_readings(figures::axes(record, &figures, &captions), &figures.allan_axes)),
        part(
            "spectrum",
            with_readings(figures::spectrum(&figures, &captions), figures.spectra.iter().chain(&figures.segments)),
        ),
        part("statistics", statistics::tables(record, &captions)),
        part(
            "marks",
            html! { @if marks.is_empty() { p.absent { "None." } } @else { (facts::facts_table("Marks", &marks, &captions)) } },
        ),
    ]
}

/// The part with the recent samples of every channel.
#[must_use]
pub fn signal_part(result: &SourceResult, prefix: &str) -> PagePart {
    let figure = |(place, channel): (usize, &ChannelResult)| {
        let history = result.history(place, COLUMNS, usize::MAX)?;
        let mut figure = last_minutes(&channel.name, &channel.unit, &history)?;
        figure.id.insert_str(0, prefix);
        Some(figure)
    };
    let figures: Vec<Figure> = result.streamed().enumerate().filter_map(figure).collect();
    PagePart::new(prefix, "signal", with_readings(figures::grid(&figures, &Captions::without_numbers()), &figures))
}

/// Figures, with what can be read off them, for the script of the page.
fn with_readings<'a>(content: Markup, figures: impl IntoIterator<Item = &'a Figure>) -> Markup {
    // without their readings the figures stand still
    let readings = figures::readings(figures.into_iter()).unwrap_or_else(|_| "[]".into());
    html! { (content) script.readings type="application/json" { (PreEscaped(readings)) } }
}

/// The part with all sources, a row each; empty for a single source.
#[must_use]
pub fn sources_part(sources: &[(String, PageSource<'_>)]) -> PagePart {
    let row = |(prefix, source): &(String, PageSource<'_>)| {
        let timing = &source.result.timing;
        let gravest = source.result.warnings.first();
        html! {
            tr {
                th scope="row" { a href={ "#" (prefix) "source" } { (source.result.source.name) } }
                td.words { (badge(source)) }
                td { (grouped(timing.samples)) }
                td { (time(timing.duration_s)) }
                td { (missing_text(timing)) (pending_text(timing)) }
                td.words { @if let Some(gravest) = gravest { b class={ "badge " (glance::severity_class(Some(gravest.severity))) } { (gravest.severity.name()) } " " (headline(gravest)) } @else { "–" } }
            }
        }
    };
    let content = html! {
        @if sources.len() > 1 {
            div.scroll { table {
                caption { "All sources" }
                thead { tr {
                    th scope="col" { "source" } th.words scope="col" { "state" }
                    @for name in ["samples", "data time", "dropped"] { th scope="col" { (name) } }
                    th.words scope="col" { "gravest warning" }
                } }
                tbody { @for source in sources { (row(source)) } }
            } }
        }
    };
    PagePart::new("", "sources", content)
}

/// The sections of a source: the name of its part, and its heading.
const SECTIONS: [(&str, &str); 9] = [
    ("cautions", "Cautions"),
    ("allan", "Allan deviation"),
    ("parameters", "Noise parameters"),
    ("signal", "Last minutes"),
    ("axes", "Allan deviation of each axis"),
    ("spectrum", "Spectrum and deviation per segment"),
    ("statistics", "Descriptive statistics"),
    ("datasheet", "Data sheet"),
    ("marks", "Marks"),
];

/// Of more sources than these the details are closed at first.
const OPEN_AT_ONCE: usize = 4;

/// The whole page with these parts; `version` is the id from which its events continue. `sources`
/// are the prefixes and names of the sources. With many sources the details of each are loaded when
/// they are opened.
#[must_use]
pub fn live_page(sources: &[(String, String)], parts: &[&PagePart], version: &str, program: &str) -> String {
    let content = |id: &str| {
        let part = parts.iter().find(|part| part.id == id && part.detail_of.is_none());
        html! { (PreEscaped(part.map_or("", |part| &part.html))) }
    };
    let section = |prefix: &str, (part, heading): (&str, &str)| {
        let id = format!("{prefix}{part}");
        html! { section { h2 { (heading) } div id=(id) { (content(&id)) } } }
    };
    let title = match sources {
        [(_, name)] => format!("{name}: noise, live"),
        _ => format!("Noise of {} sources, live", sources.len()),
    };
    let page = html! {
        (DOCTYPE)
        html lang="en" data-version=(version) {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                link rel="icon" href="icon.svg" type="image/svg+xml";
                link rel="stylesheet" href="page.css";
                script src="page.js" defer {}
            }
            body {
                header {
                    h1 { (title) }
                    p #connection role="status" {}
                    noscript { p.warning.caution { "Without its script this page stays as it is: load it again for news." } }
                }
                main {
                    section #sources { (content("sources")) }
                    @for (prefix, name) in sources {
                        article id={ (prefix) "source" } {
                            @if sources.len() > 1 { h2.record { (name) } }
                            @for part in ["now", "identity", "verdicts"] {
                                @let id = format!("{prefix}{part}");
                                div id=(id) { (content(&id)) }
                            }
                            @let (brief, details) = SECTIONS.split_at(if sources.len() > 1 { 1 } else { SECTIONS.len() });
                            @for named in brief { (section(prefix, *named)) }
                            @if !details.is_empty() {
                                details.source data-source=(prefix) open[sources.len() <= OPEN_AT_ONCE] {
                                    summary { "Figures and tables of " (name) }
                                    @for named in details { (section(prefix, *named)) }
                                }
                            }
                        }
                    }
                }
                footer {
                    p {
                        a href="report.html" { "The report so far" } " · " a href="snapshot.json" { "all numbers (JSON)" } " · " a href="metrics" { "metrics" }
                    }
                    p { "Measured by " (program) "." }
                }
            }
        }
    };
    text_of(page)
}

/// The icon of the page in a browser: a falling and rising curve, as SVG.
#[must_use]
pub fn live_icon() -> String {
    let mut path = String::from("M4 8");
    for (x, y) in [(12, 18), (18, 22), (23, 20), (28, 12)] {
        // a String takes everything
        let _ = write!(path, "L{x} {y}");
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 32 32\"><rect width=\"32\" height=\"32\" rx=\"6\" fill=\"#0072b2\"/><path d=\"{path}\" fill=\"none\" stroke=\"#fff\" stroke-width=\"3\"/></svg>"
    )
}
