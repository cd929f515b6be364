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
    Device::new(DeviceConfig { profile: args.truth(), seed: args.seed, ..DeviceConfig::default() })
}

/// An emulated sensor that a command starts for itself is past its boot of 1.25 s.
const ON_FOR: Duration = Duration::from_secs(2);

/// The port of the sensor that the options describe, and its baud rate.
pub(crate) fn emulated_port(args: &SimSensorArgs, clock: Clock) -> (EmulatedPort, u32) {
    let device = device(args);
    let host_baud = NonZeroU32::new(device.baud()).unwrap_or(NonZeroU32::MIN);
    let wire = Wire::new(device, &args.faults, args.seed, host_baud);
    (EmulatedPort::new(wire, ON_FOR, clock.now_ns()), host_baud.get())
}
