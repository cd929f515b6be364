//! `$VNDTV`: the changes of angle and velocity since the sentence before, read as mean rates and
//! accelerations.

use alloc::borrow::Cow;
use core::f64::consts::PI;

use super::{
    RangeError,
    layout::{Layout, Quantity},
    quantity::{ACCELERATION, ANGULAR_RATE, QuantityRow, rounded, row},
    sample::{MAX_CHANNELS, Sample, read_fields},
};
use crate::framing::sentence::{RejectReason, Sentence};

/// `$VNDTV`: acceleration and angular rate, each the mean since the sentence before: the change of
/// velocity or angle divided by the printed interval, in counts of packets. Their resolution is the
/// steps of 0.001 m/s and 0.001 deg divided by the interval.
pub static VNDTV: Layout = Layout {
    message: Cow::Borrowed("VNDTV"),
    compensated: None,
    channels: Cow::Borrowed(&[
        ACCELERATION.integrated("accel_x", VELOCITY_STEP_M_S),
        ACCELERATION.integrated("accel_y", VELOCITY_STEP_M_S),
        ACCELERATION.integrated("accel_z", VELOCITY_STEP_M_S),
        ANGULAR_RATE.integrated("gyro_x", ANGLE_STEP_RAD),
        ANGULAR_RATE.integrated("gyro_y", ANGLE_STEP_RAD),
        ANGULAR_RATE.integrated("gyro_z", ANGLE_STEP_RAD),
    ]),
    columns: None,
};

/// The content of the sentence: the interval, three angles, three velocities (VN-100 User Manual,
/// register 80).
static PRINTED: Layout = Layout {
    message: VNDTV_HEADER,
    compensated: None,
    channels: Cow::Borrowed(&[
        INTERVAL.decimal("delta_time"),
        ANGLE_CHANGE.decimal("delta_theta_x"),
        ANGLE_CHANGE.decimal("delta_theta_y"),
        ANGLE_CHANGE.decimal("delta_theta_z"),
        VELOCITY_CHANGE.decimal("delta_velocity_x"),
        VELOCITY_CHANGE.decimal("delta_velocity_y"),
        VELOCITY_CHANGE.decimal("delta_velocity_z"),
    ]),
    columns: None,
};

const INTERVAL: QuantityRow = row(Quantity::Value, "s", 2_000, 6, 0);
const ANGLE_CHANGE: QuantityRow = row(Quantity::Value, "deg", 1_000_000, 3, 0);
const VELOCITY_CHANGE: QuantityRow = row(Quantity::Value, "m/s", 1_000_000, 3, 0);

/// One unit of the last digit.
const VELOCITY_STEP_M_S: f64 = 0.001;
const ANGLE_STEP_RAD: f64 = 0.001 * PI / 180.0;

const VNDTV_HEADER: Cow<'static, str> = Cow::Borrowed("VNDTV");

/// Whether a sentence is such a one.
pub(super) fn are_in(sentence: &Sentence<'_>) -> bool {
    sentence.header() == VNDTV.message.as_bytes()
}

/// Reads such a sentence.
#[cold]
pub(super) fn read(sentence: &Sentence<'_>) -> Result<Sample, RejectReason> {
    let printed = read_fields(&sentence.body[VNDTV.message.len()..], &PRINTED)?;
    let value = |place: usize| PRINTED.channels[place].value(printed.counts[place]);
    // over an interval of zero all values exceed their limits
    let interval_s = value(0).max(0.0);
    let mut counts = [0; MAX_CHANNELS];
    for (place, (count, channel)) in counts.iter_mut().zip(&*VNDTV.channels).enumerate() {
        let change = if place < 3 { value(4 + place) } else { value(place - 2) * PI / 180.0 };
        let scaled = change / interval_s / channel.scale;
        if interval_s == 0.0 || scaled.abs() > channel.limit_counts.into() {
            return Err(RangeError { channel, count: scaled as i64 }.into());
        }
        *count = rounded(scaled);
    }
    Ok(Sample { layout: &VNDTV, counts, ..printed })
}
