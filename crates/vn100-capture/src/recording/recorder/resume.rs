//! A recording is resumed in a copy in the same folder, which replaces it once the copy is synced
//! to the disk.

use std::{
    collections::BTreeMap,
    ffi::OsString,
    fs::{self, File},
    io::{self, ErrorKind, Read},
    path::{Path, PathBuf},
};

use mcap::records::Metadata;
use vn100_protocol::Register;
use vn100_protocol::stream::{ReadOptions, SampleReader, StreamInput};

use super::{NamedFile, RecordError};
use crate::recording::{
    FORMAT, HEAD_BYTES, RECORDING_METADATA, RESUMED, is_ours,
    reader::{Entry, RecordingEnd, RecordingError, RecordingReader},
    writer::{RecordingWriter, head},
};

/// Replaces the recording by a copy of its readable part, and returns a writer that appends to it
/// and the last serial number in it. The recording is not changed until the copy is on the disk.
pub(super) fn resume(
    path: &Path,
    metadata: &BTreeMap<String, String>,
) -> Result<(RecordingWriter<NamedFile>, Option<String>), RecordError> {
    let failed = |source| RecordError::of(path, source);
    let found = fs::symlink_metadata(path).map_err(failed)?;
    if found.is_symlink() {
        return Err(RecordError::SymbolicLink(path.to_owned()));
    }
    if !found.is_file() {
        return Err(RecordError::NotAFile(path.to_owned()));
    }
    let not_resumable = |problem| RecordError::NotResumable { path: path.to_owned(), problem };
    // claimed until the copy has replaced it
    let mut recording = claimed(path)?;
    if !recording.has_our_topics() {
        return Err(not_resumable(RecordingError::NotBegun));
    }
    if recording.recorded().started_ns == Some(0) {
        return Err(not_resumable(RecordingError::Undated));
    }
    let (copy, file) = Copy::beside(path).map_err(failed)?;
    let mut begin = recording.head.clone();
    for about in begin.iter_mut().filter(|metadata| metadata.name == RECORDING_METADATA) {
        about.metadata.insert(RESUMED.into(), "true".into());
        about.metadata.insert("format".into(), FORMAT.into());
    }
    let mut writer = RecordingWriter::begin(NamedFile(file.try_clone().map_err(failed)?), &begin).map_err(failed)?;
    let serial = copy_inputs(&mut recording, &mut writer).map_err(failed)?;
    let topics = recording.other_topics();
    if !topics.is_empty() {
        return Err(not_resumable(RecordingError::Mixed(topics)));
    }
    writer.put_metadata(&head(metadata)).and_then(|()| writer.flush()).map_err(failed)?;
    file.sync_all().map_err(failed)?;
    copy.take_place_of(path).map_err(failed)?;
    Ok((writer, serial))
}

/// Opens a recording, which is claimed for this program while it is read.
pub(super) fn claimed(path: &Path) -> Result<RecordingReader<File>, RecordError> {
    let file = File::open(path).map_err(|source| RecordError::Io { path: path.to_owned(), source })?;
    if !NamedFile::claim(&file) {
        return Err(RecordError::InUse(path.to_owned()));
    }
    RecordingReader::open(file).map_err(|problem| RecordError::NotResumable { path: path.to_owned(), problem })
}

/// Copies all readable inputs, and marks the break. Returns the last serial number in them.
fn copy_inputs(
    recording: &mut RecordingReader<impl Read>,
    writer: &mut RecordingWriter<NamedFile>,
) -> io::Result<Option<String>> {
    let mut serial = SerialNumber::new();
    while let Some(entry) = recording.next_entry()? {
        match entry {
            Entry::Input(input) => {
                serial.look_in(&input);
                writer.write(&input)?;
            }
            Entry::Metadata(metadata) => writer.put_metadata(&[metadata])?,
        }
    }
    if let Some(interruption) = recording.recorded().end.get().and_then(RecordingEnd::interruption) {
        writer.write(&StreamInput::Link(interruption))?;
    }
    Ok(serial.found)
}

/// Reads a recording to its end to find the last serial number in it.
pub(super) fn serial_number(recording: &mut RecordingReader<impl Read>) -> io::Result<Option<String>> {
    let mut serial = SerialNumber::new();
    while let Some(input) = recording.next_input()? {
        serial.look_in(&input);
    }
    Ok(serial.found)
}

struct SerialNumber {
    parser: SampleReader,
    found: Option<String>,
}

impl SerialNumber {
    fn new() -> Self {
        Self { parser: SampleReader::new(ReadOptions::default()), found: None }
    }

    fn look_in(&mut self, input: &StreamInput) {
        let StreamInput::Chunk(chunk) = input else { return };
        self.parser.push(&chunk.bytes, None);
        let registers = self.parser.take_batches().into_iter().flat_map(|batch| batch.registers);
        if let Some(value) = registers.filter(|value| value.register == Register::SERIAL_NUMBER).last() {
            self.found = Some(value.fields.to_string());
        }
    }
}

/// A copy that has not replaced the recording yet; it is deleted when dropped before it does.
struct Copy {
    path: PathBuf,
}

impl Copy {
    /// An empty copy; it replaces one that a killed program has left.
    fn beside(recording: &Path) -> io::Result<(Self, File)> {
        let mut name = OsString::from(".");
        name.push(recording.file_name().unwrap_or_default());
        name.push(".resuming");
        let copy = Self { path: recording.with_file_name(name) };
        match fs::remove_file(&copy.path) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let file = File::create_new(&copy.path)?;
        NamedFile::claim(&file);
        Ok((copy, file))
    }

    fn take_place_of(self, recording: &Path) -> io::Result<()> {
        fs::rename(&self.path, recording)?;
        // the name is on the disk once its folder is
        #[cfg(unix)]
        File::open(crate::recording::part::folder_of(recording))?.sync_all()?;
        Ok(())
    }
}

impl Drop for Copy {
    fn drop(&mut self) {
        // it was renamed if it has replaced the recording
        let _ = fs::remove_file(&self.path);
    }
}

/// Whether a file without inputs is the beginning of a recording of this program.
pub(super) fn begins_as_ours(path: &Path) -> bool {
    let mut beginning = Vec::new();
    let read = File::open(path).and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut beginning));
    // a file that was cut so early has only the beginning common to all MCAP files
    read.is_ok_and(|length| length < HEAD_BYTES as usize || is_ours(&beginning))
}

/// Begins a new recording under another name, and renames it to `path` once its head is on the
/// disk; a file of that name is replaced.
pub(super) fn begun_whole(path: &Path, head: &[Metadata]) -> io::Result<RecordingWriter<NamedFile>> {
    let (copy, file) = Copy::beside(path)?;
    let writer = RecordingWriter::begin(NamedFile(file.try_clone()?), head)?;
    file.sync_all()?;
    copy.take_place_of(path)?;
    Ok(writer)
}
