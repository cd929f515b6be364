//! Before the first sample: what is being waited for, and why it may not come.

use ratatui::{
    Frame,
    layout::Rect,
    text::Line,
    widgets::{Block, Borders, Padding, Paragraph, Wrap},
};
use vn100_analysis::{Remedy, Setting};
use vn100_driver::LinkState;
use vn100_report::{goals::warm_up, numbers::plain::grouped, remedies::remedy_words};

use crate::{
    scene::Scene,
    source::{SourcePhase, SourceView},
};

pub(crate) fn draw_waiting(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let source = scene.source;
    let warm_up = warm_up(&source.result.timing);
    let (what, why) = match (&source.phase, &source.link, &warm_up) {
        (SourcePhase::Measuring, None | Some(LinkState::Up(_)), Some(passed)) => {
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

/// What comes next, and why it may not come.
fn waiting_for(source: &SourceView) -> (String, Vec<String>) {
    let (what, why) = situation(source);
    let cure = match (&source.phase, &source.link) {
        (SourcePhase::Measuring, Some(LinkState::Up(_))) if !source.result.timing.awaits_rate() => {
            Some(("The sensor may send another message: ", Remedy::Configure(Setting::Message("VNYMR"))))
        }
        (SourcePhase::Measuring, Some(LinkState::Silent(_))) => {
            Some(("Its output may have been switched off: ", Remedy::Configure(Setting::Message("VNYMR"))))
        }
        _ => None,
    };
    let cure = cure.map(|(why, remedy)| format!("{why}{}.", remedy_words(&remedy)));
    (what, why.into_iter().map(str::to_owned).chain(cure).collect())
}

fn situation(source: &SourceView) -> (String, Vec<&str>) {
    let name = &source.name;
    let timing = &source.result.timing;
    if let (SourcePhase::Measuring, None | Some(LinkState::Up(_)), true) =
        (&source.phase, &source.link, timing.awaits_rate())
    {
        return pending(name, timing.pending);
    }
    match (&source.phase, &source.link) {
        (SourcePhase::Preparing, _) => (
            format!("Preparing {name}: creating the recording and changing the settings of the sensor as requested."),
            vec!["A baud scan takes some seconds."],
        ),
        (SourcePhase::Ended(reason), _) => {
            (format!("{name} has ended without a measurement."), reason.iter().map(String::as_str).collect())
        }
        (SourcePhase::Measuring, None) => (
            format!("Reading {name}, waiting for the first measurement."),
            vec!["A stream may begin in the middle of a sentence: the first whole one counts."],
        ),
        (SourcePhase::Measuring, Some(link)) => match link {
            LinkState::Opening if source.result.source.kind == Some("tcp") => (
                format!("Opening {name}."),
                vec![
                    "The server may be off, in another network, or behind a firewall.",
                    "It may accept one connection at a time, and have one already.",
                    "It may listen on another port: see its settings.",
                ],
            ),
            LinkState::Opening => (
                format!("Opening {name}."),
                vec![
                    "Another program may have it open.",
                    "You may lack the permission: on Linux, add your user to the group dialout.",
                    "It may have another name now: `vn100 ports` lists them.",
                ],
            ),
            LinkState::Probing { port, baud } => (
                match baud {
                    Some(baud) => format!("Listening on {port} at {baud} baud; scanning all baud rates of the sensor."),
                    None => format!("Connected to {port}; listening for a sensor."),
                },
                vec![
                    "The sensor may be without power, or still starting.",
                    "RX and TX may be swapped, or RS-232 levels connected to a TTL input.",
                    "Its output may be off: the program asks it, unless --listen-only is set.",
                ],
            ),
            LinkState::Up(up) => (
                match up.baud {
                    Some(baud) => {
                        format!("{} is connected at {baud} baud; waiting for the first measurement.", up.port)
                    }
                    None => format!("{} is connected; waiting for the first measurement.", up.port),
                },
                vec![
                    "At low rates a sentence takes up to a second.",
                    "Sentences without a checksum are rejected, unless --accept-unchecked is set.",
                ],
            ),
            LinkState::Silent(up) => (
                format!("{} is open, but no data has arrived for several sample intervals.", up.port),
                vec!["The sensor may have lost power.", "Another program may have changed its baud rate."],
            ),
            LinkState::Down { was_up, cause, retry_in, .. } => (
                format!(
                    "{}: {cause}. Trying again in {} ms.",
                    if *was_up { "Disconnected" } else { "Not connected yet" },
                    retry_in.as_millis()
                ),
                vec!["It reconnects automatically; the samples so far are kept."],
            ),
            _ => ("Ending.".to_owned(), Vec::new()),
        },
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
