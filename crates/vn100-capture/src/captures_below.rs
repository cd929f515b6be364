//! The captures below a folder.

use std::{
    fs::{self, DirEntry},
    io,
    path::{Path, PathBuf},
};

use crate::{detect_format::is_capture_ending, unpack::PACKED_ENDINGS};

/// All captures below `path`, sorted by name: files by their endings, and the folders of ROS 2 bags;
/// hidden files and folders are skipped, and pipes and devices. A `path` that is no folder is always
/// in the list. A folder that cannot be listed is in the list as well, so that opening it gives the
/// reason.
pub fn captures_below(path: &Path) -> Vec<PathBuf> {
    let mut captures = Vec::new();
    add(path, true, &mut Vec::new(), &mut captures);
    captures
}

/// Adds the captures at and below `path`. `above` are the folders around it, used to recognise a
/// link to one of them.
fn add(path: &Path, is_named: bool, above: &mut Vec<PathBuf>, captures: &mut Vec<PathBuf>) {
    if path.is_dir() && !path.join("metadata.yaml").exists() {
        let Ok((folder, entries)) = listed(path) else { return captures.push(path.to_owned()) };
        if !above.contains(&folder) {
            above.push(folder);
            entries.iter().for_each(|entry| add(&entry.path(), false, above, captures));
            above.pop();
        }
        return;
    }
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let is_known = |ending: String| is_capture_ending(&ending) || PACKED_ENDINGS.contains(&&*ending);
    // the opening of a pipe waits for its writer, perhaps for ever
    let is_stored = fs::metadata(path).map_or(true, |entry| entry.is_file());
    if is_named || path.is_dir() || is_stored && ending.is_some_and(is_known) {
        captures.push(path.to_owned());
    }
}

fn listed(folder: &Path) -> io::Result<(PathBuf, Vec<DirEntry>)> {
    let is_hidden = |entry: &DirEntry| entry.file_name().as_encoded_bytes().starts_with(b".");
    let entries = fs::read_dir(folder)?.collect::<io::Result<Vec<_>>>()?;
    let mut entries: Vec<_> = entries.into_iter().filter(|entry| !is_hidden(entry)).collect();
    entries.sort_by_key(DirEntry::path);
    Ok((folder.canonicalize()?, entries))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn captures_are_found_by_their_endings_and_bags_as_folders() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        for name in ["b/two.VNYMR", "b/deep/one.csv.gz", "a.bin", "notes.md", ".hidden/x.bin", ".y.bin", "bag/x.db3"] {
            fs::create_dir_all(place(name).parent().unwrap()).unwrap();
            fs::write(place(name), "").unwrap();
        }
        fs::write(place("bag/metadata.yaml"), "").unwrap();
        let found = ["a.bin", "b/deep/one.csv.gz", "b/two.VNYMR", "bag"].map(place);
        assert_eq!(captures_below(folder.path()), found);
        for named in ["notes.md", "none", "bag"] {
            assert_eq!(captures_below(&place(named)), [place(named)]);
        }
        assert_eq!(captures_below(&place("b/deep")), [place("b/deep/one.csv.gz")]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_a_folder_is_followed_unless_it_leads_into_itself() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        fs::create_dir_all(place("in/deep")).unwrap();
        fs::create_dir_all(place("other")).unwrap();
        fs::write(place("other/a.bin"), "").unwrap();
        std::os::unix::fs::symlink(place("in"), place("in/deep/loop")).unwrap();
        std::os::unix::fs::symlink(place("other"), place("in/link")).unwrap();
        assert_eq!(captures_below(&place("in")), [place("in/link/a.bin")]);
    }

    #[cfg(unix)]
    #[test]
    fn only_what_is_stored_is_a_capture_unless_it_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        let _socket = std::os::unix::net::UnixListener::bind(place("live.csv")).unwrap();
        std::os::unix::fs::symlink(place("none"), place("lost.csv")).unwrap();
        assert_eq!(captures_below(folder.path()), [place("lost.csv")]);
        assert_eq!(captures_below(&place("live.csv")), [place("live.csv")]);
    }
}
