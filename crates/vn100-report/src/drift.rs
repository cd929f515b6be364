//! The drift while coasting, in words: of the vertical axis, and of the worst horizontal one.

use vn100_analysis::noise::{Sensor, Status};
use vn100_analysis::protocol::Quantity;
use vn100_analysis::{ChannelResult, DriftResult, Drifting, Finding, LongTauValidity, SourceResult, axes_name};

use crate::numbers::{
    duration,
    plain::{digits, span},
    trimmed,
};

/// What the drift rests on.
pub(crate) const ASSUMPTIONS: &str = "At rest, at constant temperature, level at the start, without an error of the scale factor; the bias is the mean over the rest before, as long as the coast if no other is named.";

const TOO_SHORT: &str = "not observable in a record of this length and rate";
const ROUNDED: &str = "rounding hides the noise";

/// The drifts of a kind, in the order of their coasts, of the axis that matters: for the heading the one
/// along gravity, for velocity and position the worst, which may be one of which nothing is known.
fn of_kind(result: &SourceResult, of: Drifting) -> Option<Vec<&DriftResult>> {
    let drifts = || result.drift.iter().filter(move |drift| drift.of == of);
    let unknown = drifts().find(|of| drifts().all(|other| other.axis != of.axis || other.std.is_none()));
    let largest = drifts().max_by(|a, b| a.std.unwrap_or(0.0).total_cmp(&b.std.unwrap_or(0.0)));
    let worst = unknown.or(largest)?;
    let vertical = vertical(result).filter(|_| of == Drifting::Angle && has_gravity(result));
    let axis = vertical.and_then(|axis| drifts().find(|drift| drift.axis == axis)).unwrap_or(worst).axis.as_str();
    Some(drifts().filter(|drift| drift.axis == axis).collect())
}

fn has_gravity(result: &SourceResult) -> bool {
    !result.warnings.iter().any(|warning| matches!(warning.finding, Finding::Gravity(_)))
}

/// The gyroscope's axis along the mean specific force.
fn vertical(result: &SourceResult) -> Option<String> {
    let force = |axis: &&ChannelResult| axis.statistics.mean.unwrap_or(0.0).abs();
    let axes = result.of(Quantity::Acceleration);
    let axis = axes.iter().max_by(|a, b| force(a).total_cmp(&force(b)))?;
    let letter = axis.name.rsplit('_').next()?;
    Some(format!("{}_{letter}", axes_name(Sensor::Gyroscope)))
}

/// One line for the heading and one for velocity and position, each value with its coast; none without
/// a drift, or if the sensor was moved.
pub(crate) fn lines(result: &SourceResult) -> Vec<String> {
    if result.motion.is_some() {
        return Vec::new();
    }
    if result.drift.is_empty() && !result.settings().coasts.is_empty() {
        return vec!["not given: it takes the Allan deviation of a gyroscope or an accelerometer".into()];
    }
    let axes = |of: Quantity| result.streamed().filter(move |axis| axis.quantity == of);
    let is_compensated = axes(Quantity::AngularRate)
        .filter_map(|axis| axis.noise.as_ref())
        .any(|noise| matches!(noise.long_taus, LongTauValidity::Compensated | LongTauValidity::LooksCompensated));
    let heading = of_kind(result, Drifting::Angle).map(|found| match values(&found) {
        Ok(text) => {
            let percent = trimmed(100.0 * result.confidence, 3);
            format!("{percent} % of heading errors ({}) within {text}", found[0].axis)
        }
        Err(Status::NotMeasurable) if is_compensated => "heading not measurable in a compensated message".into(),
        Err(Status::NotMeasurable) => format!("heading not measurable: {ROUNDED}"),
        Err(_) => format!("heading {TOO_SHORT}"),
    });
    let along = [(Drifting::Velocity, "velocity"), (Drifting::Position, "position")];
    let of_kind = |(of, name)| match values(&of_kind(result, of)?) {
        Ok(text) => Some(format!("{name} {text}")),
        Err(Status::NotMeasurable) if of == Drifting::Velocity && !is_compensated => Some(format!(
            "velocity not measurable: {}",
            match [Quantity::AngularRate, Quantity::Acceleration].map(|of| axes(of).count()) {
                [3, 3] if !has_gravity(result) => "the mean acceleration is not gravity",
                [3, 3] => ROUNDED,
                _ => "the tilt takes three gyroscopes and three accelerometers",
            }
        )),
        Err(_) => None,
    };
    let along: Vec<String> = along.into_iter().filter_map(of_kind).collect();
    heading.into_iter().chain((!along.is_empty()).then(|| along.join("; "))).collect()
}

/// The length of the coast, and of the rest unless it is as long.
pub(crate) fn coast(drift: &DriftResult) -> String {
    let length = |s: f64| if s.fract() == 0.0 { span(s, " ") } else { duration(s) };
    match length(drift.coast_s) {
        coast if drift.rest_s == drift.coast_s => coast,
        coast => format!("{coast} after {}", length(drift.rest_s)),
    }
}

/// Such as `0.05 deg (10 s), 0.4 (1 min)`.
fn values(drifts: &[&DriftResult]) -> Result<String, Status> {
    let known = drifts.iter().filter_map(|drift| Some((drift, drift.within?)));
    let value = |(place, (drift, within)): (usize, (&&DriftResult, f64))| {
        let unit = if place == 0 { format!(" {}", drift.unit) } else { String::new() };
        format!("{}{unit} ({})", digits(within, 2), coast(drift))
    };
    let texts: Vec<String> = known.enumerate().map(value).collect();
    match texts.is_empty() {
        true => Err(drifts.first().map_or(Status::NotObservable, |drift| drift.status)),
        false => Ok(texts.join(", ")),
    }
}
