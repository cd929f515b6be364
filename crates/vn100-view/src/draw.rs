//! The screen from what is known: which panels it has at its size, and where. Draws plain data,
//! and waits for nothing.

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    style::Style,
    text::{Line, Span},
    widgets::{Paragraph, Wrap},
};

use vn100_report::{names::names_of, numbers::plain::grouped};

use crate::{
    keys,
    panels::{allan, channels, health, overview, parameters, spectrum, waiting, warnings},
    scene::Scene,
    state::Panel,
};

pub(crate) const LEAST: (u16, u16) = (60, 16);

/// From here on, all panels stand side by side.
const ALL_PANELS: (u16, u16) = (110, 34);

pub(crate) fn draw(frame: &mut Frame<'_>, scene: Scene<'_>) {
    let area = frame.area();
    if is_too_small((area.width, area.height)) {
        too_small(frame, area, scene);
    } else if let Some(page) = scene.state.help {
        keys::draw_help(frame, area, scene, page);
    } else if scene.state.overview {
        let [body, keys] = Layout::vertical([Constraint::Fill(1), Constraint::Length(1)]).areas(area);
        overview::draw(frame, body, scene);
        keys::draw_footer(frame, keys, scene);
    } else {
        one_source(frame, area, scene);
    }
    scene.theme.finish(frame.buffer_mut());
}

fn one_source(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let source = scene.source;
    let all = area.width >= ALL_PANELS.0 && area.height >= ALL_PANELS.1;
    let top_lines = warnings::TopLines::new(scene, area.width, if all { 4 } else { 2 });
    let goal_rows = health::goal_lines(scene, area.width).len() as u16;
    let head_rows = 3 + u16::from(source.playback.is_some()) + goal_rows;
    let [top, warned, tabs, body, keys] = Layout::vertical([
        Constraint::Length(head_rows),
        Constraint::Length(top_lines.rows()),
        Constraint::Length(1),
        Constraint::Fill(1),
        Constraint::Length(1),
    ])
    .areas(area);
    health::draw_header(frame, top, scene);
    top_lines.draw(frame, warned, scene);
    keys::draw_footer(frame, keys, scene);
    if source.result.timing.samples == 0 {
        waiting::draw_waiting(frame, tabs.union(body), scene);
        return;
    }
    draw_tabs(frame, tabs, scene, all && !scene.state.expanded);
    if !all || scene.state.expanded {
        panel(frame, body, scene, scene.state.panel, true);
        return;
    }
    let [upper, lower] = Layout::vertical([Constraint::Fill(3), Constraint::Fill(2)]).areas(body);
    let lower_rows = (source.result.channels.len() as u16 + 3).max(lower.height).min(body.height / 2);
    let [upper, lower] =
        Layout::vertical([Constraint::Fill(1), Constraint::Length(lower_rows)]).areas(upper.union(lower));
    let right = (area.width * 2 / 5).clamp(parameters::WIDTH, 70);
    let columns = [Constraint::Fill(1), Constraint::Length(right)];
    let [allan, noise] = Layout::horizontal(columns).areas(upper);
    // a warning is read where the signal is otherwise; the signal leaves some columns to the sparklines
    let warned = scene.state.panel == Panel::Warnings;
    let right = if warned { right } else { right.min((area.width * 2 / 5).max(channels::SIGNAL_WIDTH)) };
    let [statistics, signal] = Layout::horizontal([Constraint::Fill(1), Constraint::Length(right)]).areas(lower);
    panel(frame, allan, scene, Panel::Allan, false);
    panel(frame, noise, scene, Panel::Parameters, false);
    panel(frame, statistics, scene, Panel::Statistics, false);
    panel(frame, signal, scene, if warned { Panel::Warnings } else { Panel::Signal }, false);
}

fn panel(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, panel: Panel, alone: bool) {
    match panel {
        Panel::Allan if scene.state.shows_spectrum => spectrum::draw(frame, area, scene),
        Panel::Allan => allan::draw(frame, area, scene, alone),
        Panel::Parameters => parameters::draw(frame, area, scene),
        Panel::Statistics => channels::draw_statistics(frame, area, scene),
        Panel::Signal => channels::draw_signal(frame, area, scene),
        Panel::Warnings => warnings::draw_panel(frame, area, scene),
    }
}

/// Columns of the names of all panels.
const PANEL_TABS: usize = 40;

/// The sensors by their numbers, and the panels unless all of them are there.
fn draw_tabs(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, all: bool) {
    let Scene { state, source, theme, .. } = scene;
    let mut spans = Vec::new();
    let mut tab = |text: String, style: Style| spans.push(Span::raw(text).style(style));
    let style = |chosen: bool| if chosen { theme.chosen() } else { Style::new() };
    let groups = source.groups();
    let names = groups.iter().map(|group| names_of(group.quantity).short.len() + 4).sum::<usize>();
    let is_narrow = !all && usize::from(area.width) < names + PANEL_TABS;
    if !all {
        for panel in Panel::ALL {
            let text = match panel {
                Panel::Warnings if is_narrow => "Warn ".into(),
                _ if is_narrow => format!("{} ", panel.name()),
                _ => format!(" {} ", panel.name()),
            };
            tab(text, style(panel == state.panel));
        }
        tab("│".into(), theme.faint());
    }
    for (place, group) in groups.iter().enumerate() {
        let name = names_of(group.quantity).short;
        let text = match is_narrow {
            false => format!(" {} {name} ", place + 1),
            true if place == state.sensor => format!(" {} {name}", place + 1),
            true => format!(" {}", place + 1),
        };
        tab(text, style(place == state.sensor));
    }
    frame.render_widget(Paragraph::new(Line::from(spans)), area);
}

/// Whether nothing but the size is shown.
pub(crate) fn is_too_small((width, height): (u16, u16)) -> bool {
    width < LEAST.0 || height < LEAST.1
}

fn too_small(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
    let under_way = match scene.source.playback {
        None => "the measurement continues",
        Some(playback) if playback.paused => "the replay is paused",
        Some(_) => "the replay continues",
    };
    let lines = vec![
        Line::raw(format!("{}x{} is too small", area.width, area.height)).style(scene.theme.warning()),
        Line::raw(format!("the view needs {}x{}", LEAST.0, LEAST.1)),
        Line::raw(scene.source.no_measurement().unwrap_or(under_way)),
        Line::raw(format!("{} samples", grouped(scene.source.result.timing.samples))),
        Line::raw("q quits"),
    ];
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: true }), area);
}
