//! A symbolic link that leads to the port of the moment.

use std::{
    ffi::OsString,
    fs,
    os::unix::fs::symlink,
    path::{Path, PathBuf},
};

use super::PtyError;

/// Removed when it is dropped.
#[derive(Debug)]
pub(super) struct Link {
    path: PathBuf,
}

impl Link {
    /// Makes the link, or turns the one that is there.
    pub(super) fn make(path: &Path, target: &Path) -> Result<Self, PtyError> {
        // where it leads somewhere, another sensor may be reached by it
        if fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink())
            && let Ok(leads_to) = fs::canonicalize(path)
        {
            return Err(PtyError::LinkInUse { path: path.to_owned(), leads_to });
        }
        lead(path, target)?;
        Ok(Self { path: path.to_owned() })
    }

    /// Leads elsewhere from here on. A program that opens the path meanwhile finds the one or the
    /// other target.
    pub(super) fn turn(&self, target: &Path) -> Result<(), PtyError> {
        lead(&self.path, target)
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        // a link that another program has removed is gone as well
        _ = fs::remove_file(&self.path);
    }
}

fn lead(path: &Path, target: &Path) -> Result<(), PtyError> {
    if fs::symlink_metadata(path).is_ok_and(|found| !found.is_symlink()) {
        return Err(PtyError::LinkTaken { path: path.to_owned() });
    }
    let fresh = with_suffix(path, &format!(".{}", std::process::id()));
    let turned = symlink(target, &fresh).and_then(|()| fs::rename(&fresh, path));
    turned.map_err(|source| PtyError::Link { path: path.to_owned(), source })
}

/// The same path with more text at its end.
pub(super) fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut text = OsString::from(path);
    text.push(suffix);
    PathBuf::from(text)
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;

    #[test]
    fn a_link_turns_and_goes() -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("sensor");
        let link = Link::make(&path, Path::new("one")).unwrap();
        assert_eq!(fs::read_link(&path)?, Path::new("one"));
        link.turn(Path::new("other")).unwrap();
        assert_eq!(fs::read_link(&path)?, Path::new("other"));
        drop(link);
        assert_eq!(fs::read_dir(folder.path())?.count(), 0);
        Ok(())
    }

    #[test]
    fn a_link_left_behind_is_turned_and_a_file_is_not() -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("sensor");
        symlink("dead", &path)?;
        drop(Link::make(&path, Path::new("one")).unwrap());
        fs::write(&path, "precious")?;
        let error = Link::make(&path, Path::new("one")).unwrap_err().to_string();
        assert!(
            error
                .ends_with("sensor exists and is not a symbolic link: remove it, or choose another place for the link")
        );
        assert_eq!(fs::read_to_string(&path)?, "precious");
        Ok(())
    }

    #[test]
    fn a_link_that_leads_somewhere_is_not_taken_away() -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        let (path, port) = (folder.path().join("sensor"), folder.path().join("port"));
        fs::write(&port, "")?;
        let link = Link::make(&path, &port).unwrap();
        let error = Link::make(&path, Path::new("other")).unwrap_err();
        assert!(matches!(error, PtyError::LinkInUse { .. }), "{error}");
        assert_eq!(fs::read_link(&path)?, port);
        drop(link);
        Ok(())
    }

    #[test]
    fn a_link_into_nowhere_names_its_path() {
        let error = Link::make(Path::new("/nowhere/sensor"), Path::new("one")).unwrap_err().to_string();
        assert!(error.starts_with("cannot make the link /nowhere/sensor to"), "{error}");
    }
}
