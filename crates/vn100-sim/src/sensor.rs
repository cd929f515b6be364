//! The measurements of the emulated sensor, tick by tick: the truth of a profile after the window
//! of register 85.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;

use crate::{
    flicker::flicker,
    gauss_markov::Processes,
    noise::{NoiseComponent, NoiseTruth, RandomWalk, random_stream},
    normal::normal,
    onboard::{AveragingWindow, IMU_REFRESH_HZ, LowPass, MAG_REFRESH_HZ, White},
    profile::Profile,
    thermal::{Thermal, ThermalBias},
};

/// The factory default of the window.
const DELIVERED_WINDOW: u32 = 4;

/// Attitude is computed on every second tick.
const ATTITUDE_REFRESH_HZ: u32 = 400;

/// Ticks between two values of all slow quantities: flicker, walk, temperature and pressure.
const SLOW_TICKS: u64 = 20;
const SLOW_INTERVAL_S: f64 = SLOW_TICKS as f64 / IMU_REFRESH_HZ as f64;

/// Time constant of the attitude filter's gyro bias. The maker states none; recorded streams
/// suggest tens of seconds.
const BIAS_TRACKING_S: f64 = 30.0;

/// Standard deviation of the gyro bias at turn-on, rad/s; one recorded unit shows 0.020, -0.030 and
/// -0.011.
const TURN_ON_BIAS_RAD_S: f64 = 0.02;

/// The averaging windows of register 85. Calibrations and the rotation of the frame have no effect.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Processing {
    /// Windows of magnetometer, accelerometer and gyro in samples, and whether they apply to the
    /// uncompensated and to the compensated output.
    pub(crate) windows: [u32; 3],
    pub(crate) averages_uncompensated: [bool; 3],
    pub(crate) averages_compensated: [bool; 3],
}

/// All values of one tick, in single precision as in the sensor.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct SensorValues {
    /// Yaw, pitch, roll, deg.
    pub(crate) ypr_deg: [f32; 3],
    pub(crate) mag_gauss: [f32; 3],
    pub(crate) accel_m_s2: [f32; 3],
    pub(crate) gyro_rad_s: [f32; 3],
    pub(crate) uncompensated_mag_gauss: [f32; 3],
    pub(crate) uncompensated_accel_m_s2: [f32; 3],
    pub(crate) uncompensated_gyro_rad_s: [f32; 3],
    pub(crate) temperature_c: f32,
    pub(crate) pressure_kpa: f32,
}

impl SensorValues {
    /// The quaternion, with the scalar last.
    pub(crate) fn quaternion(&self) -> [f32; 4] {
        let [(sy, cy), (sp, cp), (sr, cr)] = self.ypr_deg.map(|angle| (f64::from(angle).to_radians() / 2.0).sin_cos());
        [
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        ]
        .map(|element| element as f32)
    }
}

/// Integrals since they were last read.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Deltas {
    pub(crate) time_s: f64,
    pub(crate) theta_deg: [f64; 3],
    pub(crate) velocity_m_s: [f64; 3],
}

/// One channel of the profile at 800 Hz.
#[derive(Debug, Clone)]
struct SensorChannel {
    truth: NoiseTruth,
    white: White,
    flicker: Processes,
    walk: RandomWalk,
    processes: Processes,
    line_phases_turns: Vec<f64>,
    slow: f64,
    steady: f64,
}

impl SensorChannel {
    fn new(profile: &Profile, number: usize, seed: u64) -> Self {
        let channel = &profile.channels[number];
        let rng = |component| random_stream(seed, number as u32, component);
        let (refresh_hz, delivered) = match number {
            0..3 => (ATTITUDE_REFRESH_HZ, 1),
            3..6 => (MAG_REFRESH_HZ, 1),
            _ => (IMU_REFRESH_HZ, DELIVERED_WINDOW),
        };
        let density = channel.noise.white_density;
        let (sigma, low_pass) = match channel.window {
            AveragingWindow::Boxcar { refresh_hz, low_pass, .. } => (density * f64::from(refresh_hz).sqrt(), low_pass),
            // stated for the output: the density that the sensor must have to give this output at the
            // rate of the profile
            AveragingWindow::None => (density * (profile.rate_hz * f64::from(delivered)).sqrt(), LowPass::NONE),
        };
        let instability = flicker(channel.noise.bias_instability, SLOW_INTERVAL_S);
        Self {
            truth: channel.noise.clone(),
            white: White::of_values(sigma, low_pass, refresh_hz, delivered, IMU_REFRESH_HZ, rng(NoiseComponent::White)),
            flicker: Processes::new(&instability, SLOW_INTERVAL_S, rng(NoiseComponent::Flicker)),
            walk: RandomWalk::new(channel.noise.random_walk, SLOW_INTERVAL_S, rng(NoiseComponent::Walk)),
            processes: Processes::new(&channel.noise.processes, seconds(1), rng(NoiseComponent::Processes)),
            line_phases_turns: channel.noise.line_phases_turns(rng(NoiseComponent::LinePhase)),
            slow: 0.0,
            steady: 0.0,
        }
    }

    fn advance(&mut self, tick: u64) {
        self.white.advance();
        if tick.is_multiple_of(SLOW_TICKS) {
            self.slow = self.flicker.advance() + self.walk.advance();
        }
        self.steady = self.truth.steady(seconds(tick), &self.line_phases_turns) + self.slow + self.processes.advance();
    }

    fn value(&self, averaged: bool) -> f64 {
        self.steady + if averaged { self.white.mean() } else { self.white.latest() }
    }
}

fn seconds(tick: u64) -> f64 {
    tick as f64 / f64::from(IMU_REFRESH_HZ)
}

/// The endless stream of the measurements of an emulated sensor, one tick of 1.25 ms at a time.
///
/// Reading values does not affect them.
#[derive(Debug, Clone)]
pub(crate) struct SensorModel {
    channels: [SensorChannel; 12],
    ticks: u64,
    turn_on_bias_rad_s: [f64; 3],
    /// The attitude filter's estimate of the gyro bias.
    pub(crate) bias_rad_s: [f64; 3],
    surroundings: Surroundings,
    thermal_bias: ThermalBias,
    /// The bias from the temperature on each axis.
    thermal_rad_s: f64,
    thermal_m_s2: f64,
    pub(crate) deltas: Deltas,
}

impl SensorModel {
    pub(crate) fn new(profile: &Profile, seed: u64) -> Self {
        let turn_on_bias_rad_s = [9, 10, 11]
            .map(|number| TURN_ON_BIAS_RAD_S * normal(&mut random_stream(seed, number, NoiseComponent::TurnOnBias)));
        Self {
            channels: std::array::from_fn(|number| SensorChannel::new(profile, number, seed)),
            ticks: 0,
            turn_on_bias_rad_s,
            bias_rad_s: turn_on_bias_rad_s,
            surroundings: Surroundings::new(profile.thermal, seed),
            thermal_bias: ThermalBias::new(profile.thermal),
            thermal_rad_s: 0.0,
            thermal_m_s2: 0.0,
            deltas: Deltas::default(),
        }
    }

    /// Executes one tick, with the windows of register 85.
    pub(crate) fn advance(&mut self, windows: [u32; 3]) {
        let tick = self.ticks;
        self.ticks += 1;
        for (channel, window) in self.channels[3..].iter_mut().zip(windows.into_iter().flat_map(|window| [window; 3])) {
            channel.white.set_window(window);
        }
        for channel in &mut self.channels {
            channel.advance(tick);
        }
        if tick.is_multiple_of(SLOW_TICKS) {
            self.surroundings.advance_to(seconds(tick));
            (self.thermal_rad_s, self.thermal_m_s2) = self.thermal_bias.advance_to(seconds(tick));
        }
        let interval_s = 1.0 / f64::from(IMU_REFRESH_HZ);
        self.deltas.time_s += interval_s;
        for axis in 0..3 {
            let rate_rad_s = self.gyro_rad_s(axis, false);
            self.deltas.theta_deg[axis] += rate_rad_s.to_degrees() * interval_s;
            self.deltas.velocity_m_s[axis] += self.accel_m_s2(axis, false) * interval_s;
            // a converged filter leaves the mean of the profile
            let residual_rad_s = rate_rad_s - self.channels[9 + axis].truth.mean - self.bias_rad_s[axis];
            self.bias_rad_s[axis] += residual_rad_s * interval_s / BIAS_TRACKING_S;
        }
    }

    pub(crate) fn measure(&self, processing: &Processing) -> SensorValues {
        let Processing { averages_uncompensated, averages_compensated, .. } = processing;
        let triad = |first: usize, averaged: bool| [0, 1, 2].map(|axis| self.channels[first + axis].value(averaged));
        let gyro = |averaged: bool| [0, 1, 2].map(|axis| self.gyro_rad_s(axis, averaged));
        let accel = |averaged: bool| [0, 1, 2].map(|axis| self.accel_m_s2(axis, averaged));
        SensorValues {
            ypr_deg: triad(0, false).map(wrapped_deg),
            mag_gauss: single(triad(3, averages_compensated[0])),
            accel_m_s2: single(accel(averages_compensated[1])),
            gyro_rad_s: single([0, 1, 2].map(|axis| gyro(averages_compensated[2])[axis] - self.bias_rad_s[axis])),
            uncompensated_mag_gauss: single(triad(3, averages_uncompensated[0])),
            uncompensated_accel_m_s2: single(accel(averages_uncompensated[1])),
            uncompensated_gyro_rad_s: single(gyro(averages_uncompensated[2])),
            temperature_c: self.surroundings.temperature_c as f32,
            pressure_kpa: self.surroundings.pressure_kpa as f32,
        }
    }

    fn gyro_rad_s(&self, axis: usize, averaged: bool) -> f64 {
        self.turn_on_bias_rad_s[axis] + self.thermal_rad_s + self.channels[9 + axis].value(averaged)
    }

    fn accel_m_s2(&self, axis: usize, averaged: bool) -> f64 {
        self.thermal_m_s2 + self.channels[6 + axis].value(averaged)
    }
}

pub(crate) fn single(value: [f64; 3]) -> [f32; 3] {
    value.map(|component| component as f32)
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
    // the open end itself, or a value rounded to it
    if wrapped as f32 == -180.0 { 180.0 } else { wrapped as f32 }
}

/// Number of the random stream of temperature and pressure, after those of the twelve channels.
const SURROUNDINGS_STREAM: u32 = 12;

/// The mean pressure; the weather changes it slowly, as a sine.
const PRESSURE_KPA: f64 = 101.325;
const WEATHER_KPA: f64 = 0.05;
const WEATHER_S: f64 = 7200.0;
const PRESSURE_SIGMA_KPA: f64 = 0.003;

/// The readings of the sensor's thermometer and barometer.
#[derive(Debug, Clone)]
pub(crate) struct Surroundings {
    thermal: Thermal,
    random: ChaCha8Rng,
    pub(crate) temperature_c: f64,
    pub(crate) pressure_kpa: f64,
}

impl Surroundings {
    /// The readings of a sensor that has just been switched on.
    pub(crate) fn new(thermal: Thermal, seed: u64) -> Self {
        Self {
            thermal,
            random: random_stream(seed, SURROUNDINGS_STREAM, NoiseComponent::White),
            temperature_c: thermal.temperature_c(0.0),
            pressure_kpa: PRESSURE_KPA,
        }
    }

    /// Reads both again, this many seconds after switching on.
    pub(crate) fn advance_to(&mut self, time_s: f64) {
        let weather = WEATHER_KPA * (TAU * time_s / WEATHER_S).sin();
        self.temperature_c = self.thermal.temperature_c(time_s) + self.thermal.noise_c * normal(&mut self.random);
        self.pressure_kpa = PRESSURE_KPA + weather + PRESSURE_SIGMA_KPA * normal(&mut self.random);
    }
}
