//! The keys: those that do something now in the last line, and every one of them in the help.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    style::{Modifier, Style},
    text::{Line, Span},
    widgets::{Block, Borders, Paragraph},
};
use vn100_report::shortened;
use vn100_session::Playback;

use crate::{
    panels::health::LEAST_NAME,
    scene::Scene,
    state::{Panel, Question},
    theme::Theme,
};

/// Columns of the keys that are always there: those that quit, and that show all others.
const LEAST_KEYS: usize = 16;

pub(crate) fn draw_footer(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let (state, theme) = (scene.state, scene.theme);
    let question = state.question.as_ref().map(|question| match question {
        Question::StartOver => of_source(scene, area.width, "Discard everything so far and start over? y / n"),
        Question::EndWarmUp => of_source(scene, area.width, "Exclude everything so far as warm-up? y / n"),
        Question::Mark(typed) => {
            // of a long text the end, which is written
            let text = format!(" Mark this place with: {typed}_   enter / esc");
            let excess = text.chars().count().saturating_sub(usize::from(area.width));
            text.chars().skip(excess).collect()
        }
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
    if let Some(page) = &state.page
        && let Some(beside) = room.checked_sub(page.chars().count() + 1).filter(|beside| *beside >= LEAST_KEYS)
    {
        // the keys that have no room beside it stand in the help
        room = beside;
        let page = Line::styled(format!("{page} "), theme.faint());
        frame.render_widget(Paragraph::new(page).right_aligned(), area);
    }
    for (key, does) in keys(scene) {
        let width = key.chars().count() + does.chars().count() + 3;
        if width > room {
            break;
        }
        room -= width;
        spans.push(Span::raw(format!(" {key}")).style(Modifier::BOLD));
        spans.push(Span::styled(format!(" {does} "), theme.faint()));
    }
    let line = Line::from(spans);
    let area = Rect { width: area.width.min(line.width() as u16), ..area };
    frame.render_widget(Paragraph::new(line), area);
}

/// A question, with the source it is about if there are several.
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
        return vec![("q", "quit"), ("?", "help"), ("↑↓", "choose"), ("enter", "open"), ("s", "save")];
    }
    let replay = scene.source.playback.map_or(Vec::new(), |playback| {
        let Playback { at_end, paused, .. } = playback;
        let space = (!at_end).then_some(("space", if paused { "resume" } else { "pause" }));
        space.into_iter().chain([("<>", "speed")]).collect()
    });
    let is_waiting = scene.source.result.timing.samples == 0;
    let mut keys = vec![("q", "quit"), ("?", "help")];
    if !is_waiting {
        keys.extend([("tab", "panel"), ("1-4", "sensor"), ("xyz a", "axis")]);
    }
    keys.extend(replay);
    if scene.sources.len() > 1 {
        keys.extend([("o", "list"), ("n p", "source")]);
    }
    if is_waiting {
        return keys;
    }
    match state.panel {
        Panel::Warnings => keys.push(("↑↓", "choose")),
        Panel::Allan => keys.extend([("v", "spectrum"), ("←→", "cursor")]),
        Panel::Parameters | Panel::Statistics | Panel::Signal => {}
    }
    keys.extend([("e", "expand"), ("s", "save"), ("w", "warm-up over"), ("r", "start over")]);
    keys
}

const KEYS: [(&str, &str); 16] = [
    ("q  Ctrl-C", "quit and print the summary"),
    ("?", "this help: arrows turn pages, esc closes it"),
    ("tab shift-tab", "next, previous panel"),
    ("!", "what is broken, warnings and notes, each in full"),
    ("e enter  esc", "enlarge the panel, and back"),
    ("1 - 9", "sensor: gyro, accel, mag, orientation"),
    ("x y z  a", "one axis with its model; all axes"),
    ("v", "the spectrum in place of the deviation, and back"),
    ("arrows", "cursor on the curve; channel, in Warnings: warning"),
    ("m", "mark this place with a text, in the recording too"),
    ("s", "save the result so far as JSON, curve as SVG"),
    ("w", "warm-up over: exclude everything so far"),
    ("r", "start over: discard everything so far"),
    ("Ctrl-Z", "suspend; nothing is read until fg"),
    ("o  n p", "several sources: the list, next, previous"),
    ("space  > <", "replay: pause or resume, faster, slower"),
];

/// Behind the first of them stands what the bars mean, which the level of confidence is part of.
const MEANINGS: [(&str, &str); 16] = [
    ("σ(τ)", "deviation between averages over τ seconds"),
    ("↑ ↓", "the bar extends beyond the plot"),
    ("averages", "independent averages behind a point (edf)"),
    ("N", "ARW, VRW: white noise, σ falls as 1/√τ"),
    ("B", "bias instability: flat minimum of σ"),
    ("K", "random walk of the bias: σ rises as √τ"),
    ("≤", "upper bound: not detected, may be zero"),
    ("not observable", "the record is too short"),
    ("not measurable", "the message does not carry it"),
    ("own N", "the sensor's own N, without aliasing"),
    ("data sheet", "the data sheet, as this stream shows it"),
    ("ppm", "clock offset: measured over nominal rate"),
    ("intervals", "ms between sentences: median, 99 % of them"),
    ("baud %", "share of the baud rate that is in use"),
    ("rejected", "damaged sentences: checksum, fields"),
    ("dropped", "samples that never arrived, or rejected"),
];

const KEY_COLUMNS: u16 = 62;

/// Columns from which on the meanings stand beside the keys.
const SIDE_BY_SIDE: u16 = 116;

pub(crate) fn draw_help(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, page: usize) {
    let page_line = scene.state.page.as_ref().map(|page| Line::raw(format!(" live page: {page} ")));
    let block = page_line.into_iter().fold(Block::new().borders(Borders::ALL), Block::title_bottom);
    let inner = block.inner(area);
    // no more digits than are useful, and no rounding to 100 %
    let percent = (1e5 * scene.source.result.confidence).round() / 1e3;
    let bars = format!("{percent} % confidence interval");
    let meanings = [&MEANINGS[..1], &[("bars, ±", bars.as_str())], &MEANINGS[1..]].concat();
    let keys = |width| lines(&KEYS, 16, Style::new(), scene.theme, width);
    let meanings = |width| lines(&meanings, 14, scene.theme.faint(), scene.theme, width);
    let height = usize::from(inner.height);
    let [left, right] = Layout::horizontal([Constraint::Length(KEY_COLUMNS), Constraint::Fill(1)]).areas(inner);
    if inner.width >= SIDE_BY_SIDE && height >= keys(left.width).len().max(meanings(right.width).len()) {
        frame.render_widget(block.title(" Keys and symbols "), area);
        frame.render_widget(Paragraph::new(keys(left.width)), left);
        frame.render_widget(Paragraph::new(meanings(right.width)), right);
        return;
    }
    let (keys, meanings) = (keys(inner.width), meanings(inner.width));
    let pages: Vec<&[Line<'_>]> = keys.chunks(height).chain(meanings.chunks(height)).collect();
    let page = page % pages.len();
    let of_keys = page < keys.len().div_ceil(height);
    let subject = if of_keys { "Keys" } else { "Symbols" };
    let title = format!(" {subject}: page {} of {}, → next page ", page + 1, pages.len());
    frame.render_widget(block.title(title), area);
    frame.render_widget(Paragraph::new(pages[page].to_vec()), inner);
}

/// A sign and its text; what is too long for a line continues below its beginning.
fn lines(rows: &[(&str, &str)], columns: usize, style: Style, theme: Theme, width: u16) -> Vec<Line<'static>> {
    let room = usize::from(width).saturating_sub(columns + 2).max(10);
    let line = |(sign, text): &(&str, &str)| {
        let (sign, text) = (theme.spelled(*sign), theme.spelled(*text));
        let parts: Vec<String> = textwrap::wrap(&text, room).into_iter().map(Into::into).collect();
        let signs = std::iter::once(sign).chain(std::iter::repeat(String::new()));
        let parts = parts.into_iter().zip(signs).map(|(part, sign)| {
            let sign = Span::styled(format!(" {sign:<columns$} "), Style::new().add_modifier(Modifier::BOLD));
            Line::from(vec![sign, Span::styled(part, style)])
        });
        parts.collect::<Vec<_>>()
    };
    rows.iter().flat_map(line).collect()
}
