//! The truth of an emulated sensor, from a document of a measurement or from one of two built-in ones.

use serde_json::Value;
use thiserror::Error;

use crate::{
    noise::{GaussMarkov, NoiseTruth, Vibration},
    onboard::{AveragingWindow, LowPass},
    thermal::Thermal,
};

/// One channel: its truth, and the path of its white noise to the output.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ChannelProfile {
    /// Mean and noise.
    pub noise: NoiseTruth,
    /// Whether the white noise density is that of the output, or that of the sensor before a
    /// window.
    pub window: AveragingWindow,
}

/// The truth of an emulated sensor. The default is one that always reads zero.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Profile {
    /// The name that selects it, or that of the measured source.
    pub name: String,
    /// The rate in hertz of the stream that it describes; the white noise of channels without a
    /// window belongs to this rate. 0 if nothing is described.
    pub rate_hz: f64,
    /// In the order of `$VNYMR`: yaw, pitch, roll (deg), magnetic field x y z (gauss), acceleration
    /// x y z (m/s²), angular rate x y z (rad/s).
    pub channels: [ChannelProfile; 12],
    /// Temperature of the sensor, and the bias that depends on it.
    pub thermal: Thermal,
    /// Measured channels without slow noise, as a change of the level posed as it.
    pub changing: Vec<&'static str>,
}

/// Why a document describes no sensor that can be emulated, and what would.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct NoTwin(String);

/// Names of the channels, in the order of a profile.
const NAMES: [&str; 12] =
    ["yaw", "pitch", "roll", "mag_x", "mag_y", "mag_z", "accel_x", "accel_y", "accel_z", "gyro_x", "gyro_y", "gyro_z"];

impl Profile {
    /// The names that [`Profile::named`] knows.
    pub const NAMES: [&'static str; 2] = ["datasheet", "lab3"];

    /// The profile with that name; `None` for any other than [`Profile::NAMES`].
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "datasheet" => Some(Self::datasheet()),
            "lab3" => Some(Self::lab3()),
            _ => None,
        }
    }

    /// A sensor with the figures of its data sheet, with the factory default of the averaging window:
    /// at 40 Hz the output of gyro and accelerometer has 2.24 times the density of the sensor (see
    /// [`AveragingWindow`]). The sheet states no random walk, so there is none.
    pub fn datasheet() -> Self {
        // a test reads both
        Self::like(include_str!("../profiles/datasheet.json")).unwrap_or_default()
    }

    /// A published sensor at rest, 40 Hz; densities are those of the output, and no window applies.
    pub fn lab3() -> Self {
        Self::like(include_str!("../profiles/lab3.json")).unwrap_or_default()
    }

    /// The twin of a measured sensor, by the JSON document of its result: mean, N, B, K, R, correlated
    /// noise, spectral lines and resolution of each axis, level and noise of the temperature. B, K and
    /// correlated noise that are not proved are the likeliest ones. Steps, warm-ups, cycles and the
    /// influence of the temperature are absent. If the averaging window is known, N is that of the
    /// sensor before it; else that of the stream, behind a low pass where one is proved.
    ///
    /// # Errors
    /// [`NoTwin`] if the text is no document of a result, or does not show the noise of the sensor: it
    /// was moved, its rates are bias-compensated, the rate or an N is not known, or it has no axis.
    pub fn like(document: &str) -> Result<Self, NoTwin> {
        let refused = |text: &str| Err(NoTwin(text.into()));
        let document: Value = serde_json::from_str(document).unwrap_or_default();
        let (Some(channels), source) = (document["channels"].as_array(), &document["source"]) else {
            return refused("it is no document of a measurement");
        };
        let is_compensated = |channel: &&Value| {
            let kind = channel["noise"]["long_taus"].as_str().unwrap_or_default();
            named(channel).starts_with("gyro") && kind.contains("compensated")
        };
        if source["compensated"] == true || channels.iter().any(|channel| is_compensated(&channel)) {
            let text = "a filter has removed the bias of the angular rates, whose noise the record does not show: record an \
                        uncompensated message, such as VNIMU";
            return refused(text);
        }
        if !document["motion"].is_null() {
            return refused("the sensor was moved: record it at rest");
        }
        let Some(rate_hz) = document["timing"]["rate_hz"].as_f64().filter(|rate_hz| *rate_hz > 0.0) else {
            return refused("its sample rate is not known");
        };
        let mut profile = Self { name: named(source).to_owned(), rate_hz, ..Self::default() };
        for (place, name) in NAMES.into_iter().enumerate() {
            let Some(channel) = channels.iter().find(|channel| named(channel) == name) else { continue };
            profile.channels[place] = ChannelProfile::like(channel, rate_hz)?;
            let is_changing = ["level-change", "temperature"].map(Value::from).contains(&channel["noise"]["withheld"]);
            profile.changing.extend(is_changing.then_some(name));
        }
        if let Some(channel) = channels.iter().find(|channel| named(channel) == "temperature") {
            profile.thermal = Thermal::like(channel);
        }
        if profile.absent().count() == NAMES.len() {
            return refused("it has no channel of a gyroscope, an accelerometer or a magnetometer");
        }
        Ok(profile)
    }

    /// The names of the channels without noise.
    pub fn absent(&self) -> impl Iterator<Item = &'static str> {
        let channels = NAMES.into_iter().zip(&self.channels);
        let is_absent = |noise: &NoiseTruth| noise.white_density == 0.0 && noise.processes.is_empty();
        channels.filter(move |(_, channel)| is_absent(&channel.noise)).map(|(name, _)| name)
    }
}

fn named(part: &Value) -> &str {
    part["name"].as_str().unwrap_or_default()
}

/// The elements of an array of a document; none if it has no such array.
fn elements(array: &Value) -> impl Iterator<Item = &Value> {
    array.as_array().into_iter().flatten()
}

/// A number of a document; 0 if it is not known.
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(0.0)
}

impl Thermal {
    /// The level of a temperature, and the noise of its readings.
    fn like(channel: &Value) -> Self {
        let noise_c = number(&channel["allan"]["points"][0]["deviation"]);
        Self { noise_c, ..Self::warm_at(number(&channel["statistics"]["mean"])) }
    }
}

impl ChannelProfile {
    fn like(channel: &Value, rate_hz: f64) -> Result<Self, NoTwin> {
        let (noise, statistics) = (&channel["noise"], &channel["statistics"]);
        let truth = NoiseTruth {
            mean: number(&statistics["mean"]),
            resolution: number(&statistics["resolution"]),
            ..NoiseTruth::default()
        };
        if noise.is_null() {
            // an angle has no parameters
            let white_density = number(&statistics["std"]) / rate_hz.sqrt();
            return Ok(Self { noise: NoiseTruth { white_density, ..truth }, window: AveragingWindow::None });
        }
        let likeliest = &noise["likeliest"];
        let slow = |term: &str| noise[term]["value"].as_f64().unwrap_or(number(&likeliest[term]));
        let process = |process: &Value| GaussMarkov {
            correlation_time_s: number(&process["correlation_time_s"]),
            sigma: number(&process["sigma"]),
        };
        let line = |line: &Value| Vibration {
            amplitude: number(&line["amplitude"]),
            frequency_hz: number(&line["frequency_hz"]),
        };
        let slow_and_lines = NoiseTruth {
            bias_instability: slow("bias_instability"),
            random_walk: slow("rate_random_walk"),
            ramp: number(&noise["rate_ramp"]["value"]),
            processes: elements(&likeliest["processes"]).map(process).collect(),
            lines: elements(&channel["spectrum"]["lines"]).map(line).collect(),
            ..truth
        };
        let unknown = || NoTwin(format!("N of {} is not known: record longer, at rest", named(channel)));
        slow_and_lines.with_white(channel, rate_hz).ok_or_else(unknown)
    }
}

impl NoiseTruth {
    /// With the white noise of an axis behind its filters; `None` if N is not known.
    fn with_white(self, channel: &Value, rate_hz: f64) -> Option<ChannelProfile> {
        let (white, onboard) = (&channel["noise"]["white"], &channel["onboard"]);
        let density = white["value"].as_f64();
        // the measured N has the noise of rounding in it, which the twin adds anew
        let rounding = density.map_or(0.0, |density| self.resolution.powi(2) / (12.0 * rate_hz * density.powi(2)));
        let unrounded = (1.0 - rounding).max(0.0).sqrt();
        let own = white["budget"]["unaliased"]["value"].as_f64();
        if let Some((own, refresh_hz)) = own.zip(onboard["refresh_hz"].as_f64()) {
            let low_pass = &onboard["low_pass"];
            let window = AveragingWindow::Boxcar {
                refresh_hz: refresh_hz as u32,
                samples: number(&onboard["window"]["length"]) as u32,
                low_pass: LowPass { a1: number(&low_pass[0]), a2: number(&low_pass[1]) },
            };
            return Some(ChannelProfile { noise: Self { white_density: own * unrounded, ..self }, window });
        }
        let mut noise = Self { white_density: density? * unrounded, ..self };
        if let Some(samples) = channel["noise"]["correlation_samples"].as_f64() {
            noise.filter_white(samples, rate_hz);
        }
        Some(ChannelProfile { noise, window: AveragingWindow::None })
    }

    /// White noise behind a low pass of first order that correlates it over so many samples: a process.
    fn filter_white(&mut self, samples: f64, rate_hz: f64) {
        let correlation_time_s = 1.0 / (rate_hz * ((samples + 1.0) / (samples - 1.0)).ln());
        let sigma = self.white_density * (rate_hz / samples).sqrt();
        self.processes.push(GaussMarkov { correlation_time_s, sigma });
        self.white_density = 0.0;
    }
}
