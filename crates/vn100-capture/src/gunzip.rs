//! Gzip data, unpacked: one member behind the other, and behind the last one the zeros that fill up
//! a block of a tape or an archive.

use std::io::{self, BufRead, BufReader, Read};

use flate2::bufread::GzDecoder;

/// Unpacks what it reads.
pub(crate) struct Gunzip<R> {
    /// `None` behind the last member.
    member: Option<GzDecoder<BufReader<R>>>,
}

impl<R: Read> Gunzip<R> {
    pub(crate) fn new(packed: R) -> Self {
        Self { member: Some(GzDecoder::new(BufReader::new(packed))) }
    }
}

impl<R: Read> Read for Gunzip<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = &mut self.member {
            let n = member.read(buffer)?;
            if n > 0 || buffer.is_empty() {
                return Ok(n);
            }
            let ended = skip_zeros(member.get_mut())?;
            let packed = self.member.take().map(GzDecoder::into_inner);
            self.member = packed.filter(|_| !ended).map(GzDecoder::new);
        }
        Ok(0)
    }
}

/// Whether nothing but zeros was left.
fn skip_zeros(packed: &mut impl BufRead) -> io::Result<bool> {
    loop {
        let waiting = packed.fill_buf()?;
        let length = waiting.len();
        let zeros = waiting.iter().take_while(|&&byte| byte == 0).count();
        packed.consume(zeros);
        if zeros < length || length == 0 {
            return Ok(length == 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::{Compression, write::GzEncoder};

    use super::*;

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    /// The bytes unpacked, and whether they ended without an error.
    fn unpacked(bytes: &[u8]) -> (Vec<u8>, bool) {
        let mut unpacked = Vec::new();
        let outcome = Gunzip::new(bytes).read_to_end(&mut unpacked);
        (unpacked, outcome.is_ok())
    }

    #[test]
    fn members_and_zeros_behind_them_are_one_file() {
        let (one, two) = (packed(b"one "), packed(b"two"));
        for zeros in [0, 1, 511, 100_000] {
            let padding = vec![0; zeros];
            assert_eq!(unpacked(&[&*one, &two, &padding].concat()), (b"one two".to_vec(), true), "{zeros}");
        }
        assert_eq!(unpacked(&[&packed(b"")[..], &one].concat()), (b"one ".to_vec(), true));
    }

    #[test]
    fn other_bytes_behind_and_a_cut_are_errors() {
        let one = packed(b"one ");
        assert_eq!(unpacked(&[&one, &b"\0\0more"[..]].concat()), (b"one ".to_vec(), false));
        assert!(!unpacked(&one[..one.len() - 1]).1);
        assert!(!unpacked(&[&one[..], &one[..5]].concat()).1);
        // an interrupted read is not the end
        struct Interrupted<'a>(&'a [u8], bool);
        impl Read for Interrupted<'_> {
            fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
                self.1 = !self.1;
                if self.1 { Err(io::ErrorKind::Interrupted.into()) } else { self.0.by_ref().take(3).read(buffer) }
            }
        }
        let bytes = [&one[..], &[0; 9], &one].concat();
        let mut whole = Vec::new();
        let mut reader = Interrupted(&bytes, false);
        let outcome = Gunzip::new(&mut reader).read_to_end(&mut whole);
        assert_eq!((whole, outcome.is_ok()), (b"one one ".to_vec(), true));
    }
}
