//! What would be written to the terminal while the view has it.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use vn100_report::printable;

/// Messages that are kept until the end; the oldest are dropped first.
const MOST_MESSAGES: usize = 100;

/// How long a message takes the place of the keys; a later one may follow after the shorter time.
const SHOWN_FOR: Duration = Duration::from_secs(6);
const SHOWN_FOR_AT_LEAST: Duration = Duration::from_millis(1500);

/// At most this many of the latest messages are shown one after the other; older ones are skipped.
const MOST_NEWS: usize = 3;

/// What would be written to the terminal: shown in the view, and written when that is over.
#[derive(Debug, Clone, Default)]
pub struct MessageQueue {
    messages: Arc<Mutex<Messages>>,
}

#[derive(Debug, Default)]
struct Messages {
    all: VecDeque<String>,
    /// The number of messages at the end that were not shown yet.
    unseen: usize,
}

impl MessageQueue {
    /// Appends a message.
    pub fn push(&self, message: String) {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        if messages.all.len() == MOST_MESSAGES {
            messages.all.pop_front();
        }
        messages.all.push_back(message);
        messages.unseen = (messages.unseen + 1).min(MOST_NEWS);
    }

    /// The next of the latest messages that was not taken here before.
    pub(crate) fn news(&self) -> Option<String> {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        let next = messages.all.len().checked_sub(messages.unseen)?;
        let message = messages.all.get(next).map(|message| printable(message))?;
        messages.unseen -= 1;
        Some(message)
    }

    /// All that are kept, the oldest first; none is left.
    pub fn take(&self) -> Vec<String> {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        messages.unseen = 0;
        messages.all.drain(..).collect()
    }
}

/// The message on the screen, and since when it is there.
#[derive(Debug, Default)]
pub(crate) struct ShownMessage(Option<(String, Instant)>);

impl ShownMessage {
    /// Whether the next message may take the place of the one on the screen.
    pub(crate) fn may_be_followed(&self, now: Instant) -> bool {
        self.0.as_ref().is_none_or(|(_, since)| now.duration_since(*since) >= SHOWN_FOR_AT_LEAST)
    }

    /// Whether the message on the screen has been there for long enough. Another message, or the
    /// same one after a time without it, begins its own time.
    pub(crate) fn is_over(&mut self, message: Option<&str>, now: Instant) -> bool {
        let since = self.0.take().filter(|(shown, _)| Some(shown.as_str()) == message).map(|(_, since)| since);
        self.0 = message.map(|message| (message.to_owned(), since.unwrap_or(now)));
        since.is_some_and(|since| now.duration_since(since) > SHOWN_FOR)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_message_has_its_own_time() {
        let start = Instant::now();
        let mut shown = ShownMessage::default();
        let mut is_over = |message, second| shown.is_over(message, start + Duration::from_secs(second));
        assert!(!is_over(None, 0) && !is_over(Some("one"), 1) && !is_over(Some("one"), 7));
        assert!(!is_over(Some("two"), 8) && !is_over(Some("two"), 14));
        assert!(is_over(Some("two"), 15));
        assert!(!is_over(None, 16) && !is_over(Some("two"), 17) && !is_over(Some("two"), 23));
    }

    #[test]
    fn the_next_message_waits_until_the_one_before_can_be_read() {
        let start = Instant::now();
        let mut shown = ShownMessage::default();
        assert!(shown.may_be_followed(start));
        shown.is_over(Some("one"), start);
        assert!(!shown.may_be_followed(start + Duration::from_secs(1)));
        assert!(shown.may_be_followed(start + Duration::from_millis(1500)));
    }

    #[test]
    fn a_message_is_news_once_and_kept_until_it_is_taken() {
        let queue = MessageQueue::default();
        assert_eq!(queue.news(), None);
        let news = |messages: &[&str]| {
            messages.iter().for_each(|message| queue.push((*message).into()));
            let mut news = Vec::new();
            while let Some(message) = queue.news() {
                news.push(message);
            }
            news
        };
        assert_eq!(news(&["one", "two"]), ["one", "two"]);
        assert_eq!(news(&["three", "four", "five", "six"]), ["four", "five", "six"]);
        queue.push("seven".into());
        assert_eq!(queue.take(), ["one", "two", "three", "four", "five", "six", "seven"]);
        assert_eq!((queue.news(), queue.take().len()), (None, 0));
    }
}
