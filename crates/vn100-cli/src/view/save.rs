//! What is shown of a source, written to files in the working folder: the document, and the plot.

use std::{
    fs::OpenOptions,
    io::{self, Write},
    path::{Path, PathBuf},
};

use super::{
    curve::Plot,
    source::{Source, Stage},
    state::State,
    svg,
};
use crate::{document::Document, source_document::Origin};

/// Writes both; what to tell the user.
pub(crate) fn save(state: &State, source: &Source) -> String {
    match write(Path::new("."), state, source) {
        Ok(files) => format!("saved {}", files.map(|file| file.display().to_string()).join(" and ")),
        Err(error) => format!("not saved: {error}"),
    }
}

fn write(folder: &Path, state: &State, source: &Source) -> io::Result<[PathBuf; 2]> {
    let origin = Origin { name: source.name.clone(), kind: source.kind, ..Origin::default() };
    let ended = matches!(source.stage, Stage::Ended(_));
    let document = Document::new(&origin, &source.snapshot, &source.assessment, ended);
    let json = serde_json::to_string_pretty(&document)? + "\n";
    let group = state.group(source);
    let svg = group.map_or_else(String::new, |group| svg::plot(&Plot::new(state, source, &group), source));
    let stem = stem(source);
    Ok([new_file(folder, &stem, "json", &json)?, new_file(folder, &stem, "svg", &svg)?])
}

/// A name that says what it holds: source and number of samples.
fn stem(source: &Source) -> String {
    let name: String = source.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    format!("vn100-{}-{}", name.trim_matches('-'), source.snapshot.timing.samples)
}

/// Never writes over a file: what is there gets a neighbour with a number.
fn new_file(folder: &Path, stem: &str, extension: &str, text: &str) -> io::Result<PathBuf> {
    const MOST_NEIGHBOURS: u32 = 1000;
    for number in 1..MOST_NEIGHBOURS {
        let name = if number == 1 { format!("{stem}.{extension}") } else { format!("{stem}-{number}.{extension}") };
        match OpenOptions::new().write(true).create_new(true).open(folder.join(&name)) {
            Ok(mut file) => {
                file.write_all(text.as_bytes())?;
                return Ok(PathBuf::from(name));
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::new(io::ErrorKind::AlreadyExists, format!("{stem}.{extension} and its neighbours exist")))
}
