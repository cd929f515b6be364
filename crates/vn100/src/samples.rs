//! `--samples`: the samples of a session as CSV, written by a thread of its own.

use std::{
    fs::File,
    io::{self, BufWriter, Write, stdout},
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    thread,
};

use anyhow::{Context, Result};
use tokio::sync::{mpsc, oneshot};
use tokio_util::sync::CancellationToken;
use vn100_analysis::SourceResult;
use vn100_protocol::stream::Batch;
use vn100_report::SampleTable;
use vn100_session::SampleTap;

use crate::output;

type Output = BufWriter<Box<dyn Write + Send>>;

/// A file of samples, or standard output; no file is ever replaced.
fn create(path: &Path) -> io::Result<Output> {
    let out: Box<dyn Write + Send> =
        if path == Path::new("-") { Box::new(stdout()) } else { Box::new(File::create_new(path)?) };
    Ok(BufWriter::new(out))
}

pub(crate) struct SampleWriter {
    path: PathBuf,
    dropped: Arc<AtomicU64>,
    written: oneshot::Receiver<io::Result<()>>,
    has_enough: CancellationToken,
}

impl SampleWriter {
    /// Begins to write, and gives what takes the samples. Where the reader of standard output has
    /// enough, `stop` ends the session.
    pub(crate) fn start(path: &Path, stop: CancellationToken) -> Result<(Self, SampleTap)> {
        let failed = || format!("cannot write samples to {}", path.display());
        if path != Path::new("-") {
            output::Output::check_new(path)?;
        }
        let table = SampleTable::new(create(path).with_context(failed)?);
        let (tap, batches) = SampleTap::new();
        let (sender, written) = oneshot::channel();
        let has_enough = CancellationToken::new();
        let enough = has_enough.clone();
        let work = move || {
            let result = write(table, batches);
            if result.as_ref().is_err_and(|error| error.kind() == io::ErrorKind::BrokenPipe) {
                enough.cancel();
                stop.cancel();
            }
            // the receiver may have been dropped
            let _ = sender.send(result);
        };
        // ends at an error, or with the session
        thread::Builder::new().name("samples".into()).spawn(work).with_context(failed)?;
        Ok((Self { path: path.to_owned(), dropped: tap.dropped(), written, has_enough }, tap))
    }

    /// Whether the reader of standard output has closed it, which ended the session.
    pub(crate) fn has_enough(&self) -> bool {
        self.has_enough.is_cancelled()
    }

    /// Waits until all is written, and notes in the result what is not.
    pub(crate) async fn finish(self, measured: &mut SourceResult) {
        let written =
            self.written.await.unwrap_or_else(|_| Err(io::Error::other("internal error: its writer stopped")));
        let path = self.path.display();
        // a reader that has closed its end has read enough
        if let Err(error) = written
            && error.kind() != io::ErrorKind::BrokenPipe
        {
            measured.note_failure(format!("{path} lacks samples: {error}. The result does not depend on it"));
        }
        let samples = self.dropped.load(Ordering::Relaxed);
        if samples > 0 {
            measured.note_failure(format!(
                "{path} lacks {samples} samples, because it was written too slowly. The result does not depend on it"
            ));
        }
    }
}

fn write(mut table: SampleTable<Output>, mut batches: mpsc::Receiver<Box<Batch>>) -> io::Result<()> {
    loop {
        // a reader of the file sees all that has come
        if batches.is_empty() {
            table.flush()?;
        }
        match batches.blocking_recv() {
            Some(batch) => table.push(&batch)?,
            None => return table.flush(),
        }
    }
}
