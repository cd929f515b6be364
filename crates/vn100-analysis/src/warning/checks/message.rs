//! Warnings about the message: what the sensor has done to its values.

use vn100_protocol::{Layout, Quantity, ReferenceFrameRotation, Register};

use crate::{
    accumulate::sensor_rates::rates_hz,
    remedy::{Remedy, Setting},
    sensor::uncompensated_message,
    snapshot::Snapshot,
    warning::{Finding, Warning},
};

pub(super) fn warnings(snapshot: &Snapshot) -> Vec<Warning> {
    let Some(layout) = &snapshot.layout else { return Vec::new() };
    let mut warnings = Vec::new();
    if is_of_sensor(layout) && is_rotated(snapshot) {
        warnings.push(Warning::new(Finding::Rotated));
    }
    let rates = layout.channels.iter().filter(|channel| channel.quantity == Quantity::AngularRate);
    let rates: Vec<_> = rates.map(|channel| channel.name.to_string()).collect();
    match layout.compensated {
        _ if rates.is_empty() => {}
        Some(false) => {}
        None => {
            let found = Warning::new(Finding::MaybeCompensated).of(rates);
            warnings.push(found.cured_by(Remedy::SayCompensated));
        }
        Some(true) => {
            let message = layout.message.to_string();
            let uncompensated = Setting::Message(uncompensated_message(&message));
            let found = Warning::new(Finding::Compensated(message)).of(rates);
            warnings.push(match is_of_sensor(layout) {
                true => found.cured_by(Remedy::MeasureWith(uncompensated)),
                false => found,
            });
        }
    }
    warnings
}

/// Whether the sensor turns its axes, by register 26, if the stream contains it.
fn is_rotated(snapshot: &Snapshot) -> bool {
    let rotation: Option<ReferenceFrameRotation> = snapshot.register(Register::ROTATION);
    rotation.is_some_and(|rotation| rotation.matrix != [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
}

/// Whether the message is one of the VN-100's own.
fn is_of_sensor(layout: &Layout) -> bool {
    !rates_hz(Some(layout)).is_empty()
}
