//! The emulated sensor on a pseudo-terminal, which Linux has.

use anyhow::{Context, Result};
use tokio::{runtime::Runtime, task, time};
use vn100_analysis::Completion;
use vn100_sim::pty::{PtyOptions, PtyStats, serve};

use super::times;
use crate::{
    args::{SimArgs, SimSensorArgs},
    exit::{HangUp, print, report, stop_on_interrupt},
    live_source::device,
};

pub(super) fn emulate(args: &SimArgs) -> Result<Completion> {
    let runtime = Runtime::new().context("cannot start the worker threads")?;
    runtime.block_on(async {
        let stop = stop_on_interrupt(HangUp::Stops)?;
        let SimSensorArgs { faults, seed, .. } = args.sensor.clone();
        let options = PtyOptions { link: args.link.clone(), faults, seed, ..PtyOptions::default() };
        let sensor = serve(device(&args.sensor)?, options)?;
        let path = args.link.clone().unwrap_or_else(|| sensor.path());
        print(&format!("{}\n", path.display()))?;
        match args.duration {
            Some(duration) => _ = time::timeout(duration, stop.cancelled()).await,
            None => stop.cancelled().await,
        }
        let stats = task::spawn_blocking(|| sensor.stop()).await.context("internal error: the emulator stopped")??;
        let PtyStats { openings, bytes_sent, bytes_dropped, bytes_unread } = stats;
        report(&format!(
            "opened {}, {bytes_sent} bytes sent; dropped: {bytes_dropped} because the terminal was full, {bytes_unread} because no \
             program read them",
            times(openings)
        ));
        Ok(Completion::Complete)
    })
}
