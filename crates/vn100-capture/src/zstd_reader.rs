//! zstd data, unpacked while it is read, with bounded memory.

use std::{
    borrow::BorrowMut,
    error::Error,
    io::{self, BufRead, ErrorKind, Read},
};

use ruzstd::decoding::{
    BlockDecodingStrategy, FrameDecoder,
    errors::{FrameDecoderError, ReadFrameHeaderError},
};

/// Unpacks the frames of zstd data in sequence. A frame with a window above 128 MiB is rejected.
pub(crate) struct ZstdReader<R, D> {
    packed: R,
    /// May be reused for other data, because making one takes far longer than unpacking a message.
    decoder: D,
    is_in_frame: bool,
    /// Why the frame ends early; returned after its bytes.
    error: Option<io::Error>,
}

/// The head of an empty last block, and a checksum that is not compared.
const END_OF_FRAME: &[u8] = &[1, 0, 0, 0, 0, 0, 0];

impl<R: BufRead, D: BorrowMut<FrameDecoder>> ZstdReader<R, D> {
    pub(crate) fn new(packed: R, decoder: D) -> Self {
        Self { packed, decoder, is_in_frame: false, error: None }
    }

    /// Reads the head of the next frame; `false` if there is none.
    fn begin_frame(&mut self) -> io::Result<bool> {
        while !self.packed.fill_buf()?.is_empty() {
            match self.decoder.borrow_mut().reset(&mut self.packed) {
                Ok(()) => {
                    self.is_in_frame = true;
                    return Ok(true);
                }
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame { length, .. })) => {
                    let skipped = io::copy(&mut self.packed.by_ref().take(length.into()), &mut io::sink())?;
                    if skipped < length.into() {
                        return Err(ErrorKind::UnexpectedEof.into());
                    }
                }
                Err(error) => return Err(failed(&error)),
            }
        }
        Ok(false)
    }

    /// Compares the checksum of a frame that has one.
    fn end_frame(&mut self) -> io::Result<()> {
        self.is_in_frame = false;
        let decoder = self.decoder.borrow_mut();
        match (decoder.get_checksum_from_data(), decoder.get_calculated_checksum()) {
            (Some(stated), Some(found)) if stated != found => {
                Err(damaged(&format!("its checksum is {found:#010x} and not {stated:#010x}")))
            }
            _ => Ok(()),
        }
    }
}

impl<R: BufRead, D: BorrowMut<FrameDecoder>> Read for ZstdReader<R, D> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.is_empty() {
            return Ok(0);
        }
        while self.is_in_frame || self.begin_frame()? {
            let decoder = self.decoder.borrow_mut();
            while decoder.can_collect() == 0 && !decoder.is_finished() {
                let a_block = || BlockDecodingStrategy::UptoBlocks(1);
                if let Err(error) = decoder.decode_blocks(&mut self.packed, a_block()) {
                    // the decoder keeps the last megabytes until its frame ends
                    decoder.decode_blocks(END_OF_FRAME, a_block()).map_err(|error| failed(&error))?;
                    self.error = Some(failed(&error));
                }
            }
            let n = decoder.read(buffer)?;
            if n > 0 {
                return Ok(n);
            }
            if let Some(error) = self.error.take() {
                self.is_in_frame = false;
                return Err(error);
            }
            self.end_frame()?;
        }
        Ok(0)
    }
}

/// Why zstd data cannot be unpacked, in words for the user.
fn failed(error: &FrameDecoderError) -> io::Error {
    if let FrameDecoderError::WindowSizeTooBig { requested, max } = error {
        let needed =
            format!("this zstd data needs {requested} bytes of memory, at most {max} are given: unpack it first");
        return io::Error::new(ErrorKind::InvalidData, needed);
    }
    let mut source: Option<&(dyn Error + 'static)> = Some(error);
    while let Some(error) = source {
        if error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == ErrorKind::UnexpectedEof) {
            return io::Error::new(ErrorKind::UnexpectedEof, "the zstd data ends early");
        }
        source = error.source();
    }
    damaged(&error.to_string())
}

fn damaged(problem: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, format!("the zstd data is damaged: {problem}"))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    fn unpacked(packed: &[u8]) -> (Vec<u8>, bool) {
        let mut unpacked = Vec::new();
        let outcome = ZstdReader::new(packed, FrameDecoder::new()).read_to_end(&mut unpacked);
        (unpacked, outcome.is_ok())
    }

    fn packed(bytes: &[u8]) -> Vec<u8> {
        compress_to_vec(bytes, CompressionLevel::Fastest)
    }

    /// A frame for other programs, with these bytes.
    fn skippable(bytes: &[u8]) -> Vec<u8> {
        [&0x184d_2a53_u32.to_le_bytes(), &(bytes.len() as u32).to_le_bytes(), bytes].concat()
    }

    #[test]
    fn frames_follow_each_other_and_those_of_others_are_skipped() {
        let bytes = [packed(b"one "), skippable(b"no matter"), packed(b""), packed(b"two"), skippable(b"")].concat();
        assert_eq!(unpacked(&bytes), (b"one two".to_vec(), true));
        assert_eq!(unpacked(b""), (vec![], true));
    }

    #[test]
    fn what_comes_before_a_cut_is_kept() {
        let bytes: Vec<u8> =
            (0..400_000_u32).flat_map(|number| number.wrapping_mul(2_654_435_761).to_le_bytes()).collect();
        let packed = packed(&bytes);
        let (found, is_whole) = unpacked(&packed[..packed.len() * 3 / 4]);
        assert!(!is_whole && bytes.starts_with(&found));
        // all but the block that was cut
        assert!(found.len() + (128 << 10) >= bytes.len() * 3 / 4, "{} of {}", found.len(), bytes.len());
    }

    #[test]
    fn a_checksum_mismatch_is_an_error() {
        // `printf abc | zstd`
        let mut bytes = *b"\x28\xb5\x2f\xfd\x24\x03\x19\0\0abc\x99\x09\x77\xad";
        assert_eq!(unpacked(&bytes), (b"abc".to_vec(), true));
        bytes[10] ^= 1;
        assert!(!unpacked(&bytes).1);
    }

    #[test]
    fn a_large_window_is_rejected_before_it_needs_memory() {
        // a window of 2^41 bytes
        let packed = b"\x28\xb5\x2f\xfd\0\xf8\x19\0\0abc";
        let error = ZstdReader::new(&packed[..], FrameDecoder::new()).read_to_end(&mut Vec::new()).unwrap_err();
        assert!(error.to_string().contains("needs 2199023255552 bytes of memory"), "{error}");
    }

    proptest! {
        #[test]
        fn a_cut_is_an_error_and_earlier_bytes_are_kept(text in "[a-d]{1,3000}", cut in 1_usize..4000) {
            let whole = packed(text.as_bytes());
            prop_assert_eq!(unpacked(&whole), (text.clone().into_bytes(), true));
            let (found, is_whole) = unpacked(&whole[..whole.len().saturating_sub(cut).max(1)]);
            prop_assert!(!is_whole && text.as_bytes().starts_with(&found));
            let cut = &whole[..whole.len() - 1];
            let error = ZstdReader::new(cut, FrameDecoder::new()).read_to_end(&mut Vec::new()).unwrap_err();
            prop_assert_eq!(error.kind(), ErrorKind::UnexpectedEof);
        }
    }
}
