//! Reads that came close together share one message: the header of a message would otherwise be
//! larger than the bytes of a read.
//!
//! ```text
//! number of reads | for each: its length, nanoseconds since the one before | their bytes
//! ```
//!
//! Numbers are LEB128, seven bits per byte, the lowest first; the first read came at the log time.

use std::mem;

/// Longest time from the first read of a message to its last; the file is this much later than the
/// port.
const TOGETHER_NS: u64 = 50_000_000;

/// Reads of this many bytes are written at once: the header of a message is small compared to them.
const TOGETHER_BYTES: usize = 4 * 1024;

/// Longest form of a 64-bit number.
const MAX_DIGITS: usize = 10;

/// Reads that will be written together.
#[derive(Debug, Default)]
pub(super) struct Reads {
    first_ns: i64,
    last_ns: i64,
    count: u64,
    table: Vec<u8>,
    bytes: Vec<u8>,
}

impl Reads {
    /// Whether a read at this time belongs to the pending reads.
    pub(super) fn takes(&self, at_ns: i64, bytes: &[u8]) -> bool {
        let is_later = at_ns >= self.last_ns && at_ns.abs_diff(self.first_ns) < TOGETHER_NS;
        self.count == 0 || is_later && self.bytes.len() + bytes.len() <= TOGETHER_BYTES
    }

    /// Whether the pending reads must be written now.
    pub(super) fn is_full(&self) -> bool {
        self.bytes.len() >= TOGETHER_BYTES
    }

    pub(super) fn push(&mut self, at_ns: i64, bytes: &[u8]) {
        if self.count == 0 {
            (self.first_ns, self.last_ns) = (at_ns, at_ns);
        }
        put_number(&mut self.table, bytes.len() as u64);
        put_number(&mut self.table, at_ns.abs_diff(self.last_ns));
        self.bytes.extend_from_slice(bytes);
        self.last_ns = at_ns;
        self.count += 1;
    }

    /// The pending reads as one message: its log time, whether they are several, and its data in the
    /// form above, or the bytes of a single read. `None` if there are none.
    pub(super) fn take(&mut self) -> Option<(i64, bool, Vec<u8>)> {
        let Self { first_ns, count, table, bytes, .. } = mem::take(self);
        if count <= 1 {
            return (count == 1).then_some((first_ns, false, bytes));
        }
        let mut data = Vec::with_capacity(MAX_DIGITS + table.len() + bytes.len());
        put_number(&mut data, count);
        data.extend(table);
        data.extend(bytes);
        Some((first_ns, true, data))
    }
}

/// The reads of a message of several reads, with the time and the place of each in `data`; `None`
/// if the message does not have this form.
pub(super) fn reads_of(log_ns: i64, data: &[u8]) -> Option<Vec<(i64, std::ops::Range<usize>)>> {
    let mut rest = data;
    let count = take_number(&mut rest)?;
    // a read takes two digits or more
    if count > rest.len() as u64 / 2 {
        return None;
    }
    let mut reads = Vec::with_capacity(count as usize);
    let (mut at_ns, mut lengths) = (log_ns, 0_usize);
    for _ in 0..count {
        let length = usize::try_from(take_number(&mut rest)?).ok()?;
        at_ns = at_ns.checked_add_unsigned(take_number(&mut rest)?)?;
        let end = lengths.checked_add(length)?;
        reads.push((at_ns, lengths..end));
        lengths = end;
    }
    let begin = data.len() - rest.len();
    (lengths == rest.len())
        .then(|| reads.into_iter().map(|(at, range)| (at, begin + range.start..begin + range.end)).collect())
}

fn put_number(out: &mut Vec<u8>, mut number: u64) {
    while number >= 0x80 {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
}

fn take_number(rest: &mut &[u8]) -> Option<u64> {
    let mut number = 0_u64;
    for shift in (0..MAX_DIGITS as u32).map(|digit| 7 * digit) {
        let (digit, behind) = rest.split_first()?;
        *rest = behind;
        let bits = u64::from(digit & 0x7F);
        // the last digit has one bit
        number |= bits.checked_mul(1 << shift)?;
        if digit & 0x80 == 0 {
            return Some(number);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};

    use super::*;

    fn several(reads: &[(i64, &[u8])]) -> (i64, Vec<u8>) {
        let mut waiting = Reads::default();
        reads.iter().for_each(|(at_ns, bytes)| waiting.push(*at_ns, bytes));
        match waiting.take() {
            Some((at_ns, true, data)) => (at_ns, data),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn one_read_is_its_bytes() {
        let mut reads = Reads::default();
        assert_eq!(reads.take(), None);
        reads.push(5, b"abc");
        assert_eq!(reads.take(), Some((5, false, b"abc".to_vec())));
        assert_eq!(reads.take(), None);
    }

    #[test]
    fn reads_wait_for_a_twentieth_of_a_second_unless_time_decreases() {
        let mut reads = Reads::default();
        assert!(reads.takes(7, b"a"));
        reads.push(7, b"a");
        assert!(reads.takes(7, b"a") && reads.takes(50_000_006, b"a"));
        assert!(!reads.takes(50_000_007, b"a") && !reads.takes(6, b"a"));
        assert!(!reads.takes(7, &[0; TOGETHER_BYTES]));
    }

    #[test]
    fn false_lengths_are_rejected() {
        let (at_ns, data) = several(&[(10, b"abc"), (300, b"de")]);
        assert_eq!(reads_of(at_ns, &data), Some(vec![(10, 6..9), (300, 9..11)]));
        for cut in 0..data.len() {
            assert_eq!(reads_of(at_ns, &data[..cut]), None, "{cut}");
        }
        assert_eq!(reads_of(at_ns, &[&data[..], b"f"].concat()), None);
        assert_eq!(reads_of(0, &[0xFF; 40]), None);
        assert_eq!(reads_of(i64::MAX, &[1, 0, 1]), None);
        assert_eq!(reads_of(0, &[0]), Some(vec![]));
    }

    proptest! {
        #[test]
        fn reads_are_returned_as_they_were(reads in vec((0_i64..10_000_000, vec(any::<u8>(), 1..200)), 2..30)) {
            let mut at_ns = -5;
            let reads: Vec<(i64, Vec<u8>)> = reads.into_iter().map(|(by, bytes)| { at_ns += by; (at_ns, bytes) }).collect();
            let borrowed: Vec<(i64, &[u8])> = reads.iter().map(|(at_ns, bytes)| (*at_ns, &**bytes)).collect();
            let (log_ns, data) = several(&borrowed);
            let back: Vec<(i64, &[u8])> = reads_of(log_ns, &data).unwrap().into_iter().map(|(at_ns, place)| (at_ns, &data[place])).collect();
            prop_assert_eq!(back, borrowed);
        }

        #[test]
        fn numbers_are_returned(number: u64) {
            let mut digits = Vec::new();
            put_number(&mut digits, number);
            prop_assert_eq!(take_number(&mut &digits[..]), Some(number));
        }
    }
}
