//! The tables of the documents list what the program has: each format, channel, unit, message,
//! option value, command, exit status and kind of warning has its row, and there is no other.

use std::{collections::BTreeSet, fs, path::Path, process::Command};

use vn100_analysis::WarningKind;
use vn100_capture::{ColumnMap, Format};
use vn100_protocol::{Channel, MESSAGES, PACKET_MESSAGES, PacketForm};
use vn100_report::glossary::explain;

/// The cells of the rows of the first table below a heading of a document, without its head.
fn rows(document: &str, heading: &str) -> Vec<Vec<String>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(document);
    let text = fs::read_to_string(path).unwrap();
    let (_, below) = text.split_once(heading).unwrap_or_else(|| panic!("{document} lacks {heading:?}"));
    let table = below.lines().skip_while(|line| !line.starts_with("|---")).skip(1);
    let cells = |line: &str| line.trim_matches('|').split(" | ").map(|cell| cell.trim().to_owned()).collect();
    table.take_while(|line| line.starts_with('|')).map(cells).collect()
}

/// What stands in backquotes in a cell.
fn codes(cell: &str) -> Vec<&str> {
    cell.split('`').skip(1).step_by(2).collect()
}

/// The code in the first cell of each row.
fn first_codes(document: &str, heading: &str) -> Vec<String> {
    rows(document, heading).iter().map(|cells| codes(&cells[0])[0].to_owned()).collect()
}

fn help(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_vn100")).args(arguments).output().unwrap();
    String::from_utf8(output.stdout).unwrap()
}

/// The values that the help of a command lists for an option.
fn option_values(command: &str, option: &str) -> Vec<String> {
    let help = help(&[command, "--help"]);
    let (_, below) = help.split_once(&format!(" --{option} <")).unwrap();
    let (_, values) = below.split_once("Possible values:\n").unwrap();
    let value = |line: &str| Some(line.trim().strip_prefix("- ")?.split_once(':')?.0.to_owned());
    values.lines().take_while(|line| !line.trim().is_empty()).filter_map(value).collect()
}

#[test]
fn formats_of_captures() {
    assert_eq!(first_codes("captures.md", "## Formats"), Format::ALL.map(Format::code));
}

/// The units that the error for an unknown one offers; none where any or none is taken.
fn units(channel: &str) -> Vec<String> {
    let error = format!("{channel}=1:nonsense").parse::<ColumnMap>().err().map(|error| error.to_string());
    let offered = error.as_deref().and_then(|text| text.split_once("use one of ")).map_or("", |(_, units)| units);
    offered.split_whitespace().map(str::to_owned).collect()
}

#[test]
fn channels_of_tables_and_their_units() {
    let unknown = "nonsense=1:g".parse::<ColumnMap>().unwrap_err().to_string();
    let (_, channels) = unknown.split_once("use one of ").unwrap();
    let rows = rows("captures.md", "| channels of `--columns`");
    let documented: Vec<&str> = rows.iter().flat_map(|cells| codes(&cells[0])).collect();
    assert_eq!(documented, channels.split_whitespace().collect::<Vec<_>>());
    for cells in &rows {
        for channel in codes(&cells[0]) {
            assert_eq!(codes(&cells[1]), units(channel), "{channel}");
        }
    }
}

#[test]
fn messages_and_their_channels() {
    let documented = rows("reference.md", "## Messages");
    let expected: Vec<Vec<String>> = MESSAGES
        .iter()
        .map(|layout| {
            let channels: Vec<String> = layout.channels.iter().map(|channel| format!("`{}`", channel.name)).collect();
            let nature = match layout.compensated {
                Some(true) => "compensated",
                Some(false) => "uncompensated",
                None => "by register 82, else unknown",
            };
            vec![format!("`${}`", layout.message), channels.join(" "), nature.into()]
        })
        .collect();
    let packets = PACKET_MESSAGES.iter().map(|message| {
        let output = message.output(1, 800).unwrap();
        let form = PacketForm::new(output.groups, &output.field_words).unwrap();
        let channels: Vec<String> =
            form.layout().channels.iter().map(|channel| format!("`{}`", channel.name)).collect();
        let nature = if form.layout().compensated == Some(true) { "compensated" } else { "uncompensated" };
        vec![format!("`{}`", message.name), channels.join(" "), nature.into()]
    });
    assert_eq!(documented, expected.into_iter().chain(packets).collect::<Vec<_>>());
}

#[test]
fn units_and_their_counts() {
    let count = |channel: &Channel| format!("{:.*}", usize::from(channel.decimals), channel.value(1));
    let printed = |channel: &&Channel| channel.increment_step.is_none();
    let channels = MESSAGES.iter().flat_map(|layout| layout.channels.iter()).filter(printed);
    let expected: BTreeSet<_> = channels.map(|channel| (channel.unit.to_string(), count(channel))).collect();
    let rows = rows("reference.md", "## Units");
    let documented = rows.iter().map(|cells| (codes(&cells[1])[0].to_owned(), codes(&cells[2])[0].to_owned()));
    assert_eq!(documented.collect::<BTreeSet<_>>(), expected);
    assert_eq!(rows.len(), expected.len());
}

#[test]
fn values_of_options() {
    assert_eq!(first_codes("reference.md", "## Estimators"), option_values("replay", "estimator"));
    assert_eq!(first_codes("reference.md", "| `--export`"), option_values("report", "export"));
}

#[test]
fn commands() {
    let help = help(&["--help"]);
    let (_, commands) = help.split_once("Commands:\n").unwrap();
    let (commands, _) = commands.split_once("\n\n").unwrap();
    // lines that continue a description are indented further
    let name = |line: &str| line.strip_prefix("  ").filter(|rest| !rest.starts_with(' ')).map(str::to_owned);
    let names = commands.lines().filter_map(name).map(|line| line.split(' ').next().unwrap().to_owned());
    let names: Vec<String> = names.filter(|name| name != "help").collect();
    assert_eq!(first_codes("reference.md", "## Commands"), names);
}

#[test]
fn exit_statuses() {
    let help = help(&["--help"]);
    let (_, statuses) = help.split_once("Exit status:\n").unwrap();
    let expected: Vec<String> = statuses.lines().map(|line| line.trim().to_owned()).collect();
    let rows = rows("reference.md", "## Exit status");
    let documented: Vec<String> = rows.iter().map(|cells| format!("{}  {}", cells[0], cells[1])).collect();
    assert_eq!(documented, expected);
}

#[test]
fn kinds_of_warnings() {
    let severity = |kind: &WarningKind| {
        explain(kind.name()).into_iter().find(|entry| entry.group == "Warnings").map(|entry| entry.title).unwrap()
    };
    let expected: Vec<Vec<String>> = ["problem", "caution", "note"]
        .map(|name| {
            let kinds = WarningKind::ALL.iter().filter(|kind| severity(kind) == name);
            vec![name.to_owned(), kinds.map(|kind| format!("`{}`", kind.name())).collect::<Vec<_>>().join(" ")]
        })
        .into();
    let rows = rows("words.md", "## Warnings");
    let lines: Vec<String> = expected.iter().map(|cells| format!("| {} |", cells.join(" | "))).collect();
    assert_eq!(rows, expected, "the rows are\n{}", lines.join("\n"));
}
