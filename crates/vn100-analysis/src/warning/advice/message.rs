//! Warnings about the message: what the sensor has done to its values.

use vn100_protocol::{Layout, Quantity, ReferenceFrameRotation, Register, RegisterContents, RegisterFields};

use super::Advice;
use crate::{
    accumulate::sensor_rates::rates_hz,
    remedy::{Remedy, Setting, Text},
    sensor::uncompensated_message,
    snapshot::Snapshot,
    warning::WarningKind,
};

impl Advice {
    pub(super) fn on_message(&mut self, snapshot: &Snapshot) {
        let Some(layout) = &snapshot.layout else { return };
        if is_of_sensor(layout) && is_rotated(snapshot) {
            let details = "Register 26 holds a rotation: x, y and z are axes of the vehicle, each a mixture of axes of the sensor. A \
                           disturbance or a high noise of one axis of the sensor shows on all that it mixes into.";
            self.warn(WarningKind::RotatedAxes, "axes rotated by the sensor (register 26)", details);
        }
        let rates = layout.channels.iter().filter(|channel| channel.quantity == Quantity::AngularRate);
        let rates: Vec<_> = rates.map(|channel| channel.name.to_string()).collect();
        if rates.is_empty() {
            return;
        }
        if layout.compensated.is_none() {
            let headline = "unknown whether a filter has removed the gyroscope bias";
            let details = Text::from("If one has, B, K and R are those of the filter, not of the sensor. Set ")
                .remedy(Remedy::SayCompensated)
                .then(" yes or no.");
            self.warn_of(WarningKind::CompensationUnknown, rates, headline, details);
        } else if layout.compensated == Some(true) {
            let headline = format!("{} is bias-compensated: gyro B and K not measurable", layout.message);
            let details = Text::from(
                "The attitude filter removes its bias estimate from the angular rates: at long averaging times the deviation shows that \
                 filter, not the sensor. ",
            );
            let details = match is_of_sensor(layout) {
                true => {
                    let message = Setting::Message(uncompensated_message(&layout.message));
                    details
                        .then("`")
                        .remedy(Remedy::MeasureWith(message))
                        .then("` records uncompensated rates, which show bias instability and rate random walk.")
                }
                false => {
                    details.then("Record the uncompensated output to measure bias instability and rate random walk.")
                }
            };
            self.warn_of(WarningKind::CompensatedStream, rates, headline, details);
        }
    }
}

/// Whether the sensor turns its axes, by register 26, where the stream contains it.
fn is_rotated(snapshot: &Snapshot) -> bool {
    let register = Register::ROTATION;
    let fields = snapshot.registers.get(&register.0).and_then(|fields| RegisterFields::new(fields).ok());
    let rotation =
        fields.and_then(|fields| RegisterContents { register, fields }.value::<ReferenceFrameRotation>().ok());
    rotation.is_some_and(|rotation| rotation.matrix != [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
}

/// Whether the message is one of the VN-100's own.
fn is_of_sensor(layout: &Layout) -> bool {
    !rates_hz(Some(layout)).is_empty()
}
