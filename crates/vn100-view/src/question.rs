//! What is asked before something is done, and the answers.

use ratatui::crossterm::event::KeyCode;
use vn100_session::Command;

use crate::{
    source::SourceView,
    state::{Question, ViewRequest, ViewState},
};

/// Of the text of a mark.
const MOST_SIGNS: usize = 120;

impl ViewState {
    /// Asks before what cannot be undone; if it has no effect, says why.
    pub(super) fn ask(&mut self, question: Question, sources: &[SourceView]) {
        match sources.get(self.source).and_then(SourceView::no_measurement) {
            Some(why) => self.message = Some(why.into()),
            None => self.question = Some(question),
        }
    }

    pub(super) fn answer(&mut self, question: Question, code: KeyCode) -> Option<ViewRequest> {
        let yes = matches!(code, KeyCode::Char('y' | 'Y') | KeyCode::Enter);
        match question {
            Question::StartOver => yes.then_some(ViewRequest::Control(Command::StartOver)),
            Question::EndWarmUp => yes.then_some(ViewRequest::Control(Command::EndWarmUp)),
            Question::Mark(mut typed) => {
                match code {
                    KeyCode::Char(sign) if !sign.is_control() && typed.chars().count() < MOST_SIGNS => typed.push(sign),
                    KeyCode::Backspace => drop(typed.pop()),
                    KeyCode::Enter if typed.trim().is_empty() => return None,
                    KeyCode::Enter => {
                        let text = typed.trim().to_owned();
                        self.message = Some(format!("marked: {text}"));
                        return Some(ViewRequest::Control(Command::Mark(text)));
                    }
                    KeyCode::Esc => return None,
                    _ => {}
                }
                self.question = Some(Question::Mark(typed));
                None
            }
        }
    }
}
