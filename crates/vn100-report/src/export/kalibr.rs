//! The file that Kalibr takes: white noise and random walk of each sensor, in continuous time and
//! SI units.
//!
//! Names and units as in the page "Yaml formats" of its documentation.

use thiserror::Error;
use vn100_analysis::noise::{Sensor, Status, Term, over_bound};
use vn100_analysis::protocol::Quantity;

use crate::{
    findings::{Findings, Largest, SensorFindings},
    measured::Record,
    units::{ChannelValues, si_unit},
};

/// No file for Kalibr: it needs every figure, and a guess would pass for a measurement.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum KalibrError {
    /// The sensor was moved.
    #[error("the sensor was moved in this record, and its noise is not seen")]
    Moved,
    /// A figure is not known; why, for each.
    #[error("{}", .0.join("; "))]
    Lacks(Vec<String>),
}

/// The lines of the file, and what it lacks.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KalibrYaml {
    lines: Vec<String>,
    lacks: Vec<String>,
    was_moved: bool,
}

impl KalibrYaml {
    /// Of each sensor the worst axis. Where its random walk is not estimated, `with_over_bound` the
    /// white noise and the random walk that together lie above the whole curve of every axis.
    #[must_use]
    pub fn of(record: &Record<'_>, with_over_bound: bool) -> Self {
        let snapshot = &record.measured.snapshot;
        let mut yaml = Self::default();
        let message = snapshot.layout.as_ref().map_or("no message", |layout| &layout.message);
        yaml.comment(&format!(
            "{} samples of {message} at {} Hz; intervals at {}",
            snapshot.timing.samples, snapshot.timing.rate_hz, record.measured.assessment.confidence
        ));
        let findings = Findings::of(record);
        if findings.motion.is_some() {
            yaml.was_moved = true;
            yaml.comment("nothing for a filter: the sensor was moved, and its noise is not seen");
            return yaml;
        }
        yaml.comment("continuous-time densities of this stream at this rate, as measured: nothing is divided out");
        for (quantity, sensor, name) in [
            (Quantity::Acceleration, Sensor::Accelerometer, "accelerometer"),
            (Quantity::AngularRate, Sensor::Gyroscope, "gyroscope"),
        ] {
            let axes = record.of(quantity);
            yaml.sensor(&axes, findings.sensor(sensor), (sensor, name), with_over_bound);
        }
        yaml.lines.push("rostopic: /imu/data".into());
        yaml.lines.push(format!("update_rate: {}", decimal(snapshot.timing.rate_hz)));
        yaml
    }

    /// The file.
    #[must_use]
    pub fn text(&self) -> String {
        self.lines.join("\n") + "\n"
    }

    /// Whether it can be used.
    ///
    /// # Errors
    /// Where a figure is not known.
    pub fn complete(&self) -> Result<(), KalibrError> {
        if self.was_moved {
            return Err(KalibrError::Moved);
        }
        if self.lacks.is_empty() { Ok(()) } else { Err(KalibrError::Lacks(self.lacks.clone())) }
    }

    fn comment(&mut self, text: &str) {
        self.lines.push(format!("# {text}"));
    }

    fn figure(&mut self, name: &str, value: f64) {
        self.lines.push(format!("{name}: {}", decimal(value)));
    }

    fn sensor(
        &mut self,
        axes: &[&ChannelValues],
        found: Option<&SensorFindings>,
        (sensor, name): (Sensor, &str),
        with_over_bound: bool,
    ) {
        let (white_name, walk_name) = (format!("{name}_noise_density"), format!("{name}_random_walk"));
        let white = found.and_then(|found| found.largest(|axis| axis.white));
        let walk = found.and_then(|found| found.largest(|axis| axis.random_walk));
        let estimated = |yaml: &mut Self, what: &str, worst: &Largest<'_>, term, figure: &str| {
            yaml.comment(&format!("{name}: {what} of {}, in {}", worst.named(), si_unit(sensor, term)));
            yaml.figure(figure, worst.value);
        };
        if let (Some(white), Some(walk)) = (&white, &walk) {
            estimated(self, "white noise", white, Term::White, &white_name);
            estimated(self, "random walk", walk, Term::RateRandomWalk, &walk_name);
            return;
        }
        let reason = match white {
            None => format!("the white noise of the {name} is not estimated"),
            Some(_) => format!("the random walk of the {name} is {} in this record", why_no_walk(axes)),
        };
        if let Some((white_bound, walk_bound)) = with_over_bound.then(|| above_all(axes)).flatten() {
            self.comment(&format!("{name}: {reason}. The next two are no estimates: together they"));
            self.comment("lie above the upper bounds of the whole curve of every axis, and make a filter careful");
            if let Some(worst) = white {
                let value = decimal(worst.value);
                self.comment(&format!("({}, has an estimated white noise of {value} alone)", worst.named()));
            }
            self.figure(&white_name, white_bound);
            self.figure(&walk_name, walk_bound);
            return;
        }
        match white {
            Some(white) => estimated(self, "white noise", &white, Term::White, &white_name),
            None => self.comment(&format!("{white_name}: not known")),
        }
        self.comment(&format!("{walk_name}: not known, {reason}"));
        self.lacks.push(reason);
    }
}

fn why_no_walk(axes: &[&ChannelValues]) -> &'static str {
    let first = axes.iter().find_map(|axis| axis.noise.as_ref()?.parameter(Term::RateRandomWalk));
    match first.map(|parameter| parameter.status) {
        Some(Status::Bounded) => "only bounded from above",
        Some(Status::NotMeasurable) => "not measurable",
        Some(Status::ModelRejected) => "not estimated, no model fits",
        Some(Status::Estimated | Status::NotObservable) => "not observable",
        None => "not known",
    }
}

fn above_all(axes: &[&ChannelValues]) -> Option<(f64, f64)> {
    let bounds = axes.iter().filter_map(|axis| {
        let known = axis.octaves.iter().filter(|point| point.is_known());
        let (tau_s, upper): (Vec<f64>, Vec<f64>) = known.filter_map(|point| Some((point.tau_s, point.upper?))).unzip();
        over_bound(&tau_s, &upper)
    });
    bounds.map(|bound| (bound.white, bound.rate_random_walk)).reduce(|a, b| (a.0.max(b.0), a.1.max(b.1)))
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
