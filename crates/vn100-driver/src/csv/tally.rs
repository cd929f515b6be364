//! What became of the lines of a CSV file: each is counted once.

use std::fmt;

/// Why a row was not let in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OddRow {
    /// It has more or fewer fields than the header, or no sentence in the field for it.
    Fields,
    /// A field is no number.
    Number,
    /// A number has more decimals than the rows at the beginning.
    Decimals,
    /// A number is beyond what the sensor can give, or beyond 32 bits.
    Range,
    /// The stamp is no number, or 292 years from the first.
    Stamp,
    /// The line is longer than 64 KiB.
    Length,
}

/// The odd rows of one kind.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct OddRows {
    pub(crate) count: u64,
    pub(crate) first: Option<Evidence>,
}

/// A line that was not let in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Evidence {
    /// From 1.
    pub(crate) line: u64,
    /// Its beginning, fit for a terminal.
    pub(crate) text: String,
}

/// `lines = rows + odd + skipped_lines`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct CsvTally {
    pub(crate) lines: u64,
    pub(crate) rows: u64,
    /// The header and what stands above it, blank lines, lines that begin with `#`, and line breaks inside quotes.
    pub(crate) skipped_lines: u64,
    /// Bytes of all these lines, line ends included.
    pub(crate) bytes: u64,
    odd: [OddRows; OddRow::ALL.len()],
}

impl OddRow {
    pub(crate) const ALL: [Self; 6] =
        [Self::Fields, Self::Number, Self::Decimals, Self::Range, Self::Stamp, Self::Length];
}

impl fmt::Display for OddRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Fields => "fields",
            Self::Number => "number",
            Self::Decimals => "decimals",
            Self::Range => "range",
            Self::Stamp => "stamp",
            Self::Length => "length",
        })
    }
}

impl CsvTally {
    /// The odd rows of one kind.
    pub(crate) fn odd(&self, kind: OddRow) -> &OddRows {
        &self.odd[kind as usize]
    }

    /// The odd rows of all kinds.
    #[cfg(test)]
    pub(crate) fn odd_rows(&self) -> u64 {
        self.odd.iter().map(|odd| odd.count).sum()
    }

    #[cold]
    pub(super) fn count_odd(&mut self, kind: OddRow, line: u64, text: &[u8]) {
        let odd = &mut self.odd[kind as usize];
        odd.count += 1;
        odd.first.get_or_insert_with(|| Evidence { line, text: shown(text) });
    }
}

/// The beginning of `text`, without the characters that steer a terminal.
pub(super) fn shown(text: &[u8]) -> String {
    const SHOWN_BYTES: usize = 160;
    let head = &text[..text.len().min(SHOWN_BYTES)];
    let mut shown: String = String::from_utf8_lossy(head)
        .chars()
        .map(|c| if c == '\t' { ' ' } else { c })
        .filter(|c| !c.is_control())
        .collect();
    if head.len() < text.len() {
        shown.push('…');
    }
    shown
}
