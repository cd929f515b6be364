//! Makes foreign text printable: file names, captures and replies of a sensor may hold control
//! characters.

/// The text in one line, with a replacement mark for each character that controls a terminal.
pub fn printable(text: &str) -> String {
    text.chars().map(|c| if steers_terminal(c) { char::REPLACEMENT_CHARACTER } else { c }).collect()
}

/// The text, or as much of it as such a number of characters holds, with an ellipsis at its end.
pub fn shortened(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    text.chars().take(width.saturating_sub(1)).chain(['…']).collect()
}

/// A JSON document and a line end, with characters that control a terminal escaped, which changes no
/// content: serde_json leaves DEL, control characters above ASCII, and those that turn text round.
pub fn json_line(json: &str) -> String {
    let mut text = String::with_capacity(json.len() + 1);
    for c in json.chars() {
        // a line end separates the values of a document and is never within one
        if c != '\n' && steers_terminal(c) {
            // all of them are below U+10000
            text.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            text.push(c);
        }
    }
    text.push('\n');
    text
}

/// Whether a character controls a terminal or the direction of text, so that a name can look like
/// another: control characters, ends of lines and paragraphs, and Unicode's property Bidi_Control.
pub fn steers_terminal(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_do_not_reach_the_terminal() {
        assert_eq!(printable("a\x1b[2Jb\u{9b}c\nd"), "a\u{fffd}[2Jb\u{fffd}c\u{fffd}d");
    }

    #[test]
    fn a_name_cannot_be_turned_round_to_look_like_another() {
        assert_eq!(printable("night\u{202e}pacm.exe\u{2066}\u{200f}"), "night\u{fffd}pacm.exe\u{fffd}\u{fffd}");
        assert_eq!(printable("größe 夜 שלום"), "größe 夜 שלום");
    }

    #[test]
    fn a_document_in_json_means_the_same_without_control_characters() {
        let json = "{\n  \"name\": \"a\u{7f}b\u{9b}c\u{202e}d\"\n}";
        let line = json_line(json);
        assert_eq!(line, "{\n  \"name\": \"a\\u007fb\\u009bc\\u202ed\"\n}\n");
        let [before, after] = [json, &line].map(|text| serde_json::from_str::<serde_json::Value>(text).unwrap());
        assert_eq!(before, after);
    }
}
