//! `vn100 completions` and `vn100 man`: the command line for shells and as manual pages, from the
//! texts of `--help`.

use std::{fs::File, io::Write, path::Path};

use anyhow::{Context, Result};
use clap::{Command, CommandFactory};
use clap_mangen::Man;
use vn100_report::Completion;

use crate::{
    args::{Args, CompletionsArgs, ManArgs},
    exit::print,
};

pub(crate) fn completions(args: &CompletionsArgs) -> Result<Completion> {
    // written to memory first: clap_complete panics where its output cannot be written
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Args::command(), "vn100", &mut script);
    print(&String::from_utf8(script)?)?;
    Ok(Completion::Complete)
}

pub(crate) fn man(args: &ManArgs) -> Result<Completion> {
    let mut vn100 = Args::command().disable_help_subcommand(true);
    // gives the commands their whole names
    vn100.build();
    match &args.output {
        Some(folder) => {
            write_page(folder, &vn100)?;
            vn100.get_subcommands().try_for_each(|command| write_page(folder, command))?;
        }
        None => print(&page(&vn100)?)?,
    }
    Ok(Completion::Complete)
}

fn page(command: &Command) -> Result<String> {
    let mut page = Vec::new();
    Man::new(command.clone()).source(concat!("vn100 ", env!("CARGO_PKG_VERSION"))).render(&mut page)?;
    // what follows the help of the program
    Ok(String::from_utf8(page)?.replace(".SH EXTRA\n", ".SH \"EXIT STATUS\"\n"))
}

fn write_page(folder: &Path, command: &Command) -> Result<()> {
    let path = folder.join(Man::new(command.clone()).get_filename());
    let write = || -> Result<()> { Ok(File::create_new(&path)?.write_all(page(command)?.as_bytes())?) };
    write().with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_have_the_usual_heads_and_no_default_that_is_nothing() {
        let mut vn100 = Args::command();
        vn100.build();
        let first = page(&vn100).unwrap();
        assert!(first.contains(".SH \"EXIT STATUS\"\nExit codes: 0 good"), "{first}");
        for command in vn100.get_subcommands() {
            let page = page(command).unwrap();
            assert!(!page.contains("default: ]") && !page.contains("EXTRA"), "{page}");
        }
    }
}
