//! The kit: one ZIP file with the recordings of all steps, in which the serial number is replaced,
//! and a manifest with their checksums.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    io::{Read, Seek, Write},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use tempfile::TempDir;
use zip::{CompressionMethod, ZipArchive, ZipWriter, write::SimpleFileOptions};

use crate::digest::hex;

const SCHEMA: &str = "vn100.witness/1";
const MANIFEST: &str = "manifest.json";

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
    /// SHA-256 of the serial number; `None` if the sensor did not reply.
    serial_sha256: Option<String>,
    /// What the owner says of the measurement.
    conditions: BTreeMap<String, String>,
    recordings: Vec<Recorded>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Recorded {
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
        let read = |path: &PathBuf| fs::read(path).with_context(|| format!("cannot read {}", path.display()));
        let first = read(recordings.first().context("a kit has recordings")?)?;
        let reply = |number: u8| reply(&first, number);
        let serial = reply(3);
        let names = [(1, "model"), (2, "hardware"), (4, "firmware")];
        let sensor = names.into_iter().filter_map(|(number, name)| Some((name.to_owned(), reply(number)?)));
        let mut manifest = Manifest {
            schema: SCHEMA.into(),
            program: format!("vn100 {}", env!("CARGO_PKG_VERSION")),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            sensor: sensor.collect(),
            serial_sha256: serial.as_deref().map(|serial| hex(&Sha256::digest(serial))),
            conditions: conditions.clone(),
            recordings: Vec::new(),
        };
        let mut zip = ZipWriter::new(kit);
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        for path in recordings {
            let mut bytes = read(path)?;
            if let Some(serial) = &serial {
                replace(&mut bytes, serial.as_bytes(), pseudonym(serial).as_bytes());
            }
            let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            zip.start_file(&file, options)?;
            zip.write_all(&bytes)?;
            manifest.recordings.push(Recorded {
                file,
                bytes: bytes.len() as u64,
                sha256: hex(&Sha256::digest(&bytes)),
            });
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
        for Recorded { file, bytes, sha256 } in &manifest.recordings {
            let content = member(&mut zip, file).with_context(|| format!("{name}: {file}"))?;
            if content.len() as u64 != *bytes || hex(&Sha256::digest(&content)) != *sha256 {
                bail!("{name}: {file} is not the recording that was packed: its checksum differs");
            }
            // the name is that of a file, whatever the manifest says
            let file = Path::new(file).file_name().with_context(|| format!("{name}: {file:?} is no name of a file"))?;
            fs::write(folder.path().join(file), content).context("cannot write a temporary file")?;
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

/// What the sensor replied when it was asked for this register.
fn reply(recording: &[u8], register: u8) -> Option<String> {
    let begin = format!("$VNRRG,{register:02},");
    let at = recording.windows(begin.len()).position(|bytes| bytes == begin.as_bytes())?;
    let value = recording[at + begin.len()..].split(|byte| *byte == b'*').next()?;
    Some(String::from_utf8_lossy(value).into_owned()).filter(|value| value.len() < 100)
}

/// Digits in place of a serial number: as many, the same for the same number, and with the same
/// checksum of a sentence, the exclusive or of all bytes.
fn pseudonym(serial: &str) -> String {
    let checksum = |text: &str| text.bytes().fold(0, |sum, byte| sum ^ byte);
    let mut digest = Sha256::digest(serial);
    loop {
        let digits = serial.bytes().zip(digest.iter().cycle()).map(|(byte, random)| match byte.is_ascii_digit() {
            true => char::from(b'0' + random % 10),
            false => char::from(byte),
        });
        let digits: String = digits.collect();
        // one in ten does, but of a single digit only that itself
        if checksum(&digits) == checksum(serial) {
            return digits;
        }
        digest = Sha256::digest(digest);
    }
}

fn replace(bytes: &mut [u8], old: &[u8], new: &[u8]) {
    let mut from = 0;
    while let Some(at) = bytes[from..].windows(old.len()).position(|found| found == old) {
        bytes[from + at..from + at + old.len()].copy_from_slice(new);
        from += at + old.len();
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_pseudonym_keeps_the_form_and_the_checksum_of_a_sentence(serial in "[0-9]{6,10}") {
            let checksum = |text: &str| text.bytes().fold(0, |sum, byte| sum ^ byte);
            let other = pseudonym(&serial);
            prop_assert_eq!(&other, &pseudonym(&serial));
            prop_assert!(other.len() == serial.len() && other.bytes().all(|byte| byte.is_ascii_digit()));
            prop_assert_eq!(checksum(&other), checksum(&serial));
        }
    }

    #[test]
    fn a_kit_with_a_changed_recording_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (recording, kit) = (folder.path().join("as-found.mcap"), folder.path().join("kit.zip"));
        fs::write(&recording, "$VNRRG,01,VN-100*45\r\n$VNRRG,03,0100071234*00\r\n").unwrap();
        Kit::pack(File::create(&kit).unwrap(), std::slice::from_ref(&recording), &BTreeMap::new()).unwrap();
        let opened = Kit::open(&kit).unwrap();
        assert_eq!(opened.manifest.sensor["model"], "VN-100");
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
