//! The truth of all twelve channels, by name.

use thiserror::Error;

use crate::{
    STANDARD_GRAVITY_M_S2,
    noise::{NoiseTruth, Vibration},
    onboard::AveragingWindow,
    thermal::Thermal,
};

const HOUR_S: f64 = 3600.0;

/// Output rate of the record for [`Profile::lab3`], Hz.
const LAB3_RATE_HZ: f64 = 40.0;

/// One channel: its truth, and the path of its white noise to the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelProfile {
    /// Mean and noise.
    pub noise: NoiseTruth,
    /// Whether the white noise density is that of the output, or that of the sensor before a
    /// window.
    pub window: AveragingWindow,
}

/// The truth of an emulated sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// The name that selects it.
    pub name: &'static str,
    /// In the order of `$VNYMR`: yaw, pitch, roll (deg), magnetic field x y z (gauss), acceleration
    /// x y z (m/s²), angular rate x y z (rad/s).
    pub channels: [ChannelProfile; 12],
    /// Temperature of the sensor, and the bias that depends on it.
    pub thermal: Thermal,
}

/// There is no profile of that name.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("unknown noise profile {name:?}: use one of {}", Profile::NAMES.join(", "))]
pub struct UnknownProfile {
    /// The requested name.
    pub name: String,
}

impl Profile {
    /// The names that [`Profile::named`] knows.
    pub const NAMES: [&'static str; 2] = ["datasheet", "lab3"];

    /// The profile with that name.
    ///
    /// # Errors
    /// [`UnknownProfile`] for any other than [`Profile::NAMES`].
    pub fn named(name: &str) -> Result<Self, UnknownProfile> {
        match name {
            "datasheet" => Ok(Self::datasheet()),
            "lab3" => Ok(Self::lab3()),
            _ => Err(UnknownProfile { name: name.to_owned() }),
        }
    }

    /// A sensor with the figures of its data sheet, level and at rest, facing magnetic north at a
    /// middle latitude, with the factory default of the averaging window.
    ///
    /// Densities are the sensor's: at 40 Hz the output of gyro and accelerometer has 2.24 times as
    /// much (see [`AveragingWindow`]). The sheet states no random walk, so there is none. The
    /// angles have a small white noise of their own, which is not computed from the other channels.
    #[must_use]
    pub fn datasheet() -> Self {
        let gyro = NoiseTruth {
            white_density: 0.0035_f64.to_radians(),          // 0.0035 deg/s/√Hz
            bias_instability: 6.0_f64.to_radians() / HOUR_S, // deg/h; typical 5 to 7
            ..NoiseTruth::default()
        };
        let accel = NoiseTruth {
            white_density: 0.14 * 1e-3 * STANDARD_GRAVITY_M_S2, // 0.14 mg/√Hz
            bias_instability: 3e-4,                             // stated: below 0.04 mg = 3.92e-4
            ..NoiseTruth::default()
        };
        let mag = NoiseTruth { white_density: 140e-6, ..NoiseTruth::default() };
        let angle = NoiseTruth { white_density: 5e-4, ..NoiseTruth::default() };
        // 0.48 gauss, dipping by 64 deg
        let field_gauss = [0.21, 0.0, 0.43];
        let channels = std::array::from_fn(|number| {
            let (mean, noise, window) = match number {
                0..3 => (0.0, angle, AveragingWindow::None),
                3..6 => (field_gauss[number - 3], mag, AveragingWindow::MAG_DEFAULT),
                8 => (-STANDARD_GRAVITY_M_S2, accel, AveragingWindow::ACCELEROMETER_DEFAULT),
                6..8 => (0.0, accel, AveragingWindow::ACCELEROMETER_DEFAULT),
                _ => (0.0, gyro, AveragingWindow::GYRO_DEFAULT),
            };
            ChannelProfile { noise: NoiseTruth { mean, ..noise }, window }
        });
        Self { name: "datasheet", channels, thermal: Thermal::default() }
    }

    /// A published sensor at rest, 40 Hz.
    ///
    /// Every channel has the mean and standard deviation of a record of ten minutes, as white
    /// noise, except the two that were also analysed. Densities are those of the output at 40 Hz;
    /// no window applies.
    ///
    /// * Gyro y: N 0.354 deg/√h, K 0.8969 deg/h^1.5, no flicker. The published standard deviation
    ///   is larger than N gives; the rest is a vibration line at 18.4 Hz.
    /// * Accelerometer y: N 0.114 m/s/√h, B 0.0131 mg, K 4.559 m/s/h^1.5.
    ///
    /// The "bias instabilities" published with these, 0.830 deg/h and 0.0356 mg, are the minimum of
    /// the Allan deviation divided by 0.664, which counts N and K as flicker. Five hours of this
    /// truth give the same (medians 0.85 deg/h and 0.036 mg); ten minutes are too short for the
    /// gyro and give 2.3 deg/h.
    #[must_use]
    pub fn lab3() -> Self {
        let white = |mean, standard_deviation: f64| NoiseTruth {
            mean,
            white_density: standard_deviation / LAB3_RATE_HZ.sqrt(),
            ..NoiseTruth::default()
        };
        let noise = [
            white(52.339768, 0.051601),
            white(0.272679, 0.006165),
            white(0.000704, 0.004488),
            white(0.225998, 0.001378),
            white(0.123310, 0.002924),
            white(0.057567, 0.003743),
            white(0.048526, 0.011822),
            lab3_accel_y(),
            white(-9.717405, 0.020968),
            white(0.000051, 0.000638),
            lab3_gyro_y(),
            white(-0.000009, 0.000638),
        ];
        Self {
            name: "lab3",
            channels: noise.map(|noise| ChannelProfile { noise, window: AveragingWindow::None }),
            thermal: Thermal::default(),
        }
    }
}

fn lab3_gyro_y() -> NoiseTruth {
    const STANDARD_DEVIATION_RAD_S: f64 = 0.000766;
    let white_density = 0.354_f64.to_radians() / HOUR_S.sqrt();
    let white_variance = white_density.powi(2) * LAB3_RATE_HZ;
    let line_variance = STANDARD_DEVIATION_RAD_S.powi(2) - white_variance;
    NoiseTruth {
        mean: -0.000152,
        white_density,
        random_walk: 0.8969_f64.to_radians() / HOUR_S.powf(1.5),
        line: Some(Vibration { amplitude: (2.0 * line_variance).sqrt(), frequency_hz: 18.4 }),
        ..NoiseTruth::default()
    }
}

fn lab3_accel_y() -> NoiseTruth {
    NoiseTruth {
        mean: 0.000759,
        white_density: 0.114 / HOUR_S.sqrt(),
        bias_instability: 0.0131 * 1e-3 * STANDARD_GRAVITY_M_S2,
        random_walk: 4.559 / HOUR_S.powf(1.5),
        ..NoiseTruth::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_close(found: f64, expected: f64, relative: f64) {
        assert!((found / expected - 1.0).abs() < relative, "{found}, expected {expected}");
    }

    #[test]
    fn names_lead_to_profiles() {
        for name in Profile::NAMES {
            assert_eq!(Profile::named(name).unwrap().name, name);
        }
    }

    #[test]
    fn an_unknown_name_lists_the_known_ones() {
        let error = Profile::named("lab4").unwrap_err();
        assert_eq!(error.to_string(), "unknown noise profile \"lab4\": use one of datasheet, lab3");
    }

    /// The conversion factors are those printed in reference works.
    #[test]
    fn published_coefficients_are_kept_in_si() {
        let (datasheet, lab3) = (Profile::datasheet().channels, Profile::lab3().channels);
        assert_close(datasheet[9].noise.bias_instability * 206_264.806, 6.0, 1e-8);
        assert_close(datasheet[6].noise.white_density * 101.971621, 0.14, 1e-8);
        assert_close(lab3[10].noise.white_density * 3437.747, 0.354, 1e-7);
        assert_close(lab3[10].noise.random_walk * 1.23759e7, 0.8969, 1e-5);
        assert_close(lab3[7].noise.bias_instability * 101.971621, 0.0131, 1e-8);
        assert_close(lab3[7].noise.white_density * 60.0, 0.114, 1e-12);
        assert_close(lab3[7].noise.random_walk * 216_000.0, 4.559, 1e-12);
    }

    #[test]
    fn datasheet_densities_in_si() {
        let channels = Profile::datasheet().channels;
        assert_close(channels[9].noise.white_density, 6.11e-5, 1e-3);
        assert_close(channels[9].noise.bias_instability, 2.9e-5, 1e-2);
        assert_close(channels[6].noise.white_density, 1.373e-3, 1e-3);
        assert_close(channels[3].noise.white_density, 1.4e-4, 1e-12);
    }

    #[test]
    fn lab3_noise_adds_up_to_the_published_standard_deviations() {
        let published = [
            0.051601, 0.006165, 0.004488, 0.001378, 0.002924, 0.003743, 0.011822, 0.011932, 0.020968, 0.000638,
            0.000766, 0.000638,
        ];
        for (channel, published) in Profile::lab3().channels.iter().zip(published) {
            let noise = channel.noise;
            let line = noise.line.map_or(0.0, |line| line.amplitude.powi(2) / 2.0);
            let found = (noise.white_density.powi(2) * LAB3_RATE_HZ + line).sqrt();
            // accelerometer y: N alone is 0.7 % larger
            assert_close(found, published, 0.02);
        }
    }
}
