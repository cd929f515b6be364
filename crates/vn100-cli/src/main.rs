//! `vn100`: live Allan deviation and statistics for the VectorNav VN-100. The table of contents of
//! the program.

mod args;
mod attach;
mod compare;
mod documentation;
mod exit;
mod files;
mod interrupt;
mod live_source;
mod log;
mod plan;
mod ports;
mod replay;
mod report;
mod result;
mod sensor;
mod sim;
mod status;
mod text;
mod user_files;
mod view;
mod words;

use std::process::ExitCode;

use clap::Parser;
use vn100_pipeline::LiveError;
use vn100_report::Completion;

use crate::args::{Args, Command, OutputFormat};

fn main() -> ExitCode {
    let result = match Args::try_parse().and_then(Args::checked).unwrap_or_else(|error| exit::usage(&error)).command {
        Command::Attach(args) => {
            let format = args.result.format();
            attach::attach(args, format)
        }
        Command::Record(args) => attach::attach(args.into(), OutputFormat::Summary),
        Command::Info(args) => sensor::info(args),
        Command::Configure(args) => sensor::configure(args),
        Command::Replay(args) => replay::replay(&args),
        Command::Compare(args) => compare::compare(&args),
        Command::Plan(args) => plan::plan(&args),
        Command::Report(args) => report::report(&args),
        Command::Sim(args) => sim::sim(&args),
        Command::Ports(args) => ports::ports(&args),
        Command::Completions(args) => documentation::completions(&args),
        Command::Man(args) => documentation::man(&args),
    };
    let completion = match result {
        Ok(completion) => completion,
        Err(error) if exit::is_broken_pipe(&error) => Completion::Complete,
        Err(error) => {
            exit::report(&format!("{error:#}"));
            match error.downcast_ref() {
                Some(LiveError::NoSensor(_)) => Completion::NoData,
                _ => Completion::Failed,
            }
        }
    };
    exit::code(completion)
}
