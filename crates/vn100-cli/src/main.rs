//! `vn100`: live Allan deviation and statistics for the VectorNav VN-100. The table of contents of the program.

mod args;
mod document;
mod exit;
mod interrupt;
mod progress;
mod replay;
mod sim;
mod text;
mod units;

use std::process::ExitCode;

use clap::Parser;

use crate::{
    args::{Args, Command},
    exit::Exit,
};

fn main() -> ExitCode {
    let result = match Args::parse().command {
        Command::Replay(args) => replay::replay(&args),
        Command::Sim(args) => sim::sim(&args),
    };
    result
        .unwrap_or_else(|error| {
            exit::report(&format!("{error:#}"));
            Exit::Failed
        })
        .into()
}
