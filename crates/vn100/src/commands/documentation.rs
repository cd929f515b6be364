//! `vn100 completions` and `vn100 man`: the command line for shells and as manual pages, from the
//! texts of `--help`; `vn100 schema`: the fields of a document.

use std::{fs::File, io::Write, path::Path};

use anyhow::{Context, Result};
use clap::{Arg, ArgAction, Command, CommandFactory};
use clap_mangen::Man;
use vn100_analysis::Completion;
use vn100_report::{analysis_schema, progress_schema};

use crate::{
    args::{Args, CommandHelp, CompletionsArgs, DescribedDocument, ENVIRONMENT, ManArgs, SchemaArgs, help_of},
    exit::print,
};

const PROGRAM: &str = "vn100";

pub(crate) fn schema(args: &SchemaArgs) -> Result<Completion> {
    let schema = match args.document {
        DescribedDocument::Analysis => analysis_schema(),
        DescribedDocument::Progress => progress_schema(),
    };
    print(&(serde_json::to_string_pretty(&schema)? + "\n"))?;
    Ok(Completion::Complete)
}

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
    let man = Man::new(command.clone()).source(concat!("vn100 ", env!("CARGO_PKG_VERSION"))).manual("vn100");
    let mut page = Vec::new();
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    page.extend(synopsis(command).bytes());
    man.render_description_section(&mut page)?;
    man.render_options_section(&mut page)?;
    if command.has_subcommands() {
        man.render_subcommands_section(&mut page)?;
    }
    page.extend(sections(command.get_name()).bytes());
    Ok(String::from_utf8(page)?)
}

/// Text of a man page: a hyphen is a minus, and a line does not begin as a request does.
fn escaped(text: &str) -> String {
    let text = text.replace('\\', "\\e").replace('-', "\\-");
    if text.starts_with(['.', '\'']) { format!("\\&{text}") } else { text }
}

/// The command with all options and their values.
fn synopsis(command: &Command) -> String {
    let words = |option: &Arg| {
        let names: Vec<String> =
            (option.get_short().map(|short| format!("\\fB{}\\fR", escaped(&format!("-{short}")))).into_iter())
                .chain(option.get_long().map(|long| format!("\\fB{}\\fR", escaped(&format!("--{long}")))))
                .collect();
        let values = option.get_value_names().unwrap_or_default();
        let values: Vec<String> = values.iter().map(|value| format!("\\fI{}\\fR", escaped(value))).collect();
        let value = match option.get_action() {
            ArgAction::Set | ArgAction::Append => values.join(" "),
            _ => String::new(),
        };
        let is_optional = option.get_num_args().is_some_and(|range| range.min_values() == 0);
        let value = if is_optional && !value.is_empty() { format!("[{value}]") } else { value };
        let text =
            [names.join("|"), value].iter().filter(|part| !part.is_empty()).cloned().collect::<Vec<_>>().join(" ");
        let text = if option.is_required_set() { text } else { format!("[{text}]") };
        if matches!(option.get_action(), ArgAction::Append)
            || option.get_num_args().is_some_and(|range| range.max_values() > 1)
        {
            format!("{text}...")
        } else {
            text
        }
    };
    let name = command.get_bin_name().unwrap_or(command.get_name());
    let mut parts = vec![format!("\\fB{}\\fR", escaped(name))];
    parts.extend(command.get_arguments().filter(|arg| !arg.is_positional() && !arg.is_hide_set()).map(words));
    parts.extend(command.get_positionals().map(words));
    if command.has_subcommands() {
        parts.push("\\fICOMMAND\\fR".into());
    }
    format!(".SH SYNOPSIS\n{}\n", parts.join("\n"))
}

/// What stands behind the options.
fn sections(command: &str) -> String {
    let CommandHelp { examples, exit_status, files, see_also, .. } = help_of(command);
    let mut out = String::new();
    let mut section = |title: &str, rows: Vec<(String, String)>| {
        if rows.is_empty() {
            return;
        }
        out += &format!(".SH \"{title}\"\n");
        rows.iter().for_each(|(term, text)| out += &format!(".TP\n\\fB{}\\fR\n{}\n", escaped(term), escaped(text)));
    };
    let owned = |(term, text): &(&str, &str)| ((*term).to_owned(), (*text).to_owned());
    section("EXAMPLES", examples.iter().map(|(what, words)| (format!("vn100 {words}"), (*what).to_owned())).collect());
    section(
        "EXIT STATUS",
        exit_status.iter().map(|(code, meaning)| (code.to_string(), (*meaning).to_owned())).collect(),
    );
    section("FILES", files.iter().map(owned).collect());
    section("ENVIRONMENT", ENVIRONMENT.iter().map(owned).collect());
    let mut pages = if command == PROGRAM { Vec::new() } else { vec![format!("\\fB{PROGRAM}\\fR(1)")] };
    pages.extend(see_also.iter().map(|name| format!("\\fB{PROGRAM}\\-{name}\\fR(1)")));
    if pages.is_empty() {
        let all = Args::command();
        pages.extend(all.get_subcommands().map(|other| format!("\\fB{PROGRAM}\\-{}\\fR(1)", other.get_name())));
    }
    out + &format!(".SH \"SEE ALSO\"\n{}\n", pages.join(",\n"))
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

    #[test]
    fn every_page_has_all_sections_and_every_help_its_examples() {
        let mut vn100 = Args::command();
        vn100.build();
        let first = page(&vn100).unwrap();
        assert!(first.contains("\\fBvn100\\-attach\\fR(1)"), "{first}");
        for command in std::iter::once(&vn100).chain(vn100.get_subcommands().filter(|it| it.get_name() != "help")) {
            let page = page(command).unwrap();
            let help = command.clone().render_help().to_string();
            for section in ["EXAMPLES", "EXIT STATUS", "ENVIRONMENT", "SEE ALSO"] {
                assert!(page.contains(&format!(".SH \"{section}\"\n")), "{section}: {page}");
            }
            assert!(help.contains("Examples:\n  vn100 ") && help.contains("Exit status:\n  0  success"), "{help}");
            assert!(!page.contains("default: ]") && !page.contains("EXTRA"), "{page}");
            assert!(help_of(command.get_name()).name == command.get_name() || command.get_name() == PROGRAM);
        }
    }

    #[test]
    fn a_synopsis_has_the_values_of_its_options() {
        let mut vn100 = Args::command();
        vn100.build();
        let of = |name: &str| synopsis(vn100.find_subcommand(name).unwrap());
        let record = of("record");
        assert!(record.contains("\n\\fB\\-o\\fR|\\fB\\-\\-output\\fR \\fIFILE\\fR\n"), "{record}");
        assert!(
            record.contains("\n[\\fB\\-\\-listen\\-only\\fR]\n") && record.ends_with("\n\\fISOURCE\\fR\n"),
            "{record}"
        );
        assert!(of("attach").ends_with("\n[\\fISOURCE\\fR]...\n"));
    }

    #[test]
    fn examples_are_command_lines() {
        let mut vn100 = Args::command();
        vn100.build();
        let names = vn100.get_subcommands().map(Command::get_name).chain([PROGRAM]).filter(|name| *name != "help");
        for (_, words) in names.flat_map(|name| help_of(name).examples) {
            // a part between quotes is one word
            let parts = words.split('\'').enumerate();
            let line = parts.flat_map(|(place, part)| match place % 2 {
                0 => part.split_whitespace().collect(),
                _ => vec![part],
            });
            let parsed = Args::try_parse_from([PROGRAM].into_iter().chain(line)).and_then(Args::checked);
            assert!(parsed.is_ok(), "{words}: {}", parsed.unwrap_err());
        }
    }
}
