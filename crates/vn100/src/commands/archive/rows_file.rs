//! The file of the rows of an archive, which a later run continues.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs::{self, File, OpenOptions},
    io::{BufRead, BufReader, BufWriter, Write},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};
use vn100_analysis::Completion;
use vn100_report::{ArchiveRow, ArchivedFile, numbers::plain::counted};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RowForm {
    /// A line of JSON each.
    Lines,
    /// A line of a table each, under a header.
    Table,
}

impl RowForm {
    fn of(path: &Path) -> Self {
        let is_table = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
        if is_table { Self::Table } else { Self::Lines }
    }

    pub(super) fn text(self, rows: &[ArchiveRow]) -> String {
        let line = match self {
            Self::Lines => ArchiveRow::json_line,
            Self::Table => ArchiveRow::table_line,
        };
        rows.iter().map(line).collect()
    }

    fn header(self) -> String {
        match self {
            Self::Lines => String::new(),
            Self::Table => ArchiveRow::table_header(),
        }
    }
}

/// The rows of one capture, which stand together.
struct Block {
    /// `None` for a last line that was cut.
    file: Option<ArchivedFile>,
    rows: usize,
    found: usize,
    /// The worst of its recordings.
    completion: Completion,
}

/// A file of rows, open at its end.
pub(super) struct RowsFile {
    path: PathBuf,
    form: RowForm,
    file: File,
    /// The captures whose rows are there.
    measured: BTreeSet<String>,
    /// The number of rows and the outcome of each of those that are wanted.
    kept: Vec<(usize, Completion)>,
}

impl RowsFile {
    /// Opens the file at `path`, or makes it. Of `wanted`, the captures by their paths, those rows
    /// are kept that are whole and of the capture as it is now; rows of other captures are kept
    /// too.
    pub(super) fn open(path: &Path, wanted: &BTreeMap<String, ArchivedFile>) -> Result<Self> {
        let form = RowForm::of(path);
        let blocks = if path.exists() { blocks(path, form)? } else { Vec::new() };
        let (mut measured, mut wanted_there) = (BTreeSet::new(), Vec::new());
        let is_kept = |block: &Block| {
            block.file.as_ref().is_some_and(|file| {
                let now = wanted.get(&file.path);
                let is_current = now.is_none_or(|now| now == file);
                let is_kept = block.found == block.rows && is_current && measured.insert(file.path.clone());
                if is_kept && now.is_some() {
                    wanted_there.push((block.rows, block.completion));
                }
                is_kept
            })
        };
        let kept: Vec<bool> = blocks.iter().map(is_kept).collect();
        if blocks.is_empty() || kept.contains(&false) {
            keep(path, form, &blocks, &kept)?;
        }
        let file = OpenOptions::new().append(true).open(path);
        let file = file.with_context(|| format!("cannot write {}", path.display()))?;
        Ok(Self { path: path.to_owned(), form, file, measured, kept: wanted_there })
    }

    /// The worst outcome of the wanted captures whose rows are kept.
    pub(super) fn completion(&self) -> Completion {
        self.kept.iter().map(|(_, completion)| *completion).max().unwrap_or(Completion::Complete)
    }

    /// What is kept of the wanted captures.
    pub(super) fn kept_in_words(&self) -> String {
        let rows = self.kept.iter().map(|(rows, _)| *rows as u64).sum();
        let failed = self.kept.iter().filter(|(_, completion)| *completion != Completion::Complete).count();
        let end = if failed == 0 { String::new() } else { format!("; {failed} of them did not succeed") };
        format!("{} kept of {}{end}", counted(rows, "row"), counted(self.kept.len() as u64, "file"))
    }

    pub(super) fn holds(&self, path: &str) -> bool {
        self.measured.contains(path)
    }

    /// Adds the rows of a capture, in one write.
    pub(super) fn add(&mut self, rows: &[ArchiveRow]) -> Result<()> {
        let written = self.file.write_all(self.form.text(rows).as_bytes());
        written.with_context(|| format!("cannot write {}", self.path.display()))
    }
}

/// The rows in a file by their captures.
fn blocks(path: &Path, form: RowForm) -> Result<Vec<Block>> {
    let mut blocks: Vec<Block> = Vec::new();
    for (number, line) in lines(path)?.enumerate() {
        let line = line?;
        if number == 0 && line == form.header() {
            continue;
        }
        let is_whole = line.ends_with('\n');
        match ArchiveRow::file_of_line(&line).filter(|_| is_whole) {
            Some((file, rows, completion)) => match blocks.last_mut() {
                Some(last) if last.file.as_ref() == Some(&file) && last.found < last.rows => {
                    last.found += 1;
                    last.completion = last.completion.max(completion);
                }
                _ => blocks.push(Block { file: Some(file), rows, found: 1, completion }),
            },
            None if !is_whole && number > 0 => {
                blocks.push(Block { file: None, rows: 1, found: 1, completion: Completion::Complete });
            }
            None => {
                let (number, path) = (number + 1, path.display());
                bail!("line {number} of {path} is no row of an archive: give another name for the rows")
            }
        }
    }
    Ok(blocks)
}

/// Writes the file anew with the rows that are kept: whole or not at all.
fn keep(path: &Path, form: RowForm, blocks: &[Block], kept: &[bool]) -> Result<()> {
    let mut partial = path.to_owned().into_os_string();
    partial.push(".partial");
    let partial = PathBuf::from(partial);
    let write = || -> Result<()> {
        let mut file = BufWriter::new(File::create(&partial)?);
        file.write_all(form.header().as_bytes())?;
        if !blocks.is_empty() {
            let mut rows = lines(path)?.skip(usize::from(form == RowForm::Table));
            for (block, is_kept) in blocks.iter().zip(kept) {
                for line in rows.by_ref().take(block.found) {
                    let line = line?;
                    file.write_all(if *is_kept { line.as_bytes() } else { b"" })?;
                }
            }
        }
        file.flush()?;
        Ok(fs::rename(&partial, path)?)
    };
    write().with_context(|| format!("cannot write {}", path.display()))
}

/// The lines of a file with their ends, one at a time.
fn lines(path: &Path) -> Result<impl Iterator<Item = Result<String>>> {
    let file = File::open(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut reader = BufReader::new(file);
    let name = path.display().to_string();
    Ok(std::iter::from_fn(move || {
        let mut line = String::new();
        match reader.read_line(&mut line).with_context(|| format!("cannot read {name}")) {
            Ok(0) => None,
            Ok(_) => Some(Ok(line)),
            Err(error) => Some(Err(error)),
        }
    }))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vn100_analysis::{Analysis, Assessment, Parts, Settings, SourceFacts, SourceResult};

    use super::*;

    fn unread() -> SourceResult {
        let nothing = Arc::new(Analysis::new(Settings::default()).snapshot());
        let assessment = Arc::new(Assessment::new(&nothing, 0.95));
        SourceResult::new(SourceFacts::default(), nothing, assessment, Parts::WithoutSignals)
    }

    fn file(path: &str, bytes: u64) -> ArchivedFile {
        ArchivedFile { path: path.into(), bytes, modified_ns: 5, options: "a".into() }
    }

    #[test]
    fn whole_rows_of_captures_as_they_are_stay() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["rows.jsonl", "rows.csv"] {
            let path = folder.path().join(name);
            let wanted: BTreeMap<_, _> =
                ["a", "b", "c"].into_iter().map(|name| (name.to_owned(), file(name, 1))).collect();
            let mut rows = RowsFile::open(&path, &wanted).unwrap();
            for (name, bytes) in [("a", 1), ("b", 2), ("other", 9), ("c", 1)] {
                rows.add(&ArchiveRow::of_file(&file(name, bytes), &[unread()])).unwrap();
            }
            drop(rows);
            let text = fs::read_to_string(&path).unwrap();
            // the last row was cut
            fs::write(&path, &text[..text.len() - 5]).unwrap();
            let rows = RowsFile::open(&path, &wanted).unwrap();
            assert_eq!(["a", "b", "other", "c"].map(|name| rows.holds(name)), [true, false, true, false], "{name}");
            let kept = fs::read_to_string(&path).unwrap();
            assert_eq!(kept.lines().count(), 2 + usize::from(name == "rows.csv"), "{kept}");
            fs::write(&path, "nothing\nof an archive\n").unwrap();
            assert!(RowsFile::open(&path, &wanted).is_err_and(|error| error.to_string().contains("line 1")));
        }
    }
}
