//! `vn100 configure`: changes what a sensor sends.

use anyhow::{Context, Result, bail};
use tokio::runtime::Runtime;
use vn100_driver::{Configured, OutputSettings};
use vn100_report::{Completion, printable};

use crate::{
    args::ConfigureArgs,
    exit::print,
    interrupt::{HangUp, stop_on_interrupt},
    live_source::live_source,
    log::Log,
};

pub(crate) fn configure(args: ConfigureArgs) -> Result<Completion> {
    let settings = OutputSettings {
        baud: args.set_baud,
        count: args.count,
        save: args.save,
        ..args.change.settings().unwrap_or_default()
    };
    if settings == OutputSettings::default() {
        bail!("nothing to change: give --set-rate, --set-message, --set-baud, --window, --count or --save");
    }
    if args.link.listen_only {
        bail!("--listen-only sends nothing to the sensor, so that it cannot be changed");
    }
    if settings.baud.is_some() && args.source.kind() == "tcp" {
        bail!(
            "the serial server sets the speed of its line, and would not hear the sensor at another: --set-baud needs a port"
        );
    }
    let log = Log::open(&args.link.log)?;
    let runtime = Runtime::new().context("cannot start the worker threads")?;
    let name = args.source.to_string();
    let configured = runtime.block_on(async {
        let stop = stop_on_interrupt(HangUp::Stops)?;
        let (source, _emulated) = live_source(&args.source, &args.link, &log.entries())?;
        let configure = async |link| anyhow::Ok(vn100_driver::configure(&link, &settings, &stop).await?);
        source.with_link(None, &stop, configure).await
    })?;
    let kept = match (settings.save, configured.changes.is_empty()) {
        (true, _) => "; the sensor keeps all its settings when it is switched off",
        (false, false) => "; until it is switched off: --save keeps it",
        (false, true) => "",
    };
    print(&format!("{}: {}{kept}\n", printable(&name), describe(&configured)))?;
    Ok(if configured.rate_is_kept() { Completion::Complete } else { Completion::Failed })
}

/// What was changed, and whether the sensor does what it is set to.
pub(crate) fn describe(configured: &Configured) -> String {
    let changes: Vec<_> = configured.changes.iter().map(ToString::to_string).collect();
    let changed = if changes.is_empty() { "all was as asked".into() } else { changes.join(", ") };
    let (measured_hz, rate_hz) = (configured.measured_hz, configured.rate_hz);
    let verdict =
        if configured.rate_is_kept() { "" } else { ": NOT as set; look at the cable and the speed of the line" };
    let found = if configured.was_paused { "; its output was paused, and is on now" } else { "" };
    printable(&format!("{changed}{found}; {measured_hz:.1} lines a second come, {rate_hz} are set{verdict}"))
}
