//! What a command measures of its files: each stream of each, and the parts of a recording as one.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use vn100_capture::{Capture, CaptureOptions, RecordingPart};

use crate::{args::FileArgs, exit::report};

/// A stream of a file.
#[derive(Debug, Clone)]
pub(crate) struct FileStream {
    pub(crate) path: PathBuf,
    pub(crate) options: CaptureOptions,
    /// Whether the file has others, too.
    pub(crate) is_one_of_several: bool,
}

impl FileStream {
    /// Its file, and the parts that follow it.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        std::iter::once(&self.path).chain(&self.options.later_parts).map(PathBuf::as_path)
    }
}

/// The streams of the files, in their order; parts of one recording stand where the first of them
/// is named. Standard input, which cannot be read twice, counts as one stream.
pub(crate) fn inputs(args: &FileArgs) -> Vec<FileStream> {
    let part = |path: &PathBuf| (path != Path::new("-") && !args.separate).then(|| RecordingPart::of(path)).flatten();
    let mut inputs = Vec::new();
    for mut files in joined(args.files.iter().map(|path| (path.clone(), part(path)))) {
        let path = files.remove(0);
        let options = CaptureOptions { columns: args.columns.clone(), topic: args.topic.clone(), later_parts: files };
        let topics = match path == Path::new("-") {
            true => vec![options.topic.clone()],
            false => Capture::streams(&path, &options),
        };
        let is_one_of_several = topics.len() > 1;
        inputs.extend(topics.into_iter().map(|topic| FileStream {
            path: path.clone(),
            options: CaptureOptions { topic, ..options.clone() },
            is_one_of_several,
        }));
    }
    inputs
}

/// The files of a recording by the numbers of their parts; of any other file that alone.
type Parts = BTreeMap<u32, PathBuf>;

/// The files that belong together, each recording's in the order of its parts. A part that is named
/// twice is measured by itself.
fn joined(files: impl Iterator<Item = (PathBuf, Option<RecordingPart>)>) -> Vec<Vec<PathBuf>> {
    let mut groups: Vec<(Option<String>, Parts)> = Vec::new();
    for (path, part) in files {
        let (id, number) = part.map_or((None, 0), |part| (Some(part.id), part.number));
        let known = groups.iter_mut().find(|(known, _)| id.is_some() && *known == id);
        match known {
            Some((_, parts)) if !parts.contains_key(&number) => _ = parts.insert(number, path),
            Some(_) => groups.push((None, Parts::from([(number, path)]))),
            None => groups.push((id, Parts::from([(number, path)]))),
        }
    }
    groups.iter().for_each(|(_, parts)| report_missing(parts));
    groups.into_iter().map(|(_, parts)| parts.into_values().collect()).collect()
}

/// Reports the parts of a recording that are not there; of a part alone it is known which it is.
fn report_missing(parts: &Parts) {
    if let Some((path, text)) = parts.values().next().zip(missing_parts(&parts.keys().copied().collect::<Vec<_>>())) {
        report(&format!("{}: {text}", path.display()));
    }
}

/// What is missing of these parts, in rising order; `None` of one alone, and where they follow each
/// other from the first on.
fn missing_parts(numbers: &[u32]) -> Option<String> {
    let [first, _, ..] = numbers else { return None };
    let begins = (*first > 1).then(|| format!("the record begins with part {first}"));
    let last = numbers.last().unwrap_or(first);
    let missing: Vec<String> =
        (*first..*last).filter(|number| !numbers.contains(number)).map(|number| number.to_string()).collect();
    let lost = match &missing[..] {
        [] => None,
        [number] => Some(format!("part {number} is missing: the link counts as lost meanwhile")),
        numbers => Some(format!("parts {} are missing: the link counts as lost meanwhile", numbers.join(", "))),
    };
    let texts: Vec<String> = begins.into_iter().chain(lost).collect();
    (!texts.is_empty()).then(|| texts.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_parts_are_named_and_those_before_the_first_are_no_loss() {
        for (numbers, text) in [
            (&[1, 2, 3][..], None),
            (&[4], None),
            (&[2, 3], Some("the record begins with part 2")),
            (&[1, 3], Some("part 2 is missing: the link counts as lost meanwhile")),
            (&[1, 3, 5], Some("parts 2, 4 are missing: the link counts as lost meanwhile")),
            (&[2, 4], Some("the record begins with part 2; part 3 is missing: the link counts as lost meanwhile")),
        ] {
            assert_eq!(missing_parts(numbers).as_deref(), text, "{numbers:?}");
        }
    }

    #[test]
    fn parts_of_a_recording_are_joined_in_their_order_wherever_they_stand() {
        let part = |id: &str, number| Some(RecordingPart { id: id.into(), number, resumed: false });
        let files = [
            ("b2", part("b", 2)),
            ("x", None),
            ("a3", part("a", 3)),
            ("y", None),
            ("b1", part("b", 1)),
            ("a1", part("a", 1)),
            ("a1 again", part("a", 1)),
        ];
        let joined = joined(files.into_iter().map(|(path, part)| (path.into(), part)));
        let expected: [&[&str]; 5] = [&["b1", "b2"], &["x"], &["a1", "a3"], &["y"], &["a1 again"]];
        let paths = |files: &[&str]| files.iter().map(PathBuf::from).collect::<Vec<_>>();
        assert_eq!(joined, expected.map(paths));
    }
}
