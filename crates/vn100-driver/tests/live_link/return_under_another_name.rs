//! An adapter that is unplugged and returns under another name, on pseudo-terminals: the link
//! follows it, and opens no other adapter.

use std::{
    fs,
    io::Write,
    os::unix::fs::symlink,
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
    time::Duration,
};

use crate::support::LINE;
use serialport::{SerialPort, TTYPort};
use tokio::{sync::watch, time::interval};
use tokio_util::sync::CancellationToken;
use vn100_capture::Clock;
use vn100_driver::{LinkOptions, LinkState, PortEntry, SerialPorts, UsbPortInfo, open_link};

/// A machine with USB sockets.
#[derive(Clone, Default)]
struct Machine(Arc<Mutex<Vec<PortEntry>>>);

impl Machine {
    fn list(&self) -> Vec<PortEntry> {
        self.0.lock().unwrap().clone()
    }

    fn pull_all_out(&self) {
        self.0.lock().unwrap().clear();
    }

    /// The sensor's end of the port of an adapter with that number, and the name of the port.
    fn plug_in(&self, adapter_number: &str) -> (TTYPort, String) {
        let (sensor, ours) = TTYPort::pair().unwrap();
        let name = ours.name().unwrap();
        let usb = UsbPortInfo {
            vid: 0x0403,
            pid: 0x6001,
            serial_number: Some(adapter_number.into()),
            manufacturer: None,
            product: None,
        };
        let entry = PortEntry { name: name.clone(), stable_name: None, usb: Some(usb), likely: true };
        self.0.lock().unwrap().push(entry);
        (sensor, name)
    }
}

/// Makes a name refer to a port, in place of its former target.
fn lead(name: &Path, port: &str) {
    let fresh = name.with_extension("new");
    symlink(port, &fresh).unwrap();
    fs::rename(fresh, name).unwrap();
}

/// Sends lines on all ports until the link is up; returns the name that was used.
async fn up(state: &mut watch::Receiver<LinkState>, sensors: &mut [&mut TTYPort]) -> String {
    let mut lines = interval(Duration::from_millis(10));
    loop {
        tokio::select! {
            found = state.wait_for(|state| matches!(state, LinkState::Up(_))) => {
                let LinkState::Up(up) = found.unwrap().clone() else { continue };
                return up.port;
            }
            // a port that is not opened is not read, and becomes full
            _ = lines.tick() => sensors.iter_mut().for_each(|sensor| drop(sensor.write(LINE.as_bytes()))),
        }
    }
}

/// The reason why the link is not opened again.
async fn refusal(state: &mut watch::Receiver<LinkState>) -> String {
    let refused =
        |state: &LinkState| matches!(state, LinkState::Down { cause, .. } if cause.starts_with("cannot open"));
    let state = state.wait_for(refused).await.unwrap().clone();
    let LinkState::Down { cause, .. } = state else { return String::new() };
    cause
}

/// The machine, with a link by `name` that is up on a port of adapter A1; the sensor's end of it,
/// and the name of the port.
async fn attached(name: &Path) -> (Machine, watch::Receiver<LinkState>, TTYPort, String) {
    let machine = Machine::default();
    let (mut sensor, port) = machine.plug_in("A1");
    lead(name, &port);
    let list = machine.clone();
    let ports = SerialPorts::among(name.to_str().unwrap(), Clock::start(), move || list.list());
    let options = LinkOptions { baud: Some(115_200), ..LinkOptions::default() };
    let (link, mut events) = open_link(ports, options, CancellationToken::new());
    tokio::spawn(async move { while events.recv().await.is_some() {} });
    let mut state = link.state();
    assert_eq!(Path::new(&up(&mut state, &mut [&mut sensor]).await), name);
    (machine, state, sensor, port)
}

fn named(folder: &tempfile::TempDir, name: &str) -> PathBuf {
    folder.path().join(name)
}

#[tokio::test]
async fn an_adapter_is_followed_to_another_name_and_no_other_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    let name = named(&folder, "ttyUSB0");
    let (machine, mut state, sensor, _) = attached(&name).await;
    machine.pull_all_out();
    fs::remove_file(&name).unwrap();
    drop(sensor);
    let told = refusal(&mut state).await;
    assert!(
        told.starts_with(&format!("cannot open {} at 115200 baud: there is no such port", name.display())),
        "{told}"
    );

    // its name now belongs to another port, on which a sensor sends as well
    let (mut other_sensor, other) = machine.plug_in("B2");
    lead(&name, &other);
    let is_news = |state: &LinkState| matches!(state, LinkState::Down { cause, .. } if *cause != told);
    let told = state.wait_for(is_news).await.unwrap().clone();
    let expected = format!("cannot open {} at 115200 baud: another adapter has that name now", name.display());
    assert!(matches!(&told, LinkState::Down { cause, .. } if cause.starts_with(&expected)), "{told:?}");

    let (mut sensor, port) = machine.plug_in("A1");
    assert_eq!(up(&mut state, &mut [&mut other_sensor, &mut sensor]).await, port);
    assert_eq!(other_sensor.bytes_to_read().unwrap(), 0, "the other adapter was asked");
}

#[tokio::test]
async fn a_name_that_follows_the_adapter_leads_to_its_new_port() {
    let folder = tempfile::tempdir().unwrap();
    let name = named(&folder, "usb-FTDI_A1-if00-port0");
    let (machine, mut state, sensor, before) = attached(&name).await;
    machine.pull_all_out();
    fs::remove_file(&name).unwrap();
    // another adapter is in that socket first
    let (mut other_sensor, _other) = machine.plug_in("B2");
    let (mut fresh, port) = machine.plug_in("A1");
    assert_ne!(port, before);
    lead(&name, &port);
    drop(sensor);
    state.wait_for(|state| matches!(state, LinkState::Down { .. })).await.unwrap();
    assert_eq!(Path::new(&up(&mut state, &mut [&mut other_sensor, &mut fresh]).await), name);
}

#[tokio::test]
async fn a_port_that_exists_and_cannot_be_opened_is_reported_before_a_name_that_leads_nowhere() {
    let folder = tempfile::tempdir().unwrap();
    let name = named(&folder, "ttyUSB0");
    let (machine, mut state, sensor, _) = attached(&name).await;
    machine.pull_all_out();
    fs::remove_file(&name).unwrap();
    let (_sensor, port) = machine.plug_in("A1");
    // another program has it first
    let _user = serialport::new(&port, 115_200).open().unwrap();
    drop(sensor);
    let told = refusal(&mut state).await;
    let expected = format!("cannot open {} as {port} at 115200 baud: it is in use", name.display());
    assert!(told.starts_with(&expected), "{told}");
}
