//! Whether the terminal is dark or light: what it answers to a query (OSC 11), without waiting for
//! the answer. That arrives among the keys, and is taken out of them.

use std::time::{Duration, Instant};

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Background {
    Dark,
    Light,
}

/// Asks the terminal for the colour of its background; one that does not know the query ignores it.
pub(crate) const QUERY: &str = "\x1b]11;?\x07";

/// An answer comes within this time, over a slow connection too, or not at all.
const ANSWERED_WITHIN: Duration = Duration::from_secs(60);

/// What an answer begins with.
const BEGIN: &str = "11;";

/// Longer than any answer.
const MOST_SIGNS: usize = 40;

impl Background {
    /// By the variable that some terminals set, such as `15;0`: the last number is the background,
    /// of the sixteen colours.
    pub(crate) fn of_variable(text: &str) -> Option<Self> {
        let colour: u8 = text.rsplit(';').next()?.parse().ok()?;
        Some(if matches!(colour, 7 | 9..=15) { Self::Light } else { Self::Dark })
    }

    /// By an answer such as `11;rgb:ffff/fafa/f0f0`.
    fn of_answer(text: &str) -> Option<Self> {
        let (_, colour) = text.strip_prefix(BEGIN)?.split_once(':')?;
        let part = |text: &str| {
            let most = 16_f64.powi(i32::try_from(text.len()).ok()?) - 1.0;
            Some(f64::from(u32::from_str_radix(text, 16).ok()?) / most)
        };
        let parts: Vec<f64> = colour.split('/').take(3).map(part).collect::<Option<_>>()?;
        let [red, green, blue] = parts[..] else { return None };
        let light = 0.299 * red + 0.587 * green + 0.114 * blue;
        Some(if light > 0.5 { Self::Light } else { Self::Dark })
    }
}

/// Takes the answer to the query out of the keys.
#[derive(Debug, Default)]
pub(crate) struct Answer {
    asked: Option<Instant>,
    /// What has come of it.
    begun: Option<String>,
}

#[derive(Debug, PartialEq, Eq)]
pub(crate) enum FromTerminal {
    /// The user's key.
    Key,
    /// A part of the answer.
    Part,
    /// The end of the answer; `None` if it names no colour.
    Whole(Option<Background>),
}

impl Answer {
    pub(crate) fn awaited(now: Instant) -> Self {
        Self { asked: Some(now), begun: None }
    }

    /// Whether it may still come.
    pub(crate) fn is_awaited(&self, now: Instant) -> bool {
        self.asked.is_some_and(|asked| now.duration_since(asked) < ANSWERED_WITHIN)
    }

    /// Whether it is awaited since less than this.
    pub(crate) fn is_young(&self, age: Duration) -> bool {
        self.asked.is_some_and(|asked| asked.elapsed() < age)
    }

    pub(crate) fn take(&mut self, key: &KeyEvent, now: Instant) -> FromTerminal {
        if !self.is_awaited(now) {
            return FromTerminal::Key;
        }
        let Some(begun) = &mut self.begun else {
            // ESC ]
            if key.code == KeyCode::Char(']') && key.modifiers.contains(KeyModifiers::ALT) {
                self.begun = Some(String::new());
                return FromTerminal::Part;
            }
            return FromTerminal::Key;
        };
        match key.code {
            // BEL, or ESC \
            KeyCode::Char('g' | 'G') if key.modifiers.contains(KeyModifiers::CONTROL) => {}
            KeyCode::Char('\\') if key.modifiers.contains(KeyModifiers::ALT) => {}
            // a key of the user's, with Alt, is followed by something else
            KeyCode::Char(sign) if begun.len() < BEGIN.len() && !BEGIN[begun.len()..].starts_with(sign) => {
                self.begun = None;
                return FromTerminal::Key;
            }
            KeyCode::Char(sign) if begun.len() < MOST_SIGNS => {
                begun.push(sign);
                return FromTerminal::Part;
            }
            _ => {}
        }
        let answer = Background::of_answer(begun);
        *self = Self::default();
        FromTerminal::Whole(answer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes as they are read: a key each, the one behind ESC with Alt.
    fn keys(bytes: &str) -> Vec<KeyEvent> {
        let mut alt = false;
        let mut keys = Vec::new();
        for sign in bytes.chars() {
            if sign == '\x1b' {
                alt = true;
                continue;
            }
            let modifiers = if alt { KeyModifiers::ALT } else { KeyModifiers::NONE };
            alt = false;
            keys.push(match sign {
                '\x07' => KeyEvent::new(KeyCode::Char('g'), KeyModifiers::CONTROL),
                sign => KeyEvent::new(KeyCode::Char(sign), modifiers),
            });
        }
        keys
    }

    fn taken(bytes: &str, after: Duration) -> (String, Option<Background>) {
        let asked = Instant::now();
        let mut answer = Answer::awaited(asked);
        let (mut left, mut background) = (String::new(), None);
        for key in keys(bytes) {
            match answer.take(&key, asked + after) {
                FromTerminal::Key => left.extend(key.code.as_char()),
                FromTerminal::Part => {}
                FromTerminal::Whole(found) => background = found,
            }
        }
        (left, background)
    }

    #[test]
    fn an_answer_leaves_no_key_and_the_keys_around_it_stay() {
        for (bytes, left, background) in [
            ("\x1b]11;rgb:ffff/fafa/f0f0\x07", "", Some(Background::Light)),
            ("\x1b]11;rgb:0000/2b2b/3636\x1b\\", "", Some(Background::Dark)),
            ("u\x1b]11;rgb:1e/1e/1e\x07!", "u!", Some(Background::Dark)),
            ("\x1b]11;rgba:ffff/ffff/ffff/ffff\x07", "", Some(Background::Light)),
            ("\x1b]11;none\x07x", "x", None),
            ("]q", "]q", None),
        ] {
            assert_eq!(taken(bytes, Duration::from_millis(40)), (left.to_owned(), background), "{bytes:?}");
        }
        assert_eq!(taken("\x1b]", ANSWERED_WITHIN).0, "]", "nothing is awaited any more");
        let late = taken("\x1b]q\x1b]1u\x1b]11;rgb:ff/ff/ff\x07", Duration::from_secs(30));
        assert_eq!(late, ("qu".to_owned(), Some(Background::Light)), "keys with Alt are no answer");
        let endless = format!("\x1b]11;{}q", "1".repeat(MOST_SIGNS - 2));
        assert_eq!(taken(&endless, Duration::ZERO).0, "q");
    }

    #[test]
    fn the_variable_of_a_terminal_says_how_light_it_is() {
        for (text, background) in [
            ("15;0", Some(Background::Dark)),
            ("0;15", Some(Background::Light)),
            ("0;default;15", Some(Background::Light)),
            ("0;8", Some(Background::Dark)),
            ("default;default", None),
        ] {
            assert_eq!(Background::of_variable(text), background, "{text}");
        }
    }
}
