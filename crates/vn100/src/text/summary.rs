//! The summary of a result: at most [`MOST_LINES`] lines of [`WIDTH`] columns.

use clap::builder::styling::{AnsiColor, Style};
use textwrap::{Options, WordSplitter};
use vn100_analysis::{Severity, SourceResult};
use vn100_report::{
    printable,
    summary::{AXES, AspectStatus, ParameterRow, SensorTable, StatisticsRow, Summary},
};

use super::WIDTH;
use vn100_report::remedies::remedy_words;

/// A summary of three axes of three sensors.
const MOST_LINES: usize = 36;

/// Columns of the parts of a table.
const LABEL: usize = 17;
const CELL: usize = 12;
const FIGURE: usize = 14;
const VERDICT: usize = 13;

/// Columns of a mean or a standard deviation.
const STATISTIC: usize = 8;

/// Columns before what was found on an aspect.
const FOUND: usize = 21;

/// Findings of one aspect that are shown.
const MOST_FOUND: usize = 3;

/// Lines of the summary, each with the style of its characters.
struct Lines {
    is_coloured: bool,
    lines: Vec<String>,
}

impl Lines {
    fn push(&mut self, line: &str) {
        self.lines.push(line.trim_end().to_owned());
    }

    /// These texts below each other, with a head of so many columns before the first.
    fn push_beside(&mut self, head: &str, columns: usize, texts: &[String]) {
        let heads = std::iter::once(head.to_owned()).chain(std::iter::repeat(" ".repeat(columns)));
        heads.zip(texts).for_each(|(head, text)| self.push(&(head + text)));
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

/// The summary, with a line feed after each line: the noise parameters, whether the record can be
/// trusted, means and standard deviations, what to do. What has no room is left to the report: the
/// drift first unless its coasts were chosen, then the notes, the statistics, and all findings of an
/// aspect but the first.
pub(crate) fn summary(result: &SourceResult, is_coloured: bool) -> String {
    let summary = Summary::new(result, remedy_words);
    let new = || Lines { is_coloured, lines: Vec::new() };
    let mut lines = new();
    write_identity(&mut lines, &summary.identity);
    summary.sensors.iter().for_each(|table| write_table(&mut lines, table));
    let statuses = |most: usize| {
        let mut lines = new();
        summary.statuses.iter().for_each(|status| write_status(&mut lines, status, most));
        lines.lines
    };
    let room = MOST_LINES.saturating_sub(lines.lines.len() + 1);
    let trust = if statuses(MOST_FOUND).len() <= room { statuses(MOST_FOUND) } else { statuses(1) };
    let mut statistics = new();
    write_statistics(&mut statistics, &summary.statistics);
    let mut drift = new();
    write_drift(&mut drift, &summary.drift);
    let notes: usize = summary.notes.iter().map(|note| wrapped(&printable(note), WIDTH - 4).len()).sum();
    let with_drift = trust.len() + statistics.lines.len() + drift.lines.len();
    let has_drift = !result.settings().coasts.is_empty() || with_drift + notes <= room;
    if !has_drift {
        drift.lines.clear();
    }
    let has_room = trust.len() + statistics.lines.len() + drift.lines.len() <= room;
    lines.lines.extend(drift.lines);
    lines.lines.extend(trust);
    lines.lines.extend(statistics.lines.into_iter().filter(|_| has_room));
    write_notes(&mut lines, &summary.notes, !has_drift);
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

fn write_status(lines: &mut Lines, status: &AspectStatus, most: usize) {
    let AspectStatus { aspect, severity, word, findings } = status;
    let more = findings.len().saturating_sub(most);
    let found = findings.iter().take(most).map(|(text, notes)| format!("{}{}", printable(text), marks(notes)));
    let more = (more > 0).then(|| format!("and {more} more (`vn100 report`)"));
    let word = lines.paint(&format!("{:<9}", word.word()), of_severity(*severity));
    let texts: Vec<String> = found.chain(more).flat_map(|text| wrapped(&text, WIDTH - FOUND)).collect();
    lines.push_beside(&format!("  {aspect:<9} {word}"), FOUND, &texts);
}

/// How far the sensor drifts while it coasts, below its parameters.
fn write_drift(lines: &mut Lines, texts: &[String]) {
    const HEAD: &str = "Coasting ";
    let texts: Vec<String> = texts.iter().flat_map(|text| wrapped(&printable(text), WIDTH - HEAD.len())).collect();
    lines.push_beside(HEAD, HEAD.len(), &texts);
}

fn write_table(lines: &mut Lines, table: &SensorTable) {
    let cells: String = table.axes.iter().map(|axis| right(axis, CELL)).collect();
    let datasheet = match table.has_datasheet {
        true => {
            let datasheet = right(&format!("sheet{}", marks(&table.notes)), FIGURE);
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
    let ParameterRow { short_label, unit, is_detail, cells, figure, .. } = row;
    let label = format!("{}{unit}", left(short_label, LABEL - width(unit)));
    let label = if *is_detail { lines.paint(&label, FAINT) } else { label };
    let cells = match &cells[..] {
        [text] => right(text, CELL * AXES),
        cells => left(&cells.iter().map(|cell| right(cell, CELL)).collect::<String>(), CELL * AXES),
    };
    let figure = figure.as_ref().map_or(String::new(), |(claim, verdict)| {
        let word = right(&verdict.word, VERDICT);
        let word = if verdict.is_failed { lines.paint(&word, of_severity(Some(Severity::Problem))) } else { word };
        format!("{}{word}", right(claim, FIGURE))
    });
    lines.push(&format!("{label}{cells}{figure}"));
}

fn write_statistics(lines: &mut Lines, rows: &[StatisticsRow]) {
    let Some(first) = rows.first() else { return };
    let head = |name: &str, axes: usize| left(&right(name, STATISTIC), STATISTIC * axes);
    let axes = first.means.len().max(1);
    let title = left("One sample", LABEL) + &head("mean", axes) + &head("std", axes);
    lines.push(&lines.paint(title.trim_end(), FAINT));
    for StatisticsRow { label, unit, means, stds, remark } in rows {
        let label = format!("{}{unit}", left(label, LABEL - width(unit)));
        let cells = |cells: &[String]| -> String {
            left(&cells.iter().map(|cell| right(cell, STATISTIC)).collect::<String>(), STATISTIC * axes)
        };
        lines.push(&format!("{label}{}{}  {remark}", cells(means), cells(stds)));
    }
}

/// As many notes as there is room for; the last line names the others.
fn write_notes(lines: &mut Lines, notes: &[String], lacks_drift: bool) {
    let mut room = MOST_LINES.saturating_sub(lines.lines.len() + 1);
    let mut left_out = Vec::new();
    for (place, note) in notes.iter().enumerate() {
        let rows = wrapped(&printable(note), WIDTH - 4);
        if rows.len() > room {
            left_out.push(place);
            continue;
        }
        room -= rows.len();
        lines.push_beside(&format!("{:<4}", format!("[{}]", place + 1)), 4, &rows);
    }
    let notes = if left_out.is_empty() { String::new() } else { format!("the notes{}", marks(&left_out)) };
    let more = [if lacks_drift { "the drift" } else { "" }, &notes].map(str::to_owned);
    let more = more.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" and ");
    let everything = match more.is_empty() {
        true => "everything: `vn100 report FILE` as a page, --json as a document".to_owned(),
        false => format!("everything, also {more}: `vn100 report FILE`, or --json"),
    };
    wrapped(&everything, WIDTH).iter().take(1).for_each(|line| lines.push(&lines.paint(line, FAINT)));
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
