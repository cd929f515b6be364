//! `vn100 completions` and `vn100 man`: the command line for shells and as manual pages, from the
//! texts of `--help`; `vn100 schema`: the fields of a document.

use std::{fs::File, io::Write, path::Path};

use anyhow::{Context, Result};
use clap::{Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;
use vn100_analysis::Completion;
use vn100_report::{analysis_schema, progress_schema};

use crate::{
    args::{Args, DescribedDocument},
    exit::print,
};

pub(crate) fn schema(document: DescribedDocument) -> Result<Completion> {
    let schema = match document {
        DescribedDocument::Analysis => analysis_schema(),
        DescribedDocument::Progress => progress_schema(),
    };
    print(&(serde_json::to_string_pretty(&schema)? + "\n"))?;
    Ok(Completion::Complete)
}

pub(crate) fn completions(shell: Shell) -> Result<Completion> {
    // written to memory first: clap_complete panics where its output cannot be written
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Args::command(), "vn100", &mut script);
    print(&String::from_utf8(script)?)?;
    Ok(Completion::Complete)
}

pub(crate) fn man(folder: Option<&Path>) -> Result<Completion> {
    let mut vn100 = Args::command().disable_help_subcommand(true);
    // gives the commands their whole names
    vn100.build();
    match folder {
        Some(folder) => {
            write_page(folder, &vn100)?;
            vn100.get_subcommands().try_for_each(|command| write_page(folder, command))?;
        }
        None => print(&page(&vn100)?)?,
    }
    Ok(Completion::Complete)
}

fn page(command: &Command) -> Result<String> {
    let man = Man::new(command.clone()).source(concat!("vn100 ", env!("CARGO_PKG_VERSION"))).manual("vn100");
    let mut page = Vec::new();
    man.render(&mut page)?;
    Ok(String::from_utf8(page)?)
}

fn write_page(folder: &Path, command: &Command) -> Result<()> {
    let path = folder.join(Man::new(command.clone()).get_filename());
    let write = || -> Result<()> { Ok(File::create_new(&path)?.write_all(page(command)?.as_bytes())?) };
    write().with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::help_of;

    #[test]
    fn every_help_and_page_has_its_examples() {
        let mut vn100 = Args::command();
        vn100.build();
        for command in std::iter::once(&vn100).chain(vn100.get_subcommands().filter(|it| it.get_name() != "help")) {
            let page = page(command).unwrap();
            let help = command.clone().render_help().to_string();
            assert!(help.contains("Examples:\n  vn100 ") && help.contains("Exit status:\n  0  success"), "{help}");
            assert!(page.contains(".SH EXTRA\nExamples:") && !page.contains("default: ]"), "{page}");
            let name = command.get_name();
            assert!(name == "vn100" || help_of(name).0.iter().all(|(_, words)| words.starts_with(name)), "{name}");
        }
    }

    #[test]
    fn examples_are_command_lines() {
        let mut vn100 = Args::command();
        vn100.build();
        let names = vn100.get_subcommands().map(Command::get_name).chain(["vn100"]).filter(|name| *name != "help");
        for (_, words) in names.flat_map(|name| help_of(name).0) {
            // a part between quotes is one word
            let parts = words.split('\'').enumerate();
            let line = parts.flat_map(|(place, part)| match place % 2 {
                0 => part.split_whitespace().collect(),
                _ => vec![part],
            });
            let parsed = Args::try_parse_from(["vn100"].into_iter().chain(line)).and_then(Args::checked);
            assert!(parsed.is_ok(), "{words}: {}", parsed.unwrap_err());
        }
    }
}
