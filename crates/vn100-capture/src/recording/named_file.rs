//! A file that is worth writing as long as it has a name.

use std::{
    fs::{File, TryLockError},
    io::{self, Write},
};

/// Writes to a file, and fails to [`flush`](Write::flush) after its last name was removed: what is
/// written then is gone with the program. Elsewhere than on Unix an open file cannot be removed.
#[derive(Debug)]
pub(super) struct NamedFile(pub(super) File);

impl NamedFile {
    /// Claims a file for this program alone, as long as it is open; `false` where another one
    /// writes it.
    pub(super) fn claim(file: &File) -> bool {
        // a file system without locks lets everybody in
        !matches!(file.try_lock(), Err(TryLockError::WouldBlock))
    }

    pub(super) fn sync_all(&self) -> io::Result<()> {
        self.0.sync_all()
    }
}

impl Write for NamedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()?;
        match has_name(&self.0)? {
            true => Ok(()),
            false => Err(io::Error::new(io::ErrorKind::NotFound, "the file was removed while it was written")),
        }
    }
}

#[cfg(unix)]
fn has_name(file: &File) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    Ok(file.metadata()?.nlink() > 0)
}

#[cfg(not(unix))]
fn has_name(_file: &File) -> io::Result<bool> {
    Ok(true)
}
