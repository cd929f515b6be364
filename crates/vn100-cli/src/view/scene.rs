//! What every panel is drawn from, the frame around it, and the regions that a mouse may point at.

use ratatui::{
    layout::Rect,
    style::{Modifier, Style},
    text::Span,
    widgets::{Block, Borders},
};

use super::{
    source::Source,
    state::{Panel, State},
    theme::Theme,
};

/// Where on the screen what a mouse may point at is.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Regions {
    pub(crate) panels: Vec<(Rect, Panel)>,
    pub(crate) tabs: Vec<(Rect, Panel)>,
    /// Names of the sensors, by their places.
    pub(crate) sensors: Vec<(Rect, usize)>,
    /// Columns of the octaves of the curve, and the rows they stand in.
    pub(crate) octaves: Vec<(u16, usize)>,
    pub(crate) chart: Rect,
    /// Rows of the channels, by their places.
    pub(crate) channels: Vec<(u16, usize)>,
    /// The progress bar of a replay.
    pub(crate) progress: Rect,
}

/// What everything is drawn from.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) state: &'a State,
    pub(crate) sources: &'a [Source],
    pub(crate) theme: Theme,
}

impl<'a> Scene<'a> {
    /// The source shown.
    pub(crate) fn source(self) -> Option<&'a Source> {
        self.sources.get(self.state.source)
    }
}

/// A frame with a title, that of the panel chosen brighter.
pub(crate) fn framed(scene: Scene<'_>, panel: Panel, title: String) -> Block<'static> {
    let chosen = scene.state.panel == panel;
    let title = format!(" {title} ");
    let title = if chosen { Span::raw(title).style(Modifier::BOLD) } else { Span::raw(title) };
    let border = if chosen { Style::new() } else { scene.theme.faint() };
    Block::new().borders(Borders::ALL).border_style(border).title(title)
}
