//! Text in UTF-16, as spreadsheets save it, read as UTF-8.

use std::io::{self, Cursor, Read};

/// How many bytes after the byte order mark are examined to confirm that it is one.
const SHOWN_BYTES: u64 = 64;

const BUFFER_BYTES: usize = 8192;

/// The same bytes, or their text in UTF-8 where a byte order mark and the characters behind it say
/// that it is in UTF-16, in either order.
pub(crate) fn as_utf8(mut reader: Box<dyn Read + Send>) -> io::Result<Box<dyn Read + Send>> {
    let mut head = Vec::new();
    reader.by_ref().take(1).read_to_end(&mut head)?;
    if matches!(head[..], [0xff | 0xfe]) {
        reader.by_ref().take(1).read_to_end(&mut head)?;
    }
    let unit: fn([u8; 2]) -> u16 = match head[..] {
        [0xff, 0xfe] => u16::from_le_bytes,
        [0xfe, 0xff] => u16::from_be_bytes,
        _ => return Ok(Box::new(Cursor::new(head).chain(reader))),
    };
    reader.by_ref().take(SHOWN_BYTES).read_to_end(&mut head)?;
    let units = head[2..].chunks_exact(2).map(|bytes| unit([bytes[0], bytes[1]]));
    let is_text = |unit: u16| matches!(unit, 9 | 10 | 13 | 0x20..=0x7e | 0xa0..=0x24f | 0x2000..=0x22ff);
    if head.len() < 4 || !units.clone().all(is_text) {
        return Ok(Box::new(Cursor::new(head).chain(reader)));
    }
    let units = Cursor::new(head.split_off(2)).chain(reader);
    Ok(Box::new(Utf16Reader { units, unit, rest: Vec::new(), text: Vec::new(), shown: 0 }))
}

struct Utf16Reader<R> {
    units: R,
    unit: fn([u8; 2]) -> u16,
    /// Bytes of a character that is not whole.
    rest: Vec<u8>,
    text: Vec<u8>,
    shown: usize,
}

impl<R: Read> Read for Utf16Reader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.shown == self.text.len() {
            let mut piece = [0; BUFFER_BYTES];
            let n = self.units.read(&mut piece)?;
            self.rest.extend_from_slice(&piece[..n]);
            let is_last = n == 0;
            if is_last && self.rest.is_empty() {
                return Ok(0);
            }
            let mut whole = self.rest.len() / 2 * 2;
            let unit = |at: usize| (self.unit)([self.rest[at], self.rest[at + 1]]);
            // the first half of a character beyond 16 bits waits for the second
            if whole >= 2 && !is_last && matches!(unit(whole - 2), 0xd800..0xdc00) {
                whole -= 2;
            }
            let units = (0..whole).step_by(2).map(unit);
            let text: String = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
            (self.text, self.shown) = (text.into_bytes(), 0);
            if is_last && whole < self.rest.len() {
                self.text.extend_from_slice("\u{fffd}".as_bytes());
                whole = self.rest.len();
            }
            self.rest.drain(..whole);
        }
        let n = (&self.text[self.shown..]).read(buffer)?;
        self.shown += n;
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Hands out a few bytes at a time.
    struct Slow(Cursor<Vec<u8>>, usize);

    impl Read for Slow {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            self.0.by_ref().take(self.1 as u64).read(buffer)
        }
    }

    fn read(bytes: &[u8], step: usize) -> Vec<u8> {
        let mut text = Vec::new();
        as_utf8(Box::new(Slow(Cursor::new(bytes.to_vec()), step))).unwrap().read_to_end(&mut text).unwrap();
        text
    }

    #[test]
    fn what_only_begins_so_stays_what_it_is() {
        for bytes in
            [&b""[..], b"\xff", b"\xff\xfe", b"\xff\xfe\0", b"\xfe\xff\0\0\0\0", b"\xff\xfe$VNYMR,\x80\x01", b"$VN"]
        {
            assert_eq!(read(bytes, 2), bytes, "{bytes:?}");
        }
    }

    proptest! {
        #[test]
        fn either_order_is_the_same_text(begin in "[a-z,0-9]{40}", text in "[\u{20}-\u{7e}\u{b0}\u{1f600}\r\n]{0,300}", step in 1_usize..50) {
            let text = begin + &text;
            let bytes = |unit: fn(u16) -> [u8; 2]| "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(unit).collect::<Vec<_>>();
            prop_assert_eq!(read(&bytes(u16::to_le_bytes), step), text.as_bytes());
            prop_assert_eq!(read(&bytes(u16::to_be_bytes), step), text.as_bytes());
            let whole = bytes(u16::to_be_bytes);
            let cut = String::from_utf8(read(&whole[..whole.len() - 1], step)).unwrap();
            prop_assert!(cut.ends_with(char::REPLACEMENT_CHARACTER));
        }
    }
}
