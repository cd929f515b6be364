//! Bytes that came over telnet (RFC 854, also RFC 2217 of serial servers), in which a byte 0xFF is
//! sent twice, because 0xFF alone begins a command. As those of a packed file, the bytes are counted
//! as they are read.

use std::io::{self, Read};

/// With fewer runs of 0xFF, equal pairs may be chance.
const FEWEST_RUNS: usize = 4;

/// Whether 0xFF comes only in pairs in these bytes, which does not occur in packets.
pub(crate) fn doubles_ff(bytes: &[u8]) -> bool {
    // a run at the end may be cut
    let whole = &bytes[..bytes.iter().rposition(|byte| *byte != 0xff).unwrap_or(0)];
    let runs = whole.chunk_by(|one, other| (*one == 0xff) == (*other == 0xff)).filter(|run| run[0] == 0xff);
    let lengths: Vec<usize> = runs.map(<[u8]>::len).collect();
    lengths.len() >= FEWEST_RUNS && lengths.iter().all(|length| length % 2 == 0)
}

/// Gives one 0xFF for each pair.
pub(crate) struct Undoubled<R> {
    reader: R,
    /// Whether the last byte was the first of a pair.
    is_open: bool,
}

impl<R> Undoubled<R> {
    pub(crate) const fn new(reader: R) -> Self {
        Self { reader, is_open: false }
    }
}

impl<R: Read> Read for Undoubled<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let n = self.reader.read(buffer)?;
            let mut kept = 0;
            for at in 0..n {
                let byte = buffer[at];
                let is_second = self.is_open && byte == 0xff;
                self.is_open = byte == 0xff && !is_second;
                if !is_second {
                    buffer[kept] = byte;
                    kept += 1;
                }
            }
            if kept > 0 || n == 0 {
                return Ok(kept);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn doubled(bytes: &[u8]) -> Vec<u8> {
        bytes.iter().flat_map(|&byte| if byte == 0xff { vec![byte; 2] } else { vec![byte] }).collect()
    }

    proptest! {
        #[test]
        fn doubled_bytes_are_recognised_and_undone(bytes in proptest::collection::vec(any::<u8>(), 4096), piece in 1_usize..50) {
            let twice = doubled(&bytes);
            let runs = bytes.chunk_by(|one, other| (*one == 0xff) == (*other == 0xff)).filter(|run| run[0] == 0xff).count();
            prop_assume!(runs > 6);
            prop_assert!(doubles_ff(&twice) && doubles_ff(&twice[..4000]));
            prop_assert!(!doubles_ff(&bytes));
            let mut read = Vec::new();
            let mut reader = Undoubled::new(&twice[..]);
            let mut buffer = vec![0; piece];
            while let n @ 1.. = reader.read(&mut buffer).unwrap() {
                read.extend_from_slice(&buffer[..n]);
            }
            prop_assert_eq!(read, bytes);
        }
    }

    #[test]
    fn text_and_few_bytes_are_unchanged() {
        for bytes in [&b""[..], b"\xff", b"\xff\xff\0\xff\xff", b"$VNYMR", &[0xff; 100]] {
            assert!(!doubles_ff(bytes));
        }
    }
}
