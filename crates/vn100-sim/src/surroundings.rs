//! Temperature inside the emulated sensor, and the pressure of the air around it.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;

use crate::random::{NoiseComponent, normal, random_stream};

/// Number of their random stream, behind those of the twelve channels.
const STREAM: u32 = 12;

/// Warm-up from the temperature of the room, as a first-order lag.
const ROOM_C: f64 = 22.0;
const WARM_UP_C: f64 = 11.0;
const WARM_UP_S: f64 = 900.0;
const TEMPERATURE_SIGMA_C: f64 = 0.02;
/// Slow change of the weather: a sine.
const PRESSURE_KPA: f64 = 101.325;
const WEATHER_KPA: f64 = 0.05;
const WEATHER_S: f64 = 7200.0;
const PRESSURE_SIGMA_KPA: f64 = 0.003;

/// What the sensor's thermometer and barometer read.
#[derive(Debug, Clone)]
pub(crate) struct Surroundings {
    random: ChaCha8Rng,
    pub(crate) temperature_c: f64,
    pub(crate) pressure_kpa: f64,
}

impl Surroundings {
    /// Of a sensor that is just switched on.
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            random: random_stream(seed, STREAM, NoiseComponent::White),
            temperature_c: ROOM_C,
            pressure_kpa: PRESSURE_KPA,
        }
    }

    /// Reads both anew, so many seconds after switching on.
    pub(crate) fn advance_to(&mut self, time_s: f64) {
        let warm = WARM_UP_C * (1.0 - (-time_s / WARM_UP_S).exp());
        let weather = WEATHER_KPA * (TAU * time_s / WEATHER_S).sin();
        self.temperature_c = ROOM_C + warm + TEMPERATURE_SIGMA_C * normal(&mut self.random);
        self.pressure_kpa = PRESSURE_KPA + weather + PRESSURE_SIGMA_KPA * normal(&mut self.random);
    }
}
