//! Rows of twelve values, as the sensor prints them in `$VNYMR`, and files of many of them.

use std::num::NonZeroU32;

use thiserror::Error;
use vn100_protocol::{Check, OUTPUT_RATES_HZ};

use crate::{
    message::Message,
    noise::ChannelStream,
    onboard::AveragingWindow,
    profile::Profile,
    sensor::{Deltas, SensorValues, Surroundings, wrapped_deg},
    thermal::ThermalBias,
};

/// The sensor has no such output rate.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("the sensor has no output rate of {rate_hz} Hz: use one of {}", rates.iter().map(u32::to_string).collect::<Vec<_>>().join(", "))]
pub struct UnsupportedRate {
    pub(crate) rate_hz: u32,
    pub(crate) rates: Vec<u32>,
}

/// The endless, seeded stream of an emulated sensor's samples.
#[derive(Debug, Clone)]
pub struct Generator {
    channels: [ChannelStream; 12],
    surroundings: Surroundings,
    thermal_bias: ThermalBias,
    age_s: f64,
    interval_s: f64,
    rows: u64,
}

impl Generator {
    /// Samples of `profile` at `rate_hz`. Equal arguments give equal rows.
    ///
    /// # Errors
    /// [`UnsupportedRate`] unless the rate is one of [`OUTPUT_RATES_HZ`].
    pub fn new(profile: &Profile, rate_hz: u32, seed: u64) -> Result<Self, UnsupportedRate> {
        let is_supported = OUTPUT_RATES_HZ.contains(&rate_hz);
        let generator = Self::at_any_rate(profile, rate_hz, seed).filter(|_| is_supported);
        generator.ok_or_else(|| UnsupportedRate { rate_hz, rates: OUTPUT_RATES_HZ.to_vec() })
    }

    /// Samples for a message: for increments the samples are means over the whole interval, without
    /// aliasing by an averaging window.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn for_message(profile: &Profile, message: &Message, rate_hz: u32, seed: u64) -> Result<Self, UnsupportedRate> {
        let mut profile = profile.clone();
        if message.has_deltas() {
            profile.channels.iter_mut().for_each(|channel| channel.window = AveragingWindow::None);
        }
        Self::new(&profile, rate_hz, seed)
    }

    /// `None` for a rate of zero.
    pub(crate) fn at_any_rate(profile: &Profile, rate_hz: u32, seed: u64) -> Option<Self> {
        let rate = NonZeroU32::new(rate_hz)?;
        let channels = std::array::from_fn(|number| {
            let channel = &profile.channels[number];
            ChannelStream::new(&channel.noise, channel.window, rate, seed, number as u32)
        });
        let thermal = profile.thermal;
        Some(Self {
            channels,
            surroundings: Surroundings::new(thermal, seed),
            thermal_bias: ThermalBias::new(thermal),
            age_s: thermal.age_s,
            interval_s: 1.0 / f64::from(rate_hz),
            rows: 0,
        })
    }

    /// The next sample: yaw, pitch, roll (deg, in (-180, 180]), magnetic field x y z (gauss),
    /// acceleration x y z (m/s²), angular rate x y z (rad/s).
    pub fn next_row(&mut self) -> [f32; 12] {
        let mut values = self.channels.each_mut().map(ChannelStream::next_sample);
        let (rate_rad_s, accel_m_s2) = self.thermal_bias.advance_to(self.age_s + self.rows as f64 * self.interval_s);
        self.rows += 1;
        values[6..9].iter_mut().for_each(|value| *value += accel_m_s2);
        values[9..].iter_mut().for_each(|value| *value += rate_rad_s);
        // single precision, as in the sensor, because the last printed digit depends on it
        let mut row = values.map(|value| value as f32);
        for (angle_deg, value) in row.iter_mut().zip(values).take(3) {
            *angle_deg = wrapped_deg(value);
        }
        row
    }

    /// The temperature (degC) and the pressure (kPa), this many seconds after the first sample.
    pub(crate) fn surroundings_at(&mut self, time_s: f64) -> [f32; 2] {
        self.surroundings.advance_to(self.age_s + time_s);
        [self.surroundings.temperature_c as f32, self.surroundings.pressure_kpa as f32]
    }
}

/// Appends the sentence of one row of a [`Generator`], with temperature (°C) and pressure (kPa) in
/// `surroundings`, from `$` to LF; increments are over `interval_s` seconds.
///
/// The angular rates are those of the row in every message: no attitude filter removes a bias.
pub fn write_sentence(line: &mut Vec<u8>, message: &Message, row: &[f32; 12], surroundings: [f32; 2], interval_s: f64) {
    let mut body = message.header.to_owned();
    let [.., ax, ay, az, gx, gy, gz] = row.map(|value| f64::from(value) * interval_s);
    let theta_deg = [gx, gy, gz].map(f64::to_degrees);
    let deltas = Deltas { time_s: interval_s, theta_deg, velocity_m_s: [ax, ay, az] };
    message.print(&values_of(row, surroundings), &deltas, &mut body);
    line.extend(Check::Xor8.sentence(&body).into_bytes());
}

/// The values of a row, with equal uncompensated and compensated ones.
pub(crate) fn values_of(row: &[f32; 12], [temperature_c, pressure_kpa]: [f32; 2]) -> SensorValues {
    let [yaw, pitch, roll, mx, my, mz, ax, ay, az, gx, gy, gz] = *row;
    let (mag_gauss, accel_m_s2, gyro_rad_s) = ([mx, my, mz], [ax, ay, az], [gx, gy, gz]);
    SensorValues {
        ypr_deg: [yaw, pitch, roll],
        mag_gauss,
        accel_m_s2,
        gyro_rad_s,
        uncompensated_mag_gauss: mag_gauss,
        uncompensated_accel_m_s2: accel_m_s2,
        uncompensated_gyro_rad_s: gyro_rad_s,
        temperature_c,
        pressure_kpa,
    }
}

/// Appends the next row of the generator as a sentence.
pub fn write_next(line: &mut Vec<u8>, message: &Message, generator: &mut Generator) {
    let time_s = generator.rows as f64 * generator.interval_s;
    let row = generator.next_row();
    let surroundings = if message.has_surroundings() { generator.surroundings_at(time_s) } else { [0.0; 2] };
    write_sentence(line, message, &row, surroundings, generator.interval_s);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::NoiseTruth;

    /// Sentences of real sensors: still, moving, beyond 100 m/s², with negative zero.
    const REAL: [&str; 8] = [
        "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n",
        "$VNYMR,-085.476,+074.973,+063.745,-00.5552,+00.4334,+00.9062,+08.992,-02.114,-01.105,+00.002040,-00.000298,-00.000980*6C\r\n",
        "$VNYMR,+148.954,+001.254,+000.995,-00.5664,-00.1587,+00.4170,+00.212,-00.169,-09.817,-00.000168,+00.000295,-00.000137*68\r\n",
        "$VNYMR,-077.616,-001.322,+000.143,+00.0452,+00.2449,-00.3347,-00.249,-00.019,-09.893,+00.001117,+00.000227,-00.000329*63\r\n",
        "$VNYMR,-082.171,-044.329,-135.904,+00.3385,-00.2514,+00.0610,-32.044,+06.154,+01.762,+09.803607,-11.823348,-04.562857*60\r\n",
        "$VNYMR,-118.034,-024.276,-062.915,+00.3261,-00.2790,+00.2276,-39.242,+123.931,-58.612,-00.223137,+02.140320,-03.657718*52\r\n",
        "$VNYMR,-000.326,+088.263,-034.861,-00.2266,+00.2469,-00.5156,-19.679,-40.886,-143.685,-06.326948,-00.046931,-00.119262*55\r\n",
        "$VNYMR,-095.878,+008.933,-009.419,+00.1785,+00.1474,+00.5479,+00.252,-03.706,-03.874,-01.012502,-00.234810,+00.247165*66\r\n",
    ];

    fn printed(header: &str, row: [f32; 12], surroundings: [f32; 2]) -> String {
        let mut line = Vec::new();
        write_sentence(&mut line, Message::named(header).unwrap(), &row, surroundings, 0.025);
        String::from_utf8(line).unwrap()
    }

    #[test]
    fn real_sentences_are_printed_alike() {
        for real in REAL {
            let fields = real[7..real.len() - 5].split(',').map(|field| field.parse::<f32>().unwrap());
            let row: Vec<f32> = fields.collect();
            assert_eq!(printed("VNYMR", row.try_into().unwrap(), [0.0; 2]), real);
        }
    }

    #[test]
    fn negative_zero_keeps_its_sign() {
        let text = printed("VNYMR", [-0.0; 12], [0.0; 2]);
        assert!(text.starts_with("$VNYMR,-000.000,"), "{text}");
        assert!(text.contains(",-00.0000,") && text.contains(",-00.000,"), "{text}");
        assert!(text.contains(",-00.000000*"), "{text}");
    }

    #[test]
    fn each_message_has_its_part_of_the_row() {
        let row = [0.0, 0.0, 90.0, -2.0841, 0.6045, 2.8911, 0.381, -0.154, -9.657, -0.005683, 0.000262, 0.001475];
        let inertial = "-02.0841,+00.6045,+02.8911,+00.381,-00.154,-09.657,-00.005683,+00.000262,+00.001475";
        for (header, body) in [
            ("VNYMR", format!("VNYMR,+000.000,+000.000,+090.000,{inertial}")),
            ("VNIMU", format!("VNIMU,{inertial},+21.6,+00099.761")),
            ("VNMAR", format!("VNMAR,{inertial}")),
            ("VNQMR", format!("VNQMR,+0.707107,+0.000000,+0.000000,+0.707107,{inertial}")),
        ] {
            assert_eq!(printed(header, row, [21.6, 99.761]).split('*').next().unwrap()[1..], body);
        }
        assert!(Message::named("VNXYZ").is_none());
    }

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
        // both are nearer to the end than the resolution of single precision
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
    fn changing_one_channel_leaves_the_others_unchanged() {
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
            let noise = &Profile::lab3().channels[channel].noise;
            (f64::from(value) - noise.mean) / noise.white_density
        };
        let row = row(1);
        assert!((white(row[9], 9) - white(row[11], 11)).abs() > 1e-3);
    }
}
