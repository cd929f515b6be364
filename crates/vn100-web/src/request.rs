//! What the page says of a file and of its measurement.

use std::time::Duration;

use serde::Deserialize;
use vn100_analysis::Settings;
use vn100_capture::CaptureOptions;

/// A file, and what the user says of it; `None` for what is to be found in the file.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Request {
    /// Name of the file, without a folder.
    pub name: String,
    /// Sample rate in hertz.
    pub rate_hz: Option<f64>,
    /// Averaging window of gyroscope and accelerometer, in samples of the sensor.
    pub window: Option<u32>,
    /// The topic of a bag, or the columns of a table.
    pub topic: Option<String>,
    /// The map of the columns, as `gyro_x=wx:deg/s,t=stamp:ns`.
    pub columns: Option<String>,
    /// Whether the rates are compensated.
    pub compensated: Option<bool>,
    /// Data time that is excluded at the beginning, in seconds.
    pub skip_s: Option<f64>,
    /// Data time that is measured, in seconds.
    pub duration_s: Option<f64>,
    /// Name of a built-in data sheet.
    pub datasheet: Option<String>,
    /// Whether sentences without a checksum are accepted.
    pub accept_unchecked: bool,
}

impl Request {
    /// The settings of the measurement.
    ///
    /// # Errors
    /// In words, if a number cannot be used.
    pub(crate) fn settings(&self) -> Result<Settings, String> {
        let rate_hz = self.rate_hz.map(|hz| match hz {
            0.001..=100_000.0 => Ok(hz),
            hz => Err(format!("The sample rate is between 0.001 and 100 000 Hz, and not {hz} Hz.")),
        });
        let window = self.window.map(|window| match window {
            1..=800 => Ok(window),
            window => Err(format!("The averaging window is between 1 and 800 samples, and not {window}.")),
        });
        let time = |seconds: Option<f64>| {
            let wrong = |_| "A time is at least 0 s, and not longer than 30 000 years.".to_owned();
            seconds.map(|seconds| Duration::try_from_secs_f64(seconds).map_err(wrong)).transpose()
        };
        Ok(Settings {
            rate_hz: rate_hz.transpose()?,
            window: window.transpose()?,
            compensated: self.compensated,
            skip: time(self.skip_s)?.unwrap_or_default(),
            duration: time(self.duration_s)?.filter(|duration| !duration.is_zero()),
            ..Settings::default()
        })
    }

    /// What the user says of the content of the file.
    ///
    /// # Errors
    /// In words, if the map of the columns cannot be read.
    pub(crate) fn capture_options(&self) -> Result<CaptureOptions, String> {
        let columns = self.columns.as_ref().map(|map| map.parse()).transpose();
        let columns = columns.map_err(|error| format!("The columns cannot be read: {error}"))?;
        Ok(CaptureOptions { columns, topic: self.topic.clone(), ..CaptureOptions::default() })
    }

    /// What was asked, for the report.
    pub(crate) fn asked(&self) -> String {
        let time = |seconds: Option<f64>| seconds.map(|seconds| format!("{seconds} s"));
        let asked = [
            ("rate", self.rate_hz.map(|hz| format!("{hz} Hz"))),
            ("estimator", Some("strided".into())),
            ("deviation", Some("allan".into())),
            ("skip", time(self.skip_s)),
            ("duration", time(self.duration_s)),
            ("datasheet", self.datasheet.clone()),
            ("topic", self.topic.clone()),
            ("window", self.window.map(|window| window.to_string())),
            ("unchecked sentences", self.accept_unchecked.then(|| "accepted".into())),
        ];
        let said = asked.into_iter().filter_map(|(name, value)| Some(format!("{name} {}", value?)));
        said.collect::<Vec<_>>().join(", ")
    }
}
