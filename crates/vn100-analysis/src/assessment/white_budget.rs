//! What N is uncertain by, and the N of the sensor itself.

use imu_noise::timebase::TimebaseSummary;
use imu_noise::{Parameter, Status};
use schemars::JsonSchema;
use serde::Serialize;

use super::{Onboard, WindowFrom};
use crate::snapshot::{RateFrom, Snapshot};

/// What N is uncertain by, each part relative to it; null if a part is not known. The scale factor of
/// the sensor is no part: a record at rest does not show it, and its relative error is that of N too.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema, Serialize)]
pub struct WhiteBudget {
    /// Randomness of the record: how far the interval of the fit reaches below and above the value.
    pub sampling: Option<(f64, f64)>,
    /// Sample rate.
    pub rate: RateShare,
    /// What averaging and decimation on board add to the noise of the sensor.
    pub aliasing: Option<Aliasing>,
}

/// What the sample rate adds to the uncertainty of N.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema, Serialize)]
pub struct RateShare {
    /// Source of the nominal rate.
    pub from: RateFrom,
    /// How far N may be off for it, relative: half of what the rate may be, as N² is a variance
    /// times a time. The rate may be off by what the arrival times differ from the nominal one, and
    /// by their own spread (99th percentile of the intervals less the median) over the record; the
    /// clock that they were taken by is not verified. `None` without arrival times.
    pub relative: Option<f64>,
}

/// The effect of averaging and decimation on board on white noise: N in the stream over that of the
/// sensor.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema, Serialize)]
pub struct Aliasing {
    /// Factor with the window as known or by default.
    pub factor: f64,
    /// How far the factor may be off, relative, for the own roll-off of the sensor; null if the window
    /// is not known.
    pub relative: Option<f64>,
    /// Source of the averaging window.
    pub window_from: WindowFrom,
    /// Factor without any averaging, the largest of any window.
    #[serde(rename = "largest_factor")]
    pub most: f64,
}

impl WhiteBudget {
    pub(super) fn new(fitted: Option<Parameter>, snapshot: &Snapshot, onboard: Option<Onboard>) -> Self {
        let sampling = |white: Parameter| {
            let value = white.value.filter(|value| *value > 0.0)?;
            Some((1.0 - white.lower? / value, white.upper? / value - 1.0))
        };
        let measured = |arrivals: TimebaseSummary| {
            let off = (arrivals.measured_hz? / snapshot.timing.rate_hz - 1.0).abs();
            let times = arrivals.arrivals?;
            let spread_s = times.p99_us.saturating_sub(times.p50_us) as f64 * 1e-6;
            let relative = (off + spread_s / snapshot.timing.duration_s()) / 2.0;
            relative.is_finite().then_some(relative)
        };
        let aliasing = |onboard: Onboard| Aliasing {
            factor: onboard.window.white_factor(),
            relative: onboard.window_known().then(|| Onboard::uncertainty_of(onboard.window)),
            window_from: onboard.window_from,
            most: onboard.window.decimation.max(1.0).sqrt(),
        };
        Self {
            sampling: fitted.and_then(sampling),
            rate: RateShare { from: snapshot.timing.rate_from, relative: snapshot.arrivals.and_then(measured) },
            aliasing: onboard.map(aliasing),
        }
    }

    /// The interval of the fit, widened by what is known of the time scale.
    pub(super) fn widened(&self, white: Parameter) -> Parameter {
        let relative = self.rate.relative.unwrap_or(0.0);
        Parameter {
            lower: white.lower.map(|lower| lower * (1.0 - relative).max(0.0)),
            upper: white.upper.map(|upper| upper * (1.0 + relative)),
            ..white
        }
    }

    /// `white` as the sensor itself has it, without what aliasing adds. Where the window is not
    /// known any may have been set: between no averaging and no aliasing it is bounded only.
    pub(super) fn unaliased(&self, white: Parameter) -> Parameter {
        let bounded = |lower| Parameter { value: None, lower, status: bounded(white.status), ..white };
        match self.aliasing {
            Some(Aliasing { factor, relative: Some(relative), .. }) => Parameter {
                value: white.value.map(|value| value / factor),
                lower: white.lower.map(|lower| lower / (factor * (1.0 + relative))),
                upper: white.upper.map(|upper| upper / (factor * (1.0 - relative))),
                ..white
            },
            Some(Aliasing { most, .. }) => bounded(white.lower.map(|lower| lower / most)),
            None => bounded(None),
        }
    }
}

fn bounded(status: Status) -> Status {
    if status == Status::Estimated { Status::Bounded } else { status }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn budget(window_from: WindowFrom, relative: Option<f64>) -> WhiteBudget {
        let uncertainty = (window_from != WindowFrom::Default).then_some(0.1);
        let aliasing = Some(Aliasing { factor: 2.0, relative: uncertainty, window_from, most: 4.0 });
        WhiteBudget { sampling: None, rate: RateShare { from: RateFrom::Option, relative }, aliasing }
    }

    fn close(found: Option<f64>, expected: f64) {
        assert!((found.unwrap() / expected - 1.0).abs() < 1e-12, "{found:?}, not {expected}");
    }

    #[test]
    fn a_rate_that_is_off_widens_both_ends() {
        let white = Parameter::estimated(10.0, 9.0, 11.0);
        assert_eq!(budget(WindowFrom::Register, None).widened(white), white);
        let widened = budget(WindowFrom::Register, Some(0.01)).widened(white);
        close(widened.lower, 8.91);
        close(widened.upper, 11.11);
        assert_eq!(widened.value, white.value);
        close(budget(WindowFrom::Register, Some(0.01)).widened(Parameter::bounded(10.0)).upper, 10.1);
    }

    #[test]
    fn the_sensors_own_density_is_known_as_well_as_the_window() {
        let white = Parameter::estimated(10.0, 9.0, 11.0);
        for from in [WindowFrom::Register, WindowFrom::Given] {
            let own = budget(from, None).unaliased(white);
            close(own.value, 5.0);
            close(own.lower, 9.0 / 2.2);
            close(own.upper, 11.0 / 1.8);
            assert_eq!(own.status, Status::Estimated);
        }
        let own = budget(WindowFrom::Default, None).unaliased(white);
        assert_eq!((own.status, own.value, own.lower, own.upper), (Status::Bounded, None, Some(2.25), Some(11.0)));
        let nothing_known = WhiteBudget { aliasing: None, ..budget(WindowFrom::Default, None) };
        let own = nothing_known.unaliased(white);
        assert_eq!((own.status, own.value, own.lower, own.upper), (Status::Bounded, None, None, Some(11.0)));
        let unseen = Parameter::without_value(Status::NotObservable);
        assert_eq!(nothing_known.unaliased(unseen), unseen);
    }
}
