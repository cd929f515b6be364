//! Every key, and what the signs mean.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    text::{Line, Span},
    widgets::{Block, Borders, Paragraph},
};

use super::draw::Scene;

const KEYS: [(&str, &str); 21] = [
    ("q  Ctrl-C", "quit: the result is printed"),
    ("Q", "quit, and keep this screen above the result"),
    ("?", "this help; any key closes it"),
    ("tab shift-tab", "next panel, the one before"),
    ("e enter  esc", "the panel alone, and back"),
    ("1 - 9", "sensor: gyro, accel, mag, orientation"),
    ("x y z  a", "one axis large with its model; all axes"),
    ("up down  k j", "channel before, next; in Warnings: warning"),
    ("left right  h l", "cursor on the curve; home, end"),
    ("= -", "zoom around the cursor; in Signal: in time"),
    ("u", "next units of N, B, K and the curve"),
    ("f", "freeze the view; measuring goes on"),
    ("s", "save what is known as JSON and SVG, here"),
    ("w", "warm-up is over: leave out what came so far"),
    ("r", "start over, as if attached now"),
    ("Ctrl-Z", "to the shell; nothing is read until fg"),
    ("o  n p", "several sources: overview, next, before"),
    ("space  .", "replay: pause, go on; a second of data more"),
    ("> <", "replay: faster, slower"),
    ("g  [ ]", "replay: go to a percentage; a tenth back, on"),
    ("mouse", "click panels, points, the replay bar; wheel"),
];

const MEANINGS: [&str; 8] = [
    "σ(τ): how much means over τ seconds differ.",
    "Bars and ± hold the truth with 95 %, unless",
    "--confidence says other. ↑ ↓: a bar goes on.",
    "N white noise, B bias instability, K random walk.",
    "≤: at most. not yet seen: too short a record.",
    "not in stream: the message does not carry it.",
    "fit p: chance of a worse fit if the model holds.",
    "! a warning: tab to Warnings reads it in full.",
];

pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let block = Block::new().borders(Borders::ALL).title(" Keys ");
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let keys: Vec<_> = (KEYS.iter())
        .map(|(key, does)| {
            Line::from(vec![Span::raw(format!(" {key:<16}")).style(ratatui::style::Modifier::BOLD), Span::raw(*does)])
        })
        .collect();
    let meanings: Vec<_> = MEANINGS.iter().map(|text| Line::styled(format!(" {text}"), scene.theme.faint())).collect();
    if inner.width >= 116 || inner.height < 21 {
        let [left, right] = Layout::horizontal([Constraint::Length(66), Constraint::Fill(1)]).areas(inner);
        frame.render_widget(Paragraph::new(keys), left);
        frame.render_widget(Paragraph::new(meanings), right);
    } else {
        let [above, below] = Layout::vertical([Constraint::Length(22), Constraint::Fill(1)]).areas(inner);
        frame.render_widget(Paragraph::new(keys), above);
        frame.render_widget(Paragraph::new(meanings), below);
    }
}
