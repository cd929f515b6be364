//! What would be written to the terminal while the view has it.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, PoisonError},
};

use vn100_report::printable;

/// Messages that are kept until the end; the oldest are dropped first.
const MOST_MESSAGES: usize = 100;

/// What would be written to the terminal: shown in the view, and written when that is over.
#[derive(Debug, Clone, Default)]
pub struct MessageQueue {
    messages: Arc<Mutex<Messages>>,
}

#[derive(Debug, Default)]
struct Messages {
    all: VecDeque<String>,
    seen: bool,
    /// Written at the end alone.
    last: Option<String>,
}

impl MessageQueue {
    /// Appends a message.
    pub fn push(&self, message: String) {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        if messages.all.len() == MOST_MESSAGES {
            messages.all.pop_front();
        }
        messages.all.push_back(message);
        messages.seen = false;
    }

    /// Sets the message that is written after all others.
    pub(super) fn keep(&self, last: Option<String>) {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner).last = last;
    }

    /// The latest, if it was not taken here before.
    pub(crate) fn news(&self) -> Option<String> {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        let seen = std::mem::replace(&mut messages.seen, true);
        if seen { None } else { messages.all.back().map(|message| printable(message)) }
    }

    /// All that are kept, the oldest first; none is left.
    #[must_use]
    pub fn take(&self) -> Vec<String> {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        let last = messages.last.take();
        messages.all.drain(..).chain(last).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_news_once_and_kept_until_it_is_taken() {
        let queue = MessageQueue::default();
        assert_eq!(queue.news(), None);
        queue.push("one".into());
        queue.push("two".into());
        assert_eq!((queue.news().as_deref(), queue.news()), (Some("two"), None));
        queue.push("three".into());
        queue.keep(Some("last".into()));
        assert_eq!((queue.news().as_deref(), queue.news()), (Some("three"), None));
        assert_eq!(queue.take(), ["one", "two", "three", "last"]);
        assert!(queue.take().is_empty());
    }
}
