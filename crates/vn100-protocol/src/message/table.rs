//! The messages that are measured, one row each. The decoder, the readers of files and the analysis
//! take all their knowledge of a message from here.

use alloc::borrow::Cow;

use crate::{
    framing::sentence::{RejectReason, Sentence},
    message::{
        increments::{self, VNDTV},
        layout::{Channel, Layout},
        quantity::{self, ACCELERATION, ANGLE, ANGULAR_RATE, ELEMENT, MAGNETIC_FIELD},
        sample::{Sample, read_fields},
    },
};

/// A static for each row, and the list of all rows.
macro_rules! messages {
    ($($(#[$doc:meta])* $name:ident = $header:literal, compensated: $compensated:literal, [$($channel:expr),*];)*) => {
        $(
            $(#[$doc])*
            pub static $name: Layout = Layout {
                message: Cow::Borrowed($header),
                compensated: Some($compensated),
                channels: Cow::Borrowed(&[$($channel),*]),
                columns: None,
            };
        )*

        /// Every message that is measured.
        pub static MESSAGES: [&Layout; [$($header),*].len() + 1] = [$(&$name,)* &VNDTV];
    };
}

#[rustfmt::skip]
messages! {
    /// `$VNYMR`: attitude, and the compensated magnetic field, acceleration and angular rate.
    VNYMR = "VNYMR", compensated: true,
        [YAW, PITCH, ROLL, MAG_X, MAG_Y, MAG_Z, ACCEL_X, ACCEL_Y, ACCEL_Z, GYRO_X, GYRO_Y, GYRO_Z];

    /// `$VNIMU`: the uncompensated magnetic field, acceleration and angular rate, with temperature
    /// and pressure.
    VNIMU = "VNIMU", compensated: false,
        [MAG_X, MAG_Y, MAG_Z, ACCEL_X, ACCEL_Y, ACCEL_Z, GYRO_X, GYRO_Y, GYRO_Z, TEMPERATURE, PRESSURE];

    /// `$VNMAR`: the compensated magnetic field, acceleration and angular rate.
    VNMAR = "VNMAR", compensated: true,
        [MAG_X, MAG_Y, MAG_Z, ACCEL_X, ACCEL_Y, ACCEL_Z, GYRO_X, GYRO_Y, GYRO_Z];

    /// `$VNQMR`: attitude as a quaternion, and the compensated magnetic field, acceleration and
    /// angular rate.
    VNQMR = "VNQMR", compensated: true,
        [QUAT_X, QUAT_Y, QUAT_Z, QUAT_W, MAG_X, MAG_Y, MAG_Z, ACCEL_X, ACCEL_Y, ACCEL_Z, GYRO_X, GYRO_Y, GYRO_Z];
}

impl Sample {
    /// Reads a sentence; `None` unless it is one of the [`MESSAGES`].
    ///
    /// # Errors
    /// [`RejectReason::Grammar`] unless it has the numbers of its message in one of the two print
    /// formats with at most a suffix after them; [`RejectReason::Range`] for a value beyond its
    /// channel's limit.
    pub fn parse(sentence: &Sentence<'_>) -> Option<Result<Self, RejectReason>> {
        if increments::are_in(sentence) {
            return Some(increments::read(sentence));
        }
        let header = sentence.header();
        let layout = MESSAGES.into_iter().find(|layout| layout.message.as_bytes() == header)?;
        Some(read_fields(&sentence.body[header.len()..], layout))
    }
}

const YAW: Channel = ANGLE.decimal("yaw");
const PITCH: Channel = ANGLE.decimal("pitch");
const ROLL: Channel = ANGLE.decimal("roll");
const QUAT_X: Channel = ELEMENT.decimal("quat_x");
const QUAT_Y: Channel = ELEMENT.decimal("quat_y");
const QUAT_Z: Channel = ELEMENT.decimal("quat_z");
const QUAT_W: Channel = ELEMENT.decimal("quat_w");
const MAG_X: Channel = MAGNETIC_FIELD.decimal("mag_x");
const MAG_Y: Channel = MAGNETIC_FIELD.decimal("mag_y");
const MAG_Z: Channel = MAGNETIC_FIELD.decimal("mag_z");
const ACCEL_X: Channel = ACCELERATION.decimal("accel_x");
const ACCEL_Y: Channel = ACCELERATION.decimal("accel_y");
const ACCEL_Z: Channel = ACCELERATION.decimal("accel_z");
const GYRO_X: Channel = ANGULAR_RATE.decimal("gyro_x");
const GYRO_Y: Channel = ANGULAR_RATE.decimal("gyro_y");
const GYRO_Z: Channel = ANGULAR_RATE.decimal("gyro_z");
const TEMPERATURE: Channel = quantity::TEMPERATURE.decimal("temperature");
const PRESSURE: Channel = quantity::PRESSURE.decimal("pressure");

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Check;

    #[test]
    fn names_are_unique() {
        for layout in MESSAGES {
            let mut names: Vec<_> = layout.channels.iter().map(|channel| &channel.name).collect();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), layout.channels.len());
        }
    }

    #[test]
    fn a_name_means_one_channel_in_all_messages() {
        let printed = MESSAGES.iter().flat_map(|layout| &*layout.channels);
        let channels: Vec<_> = printed.filter(|channel| channel.increment_step.is_none()).collect();
        for (one, other) in channels.iter().flat_map(|one| channels.iter().map(move |other| (one, other))) {
            assert_eq!(one.name == other.name, one == other, "{} {}", one.name, other.name);
        }
    }

    #[test]
    fn limits_are_in_counts() {
        let limits: Vec<_> = VNYMR.channels.iter().map(|channel| channel.limit_counts).collect();
        assert_eq!(limits[2..=9], [180_000, 100_000, 100_000, 100_000, 200_000, 200_000, 200_000, 40_000_000]);
        assert_eq!((VNIMU.channels[9].limit_counts, VNIMU.channels[10].limit_counts), (2_000, 200_000));
        assert_eq!(VNQMR.channels[3].limit_counts, 2_000_000);
    }

    /// Both print formats of every message, also in unusual widths.
    const BODIES: [&str; 9] = [
        "VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391",
        "VNYMR,-5.469,+04.972,-180.000,-0.5551,+10.0000,+000.9048,+108.971,-2.145,-200.000,+0.000040,-40.000000,-0.000000,T01,S00FF",
        "VNYMR,-085.46,+074.97,+063.75,-0.5551,+0.4403,-0.0000,+08.971,-02.145,-01.093,+00.0000,-40.0000,-00.0003",
        "VNYMR,-5.46,-000.00,+180.00,-00.5551,+10.0000,+000.9048,+108.971,-2.145,-0.000,+0.0000,-40.0000,-0.0003,S0000",
        "VNIMU,-0.0350,+00.4222,-000.6643,-00.015,+00.019,+109.948,-00.000000,-08.008442,-0.044656,+20.7,+084.322,T5",
        "VNMAR,-00.0350,+00.4222,-00.6643,-00.015,+00.019,+109.948,-00.000000,-08.008442,-0.044656,S1234",
        "VNMAR,-0.0350,+0.4222,-0.6643,-00.015,+00.019,+09.948,-00.0000,-08.0084,-00.0446",
        "VNQMR,+0.004183,+0.001149,+0.089285,+0.995997,+00.0113,-00.2384,+00.1800,+00.020,-00.092,-09.683,-00.000272,+00.000824,+00.000073,T0000000543",
        "VNQMR,+0.021375,-0.049923,+0.797361,-0.601055,-0.2354,+0.8029,+1.8875,+00.795,-00.412,-09.709,-00.0201,-00.0055,-00.0149",
    ];

    #[test]
    fn good_sentences_of_any_width_are_read() {
        for body in BODIES {
            let sentence = Sentence { body: body.as_bytes(), raw: body.as_bytes(), check: Check::Crc16, offset: 0 };
            assert!(matches!(Sample::parse(&sentence), Some(Ok(_))), "{body}");
        }
    }
}
