//! Records a link while it is measured, to a new file or to the end of an existing recording.

mod disk_space;
mod parts;
mod resume;

use std::{
    collections::BTreeMap,
    fs::{self, File, TryLockError},
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

/// Inputs that may wait for the disk: ten seconds of 800 packets per second. The sender drops
/// further inputs.
const WAITING_INPUTS: usize = 8192;

/// The longest part of the stream that is lost if the program is killed.
const FLUSH_EVERY_NS: u64 = 1_000_000_000;

/// The reason why a recording cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The operating system reports an error.
    #[error("cannot record to {}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The error.
        source: io::Error,
    },
    /// The folder of the file does not exist.
    #[error("there is no folder {}: create it, or choose another name", .0.display())]
    NoFolder(PathBuf),
    /// The name is that of a folder, a device or the like.
    #[error("{} is not a file: choose another name", .0.display())]
    NotAFile(PathBuf),
    /// A file of this name exists.
    #[error("{} exists and is not replaced: choose another name, or resume it", .0.display())]
    Exists(PathBuf),
    /// Resuming a recording replaces its file, and would here replace a symbolic link.
    #[error("{} is a symbolic link: name the recording itself to resume it", .0.display())]
    SymbolicLink(PathBuf),
    /// Another program is recording to the file.
    #[error("{} is being recorded to: end that first", .0.display())]
    InUse(PathBuf),
    /// The file is no recording that can be resumed.
    #[error("{} cannot be resumed: {problem}", path.display())]
    NotResumable {
        /// The file.
        path: PathBuf,
        /// The reason.
        problem: RecordingError,
    },
}

impl RecordError {
    /// The error of the operating system for `path`, with its cure if there is one.
    fn of(path: &Path, source: io::Error) -> Self {
        let found = fs::symlink_metadata(path);
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.is_dir());
        match (folder, source.kind()) {
            (Some(folder), ErrorKind::NotFound | ErrorKind::NotADirectory) => Self::NoFolder(folder.to_owned()),
            (None, _) if found.is_ok_and(|found| !found.is_file() && !found.is_symlink()) => {
                Self::NotAFile(path.to_owned())
            }
            (None, ErrorKind::AlreadyExists) => Self::Exists(path.to_owned()),
            _ => Self::Io { path: path.to_owned(), source },
        }
    }
}

/// The state of a recording.
#[derive(Debug, Clone)]
pub struct RecordingState {
    /// The file.
    pub path: PathBuf,
    /// Bytes of the stream that this recorder has written.
    pub bytes: u64,
    /// The free space on the disk, if the disk will soon be full; else `None`.
    pub low_space: Option<LowSpace>,
    /// The reason why the recording stopped: a full disk, or a file that was removed meanwhile; `None`
    /// while it continues. The file holds all inputs before the error, and the measurement continues.
    pub error: Option<Arc<io::Error>>,
    /// Whether the recording has ended, by [`Recorder::finish`] or by an error.
    pub ended: bool,
}

/// Writes the inputs of a link to a file, on a thread of its own.
///
/// The file is flushed whenever a second of the stream has passed, and with each link event. If a
/// recorder is dropped, its thread ends the file without a reason.
#[derive(Debug)]
pub struct Recorder {
    inputs: mpsc::Sender<StreamInput>,
    state: watch::Receiver<RecordingState>,
    reason: Arc<OnceLock<String>>,
    known_serial: Option<String>,
    is_resumed: bool,
}

impl Recorder {
    /// Starts a new file; `metadata` is the information about the recording for a replay. An
    /// existing file is never replaced.
    ///
    /// # Errors
    /// [`RecordError::Exists`] if a file of this name exists, and others if the file cannot be
    /// written.
    pub fn create(path: impl AsRef<Path>, metadata: &BTreeMap<String, String>) -> Result<Self, RecordError> {
        let path = path.as_ref();
        let failed = |source| RecordError::of(path, source);
        let file = File::create_new(path).map_err(failed)?;
        NamedFile::claim(&file);
        let writer = RecordingWriter::new(NamedFile(file), metadata).map_err(|source| {
            // an empty file would prevent the next recording
            let _ = fs::remove_file(path);
            failed(source)
        })?;
        Self::to_file(path, writer, None)
    }

    /// Starts a recording in parts, whose files are named by [`part_path`](super::part::part_path);
    /// if `resume` is set and a recording exists, continues it in its next part.
    ///
    /// # Errors
    /// [`RecordError`] if a part exists that must not be resumed, cannot be read, or is in use by
    /// another program; or if the next part cannot be written.
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
        Ok(Self { known_serial, is_resumed, ..Self::to_file(&part, writer, Some(next_part))? })
    }

    /// Resumes a recording, finished or cut: the new file has its readable part, then
    /// [`Down`](vn100_protocol::stream::LinkEventKind::Down), then the new inputs.
    /// [`create`](Self::create)s one if there is none, or if it was cut before its first input.
    ///
    /// The readable part is copied to another file in the same folder, which replaces the recording
    /// once it is synced to the disk. Until then the recording is unchanged, and the disk must have
    /// room for both. Blocks while it copies.
    ///
    /// # Errors
    /// [`RecordError`] if the file cannot be read or is no recording, if another program records to
    /// it, or if the copy cannot be written.
    pub fn resume(path: impl AsRef<Path>, metadata: &BTreeMap<String, String>) -> Result<Self, RecordError> {
        let path = path.as_ref();
        match resume(path, metadata) {
            Ok((writer, known_serial)) => {
                Ok(Self { known_serial, is_resumed: true, ..Self::to_file(path, writer, None)? })
            }
            Err(RecordError::Io { source, .. }) if source.kind() == ErrorKind::NotFound => Self::create(path, metadata),
            Err(RecordError::NotResumable { problem: RecordingError::NotBegun, .. }) if begins_as_ours(path) => {
                let failed = |source| RecordError::Io { path: path.to_owned(), source };
                Self::to_file(path, begun_whole(path, &head(metadata)).map_err(failed)?, None)
            }
            Err(error) => Err(error),
        }
    }

    fn to_file(
        path: &Path,
        writer: RecordingWriter<NamedFile>,
        next_part: Option<NextPart<NamedFile>>,
    ) -> Result<Self, RecordError> {
        Self::start(path, writer, NamedFile::sync_all, next_part)
            .map_err(|source| RecordError::Io { path: path.to_owned(), source })
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

    /// The sender for inputs to record, used by `LinkOptions::recording`. A full channel means that
    /// the disk is too slow; a closed channel means that the recording has stopped.
    pub fn inputs(&self) -> mpsc::Sender<StreamInput> {
        self.inputs.clone()
    }

    /// The serial number of the sensor in a resumed recording, for `LinkOptions::known_serial`;
    /// `None` if the recording does not contain it, or is new.
    pub fn known_serial(&self) -> Option<&str> {
        self.known_serial.as_deref()
    }

    /// Whether an existing recording is continued.
    pub const fn is_resumed(&self) -> bool {
        self.is_resumed
    }

    /// The state of the recording; the receiver is notified of each change.
    pub fn state(&self) -> watch::Receiver<RecordingState> {
        self.state.clone()
    }

    /// Ends the recording for this reason, in words, once all clones of [`Recorder::inputs`] are
    /// dropped: writes pending inputs and syncs the file to the disk. Returns the last state, with
    /// the error, if there was one.
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

/// The next part of a recording and its file, if one begins before an input.
type NextPart<W> = Box<dyn FnMut(&StreamInput) -> Option<io::Result<(PathBuf, RecordingWriter<W>)>> + Send>;

/// Records until all senders are dropped, and syncs the finished files to the disk.
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
            // all before it is in the file, also if no part can begin
            writer.flush()?;
            states.send_modify(|state| state.bytes = bytes);
            let (path, part) = begun?;
            sync(&std::mem::replace(&mut writer, part).finish(Some(CONTINUED))?)?;
            states.send_modify(|state| state.path = path);
            oldest_unflushed_ns = None;
        }
        writer.write(&input)?;
        let flush = match input {
            StreamInput::Chunk(Chunk { bytes: more, at_ns: Some(at_ns) }) => {
                bytes += more.len() as u64;
                low_space = disk.note(at_ns);
                at_ns.abs_diff(*oldest_unflushed_ns.get_or_insert(at_ns)) >= FLUSH_EVERY_NS
            }
            // the elapsed time is not known
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

/// Writes to a file, and fails to [`flush`](Write::flush) after its last name was removed, because
/// the bytes would be lost when the program ends.
#[derive(Debug)]
struct NamedFile(File);

impl NamedFile {
    /// Claims a file for this program while it is open; `false` if another program writes it.
    fn claim(file: &File) -> bool {
        // a file system without locks grants every claim
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
