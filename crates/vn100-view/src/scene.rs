//! What is drawn, and the frame of a panel.

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
    let chosen = scene.state.panel == panel;
    let title = format!(" {title} ");
    let title = if chosen { Span::raw(title).style(Modifier::BOLD) } else { Span::raw(title) };
    let border = if chosen { Style::new() } else { scene.theme.faint() };
    let block = Block::new().borders(Borders::ALL).border_style(border).title(title);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    inner
}
