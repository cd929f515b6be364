//! The `imu.yaml` of Kalibr: noise density and random walk of each sensor, in continuous time and
//! SI units.
//!
//! Names and units as in the page "Yaml formats" of its documentation.

use thiserror::Error;
use vn100_analysis::noise::{Sensor, Status, Term};
use vn100_analysis::protocol::Quantity;
use vn100_analysis::{ChannelResult, LongTauValidity, SourceResult};

use crate::{printable, units::si_unit};

/// The time in seconds over which Kalibr integrates, where the user does not give one.
pub const DEFAULT_KALIBR_SPAN_S: f64 = 60.0;

/// The walk of this many B per √(averaging time) drifts over that time as flicker of B does.
const WALK_OF_FLICKER: f64 = 1.15;

/// Why no file for Kalibr can be written.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum KalibrError {
    /// The sensor was moved.
    #[error("the sensor was moved in this record, which shows none of its noise")]
    Moved,
    /// No value of an accelerometer or a gyroscope is known; the reasons.
    #[error("{}", .0.join("; "))]
    Nothing(Vec<String>),
    /// Only estimates were asked for; the values that are not estimated.
    #[error("not every value is estimated: {}", .0.join("; "))]
    NotEstimated(Vec<String>),
}

/// The lines of the file, and which of its values are bounds or missing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KalibrYaml {
    lines: Vec<String>,
    values: usize,
    bounds: Vec<String>,
    missing: Vec<String>,
    was_moved: bool,
}

/// A value of the file.
struct Value {
    value: f64,
    is_estimated: bool,
    /// What it is, with its axis.
    label: String,
}

impl KalibrYaml {
    /// For each sensor the values of its noisiest axis: N, and as the random walk the larger of K
    /// and 1.15 B/√span, the walk that drifts in `span_s` seconds as much as the bias instability.
    /// A value without an estimate is an upper bound; if there is no bound, the value is
    /// missing, with the reason.
    #[must_use]
    pub fn of(record: &SourceResult, span_s: f64) -> Self {
        let mut yaml = Self::default();
        let message = record.source.message.as_deref().unwrap_or("no message");
        let rate = record.timing.rate_hz.map_or_else(|| "an unknown rate".into(), |hz| format!("{hz} Hz"));
        yaml.comment(&format!(
            "{} samples of {message} at {rate}; upper bounds at a confidence of {}",
            record.timing.samples, record.confidence
        ));
        if record.motion.is_some() {
            yaml.was_moved = true;
            yaml.comment("no values: the sensor was moved in this record, which shows none of its noise");
            return yaml;
        }
        yaml.comment("continuous-time densities of the noisiest axis, as measured in this stream at this rate");
        yaml.comment(&format!("random walk: the larger of K and 1.15 B/sqrt({span_s} s)"));
        if record.source.compensated.is_none() {
            yaml.comment("whether the rates are bias-compensated is unknown; if they are, B and K are too small");
        }
        for (quantity, sensor, name) in [
            (Quantity::Acceleration, Sensor::Accelerometer, "accelerometer"),
            (Quantity::AngularRate, Sensor::Gyroscope, "gyroscope"),
        ] {
            yaml.sensor(&axes(record, quantity), (sensor, name), span_s);
        }
        // Kalibr reads no other type
        match record.source.bag.as_ref().filter(|bag| bag.type_name.ends_with("/Imu")) {
            Some(bag) => yaml.lines.push(format!("rostopic: {}", quoted(&bag.topic))),
            None => {
                yaml.comment("the topic of the sensor in the bag that Kalibr reads: put its name here");
                yaml.lines.push("rostopic: /imu/data".into());
            }
        }
        match record.timing.rate_hz {
            Some(hz) => yaml.lines.push(format!("update_rate: {}", decimal(hz))),
            None => yaml.comment("update_rate: unknown, put it here"),
        }
        yaml
    }

    /// The text of the file.
    #[must_use]
    pub fn text(&self) -> String {
        self.lines.join("\n") + "\n"
    }

    /// The missing values, each with the reason: Kalibr needs all four values.
    #[must_use]
    pub fn missing(&self) -> &[String] {
        &self.missing
    }

    /// Whether the file may be written; with `only_estimates` only if all values are estimated.
    ///
    /// # Errors
    /// [`KalibrError`] when the file may not be written.
    pub fn check(&self, only_estimates: bool) -> Result<(), KalibrError> {
        if self.was_moved {
            return Err(KalibrError::Moved);
        }
        if self.values == 0 {
            return Err(KalibrError::Nothing(self.missing.clone()));
        }
        let doubtful: Vec<String> = self.bounds.iter().chain(&self.missing).cloned().collect();
        if only_estimates && !doubtful.is_empty() { Err(KalibrError::NotEstimated(doubtful)) } else { Ok(()) }
    }

    fn comment(&mut self, text: &str) {
        // the name of a message comes from a file
        self.lines.push(format!("# {}", printable(text)));
    }

    fn sensor(&mut self, axes: &[&ChannelResult], (sensor, name): (Sensor, &str), span_s: f64) {
        let first = axes.first().and_then(|axis| axis.noise.as_ref());
        let no_walk = first.and_then(|noise| match noise.long_taus {
            LongTauValidity::Sensor => None,
            LongTauValidity::Compensated => {
                Some("B and K are not measurable in a bias-compensated message; record an uncompensated one")
            }
            LongTauValidity::LooksCompensated => {
                Some("a filter removes the bias from this stream, and B and K with it")
            }
            LongTauValidity::Surroundings | LongTauValidity::Motion => Some("B and K are not the sensor's"),
        });
        let absent = first.is_none().then_some("not in this capture");
        let unknown = "neither an estimate nor an upper bound; the record is too short";
        let key = format!("{name}_noise_density");
        self.value(&key, si_unit(sensor, Term::White), noisiest(axes, density), absent.unwrap_or(unknown));
        let walk = noisiest(axes, |axis| random_walk(axis, span_s)).filter(|_| no_walk.is_none());
        let why = absent.or(no_walk).unwrap_or(unknown);
        self.value(&format!("{name}_random_walk"), si_unit(sensor, Term::RateRandomWalk), walk, why);
    }

    fn value(&mut self, key: &str, unit: &str, value: Option<Value>, why_not: &str) {
        let Some(Value { value, is_estimated, label }) = value else {
            self.comment(&format!("{key}: missing, and Kalibr needs it:"));
            self.comment(&format!("  {why_not}"));
            self.missing.push(format!("{key}: {why_not}"));
            return;
        };
        self.comment(&format!("{key} in {unit}:"));
        self.comment(&format!("  {label}"));
        self.lines.push(format!("{key}: {}", decimal(value)));
        self.values += 1;
        if !is_estimated {
            self.bounds.push(format!("{key} is {label}"));
        }
    }
}

/// The axes of a sensor in the stream, none if its noise is not assessed; what was read from a
/// register between the samples has no noise parameters.
fn axes(record: &SourceResult, quantity: Quantity) -> Vec<&ChannelResult> {
    let axes: Vec<_> = record.streamed().filter(|channel| channel.quantity == quantity).collect();
    if axes.first().is_some_and(|axis| axis.noise.is_some()) { axes } else { Vec::new() }
}

/// The largest value of the axes; an axis without a value is named.
fn noisiest(axes: &[&ChannelResult], of: impl Fn(&ChannelResult) -> Option<Value>) -> Option<Value> {
    let unknown: Vec<&str> = axes.iter().filter(|axis| of(axis).is_none()).map(|axis| axis.name.as_str()).collect();
    let known = axes.iter().filter_map(|axis| of(axis)).max_by(|a, b| a.value.total_cmp(&b.value))?;
    let except = if unknown.is_empty() { String::new() } else { format!("; not known: {}", unknown.join(", ")) };
    Some(Value { label: known.label + &except, ..known })
}

/// The estimate of a parameter, or else its upper bound, and whether it is the first.
fn known(axis: &ChannelResult, term: Term) -> Option<(f64, bool)> {
    let parameter = axis.noise.as_ref()?.parameter(term)?;
    let estimate = parameter.value.filter(|_| parameter.status == Status::Estimated);
    estimate.map(|value| (value, true)).or_else(|| Some((parameter.upper?, false)))
}

fn density(axis: &ChannelResult) -> Option<Value> {
    let (value, is_estimated) = known(axis, Term::White)?;
    let status = if is_estimated { "estimated" } else { "upper bound, N is not estimated" };
    Some(Value { value, is_estimated, label: format!("N of {}: {status}", axis.name) })
}

/// Bias instability that was not detected says nothing beside a K that was.
fn random_walk(axis: &ChannelResult, span_s: f64) -> Option<Value> {
    let walk = known(axis, Term::RateRandomWalk);
    let flicker = known(axis, Term::BiasInstability);
    let flicker = flicker.map(|(b, is_estimated)| (WALK_OF_FLICKER * b / span_s.sqrt(), is_estimated));
    let flicker = flicker.filter(|(_, is_estimated)| *is_estimated || !walk.is_some_and(|(_, estimated)| estimated));
    let by_flicker = match (walk, flicker) {
        (Some((walk, _)), Some((flicker, _))) => flicker > walk,
        (walk, _) => walk.is_none(),
    };
    let (value, is_estimated) = if by_flicker { flicker? } else { walk? };
    let source = match (by_flicker, is_estimated) {
        (false, true) => "K of AXIS: estimated".to_owned(),
        (false, false) => "K of AXIS: random walk not detected; upper bound".to_owned(),
        (true, true) => format!("by bias instability of AXIS over {span_s} s: B estimated"),
        (true, false) => format!("by bias instability of AXIS over {span_s} s: B not detected; upper bound"),
    };
    Some(Value { value, is_estimated, label: source.replace("AXIS", &axis.name) })
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
