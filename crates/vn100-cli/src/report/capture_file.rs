//! The capture as a file: its size, and the digest by which it can be told from any other.

use std::{
    fmt::Write,
    fs::{self, File},
    io::Read,
    path::Path,
};

use anyhow::Result;
use sha2::{Digest, Sha256};

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct CaptureFile {
    pub(crate) bytes: u64,
    /// In 64 hexadecimal digits.
    pub(crate) sha256: String,
}

impl CaptureFile {
    /// Of the stored bytes, compressed or not; `None` for standard input, and where they cannot be
    /// read.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        // a second reading of anything but a file would wait, or bring something else
        let is_file = path != Path::new("-") && fs::metadata(path).is_ok_and(|found| found.is_file());
        if is_file { Self::read(path).ok() } else { None }
    }

    fn read(path: &Path) -> Result<Self> {
        const PIECE: usize = 1 << 18;
        let mut file = File::open(path)?;
        let (mut digest, mut bytes, mut piece) = (Sha256::new(), 0, vec![0; PIECE]);
        loop {
            let read = file.read(&mut piece)?;
            if read == 0 {
                break;
            }
            digest.update(&piece[..read]);
            bytes += read as u64;
        }
        let sha256 = digest.finalize().iter().fold(String::new(), |mut text, byte| {
            // a String takes everything
            let _ = write!(text, "{byte:02x}");
            text
        });
        Ok(Self { bytes, sha256 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_the_published_one() {
        let file = tempfile::NamedTempFile::new().unwrap();
        fs::write(file.path(), "abc").unwrap();
        // FIPS 180-4, example of the standard
        let sha256 = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad".to_owned();
        assert_eq!(CaptureFile::of(Path::new("-")), None);
        assert_eq!(CaptureFile::of(file.path()), Some(CaptureFile { bytes: 3, sha256 }));
    }
}
