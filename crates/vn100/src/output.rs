//! Writes files that did not exist, or replaces whole ones if that was asked for. Never writes
//! through a link.

use std::{
    fs::{self, File, OpenOptions},
    io::{BufWriter, ErrorKind, Write},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};

use crate::args::is_page;

#[derive(Debug, Clone)]
pub(crate) struct Output {
    /// The folder and the beginning of every name.
    stem: PathBuf,
    /// The page's own name; `None` if no page is wanted.
    page: Option<PathBuf>,
    force: bool,
}

impl Output {
    /// A name in `.html` is that of a page; any name without it begins those of what is exported.
    pub(crate) fn new(path: &Path, force: bool) -> Self {
        let is_page = is_page(path);
        let stem = if is_page { path.with_extension("") } else { path.to_owned() };
        Self { stem, page: is_page.then(|| path.to_owned()), force }
    }

    pub(crate) fn page(&self) -> Option<&Path> {
        self.page.as_deref()
    }

    pub(crate) fn beside(&self, ending: &str) -> PathBuf {
        let mut name = self.stem.clone().into_os_string();
        name.push(ending);
        name.into()
    }

    /// Fails early: before a long measurement, and before anything is written.
    pub(crate) fn check(&self, path: &Path, inputs: &[PathBuf]) -> Result<()> {
        match fs::symlink_metadata(path) {
            Ok(found) if found.is_dir() => bail!("{} is a folder: give another name", path.display()),
            Ok(found) if !found.is_file() && !found.is_symlink() => {
                bail!("{} is not a regular file, and nothing else is replaced: give another name", path.display())
            }
            _ => self.check_place(path, inputs),
        }
    }

    /// The same for a file that no option replaces.
    pub(crate) fn check_new(path: &Path) -> Result<()> {
        if fs::symlink_metadata(path).is_ok() {
            bail!("{} exists and is not replaced: give another name", path.display());
        }
        Self::new(path, false).check_place(path, &[])
    }

    /// The same for a folder of many files.
    pub(crate) fn check_folder(&self, path: &Path, inputs: &[PathBuf]) -> Result<()> {
        if self.force && fs::symlink_metadata(path).is_ok() && !is_folder(path) {
            bail!("{} is no folder for the figures: give another name", path.display());
        }
        self.check_place(path, inputs)
    }

    fn check_place(&self, path: &Path, inputs: &[PathBuf]) -> Result<()> {
        let same = |input: &PathBuf| {
            fs::canonicalize(input).ok().zip(fs::canonicalize(path).ok()).is_some_and(|(a, b)| a == b)
        };
        if inputs.iter().any(same) {
            bail!("{} is one of the captures: give another name", path.display());
        }
        if !self.force && fs::symlink_metadata(path).is_ok() {
            bail!("{} exists: give another name, or --force to replace it", path.display());
        }
        let folder = folder(path);
        if !folder.is_dir() {
            bail!("there is no folder {}: create it, or give another name", folder.display());
        }
        Ok(())
    }

    /// Writes a file by `content`, whole or not at all.
    pub(crate) fn write(&self, path: &Path, content: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
        if !self.force {
            return create(path, content);
        }
        // renamed into place: whole or not at all, and a link is replaced instead of followed
        let mut partial = tempfile::Builder::new();
        #[cfg(unix)]
        partial.permissions(readable_as_usual());
        let partial = partial.suffix(".partial").tempfile_in(folder(path));
        let partial = partial.with_context(|| format!("cannot write {}", path.display()))?;
        let mut file = BufWriter::new(partial.as_file().try_clone()?);
        let written = content(&mut file).and_then(|()| Ok(file.flush()?));
        written.with_context(|| format!("cannot write {}", path.display()))?;
        partial.persist(path).with_context(|| format!("cannot replace {}", path.display()))?;
        Ok(())
    }

    pub(crate) fn make_folder(&self, path: &Path) -> Result<()> {
        match fs::create_dir(path) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists && self.force && is_folder(path) => Ok(()),
            made => made.with_context(|| format!("cannot create the folder {}", path.display())),
        }
    }
}

/// Those of any new file, less what the user's mask takes away.
#[cfg(unix)]
fn readable_as_usual() -> fs::Permissions {
    std::os::unix::fs::PermissionsExt::from_mode(0o666)
}

fn is_folder(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_dir())
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn create(path: &Path, content: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    let file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(path)
        .with_context(|| format!("cannot write {}", path.display()))?;
    let mut file = BufWriter::new(file);
    if let Err(error) = content(&mut file).and_then(|()| Ok(file.flush()?)) {
        // half a file looks like a whole one
        let _ = fs::remove_file(path);
        return Err(error).with_context(|| format!("cannot write {}", path.display()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &'static [u8]) -> impl FnOnce(&mut BufWriter<File>) -> Result<()> {
        |file| Ok(file.write_all(bytes)?)
    }

    #[test]
    fn a_page_gives_its_name_to_what_lies_beside() {
        let page = Output::new(Path::new("out/lab.html"), false);
        assert_eq!(page.page(), Some(Path::new("out/lab.html")));
        assert_eq!(page.beside(".json"), Path::new("out/lab.json"));
        let none = Output::new(Path::new("run.2"), false);
        assert_eq!((none.page(), none.beside(".json")), (None, PathBuf::from("run.2.json")));
    }

    #[test]
    fn a_new_file_that_has_no_place_is_refused_with_the_cure() {
        let folder = tempfile::tempdir().unwrap();
        let refused = |name: &str| Output::check_new(&folder.path().join(name)).unwrap_err().to_string();
        assert!(Output::check_new(&folder.path().join("a.csv")).is_ok());
        assert!(refused("none/a.csv").ends_with("none: create it, or give another name"));
        fs::write(folder.path().join("a.csv"), "mine").unwrap();
        for name in ["a.csv", ""] {
            assert!(refused(name).ends_with(" exists and is not replaced: give another name"));
        }
    }

    #[test]
    fn nothing_is_replaced_unless_asked_and_links_are_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("a.html"), folder.path().join("b.html"));
        let careful = Output::new(&file, false);
        careful.write(&file, text(b"first")).unwrap();
        assert!(careful.check(&file, &[]).is_err() && careful.write(&file, text(b"second")).is_err());
        let forced = Output::new(&file, true);
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&file, &link).unwrap();
            assert!(careful.write(&link, text(b"second")).is_err());
            forced.write(&link, text(b"third")).unwrap();
            assert_eq!(fs::read(&link).unwrap(), b"third");
            assert!(!fs::symlink_metadata(&link).unwrap().is_symlink());
        }
        assert_eq!(fs::read(&file).unwrap(), b"first");
        assert!(forced.check(&file, std::slice::from_ref(&file)).is_err(), "not over the capture, whatever is asked");
        forced.write(&file, text(b"fourth")).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"fourth");
        let sub = folder.path().join("c.html");
        fs::create_dir(&sub).unwrap();
        assert!(forced.check(&sub, &[]).is_err() && forced.check_folder(&sub, &[]).is_ok());
        assert!(forced.check_folder(&file, &[]).is_err() && careful.check_folder(&sub, &[]).is_err());
        assert!(forced.write(&sub, text(b"fifth")).is_err() && sub.is_dir());
        let left = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, if cfg!(unix) { 3 } else { 2 }, "what failed leaves nothing");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = |path| fs::metadata(path).unwrap().permissions().mode();
            careful.write(&folder.path().join("d.html"), text(b"sixth")).unwrap();
            assert_eq!(mode(file.clone()), mode(folder.path().join("d.html")), "readable as any file");
        }
    }
}
