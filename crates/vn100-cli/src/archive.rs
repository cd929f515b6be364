//! `vn100 archive`: every capture below some folders, on all cores, as one document or table. The
//! state of each is kept where that is asked for, and a file that is as it was is not read again.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
    thread,
    time::SystemTime,
};

use anyhow::{Context, Result};
use indicatif::ProgressBar;
use sha2::{Digest, Sha256};
use tokio::{runtime::Builder, sync::Semaphore, task};
use tokio_util::sync::CancellationToken;
use vn100_analysis::State;
use vn100_pipeline::Session;
use vn100_report::{ArchiveDocument, Completion, archive_table};

use crate::{
    args::{ArchiveArgs, FileArgs},
    exit::{HangUp, print, report, stop_on_interrupt},
    inputs::{FileStream, inputs},
    log::{Entries, run_logged, takes_terminal},
    replay::{progress_bar, replay_spec, stored_bytes},
    result::{FAULT, measured},
    user_files::evaluation,
    words::remedy_words,
};

/// What captures are called, packed or not; of other files in a folder nothing is said.
const ENDINGS: [&str; 17] = [
    "bag", "bin", "bz2", "csv", "db3", "gz", "log", "mcap", "raw", "tsv", "txt", "vnimu", "vnmar", "vnqmr", "vnymr",
    "xz", "zst",
];

/// Bytes of a digest before the state in its file.
const KEY: usize = 32;

pub(crate) fn archive(args: &ArchiveArgs) -> Result<Completion> {
    let evaluation = evaluation(&args.files.measure, false)?;
    let mut files = Vec::new();
    for path in &args.files.files {
        find(path, true, &mut files).with_context(|| format!("cannot read {}", path.display()))?;
    }
    files.sort();
    files.dedup();
    let found = FileArgs { files, ..args.files.clone() };
    if let Some(folder) = &args.state {
        fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    let work = async |log| measure_all(&found, args, log).await;
    let state = run_logged(&mut Builder::new_multi_thread(), &found.log, work)?;
    let document = ArchiveDocument::new(&state, &evaluation, remedy_words);
    document.notes().iter().for_each(|text| report(text));
    let is_table =
        args.csv || args.output.as_ref().is_some_and(|path| path.extension().is_some_and(|end| end == "csv"));
    let text = match is_table {
        true => archive_table(&document),
        false => serde_json::to_string_pretty(&document)? + "\n",
    };
    match &args.output {
        Some(path) => fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))?,
        None => print(&text)?,
    }
    Ok(document.completion())
}

/// Every capture below `path`, which itself is one whatever it is called.
fn find(path: &Path, is_named: bool, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    if path.is_dir() && !path.join("metadata.yaml").exists() {
        let mut entries: Vec<_> = fs::read_dir(path)?.collect::<std::io::Result<_>>()?;
        entries.sort_by_key(fs::DirEntry::path);
        let is_hidden = |entry: &fs::DirEntry| entry.file_name().to_string_lossy().starts_with('.');
        return entries
            .iter()
            .filter(|entry| !is_hidden(entry))
            .try_for_each(|entry| find(&entry.path(), false, files));
    }
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    if is_named || path.is_dir() || ending.is_some_and(|ending| ENDINGS.contains(&&*ending)) {
        files.push(path.to_owned());
    }
    Ok(())
}

struct Job {
    args: FileArgs,
    folder: Option<PathBuf>,
    progress: ProgressBar,
    turns: Semaphore,
    log: Entries,
    stop: CancellationToken,
}

async fn measure_all(files: &FileArgs, args: &ArchiveArgs, log: Entries) -> Result<State> {
    let inputs = inputs(files);
    let progress = progress_bar(
        inputs.iter().flat_map(FileStream::files).map(stored_bytes),
        files.log.quiet || takes_terminal(&files.log),
    );
    let job = Arc::new(Job {
        args: files.clone(),
        folder: args.state.clone(),
        progress,
        turns: Semaphore::new(thread::available_parallelism().map_or(1, Into::into)),
        log,
        stop: stop_on_interrupt(HangUp::Stops)?,
    });
    let streams: Vec<_> = inputs.into_iter().map(|input| task::spawn(state_of(input, Arc::clone(&job)))).collect();
    let mut all = State::default();
    for stream in streams {
        all = all.merged(stream.await.context(FAULT)??)?;
    }
    Ok(all)
}

async fn state_of(input: FileStream, job: Arc<Job>) -> Result<State> {
    let _turn = job.turns.acquire().await?;
    let bytes: u64 = input.files().filter_map(stored_bytes).sum();
    let name = name(&input);
    let kept = job.folder.as_ref().map(|folder| (folder.join(file_name(&name)), key(&input, &job.args)));
    let known = kept.as_ref().and_then(|(path, key)| unchanged(path, key));
    let state = match known {
        Some(state) => state,
        None => {
            let mut result =
                Session::replay(replay_spec(&job.args, input, &job.log, &job.stop)).result.await.context(FAULT)?;
            let analysis = result.analysis.take();
            let (name, is_stopped) = (name.clone(), job.stop.is_cancelled());
            let state = task::spawn_blocking(move || {
                let measured = measured(result, false);
                let started_ns = measured.compared().started_ns;
                let has_samples = measured.snapshot.timing.samples > 0;
                let error = measured.facts.error.clone();
                match analysis.filter(|_| has_samples) {
                    Some(mut analysis) => {
                        let state = State::of(&name, started_ns, &mut analysis);
                        error.iter().fold(state, |state, error| state.with_error(error))
                    }
                    None => State::unreadable(&name, error.as_deref().unwrap_or("no sample")),
                }
            })
            .await?;
            if let Some((path, key)) = kept.filter(|_| !is_stopped) {
                write(&path, &[&key[..], &state.to_bytes()].concat())?;
            }
            state
        }
    };
    job.progress.inc(bytes);
    Ok(state)
}

/// The path as it was given, and which stream of the file.
fn name(input: &FileStream) -> String {
    match input.options.topic.as_deref().filter(|_| input.is_one_of_several) {
        Some(topic) => format!("{} {topic}", input.path.display()),
        None => input.path.display().to_string(),
    }
}

fn file_name(name: &str) -> String {
    let digest = Sha256::digest(name.as_bytes());
    let hex: String = digest.iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    format!("{hex}.vn1s")
}

/// Of what the state depends on: the files by size and time of change, and how they are measured.
fn key(input: &FileStream, args: &FileArgs) -> [u8; KEY] {
    let mut digest = Sha256::new();
    for file in input.files() {
        let metadata = fs::metadata(file).ok();
        let changed = metadata.as_ref().and_then(|metadata| metadata.modified().ok());
        let since = changed.and_then(|time| time.duration_since(SystemTime::UNIX_EPOCH).ok());
        digest.update(format!("{} {:?} {since:?}\n", file.display(), metadata.map(|metadata| metadata.len())));
    }
    digest.update(format!("{:?} {:?} {:?}", args.settings(), args.measure.read_options(), input.options));
    digest.finalize().into()
}

/// The state kept under this key; `None` for another one, and for one that cannot be read.
fn unchanged(path: &Path, key: &[u8; KEY]) -> Option<State> {
    let bytes = fs::read(path).ok()?;
    let state = bytes.strip_prefix(&key[..])?;
    State::from_bytes(state).ok()
}

/// As a whole or not at all.
fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let part = path.with_extension("part");
    fs::write(&part, bytes)
        .and_then(|()| fs::rename(&part, path))
        .with_context(|| format!("cannot write {}", path.display()))
}
