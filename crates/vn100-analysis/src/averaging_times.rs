//! At which averaging times the deviation is given: the octaves, or others that the user asks for.

use std::{fmt, str::FromStr};

use imu_noise::{Deviation, RecordShape};

use crate::invalid_text::InvalidText;

/// The averaging times at which the deviation is given; the model is fitted to the octaves.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum AveragingTimes {
    /// m = 1, 2, 4, 8 … samples.
    #[default]
    Octave,
    /// m = 1, 2, 4, 10, 20, 40, 100 … samples, as in Stable32 and allantools.
    Decade,
    /// These averaging times in seconds, each above 0.
    List(Vec<f64>),
}

/// What is said of an averaging factor that no stretch of a record of this shape has room for.
pub(crate) fn without_window(m: u64, shape: &RecordShape) -> String {
    let order = if shape.deviation == Deviation::Allan { 2.0 } else { 3.0 };
    let tau_s = m as f64 * shape.interval_s;
    let (tau_s, needed_s) = (tidy(tau_s), tidy(order * tau_s));
    format!("an averaging time of {tau_s} s needs {needed_s} s without a gap, and the record has no such stretch")
}

fn near(tau_s: f64, interval_s: f64) -> String {
    let below = (tau_s / interval_s).floor();
    let times = [below, below + 1.0].into_iter().filter(|m| *m > 0.0).map(|m| format!("{} s", tidy(m * interval_s)));
    times.collect::<Vec<_>>().join(" and ")
}

/// The number without the digits that a division by the rate adds.
fn tidy(seconds: f64) -> f64 {
    format!("{seconds:.9e}").parse().unwrap_or(seconds)
}

impl AveragingTimes {
    /// The averaging factors besides the octaves for a record of this shape, ascending, and the
    /// sentences of [`no_multiples`](Self::no_multiples); none of either for the octaves themselves.
    pub(crate) fn factors(&self, shape: &RecordShape) -> (Vec<u64>, Vec<String>) {
        let has_window = |m: &u64| shape.windows(*m) > 0;
        match self {
            Self::Octave => (Vec::new(), Vec::new()),
            Self::Decade => {
                let decades = (0..19).flat_map(|power| [1, 2, 4].map(|m| m * 10_u64.pow(power)));
                (decades.take_while(has_window).collect(), Vec::new())
            }
            Self::List(times) => {
                let missing = self.no_multiples(shape.interval_s);
                let factor = |tau_s: &f64| whole_factor(*tau_s, shape.interval_s);
                let mut factors: Vec<u64> = times.iter().filter_map(factor).collect();
                factors.sort_unstable();
                factors.dedup();
                (factors, missing)
            }
        }
    }

    /// A sentence for each of the listed times that is not a multiple of this sample interval.
    pub fn no_multiples(&self, interval_s: f64) -> Vec<String> {
        let Self::List(times) = self else { return Vec::new() };
        let not_whole = times.iter().filter(|tau_s| whole_factor(**tau_s, interval_s).is_none());
        let sentence = |tau_s: &f64| {
            let (interval_s, nearest) = (tidy(interval_s), near(*tau_s, tidy(interval_s)));
            format!(
                "the averaging time of {tau_s} s is no multiple of the sample interval of {interval_s} s; the nearest: {nearest}"
            )
        };
        not_whole.map(sentence).collect()
    }
}

/// The averaging factor; `None` unless it is whole to a millionth.
fn whole_factor(tau_s: f64, interval_s: f64) -> Option<u64> {
    let m = tau_s / interval_s;
    (m.round() >= 1.0 && (m / m.round() - 1.0).abs() <= 1e-6).then_some(m.round() as u64)
}

impl FromStr for AveragingTimes {
    type Err = InvalidText;

    fn from_str(text: &str) -> Result<Self, InvalidText> {
        match text.trim() {
            "octave" => Ok(Self::Octave),
            "decade" => Ok(Self::Decade),
            list => {
                let time = |word: &str| match word.trim().parse::<f64>() {
                    Ok(tau_s) if tau_s > 0.0 && tau_s.is_finite() => Ok(tau_s),
                    Ok(tau_s) => {
                        Err(InvalidText(format!("an averaging time of {tau_s} s does not exist: give seconds above 0")))
                    }
                    Err(_) => Err(InvalidText(format!(
                        "{:?} is no averaging time: octave, decade, or seconds with commas between them, as in 0.5,1,10",
                        word.trim()
                    ))),
                };
                list.split(',').map(time).collect::<Result<_, _>>().map(Self::List)
            }
        }
    }
}

impl fmt::Display for AveragingTimes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Octave => f.write_str("octave"),
            Self::Decade => f.write_str("decade"),
            Self::List(times) => f.write_str(&times.iter().map(f64::to_string).collect::<Vec<_>>().join(",")),
        }
    }
}

#[cfg(test)]
mod tests {
    use imu_noise::Estimator;

    use super::*;

    fn shape(samples: u64, interval_s: f64) -> RecordShape {
        RecordShape { samples, interval_s, estimator: Estimator::Full, deviation: Deviation::Allan }
    }

    fn factors(text: &str, samples: u64, interval_s: f64) -> Vec<u64> {
        let (factors, missing) = text.parse::<AveragingTimes>().unwrap().factors(&shape(samples, interval_s));
        assert!(missing.is_empty(), "{missing:?}");
        factors
    }

    #[test]
    fn names_stand_for_the_factors_of_the_tables() {
        assert_eq!(factors("octave", 1000, 1.0), [0; 0]);
        assert_eq!(factors("decade", 1000, 1.0), [1, 2, 4, 10, 20, 40, 100, 200, 400]);
        assert_eq!(factors("decade", 1, 1.0), [0; 0]);
        assert_eq!(factors("10, 0.025 ,1,1", 10_000, 0.025), [1, 40, 400]);
        // 0.33 s at 300 Hz is 99 samples but for the last bit
        assert_eq!(factors("0.33", 1000, 1.0 / 300.0), [99]);
    }

    #[test]
    fn what_is_no_multiple_is_named_with_its_neighbours() {
        let times: AveragingTimes = "0.03,1,0.01".parse().unwrap();
        let (factors, missing) = times.factors(&shape(1000, 0.025));
        assert_eq!(factors, [40]);
        let expected = [
            "the averaging time of 0.03 s is no multiple of the sample interval of 0.025 s; the nearest: 0.025 s and 0.05 s",
            "the averaging time of 0.01 s is no multiple of the sample interval of 0.025 s; the nearest: 0.025 s",
        ];
        assert_eq!(missing, expected);
    }

    #[test]
    fn texts_are_read_as_they_are_printed() {
        for text in ["octave", "decade", "0.5,1,10"] {
            assert_eq!(text.parse::<AveragingTimes>().unwrap().to_string(), text);
        }
        for (text, expected) in
            [("", "is no averaging time"), ("1,x", "\"x\" is no"), ("0", "above 0"), ("1,-2", "-2 s"), ("inf", "inf s")]
        {
            let error = text.parse::<AveragingTimes>().unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
