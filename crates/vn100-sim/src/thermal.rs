//! The temperature of the sensor, and the bias that follows it, with known truth.

use std::{f64::consts::TAU, str::FromStr};

use thiserror::Error;

use crate::STANDARD_GRAVITY_M_S2;

/// The truth of the temperature of the sensor, and of the residual of its temperature compensation.
///
/// The text is a list of differences from a sensor that has just been switched on, warms up as
/// usual in a room of constant temperature and has no residual, such as `gyro=0.002 accel=0.1
/// lag=60 cycle=1.5 period=900`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thermal {
    /// Temperature coefficient of the bias of each gyroscope axis, rad/s per °C; in text `gyro`, in
    /// deg/s per °C.
    pub gyro_rad_s_c: f64,
    /// Temperature coefficient of the bias of each accelerometer axis, m/s² per °C; in text
    /// `accel`, in mg per °C.
    pub accel_m_s2_c: f64,
    /// First-order lag of the bias after the temperature, in seconds; `lag`.
    pub lag_s: f64,
    /// The final excess of the sensor's temperature over the room, °C; `heating`.
    pub self_heating_c: f64,
    /// Time constant of the warm-up, in seconds; `warm-up`.
    pub self_heating_s: f64,
    /// Amplitude of a sinusoidal temperature of the room, °C; `cycle`.
    pub cycle_c: f64,
    /// Period of that temperature, in seconds; `period`.
    pub cycle_s: f64,
    /// Standard deviation of the noise of the readings, °C.
    pub noise_c: f64,
    /// Time from switching on to the beginning of a capture, in seconds; `age`. An emulated port
    /// has just been switched on.
    pub age_s: f64,
}

/// Temperature of the room, without its cycle.
const ROOM_C: f64 = 22.0;

/// Seconds after which a sensor has warmed up.
const WARM_S: f64 = 36_000.0;

impl Default for Thermal {
    /// A sensor that has been on for long, in a room of constant temperature, without a residual.
    fn default() -> Self {
        Self {
            gyro_rad_s_c: 0.0,
            accel_m_s2_c: 0.0,
            lag_s: 0.0,
            self_heating_c: 11.0,
            self_heating_s: 900.0,
            cycle_c: 0.0,
            cycle_s: 900.0,
            noise_c: 0.02,
            age_s: WARM_S,
        }
    }
}

impl Thermal {
    /// A sensor that has this temperature in °C when it has warmed up.
    pub(crate) fn warm_at(temperature_c: f64) -> Self {
        Self { self_heating_c: temperature_c - ROOM_C, ..Self::default() }
    }

    /// The temperature of the sensor in °C, `time_s` seconds after switching on.
    pub(crate) fn temperature_c(&self, time_s: f64) -> f64 {
        let heated = self.self_heating_c * (1.0 - (-time_s / self.self_heating_s).exp());
        ROOM_C + heated + self.cycle_c * (TAU * (time_s / self.cycle_s).fract()).sin()
    }
}

/// The options of the temperature are impossible.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "\"{0}\" is no thermal setting: give gyro=DEG_S_C accel=MG_C lag=S heating=C warm-up=S cycle=C period=S age=S, times above 0 but lag and \
     age, which may be 0"
)]
pub struct ThermalError(String);

impl FromStr for Thermal {
    type Err = ThermalError;

    fn from_str(text: &str) -> Result<Self, ThermalError> {
        let mut thermal = Self { age_s: 0.0, ..Self::default() };
        for item in text.split_whitespace() {
            let wrong = || ThermalError(item.into());
            let (key, number) = item.split_once('=').ok_or_else(wrong)?;
            let number: f64 = number.parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(wrong)?;
            let at_least = |least: f64| Some(number).filter(|number| *number >= least).ok_or_else(wrong);
            match key {
                "gyro" => thermal.gyro_rad_s_c = number.to_radians(),
                "accel" => thermal.accel_m_s2_c = number * 1e-3 * STANDARD_GRAVITY_M_S2,
                "heating" => thermal.self_heating_c = number,
                "cycle" => thermal.cycle_c = number,
                "lag" => thermal.lag_s = at_least(0.0)?,
                "age" => thermal.age_s = at_least(0.0)?,
                "warm-up" => thermal.self_heating_s = at_least(f64::MIN_POSITIVE)?,
                "period" => thermal.cycle_s = at_least(f64::MIN_POSITIVE)?,
                _ => return Err(wrong()),
            }
        }
        Ok(thermal)
    }
}

/// The temperature that the bias follows, over time.
#[derive(Debug, Clone)]
pub(crate) struct ThermalBias {
    thermal: Thermal,
    /// The time, and the temperature after the lag.
    last: Option<(f64, f64)>,
    first_c: f64,
}

impl ThermalBias {
    pub(crate) const fn new(thermal: Thermal) -> Self {
        Self { thermal, last: None, first_c: 0.0 }
    }

    /// The bias of gyroscope (rad/s) and accelerometer (m/s²) axes this many seconds after
    /// switching on, less that of the first call. Times must not decrease.
    pub(crate) fn advance_to(&mut self, time_s: f64) -> (f64, f64) {
        let now_c = self.thermal.temperature_c(time_s);
        let lagged_c = match self.last {
            None => {
                self.first_c = now_c;
                now_c
            }
            Some((before_s, lagged_c)) => {
                let lags = (time_s - before_s) / self.thermal.lag_s;
                let gain = if lags.is_finite() { -(-lags).exp_m1() } else { 1.0 };
                lagged_c + gain * (now_c - lagged_c)
            }
        };
        self.last = Some((time_s, lagged_c));
        let degrees = lagged_c - self.first_c;
        (self.thermal.gyro_rad_s_c * degrees, self.thermal.accel_m_s2_c * degrees)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_truth_is_read() {
        let thermal: Thermal = "gyro=0.002 accel=-0.1 lag=60 heating=8 cycle=1.5 period=600 age=30".parse().unwrap();
        assert!((thermal.gyro_rad_s_c.to_degrees() - 0.002).abs() < 1e-15);
        assert!((thermal.accel_m_s2_c + 0.1e-3 * 9.80665).abs() < 1e-15);
        assert_eq!((thermal.lag_s, thermal.self_heating_s, thermal.age_s), (60.0, 900.0, 30.0));
        assert_eq!("".parse::<Thermal>(), Ok(Thermal { age_s: 0.0, ..Thermal::default() }));
    }

    #[test]
    fn impossible_options_are_reported() {
        for item in ["gyro", "gyro=x", "gyro=inf", "lag=-1", "period=0", "warm-up=0", "cool=1"] {
            let error = format!("cycle=1 {item}").parse::<Thermal>().unwrap_err();
            let text = error.to_string();
            assert!(text.starts_with(&format!("\"{item}\" is")) && text.contains("warm-up=S"), "{text}");
        }
    }

    #[test]
    fn a_sensor_warms_up_and_follows_its_room() {
        let thermal: Thermal = "heating=8 warm-up=600 cycle=2 period=400".parse().unwrap();
        assert_eq!(thermal.temperature_c(0.0), 22.0);
        assert!((thermal.temperature_c(600.0) - (22.0 + 8.0 * (1.0 - (-1.0_f64).exp()))).abs() < 1e-9);
        assert!((thermal.temperature_c(100_100.0) - 32.0).abs() < 1e-9, "a quarter of a cycle");
    }

    #[test]
    fn the_bias_follows_with_a_lag_and_completely() {
        let thermal: Thermal = "gyro=1 lag=60 heating=10 warm-up=0.001".parse().unwrap();
        let mut bias = ThermalBias::new(thermal);
        assert_eq!(bias.advance_to(0.0), (0.0, 0.0));
        let at = |bias: &mut ThermalBias, from: usize, to: usize| {
            (from..=to).map(|tick| bias.advance_to(tick as f64 * 0.1).0.to_degrees()).last().unwrap()
        };
        let after_one_lag = at(&mut bias, 1, 600);
        assert!((after_one_lag - 10.0 * (1.0 - (-1.0_f64).exp())).abs() < 1e-9, "{after_one_lag}");
        assert!((at(&mut bias, 601, 9000) - 10.0).abs() < 1e-4);
    }
}
