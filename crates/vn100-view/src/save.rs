//! What is measured of a source, written to files in a folder: the document that the
//! result would be if it ended now, and the plot that is shown. What only the end of a source
//! shows, such as why it ended, is not in it.

use std::{
    fs::OpenOptions,
    io::{self, Write},
    path::Path,
};

use crate::{source::SourceView, state::ViewState};
use vn100_report::remedies::remedy_words;
use vn100_report::{
    Document, Evaluation,
    figure::{Figure, deviations},
    json_line,
};

/// Writes both into this folder; gives the message. The document is assessed anew: the intervals shown
/// may be those of a record a twentieth shorter.
pub(crate) fn save(folder: &Path, state: &ViewState, source: &SourceView, evaluation: &Evaluation) -> String {
    let result = evaluation.complete(source.result.exact());
    let document = Document::new(&result, remedy_words);
    let stem = stem(source);
    let write = || -> io::Result<String> {
        let json = new_file(folder, &stem, "json", &json_line(&serde_json::to_string(&document)?))?;
        let Some(figure) = picture(state, source) else { return Ok(json) };
        Ok(format!("{json} and {}", new_file(folder, &stem, "svg", &figure.svg_file())?))
    };
    write().map_or_else(|error| format!("not saved: {error}"), |files| format!("saved {files}"))
}

/// The curves that are shown; `None` while there are none.
pub(super) fn picture(state: &ViewState, source: &SourceView) -> Option<Figure> {
    let group = state.group(source)?;
    deviations(&source.result, &state.shown(source, &group).1)
}

/// A name that says what it holds: source and number of samples.
fn stem(source: &SourceView) -> String {
    let name: String = source.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    format!("vn100-{}-{}", name.trim_matches('-'), source.result.timing.samples)
}

/// Never overwrites a file: the name gets a number.
fn new_file(folder: &Path, stem: &str, extension: &str, text: &str) -> io::Result<String> {
    const MOST_NEIGHBOURS: u32 = 1000;
    for number in 1..MOST_NEIGHBOURS {
        let name = if number == 1 { format!("{stem}.{extension}") } else { format!("{stem}-{number}.{extension}") };
        match OpenOptions::new().write(true).create_new(true).open(folder.join(&name)) {
            Ok(mut file) => {
                file.write_all(text.as_bytes())?;
                return Ok(name);
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::new(io::ErrorKind::AlreadyExists, format!("{stem}.{extension} and its neighbours exist")))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use tempfile::TempDir;

    use super::*;
    use crate::tests::fixture::measured;

    /// Each save has files of its own, and one that cannot be written is said.
    #[test]
    fn what_is_shown_is_saved_beside_other_files() {
        let folder = TempDir::new().unwrap();
        let source = measured();
        let evaluation = Evaluation::new(None, Vec::new(), false).unwrap();
        let save_in = |folder: &Path| save(folder, &ViewState::new(1), &source, &evaluation);
        let stem = stem(&source);
        fs::write(folder.path().join(format!("{stem}.svg")), "mine").unwrap();
        assert_eq!(save_in(folder.path()), format!("saved {stem}.json and {stem}-2.svg"));
        assert_eq!(save_in(folder.path()), format!("saved {stem}-2.json and {stem}-3.svg"));
        let read = |name: String| fs::read_to_string(folder.path().join(name)).unwrap();
        assert_eq!(read(format!("{stem}.svg")), "mine");
        assert!(read(format!("{stem}-2.svg")).contains("<svg "));
        let document: serde_json::Value = serde_json::from_str(&read(format!("{stem}.json"))).unwrap();
        assert_eq!(document["timing"]["samples"], source.result.timing.samples);
        assert_eq!(read(format!("{stem}.json")), read(format!("{stem}-2.json")));
        assert!(save_in(&folder.path().join("absent")).starts_with("not saved: "));
    }

    #[test]
    fn a_file_is_named_after_source_and_samples() {
        for (name, expected) in [
            ("/dev/ttyUSB0", "vn100-dev-ttyUSB0-20000"),
            ("tcp://bench.local:4000", "vn100-tcp---bench-local-4000-20000"),
            ("log 7 (b).csv", "vn100-log-7--b--csv-20000"),
        ] {
            assert_eq!(stem(&SourceView { name: name.into(), ..measured() }), expected);
        }
    }
}
