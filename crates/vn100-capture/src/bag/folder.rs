//! The folder of a rosbag2: its files in the order of time.

use std::{
    fs,
    path::{Path, PathBuf},
};

use super::files::BagForm;
use crate::open_error::Problem;

/// The longest `metadata.yaml` that is read; files with many topics are shorter.
const METADATA_BYTES: u64 = 64 * 1024 * 1024;

/// The files of the bag: in the order of `metadata.yaml`, else all files of the folder, by the
/// number at the end of their names.
pub(crate) fn files(folder: &Path) -> Result<Vec<PathBuf>, Problem> {
    let metadata = folder.join("metadata.yaml");
    let listed = match fs::metadata(&metadata) {
        Ok(found) if found.len() <= METADATA_BYTES => listed(&String::from_utf8_lossy(&fs::read(&metadata)?)),
        _ => Vec::new(),
    };
    // old versions list paths relative to the parent folder
    let name = |path: &String| Path::new(path).file_name().map(|name| folder.join(name));
    let listed: Vec<_> = listed.iter().filter_map(name).collect();
    let files = if listed.is_empty() { found(folder)? } else { listed };
    if files.is_empty() { Err(not_a_bag()) } else { Ok(files) }
}

/// The error for a folder without files of a bag.
pub(super) fn not_a_bag() -> Problem {
    Problem::new("it is a folder without files of a bag (metadata.yaml, *.db3, *.mcap): name the captures in it")
}

/// The paths under `relative_file_paths:`.
fn listed(metadata: &str) -> Vec<String> {
    let mut lines = metadata.lines().skip_while(|line| !line.trim_start().starts_with("relative_file_paths:"));
    let Some(head) = lines.next() else { return Vec::new() };
    let unquoted = |text: &str| text.trim().trim_matches(['"', '\'']).to_owned();
    if let Some((_, inline)) = head.split_once('[') {
        let inline = inline.split(']').next().unwrap_or_default();
        return inline.split(',').map(unquoted).filter(|path| !path.is_empty()).collect();
    }
    lines.map_while(|line| line.trim_start().strip_prefix("- ")).map(unquoted).collect()
}

fn found(folder: &Path) -> Result<Vec<PathBuf>, Problem> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let unpacked = name.strip_suffix(".zstd").unwrap_or(&name).rsplit_once('.');
        let stem = unpacked.filter(|(_, ending)| BagForm::is_ending(ending));
        if let Some((bag, number)) = stem.map(|(stem, _)| numbered(stem)) {
            files.push((number, bag, name, path));
        }
    }
    files.sort();
    let follow = |pair: &&[(Option<u64>, String, String, PathBuf)]| {
        let next = pair[0].0.and_then(|number| number.checked_add(1));
        pair[0].1 == pair[1].1 && next.is_some() && next == pair[1].0
    };
    if let Some(pair) = files.windows(2).find(|pair| !follow(pair)) {
        let [one, other] = [&pair[0].2, &pair[1].2];
        return Err(Problem::new(format!(
            "it is a folder without metadata.yaml, and {one} and {other} are not parts of one bag (NAME_0, NAME_1 ...): name \
             one of them"
        )));
    }
    Ok(files.into_iter().map(|(.., path)| path).collect())
}

/// The name of the bag and the number of the part: parts are called `NAME_0.db3`, `NAME_1.db3`.
/// Digits of the name are compared as 0, because ROS 1 puts the start time of each part in it.
fn numbered(stem: &str) -> (String, Option<u64>) {
    let part = stem.rsplit_once('_').and_then(|(name, digits)| Some((name, digits.parse().ok()?)));
    let (name, number) = part.map_or((stem, None), |(name, number)| (name, Some(number)));
    (name.replace(|c: char| c.is_ascii_digit(), "0"), number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metadata_lists_the_files() {
        let text = "rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n    - walk_0.db3\n    - \"walk_1.db3\"\n  duration:\n    nanoseconds: 5\n";
        assert_eq!(listed(text), ["walk_0.db3", "walk_1.db3"]);
        assert_eq!(listed("relative_file_paths: [a.mcap, 'b.mcap']\n"), ["a.mcap", "b.mcap"]);
        assert!(listed("").is_empty() && listed("relative_file_paths: []").is_empty());
    }

    #[test]
    fn files_without_metadata_come_by_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        assert!(files(folder.path()).is_err());
        for name in ["b_10.db3", "b_9.db3", "b_8.db3", "notes.txt", "b_8.db3-wal"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let names: Vec<_> =
            files(folder.path()).unwrap().iter().map(|path| path.file_name().unwrap().to_owned()).collect();
        assert_eq!(names, ["b_8.db3", "b_9.db3", "b_10.db3"]);
        fs::write(folder.path().join("c_11.db3"), "").unwrap();
        let error = files(folder.path()).unwrap_err().to_string();
        assert!(error.contains("b_10.db3 and c_11.db3 are not parts of one bag"), "{error}");
    }

    #[test]
    fn recordings_side_by_side_are_not_parts_of_one() {
        let read = |names: &[&str]| {
            let folder = tempfile::tempdir().unwrap();
            names.iter().for_each(|name| fs::write(folder.path().join(name), "").unwrap());
            files(folder.path()).map(|files| files.len()).ok()
        };
        assert_eq!(read(&["static.mcap"]), Some(1));
        assert_eq!(read(&["static.mcap", "walk.mcap"]), None);
        assert_eq!(read(&["lab1.mcap", "lab2.mcap"]), None);
        assert_eq!(read(&["walk.mcap", "walk_0.mcap"]), None);
        assert_eq!(read(&["b_0.db3", "b_0.db3.zstd"]), None);
        // names that rosbag2 gives by default
        assert_eq!(read(&["rosbag2_2026_11_26-10_00_00_0.mcap", "rosbag2_2026_11_26-11_00_00_0.mcap"]), None);
        assert_eq!(read(&["rec_2026_11_26-10_00_12.mcap", "rec_2026_11_26-11_07_47.mcap"]), None);
        assert_eq!(read(&["2026-01-01-10-00-00_0.bag", "2026-01-01-10-05-00_1.bag"]), Some(2));
    }
}
