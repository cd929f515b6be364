//! Sentences of a VectorNav inside a message, in a field of any name.

use memchr::memmem;

use crate::csv::checked_part;

/// The sentences in the bytes of a message, each from `$VN` to the end of its line, or to the end
/// of the text.
pub(super) fn sentences(message: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = message;
    std::iter::from_fn(move || {
        let start = memmem::find(rest, b"$VN")?;
        let sentence = &rest[start..];
        let is_text = |byte: &u8| matches!(byte, 0x20..=0x7e);
        let end = sentence.iter().position(|byte| !is_text(byte)).unwrap_or(sentence.len());
        // another sentence may follow in the same text
        let end = memmem::find(&sentence[1..end], b"$").map_or(end, |next| next + 1);
        rest = &sentence[end..];
        Some(checked_part(&sentence[..end]))
    })
}

/// Whether a message contains a header of the VectorNav form, followed by numbers. The three bytes
/// `$VN` alone occur in any image.
pub(super) fn has_sentence(message: &[u8]) -> bool {
    const SHORTEST: usize = 20;
    let is_one = |sentence: &[u8]| {
        sentence.len() >= SHORTEST
            && sentence[3..6].iter().all(u8::is_ascii_uppercase)
            && sentence[6] == b','
            && sentence[7..SHORTEST].iter().all(|byte| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b','))
    };
    sentences(message).any(is_one)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_end_with_their_line_or_their_text() {
        let found = |message: &[u8]| sentences(message).map(<[u8]>::to_vec).collect::<Vec<_>>();
        assert_eq!(found(b"\x08\0\0\0$VNYMR,1*5E\0\0"), [b"$VNYMR,1*5E"]);
        assert_eq!(found(b"$VNYMR,1*5E\r\n$VNYMR,2*5D\r\n"), [&b"$VNYMR,1*5E"[..], b"$VNYMR,2*5D"]);
        assert_eq!(found(b"b'$VNYMR,1*5E\\r\\n'"), [b"$VNYMR,1*5E"]);
        assert_eq!(found(b"\"$VNYMR,1*12EF\""), [b"$VNYMR,1*12EF"]);
        assert_eq!(found(b"$VNYMR,1*"), [b"$VNYMR,1*"]);
        assert_eq!(found(b"$VNYMR,1$VNYMR,2*5D"), [&b"$VNYMR,1"[..], b"$VNYMR,2*5D"]);
        assert!(found(b"$GPGGA,1*5E").is_empty() && found(b"").is_empty());
    }

    #[test]
    fn three_bytes_are_no_evidence() {
        assert!(has_sentence(b"\x08$VNYMR,+098.146,-000.915,+011.708*00\0"));
        for other in [&b"\xff$VN\xff"[..], b"$VNYMR", b"no answer to $VNRRG,now that it is late", b"$VNYMR,+098.146,-"]
        {
            assert!(!has_sentence(other), "{other:?}");
        }
    }
}
