//! A fitted parameter against a data sheet's claim, by the interval, never by the point.

use super::noise_model::{Parameter, Status};
use schemars::JsonSchema;
use serde::Serialize;

/// What a data sheet claims of a parameter, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Claim {
    /// No sensor is worse.
    Limit(f64),
    /// Many sensors lie from here to there; not a guarantee.
    Typical {
        /// Lower end.
        from: f64,
        /// Upper end; the same for a single value.
        to: f64,
        /// How far either may be rounded: half a unit of the last printed place of a single value,
        /// because a maker prints 0.00354 as 0.0035, too. The ends of a range are taken as printed.
        rounding: f64,
    },
}

impl Claim {
    /// The code of the claim in results.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Limit(_) => "limit",
            Self::Typical { .. } => "typical",
        }
    }

    /// The lowest and the highest number of the claim.
    pub const fn ends(&self) -> (f64, f64) {
        match *self {
            Self::Limit(limit) => (limit, limit),
            Self::Typical { from, to, .. } => (from, to),
        }
    }

    /// The number that no sensor is to exceed, if a typical figure is taken for a limit: all that
    /// round to it are allowed for.
    pub const fn as_limit(&self) -> f64 {
        match *self {
            Self::Limit(limit) => limit,
            Self::Typical { to, rounding, .. } => to + rounding,
        }
    }
}

/// A limit, judged by an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The whole interval lies beyond the limit, even with all that is not known of it.
    Fail,
    /// The interval spans the limit, or what is not known; decided_by names what would decide.
    Undecided,
    /// The message does not carry the parameter.
    NotComparable,
    /// The whole interval lies within the limit, even with all that is not known of it.
    Pass,
}

impl Verdict {
    /// From the worst for the sensor to the best.
    pub const ALL: [Self; 4] = [Self::Fail, Self::Undecided, Self::NotComparable, Self::Pass];

    /// Compares a parameter with a limit that lies between `low` and `high`, as a sensor at the limit
    /// may read in the stream. It is kept if the upper end of the interval lies below `low` (the
    /// uncertainty counts against passing, as in ISO 14253-1), and broken if the lower end lies above
    /// `high`. A bound can keep a limit and never break it.
    pub fn of(parameter: &Parameter, (low, high): (f64, f64)) -> Self {
        match parameter {
            Parameter { status: Status::NotMeasurable | Status::Moved, .. } => Self::NotComparable,
            _ if parameter.upper.is_some_and(|upper| upper <= low) => Self::Pass,
            _ if parameter.lower.is_some_and(|lower| lower > high) => Self::Fail,
            _ => Self::Undecided,
        }
    }
}

/// A class of gyroscopes. No standard defines these; the edges are what makers and textbooks agree
/// on within a factor of a few.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Grade {
    /// B below 0.01 deg/h and N below 0.002 deg/sqrt(h); no standard defines these.
    Navigation,
    /// B below 1 deg/h and N below 0.05 deg/sqrt(h).
    Tactical,
    /// B below 30 deg/h and N below 0.5 deg/sqrt(h).
    Industrial,
    /// B or N above the industrial limits.
    Consumer,
}

impl Grade {
    /// From the best.
    pub const ALL: [Self; 4] = [Self::Navigation, Self::Tactical, Self::Industrial, Self::Consumer];

    /// The bias instability in deg/h and the angle random walk in deg/sqrt(h) below which a gyroscope
    /// may be of this grade.
    pub const fn limits(self) -> (f64, f64) {
        match self {
            Self::Navigation => (0.01, 0.002),
            Self::Tactical => (1.0, 0.05),
            Self::Industrial => (30.0, 0.5),
            Self::Consumer => (f64::INFINITY, f64::INFINITY),
        }
    }

    /// The best and the worst grade that the N of the sensor itself, in rad/s/√Hz, and its B in rad/s leave
    /// possible: the worse of the two counts. `None` unless both are known from above.
    pub fn range(white: &Parameter, bias_instability: &Parameter) -> Option<(Self, Self)> {
        let of_white = Self::by(white, |rad| rad.to_degrees() * 60.0, |grade| grade.limits().1)?;
        let of_bias = Self::by(bias_instability, |rad_s| rad_s.to_degrees() * 3600.0, |grade| grade.limits().0)?;
        Some((of_white.0.max(of_bias.0), of_white.1.max(of_bias.1)))
    }

    fn by(parameter: &Parameter, unit: fn(f64) -> f64, limit: fn(Self) -> f64) -> Option<(Self, Self)> {
        let of = |value: f64| Self::ALL.into_iter().find(|grade| unit(value) < limit(*grade));
        Some((parameter.lower.map_or(Some(Self::Navigation), of)?, of(parameter.upper?)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimated(lower: f64, upper: f64) -> Parameter {
        Parameter::estimated((lower + upper) / 2.0, lower, upper)
    }

    fn bounded(upper: f64) -> Parameter {
        Parameter::bounded(upper)
    }

    #[test]
    fn the_interval_decides() {
        use Verdict::{Fail, NotComparable, Pass, Undecided};
        let limit = (10.0, 10.0);
        // what the stream does to a sensor at the limit is known to 10 %
        let about_twice = (18.0, 22.0);
        let without = Parameter::without_value;
        for (range, parameter, expected) in [
            (limit, estimated(9.0, 10.0), Pass),
            (limit, estimated(8.0, 10.1), Undecided),
            (limit, estimated(10.0, 11.0), Undecided),
            (limit, estimated(10.1, 11.0), Fail),
            (limit, bounded(9.0), Pass),
            (limit, bounded(11.0), Undecided),
            // a record may be too short for the upper end alone
            (limit, Parameter { upper: None, ..estimated(8.0, 9.0) }, Undecided),
            (limit, Parameter { upper: None, ..estimated(11.0, 12.0) }, Fail),
            (about_twice, estimated(17.0, 17.9), Pass),
            (about_twice, estimated(17.0, 18.1), Undecided),
            (about_twice, estimated(21.9, 23.0), Undecided),
            (about_twice, estimated(22.1, 23.0), Fail),
            (limit, without(Status::NotMeasurable), NotComparable),
            (limit, without(Status::Moved), NotComparable),
            (limit, without(Status::NotObservable), Undecided),
        ] {
            assert_eq!(Verdict::of(&parameter, range), expected, "{range:?} {parameter:?}");
        }
    }

    #[test]
    fn what_rounds_to_a_typical_figure_is_within_it_as_a_limit() {
        let typical = Claim::Typical { from: 35.0, to: 35.0, rounding: 0.5 };
        assert_eq!((typical.ends(), typical.as_limit()), ((35.0, 35.0), 35.5));
        let range = Claim::Typical { from: 5.0, to: 7.0, rounding: 0.0 };
        assert_eq!((range.ends(), range.as_limit()), ((5.0, 7.0), 7.0));
        assert_eq!((Claim::Limit(4.0).ends(), Claim::Limit(4.0).as_limit()), ((4.0, 4.0), 4.0));
    }

    #[test]
    fn the_worse_of_both_parameters_makes_the_grade() {
        use Grade::{Consumer, Industrial, Navigation, Tactical};
        let bias = |lower: f64, upper: f64| estimated((lower / 3600.0).to_radians(), (upper / 3600.0).to_radians());
        let white = |lower: f64, upper: f64| estimated((lower / 60.0).to_radians(), (upper / 60.0).to_radians());
        let upper_alone = |parameter: Parameter| bounded(parameter.upper.unwrap());
        for (white, bias, expected) in [
            (white(0.20, 0.22), bias(5.0, 7.0), (Industrial, Industrial)),
            (white(0.001, 0.0019), bias(0.001, 0.009), (Navigation, Navigation)),
            // each alone is not enough
            (white(0.04, 0.045), bias(0.001, 0.009), (Tactical, Tactical)),
            (white(0.001, 0.0019), bias(0.5, 0.9), (Tactical, Tactical)),
            (white(0.001, 0.0019), bias(29.0, 31.0), (Industrial, Consumer)),
            (white(0.6, 0.7), bias(0.5, 0.9), (Consumer, Consumer)),
            // an edge belongs to the worse grade
            (white(0.04, 0.05), bias(0.5, 0.9), (Tactical, Industrial)),
            // a bound leaves all that is better, unless the other one decides
            (white(0.001, 0.0019), upper_alone(bias(1.0, 3.0)), (Navigation, Industrial)),
            (white(0.20, 0.22), upper_alone(bias(1.0, 3.0)), (Industrial, Industrial)),
            (upper_alone(white(0.2, 0.4)), upper_alone(bias(0.1, 0.9)), (Navigation, Industrial)),
        ] {
            assert_eq!(Grade::range(&white, &bias), Some(expected), "{white:?} {bias:?}");
        }
        let nothing = Parameter::without_value(Status::NotMeasurable);
        assert_eq!(Grade::range(&white(0.2, 0.3), &nothing), None);
        assert_eq!(Grade::range(&nothing, &bias(5.0, 7.0)), None);
    }
}
