//! Before the first sample: what is being waited for, and what may be wrong if it does not come.

use ratatui::{
    Frame,
    layout::Rect,
    text::Line,
    widgets::{Block, Borders, Padding, Paragraph, Wrap},
};
use vn100_driver::LinkState;
use vn100_report::numbers::plain::grouped;

use super::{
    scene::Scene,
    source::{Source, Stage},
};

pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, source: &Source) {
    let (what, why) = waiting_for(source);
    let tally = &source.snapshot.link.tally;
    let mut lines = vec![Line::raw(what).style(scene.theme.warning()), Line::raw("")];
    lines.extend(why.into_iter().map(|line| Line::raw(format!("- {line}"))));
    lines.push(Line::raw(""));
    lines.push(Line::raw(format!(
        "So far {} bytes, {} good lines, {} bad lines.",
        grouped(source.snapshot.link.bytes()),
        grouped(tally.valid_sentences()),
        grouped(tally.rejected.total())
    )));
    let block = Block::new()
        .borders(Borders::ALL)
        .border_style(scene.theme.faint())
        .padding(Padding::symmetric(2, 1))
        .title(" No measurement yet ");
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: false }).block(block), area);
}

/// What comes next, and why it may not come.
fn waiting_for(source: &Source) -> (String, Vec<String>) {
    let own = |lines: &[&str]| lines.iter().map(|line| (*line).to_owned()).collect();
    let name = &source.name;
    if let (Stage::Measuring, None | Some(LinkState::Up(_)), Some(lines)) =
        (&source.stage, &source.link, source.snapshot.lines_held())
    {
        return held(name, lines);
    }
    match (&source.stage, &source.link) {
        (Stage::Preparing, _) => (
            format!(
                "Preparing {name}: the recording is made ready, and what was asked to be changed on the sensor is."
            ),
            own(&["While the speed of the line is looked for this takes some seconds."]),
        ),
        (Stage::Ended(reason), _) => {
            (format!("{name} has ended without a measurement."), reason.iter().cloned().collect())
        }
        (Stage::Measuring, None) => (
            format!("Reading {name}, looking for the first measurement."),
            own(&["A stream that was cut off begins in the middle of a line: the first whole one counts."]),
        ),
        (Stage::Measuring, Some(link)) => match link {
            LinkState::Opening if source.origin.kind == Some("tcp") => (
                format!("Opening {name}."),
                own(&[
                    "The server may be off, in another network, or behind a firewall.",
                    "It may take one connection at a time, and have it.",
                    "Its port may be another: the number stands in its settings.",
                ]),
            ),
            LinkState::Opening => (
                format!("Opening {name}."),
                own(&[
                    "Another program may have it open.",
                    "You may have no right to it: on Linux, your user belongs in the group dialout.",
                    "It may have another name now: `vn100 ports` lists them.",
                ]),
            ),
            LinkState::Probing { port, baud } => (
                match baud {
                    Some(baud) => format!("Listening on {port} at {baud} baud; all speeds of the sensor are tried."),
                    None => format!("Connected to {port}; listening for a sensor."),
                },
                own(&[
                    "The sensor may be without power, or still starting.",
                    "Receive and transmit may be swapped, or RS-232 levels meet a TTL input.",
                    "It may send nothing: then it is asked, unless --listen-only forbids it.",
                ]),
            ),
            LinkState::Up(up) => (
                match up.baud {
                    Some(baud) => format!("{} is heard at {baud} baud; waiting for the first measurement.", up.port),
                    None => format!("{} is heard; waiting for the first measurement.", up.port),
                },
                own(&[
                    "At low rates a line takes up to a second.",
                    "The sensor may send another message: `vn100 configure PORT --set-message VNYMR`.",
                    "Lines without a checksum are left out, unless --accept-unchecked lets them in.",
                ]),
            ),
            LinkState::Silent(up) => (
                format!("{} is open, and nothing has come on it for several lines' time.", up.port),
                own(&[
                    "The sensor may have lost its power.",
                    "Its output may have been switched off: `vn100 configure PORT --set-rate 40`.",
                    "Another program may have changed its speed.",
                ]),
            ),
            LinkState::Down { was_up, cause, retry_in, .. } => (
                format!(
                    "{}: {cause}. Trying again in {} ms.",
                    if *was_up { "The link is lost" } else { "There is no link yet" },
                    retry_in.as_millis()
                ),
                own(&["It is opened again as soon as it is back; what was measured stands."]),
            ),
            _ => ("Ending.".to_owned(), Vec::new()),
        },
    }
}

fn held(name: &str, lines: u64) -> (String, Vec<String>) {
    (
        format!(
            "{name} sends; the rate is being found. Its first {} lines are held until their times tell it, and what is missing.",
            grouped(lines)
        ),
        vec![
            "On a quiet line that takes 32 lines, or a second and 5 lines where the sensor tells its rate.".to_owned(),
            "On a disturbed or busy one it takes up to 1024 lines, half a minute at 40 Hz.".to_owned(),
            "None of them is lost: they are counted as soon as it is known.".to_owned(),
        ],
    )
}
