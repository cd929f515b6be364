//! The serial ports of this machine: the likely ports of a VN-100, the search for a named port
//! after its adapter was plugged in under another name, and the latency timer of an adapter.

use std::{
    fs,
    path::{Path, PathBuf},
};

use serialport::{SerialPortInfo, SerialPortType, UsbPortInfo};

/// The folder in which udev keeps names that stay the same for an adapter after a change of its
/// socket and after a boot.
const STABLE_NAMES: &str = "/dev/serial/by-id";

/// The USB vendor of the chip in VN-100 cables, and its products: FT232, FT2232-family and FT-X
/// with one channel.
const FTDI: u16 = 0x0403;
const FTDI_PRODUCTS: [u16; 3] = [0x6001, 0x6014, 0x6015];

/// One serial port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortEntry {
    /// The name of the port, such as `/dev/ttyUSB0` or `COM3`.
    pub name: String,
    /// A name that stays the same when the adapter is plugged in again; `None` if the system has
    /// none.
    pub stable_name: Option<PathBuf>,
    /// The description of the USB adapter; `None` for a port that is not on USB.
    pub usb: Option<UsbPortInfo>,
    /// Whether the adapter is of the kind in VN-100 cables.
    pub likely: bool,
}

fn is_likely(usb: &UsbPortInfo) -> bool {
    let says_so = [&usb.manufacturer, &usb.product]
        .into_iter()
        .flatten()
        .any(|name| ["vectornav", "vn-1"].iter().any(|ours| name.to_ascii_lowercase().contains(ours)));
    says_so || usb.vid == FTDI && FTDI_PRODUCTS.contains(&usb.pid)
}

/// Lists the serial ports of this machine: the likely ones first, then by name.
///
/// If the system cannot list ports, the list is empty; a port can still be opened by its name.
pub fn list_ports() -> Vec<PortEntry> {
    // serialport panics in a container without it
    let can_list = !cfg!(target_os = "linux") || Path::new("/sys/class/tty").is_dir();
    let found = if can_list { serialport::available_ports().unwrap_or_default() } else { Vec::new() };
    entries(found, &stable_names(Path::new(STABLE_NAMES)))
}

/// Symlinks in `folder`, each with its target port.
fn stable_names(folder: &Path) -> Vec<(PathBuf, PathBuf)> {
    // a machine without USB serial adapters does not have the folder
    let links = fs::read_dir(folder).into_iter().flatten().flatten();
    let with_port = |link: PathBuf| fs::canonicalize(&link).ok().map(|port| (link, port));
    let mut names: Vec<_> = links.filter_map(|link| with_port(link.path())).collect();
    names.sort();
    names
}

fn entries(found: Vec<SerialPortInfo>, stable_names: &[(PathBuf, PathBuf)]) -> Vec<PortEntry> {
    let mut entries: Vec<_> = found
        .into_iter()
        .map(|SerialPortInfo { port_name: name, port_type }| {
            let stable_name = stable_names.iter().find(|(_, port)| *port == Path::new(&name));
            let usb = if let SerialPortType::UsbPort(usb) = port_type { Some(usb) } else { None };
            let likely = usb.as_ref().is_some_and(is_likely);
            PortEntry { stable_name: stable_name.map(|(link, _)| link.clone()), name, usb, likely }
        })
        .collect();
    // a number at the end of a name sorts by its value: ttyUSB10 comes after ttyUSB9
    entries.sort_by_key(|entry| (!entry.likely, entry.name.len(), entry.name.clone()));
    entries
}

/// A port, with all known ways to find it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct PortAddress {
    /// The name given by the user.
    pub(crate) given: String,
    stable_name: Option<PathBuf>,
    usb: Option<UsbPortInfo>,
}

impl PortAddress {
    pub(crate) fn new(given: &str) -> Self {
        Self { given: given.into(), stable_name: None, usb: None }
    }

    /// Keeps the stable name and the adapter of the port that was just opened.
    pub(crate) fn learn(&mut self, opened: &str, ports: &[PortEntry]) {
        let Some(port) = find(ports, opened) else { return };
        self.stable_name = port.stable_name.clone();
        self.usb = port.usb.clone();
    }

    /// The names to try, the most reliable first: another adapter may have taken the given name.
    pub(crate) fn candidates(&self, ports: &[PortEntry]) -> Vec<String> {
        let stable = self.stable_name.as_ref().map(|name| name.to_string_lossy().into_owned());
        let known =
            stable.into_iter().chain([self.given.clone()]).filter(|name| !self.belongs_to_another_port(name, ports));
        let same_adapter = ports.iter().filter(|port| self.is_same_adapter(port)).map(|port| port.name.clone());
        let mut names: Vec<String> = Vec::new();
        for name in known.chain(same_adapter) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// Compares the serial numbers of the adapters: without them, two adapters of the same kind
    /// cannot be distinguished.
    fn is_same_adapter(&self, port: &PortEntry) -> bool {
        self.usb.as_ref().is_some_and(|usb| usb.serial_number.is_some()) && port.usb == self.usb
    }

    /// Whether `name` now refers to another adapter; `false` for a port that is not on USB, because
    /// it has no known properties that could differ.
    pub(crate) fn belongs_to_another_port(&self, name: &str, ports: &[PortEntry]) -> bool {
        self.usb.is_some() && find(ports, name).is_some_and(|port| port.usb != self.usb)
    }
}

fn find<'a>(ports: &'a [PortEntry], name: &str) -> Option<&'a PortEntry> {
    // the user may have given a symlink
    let device = fs::canonicalize(name).unwrap_or_else(|_| name.into());
    ports.iter().find(|port| Path::new(&port.name) == device)
}

/// The shortest time of a latency timer, in milliseconds.
const SHORTEST_MS: u32 = 1;

/// The latency timer of an FTDI adapter: the longest time that the chip keeps bytes before it sends
/// them to the host. Because of its default of 16 ms, sentences arrive in bursts (FTDI application
/// note AN232B-04).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LatencyTimer {
    /// The present time of the timer, in milliseconds.
    pub ms: u32,
    /// The advice for shortening the time, if this program was not allowed to; `None` if it is at
    /// its shortest.
    pub advice: Option<String>,
}

/// Sets the latency timer of `port`, which may be a symlink, to 1 ms if that is allowed, and
/// returns its state after that. `None` if there is no such timer, as for another adapter,
/// pseudo-terminal or system.
pub(crate) fn shorten_latency(port: &Path) -> Option<LatencyTimer> {
    let device = fs::canonicalize(port).ok()?;
    shorten(Path::new("/sys/bus/usb-serial/devices"), device.file_name()?.as_ref())
}

fn shorten(devices: &Path, device: &Path) -> Option<LatencyTimer> {
    let timer = devices.join(device).join("latency_timer");
    let before = read_ms(&timer)?;
    if before <= SHORTEST_MS {
        return Some(LatencyTimer { ms: before, advice: None });
    }
    // the value that is read next shows whether the write was allowed
    let _ = fs::write(&timer, SHORTEST_MS.to_string());
    let ms = read_ms(&timer)?;
    let advice = (ms > SHORTEST_MS).then(|| advice(&timer, ms));
    Some(LatencyTimer { ms, advice })
}

fn read_ms(timer: &PathBuf) -> Option<u32> {
    fs::read_to_string(timer).ok()?.trim().parse().ok()
}

fn advice(timer: &Path, ms: u32) -> String {
    format!(
        "the adapter buffers bytes for up to {ms} ms; shorten that once with `echo {SHORTEST_MS} | sudo tee {}`, or for good with the udev \
         rule `ACTION==\"add\", SUBSYSTEM==\"usb-serial\", DRIVER==\"ftdi_sio\", ATTR{{latency_timer}}=\"{SHORTEST_MS}\"` in \
         /etc/udev/rules.d/99-vn100.rules",
        timer.display()
    )
}

#[cfg(test)]
mod tests {
    use serialport::UsbPortInfo;

    use super::*;

    fn usb(name: &str, vid: u16, pid: u16, product: &str) -> SerialPortInfo {
        let port = UsbPortInfo { vid, pid, serial_number: None, manufacturer: None, product: Some(product.into()) };
        SerialPortInfo { port_name: name.into(), port_type: SerialPortType::UsbPort(port) }
    }

    #[test]
    fn likely_ports_come_first() {
        let found = vec![
            SerialPortInfo { port_name: "/dev/ttyS0".into(), port_type: SerialPortType::PciPort },
            usb("/dev/ttyUSB10", 0x0403, 0x6001, "FT232R USB UART"),
            usb("/dev/ttyACM0", 0x2341, 0x0043, "Arduino Uno"),
            usb("/dev/ttyUSB9", 0x0403, 0x6015, "FT230X"),
            usb("/dev/ttyUSB1", 0x10c4, 0xea60, "VectorNav VN-100"),
            usb("/dev/ttyUSB2", 0x0403, 0x6011, "Quad RS232-HS"),
        ];
        let entries = entries(found, &[]);
        let order: Vec<_> = entries.iter().map(|entry| (entry.name.as_str(), entry.likely)).collect();
        let expected = [
            ("/dev/ttyUSB1", true),
            ("/dev/ttyUSB9", true),
            ("/dev/ttyUSB10", true),
            ("/dev/ttyS0", false),
            ("/dev/ttyACM0", false),
            ("/dev/ttyUSB2", false),
        ];
        assert_eq!(order, expected);
    }

    #[cfg(unix)]
    #[test]
    fn the_stable_name_is_the_link_that_leads_to_the_port() {
        let folder = tempfile::tempdir().unwrap();
        let folder = fs::canonicalize(folder.path()).unwrap();
        let (port, link) = (folder.join("ttyUSB0"), folder.join("by-id/usb-FTDI_A1-if00-port0"));
        fs::write(&port, "").unwrap();
        fs::create_dir(folder.join("by-id")).unwrap();
        std::os::unix::fs::symlink("../ttyUSB0", &link).unwrap();
        std::os::unix::fs::symlink("../ttyUSB7", folder.join("by-id/usb-gone")).unwrap();

        let name = port.to_str().unwrap();
        let found = vec![usb(name, FTDI, 0x6001, ""), usb("/dev/ttyUSB1", FTDI, 0x6001, "")];
        let entries = entries(found, &stable_names(&folder.join("by-id")));
        let stable = |name: &str| entries.iter().find(|entry| entry.name == name).unwrap().stable_name.clone();
        assert_eq!(stable(name), Some(link));
        assert_eq!(stable("/dev/ttyUSB1"), None);
        assert_eq!(stable_names(Path::new("/nowhere")), []);
    }

    fn port(name: &str, serial_number: Option<&str>) -> PortEntry {
        let usb = UsbPortInfo {
            vid: 0x0403,
            pid: 0x6001,
            serial_number: serial_number.map(Into::into),
            manufacturer: None,
            product: None,
        };
        let stable_name = serial_number.map(|number| format!("/dev/serial/by-id/usb-{number}").into());
        PortEntry { name: name.into(), stable_name, usb: Some(usb), likely: true }
    }

    #[test]
    fn an_adapter_is_followed_to_another_name() {
        let mut address = PortAddress::new("ttyX0");
        assert_eq!(address.candidates(&[]), ["ttyX0"]);
        address.learn("ttyX0", &[port("ttyX0", Some("A1")), port("ttyX1", Some("B2"))]);
        assert_eq!(address.candidates(&[]), ["/dev/serial/by-id/usb-A1", "ttyX0"]);
        let moved = [port("ttyX0", Some("B2")), port("ttyX5", Some("A1"))];
        assert_eq!(address.candidates(&moved), ["/dev/serial/by-id/usb-A1", "ttyX5"], "the old name is another's");
        let is_taken = |ports| address.belongs_to_another_port("ttyX0", ports);
        assert!(is_taken(&moved) && !is_taken(&moved[1..]));
    }

    #[test]
    fn adapters_without_a_number_are_not_guessed() {
        let mut address = PortAddress::new("ttyX0");
        address.learn("ttyX0", &[port("ttyX0", None)]);
        assert_eq!(address.candidates(&[port("ttyX1", None)]), ["ttyX0"]);
    }

    #[test]
    fn a_port_that_is_not_on_usb_keeps_its_name() {
        let mut address = PortAddress::new("/dev/pts/7");
        address.learn("/dev/pts/7", &[port("ttyX0", Some("A1"))]);
        assert_eq!(address.candidates(&[port("ttyX0", Some("A1"))]), ["/dev/pts/7"]);
    }

    fn devices_with(text: &str) -> tempfile::TempDir {
        let devices = tempfile::tempdir().unwrap();
        fs::create_dir(devices.path().join("ttyUSB3")).unwrap();
        fs::write(devices.path().join("ttyUSB3/latency_timer"), text).unwrap();
        devices
    }

    #[test]
    fn the_timer_is_set_to_its_shortest() {
        let devices = devices_with("16\n");
        let timer = shorten(devices.path(), Path::new("ttyUSB3"));
        assert_eq!(timer, Some(LatencyTimer { ms: 1, advice: None }));
        assert_eq!(fs::read_to_string(devices.path().join("ttyUSB3/latency_timer")).unwrap(), "1");
    }

    #[test]
    fn the_command_is_named_if_the_timer_cannot_be_written() {
        let advice = advice(Path::new("/sys/bus/usb-serial/devices/ttyUSB3/latency_timer"), 16);
        assert!(advice.contains("up to 16 ms"));
        assert!(advice.contains("`echo 1 | sudo tee /sys/bus/usb-serial/devices/ttyUSB3/latency_timer`"));
        assert!(advice.contains("ATTR{latency_timer}=\"1\""));
    }

    #[test]
    fn no_timer_no_value() {
        assert_eq!(shorten(devices_with("16").path(), Path::new("ttyUSB4")), None);
        assert_eq!(shorten(devices_with("fast").path(), Path::new("ttyUSB3")), None);
        assert_eq!(shorten_latency(Path::new("/dev/does-not-exist")), None);
    }
}
