//! The programs that take N and K: one row each, with what they are typed as, where the program's
//! own code says so, and the file it reads.
//!
//! A program's recursion decides what N and K are called: a variance per sample, a rate of change, a
//! continuous density. The tests propagate white noise and a walk through each recursion.

#[cfg(test)]
mod recursions;

use std::f64::consts::PI;

use vn100_analysis::Remedy;
use vn100_analysis::noise::{Sensor, Term};

use super::filter_noise::{FilterNoise, Missing, NotWritten};
use crate::printable;

/// A program that takes N and K of a gyroscope and an accelerometer.
#[derive(Debug, Clone, Copy)]
pub struct Consumer {
    /// The name that selects it, such as `vins`.
    pub name: &'static str,
    /// Its own name.
    pub title: &'static str,
    /// What the name of its file ends with.
    pub ending: &'static str,
    /// What N is typed as.
    pub white: Formula,
    /// What K is typed as; `None` for a program without a place for it.
    pub walk: Option<Formula>,
    /// The repository, its commit, and the lines of its code that use the numbers.
    pub code: &'static str,
    /// What else its user must know; may be empty.
    pub remark: &'static str,
    needs_rate: bool,
    /// The file, with a name between braces in the place of each number, and one line for comments.
    template: &'static str,
}

/// What a parameter is typed as.
#[derive(Debug, Clone, Copy)]
pub struct Formula {
    /// In words, such as `N sqrt(rate)`.
    pub text: &'static str,
    /// Units of the gyroscope and of the accelerometer.
    pub units: (&'static str, &'static str),
    /// Of the parameter in SI units and the sample rate in hertz.
    typed: fn(Sensor, f64, f64) -> f64,
}

/// The correlation time of KF-GINS' biases in seconds: a walk of less than that stays one.
const KF_GINS_CORRELATION_S: f64 = 4.0 * 3600.0;

const DEGREES: f64 = 180.0 / PI;
/// Milligals in one m/s².
const MILLIGAL: f64 = 1e5;

type Units = (&'static str, &'static str);

const fn formula(text: &'static str, units: Units, typed: fn(Sensor, f64, f64) -> f64) -> Formula {
    Formula { text, units, typed }
}

const N: Formula = formula("N", ("rad/s/sqrt(Hz)", "m/s^2/sqrt(Hz)"), |_, value, _| value);
const K: Formula = formula("K", ("rad/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)"), |_, value, _| value);
const VARIANCE_OF_A_SAMPLE: Formula =
    formula("N^2 rate", ("(rad/s)^2", "(m/s^2)^2"), |_, value, rate| value * value * rate);

impl Consumer {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self {
            name: "kalibr",
            title: "Kalibr",
            ending: ".imu.yaml",
            white: N,
            walk: Some(K),
            code: "ethz-asl/kalibr 1f602274, kalibr_common/ConfigReader.py:441-492, kalibr_imu_camera_calibration/IccSensors.py:628, 768",
            remark: "update_rate weighs the samples: that of the bag which is calibrated",
            needs_rate: true,
            template: include_str!("../../templates/kalibr.txt"),
        },
        Self {
            name: "openvins",
            title: "OpenVINS",
            ending: ".kalibr_imu_chain.yaml",
            white: N,
            walk: Some(K),
            code: "rpng/open_vins 69488123, ov_msckf/src/core/VioManagerOptions.h:159, ov_msckf/src/state/Propagator.cpp:463, 820",
            remark: "the matrices stand for an IMU without errors of scale and alignment",
            needs_rate: false,
            template: include_str!("../../templates/openvins.txt"),
        },
        Self {
            name: "gtsam",
            title: "GTSAM PreintegrationCombinedParams",
            ending: ".gtsam.py",
            white: formula("N^2", ("(rad/s)^2/Hz", "(m/s^2)^2/Hz"), |_, value, _| value * value),
            walk: Some(formula("K^2", ("(rad/s^2)^2/Hz", "(m/s^3)^2/Hz"), |_, value, _| value * value)),
            code: "borglab/gtsam 0ffe6c93, gtsam/navigation/CombinedImuFactor.cpp:164-178, ImuFactor.cpp:79",
            remark: "up to GTSAM 4.2 the default of biasAccOmegaInt adds white noise of density 1: it is set to 0",
            needs_rate: false,
            template: include_str!("../../templates/gtsam.txt"),
        },
        Self {
            name: "lio-sam",
            title: "LIO-SAM",
            ending: ".lio-sam.yaml",
            white: N,
            walk: Some(K),
            code: "TixiaoShan/LIO-SAM 0be1fbe6, src/imuPreintegration.cpp:215, 225, 374, include/utility.h:203",
            remark: "these four lines replace those of config/params.yaml",
            needs_rate: false,
            template: include_str!("../../templates/lio-sam.txt"),
        },
        Self {
            name: "vins",
            title: "VINS-Fusion, VINS-Mono",
            ending: ".vins.yaml",
            white: formula("N sqrt(2 rate)", ("rad/s", "m/s^2"), |_, value, rate| value * (2.0 * rate).sqrt()),
            walk: Some(formula("K sqrt(rate)", ("rad/s^2", "m/s^3"), |_, value, rate| value * rate.sqrt())),
            code: "HKUST-Aerial-Robotics/VINS-Fusion be55a937, VINS-Mono 90dabb5e, vins_estimator/src/factor/integration_base.h:31, 122 (22, 113)",
            remark: "a midpoint of two samples, taken as independent; K/sqrt(rate) would make the walk too small by the rate",
            needs_rate: true,
            template: include_str!("../../templates/vins.txt"),
        },
        Self {
            name: "fast-lio",
            title: "FAST-LIO, FAST-LIO2",
            ending: ".fast-lio.yaml",
            white: VARIANCE_OF_A_SAMPLE,
            walk: Some(formula("K^2 rate", ("(rad/s^2)^2", "(m/s^3)^2"), |_, value, rate| value * value * rate)),
            code: "hku-mars/FAST_LIO 7cc4175d, include/IKFoM_toolkit/esekfom/esekfom.hpp:381, src/IMU_Processing.hpp:280",
            remark: "right to half the scans per second over the rate (2.5 % at 200 Hz and 10 scans), since the end of a scan cuts a sample in two",
            needs_rate: true,
            template: include_str!("../../templates/fast-lio.txt"),
        },
        Self {
            name: "kf-gins",
            title: "KF-GINS",
            ending: ".kf-gins.yaml",
            white: formula("N in its units", ("deg/sqrt(h)", "m/s/sqrt(h)"), per_root_hour),
            walk: Some(formula("K sqrt(corrtime/2)", ("deg/h", "mGal"), gauss_markov)),
            code: "i2Nav-WHU/KF-GINS f39bc2e7, src/kf_gins.cpp:286, 342, src/kf-gins/gi_engine.cpp:47, 275-297",
            remark: "gbstd and abstd belong to a Gauss-Markov process, not to the bias instability; without initbgstd and initbastd it takes them for the bias at the start, which is far larger",
            needs_rate: false,
            template: include_str!("../../templates/kf-gins.txt"),
        },
        Self {
            name: "ros",
            title: "ROS sensor_msgs/Imu covariances",
            ending: ".ros-covariances.yaml",
            white: VARIANCE_OF_A_SAMPLE,
            walk: None,
            code: "ros2/common_interfaces c0c0bc57, sensor_msgs/msg/Imu.msg; cra-ros-pkg/robot_localization 1cb95337, src/ros_filter.cpp:588, src/ekf.cpp:128",
            remark: "at the rate of the published message; robot_localization replaces values below 1e-9 by 1e-9",
            needs_rate: true,
            template: include_str!("../../templates/ros.txt"),
        },
        Self {
            name: "gazebo",
            title: "Gazebo SDF",
            ending: ".gazebo.sdf",
            white: formula("N sqrt(update_rate)", ("rad/s", "m/s^2"), |_, value, rate| value * rate.sqrt()),
            walk: Some(K),
            code: "gazebosim/gz-sensors 9ba02f24, src/GaussianNoiseModel.cc:111-155",
            remark: "stddev belongs to this update_rate; without dynamic_bias_correlation_time there is no walk",
            needs_rate: true,
            template: include_str!("../../templates/gazebo.txt"),
        },
        Self {
            name: "matlab",
            title: "MATLAB imuSensor",
            ending: "_imu_sensor.m",
            white: N,
            walk: Some(K),
            code: "fusion.internal.IMUSensorSimulator (2017-2023), setStdDevWhiteNoise and setStdDevRandWalk",
            remark: "NoiseType \"double-sided\", the default, halves the variance of the white noise and doubles that of the walk",
            needs_rate: true,
            template: include_str!("../../templates/matlab.txt"),
        },
    ];

    /// The consumer with this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        const ALL: &[Consumer] = &Consumer::ALL;
        ALL.iter().find(|consumer| consumer.name == name)
    }

    /// Its own name, and what it takes N and K as.
    pub fn help(&self) -> String {
        let walk = self.walk.map_or_else(|| "no K".into(), |walk| format!("K as {}", walk.text));
        format!("{}: N as {}, {walk}", self.title, self.white.text)
    }

    /// The file for this program.
    ///
    /// # Errors
    /// [`NotWritten`] if the program needs a value that is not known.
    pub fn file(&self, noise: &FilterNoise) -> Result<String, NotWritten> {
        let terms: &[Term] = if self.walk.is_some() { &[Term::White, Term::RateRandomWalk] } else { &[Term::White] };
        let mut missing = noise.missing(terms)?;
        if self.needs_rate && noise.rate_hz.is_none() {
            missing.push(Missing {
                value: "the sample rate".into(),
                why: "the source does not contain it".into(),
                remedies: vec![Remedy::GiveRate(None)],
            });
        }
        if self.template.contains("{scale_factor_ppm}") && noise.scale_factor_ppm.is_none() {
            missing.push(Missing {
                value: "the error of the scale factor".into(),
                why: "a record at rest does not show it".into(),
                remedies: vec![Remedy::GiveScaleFactor],
            });
        }
        if !missing.is_empty() {
            return Err(NotWritten::Lacks(missing));
        }
        Ok(self.filled(noise, &self.comments(noise, terms)))
    }

    /// The template with its numbers, as every reader takes them for numbers, and a line for each comment.
    fn filled(&self, noise: &FilterNoise, comments: &[String]) -> String {
        let number = |value: Option<f64>| value.map_or_else(String::new, decimal);
        let [gyro_white, accel_white, gyro_walk, accel_walk] = self.typed_values(noise).map(number);
        let values = [
            ("{gyro_white}", gyro_white),
            ("{accel_white}", accel_white),
            ("{gyro_walk}", gyro_walk),
            ("{accel_walk}", accel_walk),
            ("{rate}", number(noise.rate_hz)),
            ("{scale_factor_ppm}", number(noise.scale_factor_ppm)),
            ("{topic}", noise.topic.as_deref().map_or_else(|| "/imu/data".into(), quoted)),
        ];
        let line = |line: &str| match line.contains("{comments}") {
            true => comments.iter().map(|text| comment_line(line, text)).collect(),
            false => values.iter().fold(format!("{line}\n"), |line, (name, value)| line.replace(name, value)),
        };
        self.template.lines().map(line).collect()
    }

    fn comments(&self, noise: &FilterNoise, terms: &[Term]) -> Vec<String> {
        let mut lines = vec![format!("{} by vn100", self.title)];
        lines.extend(noise.remarks(terms));
        lines.extend(noise.labels(terms));
        let walk = self.walk.map_or_else(String::new, |walk| format!(", K as {}", walk.text));
        lines.push(format!("N is typed as {}{walk}", self.white.text));
        let is_placeholder = noise.topic.is_none() && self.template.contains("{topic}");
        lines.extend(is_placeholder.then(|| "rostopic is a placeholder: type the topic of your sensor".to_owned()));
        lines.extend((!self.remark.is_empty()).then(|| self.remark.to_owned()));
        lines.push(format!("code: {}", self.code));
        lines
    }

    /// N of gyroscope and accelerometer and K of the two, as far as they are known and have a place.
    pub fn typed_values(&self, noise: &FilterNoise) -> [Option<f64>; 4] {
        let rate_hz = if self.needs_rate { noise.rate_hz } else { noise.rate_hz.or(Some(1.0)) };
        let number = |sensor, term, formula: Option<Formula>| {
            Some((formula?.typed)(sensor, noise.value(sensor, term)?, rate_hz?))
        };
        let (white, walk) = ((Term::White, Some(self.white)), (Term::RateRandomWalk, self.walk));
        let of =
            |(term, formula)| [Sensor::Gyroscope, Sensor::Accelerometer].map(|sensor| number(sensor, term, formula));
        let ([gyro_white, accel_white], [gyro_walk, accel_walk]) = (of(white), of(walk));
        [gyro_white, accel_white, gyro_walk, accel_walk]
    }
}

/// A comment in the line that the template has for it. Two dashes end a comment of XML.
fn comment_line(line: &str, text: &str) -> String {
    let is_xml = line.starts_with("<!--");
    let text = if is_xml { text.replace("--", "- -").trim_end_matches('-').to_owned() } else { text.to_owned() };
    format!("{}\n", line.replace("{comments}", &text))
}

/// In deg/√h and m/s/√h.
fn per_root_hour(sensor: Sensor, value: f64, _: f64) -> f64 {
    let unit = if sensor == Sensor::Gyroscope { DEGREES } else { 1.0 };
    value * unit * 60.0
}

/// The standard deviation of the Gauss-Markov process that begins as a walk of K, in deg/h and mGal.
fn gauss_markov(sensor: Sensor, value: f64, _: f64) -> f64 {
    let unit = if sensor == Sensor::Gyroscope { DEGREES * 3600.0 } else { MILLIGAL };
    value * (KF_GINS_CORRELATION_S / 2.0).sqrt() * unit
}

/// The name of a topic as a string of YAML: plain, as ROS names are, or between quotes.
fn quoted(topic: &str) -> String {
    let is_plain = topic.starts_with('/') && topic.chars().all(|c| c.is_ascii_alphanumeric() || "/_".contains(c));
    if is_plain { topic.to_owned() } else { format!("'{}'", printable(topic).replace('\'', "''")) }
}

/// As every YAML reader takes it for a number: with a point, and a sign in the exponent.
fn decimal(value: f64) -> String {
    if (1e-3..1e6).contains(&value.abs()) {
        // five digits, without trailing zeros
        let text = format!("{:.*}", (4 - value.abs().log10().floor() as i32).max(1) as usize, value);
        let short = text.trim_end_matches('0');
        return if short.ends_with('.') { format!("{short}0") } else { short.into() };
    }
    let text = format!("{value:.4e}");
    match text.split_once('e') {
        Some((_, exponent)) if exponent.starts_with('-') => text,
        Some((mantissa, exponent)) => format!("{mantissa}e+{exponent}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_numbers_in_every_yaml() {
        for (value, text) in
            [(40.0, "40.0"), (1.2634e-4, "1.2634e-4"), (0.0, "0.0000e+0"), (2e9, "2.0000e+9"), (0.002, "0.002")]
        {
            assert_eq!(decimal(value), text);
            assert_eq!(text.parse::<f64>().unwrap(), value);
        }
    }
}
