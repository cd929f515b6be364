//! A recording in several files: the start of the next file, and resuming.

use std::{
    collections::BTreeMap,
    fs,
    io::{self, ErrorKind},
    path::{Path, PathBuf},
};

use vn100_protocol::stream::{Chunk, StreamInput};

use super::{
    NamedFile, RecordError,
    resume::{begun_whole, claimed, serial_number},
};
use crate::recording::{
    RECORDING_METADATA, RESUMED,
    part::{RecordingPart, Rotation, existing_parts, part_path},
    reader::RecordingEnd,
    writer::{RecordingWriter, head},
};

/// The parts of a recording in progress.
pub(super) struct Parts {
    recording: PathBuf,
    metadata: BTreeMap<String, String>,
    rotation: Rotation,
    part: RecordingPart,
    begun_ns: Option<i64>,
    bytes: u64,
}

/// The facts about the existing parts.
#[derive(Default)]
struct Before {
    part: Option<RecordingPart>,
    end: Option<RecordingEnd>,
    serial: Option<String>,
}

impl Parts {
    /// Begins the first part; or, if the recording exists and may be resumed, the next part, which
    /// begins with the break. Returns the serial number in the earlier parts.
    pub(super) fn begin(
        recording: &Path,
        metadata: &BTreeMap<String, String>,
        rotation: Rotation,
        resume: bool,
    ) -> Result<(Self, PathBuf, RecordingWriter<NamedFile>, Option<String>), RecordError> {
        let failed = |source| RecordError::of(recording, source);
        let existing = existing_parts(recording).map_err(failed)?;
        if let Some(part) = existing.values().next_back().filter(|_| !resume) {
            return Err(RecordError::Exists(part.clone()));
        }
        let before = Before::of(&existing)?;
        let number = existing.keys().next_back().map_or(1, |last| last.saturating_add(1));
        let resumed = !existing.is_empty();
        let id = before.part.map_or_else(RecordingPart::new_id, |part| part.id);
        let part = RecordingPart { id, number, resumed };
        let parts = Self {
            recording: recording.to_owned(),
            metadata: metadata.clone(),
            rotation,
            part,
            begun_ns: None,
            bytes: 0,
        };
        let (path, mut writer) = parts.open().map_err(|source| match source.kind() {
            // no part follows the one with the largest number
            ErrorKind::AlreadyExists => RecordError::Exists(part_path(recording, number)),
            _ => failed(source),
        })?;
        if let Some(interruption) = before.end.as_ref().and_then(RecordingEnd::interruption) {
            writer.write(&StreamInput::Link(interruption)).and_then(|()| writer.flush()).map_err(failed)?;
        }
        Ok((parts, path, writer, before.serial))
    }

    /// Whether the recording existed before.
    pub(super) const fn is_resumed(&self) -> bool {
        self.part.resumed
    }

    /// The next part, if one begins before this input.
    pub(super) fn next_before(
        &mut self,
        input: &StreamInput,
    ) -> Option<io::Result<(PathBuf, RecordingWriter<NamedFile>)>> {
        let StreamInput::Chunk(Chunk { bytes, at_ns }) = input else { return None };
        let begun_ns = self.begun_ns.or(*at_ns);
        let is_due = match self.rotation {
            Rotation::Bytes(most) => self.bytes > 0 && self.bytes + bytes.len() as u64 > most,
            // a clock that is set back begins no part
            Rotation::Time(time) => at_ns.zip(begun_ns).is_some_and(|(at_ns, begun_ns)| {
                at_ns.checked_sub(begun_ns).is_some_and(|ns| ns >= 0 && ns as u128 >= time.as_nanos())
            }),
        };
        if !is_due {
            (self.begun_ns, self.bytes) = (begun_ns, self.bytes + bytes.len() as u64);
            return None;
        }
        (self.begun_ns, self.bytes) = (*at_ns, bytes.len() as u64);
        (self.part.number, self.part.resumed) = (self.part.number.saturating_add(1), false);
        Some(self.open())
    }

    fn open(&self) -> io::Result<(PathBuf, RecordingWriter<NamedFile>)> {
        let path = part_path(&self.recording, self.part.number);
        if fs::symlink_metadata(&path).is_ok() {
            return Err(ErrorKind::AlreadyExists.into());
        }
        let mut head = head(&self.metadata);
        for about in head.iter_mut().filter(|about| self.part.resumed && about.name == RECORDING_METADATA) {
            about.metadata.insert(RESUMED.into(), "true".into());
        }
        head.push(self.part.metadata());
        // if the program is killed meanwhile, it leaves no part without its identity
        let writer = begun_whole(&path, &head)?;
        Ok((path, writer))
    }
}

impl Before {
    /// Takes each value from the last part that has it.
    fn of(parts: &BTreeMap<u32, PathBuf>) -> Result<Self, RecordError> {
        let mut before = Self::default();
        for path in parts.values().rev() {
            let mut reader = claimed(path)?;
            before.part = before.part.or_else(|| reader.recorded().part.clone());
            let failed = |source| RecordError::Io { path: path.clone(), source };
            let serial = serial_number(&mut reader).map_err(failed)?;
            before.serial = before.serial.or(serial);
            let end = reader.recorded().end.get().filter(|end| end.ended_ns.is_some()).cloned();
            before.end = before.end.or(end);
            if before.part.is_some() && before.serial.is_some() && before.end.is_some() {
                break;
            }
        }
        Ok(before)
    }
}
