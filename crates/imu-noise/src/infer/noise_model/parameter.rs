//! The noise parameters: the components of the noise of a rate, and what is known of each.

use schemars::JsonSchema;
use serde::Serialize;

/// Probability, corrected for all slow terms and axes, up to which one of them is proved.
pub const PROVED_P: f64 = 0.03;

/// What is known of a noise parameter; `NotMeasurable` and `Moved` are set by the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// The term was detected; it has a value and a two-sided confidence interval.
    Estimated,
    /// The term was not detected and may be zero; only its upper bound is given.
    Bounded,
    /// The record does not show it, mostly because it is too short.
    NotObservable,
    /// The message does not carry it, however long the record.
    NotMeasurable,
    /// The sensor was moved, and what its deviation shows is the motion; a record at rest shows the
    /// parameter.
    Moved,
    /// No range of averaging times follows the noise model; N may still have an upper bound.
    ModelRejected,
}

/// A noise parameter, in the unit of its term.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Parameter {
    /// What is known.
    pub status: Status,
    /// The best value, where estimated.
    pub value: Option<f64>,
    /// Lower end of the interval, where estimated.
    pub lower: Option<f64>,
    /// Upper end of the interval, where estimated; the bound on the magnitude, where bounded.
    pub upper: Option<f64>,
    /// Probability that noise without this term would show as much of it; `None` if that was
    /// not tested.
    pub p: Option<f64>,
}

impl Parameter {
    /// A parameter of which nothing more is known than `status`.
    pub const fn without_value(status: Status) -> Self {
        Self { status, value: None, lower: None, upper: None, p: None }
    }

    /// A value with the interval from `lower` to `upper`.
    pub const fn estimated(value: f64, lower: f64, upper: f64) -> Self {
        Self { status: Status::Estimated, value: Some(value), lower: Some(lower), upper: Some(upper), p: None }
    }

    /// A bound from above.
    pub const fn bounded(upper: f64) -> Self {
        Self { upper: Some(upper), ..Self::without_value(Status::Bounded) }
    }

    /// The same, known to be no more than bounded: it may be absent after all. Without an end there is no bound.
    pub fn not_proved(self) -> Self {
        // of a ramp that falls the lower end is the larger magnitude
        let upper = self.lower.into_iter().chain(self.upper).map(f64::abs).reduce(f64::max);
        let status = if upper.is_some() { Status::Bounded } else { self.status };
        Self { status, value: None, lower: None, upper, ..self }
    }

    /// Half the width of the interval over the value; `None` without a value other than zero.
    pub fn relative_half_width(&self) -> Option<f64> {
        let half_width = (self.upper? - self.lower?) / 2.0;
        self.value.filter(|value| *value != 0.0).map(|value| (half_width / value).abs())
    }

    /// The same in a unit of which the present one is `factor`.
    pub fn scaled(self, factor: f64) -> Self {
        let scaled = |value: Option<f64>| value.map(|value| value * factor);
        Self { value: scaled(self.value), lower: scaled(self.lower), upper: scaled(self.upper), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_end_is_not_bounded() {
        let unseen = Parameter::without_value(Status::NotObservable);
        assert_eq!(unseen.not_proved(), unseen);
        assert_eq!(Parameter::estimated(2.0, 1.0, 3.0).not_proved(), Parameter::bounded(3.0));
    }
}
