//! What is shown and selected, and how keys change it. Pure: input in, requests out.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use vn100_analysis::{ChannelResult, Point};
use vn100_session::Command;

use crate::source::{ChannelGroup, SourceView};

/// A part of the screen that may have it to itself.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Panel {
    #[default]
    Allan,
    Parameters,
    Statistics,
    Signal,
    Warnings,
}

impl Panel {
    pub(crate) const ALL: [Self; 5] = [Self::Allan, Self::Parameters, Self::Statistics, Self::Signal, Self::Warnings];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Allan => "Allan",
            Self::Parameters => "Noise",
            Self::Statistics => "Stats",
            Self::Signal => "Signal",
            Self::Warnings => "Warnings",
        }
    }
}

/// What the view asks of the program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ViewRequest {
    /// End the measurement.
    Quit,
    /// Give the terminal back to the shell for a while.
    Suspend,
    Save,
    /// Do something to the source shown.
    Control(Command),
}

/// What is asked before it is done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Question {
    StartOver,
    EndWarmUp,
    /// What is to be said of this place, as typed so far.
    Mark(String),
}

#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct ViewState {
    pub(crate) overview: bool,
    /// The source shown, or chosen among all.
    pub(crate) source: usize,
    pub(crate) panel: Panel,
    pub(crate) expanded: bool,
    /// Place among the sensors of the source.
    pub(crate) sensor: usize,
    /// The axis that is shown alone; `None` for all of them.
    pub(crate) axis: Option<usize>,
    /// Whether the panel of curves has the spectrum in place of the deviation.
    pub(crate) shows_spectrum: bool,
    /// The octave that is read out; `None` for the last that has an interval.
    pub(crate) cursor: Option<usize>,
    /// The page of the help, if that is shown.
    pub(crate) help: Option<usize>,
    pub(crate) question: Option<Question>,
    pub(crate) warning: usize,
    /// Nothing but the size is shown: keys change nothing that cannot be seen.
    pub(crate) is_too_small: bool,
    /// What was done last, until the next key.
    pub(crate) message: Option<String>,
    /// The address of the live page, while there is one.
    pub(crate) page: Option<String>,
}

/// Rows of the list that a page is.
const PAGE: isize = 10;

impl ViewState {
    pub(crate) fn new(sources: usize) -> Self {
        Self { overview: sources > 1, ..Self::default() }
    }

    /// The sensor shown, of those the source has.
    pub(crate) fn group(&self, source: &SourceView) -> Option<ChannelGroup> {
        let mut groups = source.groups();
        (!groups.is_empty()).then(|| groups.swap_remove(self.sensor.min(groups.len() - 1)))
    }

    /// The place of the one channel that is shown alone: the first where all axes are.
    pub(crate) fn channel(&self, source: &SourceView) -> Option<usize> {
        let group = self.group(source)?;
        group.channels.get(self.axis.unwrap_or(0).min(group.channels.len() - 1)).copied()
    }

    /// The axes of a sensor whose curves are shown: their places among its axes, and their channels.
    pub(crate) fn shown<'a>(
        &self,
        source: &'a SourceView,
        group: &ChannelGroup,
    ) -> (Vec<usize>, Vec<&'a ChannelResult>) {
        let is_shown = |axis: usize| self.axis.is_none_or(|one| one == axis);
        let shown = group.channels.iter().enumerate().filter(|(axis, _)| is_shown(*axis));
        shown.map(|(axis, place)| (axis, &source.result.channels[*place])).unzip()
    }

    /// The octave of these that is read out: unless one was chosen, the last that has an interval.
    pub(crate) fn octave(&self, octaves: &[Point]) -> Option<usize> {
        let last = octaves.len().checked_sub(1)?;
        let known = || octaves.iter().rposition(Point::is_known).unwrap_or(last);
        Some(self.cursor.map_or_else(known, |cursor| cursor.min(last)))
    }

    pub(crate) fn key(&mut self, key: KeyEvent, sources: &[SourceView]) -> Option<ViewRequest> {
        self.message = None;
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        match key.code {
            KeyCode::Char('c') if control => return Some(ViewRequest::Quit),
            KeyCode::Char('z') if control => return Some(ViewRequest::Suspend),
            _ if control => return None,
            KeyCode::Char('q') if self.is_too_small => return Some(ViewRequest::Quit),
            _ if self.is_too_small => return None,
            _ => {}
        }
        if let Some(question) = self.question.take() {
            return self.answer(question, key.code);
        }
        if let Some(page) = self.help.take() {
            self.help = match key.code {
                KeyCode::Right | KeyCode::Down | KeyCode::PageDown | KeyCode::Tab | KeyCode::Char('?' | ' ') => {
                    Some(page + 1)
                }
                KeyCode::Left | KeyCode::Up | KeyCode::PageUp | KeyCode::BackTab => Some(page.saturating_sub(1)),
                KeyCode::Home => Some(0),
                _ => None,
            };
            // any other key closes it; the one that ends the program also does that
            if key.code != KeyCode::Char('q') {
                return None;
            }
        }
        match key.code {
            KeyCode::Char('q') => return Some(ViewRequest::Quit),
            KeyCode::Char('?') | KeyCode::F(1) => self.help = Some(0),
            KeyCode::Char('s') => return Some(ViewRequest::Save),
            KeyCode::Char('o') if sources.len() > 1 => self.overview = !self.overview,
            KeyCode::Char('n') => self.source = (self.source + 1) % sources.len().max(1),
            KeyCode::Char('p') => self.source = (self.source + sources.len().max(1) - 1) % sources.len().max(1),
            KeyCode::Char('w') => self.ask(Question::EndWarmUp, sources),
            KeyCode::Char('r') => self.ask(Question::StartOver, sources),
            _ if self.overview => self.key_of_overview(key.code, sources),
            code => return self.key_of_source(code, sources.get(self.source)?),
        }
        None
    }

    fn key_of_overview(&mut self, code: KeyCode, sources: &[SourceView]) {
        match code {
            KeyCode::Enter | KeyCode::Char('e') => self.overview = false,
            KeyCode::Up => self.step_row(-1, sources),
            KeyCode::Down => self.step_row(1, sources),
            KeyCode::PageUp => self.step_row(-PAGE, sources),
            KeyCode::PageDown => self.step_row(PAGE, sources),
            KeyCode::Home => self.step_row(isize::MIN, sources),
            KeyCode::End => self.step_row(isize::MAX, sources),
            KeyCode::Char(digit @ '1'..='9') => {
                let source = digit as usize - '1' as usize;
                if source < sources.len() {
                    (self.source, self.overview) = (source, false);
                }
            }
            _ => {}
        }
    }

    /// So many rows down in the list, no further than its ends.
    fn step_row(&mut self, rows: isize, sources: &[SourceView]) {
        self.source = self.source.saturating_add_signed(rows).min(sources.len().saturating_sub(1));
    }

    fn key_of_source(&mut self, code: KeyCode, source: &SourceView) -> Option<ViewRequest> {
        let replays = source.playback.is_some();
        let of_capture = |request| replays.then_some(ViewRequest::Control(request));
        match code {
            KeyCode::Tab => self.next_panel(1),
            KeyCode::BackTab => self.next_panel(Panel::ALL.len() - 1),
            // the gravest is why the key was pressed
            KeyCode::Char('!') => (self.panel, self.warning) = (Panel::Warnings, 0),
            KeyCode::Char('e') | KeyCode::Enter => self.expanded = !self.expanded,
            KeyCode::Esc => self.expanded = false,
            KeyCode::Char('m') if replays => self.message = Some("marks are set while a sensor is measured".into()),
            KeyCode::Char('m') => match source.no_measurement() {
                Some(why) => self.message = Some(why.into()),
                None => self.question = Some(Question::Mark(String::new())),
            },
            KeyCode::Char('a') => self.axis = None,
            KeyCode::Char('v') => (self.shows_spectrum, self.panel) = (!self.shows_spectrum, Panel::Allan),
            KeyCode::Char(axis @ 'x'..='z') => self.axis = Some(axis as usize - 'x' as usize),
            KeyCode::Char(digit @ '1'..='9') => self.choose_sensor(digit as usize - '1' as usize, source),
            KeyCode::Up => self.step_down(false, source),
            KeyCode::Down => self.step_down(true, source),
            KeyCode::Left => self.step_right(false, source),
            KeyCode::Right => self.step_right(true, source),
            KeyCode::Home => self.cursor = Some(0),
            KeyCode::End => self.cursor = None,
            KeyCode::Char(' ') => return of_capture(Command::TogglePause),
            KeyCode::Char('>') => return of_capture(Command::Faster),
            KeyCode::Char('<') => return of_capture(Command::Slower),
            _ => {}
        }
        None
    }

    fn next_panel(&mut self, steps: usize) {
        let place = Panel::ALL.iter().position(|panel| *panel == self.panel).unwrap_or(0);
        self.panel = Panel::ALL[(place + steps) % Panel::ALL.len()];
    }

    fn choose_sensor(&mut self, sensor: usize, source: &SourceView) {
        if sensor < source.groups().len() {
            self.sensor = sensor;
        }
    }

    /// To the next channel, sensor by sensor, or the next warning.
    fn step_down(&mut self, down: bool, source: &SourceView) {
        if self.panel == Panel::Warnings {
            self.warning = step(self.warning, down, source.findings());
            return;
        }
        let groups = source.groups();
        let axes: Vec<(usize, usize)> = (groups.iter().enumerate())
            .flat_map(|(sensor, group)| (0..group.channels.len()).map(move |axis| (sensor, axis)))
            .collect();
        let here = axes.iter().position(|place| *place == (self.sensor, self.axis.unwrap_or(0)));
        let next = match (here, self.axis) {
            // all axes of a sensor stand before its first
            (Some(here), None) if down => here,
            (Some(here), _) => step(here, down, axes.len()),
            (None, _) => 0,
        };
        if let Some((sensor, axis)) = axes.get(next) {
            (self.sensor, self.axis) = (*sensor, Some(*axis));
        }
    }

    fn step_right(&mut self, right: bool, source: &SourceView) {
        let octaves = self.channel(source).map_or(&[][..], |channel| &source.result.channels[channel].allan.points);
        if let Some(octave) = self.octave(octaves) {
            self.cursor = Some(step(octave, right, octaves.len()));
        }
    }
}

/// The next of `count` places, or the one before; no further than the ends.
fn step(place: usize, forward: bool, count: usize) -> usize {
    if forward { (place + 1).min(count.saturating_sub(1)) } else { place.saturating_sub(1) }
}
