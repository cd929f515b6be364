//! What became of the lines of a CSV file: each is counted once.

use std::fmt;

/// Why a row of a CSV file was not let in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OddRow {
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
    /// The last line has no line end, and its last field is not printed as those above, or not
    /// there: the file may be cut in it.
    Truncated,
}

/// Rows of a CSV file that were not let in, by reason.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OddRowCounts {
    counts: [u64; OddRow::ALL.len()],
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
    /// The header and what stands above it, blank lines, lines that begin with `#`, and line breaks
    /// inside quotes.
    pub(crate) skipped_lines: u64,
    pub(crate) bytes: LineBytes,
    odd: [OddRows; OddRow::ALL.len()],
}

/// Bytes of the lines, line ends included.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct LineBytes {
    pub(crate) rows: u64,
    pub(crate) odd: u64,
    pub(crate) skipped: u64,
}

impl OddRow {
    pub(crate) const ALL: [Self; 7] =
        [Self::Fields, Self::Number, Self::Decimals, Self::Range, Self::Stamp, Self::Length, Self::Truncated];
}

impl OddRowCounts {
    /// The reasons there are, and how many rows each has.
    pub fn iter(&self) -> impl Iterator<Item = (OddRow, u64)> {
        let counted = OddRow::ALL.into_iter().zip(self.counts);
        counted.filter(|(_, count)| *count > 0)
    }

    /// Rows of any reason.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    pub(crate) fn count(&mut self, kind: OddRow) {
        self.counts[kind as usize] += 1;
    }
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
            Self::Truncated => "truncated",
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
