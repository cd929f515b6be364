//! The kit: one ZIP file with the recordings of all steps, in which the serial number is replaced,
//! and a manifest with their checksums.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    io::{Read, Seek, Write},
    ops::Range,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use tempfile::TempDir;
use vn100_capture::{Recorded, RecordingReader, RecordingWriter};
use vn100_protocol::{
    Check,
    stream::{LinkEventKind, StreamInput},
};
use zip::{CompressionMethod, ZipArchive, ZipWriter, write::SimpleFileOptions};

use crate::digest::hex;

const SCHEMA: &str = "vn100.witness/1";
const MANIFEST: &str = "manifest.json";

/// The register of the serial number.
const SERIAL: u8 = 3;

/// Of a serial number that is replaced wherever it stands, and not in replies alone.
const LEAST_DIGITS: usize = 6;

/// More than the recording of a step can have.
const MOST_BYTES: u64 = 1 << 28;

/// What a kit says of itself.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Manifest {
    schema: String,
    /// The program that recorded it.
    program: String,
    /// The system it ran on.
    system: String,
    /// Model, hardware and firmware, as the sensor replied; empty if it did not.
    pub(super) sensor: BTreeMap<String, String>,
    /// The first four digits of the SHA-256 of the serial number, which recognise the sensor: many
    /// numbers share them. `None` if the sensor did not reply.
    serial_sha256: Option<String>,
    /// What the owner says of the measurement.
    conditions: BTreeMap<String, String>,
    recordings: Vec<Packed>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Packed {
    file: String,
    bytes: u64,
    sha256: String,
}

/// A kit that was read, its recordings in a folder that lasts as long.
pub(super) struct Kit {
    pub(super) manifest: Manifest,
    folder: TempDir,
}

impl Kit {
    /// Packs the recordings, whose names tell their steps.
    pub(super) fn pack(
        kit: impl Write + Seek,
        recordings: &[PathBuf],
        conditions: &BTreeMap<String, String>,
    ) -> Result<()> {
        let all = recordings.iter().map(|path| read_recording(path)).collect::<Result<Vec<_>>>()?;
        let mut serial = None;
        for (path, (inputs, _)) in recordings.iter().zip(&all) {
            for found in replies(&stream(inputs), SERIAL) {
                if *serial.get_or_insert_with(|| found.clone()) != found {
                    bail!("{} is of another sensor: remove it, and the same command records it", path.display());
                }
            }
        }
        let first = stream(&all.first().context("a kit has recordings")?.0);
        let names = [(1, "model"), (2, "hardware"), (4, "firmware")];
        let sensor = names.map(|(number, name)| Some((name.to_owned(), replies(&first, number).next()?)));
        let digest = serial.as_deref().map(|serial| hex(&Sha256::digest(serial)[..2]));
        let secret = serial.as_deref().zip(digest.as_deref());
        let without = |texts: &BTreeMap<String, String>| {
            let mut texts = texts.clone();
            if let Some((serial, digest)) = secret {
                texts.values_mut().for_each(|text| *text = without_serial(text, serial, digest));
            }
            texts
        };
        let mut manifest = Manifest {
            schema: SCHEMA.into(),
            program: format!("vn100 {}", env!("CARGO_PKG_VERSION")),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            sensor: sensor.into_iter().flatten().collect(),
            serial_sha256: digest.clone(),
            conditions: without(conditions),
            recordings: Vec::new(),
        };
        let mut zip = ZipWriter::new(kit);
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        for (path, (mut inputs, recorded)) in recordings.iter().zip(all) {
            if let Some((serial, digest)) = secret {
                replace_serial(&mut inputs, serial, digest);
            }
            let mut copy = RecordingWriter::new(Vec::new(), &without(&recorded.metadata))?;
            inputs.iter().try_for_each(|input| copy.write(input))?;
            let bytes = copy.finish(recorded.end.get().and_then(|end| end.reason.as_deref()))?;
            let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            zip.start_file(&file, options)?;
            zip.write_all(&bytes)?;
            manifest.recordings.push(Packed { file, bytes: bytes.len() as u64, sha256: hex(&Sha256::digest(&bytes)) });
        }
        zip.start_file(MANIFEST, options)?;
        zip.write_all(&serde_json::to_vec_pretty(&manifest)?)?;
        zip.finish()?;
        Ok(())
    }

    /// Reads a kit; an error if a recording is not the one that was packed.
    pub(super) fn open(kit: &Path) -> Result<Self> {
        let name = kit.display();
        let file = File::open(kit).with_context(|| format!("cannot open {name}"))?;
        let mut zip = ZipArchive::new(file).with_context(|| format!("{name} is no kit"))?;
        let manifest = member(&mut zip, MANIFEST).with_context(|| format!("{name} is no kit"))?;
        let manifest: Manifest = serde_json::from_slice(&manifest).with_context(|| format!("{name}: {MANIFEST}"))?;
        if manifest.schema != SCHEMA {
            bail!("{name} has the schema {:?}, and this program reads {SCHEMA}", manifest.schema);
        }
        let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
        for Packed { file, bytes, sha256 } in &manifest.recordings {
            let content = member(&mut zip, file).with_context(|| format!("{name}: {file}"))?;
            if content.len() as u64 != *bytes || hex(&Sha256::digest(&content)) != *sha256 {
                bail!("{name}: {file} is not the recording that was packed: its checksum differs");
            }
            // the name is that of a file, whatever the manifest says
            let file = Path::new(file).file_name().with_context(|| format!("{name}: {file:?} is no name of a file"))?;
            let path = folder.path().join(file);
            fs::write(&path, content).context("cannot write a temporary file")?;
            let stream = stream(&read_recording(&path)?.0);
            let digest = manifest.serial_sha256.as_deref().unwrap_or_default();
            if values(&stream, SERIAL).any(|value| stream[value.clone()] != *pseudonym(digest, value.len()).as_bytes())
            {
                bail!("{name}: {} has a serial number that was not replaced: give this kit to no one", file.display());
            }
        }
        Ok(Self { manifest, folder })
    }

    /// The recording of a step; `None` if the kit does not have it.
    pub(super) fn recording(&self, step: &str) -> Option<PathBuf> {
        Some(self.folder.path().join(format!("{step}.mcap"))).filter(|path| path.exists())
    }
}

fn member(zip: &mut ZipArchive<File>, name: &str) -> Result<Vec<u8>> {
    let mut content = Vec::new();
    zip.by_name(name)?.take(MOST_BYTES).read_to_end(&mut content)?;
    Ok(content)
}

/// What a recording has, and what it says of itself.
fn read_recording(path: &Path) -> Result<(Vec<StreamInput>, Recorded)> {
    let name = || format!("cannot read {}", path.display());
    let mut reader = RecordingReader::open(File::open(path).with_context(name)?).with_context(name)?;
    let mut inputs = Vec::new();
    while let Some(input) = reader.next_input().with_context(name)? {
        inputs.push(input);
    }
    Ok((inputs, reader.recorded().clone()))
}

/// The bytes of all reads in sequence: a reply may begin in one and end in another.
fn stream(inputs: &[StreamInput]) -> Vec<u8> {
    let bytes = inputs.iter().filter_map(|input| match input {
        StreamInput::Chunk(chunk) => Some(&chunk.bytes[..]),
        StreamInput::Link(_) => None,
    });
    bytes.collect::<Vec<_>>().concat()
}

/// Where the values are that the sensor replied when it was asked for a register, whole or cut.
fn values(stream: &[u8], register: u8) -> impl Iterator<Item = Range<usize>> {
    const BEGIN: &[u8] = b"VNRRG,";
    let begins = stream.windows(BEGIN.len()).enumerate().filter(|(_, bytes)| *bytes == BEGIN);
    begins.filter_map(move |(at, _)| {
        let number = at + BEGIN.len();
        let comma = number + stream[number..].iter().position(|byte| *byte == b',')?;
        let is_asked = str::from_utf8(&stream[number..comma]).ok()?.parse() == Ok(register);
        let is_value = |byte: &&u8| byte.is_ascii_graphic() && !b"*$".contains(byte);
        let length = stream[comma + 1..].iter().take_while(is_value).count();
        is_asked.then_some(comma + 1..comma + 1 + length)
    })
}

/// The values of a register in whole sentences; an empty one says nothing.
fn replies(stream: &[u8], register: u8) -> impl Iterator<Item = String> {
    let is_whole = |value: &Range<usize>| stream.get(value.end) == Some(&b'\r') || checked(stream, value).is_some();
    let said = values(stream, register).filter(|value| !value.is_empty());
    said.filter(is_whole).map(|value| String::from_utf8_lossy(&stream[value]).into_owned())
}

/// The check of the sentence that ends with this value, its body, and where its digits are; `None`
/// if they do not agree.
fn checked(stream: &[u8], value: &Range<usize>) -> Option<(Check, Range<usize>, Range<usize>)> {
    let body = stream[..value.start].iter().rposition(|byte| *byte == b'$')? + 1..value.end;
    [Check::Crc16, Check::Xor8].into_iter().find_map(|check| {
        let digits = check.digits(&stream[body.clone()])?.to_string();
        let place = value.end + 1..value.end + 1 + digits.len();
        let agrees = stream[value.end..].starts_with(format!("*{digits}").as_bytes());
        agrees.then(|| (check, body.clone(), place))
    })
}

/// Digits in place of so many of a serial number; they tell no more of it than the manifest.
fn pseudonym(digest: &str, length: usize) -> String {
    let number = format!("{:0>length$}", u16::from_str_radix(digest, 16).unwrap_or_default());
    number[number.len() - length..].to_owned()
}

fn without_serial(text: &str, serial: &str, digest: &str) -> String {
    if serial.len() < LEAST_DIGITS { text.to_owned() } else { text.replace(serial, &pseudonym(digest, serial.len())) }
}

/// Replaces the serial number in all that a recording has, in cut replies as well.
fn replace_serial(inputs: &mut [StreamInput], serial: &str, digest: &str) {
    let mut bytes = stream(inputs);
    // so few digits are in measured values too
    let is_long = serial.len() >= LEAST_DIGITS;
    let found = bytes.windows(serial.len().max(1)).enumerate();
    let found = found.filter(|(_, found)| is_long && *found == serial.as_bytes());
    let found = found.map(|(at, _)| at..at + serial.len());
    for value in values(&bytes, SERIAL).chain(found).collect::<Vec<_>>() {
        let check = checked(&bytes, &value);
        bytes[value.clone()].copy_from_slice(pseudonym(digest, value.len()).as_bytes());
        if let Some((check, body, place)) = check {
            let digits = check.digits(&bytes[body]).map(|digits| digits.to_string());
            bytes[place].copy_from_slice(digits.unwrap_or_default().as_bytes());
        }
    }
    let mut rest = &bytes[..];
    for input in inputs {
        match input {
            StreamInput::Chunk(chunk) => {
                let (read, behind) = rest.split_at(chunk.bytes.len());
                (chunk.bytes, rest) = (read.to_vec().into(), behind);
            }
            StreamInput::Link(event) => match &mut event.kind {
                LinkEventKind::Up { port: text, .. }
                | LinkEventKind::Down { cause: text }
                | LinkEventKind::PortShared { program: text }
                | LinkEventKind::Marked { text } => *text = without_serial(text, serial, digest),
                _ => {}
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};
    use vn100_protocol::stream::{Chunk, LinkEvent};

    use super::*;

    fn chunk(bytes: &[u8], at_ns: i64) -> StreamInput {
        Chunk { bytes: bytes.to_vec().into(), at_ns: Some(at_ns) }.into()
    }

    fn record(path: &Path, inputs: &[StreamInput], metadata: &BTreeMap<String, String>) {
        let mut writer = RecordingWriter::new(File::create(path).unwrap(), metadata).unwrap();
        inputs.iter().for_each(|input| writer.write(input).unwrap());
        writer.finish(None).unwrap();
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Wherever reads and messages end, the kit has no digit of the serial number, of a cut reply
        /// neither, and every sentence keeps its length and has the right check.
        #[test]
        fn a_kit_does_not_tell_the_serial_number(
            serial in "[1-9]{9,10}",
            lengths in vec((1_usize..40, 0_i64..60_000_000), 1..40),
            cut in 0_usize..9,
            is_crc: bool,
        ) {
            let check = if is_crc { Check::Crc16 } else { Check::Xor8 };
            let of = |serial: &str| {
                let cut = &serial[..cut];
                let [model, reply] = ["VNRRG,01,VN-100", &format!("VNRRG,03,{serial}")].map(|body| check.sentence(body));
                format!("{model}\u{1}{reply}$VNRRG,03,{cut}\0$VNRRG,3,{serial}\r\nof {serial}{reply}")
            };
            let before = of(&serial);
            let (mut rest, mut now, mut inputs) = (before.as_bytes(), 0, Vec::new());
            for (length, later) in lengths {
                let (read, behind) = rest.split_at(length.min(rest.len()));
                (rest, now) = (behind, now + later);
                inputs.push(chunk(read, now));
                let cause = format!("{serial} is gone");
                inputs.push(StreamInput::Link(LinkEvent { at_ns: now, kind: LinkEventKind::Down { cause } }));
            }
            inputs.push(chunk(rest, now + 1));
            let conditions = BTreeMap::from([("of".to_owned(), serial.clone())]);
            let folder = tempfile::tempdir().unwrap();
            let (recording, kit) = (folder.path().join("as-found.mcap"), folder.path().join("kit.zip"));
            record(&recording, &inputs, &conditions);
            Kit::pack(File::create(&kit).unwrap(), std::slice::from_ref(&recording), &conditions).unwrap();
            let opened = Kit::open(&kit).unwrap();
            let digest = opened.manifest.serial_sha256.clone().unwrap();
            prop_assert_eq!(digest.len(), 4);
            let (replaced, recorded) = read_recording(&opened.recording("as-found").unwrap()).unwrap();
            let other = pseudonym(&digest, serial.len());
            let after = of(&other).replace(&format!("{}\0", &other[..cut]), &format!("{}\0", pseudonym(&digest, cut)));
            prop_assert_eq!(String::from_utf8(stream(&replaced)).unwrap(), after);
            prop_assert_eq!(&recorded.metadata["of"], &other);
            for (input, replaced) in inputs.iter().filter(|input| !matches!(input, StreamInput::Chunk(chunk) if chunk.bytes.is_empty())).zip(&replaced) {
                match (input, replaced) {
                    (StreamInput::Chunk(old), StreamInput::Chunk(new)) => {
                        prop_assert_eq!((old.bytes.len(), old.at_ns), (new.bytes.len(), new.at_ns));
                    }
                    (_, StreamInput::Link(event)) => {
                        let cause = format!("{other} is gone");
                        prop_assert_eq!(&event.kind, &LinkEventKind::Down { cause });
                    }
                    other => prop_assert!(false, "{:?}", other),
                }
            }
        }
    }

    #[test]
    fn a_reply_without_or_with_a_short_serial_number_costs_no_measured_sentence() {
        let measured = Check::Xor8.sentence("VNYMR,+001.5,-010.25");
        for serial in ["", "1", "0", "25"] {
            let folder = tempfile::tempdir().unwrap();
            let (recording, kit) = (folder.path().join("as-found.mcap"), folder.path().join("kit.zip"));
            let reply = Check::Xor8.sentence(&format!("VNRRG,03,{serial}"));
            let conditions = BTreeMap::from([("temperature".to_owned(), "10.25".to_owned())]);
            record(&recording, &[chunk(format!("{reply}{measured}").as_bytes(), 1)], &conditions);
            Kit::pack(File::create(&kit).unwrap(), std::slice::from_ref(&recording), &conditions).unwrap();
            let opened = Kit::open(&kit).unwrap();
            let (inputs, recorded) = read_recording(&opened.recording("as-found").unwrap()).unwrap();
            assert!(String::from_utf8(stream(&inputs)).unwrap().ends_with(&measured), "{serial:?}");
            assert_eq!(recorded.metadata["temperature"], "10.25", "{serial:?}");
            assert_eq!(opened.manifest.serial_sha256.is_some(), !serial.is_empty());
        }
    }

    #[test]
    fn a_kit_of_two_sensors_or_with_a_serial_number_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let recordings = ["a.mcap", "b.mcap"].map(|name| folder.path().join(name));
        let kit = folder.path().join("kit.zip");
        let pack = || Kit::pack(File::create(&kit).unwrap(), &recordings, &BTreeMap::new());
        let of = |path: &Path, serial: &str| {
            let reply = Check::Xor8.sentence(&format!("VNRRG,03,{serial}"));
            record(path, &[chunk(reply.as_bytes(), 1)], &BTreeMap::new());
        };
        of(&recordings[0], "0100071234");
        of(&recordings[1], "0100071235");
        let error = pack().unwrap_err().to_string();
        assert!(error.contains("b.mcap is of another sensor"), "{error}");
        of(&recordings[1], "0100071234");
        pack().unwrap();
        // a member of another kit, or of one that an older program packed
        let mut manifest = Kit::open(&kit).unwrap().manifest;
        let bytes = fs::read(&recordings[0]).unwrap();
        manifest.recordings.truncate(1);
        manifest.recordings[0].sha256 = hex(&Sha256::digest(&bytes));
        let mut packed = ZipWriter::new(File::create(&kit).unwrap());
        for (name, content) in [(MANIFEST, serde_json::to_vec(&manifest).unwrap()), ("a.mcap", bytes)] {
            packed.start_file(name, SimpleFileOptions::default()).unwrap();
            packed.write_all(&content).unwrap();
        }
        packed.finish().unwrap();
        let error = Kit::open(&kit).err().unwrap().to_string();
        assert!(error.contains("a.mcap has a serial number that was not replaced"), "{error}");
    }

    #[test]
    fn a_kit_with_a_changed_recording_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (recording, kit) = (folder.path().join("as-found.mcap"), folder.path().join("kit.zip"));
        record(&recording, &[chunk(b"$VNRRG,01,VN-100*00\r\n$VNRRG,01,VN-100S\r\n", 1)], &BTreeMap::new());
        Kit::pack(File::create(&kit).unwrap(), std::slice::from_ref(&recording), &BTreeMap::new()).unwrap();
        let opened = Kit::open(&kit).unwrap();
        assert_eq!(opened.manifest.sensor["model"], "VN-100S");
        assert!(opened.recording("as-found").is_some() && opened.recording("unplug").is_none());
        // the same content in a kit whose manifest says something else
        let mut zip = ZipArchive::new(File::open(&kit).unwrap()).unwrap();
        let manifest = String::from_utf8(member(&mut zip, MANIFEST).unwrap()).unwrap();
        let changed = folder.path().join("changed.zip");
        let mut packed = ZipWriter::new(File::create(&changed).unwrap());
        for (name, content) in [(MANIFEST, manifest.as_bytes()), ("as-found.mcap", b"another")] {
            packed.start_file(name, SimpleFileOptions::default()).unwrap();
            packed.write_all(content).unwrap();
        }
        packed.finish().unwrap();
        let error = Kit::open(&changed).err().unwrap().to_string();
        assert!(error.contains("as-found.mcap is not the recording that was packed"), "{error}");
        assert!(Kit::open(&recording).is_err(), "no ZIP file");
    }
}
