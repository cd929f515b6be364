//! Records a link while it is measured, to a new file or behind a recording that is there.

mod disk_space;
mod parts;
mod resume;

use std::{
    collections::BTreeMap,
    fs::{File, TryLockError},
    io::{self, ErrorKind, Write},
    path::{Path, PathBuf},
    sync::{Arc, OnceLock},
    thread,
};

use tokio::sync::{mpsc, watch};
use vn100_protocol::stream::{Chunk, StreamInput};

use self::disk_space::DiskWatch;
pub use self::disk_space::LowSpace;
use self::parts::Parts;
use self::resume::{begins_as_ours, begun_whole, resume};
use super::{
    part::{CONTINUED, Rotation},
    reader::RecordingError,
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
    /// Its disk, where that will be full soon.
    pub low_space: Option<LowSpace>,
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
    is_resumed: bool,
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
        Self::start(path, writer, NamedFile::sync_all, None).map_err(failed)
    }

    /// [`resume`](Self::resume)s the recording of this name; begins it where there is none, or one
    /// that was cut before anything was recorded.
    ///
    /// # Errors
    /// Those of both.
    pub fn resume_or_create(path: impl AsRef<Path>, metadata: &BTreeMap<String, String>) -> Result<Self, RecordError> {
        let path = path.as_ref();
        match Self::resume(path, metadata) {
            Err(RecordError::Io { source, .. }) if source.kind() == ErrorKind::NotFound => Self::create(path, metadata),
            Err(RecordError::NotResumable { problem: RecordingError::NotBegun, .. }) if begins_as_ours(path) => {
                let failed = |source| RecordError::Io { path: path.to_owned(), source };
                let writer = begun_whole(path, &head(metadata)).map_err(failed)?;
                Self::start(path, writer, NamedFile::sync_all, None).map_err(failed)
            }
            resumed => resumed,
        }
    }

    /// Begins a recording in parts, whose files are named by [`part_path`](super::part::part_path);
    /// or resumes the one that is there, where that is asked for, in its next part.
    ///
    /// # Errors
    /// [`RecordError`] when a part is there that is not to be resumed, cannot be read, or is
    /// recorded to by another program; or when the next one cannot be written.
    pub fn in_parts(
        path: impl AsRef<Path>,
        metadata: &BTreeMap<String, String>,
        rotation: Rotation,
        resume: bool,
    ) -> Result<Self, RecordError> {
        let path = path.as_ref();
        let (mut parts, part, writer, known_serial) = Parts::begin(path, metadata, rotation, resume)?;
        let is_resumed = parts.is_resumed();
        let next_part: NextPart<NamedFile> = Box::new(move |input| parts.next_before(input));
        let recorder = Self::start(&part, writer, NamedFile::sync_all, Some(next_part))
            .map_err(|source| RecordError::Io { path: part, source })?;
        Ok(Self { known_serial, is_resumed, ..recorder })
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
        let recorder = Self::start(path, writer, NamedFile::sync_all, None)
            .map_err(|source| RecordError::Io { path: path.to_owned(), source })?;
        Ok(Self { known_serial, is_resumed: true, ..recorder })
    }

    fn start<W: Write + Send + 'static>(
        path: &Path,
        writer: RecordingWriter<W>,
        sync: fn(&W) -> io::Result<()>,
        next_part: Option<NextPart<W>>,
    ) -> io::Result<Self> {
        let (sender, inputs) = mpsc::channel(WAITING_INPUTS);
        let state = RecordingState { path: path.to_owned(), bytes: 0, low_space: None, error: None, ended: false };
        let (states, state) = watch::channel(state);
        let reason = Arc::new(OnceLock::new());
        let reason_of_end = Arc::clone(&reason);
        let disk = DiskWatch::of(path);
        let work = move || {
            let recorded = record(writer, next_part, sync, inputs, disk, &states, &reason_of_end);
            let error = recorded.err().map(Arc::new);
            states.send_modify(|state| (state.error, state.ended) = (error, true));
        };
        // ends at an error, or when all senders are dropped
        thread::Builder::new().name("recorder".into()).spawn(work)?;
        Ok(Self { inputs: sender, state, reason, known_serial: None, is_resumed: false })
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

    /// Whether the file was a recording before.
    #[must_use]
    pub const fn is_resumed(&self) -> bool {
        self.is_resumed
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

/// The next part of a recording and its file, where one begins before an input.
type NextPart<W> = Box<dyn FnMut(&StreamInput) -> Option<io::Result<(PathBuf, RecordingWriter<W>)>> + Send>;

/// Records until all senders are gone, and hands the finished files to the disk.
fn record<W: Write>(
    mut writer: RecordingWriter<W>,
    mut next_part: Option<NextPart<W>>,
    sync: fn(&W) -> io::Result<()>,
    mut inputs: mpsc::Receiver<StreamInput>,
    mut disk: DiskWatch,
    states: &watch::Sender<RecordingState>,
    reason: &OnceLock<String>,
) -> io::Result<()> {
    let mut bytes = 0;
    let mut low_space = None;
    let mut oldest_unflushed_ns: Option<i64> = None;
    while let Some(input) = inputs.blocking_recv() {
        if let Some(begun) = next_part.as_mut().and_then(|next_part| next_part(&input)) {
            let (path, part) = begun?;
            sync(&std::mem::replace(&mut writer, part).finish(Some(CONTINUED))?)?;
            states.send_modify(|state| state.path = path);
            oldest_unflushed_ns = None;
        }
        writer.write(&input)?;
        let flush = match input {
            StreamInput::Chunk(Chunk { bytes: more, at_ns: Some(at_ns) }) => {
                bytes += more.len() as u64;
                low_space = disk.note(more.len(), at_ns);
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
            states.send_modify(|state| (state.bytes, state.low_space) = (bytes, low_space));
        }
    }
    let out = writer.finish(reason.get().map(String::as_str))?;
    states.send_modify(|state| state.bytes = bytes);
    sync(&out)
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

#[cfg(test)]
mod tests;
