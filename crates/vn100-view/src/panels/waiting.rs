//! Before the first sample: what is being waited for, and why it may not come.

use ratatui::{
    Frame,
    layout::Rect,
    text::Line,
    widgets::{Block, Borders, Padding, Paragraph, Wrap},
};
use vn100_analysis::{LinkFacts, LinkStatus, Remedy, Setting};
use vn100_report::{goals::warm_up, numbers::plain::grouped, printable, remedies::remedy_words};

use crate::{
    scene::Scene,
    source::{SourcePhase, SourceView},
};

pub(crate) fn draw_waiting(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let source = scene.source;
    let warm_up = warm_up(&source.result.timing);
    let (what, why) = match (&source.phase, status(source), &warm_up) {
        (SourcePhase::Measuring, None | Some(LinkStatus::Connected), Some(passed)) => {
            (format!("Warm-up excluded: {passed}."), vec!["The measurement begins after it; w begins it now.".into()])
        }
        _ => waiting_for(source),
    };
    let link = &source.result.link;
    let mut lines = vec![Line::raw(what).style(scene.theme.warning()), Line::raw("")];
    lines.extend(why.into_iter().map(|line| Line::raw(format!("- {line}"))));
    lines.push(Line::raw(""));
    lines.push(Line::raw(format!(
        "So far {} bytes, {} valid sentences, {} packets, {} rejected.",
        grouped(source.result.link.bytes),
        grouped(link.frames),
        grouped(link.binary_packets),
        grouped(link.rejected.total() + link.rejected_packets + link.damaged_packets)
    )));
    let block = Block::new()
        .borders(Borders::ALL)
        .border_style(scene.theme.faint())
        .padding(Padding::symmetric(2, 1))
        .title(if warm_up.is_some() { " Warm-up " } else { " No measurement yet " });
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: false }).block(block), area);
}

fn status(source: &SourceView) -> Option<LinkStatus> {
    source.link().map(|link| link.status)
}

/// What comes next, and why it may not come.
fn waiting_for(source: &SourceView) -> (String, Vec<String>) {
    let (what, why) = situation(source);
    let cause = match (&source.phase, status(source)) {
        (SourcePhase::Measuring, Some(LinkStatus::Connected)) if !source.result.timing.awaits_rate() => {
            Some("The sensor may send another message")
        }
        (SourcePhase::Measuring, Some(LinkStatus::Silent)) => Some("Its output may have been switched off"),
        _ => None,
    };
    let cure = remedy_words(&Remedy::Configure(Setting::Message("VNYMR")));
    (what, why.into_iter().map(str::to_owned).chain(cause.map(|cause| format!("{cause}: {cure}."))).collect())
}

fn situation(source: &SourceView) -> (String, Vec<&str>) {
    let (name, timing) = (&source.name, &source.result.timing);
    match (&source.phase, source.link()) {
        (SourcePhase::Preparing, _) => (
            format!("Preparing {name}: creating the recording and changing the settings of the sensor as requested."),
            vec!["A baud scan takes some seconds."],
        ),
        (SourcePhase::Ended(reason), _) => {
            (format!("{name} has ended without a measurement."), reason.iter().map(String::as_str).collect())
        }
        (_, None | Some(LinkFacts { status: LinkStatus::Connected, .. })) if timing.awaits_rate() => {
            pending(name, timing.pending)
        }
        (SourcePhase::Measuring, None) => (
            format!("Reading {name}, waiting for the first measurement."),
            vec!["A stream may begin in the middle of a sentence: the first whole one counts."],
        ),
        (SourcePhase::Measuring, Some(link)) => of_link(source, link),
    }
}

fn of_link<'a>(source: &'a SourceView, link: &'a LinkFacts) -> (String, Vec<&'a str>) {
    let port = link.port.as_deref().unwrap_or(&source.name);
    let at = link.baud.map_or(String::new(), |baud| format!(" at {baud} baud"));
    match link.status {
        LinkStatus::Opening if source.result.source.kind == Some("tcp") => (
            format!("Opening {port}."),
            vec![
                "The server may be off, in another network, or behind a firewall.",
                "It may accept one connection at a time, and have one already.",
                "It may listen on another port: see its settings.",
            ],
        ),
        LinkStatus::Opening => (
            format!("Opening {port}."),
            vec![
                "Another program may have it open.",
                "You may lack the permission: on Linux, add your user to the group dialout.",
                "It may have another name now: `vn100 ports` lists them.",
            ],
        ),
        LinkStatus::Scanning => (
            match link.baud {
                Some(_) => format!("Listening on {port}{at}; scanning all baud rates of the sensor."),
                None => format!("Connected to {port}; listening for a sensor."),
            },
            vec![
                "The sensor may be without power, or still starting.",
                "RX and TX may be swapped, or RS-232 levels connected to a TTL input.",
                "Its output may be off: the program asks it, unless --listen-only is set.",
            ],
        ),
        LinkStatus::Connected => (
            format!("{port} is connected{at}; waiting for the first measurement."),
            vec![
                "At low rates a sentence takes up to a second.",
                "Sentences without a checksum are rejected, unless --accept-unchecked is set.",
            ],
        ),
        LinkStatus::Silent => (
            format!("{port} is open, but no data has arrived for several sample intervals."),
            vec!["The sensor may have lost power.", "Another program may have changed its baud rate."],
        ),
        LinkStatus::Lost | LinkStatus::NotConnected => {
            let word = if link.status == LinkStatus::Lost { "Disconnected" } else { "Not connected yet" };
            let cause = link.cause.as_deref().unwrap_or_default();
            let text = format!("{word}: {}. Another attempt follows.", printable(cause));
            (text, vec!["It reconnects automatically; the samples so far are kept."])
        }
        LinkStatus::Closed => ("Ending.".to_owned(), Vec::new()),
    }
}

fn pending(name: &str, lines: u64) -> (String, Vec<&'static str>) {
    (
        format!(
            "{name} sends data; the sample rate is being measured. Its first {} samples are pending until their arrival times give it.",
            grouped(lines)
        ),
        vec![
            "Without gaps that takes 32 samples, or a second and 5 samples where the sensor reports its rate.",
            "With gaps or on a busy host it takes up to 1024 samples, half a minute at 40 Hz.",
            "None of them is lost: they are measured once the rate is known.",
        ],
    )
}
