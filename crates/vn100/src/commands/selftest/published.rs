//! Public records, and the tables that others published with them: the records are measured in the
//! same way as any capture, and each row of the tables is compared.

mod records;

use std::{
    fmt::{self, Write as _},
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};
use imu_noise::{Deviation, Estimator};
use tokio::runtime::Builder;
use vn100_analysis::{AveragingTimes, Completion, Settings, SourceResult};
use vn100_capture::{CaptureOptions, captures_below};
use vn100_session::{ReplaySpec, Session};

use self::records::{PublishedFile, PublishedRecord, PublishedRow, PublishedTable, RECORDS};
use crate::{
    digest::digest,
    exit::{print, unless_closed},
    result::FAULT,
    text::{fill, text},
};

/// Says which records there are, and where they can be had.
pub(super) fn list() -> Result<Completion> {
    unless_closed(print(&text(|out| {
        for record in RECORDS {
            write_head(out, record)?;
            writeln!(out, "{}", fill(record.origin, "  from ", "    "))?;
            let files = record.files.iter().chain(record.tables.iter().map(|table| &table.file));
            let mut files: Vec<&PublishedFile> = files.collect();
            files.dedup();
            for PublishedFile { name, sha256, .. } in files {
                writeln!(out, "  {name}\n    SHA-256 {sha256}")?;
            }
            writeln!(out)?;
        }
        writeln!(out, "compare those in a folder: vn100 selftest --published FOLDER")
    })))?;
    Ok(Completion::Complete)
}

/// Compares the records whose files are at or below the folder, under any name.
pub(super) fn compare(folder: &Path) -> Result<Completion> {
    let known =
        RECORDS.iter().flat_map(|record| record.files.iter().chain(record.tables.iter().map(|table| &table.file)));
    let known: Vec<&PublishedFile> = known.collect();
    let mut found: Vec<(&str, PathBuf)> = Vec::new();
    for path in captures_below(folder) {
        let bytes = fs::metadata(&path).with_context(|| path.display().to_string())?.len();
        if known.iter().any(|file| file.bytes == bytes) {
            let facts = digest(&path).with_context(|| path.display().to_string())?;
            found.extend(known.iter().find(|file| file.sha256 == facts.sha256).map(|file| (file.sha256, path)));
        }
    }
    let path_of = |file: &PublishedFile| Some(found.iter().find(|(sha256, _)| *sha256 == file.sha256)?.1.as_path());
    let (mut compared, mut differing) = (0, 0);
    for record in RECORDS {
        let series = record.files.iter().find_map(path_of);
        let tables = record.tables.iter().filter_map(|table| Some((table, path_of(&table.file)?)));
        let mut lines = text(|out| write_head(out, record));
        let Some(series) = series else {
            lines += "  not there: `vn100 selftest --published` says where it can be had\n\n";
            unless_closed(print(&lines))?;
            continue;
        };
        for (table, path) in tables {
            let comparison = compared_table(record, series, table, path)?;
            compared += 1;
            differing += usize::from(!comparison.agrees());
            lines += &text(|out| comparison.write(out));
        }
        unless_closed(print(&(lines + "\n")))?;
    }
    let (outcome, completion) = match (compared, differing) {
        (0, _) => ("nothing to compare: no known record is there with a table".to_owned(), Completion::NoData),
        (_, 0) => (format!("all {compared} tables agree"), Completion::Complete),
        _ => {
            let counts = format!("{differing} of {compared} tables differ");
            (format!("{counts}: do not trust the results of this program on this machine"), Completion::Failed)
        }
    };
    unless_closed(print(&format!("{outcome}\n")))?;
    Ok(completion)
}

fn write_head(out: &mut String, record: &PublishedRecord) -> fmt::Result {
    writeln!(out, "{}", fill(&format!("{} ({}; {})", record.title, record.owner, record.licence), "", "  "))
}

/// A published table beside the numbers of this program.
struct Comparison<'a> {
    table: &'a PublishedTable,
    rows: usize,
    /// The largest relative difference, and the row that has it; `None` if a row has no value here.
    largest: Option<(f64, PublishedRow)>,
}

impl Comparison<'_> {
    fn agrees(&self) -> bool {
        self.largest.as_ref().is_some_and(|(difference, _)| difference.abs() <= self.table.tolerance)
    }

    fn write(&self, out: &mut String) -> fmt::Result {
        let PublishedTable { title, tolerance, .. } = self.table;
        let verdict = if self.agrees() { "agrees to" } else { "DIFFERS by more than" };
        let largest = match &self.largest {
            Some((difference, PublishedRow { channel, m, .. })) => format!("{difference:+.1e} at {channel}, m = {m}"),
            None => "a row has no value here".into(),
        };
        writeln!(out, "  {title}\n    {} rows, {verdict} {tolerance:.0e}: {largest}", self.rows)
    }
}

fn compared_table<'a>(
    record: &PublishedRecord,
    series: &Path,
    table: &'a PublishedTable,
    path: &Path,
) -> Result<Comparison<'a>> {
    let content = fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let rows =
        (table.rows)(&content).with_context(|| format!("{}: a row of the table cannot be read", path.display()))?;
    let mut factors: Vec<u64> = rows.iter().map(|row| row.m).collect();
    factors.sort_unstable();
    factors.dedup();
    let measured = measured(record, series, table.deviation, &factors)?;
    let mut largest: Option<(f64, PublishedRow)> = None;
    let count = rows.len();
    for row in rows {
        let Some(ours) = deviation_of(&measured, &row) else {
            return Ok(Comparison { table, rows: count, largest: None });
        };
        let difference = ours / row.deviation - 1.0;
        if largest.as_ref().is_none_or(|(most, _)| difference.abs() > most.abs()) {
            largest = Some((difference, row));
        }
    }
    Ok(Comparison { table, rows: count, largest })
}

fn deviation_of(measured: &SourceResult, row: &PublishedRow) -> Option<f64> {
    let channel = measured.channels.iter().find(|channel| channel.name == row.channel)?;
    channel.allan.points.iter().find(|point| point.m == row.m)?.deviation
}

/// The deviation of the record at these averaging factors, with all windows.
fn measured(record: &PublishedRecord, series: &Path, deviation: Deviation, factors: &[u64]) -> Result<SourceResult> {
    let times = factors.iter().map(|m| *m as f64 / record.rate_hz).collect();
    let spec = ReplaySpec {
        settings: Settings {
            rate_hz: Some(record.rate_hz),
            estimator: Estimator::Full,
            deviation,
            averaging_times: AveragingTimes::List(times),
            ..Settings::default()
        },
        capture: CaptureOptions { columns: Some(record.columns.parse()?), ..CaptureOptions::default() },
        ..ReplaySpec::of(series)
    };
    let runtime = Builder::new_multi_thread().enable_all().build().context("cannot start the worker threads")?;
    let result = runtime.block_on(async { Session::replay(spec).result.await }).context(FAULT)?;
    if let Some(error) = &result.start_error {
        bail!("{}: {error}", series.display());
    }
    Ok(result.measured)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_that_differs_and_a_row_without_a_value_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let (series, table) = (folder.path().join("series.txt"), folder.path().join("table.txt"));
        let digits = (0..100_u32).map(|row| format!("7.{:03}\n", row.wrapping_mul(2_654_435_761) >> 22));
        fs::write(&series, digits.collect::<String>()).unwrap();
        let record = PublishedRecord {
            title: "",
            owner: "",
            licence: "",
            origin: "",
            files: &[],
            rate_hz: 1.0,
            columns: "value=1:1",
            tables: &[],
        };
        let published = &RECORDS[1].tables[0];
        let compared = |rows: &str| {
            fs::write(&table, rows).unwrap();
            let comparison = compared_table(&record, &series, published, &table).unwrap();
            (comparison.agrees(), text(|out| comparison.write(out)))
        };
        let measured = measured(&record, &series, Deviation::Allan, &[1, 3]).unwrap();
        let sigma = |m: u64| {
            let row = PublishedRow { channel: "value".into(), m, deviation: 0.0 };
            deviation_of(&measured, &row).unwrap() * 1e-7
        };
        let row = |m: u64, sigma: f64| format!("{m} {m} 9 0 0 {sigma:e} 0\n");
        let (agrees, told) = compared(&(row(1, sigma(1)) + &row(3, sigma(3))));
        assert!(agrees && told.contains("2 rows, agrees to 5e-5"), "{told}");
        let (agrees, told) = compared(&(row(1, sigma(1)) + &row(3, 1.001 * sigma(3))));
        assert!(!agrees && told.contains("DIFFERS by more than 5e-5: -1.0e-3 at value, m = 3"), "{told}");
        let (agrees, told) = compared(&(row(1, sigma(1)) + &row(70, 1.0)));
        assert!(!agrees && told.contains("a row has no value here"), "{told}");
        fs::write(&table, "1 1 9 0 0 one 0\n").unwrap();
        assert!(compared_table(&record, &series, published, &table).is_err());
    }
}
