//! Live sources by their names on the command line; "sim" is an emulated sensor of this program's
//! own, on a port that is found as one with a USB adapter is.

use std::{
    env, fs, io,
    path::{Path, PathBuf},
    process,
    sync::{
        Arc, Weak,
        atomic::{AtomicU32, Ordering},
    },
    time::Duration,
};

use anyhow::Result;
use vn100_capture::Clock;
use vn100_driver::{LinkHint, LinkOptions, PortEntry, SerialPorts, TcpServer, UsbAdapter};
use vn100_pipeline::LiveSource;
use vn100_protocol::stream::ReadOptions;
use vn100_sim::pty::{PtyOptions, PtySensor, serve};

use crate::{
    args::{LinkArgs, SimSensorArgs, SourceName},
    commands::sim,
    log::Entries,
};

/// A source made ready, with the emulated sensor if it is one: that stays on as long as it is kept.
pub(crate) fn live_source(
    name: &SourceName,
    link: &LinkArgs,
    read: ReadOptions,
    log: &Entries,
) -> Result<(LiveSource, Option<EmulatedPort>)> {
    let clock = Clock::start();
    let (mut source, emulated) = match name {
        SourceName::Stdin => (LiveSource::stream(io::stdin()), None),
        SourceName::Tcp(address) => (LiveSource::link(TcpServer::new(address, clock)?), None),
        SourceName::Port(port) => (LiveSource::link(SerialPorts::new(port, clock)), None),
        SourceName::Sim => {
            let emulated = EmulatedPort::start(&link.sim)?;
            (LiveSource::link(emulated.ports(clock)), Some(emulated))
        }
    };
    source.options = LinkOptions {
        baud: link.baud.0,
        listen_only: link.listen_only,
        read: log.asked(read),
        hint_text: Some(link_hint),
        ..LinkOptions::default()
    };
    source.observer = log.observer(&name.to_string());
    Ok((source, emulated))
}

/// A hint of the link in the terms of the command line.
fn link_hint(hint: LinkHint) -> &'static str {
    match hint {
        LinkHint::AskSensor => {
            "its output may be paused, which only a request shows: remove --listen-only, or check the cable and the power of the sensor"
        }
        LinkHint::CheckBaudRate => "check the cable, the power of the sensor and --baud",
        LinkHint::ChoosePort => "\"vn100 ports\" lists the ports, those of a sensor first",
        hint => hint.text(),
    }
}

/// An emulated sensor that a command starts for itself is past its boot of 1.25 s.
const ON_FOR: Duration = Duration::from_secs(2);

/// The sensor is powered until this is dropped.
pub(crate) struct EmulatedPort {
    name: PathBuf,
    sensor: Arc<PtySensor>,
}

impl EmulatedPort {
    /// Starts the sensor that the options describe.
    pub(crate) fn start(args: &SimSensorArgs) -> Result<Self> {
        let name = private_name();
        let options = PtyOptions { link: Some(name.clone()), on_for: ON_FOR, ..sim::pty_options(args) };
        Ok(Self { name, sensor: Arc::new(serve(sim::device(args), options)?) })
    }

    /// The port by its first name; under another one its adapter identifies it.
    pub(crate) fn ports(&self, clock: Clock) -> SerialPorts {
        let name = self.name.to_string_lossy().into_owned();
        let (sensor, adapter_number) = (Arc::downgrade(&self.sensor), name.clone());
        SerialPorts::among(&name, clock, move || plugged_in(&sensor, &adapter_number).into_iter().collect())
    }
}

/// The current port; `None` while the sensor is unplugged.
fn plugged_in(sensor: &Weak<PtySensor>, adapter_number: &str) -> Option<PortEntry> {
    let path = sensor.upgrade()?.path();
    // without a port its name resolves to nothing
    let device = fs::canonicalize(path).ok()?;
    let usb = UsbAdapter {
        vendor_id: 0x0403,
        product_id: 0x6001,
        serial_number: Some(adapter_number.to_owned()),
        manufacturer: None,
        product: Some("emulated adapter".into()),
    };
    Some(PortEntry { name: device.to_string_lossy().into_owned(), stable_name: None, usb: Some(usb), likely: true })
}

/// A name for the port of an emulated sensor of this process.
fn private_name() -> PathBuf {
    static NEXT: AtomicU32 = AtomicU32::new(1);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let name = format!("vn100-sim-{}-{number}", process::id());
    let folder = env::temp_dir();
    // also under the name of a sensor that returned as another port
    [name.clone(), format!("{name}-1")].iter().for_each(|name| remove_left_link(&folder.join(name)));
    folder.join(name)
}

/// Removes a link that an earlier process of this number left when it was killed. What else bears
/// the name is reported when the link is made.
fn remove_left_link(path: &Path) {
    if fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink()) {
        let _ = fs::remove_file(path);
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn of_what_a_killed_process_left_the_link_is_removed_and_a_file_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let (link, file) = (folder.path().join("link"), folder.path().join("file"));
        std::os::unix::fs::symlink("/dev/pts/none", &link).unwrap();
        fs::write(&file, "precious").unwrap();
        [&link, &file, &folder.path().join("nothing")].into_iter().for_each(|path| remove_left_link(path));
        assert!(fs::symlink_metadata(&link).is_err());
        assert_eq!(fs::read_to_string(&file).unwrap(), "precious");
    }
}
