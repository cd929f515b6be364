//! What became of the lines of a CSV file: each is counted once.

use vn100_protocol::stream::RejectedRow;

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
    odd: [OddRows; RejectedRow::ALL.len()],
}

/// Bytes of the lines, line ends included.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct LineBytes {
    pub(crate) rows: u64,
    pub(crate) odd: u64,
    pub(crate) skipped: u64,
}

impl CsvTally {
    /// The odd rows of one kind.
    pub(crate) fn odd(&self, kind: RejectedRow) -> &OddRows {
        &self.odd[kind as usize]
    }

    /// The odd rows of all kinds.
    #[cfg(test)]
    pub(crate) fn rejected_rows(&self) -> u64 {
        self.odd.iter().map(|odd| odd.count).sum()
    }

    #[cold]
    pub(super) fn count_odd(&mut self, kind: RejectedRow, line: u64, text: &[u8]) {
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
