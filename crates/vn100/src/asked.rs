//! What was asked of a measurement, as a user would ask for it again: what a report says of it.

use std::path::Path;

use clap::{Arg, ArgMatches, CommandFactory, parser::ValueSource};

use crate::args::Args;

/// The groups of options that decide what is measured, and how it is judged.
const DECIDING: [&str; 4] = ["Measurement", "Targets and limits", "Capture", "Exports"];

/// The options of this command line that decide about a result.
pub(crate) fn asked() -> String {
    let program = Args::command();
    let matches = program.clone().try_get_matches();
    let Some((name, matches)) = matches.as_ref().ok().and_then(ArgMatches::subcommand) else { return String::new() };
    let options = program.find_subcommand(name).into_iter().flat_map(|command| command.get_arguments());
    options.flat_map(|option| words(option, matches)).collect::<Vec<_>>().join(" ")
}

/// An option as it was given, once for each of its values; nothing if it was not.
fn words(option: &Arg, matches: &ArgMatches) -> Vec<String> {
    let (id, long) = (option.get_id().as_str(), option.get_long().unwrap_or_default());
    let is_deciding = option.get_help_heading().is_some_and(|heading| DECIDING.contains(&heading));
    if !is_deciding || matches.value_source(id) != Some(ValueSource::CommandLine) {
        return Vec::new();
    }
    if !option.get_action().takes_values() {
        return vec![format!("--{long}")];
    }
    let values = matches.get_raw(id).into_iter().flatten().map(|value| value.to_string_lossy().into_owned());
    values
        .map(|value| match id {
            // without its folder: a page says the same wherever the files lie
            "datasheet" => Path::new(&value).file_name().unwrap_or_default().to_string_lossy().into_owned(),
            _ => value,
        })
        .map(|value| if value.contains(' ') { format!("--{long} \"{value}\"") } else { format!("--{long} {value}") })
        .collect()
}
