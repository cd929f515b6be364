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
        /// How far either may be rounded: half a unit of the last printed place of a single value.
        /// a maker prints 0.00354 as 0.0035, too. The ends of a range are taken as printed.
        rounding: f64,
    },
}

/// How the stream changes a parameter of the sensor before it can be measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreamFactor {
    /// Factor by which the stream raises the parameter.
    pub factor: f64,
    /// How far the factor may be off, relative; 0 and above.
    pub uncertainty: f64,
    /// Whether the sensor reported its settings; otherwise nothing can pass or fail by the factor.
    pub is_known: bool,
}

impl StreamFactor {
    /// The stream shows the parameter as it is.
    pub const ONE: Self = Self { factor: 1.0, uncertainty: 0.0, is_known: true };
}

/// A claim, judged by an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The whole interval lies within the limit.
    Pass,
    /// The whole interval lies beyond the limit, and the effect of the stream does not explain it.
    Fail,
    /// The upper end lies within what is typical: no worse than many sensors.
    Typical,
    /// The whole interval lies above what is typical, which is no guarantee.
    AboveTypical,
    /// The whole interval lies below what is typical: better than many sensors.
    BelowTypical,
    /// The interval spans the limit, or the upper end of what is typical.
    Inconclusive,
    /// No evidence against the claim, and what would decide is unknown, so that no longer record
    /// does: the effect of the stream on the parameter, or what the figure means.
    Consistent,
    /// There is no interval; or it lies beyond the claim, and the effect of the stream is unknown.
    Undecided,
    /// The stream does not carry the parameter.
    NotComparable,
}

impl Verdict {
    /// From the worst for the sensor to the best.
    pub const ALL: [Self; 9] = [
        Self::Fail,
        Self::AboveTypical,
        Self::Inconclusive,
        Self::Undecided,
        Self::NotComparable,
        Self::Consistent,
        Self::Typical,
        Self::BelowTypical,
        Self::Pass,
    ];

    /// Combines the verdicts by the two conventions of a figure whose convention is unknown: one
    /// against the sensor holds where both agree, and nothing passes.
    #[must_use]
    pub fn of_either_reading(self, other: Self) -> Self {
        let speaks_for =
            |verdict| matches!(verdict, Self::Pass | Self::Typical | Self::BelowTypical | Self::Consistent);
        match self {
            _ if speaks_for(self) || speaks_for(other) => Self::Consistent,
            same if same == other => same,
            _ => Self::Inconclusive,
        }
    }

    /// The verdict where what is typical is taken for a limit.
    #[must_use]
    pub fn with_typical_as_limit(self) -> Self {
        match self {
            Self::Typical | Self::BelowTypical => Self::Pass,
            Self::AboveTypical => Self::Fail,
            other => other,
        }
    }
}

impl Claim {
    /// The same in another convention, in which numbers are `factor` times as large.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Limit(limit) => Self::Limit(limit * factor),
            Self::Typical { from, to, rounding } => {
                Self::Typical { from: from * factor, to: to * factor, rounding: rounding * factor }
            }
        }
    }

    /// Range of the parameter in the stream of a sensor at the claim.
    #[must_use]
    pub fn expected(&self, stream: &StreamFactor) -> (f64, f64) {
        let (from, to) = match *self {
            Self::Limit(limit) => (limit, limit),
            Self::Typical { from, to, rounding } => (from - rounding, to + rounding),
        };
        (from * stream.factor * (1.0 - stream.uncertainty), to * stream.factor * (1.0 + stream.uncertainty))
    }

    /// Compares `parameter`, as measured in the stream. A limit is kept where the upper end of the
    /// interval lies below the lowest that a sensor at the limit can read (the uncertainty counts
    /// against passing, as in ISO 14253-1), and broken where the lower end lies above the highest.
    /// A parameter is typical up to the highest that such a sensor can read, its rounding allowed
    /// for. A bound can keep a claim and never break it.
    #[must_use]
    pub fn judge(&self, parameter: &Parameter, stream: &StreamFactor) -> Verdict {
        if matches!(parameter.status, Status::NotMeasurable | Status::Moved) {
            return Verdict::NotComparable;
        }
        let (low, high) = self.expected(stream);
        let is_limit = matches!(self, Self::Limit(_));
        let is_beyond = parameter.lower.is_some_and(|lower| lower > high);
        let is_within = parameter.upper.is_some_and(|upper| upper <= if is_limit { low } else { high });
        let is_below = parameter.upper.is_some_and(|upper| upper < low);
        match (stream.is_known, is_limit) {
            _ if parameter.upper.is_none() && parameter.lower.is_none() => Verdict::Undecided,
            (false, _) if is_beyond => Verdict::Undecided,
            (false, _) if is_within => Verdict::Consistent,
            (true, true) if is_beyond => Verdict::Fail,
            (true, true) if is_within => Verdict::Pass,
            (true, false) if is_beyond => Verdict::AboveTypical,
            (true, false) if is_below => Verdict::BelowTypical,
            (true, false) if is_within => Verdict::Typical,
            _ => Verdict::Inconclusive,
        }
    }
}

/// A class of gyroscopes. No standard defines these; the edges are what makers and textbooks agree
/// on within a factor of a few.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Grade {
    /// B below 0.01 deg/h and N below 0.002 deg/sqrt(h).
    Navigation,
    /// Below 1 deg/h and 0.05 deg/sqrt(h).
    Tactical,
    /// Below 30 deg/h and 0.5 deg/sqrt(h).
    Industrial,
    /// Above.
    Consumer,
}

impl Grade {
    /// From the best.
    pub const ALL: [Self; 4] = [Self::Navigation, Self::Tactical, Self::Industrial, Self::Consumer];

    /// The bias instability in deg/h below which a gyroscope may be of this grade.
    #[must_use]
    pub const fn limit_deg_h(self) -> f64 {
        match self {
            Self::Navigation => 0.01,
            Self::Tactical => 1.0,
            Self::Industrial => 30.0,
            Self::Consumer => f64::INFINITY,
        }
    }

    /// The angle random walk in deg/sqrt(h) below which it may.
    #[must_use]
    pub const fn limit_deg_sqrt_h(self) -> f64 {
        match self {
            Self::Navigation => 0.002,
            Self::Tactical => 0.05,
            Self::Industrial => 0.5,
            Self::Consumer => f64::INFINITY,
        }
    }

    /// The best and the worst grade that the N of the sensor itself, in rad/s/√Hz and without what
    /// aliasing adds, and its B in rad/s leave possible: the worse of the two counts. `None` unless
    /// both are known from above.
    #[must_use]
    pub fn range(white: &Parameter, bias_instability: &Parameter) -> Option<(Self, Self)> {
        let of_white = Self::by(white, |rad| rad.to_degrees() * 60.0, Self::limit_deg_sqrt_h)?;
        let of_bias = Self::by(bias_instability, |rad_s| rad_s.to_degrees() * 3600.0, Self::limit_deg_h)?;
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
        use Verdict::{
            AboveTypical, BelowTypical, Consistent, Fail, Inconclusive, NotComparable, Pass, Typical, Undecided,
        };
        let limit = Claim::Limit(10.0);
        let typical = Claim::Typical { from: 5.0, to: 7.0, rounding: 0.0 };
        // printed as 0.0035
        let single = Claim::Typical { from: 35.0, to: 35.0, rounding: 0.5 };
        let twice = StreamFactor { factor: 2.0, uncertainty: 0.1, is_known: true };
        let unknown = StreamFactor { is_known: false, ..twice };
        let without = Parameter::without_value;
        for (claim, parameter, stream, expected) in [
            (limit, estimated(8.0, 9.9), StreamFactor::ONE, Pass),
            (limit, estimated(8.0, 10.1), StreamFactor::ONE, Inconclusive),
            (limit, estimated(10.1, 11.0), StreamFactor::ONE, Fail),
            (limit, estimated(9.0, 10.0), StreamFactor::ONE, Pass),
            (limit, estimated(10.0, 11.0), StreamFactor::ONE, Inconclusive),
            (limit, bounded(9.0), StreamFactor::ONE, Pass),
            // a record may be too short for the upper end alone
            (limit, Parameter { upper: None, ..estimated(8.0, 9.0) }, StreamFactor::ONE, Inconclusive),
            (limit, Parameter { upper: None, ..estimated(11.0, 12.0) }, StreamFactor::ONE, Fail),
            (limit, Parameter { upper: None, ..estimated(11.0, 12.0) }, unknown, Inconclusive),
            (limit, bounded(11.0), StreamFactor::ONE, Inconclusive),
            // twice the limit is 18 to 22
            (limit, estimated(17.0, 17.9), twice, Pass),
            (limit, estimated(17.0, 18.1), twice, Inconclusive),
            (limit, estimated(21.9, 23.0), twice, Inconclusive),
            (limit, estimated(22.1, 23.0), twice, Fail),
            (typical, estimated(6.9, 7.0), StreamFactor::ONE, Typical),
            (typical, estimated(4.0, 6.0), StreamFactor::ONE, Typical),
            (typical, estimated(1.0, 5.0), StreamFactor::ONE, Typical),
            (typical, estimated(1.0, 4.9), StreamFactor::ONE, BelowTypical),
            (typical, bounded(6.0), StreamFactor::ONE, Typical),
            (typical, bounded(4.9), StreamFactor::ONE, BelowTypical),
            (typical, bounded(7.1), StreamFactor::ONE, Inconclusive),
            (typical, estimated(6.9, 7.1), StreamFactor::ONE, Inconclusive),
            (typical, Parameter { upper: None, ..estimated(4.0, 4.5) }, StreamFactor::ONE, Inconclusive),
            (typical, estimated(7.1, 7.2), StreamFactor::ONE, AboveTypical),
            // twice what is typical is 9 to 15.4
            (typical, estimated(15.0, 15.3), twice, Typical),
            (typical, estimated(8.0, 8.9), twice, BelowTypical),
            (single, estimated(35.05, 35.15), StreamFactor::ONE, Typical),
            (single, estimated(35.3, 35.5), StreamFactor::ONE, Typical),
            (single, estimated(35.4, 35.6), StreamFactor::ONE, Inconclusive),
            (single, estimated(35.5, 36.0), StreamFactor::ONE, Inconclusive),
            (single, estimated(35.51, 36.0), StreamFactor::ONE, AboveTypical),
            (single, estimated(34.0, 34.49), StreamFactor::ONE, BelowTypical),
            // 71 at most, and 10 %
            (single, estimated(77.0, 78.09), twice, Typical),
            (single, estimated(78.11, 79.0), twice, AboveTypical),
            // without the window nothing passes and nothing fails
            (limit, estimated(17.0, 17.9), unknown, Consistent),
            (typical, estimated(1.0, 2.0), unknown, Consistent),
            (typical, estimated(15.0, 16.0), unknown, Inconclusive),
            (typical, estimated(16.0, 17.0), unknown, Undecided),
            (limit, bounded(17.9), unknown, Consistent),
            // a bound above the limit is no evidence for it
            (limit, bounded(100.0), unknown, Inconclusive),
            (limit, without(Status::NotMeasurable), StreamFactor::ONE, NotComparable),
            (limit, without(Status::NotMeasurable), unknown, NotComparable),
            (limit, without(Status::NotObservable), StreamFactor::ONE, Undecided),
            (typical, without(Status::ModelRejected), unknown, Undecided),
        ] {
            assert_eq!(claim.judge(&parameter, &stream), expected, "{claim:?} {parameter:?} {stream:?}");
        }
    }

    #[test]
    fn a_figure_of_two_readings_never_passes_and_fails_by_both_only() {
        use Verdict::{
            AboveTypical, BelowTypical, Consistent, Fail, Inconclusive, NotComparable, Pass, Typical, Undecided,
        };
        for (two_sided, one_sided, expected) in [
            (Pass, Pass, Consistent),
            (Pass, Fail, Consistent),
            (Typical, AboveTypical, Consistent),
            (BelowTypical, BelowTypical, Consistent),
            (Consistent, Undecided, Consistent),
            (AboveTypical, AboveTypical, AboveTypical),
            (Fail, Fail, Fail),
            (Inconclusive, AboveTypical, Inconclusive),
            (Inconclusive, Inconclusive, Inconclusive),
            (Undecided, Undecided, Undecided),
            (NotComparable, NotComparable, NotComparable),
        ] {
            assert_eq!(two_sided.of_either_reading(one_sided), expected, "{two_sided:?} {one_sided:?}");
            assert_eq!(one_sided.of_either_reading(two_sided), expected, "{one_sided:?} {two_sided:?}");
        }
        let as_limits = [Typical, BelowTypical, AboveTypical, Pass, Consistent].map(Verdict::with_typical_as_limit);
        assert_eq!(as_limits, [Pass, Pass, Fail, Pass, Consistent]);
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
