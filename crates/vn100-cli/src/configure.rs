//! `vn100 configure`: changes what a sensor sends.

use anyhow::{Context, Result, bail};
use tokio::runtime::Runtime;
use vn100_driver::{Change, Configured, LinkHandle, OutputSettings, restore};
use vn100_protocol::Register;
use vn100_report::printable;

use crate::{
    args::ConfigureArgs,
    exit::{Exit, print},
    interrupt::{HangUp, stop_on_interrupt},
    live_source::LiveSource,
    log::Log,
};

pub(crate) fn configure(args: ConfigureArgs) -> Result<Exit> {
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
        let stop = stop_on_interrupt(HangUp::Stops).context("cannot listen to Ctrl-C")?;
        let live = LiveSource::new(args.source, args.link, log.entries())?;
        live.ask(&stop, async |link| Ok(vn100_driver::configure(&link, &settings, &stop).await?)).await
    })?;
    let kept = match (settings.save, configured.changes.is_empty()) {
        (true, _) => "; the sensor keeps all its settings when it is switched off",
        (false, false) => "; until it is switched off: --save keeps it",
        (false, true) => "",
    };
    print(&format!("{}: {}{kept}\n", printable(&name), describe(&configured)))?;
    Ok(if configured.rate_is_kept() { Exit::Good } else { Exit::Failed })
}

/// The serial number of a sensor; `None` where it does not say.
pub(crate) async fn serial(link: &LinkHandle) -> Option<String> {
    let contents = link.read(Register::SERIAL_NUMBER).await;
    contents.ok().flatten().map(|contents| contents.fields.to_string())
}

/// Puts back what was changed on the sensor of that serial number; another one is left as it is.
pub(crate) async fn restore_same(link: &LinkHandle, changes: &[Change], known: Option<&str>) -> Result<()> {
    if let (Some(known), Some(now)) = (known, serial(link).await)
        && now != known
    {
        bail!("another sensor, serial {now}, is on the port; it was {known}");
    }
    Ok(restore(link, changes).await?)
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
