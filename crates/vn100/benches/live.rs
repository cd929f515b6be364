//! What it costs to measure live sensors: CPU time and memory of `vn100 attach`, and the time from
//! the last byte of a line to its place in the sums. Linux only; it takes two minutes.
//!
//! Sensors and feeders are processes of their own, on pseudo-terminals. CPU time is the kernel's
//! account of the threads of `attach` over some seconds of steady running.
//! `cargo bench -p vn100 --bench live` prints the tables.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark prints, and stops at the first surprise")]

#[cfg(target_os = "linux")]
#[path = "../../../benches/figures.rs"]
mod figures;
#[cfg(target_os = "linux")]
mod live {
    pub(super) mod cost;
    pub(super) mod delay;
}

#[cfg(target_os = "linux")]
fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [feed, ports, rate_hz, frames] = &arguments[..]
        && feed == live::delay::FEED
    {
        return live::delay::feed(ports.parse().unwrap(), rate_hz.parse().unwrap(), frames);
    }
    live::cost::measure();
    println!();
    live::delay::measure();
}

#[cfg(not(target_os = "linux"))]
fn main() {
    println!("skipped: the emulated sensors need the pseudo-terminals of Linux");
}
