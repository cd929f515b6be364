//! Records a link while it is measured, to a new file or behind a recording that is there.

use std::{
    collections::BTreeMap,
    ffi::OsString,
    fs::{self, File, TryLockError},
    io::{self, ErrorKind, Read, Write},
    path::{Path, PathBuf},
    sync::{Arc, OnceLock},
    thread,
};

use bytes::Bytes;
use tokio::sync::{mpsc, watch};
use vn100_protocol::Register;
use vn100_protocol::stream::{Chunk, LinkEvent, LinkEventKind, ReadOptions, SampleReader, StreamInput};

use super::{
    FORMAT, RECORDING_METADATA, RESUMED,
    reader::{Entry, RecordingEnd, RecordingError, RecordingReader},
    writer::{RecordingWriter, head},
};

/// Inputs that may wait for the disk: five seconds of 200 reads. The sender drops the others.
const WAITING_INPUTS: usize = 1024;

/// A killed program loses no more of the stream than this.
const FLUSH_EVERY_NS: u64 = 1_000_000_000;

/// Why a recording cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The operating system refused.
    #[error("cannot record to {}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Its error.
        source: io::Error,
    },
    /// A file of this name is there.
    #[error("{} exists and is not replaced: choose another name, or resume it", .0.display())]
    Exists(PathBuf),
    /// To resume a recording replaces its file, and a symbolic link would be replaced instead.
    #[error("{} is a symbolic link: name the recording itself to resume it", .0.display())]
    SymbolicLink(PathBuf),
    /// Another program records to it.
    #[error("{} is being recorded to: end that first", .0.display())]
    InUse(PathBuf),
    /// What is there is no recording that can be resumed.
    #[error("{} cannot be resumed: {problem}", path.display())]
    NotResumable {
        /// The file.
        path: PathBuf,
        /// What it is instead.
        problem: RecordingError,
    },
}

/// The state of a recording.
#[derive(Debug, Clone)]
pub struct RecordingState {
    /// The file.
    pub path: PathBuf,
    /// Bytes of the stream that this recorder has handed to the file.
    pub bytes: u64,
    /// Why it stopped, if it did: a full disk, or a file that was removed meanwhile. The file holds
    /// what came before, and the measurement continues.
    pub error: Option<Arc<io::Error>>,
    /// Whether it is over, by [`Recorder::finish`] or by an error.
    pub ended: bool,
}

/// Writes what a link delivers to a file, on a thread of its own.
///
/// The file is flushed whenever a second of stream has passed, and with each
/// link event. A recorder that is dropped ends its file without a reason, on its own time.
#[derive(Debug)]
pub struct Recorder {
    inputs: mpsc::Sender<StreamInput>,
    state: watch::Receiver<RecordingState>,
    reason: Arc<OnceLock<String>>,
    known_serial: Option<String>,
}

impl Recorder {
    /// Begins a new file; `metadata` is what a replay shall know of it. No file is ever replaced.
    ///
    /// # Errors
    /// [`RecordError::Exists`] when there is something of this name, [`RecordError::Io`] when the
    /// file cannot be written.
    pub fn create(path: impl AsRef<Path>, metadata: &BTreeMap<String, String>) -> Result<Self, RecordError> {
        let path = path.as_ref();
        let failed = |source| RecordError::Io { path: path.to_owned(), source };
        let file = File::create_new(path).map_err(|source| match source.kind() {
            ErrorKind::AlreadyExists => RecordError::Exists(path.to_owned()),
            _ => failed(source),
        })?;
        NamedFile::claim(&file);
        let writer = RecordingWriter::new(NamedFile(file), metadata).map_err(failed)?;
        Self::start(path, writer, |file| file.sync_all()).map_err(failed)
    }

    /// Resumes a recording, whole or cut: its readable part, then
    /// [`Down`](vn100_protocol::stream::LinkEventKind::Down), then what comes now.
    ///
    /// The readable part is copied to a file beside it, which takes its place only when it is
    /// safely on the disk. Until then the recording stays as it is, and there must be room for
    /// both. Blocks while it copies.
    ///
    /// # Errors
    /// [`RecordError`] when it cannot be read or is no recording, when another program records to
    /// it, or when the copy cannot be written.
    pub fn resume(path: impl AsRef<Path>, metadata: &BTreeMap<String, String>) -> Result<Self, RecordError> {
        let path = path.as_ref();
        let (writer, known_serial) = resume(path, metadata)?;
        let recorder = Self::start(path, writer, |file| file.sync_all())
            .map_err(|source| RecordError::Io { path: path.to_owned(), source })?;
        Ok(Self { known_serial, ..recorder })
    }

    fn start<W: Write + Send + 'static>(
        path: &Path,
        writer: RecordingWriter<W>,
        sync: impl FnOnce(W) -> io::Result<()> + Send + 'static,
    ) -> io::Result<Self> {
        let (sender, inputs) = mpsc::channel(WAITING_INPUTS);
        let state = RecordingState { path: path.to_owned(), bytes: 0, error: None, ended: false };
        let (states, state) = watch::channel(state);
        let reason = Arc::new(OnceLock::new());
        let reason_of_end = Arc::clone(&reason);
        let work = move || {
            let error = record(writer, inputs, &states, &reason_of_end).and_then(sync).err().map(Arc::new);
            states.send_modify(|state| (state.error, state.ended) = (error, true));
        };
        // ends at an error, or when all senders are dropped
        thread::Builder::new().name("recorder".into()).spawn(work)?;
        Ok(Self { inputs: sender, state, reason, known_serial: None })
    }

    /// Where to send what shall be recorded, as in `LinkOptions::recording`. When it is full the
    /// disk does not keep up; when it is closed the recording has stopped.
    #[must_use]
    pub fn inputs(&self) -> mpsc::Sender<StreamInput> {
        self.inputs.clone()
    }

    /// The serial number of the sensor in a resumed recording, for `LinkOptions::known_serial`;
    /// `None` where it is not in there, or the recording is new.
    #[must_use]
    pub fn known_serial(&self) -> Option<&str> {
        self.known_serial.as_deref()
    }

    /// The state of the recording, now and whenever it changes.
    #[must_use]
    pub fn state(&self) -> watch::Receiver<RecordingState> {
        self.state.clone()
    }

    /// Ends the recording for this reason, in words, once all clones of [`Recorder::inputs`] are
    /// gone: writes what waits and hands the file to the disk. Gives the last state, which holds
    /// any error.
    pub async fn finish(self, reason: &str) -> RecordingState {
        let Self { inputs, mut state, reason: given, .. } = self;
        given.get_or_init(|| reason.to_owned());
        drop(inputs);
        let ended = state.wait_for(|state| state.ended).await.is_ok();
        let last = state.borrow().clone();
        if ended {
            return last;
        }
        let died = io::Error::other("internal error: the recording stopped");
        RecordingState { error: Some(Arc::new(died)), ended: true, ..last }
    }
}

/// Records until all senders are gone; gives the finished file.
fn record<W: Write>(
    mut writer: RecordingWriter<W>,
    mut inputs: mpsc::Receiver<StreamInput>,
    states: &watch::Sender<RecordingState>,
    reason: &OnceLock<String>,
) -> io::Result<W> {
    let mut bytes = 0;
    let mut oldest_unflushed_ns: Option<i64> = None;
    while let Some(input) = inputs.blocking_recv() {
        writer.write(&input)?;
        let flush = match input {
            StreamInput::Chunk(Chunk { bytes: more, at_ns: Some(at_ns) }) => {
                bytes += more.len() as u64;
                at_ns.abs_diff(*oldest_unflushed_ns.get_or_insert(at_ns)) >= FLUSH_EVERY_NS
            }
            // how much time has passed is not known
            StreamInput::Chunk(Chunk { bytes: more, at_ns: None }) => {
                bytes += more.len() as u64;
                true
            }
            StreamInput::Link(_) => true,
        };
        if flush {
            writer.flush()?;
            oldest_unflushed_ns = None;
            states.send_modify(|state| state.bytes = bytes);
        }
    }
    let out = writer.finish(reason.get().map(String::as_str))?;
    states.send_modify(|state| state.bytes = bytes);
    Ok(out)
}

/// Writes to a file, and fails to [`flush`](Write::flush) after its last name was removed: what is
/// written then is gone with the program.
#[derive(Debug)]
struct NamedFile(File);

impl NamedFile {
    /// Claims a file for this program while it is open; `false` where another one writes it.
    fn claim(file: &File) -> bool {
        // a file system without locks lets everybody in
        !matches!(file.try_lock(), Err(TryLockError::WouldBlock))
    }

    fn sync_all(&self) -> io::Result<()> {
        self.0.sync_all()
    }
}

impl Write for NamedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()?;
        match has_name(&self.0)? {
            true => Ok(()),
            false => Err(io::Error::new(ErrorKind::NotFound, "the file was removed while it was written")),
        }
    }
}

#[cfg(unix)]
fn has_name(file: &File) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    Ok(file.metadata()?.nlink() > 0)
}

#[cfg(not(unix))]
fn has_name(_file: &File) -> io::Result<bool> {
    Ok(true)
}

/// Gives the writer behind the copy, which then bears the name of the recording, and the last
/// serial number in it. The recording stays as it was until the copy is on the disk.
fn resume(
    path: &Path,
    metadata: &BTreeMap<String, String>,
) -> Result<(RecordingWriter<NamedFile>, Option<String>), RecordError> {
    let failed = |source| RecordError::Io { path: path.to_owned(), source };
    if fs::symlink_metadata(path).map_err(failed)?.is_symlink() {
        return Err(RecordError::SymbolicLink(path.to_owned()));
    }
    let not_resumable = |problem| RecordError::NotResumable { path: path.to_owned(), problem };
    let file = File::open(path).map_err(failed)?;
    // the reader keeps it claimed until the copy has taken its place
    if !NamedFile::claim(&file) {
        return Err(RecordError::InUse(path.to_owned()));
    }
    let mut recording = RecordingReader::open(file).map_err(not_resumable)?;
    if !recording.has_our_topics() {
        return Err(not_resumable(RecordingError::NotBegun));
    }
    if recording.recorded().started_ns == Some(0) {
        return Err(not_resumable(RecordingError::Undated));
    }
    let copy = Copy::beside(path);
    copy.remove_leftover().map_err(failed)?;
    let file = File::create_new(&copy.path).map_err(failed)?;
    NamedFile::claim(&file);
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

/// Copies all that can be read, and marks the break. Gives the last serial number in it.
fn copy_inputs(
    recording: &mut RecordingReader<impl Read>,
    writer: &mut RecordingWriter<NamedFile>,
) -> io::Result<Option<String>> {
    let mut parser = SampleReader::new(ReadOptions::default());
    let mut serial = None;
    let mut copy = |entry: Entry<'_>| match entry {
        Entry::Bytes { at_ns, bytes } => {
            parser.push(&bytes, None);
            let registers = parser.take_batches().into_iter().flat_map(|batch| batch.registers);
            for value in registers.filter(|value| value.register == Register::SERIAL_NUMBER) {
                serial = Some(value.fields.to_string());
            }
            writer.write(&StreamInput::Chunk(Chunk { bytes: Bytes::copy_from_slice(&bytes), at_ns }))
        }
        Entry::Link(event) => writer.write(&StreamInput::Link(event)),
        Entry::Metadata(metadata) => writer.put_metadata(&[metadata]),
    };
    while let Some(copied) = recording.next_entry(&mut copy)? {
        copied?;
    }
    let Some(RecordingEnd { ended_ns: Some(at_ns), reason, .. }) = recording.recorded().end.get() else {
        // nothing came, so that nothing was interrupted
        return Ok(serial);
    };
    let cause = match reason {
        Some(reason) => format!("recording ended ({reason}) and resumed"),
        None => "recording interrupted".into(),
    };
    writer.write(&StreamInput::Link(LinkEvent { at_ns: *at_ns, kind: LinkEventKind::Down { cause } }))?;
    Ok(serial)
}

/// The copy as long as it has not taken its place; removed if it never does.
struct Copy {
    path: PathBuf,
}

impl Copy {
    fn beside(recording: &Path) -> Self {
        let mut name = OsString::from(".");
        name.push(recording.file_name().unwrap_or_default());
        name.push(".resuming");
        Self { path: recording.with_file_name(name) }
    }

    /// Removes the copy of a program that was killed at it.
    fn remove_leftover(&self) -> io::Result<()> {
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }

    fn take_place_of(self, recording: &Path) -> io::Result<()> {
        fs::rename(&self.path, recording)?;
        // the name is safe when its folder is
        #[cfg(unix)]
        {
            let folder = recording.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            File::open(folder)?.sync_all()?;
        }
        Ok(())
    }
}

impl Drop for Copy {
    fn drop(&mut self) {
        // it was renamed if it took its place
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests;
