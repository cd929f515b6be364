//! A sentence: `$`, a body, and what protects it.

use core::fmt;

use crate::framing::checksum::{Check, CheckDigits, crc16_step};

/// The longest body taken: with `$`, `*`, four digits, CR and LF it makes 320 bytes, twice the
/// longest stock message.
pub const MAX_BODY: usize = 312;

/// A sentence whose checksum is right, or that has none where that was allowed.
///
/// ```text
/// $ VNRRG,01,VN-100S-CR * 35 CR LF
///   '------ body -----'
/// '---------- raw ---------'
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sentence<'a> {
    /// The bytes between `$` and `*`: printable ASCII without those two, at most [`MAX_BODY`].
    pub body: &'a [u8],
    /// The bytes from the `$` to the last check digit, without CR and LF.
    pub raw: &'a [u8],
    /// What protects it.
    pub check: Check,
    /// Where its `$` stands, in bytes from the beginning of the stream.
    pub offset: u64,
}

impl<'a> Sentence<'a> {
    /// What stands before the first comma, such as `VNRRG`.
    #[must_use]
    pub fn header(&self) -> &'a [u8] {
        let end = self.body.iter().position(|&byte| byte == b',').unwrap_or(self.body.len());
        &self.body[..end]
    }

    /// Whether this is what a VN-100 says to a command: the command's own name, or `VNERR`.
    #[must_use]
    pub fn is_reply(&self) -> bool {
        #[rustfmt::skip]
        const REPLIES: [&[u8]; 16] = [
            b"VNRRG", b"VNWRG", b"VNWNV", b"VNRFS", b"VNRST", b"VNTAR", b"VNKMD", b"VNKAD",
            b"VNSGB", b"VNSFB", b"VNASY", b"VNBOM", b"VNSIH", b"VNERR", b"VNFWU", b"VNCMD",
        ];
        REPLIES.contains(&self.header())
    }
}

/// Writes `$`, what `body` writes, the check digits, CR and LF.
pub(crate) fn write_sentence<W: fmt::Write>(
    out: &mut W,
    check: Check,
    body: impl FnOnce(&mut Checked<'_, W>) -> fmt::Result,
) -> fmt::Result {
    out.write_char('$')?;
    let mut checked = Checked { out, xor: 0, crc: 0 };
    body(&mut checked)?;
    let Checked { out, xor, crc } = checked;
    match check {
        Check::Xor8 => write!(out, "*{}\r\n", CheckDigits::Xor8(xor)),
        Check::Crc16 => write!(out, "*{}\r\n", CheckDigits::Crc16(crc)),
        Check::None => out.write_str("\r\n"),
    }
}

/// Passes text on and keeps its checksums.
pub(crate) struct Checked<'a, W> {
    out: &'a mut W,
    xor: u8,
    crc: u16,
}

impl<W: fmt::Write> fmt::Write for Checked<'_, W> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.xor = text.bytes().fold(self.xor, |xor, byte| xor ^ byte);
        self.crc = text.bytes().fold(self.crc, crc16_step);
        self.out.write_str(text)
    }
}
