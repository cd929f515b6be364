//! Compressed captures, recognised by their content and decompressed while they are read: gzip,
//! zstd, bzip2, xz, and the only capture in a ZIP archive.

use std::{
    fmt,
    io::{self, BufRead, BufReader, Cursor, Read, SeekFrom},
};

use bzip2::read::MultiBzDecoder;
use encoding_rs_io::DecodeReaderBytes;
use flate2::{CrcReader, bufread::GzDecoder, read::DeflateDecoder};
use lzma_rust2::XzReader;
use ruzstd::decoding::FrameDecoder;
use zip::{CompressionMethod, ZipArchive};

use crate::{
    open_error::Problem,
    stored_file::{ReadSeek, StoredFile},
    zstd_reader::ZstdReader,
};

const GZIP_MAGIC: &[u8] = &[0x1f, 0x8b];
pub(crate) const ZSTD_MAGIC: &[u8] = &[0x28, 0xb5, 0x2f, 0xfd];
const BZIP2_MAGIC: &[u8] = b"BZh";
const XZ_MAGIC: &[u8] = b"\xfd7zXZ\0";
const ZIP_MAGIC: &[u8] = b"PK\x03\x04";

/// Memory for unpacking xz data: the largest dictionary that `xz` makes takes 65 MiB.
const XZ_MEMORY_KIB: u32 = 72 << 10;

/// The most files of an archive whose contents are compared.
const MOST_EXAMINED: usize = 64;

/// Endings of the names of compressed captures.
pub(crate) const PACKED_ENDINGS: [&str; 5] = ["bz2", "gz", "xz", "zip", "zst"];

/// The error for an archive that is a document of another program, recognised by the name of a file
/// in it.
fn document_with(member: &str) -> Option<Problem> {
    let document = if member.ends_with(".npy") {
        "NumPy arrays in an archive: numpy.savetxt('imu.csv', numpy.load('FILE.npz')['NAME'], delimiter=',') makes a \
         table of one"
    } else if ["[Content_Types].xml", "xl/workbook.xml", "mimetype"].contains(&member) {
        "a document of Microsoft Office or LibreOffice: save its sheet as CSV"
    } else {
        return None;
    };
    Some(Problem::new(document))
}

fn damaged(problem: impl fmt::Display) -> Problem {
    Problem::new(format!("a ZIP archive that is damaged: {problem}"))
}

/// How a capture is known among the files of an archive.
#[derive(Clone, Copy)]
pub(crate) struct KnownBy {
    /// Whether the ending of a name is that of a capture.
    pub(crate) ending: fn(&str) -> bool,
    /// Whether a file of this name begins like a capture.
    pub(crate) beginning: fn(&mut dyn Read, &str) -> bool,
}

/// The decompressed content of a file; `counted` wraps the file to count the bytes read from it. If
/// an archive has several files, the capture among them is taken.
pub(crate) fn unpacked_stored<R: Read + Send + 'static>(
    file: &dyn StoredFile,
    counted: impl FnOnce(Box<dyn ReadSeek>) -> R,
    known_by: KnownBy,
) -> Result<Box<dyn Read + Send>, Problem> {
    let mut magic = Vec::new();
    file.open()?.take(ZIP_MAGIC.len() as u64).read_to_end(&mut magic)?;
    let mut opened = file.open()?;
    if magic != ZIP_MAGIC {
        return unpacked(counted(opened));
    }
    let member = Member::only(file, known_by)?;
    opened.seek(SeekFrom::Start(member.start))?;
    unpacked(MemberReader { inner: CrcReader::new(member.content(counted(opened))), member })
}

/// The decompressed content of a stream, with text in UTF-16 converted to UTF-8.
pub(crate) fn unpacked(mut reader: impl Read + Send + 'static) -> Result<Box<dyn Read + Send>, Problem> {
    let mut magic = Vec::new();
    // reads only as many bytes as are needed to recognise the format
    while [GZIP_MAGIC, ZSTD_MAGIC, BZIP2_MAGIC, XZ_MAGIC, ZIP_MAGIC]
        .iter()
        .any(|known| known.starts_with(&magic) && magic.len() < known.len())
    {
        let before = magic.len();
        reader.by_ref().take(1).read_to_end(&mut magic)?;
        if magic.len() == before {
            break;
        }
    }
    let is = |known: &[u8]| magic.starts_with(known);
    if is(ZIP_MAGIC) {
        let first = first_member(magic, &mut reader)?;
        return Err(document_with(&first).unwrap_or_else(|| {
            Problem::new("a ZIP archive on standard input: name it as a file, or unpack it, as `unzip -p` does")
        }));
    }
    let packings = [GZIP_MAGIC, ZSTD_MAGIC, BZIP2_MAGIC, XZ_MAGIC].map(is);
    let whole = Cursor::new(magic).chain(reader);
    let unpacked: Box<dyn Read + Send> = match packings {
        [true, ..] => Box::new(Gunzip::new(whole)),
        [_, true, ..] => Box::new(ZstdReader::new(BufReader::new(whole), FrameDecoder::new())),
        [_, _, true, _] => Box::new(MultiBzDecoder::new(whole)),
        [_, _, _, true] => Box::new(XzReader::new_mem_limit(BufReader::new(whole), true, XZ_MEMORY_KIB)),
        _ => Box::new(whole),
    };
    Ok(as_utf8(unpacked)?)
}

/// Bytes after the byte order mark of UTF-16 that are examined to confirm it.
const EXAMINED_BYTES: u64 = 64;

/// The same bytes, or their text in UTF-8 if a byte order mark and the characters after it show
/// UTF-16, in either byte order.
fn as_utf8(mut reader: Box<dyn Read + Send>) -> io::Result<Box<dyn Read + Send>> {
    let mut head = Vec::new();
    reader.by_ref().take(1).read_to_end(&mut head)?;
    if matches!(head[..], [0xff | 0xfe]) {
        reader.by_ref().take(1 + EXAMINED_BYTES).read_to_end(&mut head)?;
    }
    let unit: Option<fn([u8; 2]) -> u16> = match head[..] {
        [0xff, 0xfe, ..] => Some(u16::from_le_bytes),
        [0xfe, 0xff, ..] => Some(u16::from_be_bytes),
        _ => None,
    };
    let is_text = |unit: u16| matches!(unit, 9 | 10 | 13 | 0x20..=0x7e | 0xa0..=0x24f | 0x2000..=0x22ff);
    let is_utf16 = unit.is_some_and(|unit| {
        let mut units = head[2..].chunks_exact(2).map(|bytes| unit([bytes[0], bytes[1]]));
        head.len() >= 4 && units.all(is_text)
    });
    let whole = Cursor::new(head).chain(reader);
    Ok(if is_utf16 { Box::new(DecodeReaderBytes::new(whole)) } else { Box::new(whole) })
}

/// The name of the first file in an archive that begins with `magic`: it follows 30 bytes, with its
/// length in the 27th and 28th (APPNOTE of PKWARE, 4.3.7).
fn first_member(magic: Vec<u8>, reader: &mut impl Read) -> io::Result<String> {
    const NAMED_FROM: usize = 30;
    const LONGEST_NAME: usize = 256;
    let mut header = magic;
    reader.take((NAMED_FROM - header.len()) as u64).read_to_end(&mut header)?;
    let length = header.get(26..28).map_or(0, |bytes| usize::from(bytes[0]) | usize::from(bytes[1]) << 8);
    reader.take(length.min(LONGEST_NAME) as u64).read_to_end(&mut header)?;
    Ok(String::from_utf8_lossy(header.get(NAMED_FROM..).unwrap_or_default()).into_owned())
}

/// The position of a file in an archive.
struct Member {
    name: String,
    start: u64,
    packed_bytes: u64,
    is_deflated: bool,
    crc32: u32,
}

impl Member {
    /// The only file, or the only file that may be a capture by its name or its first bytes.
    fn only(file: &dyn StoredFile, known_by: KnownBy) -> Result<Self, Problem> {
        let opened = file.open().map_err(damaged)?;
        let mut archive = ZipArchive::new(BufReader::new(opened)).map_err(damaged)?;
        let mut names: Vec<(usize, String)> = Vec::new();
        for place in 0..archive.len() {
            let entry = archive.by_index_raw(place).map_err(damaged)?;
            let is_of_the_system = entry.name().starts_with("__MACOSX/") || entry.name().ends_with(".DS_Store");
            if entry.is_file() && !is_of_the_system {
                names.push((place, entry.name().to_owned()));
            }
        }
        let is_capture = |name: &str| (known_by.ending)(name.rsplit_once('.').map_or("", |(_, ending)| ending));
        let captures = names.iter().filter(|(_, name)| is_capture(name)).count();
        let document = names.iter().find_map(|(_, name)| document_with(name));
        if let Some(document) = document.filter(|_| captures == 0) {
            return Err(document);
        }
        if names.len() > 1 {
            names.retain(|(_, name)| captures == 0 || is_capture(name));
        }
        if names.len() > 1 {
            let is_one = |(place, _): &&(usize, String)| {
                Self::at(&mut archive, *place).is_ok_and(|member| member.begins_as(file, known_by))
            };
            let found: Vec<_> = names.iter().take(MOST_EXAMINED).filter(is_one).cloned().collect();
            names = if found.is_empty() { names } else { found };
        }
        if names.len() > 1 {
            const NAMED: usize = 20;
            let more = names.len().saturating_sub(NAMED);
            let mut names: Vec<_> = names.into_iter().take(NAMED).map(|(_, name)| legible(&name)).collect();
            names.extend((more > 0).then(|| format!("and {more} more")));
            let names = names.join(", ");
            return Err(Problem::new(format!(
                "a ZIP archive of several files: unpack the one that is meant ({names})"
            )));
        }
        let (place, _) = names.pop().ok_or_else(|| Problem::new("a ZIP archive without a file"))?;
        Self::at(&mut archive, place)
    }

    /// The member at this place of the list of files.
    fn at(archive: &mut ZipArchive<BufReader<Box<dyn ReadSeek>>>, place: usize) -> Result<Self, Problem> {
        let entry = archive.by_index_raw(place).map_err(damaged)?;
        let name = legible(entry.name());
        let is_deflated = match (entry.encrypted(), entry.compression()) {
            (false, CompressionMethod::Stored) => false,
            // the crate uses this name for the method if a caller must unpack it
            #[expect(deprecated, reason = "the number of a method that is unpacked here")]
            (false, CompressionMethod::Unsupported(8)) => true,
            (is_encrypted, method) => {
                let how = if is_encrypted { "encrypted".into() } else { format!("packed by {method}") };
                return Err(Problem::new(format!(
                    "{name} in this ZIP archive is {how}: unpack it with the program that made it"
                )));
            }
        };
        let start = entry.data_start().ok_or_else(|| damaged(format!("{name} has no beginning")))?;
        Ok(Self { name, start, packed_bytes: entry.compressed_size(), is_deflated, crc32: entry.crc32() })
    }

    /// The content, from the archive at the place where it begins.
    fn content(&self, archive: impl Read + Send + 'static) -> Box<dyn Read + Send> {
        let packed = archive.take(self.packed_bytes);
        if self.is_deflated { Box::new(DeflateDecoder::new(packed)) } else { Box::new(packed) }
    }

    /// Whether its first bytes are those of a capture.
    fn begins_as(&self, file: &dyn StoredFile, known_by: KnownBy) -> bool {
        let Ok(mut file) = file.open() else { return false };
        file.seek(SeekFrom::Start(self.start)).is_ok() && (known_by.beginning)(&mut self.content(file), &self.name)
    }
}

/// The name without control characters, at most 80 characters of it.
fn legible(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).take(80).collect()
}

/// Reads a file of an archive, whose checksum must hold.
struct MemberReader<R> {
    inner: CrcReader<R>,
    member: Member,
}

impl<R: Read> Read for MemberReader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        if n == 0 && !buffer.is_empty() && self.inner.crc().sum() != self.member.crc32 {
            let text = format!("{} in this ZIP archive is damaged: its checksum does not hold", self.member.name);
            return Err(io::Error::new(io::ErrorKind::InvalidData, text));
        }
        Ok(n)
    }
}

/// Unpacks gzip data of one or more members, and ignores the zeros that pad the last block.
struct Gunzip<R> {
    /// `None` after the last member.
    member: Option<GzDecoder<BufReader<R>>>,
}

impl<R: Read> Gunzip<R> {
    fn new(packed: R) -> Self {
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

/// Skips zeros; whether nothing else was left.
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
    use proptest::prelude::*;

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
    fn members_and_zeros_after_them_are_one_file() {
        let (one, two) = (packed(b"one "), packed(b"two"));
        for zeros in [0, 1, 511, 100_000] {
            let padding = vec![0; zeros];
            assert_eq!(unpacked(&[&*one, &two, &padding].concat()), (b"one two".to_vec(), true), "{zeros}");
        }
        assert_eq!(unpacked(&[&packed(b"")[..], &one].concat()), (b"one ".to_vec(), true));
    }

    #[test]
    fn other_bytes_after_it_and_a_cut_are_errors() {
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

    /// The text read from `bytes` in pieces of `step`.
    fn text(bytes: &[u8], step: usize) -> Vec<u8> {
        struct Slow(Cursor<Vec<u8>>, usize);
        impl Read for Slow {
            fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
                Read::take(&mut self.0, self.1 as u64).read(buffer)
            }
        }
        let mut text = Vec::new();
        as_utf8(Box::new(Slow(Cursor::new(bytes.to_vec()), step))).unwrap().read_to_end(&mut text).unwrap();
        text
    }

    #[test]
    fn bytes_that_only_begin_as_utf_16_are_unchanged() {
        for bytes in
            [&b""[..], b"\xff", b"\xff\xfe", b"\xff\xfe\0", b"\xfe\xff\0\0\0\0", b"\xff\xfe$VNYMR,\x80\x01", b"$VN"]
        {
            assert_eq!(text(bytes, 2), bytes, "{bytes:?}");
        }
    }

    proptest! {
        #[test]
        fn utf_16_of_either_order_is_the_same_text(
            begin in "[a-z,0-9]{40}", end in "[\u{20}-\u{7e}\u{b0}\u{1f600}\r\n]{0,300}", step in 1_usize..50,
        ) {
            let whole = begin + &end;
            let bytes = |unit: fn(u16) -> [u8; 2]| {
                "\u{feff}".encode_utf16().chain(whole.encode_utf16()).flat_map(unit).collect::<Vec<_>>()
            };
            prop_assert_eq!(text(&bytes(u16::to_le_bytes), step), whole.as_bytes());
            let big = bytes(u16::to_be_bytes);
            prop_assert_eq!(text(&big, step), whole.as_bytes());
            let cut = text(&big[..big.len() - 1], step);
            let begins_same = cut.iter().zip(whole.as_bytes()).take_while(|(read, written)| read == written).count();
            prop_assert!(begins_same + 4 >= whole.len());
        }
    }
}
