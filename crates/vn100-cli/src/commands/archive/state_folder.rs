//! The states of recordings, kept in a folder from one run to the next: each in a file of its own,
//! under a digest of everything that it depends on. What the beginnings of the files say is kept in
//! one more, so that of files that are as they were nothing is read.

use std::{
    collections::BTreeMap,
    fmt::Write,
    fs,
    hash::{BuildHasher, RandomState},
    io,
    path::{Path, PathBuf},
    sync::OnceLock,
};

use anyhow::{Context, Result};
use sha2::{Digest, Sha256};
use vn100_analysis::State;
use vn100_pipeline::ReplaySpec;

use crate::{args::FileArgs, inputs::Head};

/// Bytes of a digest before the state in its file.
const DIGEST: usize = 32;

/// Several runs of the program may use one folder at a time.
#[derive(Debug)]
pub(super) struct StateFolder {
    path: PathBuf,
    failure: OnceLock<String>,
}

/// The entry of a recording in the folder.
#[derive(Debug)]
pub(super) struct StateEntry {
    path: PathBuf,
    digest: [u8; DIGEST],
}

impl StateFolder {
    pub(super) fn open(path: &Path) -> Result<Self> {
        fs::create_dir_all(path).with_context(|| format!("cannot make the folder {}", path.display()))?;
        Ok(Self { path: path.to_owned(), failure: OnceLock::new() })
    }

    /// The beginnings of files, those that are not known read anew.
    pub(super) fn heads<'a>(&self, args: &'a FileArgs) -> BTreeMap<&'a Path, Head> {
        let path = self.path.join("heads.json");
        let known = fs::read(&path).ok().and_then(|text| serde_json::from_slice(&text).ok());
        let mut known: BTreeMap<String, Head> = known.unwrap_or_default();
        let before = known.len();
        let head = |file: &'a PathBuf| {
            let mut digest = begun(&format!("{:?} {:?} {}", args.columns, args.topic, args.separate));
            stamp(file, &mut digest);
            let head = known.entry(hex(&digest.finalize())).or_insert_with(|| Head::read(file, args));
            (&**file, head.clone())
        };
        let heads = args.files.iter().map(head).collect();
        if known.len() > before
            && let Ok(text) = serde_json::to_vec(&known)
        {
            self.write(&path, &text);
        }
        heads
    }

    /// Of what a state depends on: the program, the options, and the files by size and time of
    /// change.
    pub(super) fn entry(&self, name: &str, spec: &ReplaySpec) -> StateEntry {
        let ReplaySpec { path, capture, settings, read, .. } = spec;
        let mut digest = begun(&format!("{name:?} {settings:?} {read:?} {capture:?}"));
        std::iter::once(path).chain(&capture.later_parts).for_each(|file| stamp(file, &mut digest));
        let file = hex(&Sha256::digest(name)[..16]);
        StateEntry { path: self.path.join(format!("{file}.vn1s")), digest: digest.finalize().into() }
    }

    /// The state of a recording that is as it was; `None` where nothing is kept of it, or nothing
    /// that can be read.
    pub(super) fn known(&self, entry: &StateEntry) -> Option<State> {
        let bytes = fs::read(&entry.path).ok()?;
        State::from_bytes(bytes.strip_prefix(&entry.digest[..])?).ok()
    }

    pub(super) fn keep(&self, entry: &StateEntry, state: &State) {
        self.write(&entry.path, &[&entry.digest[..], &state.to_bytes()].concat());
    }

    /// Whole or not at all. What fails costs the next run the reading of the file, and this one
    /// nothing: see [`failure`](Self::failure).
    fn write(&self, path: &Path, bytes: &[u8]) {
        let draw = RandomState::new().hash_one(std::process::id());
        let part = path.with_extension(format!("{draw:016x}.part"));
        let write = || -> io::Result<()> {
            fs::write(&part, bytes)?;
            fs::rename(&part, path)
        };
        if let Err(error) = write() {
            let _ = fs::remove_file(&part);
            let text = format!("cannot keep states in {}, they are made anew next time: {error}", self.path.display());
            let _ = self.failure.set(text);
        }
    }

    /// Why a state could not be kept, the first of them.
    pub(super) fn failure(&self) -> Option<&str> {
        self.failure.get().map(String::as_str)
    }
}

/// A digest of these options, and of the program.
fn begun(options: &str) -> Sha256 {
    let mut digest = Sha256::new();
    digest.update(format!("{} {options}\n", env!("CARGO_PKG_VERSION")));
    digest
}

/// Size and time of change of a file, of the times of its reads beside it, and of what is in it
/// where it is a bag that is a folder; of what is not there that.
fn stamp(file: &Path, digest: &mut Sha256) {
    let mut sidecar = file.to_owned().into_os_string();
    sidecar.push(".timing");
    let entries = fs::read_dir(file).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> = [file.to_owned(), sidecar.into()].into_iter().chain(entries).collect();
    files.sort();
    for file in files {
        let found = fs::metadata(&file).ok().map(|metadata| (metadata.len(), metadata.modified().ok()));
        digest.update(format!("{file:?} {found:?}\n"));
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
