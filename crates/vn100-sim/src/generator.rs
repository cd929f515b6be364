//! Rows of twelve values, as the sensor would put them into `$VNYMR`.

use std::num::NonZeroU32;

use thiserror::Error;
use vn100_protocol::OUTPUT_RATES_HZ;

use crate::{noise::ChannelStream, profile::Profile, surroundings::Surroundings};

/// Yaw, pitch and roll come first.
const ANGLES: usize = 3;

/// Time after switching on, in seconds, when the temperature has settled.
const WARM_S: f64 = 36_000.0;

/// The sensor has no such output rate.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("the sensor has no output rate of {rate_hz} Hz: use one of {}", OUTPUT_RATES_HZ.map(|rate| rate.to_string()).join(", "))]
pub struct UnsupportedRate {
    /// The rate asked for, Hz.
    pub rate_hz: u32,
}

/// The endless, seeded stream of an emulated sensor's samples, in constant memory.
#[derive(Debug, Clone)]
pub struct Generator {
    channels: [ChannelStream; 12],
    surroundings: Surroundings,
    interval_s: f64,
    /// Readings of temperature and pressure taken.
    readings: u64,
}

impl Generator {
    /// Samples of `profile` at `rate_hz`. Equal arguments give equal rows.
    ///
    /// # Errors
    /// [`UnsupportedRate`] unless the rate is one of [`OUTPUT_RATES_HZ`].
    pub fn new(profile: &Profile, rate_hz: u32, seed: u64) -> Result<Self, UnsupportedRate> {
        let rate = NonZeroU32::new(rate_hz)
            .filter(|_| OUTPUT_RATES_HZ.contains(&rate_hz))
            .ok_or(UnsupportedRate { rate_hz })?;
        let mut number = 0;
        let channels = profile.channels.map(|channel| {
            let stream = ChannelStream::new(&channel.noise, channel.window, rate, seed, number);
            number += 1;
            stream
        });
        let surroundings = Surroundings::new(seed);
        Ok(Self { channels, surroundings, interval_s: 1.0 / f64::from(rate_hz), readings: 0 })
    }

    /// The next sample: yaw, pitch, roll (deg, in (-180, 180]), magnetic field x y z (gauss),
    /// acceleration x y z (m/s²), angular rate x y z (rad/s).
    #[must_use]
    pub fn next_row(&mut self) -> [f32; 12] {
        let values = self.channels.each_mut().map(ChannelStream::next_sample);
        // single precision, as in the sensor: the last printed digit depends on it
        let mut row = values.map(|value| value as f32);
        for (angle_deg, value) in row.iter_mut().zip(values).take(ANGLES) {
            *angle_deg = wrapped_deg(value);
        }
        row
    }

    /// The temperature (degC) and the pressure (kPa) of the next sample, of a sensor that has
    /// warmed up.
    #[must_use]
    pub fn next_surroundings(&mut self) -> [f32; 2] {
        self.surroundings.advance_to(WARM_S + self.readings as f64 * self.interval_s);
        self.readings += 1;
        [self.surroundings.temperature_c as f32, self.surroundings.pressure_kpa as f32]
    }
}

/// The same direction in (-180, 180].
pub(crate) fn wrapped_deg(angle_deg: f64) -> f32 {
    let turned = angle_deg % 360.0;
    let wrapped = if turned > 180.0 {
        turned - 360.0
    } else if turned < -180.0 {
        turned + 360.0
    } else {
        turned
    };
    // the open end itself, or rounded to it
    if wrapped as f32 == -180.0 { 180.0 } else { wrapped as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::NoiseTruth;

    #[test]
    fn an_unsupported_rate_names_the_supported_ones() {
        let error = |rate| Generator::new(&Profile::lab3(), rate, 1).unwrap_err().to_string();
        assert_eq!(
            error(30),
            "the sensor has no output rate of 30 Hz: use one of 1, 2, 4, 5, 10, 20, 25, 40, 50, 100, 200"
        );
        assert!(error(0).contains("of 0 Hz"));
        for rate in OUTPUT_RATES_HZ {
            assert!(Generator::new(&Profile::lab3(), rate, 1).is_ok());
        }
    }

    #[test]
    fn angles_wrap_into_the_half_open_circle() {
        for (angle, wrapped) in [
            (0.0, 0.0),
            (180.0, 180.0),
            (-180.0, 180.0),
            (180.5, -179.5),
            (-180.5, 179.5),
            (360.0, 0.0),
            (539.0, 179.0),
            (540.0, 180.0),
            (-540.0, 180.0),
            (-900.25, 179.75),
        ] {
            assert_eq!(wrapped_deg(angle), wrapped, "{angle}");
        }
        // both lie nearer to the end than single precision resolves
        for angle in [(-180.0_f64).next_up(), 180.0_f64.next_up(), (-180.0_f64).next_down()] {
            assert_eq!(wrapped_deg(angle), 180.0);
        }
        assert!(wrapped_deg(-0.0).is_sign_negative());
    }

    #[test]
    fn only_angles_wrap() {
        let mut profile = Profile::lab3();
        for channel in &mut profile.channels {
            channel.noise = NoiseTruth { mean: 190.0, ..NoiseTruth::default() };
        }
        let row = Generator::new(&profile, 40, 1).unwrap().next_row();
        assert_eq!(row[..3], [-170.0; 3]);
        assert_eq!(row[3..], [190.0; 9]);
    }

    #[test]
    fn changing_one_channel_leaves_the_others_alone() {
        let rows = |profile: &Profile| {
            let mut generator = Generator::new(profile, 40, 5).unwrap();
            [(); 50].map(|()| generator.next_row())
        };
        let before = rows(&Profile::datasheet());
        let mut profile = Profile::datasheet();
        profile.channels[7].noise.random_walk = 1e-3;
        profile.channels[7].noise.bias_instability = 0.0;
        for (before, after) in before.iter().zip(rows(&profile)) {
            for channel in (0..12).filter(|&channel| channel != 7) {
                assert_eq!(before[channel], after[channel]);
            }
        }
    }

    #[test]
    fn seeds_and_channels_differ() {
        let row = |seed| Generator::new(&Profile::lab3(), 40, seed).unwrap().next_row();
        assert!(row(1).iter().zip(row(2)).all(|(one, other)| *one != other));
        let white = |value: f32, channel: usize| {
            let noise = Profile::lab3().channels[channel].noise;
            (f64::from(value) - noise.mean) / noise.white_density
        };
        let row = row(1);
        assert!((white(row[9], 9) - white(row[11], 11)).abs() > 1e-3);
    }
}
