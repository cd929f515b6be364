//! `vn100 ports`: the serial ports of this machine, the likely ones first.

use std::{fmt::Write, path::Path};

use anyhow::Result;
use vn100_analysis::Completion;
use vn100_driver::{PortEntry, available_ports, list_ports, other_program_on};
use vn100_report::printable;

use crate::exit::print;

pub(crate) fn ports() -> Result<Completion> {
    let ports: Vec<_> = list_ports().into_iter().map(|port| (other_program_on(Path::new(&port.name)), port)).collect();
    print(&listing(&ports))?;
    Ok(Completion::Complete)
}

/// A table of the ports, each with the program that has it open if the system shows one; or what to do
/// if there is nothing to list.
fn listing(ports: &[(Option<String>, PortEntry)]) -> String {
    if ports.is_empty() {
        return "no serial port is available: plug in the USB cable of the sensor; in a container, pass the device through\n"
            .into();
    }
    let width = ports.iter().map(|(_, port)| port.name.len()).max().unwrap_or_default();
    let mut out = String::new();
    for (held_by, port) in ports {
        let mark = if port.likely { '*' } else { ' ' };
        let usb = port.usb.as_ref().map_or("not USB".into(), |usb| {
            let names = [&usb.manufacturer, &usb.product, &usb.serial_number];
            let names: Vec<_> = names.into_iter().flatten().map(String::as_str).collect();
            format!("{:04x}:{:04x} {}", usb.vid, usb.pid, names.join(" "))
        });
        // a String takes everything
        let _ = writeln!(out, "{mark} {:width$}  {}", printable(&port.name), printable(usb.trim_end()));
        if let Some(stable) = &port.stable_name {
            let _ = writeln!(out, "  {:width$}  also {}", "", printable(&stable.to_string_lossy()));
        }
        if let Some(program) = held_by {
            let _ = writeln!(out, "  {:width$}  in use by {}", "", printable(program));
        }
    }
    if ports.iter().any(|(_, port)| port.likely) {
        out.push_str("* likely a VN-100; vn100 info PORT identifies it\n");
    }
    out
}

/// The port a VN-100 is on, as far as one can be named; otherwise the available ports.
pub(crate) fn only_likely(ports: &[PortEntry]) -> Result<String, String> {
    let likely: Vec<&PortEntry> = ports.iter().filter(|port| port.likely).collect();
    if let [only] = &*likely {
        return Ok(only.name.clone());
    }
    let available = available_ports(ports);
    let why = if likely.is_empty() { "no port is a likely VN-100" } else { "several ports are likely VN-100s" };
    Err(format!("no SOURCE given, and {why}; {available}; `vn100 attach sim` measures an emulated sensor"))
}

#[cfg(test)]
mod tests {
    use vn100_driver::UsbPortInfo;

    use super::*;

    #[test]
    fn likely_ports_are_marked() {
        let usb = UsbPortInfo {
            vid: 0x0403,
            pid: 0x6001,
            serial_number: Some("A1".into()),
            manufacturer: Some("FTDI\x1b[2J".into()),
            product: None,
        };
        let likely = PortEntry {
            name: "/dev/ttyUSB0".into(),
            stable_name: Some("/dev/serial/by-id/usb-FTDI_A1".into()),
            usb: Some(usb),
            likely: true,
        };
        let other = PortEntry { name: "/dev/ttyS0".into(), stable_name: None, usb: None, likely: false };
        assert_eq!(
            listing(&[(Some("screen (process 71)".into()), likely), (None, other)]),
            "* /dev/ttyUSB0  0403:6001 FTDI\u{fffd}[2J A1\n                also /dev/serial/by-id/usb-FTDI_A1\n\u{20}               in use by screen (process 71)\n  /dev/ttyS0    not USB\n\
             * likely a VN-100; vn100 info PORT identifies it\n"
        );
    }

    #[test]
    fn the_only_likely_port_is_taken_and_others_are_listed() {
        let port = |name: &str, likely| PortEntry { name: name.into(), stable_name: None, usb: None, likely };
        let [one, other] = [port("/dev/ttyUSB0", true), port("/dev/ttyS0", false)];
        assert_eq!(only_likely(&[one.clone(), other.clone()]), Ok("/dev/ttyUSB0".into()));
        let refused = |ports: &[PortEntry]| only_likely(ports).unwrap_err();
        assert!(refused(&[]).contains("no serial port is available"));
        assert!(refused(std::slice::from_ref(&other)).contains("available ports: /dev/ttyS0;"));
        let two = refused(&[one, port("/dev/ttyUSB1", true)]);
        assert!(two.contains("available ports: /dev/ttyUSB0 (likely), /dev/ttyUSB1 (likely);"), "{two}");
    }

    #[test]
    fn without_a_port_the_text_says_what_to_do() {
        assert!(listing(&[]).contains("plug"));
    }
}
