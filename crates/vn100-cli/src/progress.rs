//! The progress bar of long work, on stderr and only when that is a terminal.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Bytes of all sources together, on one bar.
pub(crate) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// How often it is worth moving the bar.
    pub(crate) const PERIOD: Duration = Duration::from_millis(100);

    /// A bar for sources of these sizes in bytes; without an end if one does not know its size.
    /// Nothing is shown where it `is_hidden`, because something else is written there.
    pub(crate) fn new(sizes: impl IntoIterator<Item = Option<u64>>, is_hidden: bool) -> Self {
        let total: Option<u64> = sizes.into_iter().sum();
        let target = if is_hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) };
        let bar = ProgressBar::with_draw_target(total, target);
        let template =
            if total.is_some() { "{wide_bar} {bytes}/{total_bytes} {eta}" } else { "{spinner} {bytes} in {elapsed}" };
        // the default style stands in for a template it does not understand
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Self { bar }
    }

    pub(crate) fn add(&self, bytes: u64) {
        self.bar.inc(bytes);
    }

    /// Takes the bar away while `print` writes to the terminal.
    pub(crate) fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
