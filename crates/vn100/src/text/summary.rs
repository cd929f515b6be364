//! The summary of a result: at most [`MOST_LINES`] lines of [`WIDTH`] columns.

use clap::builder::styling::{AnsiColor, Style};
use textwrap::{Options, WordSplitter};
use vn100_analysis::Severity;
use vn100_report::{
    Measured, Record, printable,
    summary::{AXES, AspectStatus, Cells, ParameterRow, SensorTable, StatisticsRow, Summary},
};

use super::WIDTH;
use vn100_report::remedies::remedy_words;

/// Two screens of most terminals would be too many.
const MOST_LINES: usize = 45;

/// Columns of the parts of a table.
const LABEL: usize = 29;
const CELL: usize = 8;
const FIGURE: usize = 14;
const VERDICT: usize = 13;

/// Columns before what was found on an aspect.
const FOUND: usize = 21;

/// Findings of one aspect that are shown.
const MOST_FOUND: usize = 3;

/// Those before and above the statistics, before the notes, and the last one.
const OTHER_LINES: usize = 4;

/// Lines of the summary, each with the style of its characters.
struct Lines {
    is_coloured: bool,
    lines: Vec<String>,
}

impl Lines {
    fn push(&mut self, line: &str) {
        self.lines.push(line.trim_end().to_owned());
    }

    fn paint(&self, text: &str, style: Style) -> String {
        if self.is_coloured { format!("{style}{text}{style:#}") } else { text.to_owned() }
    }
}

const BOLD: Style = Style::new().bold();
const FAINT: Style = Style::new().dimmed();

const fn of_severity(severity: Option<Severity>) -> Style {
    match severity {
        Some(Severity::Problem) => AnsiColor::Red.on_default().bold(),
        Some(Severity::Caution) => AnsiColor::Yellow.on_default(),
        Some(Severity::Note) => AnsiColor::Cyan.on_default(),
        None => AnsiColor::Green.on_default(),
    }
}

/// The summary, with a line feed behind each line.
pub(crate) fn summary(measured: &Measured, is_coloured: bool) -> String {
    let summary = Summary::new(&Record::new(measured), remedy_words);
    let mut lines = Lines { is_coloured, lines: Vec::new() };
    write_identity(&mut lines, &summary.identity);
    summary.statuses.iter().for_each(|status| write_status(&mut lines, status));
    let notes = noted(&summary.notes);
    let tables: usize = summary.sensors.iter().map(|table| table.rows.len() + 1).sum();
    let known = lines.lines.len() + tables + summary.statistics.len() + notes.len();
    // blank lines are given up first
    let is_airy = known + summary.sensors.len() + OTHER_LINES <= MOST_LINES;
    for (place, table) in summary.sensors.iter().enumerate() {
        if is_airy || place == 0 {
            lines.push("");
        }
        write_table(&mut lines, table);
    }
    write_statistics(&mut lines, &summary.statistics);
    write_notes(&mut lines, &notes);
    lines.lines.join("\n") + "\n"
}

/// Parts that belong together are not torn apart.
fn write_identity(lines: &mut Lines, parts: &[String]) {
    let mut line = String::new();
    for part in parts.iter().map(|part| printable(part)) {
        if !line.is_empty() && width(&line) + 2 + width(&part) > WIDTH {
            lines.push(&lines.paint(&line, BOLD));
            line = "  ".into();
        } else if !line.is_empty() {
            line += "  ";
        }
        line += &part;
    }
    lines.push(&lines.paint(&line, BOLD));
}

fn write_status(lines: &mut Lines, status: &AspectStatus) {
    let AspectStatus { aspect, severity, word, findings } = status;
    let more = findings.len().saturating_sub(MOST_FOUND);
    let found = findings.iter().take(MOST_FOUND).map(|(text, notes)| format!("{}{}", printable(text), marks(notes)));
    let more = (more > 0).then(|| format!("and {more} more (`vn100 report`)"));
    for (place, text) in found.chain(more).enumerate() {
        let room = WIDTH - FOUND;
        for (row, part) in wrapped(&text, room).iter().enumerate() {
            let head = match (place, row) {
                (0, 0) => {
                    format!("  {aspect:<9} {}", lines.paint(&format!("{word:<9}"), of_severity(*severity)))
                }
                _ => " ".repeat(FOUND),
            };
            lines.push(&format!("{head}{part}"));
        }
    }
}

fn write_table(lines: &mut Lines, table: &SensorTable) {
    let cells: String = table.axes.iter().map(|axis| right(axis, CELL)).collect();
    let datasheet = match table.has_datasheet {
        true => {
            let datasheet = right(&format!("data sheet{}", marks(&table.notes)), FIGURE);
            let verdict = right("verdict", (FIGURE + VERDICT).saturating_sub(width(&datasheet)));
            datasheet + &verdict
        }
        false => String::new(),
    };
    let title = left(table.title, LABEL);
    let between = " ".repeat(CELL * (AXES - table.axes.len()));
    lines.push(&(lines.paint(&title, BOLD) + &lines.paint(&format!("{cells}{between}{datasheet}"), FAINT)));
    table.rows.iter().for_each(|row| write_row(lines, row));
}

fn write_row(lines: &mut Lines, row: &ParameterRow) {
    let ParameterRow { label, unit, is_detail, cells, figure } = row;
    let label = match is_detail {
        true => left(&format!("  {label}"), LABEL),
        false => format!("{}{unit}", left(label, LABEL - width(unit))),
    };
    let cells = match cells {
        Cells::Axes(cells) => left(&cells.iter().map(|cell| right(cell, CELL)).collect::<String>(), CELL * AXES),
        Cells::All(text) => right(text, CELL * AXES),
    };
    let label = if *is_detail { lines.paint(&label, FAINT) } else { label };
    let figure = figure.as_ref().map_or(String::new(), |(claim, verdict)| {
        let word = right(&verdict.word, VERDICT);
        let word = if verdict.is_failed { lines.paint(&word, of_severity(Some(Severity::Problem))) } else { word };
        format!("{}{word}", right(claim, FIGURE))
    });
    lines.push(&format!("{label}{cells}{figure}"));
}

fn write_statistics(lines: &mut Lines, rows: &[StatisticsRow]) {
    if rows.is_empty() {
        return;
    }
    lines.push("");
    lines.push(&lines.paint("Mean and standard deviation of one sample", BOLD));
    for StatisticsRow { label, unit, cells, remark } in rows {
        let label = format!("{}{unit}", left(label, LABEL - width(unit)));
        let cells: String = cells.iter().map(|cell| right(cell, CELL)).collect();
        lines.push(&format!("{label}{}  {remark}", left(&cells, CELL * AXES)));
    }
}

/// The lines of all notes, numbered.
fn noted(notes: &[String]) -> Vec<String> {
    let lines = |(note, number): (&String, usize)| {
        let rows = wrapped(&printable(note), WIDTH - 4);
        let head = |row| if row == 0 { format!("[{number}]") } else { String::new() };
        rows.into_iter().enumerate().map(|(row, text)| format!("{:<4}{text}", head(row))).collect::<Vec<_>>()
    };
    notes.iter().zip(1..).flat_map(lines).collect()
}

/// As many as there is room for.
fn write_notes(lines: &mut Lines, notes: &[String]) {
    const EVERYTHING: &str = "everything: `vn100 report FILE` as a page, --json as a document";
    const MORE: &str = "    ... more: `vn100 report`";
    let room = MOST_LINES.saturating_sub(lines.lines.len() + 2);
    lines.push("");
    let fitting = if notes.len() <= room { notes.len() } else { room.saturating_sub(1) };
    notes.iter().take(fitting).for_each(|line| lines.push(line));
    if fitting < notes.len() {
        lines.push(MORE);
    }
    lines.push(&lines.paint(EVERYTHING, FAINT));
}

/// ` [1] [3]`.
fn marks(notes: &[usize]) -> String {
    notes.iter().map(|place| format!(" [{}]", place + 1)).collect()
}

fn wrapped(text: &str, room: usize) -> Vec<String> {
    // a number stays with its unit
    let text = text.replace(" %", "\u{a0}%").replace(" Hz", "\u{a0}Hz");
    textwrap::wrap(&text, Options::new(room).word_splitter(WordSplitter::NoHyphenation))
        .into_iter()
        .map(|line| line.replace('\u{a0}', " "))
        .collect()
}

/// Columns: no wide characters are among the signs of units.
fn width(text: &str) -> usize {
    text.chars().count()
}

fn left(text: &str, columns: usize) -> String {
    format!("{text}{}", " ".repeat(columns.saturating_sub(width(text))))
}

/// With a blank before it at least.
fn right(text: &str, columns: usize) -> String {
    format!("{}{text}", " ".repeat(columns.saturating_sub(width(text)).max(1)))
}
