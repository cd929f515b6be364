//! The formats of captures, and which of them a file has: detected by its first bytes and never by
//! its name.

use std::io::{self, Read};

use vn100_protocol::{Decoder, Item, MESSAGES, Options, RejectReason, stream::MeasuredFrames};

use crate::{
    bag::BagForm,
    csv::{self, CsvPlan, Said},
    open_error::{OpenHint, Problem},
    recording,
};

/// Bytes of a file that are searched for a first sentence, because a boot log may precede it.
const HEAD_BYTES: usize = 1024 * 1024;

const MATLAB: &str = "a MATLAB file: save its columns there, as in writematrix([t gyro accel], 'imu.csv')";
const R_WORKSPACE: &str = "an R workspace: write.csv(NAME, 'imu.csv') makes a table of one of its data frames";
const PICKLE: &str =
    "a Python pickle: pandas.read_pickle('FILE').to_csv('imu.csv', index=False) makes a table of a frame";

/// Files that are no captures by their first bytes, unless a sentence is found in them.
const OTHERS: &[(&[u8], &str)] = &[
    (b"\x89PNG", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"%PDF", "a PDF document"),
    (b"MATLAB ", MATLAB),
    (
        b"\x89HDF\r\n\x1a\n",
        "an HDF5 file (a MATLAB file of version 7.3 is one): save its columns as CSV, with h5py and numpy.savetxt",
    ),
    (
        b"\x93NUMPY",
        "a NumPy array: numpy.savetxt('imu.csv', numpy.load('FILE.npy'), delimiter=',') makes a table of it",
    ),
    (b"RDX2", R_WORKSPACE),
    (b"RDX3", R_WORKSPACE),
    (b"X\n\0\0\0", "an R object: write.csv(readRDS('FILE.rds'), 'imu.csv') makes a table of a data frame"),
    (b"PAR1", "a Parquet file: pandas.read_parquet('FILE.parquet').to_csv('imu.csv', index=False) makes a table of it"),
    (b"ARROW1", "a Feather file: pandas.read_feather('FILE').to_csv('imu.csv', index=False) makes a table of it"),
    (b"\x80\x04\x95", PICKLE),
    (b"\x80\x05\x95", PICKLE),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "a document of Microsoft Office: save its sheet as CSV"),
    (
        b"ULog\x01\x12\x35",
        "a ULog of PX4: `ulog2csv FILE.ulg` of pyulog makes tables of it, of which sensor_combined is the IMU",
    ),
    (
        b"\xa3\x95\x80",
        "a dataflash log of ArduPilot: mavlogdump.py of pymavlink, with the format csv and the types IMU, makes a table of it",
    ),
    (b"H Product:Blackbox", "a log of Betaflight or iNav: `blackbox_decode FILE.bbl` makes a table of it"),
    (b"\xb5\x62", "messages of a u-blox receiver (UBX): pyubx2 or u-center make tables of them"),
    (b"\x75\x65", "messages of a MicroStrain sensor (MIP): SensorConnect exports them as CSV"),
    (b"\xff\x5a", "messages of an SBG sensor (sbgECom): `sbgBasicLogger` or sbgCenter export them as CSV"),
    (b"\xfa\xff\x36", "messages of an Xsens sensor (MTB): MT Manager exports them as text"),
    (b"\x7fELF", "a program"),
    (b"SQLite format 3", "an SQLite database"),
    (b"#ROSBAG", "a ROS bag without sentences"),
];

/// The format of a capture, after decompression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Sentences in text, with any line ending and with any text between them.
    Text,
    /// Bytes as received from the port: sentences, binary packets and all others.
    Raw,
    /// Rows of a CSV file: numbers, or sentences with their stamps.
    Csv,
    /// A recording of this program: the bytes with the times of their reads, and the link events.
    Mcap,
    /// A bag of ROS.
    Bag(BagForm),
}

impl Format {
    /// The code of the format in results.
    pub const fn code(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Raw => "raw",
            Self::Csv => "csv",
            Self::Mcap => "mcap",
            Self::Bag(form) => form.code(),
        }
    }
}

/// All formats but bags, which are read out of order: the endings of the names of their files, of
/// which some are those of other files too, and what of them is searched for in a file.
const FORMATS: [(&[&str], &str); 4] = [
    (&["log", "txt"], "VectorNav sentences ($VNYMR,… or $VNIMU,… with a checksum)"),
    (&["bin", "raw"], "0xFA binary packets"),
    (&["csv", "tsv"], "CSV columns of known names"),
    (&["mcap"], "MCAP recordings"),
];

/// Whether names of captures have this ending: that of a format, or a message that is measured
/// (`run.vnymr`), in any letter case.
pub(crate) fn is_capture_ending(ending: &str) -> bool {
    let ending = ending.to_ascii_lowercase();
    let is_message = MESSAGES.iter().any(|layout| layout.message.eq_ignore_ascii_case(&ending));
    is_message || BagForm::is_ending(&ending) || FORMATS.iter().any(|(endings, _)| endings.contains(&&*ending))
}

/// The error for a file in which `found` is and no capture.
fn no_capture(found: &str) -> Problem {
    let [before @ .., last] = FORMATS.map(|(_, sought)| sought);
    let before = before.join(", ");
    Problem::NotACapture(format!(
        "a capture this program reads: searched for {before} and {last}, also inside gzip, zstd, bzip2, xz and ZIP; found {found}"
    ))
}

/// Bytes that are searched for sentences between packets.
const MIXED_BYTES: usize = 4096;

/// The format detected from the head of a file.
#[derive(Debug)]
pub(crate) enum Detected {
    /// Sentences, packets or both, and the frames that are measured by default.
    Bytes(Format, MeasuredFrames),
    Csv(Box<CsvPlan>),
    /// A recording, or another MCAP file that is no bag.
    Mcap,
}

/// The first bytes of a capture, and the error that ended them early, if any. Reads the same bytes
/// as its source.
#[derive(Debug, Default)]
pub(crate) struct CaptureHead {
    pub(crate) bytes: Vec<u8>,
    shown: usize,
    fault: Option<io::Error>,
}

impl Read for CaptureHead {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = (&self.bytes[self.shown..]).read(buffer)?;
        self.shown += n;
        match self.fault.take_if(|_| n == 0) {
            Some(fault) => Err(fault),
            None => Ok(n),
        }
    }
}

/// Reads the head of `reader`, as far as needed to be certain, and detects its format.
///
/// Bytes that are not text and hold no sentence count as a raw capture: a port at the wrong baud
/// rate gives such bytes, and the user learns it from the result. With a map of columns
/// legible lines are read as CSV.
///
/// # Errors
/// If the file cannot be read, is no capture, or is a CSV file whose columns cannot be used.
pub(crate) fn detect_format(reader: &mut impl Read, said: Said<'_>) -> Result<(CaptureHead, Detected), Problem> {
    let mut head = CaptureHead::default();
    while head.bytes.len() < recording::MAGIC.len() && !head.grow(reader)?.is_empty() {}
    if head.bytes.starts_with(recording::MAGIC) {
        return Ok((head, Detected::Mcap));
    }
    let mut decoder = Decoder::new(Options { accept_unchecked: true });
    let mut sentence_seen = false;
    decoder.push(&head.bytes, |item| sentence_seen |= is_evidence(&item));
    while head.bytes.len() < HEAD_BYTES && !sentence_seen {
        let note = |item: Item<'_>| sentence_seen |= is_evidence(&item);
        let more = head.grow(reader)?;
        if more.is_empty() {
            decoder.finish(note);
            break;
        }
        decoder.push(more, note);
    }
    let text = is_text(&head.bytes);
    let other = other_by_its_head(&head.bytes).filter(|_| !text && !sentence_seen);
    if let Some(name) = other {
        return Err(no_capture(name));
    }
    // a line that begins with a sentence is no row
    if said.map.is_some() || !head.bytes.trim_ascii_start().starts_with(b"$") {
        // sentences stand below the names of their columns; if there are no names yet, a live stream is not delayed
        let may_be_csv = !sentence_seen || !matches!(csv::detect(&head.bytes, said), Ok(None));
        while may_be_csv && head.bytes.len() < csv::HEAD_BYTES && !head.grow(reader)?.is_empty() {}
        match csv::detect(&head.bytes, said) {
            Ok(Some(plan)) => return Ok((head, Detected::Csv(plan.into()))),
            // the sentences could be read without stamps, but the user would not learn that a word turns the stamps
            // into a time base
            Err(error) if matches!(error.hint(), Some(OpenHint::StampUnit(_) | OpenHint::DateOrder(_))) => {
                return Err(error.into());
            }
            Err(error) if (said.map.is_some() || !sentence_seen) && begins_legibly(&head.bytes) => {
                return Err(error.into());
            }
            Ok(None) | Err(_) => {}
        }
    }
    let detected = match (sentence_seen, text) {
        (true, true) => Detected::Bytes(Format::Text, MeasuredFrames::First),
        (false, true) => return Err(no_capture(&describe(&head.bytes))),
        (false, false) if head.bytes.iter().all(|byte| *byte == 0) => {
            return Err(no_capture("nothing but zero bytes"));
        }
        (_, false) => {
            // a live stream of sentences is not delayed
            while !holds_samples(&head.bytes) && head.bytes.len() < MIXED_BYTES && !head.grow(reader)?.is_empty() {}
            let is_of_sentences = holds_samples(&head.bytes);
            Detected::Bytes(
                Format::Raw,
                if is_of_sentences { MeasuredFrames::Sentences } else { MeasuredFrames::First },
            )
        }
    };
    Ok((head, detected))
}

/// Whether a sentence that is measured is among the first bytes.
fn holds_samples(head: &[u8]) -> bool {
    let mut holds_samples = false;
    Decoder::new(Options::default())
        .push(&head[..head.len().min(MIXED_BYTES)], |item| holds_samples |= matches!(item, Item::Sample(_)));
    holds_samples
}

impl CaptureHead {
    /// Reads a little more; nothing at the end or after an error.
    fn grow(&mut self, reader: &mut impl Read) -> io::Result<&[u8]> {
        let before = self.bytes.len();
        let mut piece = [0; 4096];
        loop {
            match reader.read(&mut piece) {
                Ok(n) => self.bytes.extend_from_slice(&piece[..n]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) if before == 0 => return Err(error),
                // the bytes before the error are still a capture
                Err(error) => self.fault = Some(error),
            }
            return Ok(&self.bytes[before..]);
        }
    }
}

/// A sample, a packet, or a sentence with the name of a VectorNav message.
fn is_evidence(item: &Item<'_>) -> bool {
    match item {
        Item::Sample(_) | Item::Packet(_) => true,
        Item::Reply(sentence) | Item::Other(sentence) => sentence.body.starts_with(b"VN"),
        Item::Rejected(rejected) => rejected.raw.starts_with(b"$VN") && rejected.kind != RejectReason::Truncated,
    }
}

/// The kind of a file that is no capture by its first bytes, in words.
fn other_by_its_head(head: &[u8]) -> Option<&'static str> {
    let by_magic = OTHERS.iter().find(|(magic, _)| head.starts_with(magic)).map(|&(_, name)| name);
    by_magic.or_else(|| is_matlab_4(head).then_some(MATLAB))
}

/// Whether `head` begins a matrix of MATLAB 4: its type, rows, columns, imaginary flag and the
/// length of its name, which ends with a zero, as 32-bit numbers (MAT-File Format, "Level 4").
fn is_matlab_4(head: &[u8]) -> bool {
    let Some((&header, rest)) = head.split_first_chunk::<20>() else { return false };
    let word = |place: usize| u32::from_le_bytes([0, 1, 2, 3].map(|byte| header[4 * place + byte]));
    let [kind, rows, columns, imaginary, name_length] = [0, 1, 2, 3, 4].map(word);
    let Some((&0, name)) = rest.get(..name_length as usize).and_then(<[u8]>::split_last) else { return false };
    let is_name = matches!(name, [first, ..] if first.is_ascii_alphabetic())
        && name.iter().all(|byte| byte.is_ascii_alphanumeric() || *byte == b'_');
    kind <= 52 && kind % 10 <= 2 && rows > 0 && columns > 0 && imaginary <= 1 && is_name
}

/// Whether the first two lines, of names and numbers, may be text in some encoding.
fn begins_legibly(head: &[u8]) -> bool {
    head.splitn(3, |&byte| byte == b'\n').take(2).all(has_no_controls)
}

fn has_no_controls(bytes: &[u8]) -> bool {
    bytes.iter().all(|&b| matches!(b, b'\t' | b'\r' | b'\n' | 0x20..=0x7e | 0x80..))
}

fn is_text(bytes: &[u8]) -> bool {
    // a character cut by the end of the head does not count against text
    has_no_controls(bytes) && std::str::from_utf8(bytes).err().is_none_or(|error| error.error_len().is_none())
}

fn describe(head: &[u8]) -> String {
    if head.is_empty() {
        return "an empty file".into();
    }
    let text = String::from_utf8_lossy(head);
    if text.contains("angular_velocity:") && text.contains("linear_acceleration:") {
        return "messages as rostopic echo prints them: rostopic echo -p prints a table, or give the bag itself".into();
    }
    if head.trim_ascii_start().starts_with(b"{") || head.trim_ascii_start().starts_with(b"[{") {
        let lines = if head.trim_ascii_start().starts_with(b"{") { ", lines=True" } else { "" };
        return format!("JSON: pandas.read_json('FILE'{lines}).to_csv('imu.csv', index=False) makes a table of it");
    }
    let mut nmea = None;
    Decoder::new(Options::default()).push(head, |item| {
        if let Item::Reply(sentence) | Item::Other(sentence) = item {
            let name = sentence.body.split(|byte| *byte == b',').next().unwrap_or_default();
            nmea.get_or_insert_with(|| String::from_utf8_lossy(name).into_owned());
        }
    });
    if let Some(name) = nmea {
        return format!("NMEA sentences of another device, such as ${name}, and no VectorNav sentence ($VN...)");
    }
    if head.starts_with(b"RDA2\n") || head.starts_with(b"RDA3\n") {
        return R_WORKSPACE.into();
    }
    let first = text.lines().map(str::trim).find(|line| !line.is_empty()).unwrap_or("");
    // U+0080 to U+009F control a terminal just like the control characters of ASCII
    let shown: String = first.chars().take(60).filter(|c| !c.is_control()).collect();
    let ellipsis = if first.chars().count() > 60 { "…" } else { "" };
    let how_much = if head.len() < HEAD_BYTES { "" } else { ", in its first megabyte," };
    format!("text that begins with \"{shown}{ellipsis}\" and{how_much} contains none of them")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a text alone is recognised as the text of a sensor.
    fn is_of_sensor(text: &str) -> bool {
        let mut is_one = false;
        Decoder::new(Options { accept_unchecked: true }).push(text.as_bytes(), |item| is_one |= is_evidence(&item));
        is_one
    }

    #[test]
    fn a_sensor_is_known_by_its_name() {
        for text in ["$VNRRG,07,40*5C\r\n", "$VNXYZ,1,2\r\n", "$VNYMR,1,2*00\r\n"] {
            assert!(is_of_sensor(text), "{text:?}");
        }
        // another device, a checksum mismatch, no checksum, a beginning without an end, no sentence
        for text in ["$GPHDT,1*52\r\n", "$GPHDT,1*00\r\n", "$GPHDT,1\r\n", "$VNYMR,1$VNYMR,1", "gyro_x,1\r\n"] {
            assert!(!is_of_sensor(text), "{text:?}");
        }
    }
}
