//! What is drawn, and where on the screen it is.

use ratatui::{
    Frame,
    layout::Rect,
    style::{Modifier, Style},
    text::Span,
    widgets::{Block, Borders},
};

use crate::{
    source::SourceView,
    state::{Panel, ViewState},
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
    pub(crate) progress: Rect,
    pub(crate) is_too_small: bool,
}

#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) state: &'a ViewState,
    pub(crate) sources: &'a [SourceView],
    /// The one of them that is shown, or chosen.
    pub(crate) source: &'a SourceView,
    pub(crate) theme: Theme,
}

/// Draws a frame with a title, that of the panel chosen brighter; gives the place within.
pub(crate) fn framed(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, panel: Panel, title: String) -> Rect {
    framed_as(frame, area, scene, scene.state.panel == panel, title)
}

/// The same for a panel that is chosen, or not.
pub(crate) fn framed_as(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, chosen: bool, title: String) -> Rect {
    let title = format!(" {title} ");
    let title = if chosen { Span::raw(title).style(Modifier::BOLD) } else { Span::raw(title) };
    let border = if chosen { Style::new() } else { scene.theme.faint() };
    let block = Block::new().borders(Borders::ALL).border_style(border).title(title);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    inner
}
