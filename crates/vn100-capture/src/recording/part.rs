//! Recordings in several files: parts with the identity of the recording and their number. The
//! joined parts equal one undivided file.

use std::{
    collections::BTreeMap,
    fs,
    hash::{BuildHasher, RandomState},
    io,
    path::{Path, PathBuf},
    time::Duration,
};

use mcap::records::Metadata;

/// The condition under which a recording continues in the next part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rotation {
    /// Once a part holds this many bytes of the stream.
    Bytes(u64),
    /// Once a part holds this much time of the stream.
    Time(Duration),
}

/// The recording and the part that a file is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordingPart {
    /// The identity of the recording, the same in all of its parts.
    pub id: String,
    /// The number of the part, from 1.
    pub number: u32,
    /// Whether the recording was interrupted before this part.
    pub resumed: bool,
}

pub(super) const PART_METADATA: &str = "vn100.part";

/// The end reason of a part that is followed by another.
pub(super) const CONTINUED: &str = "continued in the next part";

impl RecordingPart {
    /// An identity that no other recording has.
    pub(super) fn new_id() -> String {
        // seeded by the system, different each time
        let draw = || RandomState::new().hash_one(std::process::id());
        format!("{:016x}{:016x}", draw(), draw())
    }

    pub(super) fn metadata(&self) -> Metadata {
        let values = BTreeMap::from([("id".into(), self.id.clone()), ("number".into(), self.number.to_string())]);
        Metadata { name: PART_METADATA.into(), metadata: values }
    }

    pub(super) fn from_metadata(values: &BTreeMap<String, String>) -> Option<Self> {
        let number = values.get("number")?.parse().ok().filter(|number| *number > 0)?;
        Some(Self { id: values.get("id")?.clone(), number, resumed: false })
    }
}

/// Groups files: the parts of each recording by their numbers, and each other file alone. A
/// recording has the place of the first of its files. A part that is named twice is a recording of
/// its own.
pub fn joined_parts(files: impl IntoIterator<Item = (PathBuf, Option<RecordingPart>)>) -> Vec<BTreeMap<u32, PathBuf>> {
    let mut groups: Vec<BTreeMap<u32, PathBuf>> = Vec::new();
    let mut places: BTreeMap<String, usize> = BTreeMap::new();
    for (path, part) in files {
        let (id, number) = part.map_or((None, 0), |part| (Some(part.id), part.number));
        let known = id.as_ref().and_then(|id| places.get(id)).map(|place| &mut groups[*place]);
        match known {
            Some(parts) if !parts.contains_key(&number) => _ = parts.insert(number, path),
            Some(_) => groups.push(BTreeMap::from([(number, path)])),
            None => {
                id.into_iter().for_each(|id| _ = places.insert(id, groups.len()));
                groups.push(BTreeMap::from([(number, path)]));
            }
        }
    }
    groups
}

/// The missing parts among these ascending numbers, in words; `None` for a single part, and if the
/// numbers are complete from 1 on.
pub fn missing_parts(numbers: &[u32]) -> Option<String> {
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

/// The path of a part: `night.0001.mcap` for `night.mcap`.
pub fn part_path(recording: &Path, number: u32) -> PathBuf {
    let mut name = recording.file_stem().unwrap_or_default().to_owned();
    name.push(format!(".{number:04}"));
    if let Some(extension) = recording.extension() {
        name.push(".");
        name.push(extension);
    }
    recording.with_file_name(name)
}

/// The path of the recording of a part: `night.mcap` for `night.0001.mcap`; any other name
/// unchanged.
pub fn recording_path(part: &Path) -> PathBuf {
    let Some(stem) = part.file_stem().map(Path::new) else { return part.to_owned() };
    let is_number = |end: &str| end.len() >= 4 && end.bytes().all(|digit| digit.is_ascii_digit());
    match (stem.extension().and_then(|end| end.to_str()).filter(|end| is_number(end)), part.extension()) {
        (Some(_), Some(extension)) => {
            part.with_file_name(stem.with_extension(extension).file_name().unwrap_or_default())
        }
        _ => part.to_owned(),
    }
}

pub(super) fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

pub(super) fn existing_parts(recording: &Path) -> io::Result<BTreeMap<u32, PathBuf>> {
    let mut parts = BTreeMap::new();
    for entry in fs::read_dir(folder_of(recording))? {
        let name = entry?.file_name();
        let path = recording.with_file_name(&name);
        let number = Path::new(&name).file_stem().and_then(|stem| Path::new(stem).extension()?.to_str()?.parse().ok());
        if let Some(number) = number.filter(|number| part_path(recording, *number) == path) {
            parts.insert(number, path);
        }
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_named_by_their_recording_and_number() {
        for (recording, number, part) in [
            ("night.mcap", 1, "night.0001.mcap"),
            ("a/b.c/night.mcap", 12_345, "a/b.c/night.12345.mcap"),
            ("night.1.mcap", 2, "night.1.0002.mcap"),
        ] {
            assert_eq!(part_path(Path::new(recording), number), Path::new(part));
            assert_eq!(recording_path(Path::new(part)), Path::new(recording));
        }
        for other in ["night.mcap", "night.1.mcap", "night", "2024", ""] {
            assert_eq!(recording_path(Path::new(other)), Path::new(other));
        }
        assert_eq!(part_path(Path::new("night"), 3), Path::new("night.0003"));
    }

    #[test]
    fn parts_of_a_recording_are_joined_in_order_from_any_place() {
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
        let joined = joined_parts(files.into_iter().map(|(path, part)| (path.into(), part)));
        let paths: Vec<Vec<_>> =
            joined.iter().map(|parts| parts.values().map(|path| path.to_str().unwrap()).collect()).collect();
        let expected: [&[&str]; 5] = [&["b1", "b2"], &["x"], &["a1", "a3"], &["y"], &["a1 again"]];
        assert_eq!(paths, expected);
    }

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
    fn identities_differ() {
        assert_ne!(RecordingPart::new_id(), RecordingPart::new_id());
        assert_eq!(RecordingPart::new_id().len(), 32);
    }
}
