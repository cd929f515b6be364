//! An emulated sensor for the tests of the whole program.

use std::{
    path::{Path, PathBuf},
    process::{Child, Command, Output, Stdio},
};

use tempfile::TempDir;

use crate::support::{Lines, run, vn100};

/// An emulated sensor in a process of its own, with a constant name.
pub(crate) struct Sensor {
    process: Child,
    folder: TempDir,
}

impl Sensor {
    pub(crate) fn start(options: &[&str]) -> Self {
        // it is ended when it is dropped
        Self::start_for("1h", options)
    }

    /// Starts a sensor that ends after this duration.
    pub(crate) fn start_for(duration: &str, options: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("sensor");
        let mut process = vn100()
            .args(["sim", "--duration", duration, "--link"])
            .arg(&link)
            .args(options)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // it prints its name when the port exists
        let name = Lines::of(process.stdout.take().unwrap()).next().unwrap();
        assert_eq!(Path::new(&name), link);
        Self { process, folder }
    }

    pub(crate) fn port(&self) -> PathBuf {
        self.folder.path().join("sensor")
    }

    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn command(&self, command: &str, options: &[&str]) -> Command {
        let mut vn100 = vn100();
        vn100.arg(command).arg(self.port()).args(options).stdin(Stdio::null());
        vn100
    }

    pub(crate) fn run(&self, command: &str, options: &[&str]) -> Output {
        run(&mut self.command(command, options))
    }
}

impl Drop for Sensor {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
