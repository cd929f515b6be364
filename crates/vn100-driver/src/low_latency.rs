//! The latency timer of FTDI adapters: how long the chip may keep bytes before it hands them on.
//!
//! Its default of 16 ms is why lines arrive in bunches (FTDI application note AN232B-04).

use std::{
    fs,
    path::{Path, PathBuf},
};

/// The shortest the timer can be, in milliseconds.
const SHORTEST_MS: u32 = 1;

/// What the latency timer of an adapter says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LatencyTimer {
    /// Its time in milliseconds, as it is now.
    pub ms: u32,
    /// How to shorten it, where this program was not allowed to; `None` where there is nothing left
    /// to shorten.
    pub advice: Option<String>,
}

/// Sets the latency timer behind `port` to 1 ms where that is allowed, and says what it is then.
/// `port` may be a symlink.
///
/// `None` where there is no such timer: another adapter, a pseudo terminal, a system other than
/// Linux.
#[must_use]
pub fn shorten_latency(port: &Path) -> Option<LatencyTimer> {
    let device = fs::canonicalize(port).ok()?;
    shorten(Path::new("/sys/bus/usb-serial/devices"), device.file_name()?.as_ref())
}

fn shorten(devices: &Path, device: &Path) -> Option<LatencyTimer> {
    let timer = devices.join(device).join("latency_timer");
    let before = read_ms(&timer)?;
    if before <= SHORTEST_MS {
        return Some(LatencyTimer { ms: before, advice: None });
    }
    // whether it is allowed shows in what it reads then
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
        "the adapter keeps bytes for up to {ms} ms; shorten that once with `echo {SHORTEST_MS} | sudo tee {}`, or for good with the udev \
         rule `ACTION==\"add\", SUBSYSTEM==\"usb-serial\", DRIVER==\"ftdi_sio\", ATTR{{latency_timer}}=\"{SHORTEST_MS}\"` in \
         /etc/udev/rules.d/99-vn100.rules",
        timer.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn where_nothing_can_be_written_the_command_is_named() {
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
