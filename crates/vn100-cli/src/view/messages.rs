//! Messages for the user while the view has the terminal.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, PoisonError},
};

use vn100_report::printable;

/// Messages that are kept until the end; the oldest are dropped first.
const MOST_MESSAGES: usize = 100;

/// What would be written to the terminal if it were free: shown in the view, and written when that
/// is over.
#[derive(Debug, Clone, Default)]
pub(crate) struct MessageQueue {
    messages: Arc<Mutex<Messages>>,
}

#[derive(Debug, Default)]
struct Messages {
    all: VecDeque<String>,
    seen: bool,
}

impl MessageQueue {
    /// Adds one.
    pub(crate) fn push(&self, message: String) {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        if messages.all.len() == MOST_MESSAGES {
            messages.all.pop_front();
        }
        messages.all.push_back(message);
        messages.seen = false;
    }

    /// The latest, if it was not taken here before.
    pub(crate) fn news(&self) -> Option<String> {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        let seen = std::mem::replace(&mut messages.seen, true);
        if seen { None } else { messages.all.back().map(|message| printable(message)) }
    }

    /// All, to be written down.
    pub(crate) fn take(&self) -> Vec<String> {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        messages.all.drain(..).collect()
    }
}
