//! The emulated sensor that the options of a command describe.

use std::{num::NonZeroU32, time::Duration};

use vn100_capture::Clock;
use vn100_session::EmulatedPort;
use vn100_sim::{
    device::{Device, DeviceConfig},
    wire::Wire,
};

use crate::args::SimSensorArgs;

/// The sensor itself, switched off.
pub(crate) fn device(args: &SimSensorArgs) -> Device {
    Device::new(DeviceConfig {
        profile: args.truth(),
        seed: args.seed,
        firmware: args.firmware,
        clock_error_ppm: args.clock_ppm,
        ..DeviceConfig::default()
    })
}

/// An emulated sensor that a command starts for itself is past its boot of 1.25 s.
const ON_FOR: Duration = Duration::from_secs(2);

/// The port of the sensor that the options describe, at the end of an adapter with this latency if there is one, and the baud rate of both.
pub(crate) fn emulated_port(args: &SimSensorArgs, usb_latency: Option<Duration>, clock: Clock) -> (EmulatedPort, u32) {
    let device = device(args);
    let host_baud = NonZeroU32::new(device.baud()).unwrap_or(NonZeroU32::MIN);
    let wire = Wire::new(device, &args.faults, args.seed, usb_latency, host_baud);
    (EmulatedPort::new(wire, ON_FOR, clock.now_ns()), host_baud.get())
}
