//! `vn100`: live Allan deviation and statistics for the VectorNav VN-100. Dispatches to the
//! commands.

mod args;
mod asked;
mod commands;
mod digest;
mod exit;
mod heartbeat;
mod inputs;
mod live_source;
mod log;
mod output;
mod result;
mod samples;
mod serve;
mod status;
mod text;
mod twin;
mod user_files;
mod watched;
mod words;

use std::process::ExitCode;

use clap::Parser;
use vn100_analysis::Completion;
use vn100_session::LiveError;

use crate::{
    args::{Args, OutputFormat, Subcommand},
    commands::{
        archive, attach, compare, documentation, explain, export, plan, ports, replay, report, selftest, sensor, sim,
        witness,
    },
};

fn main() -> ExitCode {
    let result = match Args::try_parse().and_then(Args::checked).unwrap_or_else(|error| exit::usage(&error)).command {
        Subcommand::Attach(args) => {
            let format = args.result.format();
            attach::attach(args, format)
        }
        Subcommand::Record(args) => attach::attach(args.into(), OutputFormat::Head),
        Subcommand::Info(args) => sensor::info(args),
        Subcommand::Configure(args) => sensor::configure(args),
        Subcommand::Replay(args) => replay::replay(&args),
        Subcommand::Archive(args) => archive::archive(&args),
        Subcommand::Compare(args) => compare::compare(&args),
        Subcommand::Plan(args) => plan::plan(&args),
        Subcommand::Report(args) => report::report(&args),
        Subcommand::Export(args) => export::export(&args),
        Subcommand::Sim(args) => sim::sim(&args),
        Subcommand::Witness(args) => witness::witness(&args),
        Subcommand::Selftest { published } => selftest::selftest(published),
        Subcommand::Explain { code } => explain::explain(&code),
        Subcommand::Ports => ports::ports(),
        Subcommand::Schema { document } => documentation::schema(document),
        Subcommand::Completions { shell } => documentation::completions(shell),
        Subcommand::Man { output } => documentation::man(output.as_deref()),
    };
    let completion = match result {
        Ok(completion) => completion,
        Err(error) if exit::is_broken_pipe(&error) => Completion::Complete,
        Err(error) => {
            if let Some(error) = error.downcast_ref() {
                exit::usage(error);
            }
            exit::report(&format!("{error:#}"));
            match error.downcast_ref() {
                Some(LiveError::NoSensor(_)) => Completion::NoData,
                _ => Completion::Failed,
            }
        }
    };
    exit::code(completion)
}
