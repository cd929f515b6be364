//! The last line: a question that waits for its answer, what was done last, or the keys.

use ratatui::{
    Frame,
    layout::Rect,
    text::{Line, Span},
    widgets::Paragraph,
};

use super::{
    header::LEAST_NAME,
    scene::Scene,
    state::{Panel, Question},
    warnings::shortened,
};
use vn100_pipeline::Playback;

pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>) {
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
        spans.push(Span::raw(format!(" {key}")).style(ratatui::style::Modifier::BOLD));
        spans.push(Span::styled(format!(" {does} "), theme.faint()));
    }
    frame.render_widget(Paragraph::new(Line::from(spans)), area);
}

/// A question, with the source it is about where there are several.
fn of_source(scene: Scene<'_>, width: u16, question: &str) -> String {
    let Some(source) = scene.source().filter(|_| scene.sources.len() > 1) else { return format!(" {question}") };
    let before = format!(" {} ", scene.state.source + 1);
    let beside = before.len() + ": ".len() + question.len();
    let name = shortened(&source.name, usize::from(width).saturating_sub(beside).max(LEAST_NAME));
    format!("{before}{name}: {question}")
}

/// The keys that do something now, the most used first.
fn keys(scene: Scene<'_>) -> Vec<(&'static str, &'static str)> {
    let state = scene.state;
    if state.overview {
        return vec![("q", "quit"), ("?", "help"), ("↑↓", "choose"), ("enter", "open"), ("f", "freeze"), ("s", "save")];
    }
    let replay = scene.source().and_then(|source| source.playback).map_or(Vec::new(), |playback| {
        let Playback { at_end, paused, .. } = playback;
        let space = (!at_end).then_some(("space", if paused { "go on" } else { "pause" }));
        space.into_iter().chain([("<>", "speed"), ("[]", "seek"), ("g", "go to %")]).collect()
    });
    if scene.source().is_some_and(|source| source.snapshot.timing.samples == 0) {
        let mut keys = vec![("q", "quit"), ("?", "help")];
        keys.extend(replay);
        if scene.sources.len() > 1 {
            keys.extend([("o", "overview"), ("n p", "source")]);
        }
        return keys;
    }
    let mut keys = vec![("q", "quit"), ("?", "help"), ("tab", "panel"), ("1-4", "sensor"), ("xyz a", "axis")];
    keys.extend(replay);
    if scene.sources.len() > 1 {
        keys.extend([("o", "overview"), ("n p", "source")]);
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
