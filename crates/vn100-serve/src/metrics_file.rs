//! The metrics as a file, for a host without an open port: written whole beside its name, and then
//! renamed, so that a reader never sees a part of it.

use std::{
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use tokio::{
    task::spawn_blocking,
    time::{self, MissedTickBehavior},
};
use tokio_util::sync::CancellationToken;
use vn100_report::MetricsForm;

use crate::app::App;

const PERIOD: Duration = Duration::from_secs(15);

/// A file of metrics that is kept up to date.
pub struct MetricsFile {
    /// The file; it is replaced as a whole every 15 s and at the end.
    pub path: PathBuf,
    /// Receives why the file cannot be written: once, until a write has succeeded again.
    pub failed: Box<dyn Fn(String) + Send>,
}

/// Writes the metrics now, every 15 s, and once more at the end.
pub(crate) async fn keep_written(file: MetricsFile, app: Arc<App>, over: CancellationToken) {
    let mut ticks = time::interval(PERIOD);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut has_failed = false;
    loop {
        let is_last = tokio::select! {
            _ = ticks.tick() => false,
            () = over.cancelled() => true,
        };
        if let Ok(text) = app.ask(|drawer, now| drawer.metrics(now, MetricsForm::Prometheus)).await {
            let path = file.path.clone();
            let written = spawn_blocking(move || replace(&path, &text)).await;
            let error = written.ok().and_then(Result::err);
            if let Some(error) = error.as_ref().filter(|_| !has_failed) {
                (file.failed)(format!("the metrics cannot be written to {}: {error}", file.path.display()));
            }
            has_failed = error.is_some();
        }
        if is_last {
            return;
        }
    }
}

fn replace(path: &Path, text: &[u8]) -> io::Result<()> {
    let mut beside = path.as_os_str().to_owned();
    // a collector reads all files whose names end in `.prom`
    beside.push(".new");
    let written = fs::File::create(&beside).and_then(|mut file| file.write_all(text));
    written.and_then(|()| fs::rename(&beside, path)).inspect_err(|_| {
        // the error to report is that of the write
        let _ = fs::remove_file(&beside);
    })
}
