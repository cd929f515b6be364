//! The truth of an emulated sensor, from a document of a measurement or from one of two built-in ones.

use serde_json::Value;
use thiserror::Error;

use crate::{
    noise::{NoiseTruth, Vibration},
    onboard::{AveragingWindow, LowPass},
    thermal::Thermal,
};

/// One channel: its truth, and the path of its white noise to the output.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
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
}

/// There is no profile of that name.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("unknown noise profile {:?}: use one of {}", .0, Profile::NAMES.join(", "))]
pub struct UnknownProfile(String);

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

    /// The profile with that name.
    ///
    /// # Errors
    /// [`UnknownProfile`] for any other than [`Profile::NAMES`].
    pub fn named(name: &str) -> Result<Self, UnknownProfile> {
        match name {
            "datasheet" => Ok(Self::datasheet()),
            "lab3" => Ok(Self::lab3()),
            _ => Err(UnknownProfile(name.to_owned())),
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

    /// The twin of a measured sensor, by the JSON document of its result: mean, N, B, K, R, the
    /// strongest spectral line and the resolution of each axis. What was not detected is absent. If
    /// the averaging window is known, N is that of the sensor before it; else that of the stream.
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
        for (place, name) in NAMES.iter().enumerate() {
            if let Some(channel) = channels.iter().find(|channel| named(channel) == *name) {
                profile.channels[place] = ChannelProfile::like(channel, rate_hz)?;
            }
        }
        if profile.absent().count() == NAMES.len() {
            return refused("it has no channel of a gyroscope, an accelerometer or a magnetometer");
        }
        Ok(profile)
    }

    /// The names of the channels without noise.
    pub fn absent(&self) -> impl Iterator<Item = &'static str> {
        let channels = NAMES.into_iter().zip(&self.channels);
        channels.filter(|(_, channel)| channel.noise.white_density == 0.0).map(|(name, _)| name)
    }
}

fn named(part: &Value) -> &str {
    part["name"].as_str().unwrap_or_default()
}

impl ChannelProfile {
    fn like(channel: &Value, rate_hz: f64) -> Result<Self, NoTwin> {
        let (noise, onboard, statistics) = (&channel["noise"], &channel["onboard"], &channel["statistics"]);
        let number = |value: &Value| value.as_f64().unwrap_or(0.0);
        let detected = |term: &str| number(&noise[term]["value"]);
        let line = |line: &Value| Vibration {
            amplitude: number(&line["amplitude"]),
            frequency_hz: number(&line["frequency_hz"]),
        };
        let lines = channel["spectrum"]["lines"].as_array().into_iter().flatten().map(line);
        let mut truth = NoiseTruth {
            mean: number(&statistics["mean"]),
            // an angle has no parameters
            white_density: number(&statistics["std"]) / rate_hz.sqrt(),
            bias_instability: detected("bias_instability"),
            random_walk: detected("rate_random_walk"),
            ramp: detected("rate_ramp"),
            line: lines.max_by(|a, b| a.amplitude.total_cmp(&b.amplitude)),
            resolution: number(&statistics["resolution"]),
        };
        if noise.is_null() {
            return Ok(Self { noise: truth, window: AveragingWindow::None });
        }
        let white = &noise["white"];
        let own = white["budget"]["unaliased"]["value"].as_f64();
        let window = own.zip(onboard["refresh_hz"].as_f64()).map(|(own, refresh_hz)| {
            truth.white_density = own;
            let low_pass = &onboard["low_pass"];
            AveragingWindow::Boxcar {
                refresh_hz: refresh_hz as u32,
                samples: number(&onboard["window"]["length"]) as u32,
                low_pass: LowPass { a1: number(&low_pass[0]), a2: number(&low_pass[1]) },
            }
        });
        if window.is_none() {
            let unknown = || NoTwin(format!("N of {} is not known: record longer, at rest", named(channel)));
            truth.white_density = white["value"].as_f64().ok_or_else(unknown)?;
        }
        Ok(Self { noise: truth, window: window.unwrap_or_default() })
    }
}
