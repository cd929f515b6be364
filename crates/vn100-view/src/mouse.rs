//! What the mouse points at.

use ratatui::{
    crossterm::event::{MouseButton, MouseEvent, MouseEventKind},
    layout::Position,
};
use vn100_pipeline::Command;

use crate::{
    scene::Regions,
    source::SourceView,
    state::{Panel, ViewRequest, ViewState, step},
};

pub(crate) fn mouse(
    event: MouseEvent,
    state: &mut ViewState,
    regions: &Regions,
    sources: &[SourceView],
) -> Option<ViewRequest> {
    let at = Position::new(event.column, event.row);
    let source = sources.get(state.source)?;
    if state.is_too_small || state.help.is_some() || state.question.is_some() {
        return None;
    }
    match event.kind {
        MouseEventKind::Down(MouseButton::Left) => {
            if regions.progress.contains(at) {
                let part = f64::from(at.x - regions.progress.x) / f64::from(regions.progress.width.max(1));
                return source.progress().map(|_| ViewRequest::Control(Command::GoTo(part)));
            }
            let panels = regions.tabs.iter().chain(&regions.panels);
            if let Some((_, panel)) = panels.clone().find(|(area, _)| area.contains(at)) {
                state.panel = *panel;
            }
            if let Some((_, sensor)) = regions.sensors.iter().find(|(area, _)| area.contains(at)) {
                state.sensor = *sensor;
            }
            let statistics = regions.panels.iter().find(|(_, panel)| *panel == Panel::Statistics);
            if let Some((_, channel)) = regions.channels.iter().find(|(row, _)| *row == at.y)
                && statistics.is_some_and(|(area, _)| area.contains(at))
            {
                state.choose_channel(*channel, source);
            }
            if regions.chart.contains(at) {
                let nearest = regions.octaves.iter().min_by_key(|(column, _)| column.abs_diff(at.x));
                state.cursor = nearest.map(|(_, octave)| *octave);
            }
        }
        MouseEventKind::ScrollUp | MouseEventKind::ScrollDown => {
            let down = event.kind == MouseEventKind::ScrollDown;
            if state.panel == Panel::Warnings {
                state.warning = step(state.warning, down, source.findings());
            } else {
                let octaves = regions.octaves.len();
                state.cursor = Some(step(state.octave(octaves).unwrap_or(0), down, octaves));
            }
        }
        _ => {}
    }
    None
}
