//! `vn100 completions`: what a shell needs to complete the command line.

use anyhow::Result;
use clap::CommandFactory;

use crate::{
    args::{Args, CompletionsArgs},
    exit::{Exit, print},
};

pub(crate) fn completions(args: &CompletionsArgs) -> Result<Exit> {
    // written to memory first: clap_complete panics where its output cannot be written
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Args::command(), "vn100", &mut script);
    print(&String::from_utf8(script)?)?;
    Ok(Exit::Good)
}
