//! The live page: the state of a source, and the parts of its report, redrawn as the result changes.

use std::time::Duration;

use crate::warnings::headline;
use crate::{
    facts::{NOT_RECORDED, Row, timing as timing_rows},
    figure::Figures,
    goals::{Goals, warm_up},
    health::{FaultKind, line_load, next_octave, state},
    names::{missing_text, pending_text},
    numbers::{
        plain::{grouped, tau, time},
        with_powers,
    },
    summary::mean_temperature,
};
use maud::{Markup, PreEscaped, html};
use vn100_analysis::SourceResult;

use crate::html::{
    caption::Captions,
    glance,
    options::PageOptions,
    page::Page,
    parts::{PagePart, arranged, is_live, parts},
};

/// One source at one moment.
#[derive(Debug, Clone, Copy)]
pub struct PageSource<'a> {
    /// The result so far.
    pub result: &'a SourceResult,
    /// What its measurement ends by.
    pub goals: &'a Goals,
    /// Whether the source is still being opened.
    pub is_preparing: bool,
    /// Time by the clock since the command began.
    pub elapsed: Duration,
    /// How long no sample has come; `None` if that is too short to mention.
    pub silent: Option<Duration>,
}

fn badge(source: &PageSource<'_>) -> Markup {
    let (word, severity) = state(&source.result.source, source.is_preparing);
    html! { b class={ "badge " (glance::severity_class(severity)) } { (word) } }
}

/// What of rate, counts and losses is shown at every moment.
const SHOWN: [&str; 8] = [
    "Samples",
    "Sample rate",
    "Measured rate",
    "Interarrival times",
    "Dropped samples",
    "Excluded",
    "Rejected lines",
    "Link",
];

/// The part that changes with every sample: the link, samples and losses, and what is to come.
pub fn state_part(source: &PageSource<'_>) -> PagePart {
    let SourceResult { source: facts, timing, .. } = source.result;
    let is_over = source.is_preparing || facts.end.is_some() || facts.playback.is_some_and(|playback| playback.at_end);
    let recorder =
        facts.recorder.as_ref().map(|recorder| format!("{}, {} bytes", recorder.path, grouped(recorder.bytes)));
    let progress = facts.playback.and_then(|playback| {
        let part = playback.samples as f64 / playback.total.filter(|total| *total > 0)? as f64;
        Some(format!("{:.0} %", 100.0 * part))
    });
    let next = next_octave(source.result).filter(|_| !is_over);
    let more = [
        ("Line load", line_load(source.result).map(|load| format!("{:.0} %", 100.0 * load))),
        ("Recording", recorder),
        ("Replayed", progress),
        ("Temperature, mean", mean_temperature(source.result)),
        ("Next octave", next.map(|next| format!("τ {} s {}", tau(next.tau_s), next.when()))),
    ];
    let known = timing_rows(source.result).into_iter().filter(|(name, value)| {
        SHOWN.contains(&&**name) && value != NOT_RECORDED && (name != "Excluded" || timing.excluded > 0)
    });
    let more = more.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?)));
    let rows: Vec<Row> = known.chain(more).map(|(name, value)| (name, with_powers(&value))).collect();
    let goals = source.goals.texts(source.result, source.elapsed);
    let faults = if is_over { Vec::new() } else { FaultKind::of(facts) };
    // of a link that never was
    let is_fault = faults.iter().any(|(fault, _)| *fault != FaultKind::RecordingFailed);
    let cause = facts.link.as_ref().and_then(|link| link.cause.as_ref()).filter(|_| !is_over && !is_fault);
    let error = facts.error.as_ref().filter(|_| facts.end.is_some());
    let content = html! {
        p.state {
            (badge(source))
            @if let Some(cause) = cause { " " (cause) }
            @if let Some(silent) = source.silent { " no sample for " (time(silent.as_secs_f64().floor())) }
        }
        @for (fault, cause) in faults { p.warning.problem { b.badge.problem { (fault.name()) } " " (cause) ". " (fault.details()) } }
        @if let Some(error) = error { p.warning.problem { (error) } }
        (glance::rows(rows.iter().map(|(name, value)| (name.as_str(), Some(value.clone())))))
        @if let Some(passed) = warm_up(timing) { p.goal { b { "Warm-up excluded: " } (passed) } }
        @for goal in goals { p.goal { b { "Goal: " } (goal) } }
    };
    PagePart::new("now", content)
}

/// The parts of the report of a source under way, and the recent samples of every channel.
pub fn result_parts(result: &SourceResult, options: PageOptions<'_>) -> Vec<PagePart> {
    parts(result, &Figures::live(result), options, &Captions::default(), true)
}

/// The part with all sources, a row each that leads to the page of the source.
pub fn sources_part(sources: &[PageSource<'_>]) -> PagePart {
    let row = |(place, source): (usize, &PageSource<'_>)| {
        let timing = &source.result.timing;
        let gravest = source.result.warnings.first();
        html! {
            tr {
                th scope="row" { a href=(place + 1) { (source.result.source.name) } }
                td.words { (badge(source)) }
                td { (grouped(timing.samples)) }
                td { (time(timing.duration_s)) }
                td { (missing_text(timing)) (pending_text(timing)) }
                td.words { @if let Some(gravest) = gravest { b class={ "badge " (glance::severity_class(Some(gravest.severity))) } { (gravest.severity.name()) } " " (headline(gravest)) } @else { "–" } }
            }
        }
    };
    let content = html! {
        div.scroll { table {
            caption { "All sources" }
            thead { tr {
                th scope="col" { "source" } th.words scope="col" { "state" }
                @for name in ["samples", "data time", "dropped"] { th scope="col" { (name) } }
                th.words scope="col" { "gravest warning" }
            } }
            tbody { @for source in sources.iter().enumerate() { (row(source)) } }
        } }
    };
    PagePart::new("sources", content)
}

/// What a live page shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShownPage<'a> {
    /// All of so many sources.
    List(usize),
    /// One source by its name.
    Source(&'a str),
    /// One source of several.
    SourceOfSeveral(&'a str),
}

/// The whole page with these parts; `version` is the id from which its events continue.
pub fn live_page<'a>(
    shown: ShownPage<'_>,
    parts: impl Fn(&str) -> Option<&'a str>,
    version: &str,
    program: &str,
) -> String {
    let title = match shown {
        ShownPage::List(count) => format!("Noise of {count} sources, live"),
        ShownPage::Source(name) | ShownPage::SourceOfSeveral(name) => format!("{name}: noise, live"),
    };
    let content = |id: &str| parts(id).or(is_live(id).then_some(""));
    let head = html! {
        p #connection {}
        p #announced role="status" {}
        @if matches!(shown, ShownPage::SourceOfSeveral(_)) { p { a href="/" { "All sources" } } }
        noscript { p.warning.caution { "Without its script this page stays as it is: load it again for news." } }
    };
    let main = html! {
        @if matches!(shown, ShownPage::List(_)) { section id="sources" { (PreEscaped(parts("sources").unwrap_or_default())) } } @else { (arranged(content, "")) }
        footer {
            p { a href="report.html" { "The report so far" } " · " a href="snapshot.json" { "all numbers (JSON)" } " · " a href="metrics" { "metrics" } }
            p { "Measured by " (program) "." }
        }
    };
    Page { title: &title, style: "", version: Some(version), head, main }.text()
}
