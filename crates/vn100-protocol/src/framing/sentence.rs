//! A sentence: `$`, a body, and what protects it.

use crate::framing::checksum::Check;

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
