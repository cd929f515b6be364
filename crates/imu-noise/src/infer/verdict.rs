//! A fitted parameter against a data sheet's claim, by the interval, never by the point.

use super::noise_model::{Parameter, Status};

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

/// What the stream does to a parameter of the sensor before anybody can measure it.
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// The whole interval is within the claim.
    Pass,
    /// The whole interval is beyond the claim, and the effect of the stream does not explain it.
    Fail,
    /// The interval holds both, or there is none.
    Undecided,
    /// The claim may hold, but the effect of the stream on the parameter is unknown.
    Consistent,
    /// The stream does not carry the parameter.
    NotComparable,
}

impl Claim {
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
    /// A typical value is kept up to the highest that such a sensor can read, its rounding allowed
    /// for. A bound can keep a claim and never break it.
    #[must_use]
    pub fn judge(&self, parameter: &Parameter, stream: &StreamFactor) -> Verdict {
        if parameter.status == Status::NotMeasurable {
            return Verdict::NotComparable;
        }
        let (low, high) = self.expected(stream);
        if parameter.upper.is_none() && parameter.lower.is_none() {
            return Verdict::Undecided;
        }
        let is_beyond = parameter.lower.is_some_and(|lower| lower > high);
        let is_within = parameter.upper.is_some_and(|upper| match self {
            Self::Limit(_) => upper <= low,
            Self::Typical { .. } => upper <= high,
        });
        match (stream.is_known, is_within, is_beyond) {
            (false, _, true) => Verdict::Undecided,
            (false, _, false) => Verdict::Consistent,
            (true, true, _) => Verdict::Pass,
            (true, _, true) => Verdict::Fail,
            (true, false, false) => Verdict::Undecided,
        }
    }
}

/// By drift, after N. El-Sheimy and A. Youssef, "Inertial sensors technologies for navigation
/// applications: state of the art and future trends", Satellite Navigation 1 (2020), table 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Grade {
    /// Below 0.01 deg/h.
    Navigation,
    /// Up to 10 deg/h; the table leaves the space from 0.01 to 1 deg/h open, which is counted here.
    Tactical,
    /// Above.
    Commercial,
}

impl Grade {
    /// From the best.
    pub const ALL: [Self; 3] = [Self::Navigation, Self::Tactical, Self::Commercial];

    /// The bias instability in deg/h up to which a gyroscope is of this grade.
    #[must_use]
    pub const fn limit_deg_h(self) -> f64 {
        match self {
            Self::Navigation => 0.01,
            Self::Tactical => 10.0,
            Self::Commercial => f64::INFINITY,
        }
    }

    /// The best and the worst grade that a bias instability B in rad/s leaves possible; equal where
    /// by the interval. `None` where the stream does not carry it, or nothing is known of it.
    #[must_use]
    pub fn range(bias_instability: &Parameter) -> Option<(Self, Self)> {
        let of = |rad_s: f64| {
            let deg_h = rad_s.to_degrees() * 3600.0;
            Self::ALL.into_iter().find(|grade| deg_h <= grade.limit_deg_h())
        };
        let worst = of(bias_instability.upper?)?;
        Some((bias_instability.lower.map_or(Some(Self::Navigation), of)?, worst))
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
        use Verdict::{Consistent, Fail, NotComparable, Pass, Undecided};
        let limit = Claim::Limit(10.0);
        let typical = Claim::Typical { from: 5.0, to: 7.0, rounding: 0.0 };
        // printed as 0.0035
        let single = Claim::Typical { from: 35.0, to: 35.0, rounding: 0.5 };
        let twice = StreamFactor { factor: 2.0, uncertainty: 0.1, is_known: true };
        let unknown = StreamFactor { is_known: false, ..twice };
        let without = Parameter::without_value;
        for (claim, parameter, stream, expected) in [
            (limit, estimated(8.0, 9.9), StreamFactor::ONE, Pass),
            (limit, estimated(8.0, 10.1), StreamFactor::ONE, Undecided),
            (limit, estimated(10.1, 11.0), StreamFactor::ONE, Fail),
            (limit, estimated(9.0, 10.0), StreamFactor::ONE, Pass),
            (limit, estimated(10.0, 11.0), StreamFactor::ONE, Undecided),
            (limit, bounded(9.0), StreamFactor::ONE, Pass),
            // a record may be too short for the upper end alone
            (limit, Parameter { upper: None, ..estimated(8.0, 9.0) }, StreamFactor::ONE, Undecided),
            (limit, Parameter { upper: None, ..estimated(11.0, 12.0) }, StreamFactor::ONE, Fail),
            (limit, Parameter { upper: None, ..estimated(11.0, 12.0) }, unknown, Consistent),
            (limit, bounded(11.0), StreamFactor::ONE, Undecided),
            // twice the limit is 18 to 22
            (limit, estimated(17.0, 17.9), twice, Pass),
            (limit, estimated(17.0, 18.1), twice, Undecided),
            (limit, estimated(21.9, 23.0), twice, Undecided),
            (limit, estimated(22.1, 23.0), twice, Fail),
            (typical, estimated(6.9, 7.0), StreamFactor::ONE, Pass),
            (typical, estimated(1.0, 2.0), StreamFactor::ONE, Pass),
            (typical, estimated(6.9, 7.1), StreamFactor::ONE, Undecided),
            (typical, estimated(7.1, 7.2), StreamFactor::ONE, Fail),
            (typical, estimated(15.0, 15.3), twice, Pass),
            (single, estimated(35.05, 35.15), StreamFactor::ONE, Pass),
            (single, estimated(35.3, 35.5), StreamFactor::ONE, Pass),
            (single, estimated(35.4, 35.6), StreamFactor::ONE, Undecided),
            (single, estimated(35.5, 36.0), StreamFactor::ONE, Undecided),
            (single, estimated(35.51, 36.0), StreamFactor::ONE, Fail),
            // 71 at most, and 10 %
            (single, estimated(77.0, 78.09), twice, Pass),
            (single, estimated(78.11, 79.0), twice, Fail),
            // without the window nothing passes and nothing fails
            (typical, estimated(1.0, 2.0), unknown, Consistent),
            (typical, estimated(15.0, 16.0), unknown, Consistent),
            (typical, estimated(16.0, 17.0), unknown, Undecided),
            (limit, bounded(100.0), unknown, Consistent),
            (limit, without(Status::NotMeasurable), StreamFactor::ONE, NotComparable),
            (limit, without(Status::NotMeasurable), unknown, NotComparable),
            (limit, without(Status::NotObservable), StreamFactor::ONE, Undecided),
            (limit, without(Status::ModelRejected), unknown, Undecided),
        ] {
            assert_eq!(claim.judge(&parameter, &stream), expected, "{claim:?} {parameter:?} {stream:?}");
        }
    }

    #[test]
    fn grades_are_what_the_interval_leaves() {
        let rad_s = |deg_h: f64| (deg_h / 3600.0).to_radians();
        let range = |lower, upper| Grade::range(&estimated(rad_s(lower), rad_s(upper)));
        assert_eq!(range(5.0, 7.0), Some((Grade::Tactical, Grade::Tactical)));
        assert_eq!(range(9.0, 11.0), Some((Grade::Tactical, Grade::Commercial)));
        assert_eq!(range(0.001, 0.009), Some((Grade::Navigation, Grade::Navigation)));
        assert_eq!(Grade::range(&bounded(rad_s(3.0))), Some((Grade::Navigation, Grade::Tactical)));
        assert_eq!(Grade::range(&Parameter::without_value(Status::NotMeasurable)), None);
    }
}
