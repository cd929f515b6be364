//! The keys: those that do something now in the last line, and every one of them in the help.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    style::{Modifier, Style},
    text::{Line, Span},
    widgets::{Block, Borders, Paragraph},
};
use vn100_pipeline::Playback;

use super::{
    draw::Scene,
    health::LEAST_NAME,
    state::{Panel, Question},
    theme::Theme,
    warnings::shortened,
};

pub(crate) fn draw_footer(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let (state, theme) = (scene.state, scene.theme);
    let question = state.question.as_ref().map(|question| match question {
        Question::StartOver => of_source(scene, area.width, "Forget everything so far, start over? y / n"),
        Question::EndWarmUp => of_source(scene, area.width, "Leave out all so far, as warm-up? y / n"),
        Question::GoTo(typed) => format!(" Go to which percent of the capture? {typed}_   enter / esc"),
    });
    if let Some(text) = question {
        frame.render_widget(Paragraph::new(text).style(theme.chosen()), area);
        return;
    }
    if let Some(message) = &state.message {
        let text = shortened(&format!(" {message}"), usize::from(area.width));
        frame.render_widget(Paragraph::new(text).style(theme.warning()), area);
        return;
    }
    let mut spans = Vec::new();
    let mut room = usize::from(area.width);
    for (key, does) in keys(scene) {
        let width = key.chars().count() + does.chars().count() + 3;
        if width > room {
            break;
        }
        room -= width;
        spans.push(Span::raw(format!(" {key}")).style(Modifier::BOLD));
        spans.push(Span::styled(format!(" {does} "), theme.faint()));
    }
    frame.render_widget(Paragraph::new(Line::from(spans)), area);
}

/// A question, with the source it is about where there are several.
fn of_source(scene: Scene<'_>, width: u16, question: &str) -> String {
    if scene.sources.len() < 2 {
        return format!(" {question}");
    }
    let before = format!(" {} ", scene.state.source + 1);
    let beside = before.len() + ": ".len() + question.len();
    let name = shortened(&scene.source.name, usize::from(width).saturating_sub(beside).max(LEAST_NAME));
    format!("{before}{name}: {question}")
}

/// The keys that do something now, the most used first.
fn keys(scene: Scene<'_>) -> Vec<(&'static str, &'static str)> {
    let state = scene.state;
    if state.overview {
        return vec![("q", "quit"), ("?", "help"), ("↑↓", "choose"), ("enter", "open"), ("f", "freeze"), ("s", "save")];
    }
    let replay = scene.source.playback.map_or(Vec::new(), |playback| {
        let Playback { at_end, paused, .. } = playback;
        let space = (!at_end).then_some(("space", if paused { "go on" } else { "pause" }));
        space.into_iter().chain([("<>", "speed"), ("[]", "seek"), ("g", "go to %")]).collect()
    });
    let is_waiting = scene.source.snapshot.timing.samples == 0;
    let mut keys = vec![("q", "quit"), ("?", "help")];
    if !is_waiting {
        keys.extend([("tab", "panel"), ("1-4", "sensor"), ("xyz a", "axis")]);
    }
    keys.extend(replay);
    if scene.sources.len() > 1 {
        keys.extend([("o", "overview"), ("n p", "source")]);
    }
    if is_waiting {
        return keys;
    }
    match state.panel {
        Panel::Warnings => keys.push(("↑↓", "choose")),
        Panel::Allan => keys.push(("←→", "cursor")),
        Panel::Parameters | Panel::Statistics | Panel::Signal => {}
    }
    keys.extend([("u", "unit"), ("e", "expand"), ("f", "freeze"), ("s", "save"), ("-=", "zoom")]);
    keys.extend([("w", "warm-up over"), ("r", "start over")]);
    keys
}

const KEYS: [(&str, &str); 22] = [
    ("q  Ctrl-C", "quit: the result is printed"),
    ("Q", "quit, and keep this screen above the result"),
    ("?", "this help: arrows turn it, esc closes it"),
    ("tab shift-tab", "next panel, the one before"),
    ("!", "the warnings, each in full"),
    ("e enter  esc", "the panel alone, and back"),
    ("1 - 9", "sensor: gyro, accel, mag, orientation"),
    ("x y z  a", "one axis large with its model; all axes"),
    ("up down  k j", "channel before, next; in Warnings: warning"),
    ("left right  h l", "cursor on the curve; home, end"),
    ("= -", "zoom around the cursor; in Signal: in time"),
    ("u", "next units of N, B, K and the curve"),
    ("f", "freeze the view; measuring goes on"),
    ("s", "save the result so far as JSON, curve as SVG"),
    ("w", "warm-up is over: leave out what came so far"),
    ("r", "start over, as if attached now"),
    ("Ctrl-Z", "to the shell; nothing is read until fg"),
    ("o  n p", "several sources: overview, next, before"),
    ("space  .", "replay: pause, go on; a second of data more"),
    ("> <", "replay: faster, slower"),
    ("g  [ ]", "replay: go to a percentage; a tenth back, on"),
    ("mouse", "click panels, points, the replay bar; wheel"),
];

/// Behind the first of them stands what the bars mean, which the level of confidence is part of.
const MEANINGS: [(&str, &str); 16] = [
    ("σ(τ)", "how much means over τ seconds differ"),
    ("↑ ↓", "the bar goes on outside the plot"),
    ("edf", "degrees of freedom: few, a wide bar"),
    ("N", "white noise: σ down as 1/√τ"),
    ("B", "bias instability: flat floor of σ"),
    ("K", "rate random walk: σ up as √τ"),
    ("≤", "at most this, and perhaps none at all"),
    ("not yet seen", "the record is too short to tell"),
    ("not in stream", "the message does not carry it"),
    ("sensor", "the sensor's own N, without folding"),
    ("verdict", "held against the data sheet"),
    ("fit p", "below 0.01 the model does not fit"),
    ("ppm", "the sensor's clock beside this host's"),
    ("p50 p99 max", "ms between lines: half, 99 %, all"),
    ("line", "how much of the line's speed is taken"),
    ("missing", "samples not there: lost or damaged"),
];

const KEY_COLUMNS: u16 = 62;

/// Columns from which on the meanings stand beside the keys.
const SIDE_BY_SIDE: u16 = 116;

pub(crate) fn draw_help(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, page: usize) {
    let block = Block::new().borders(Borders::ALL);
    let inner = block.inner(area);
    let keys = lines(&KEYS, 16, Style::new(), scene.theme);
    // no more digits than are useful, and no rounding to 100 %
    let percent = (1e5 * scene.source.assessment.confidence).round() / 1e3;
    let bars = format!("the truth lies within: {percent} % sure");
    let meanings = [&MEANINGS[..1], &[("bars, ±", bars.as_str())], &MEANINGS[1..]].concat();
    let meanings = lines(&meanings, 14, scene.theme.faint(), scene.theme);
    let height = usize::from(inner.height);
    if inner.width >= SIDE_BY_SIDE && height >= keys.len() {
        frame.render_widget(block.title(" Keys, and what the signs mean "), area);
        let [left, right] = Layout::horizontal([Constraint::Length(KEY_COLUMNS), Constraint::Fill(1)]).areas(inner);
        frame.render_widget(Paragraph::new(keys), left);
        frame.render_widget(Paragraph::new(meanings), right);
        return;
    }
    let pages: Vec<&[Line<'_>]> = keys.chunks(height).chain(meanings.chunks(height)).collect();
    let page = page % pages.len();
    let of_keys = page < keys.len().div_ceil(height);
    let subject = if of_keys { "Keys" } else { "What the signs mean" };
    let title = format!(" {subject}: page {} of {}, → turns it ", page + 1, pages.len());
    frame.render_widget(block.title(title), area);
    frame.render_widget(Paragraph::new(pages[page].to_vec()), inner);
}

fn lines(rows: &[(&str, &str)], width: usize, style: Style, theme: Theme) -> Vec<Line<'static>> {
    let line = |(sign, text): &(&str, &str)| {
        let sign = theme.spelled(*sign);
        let sign = Span::styled(format!(" {sign:<width$} "), Style::new().add_modifier(Modifier::BOLD));
        Line::from(vec![sign, Span::styled(theme.spelled(*text), style)])
    };
    rows.iter().map(line).collect()
}
