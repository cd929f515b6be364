//! The program as its user runs it, from start to exit: each input, each state of it and each
//! output, beside `sha256sum` of the same bytes and, if Python has them, pandas, rosbags and
//! allantools.
//!
//! A path is timed with a record of one hour and with one of five at 40 Hz: the difference gives
//! the time of a unit, and the rest is the cost of a process, however short its record is. Commands
//! take turns, the cache is warm; times are the kernel's account of the process, user and system.
//! `cargo bench -p vn100 --bench whole_process` prints the tables; an argument selects the rows
//! whose names contain it. The records take 3 GB in the target folder.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark prints, and stops at the first surprise")]

#[cfg(unix)]
#[path = "../../../benches/figures.rs"]
mod figures;
#[cfg(unix)]
mod whole_process {
    pub(super) mod forms;
    pub(super) mod paths;
}

#[cfg(unix)]
fn main() {
    let selected = std::env::args().skip(1).find(|argument| !argument.starts_with('-')).unwrap_or_default();
    whole_process::paths::measure(&selected);
}

#[cfg(not(unix))]
fn main() {
    println!("skipped: the account of the time of a process is that of Unix");
}
