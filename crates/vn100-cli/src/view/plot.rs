//! A logarithmic axis: what it spans, where its grid stands, and how that is labelled.

/// A span of a logarithmic axis, as decimal logarithms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LogAxis {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

/// A line of the grid.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tick {
    /// Decimal logarithm.
    pub(crate) at: f64,
    pub(crate) label: String,
}

/// Narrower than this an axis says nothing.
const LEAST_SPAN: f64 = 0.6;

impl LogAxis {
    /// As wide as the positive values, with a little room at both ends; `None` without any.
    pub(crate) fn over(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let logs = values.into_iter().filter(|value| value.is_finite() && *value > 0.0).map(f64::log10);
        let (low, high) =
            logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), log| (low.min(log), high.max(log)));
        if low > high {
            return None;
        }
        let middle = f64::midpoint(low, high);
        let half = ((high - low).max(LEAST_SPAN) / 2.0) * 1.06;
        Some(Self { low: middle - half, high: middle + half })
    }

    /// Where a value lies, 0 at the low end, 1 at the high one; `None` outside.
    pub(crate) fn part(self, value: f64) -> Option<f64> {
        let part = (value.log10() - self.low) / (self.high - self.low);
        (0.0..=1.0).contains(&part).then_some(part)
    }

    /// A part of the axis, half as wide for each `zoom`, around a value and within the whole.
    pub(crate) fn zoomed(self, zoom: u8, around: f64) -> Self {
        let width = (self.high - self.low) / f64::from(1_u32 << zoom.min(16));
        let low = (around.log10() - width / 2.0).clamp(self.low, self.high - width);
        Self { low, high: low + width }
    }

    /// The decades within, every second or third where there are more than `most`; with few decades
    /// twos and fives too.
    pub(crate) fn ticks(self, most: usize) -> Vec<Tick> {
        let (first, last) = (self.low.ceil() as i32, self.high.floor() as i32);
        let decades = (last - first + 1).max(0) as usize;
        let mut ticks = Vec::new();
        if decades >= 3 || decades > most {
            let apart = decades.div_ceil(most.max(1)).max(1);
            ticks.extend((first..=last).step_by(apart).map(|exponent| tick(1, exponent)));
        } else {
            for exponent in first - 1..=last {
                ticks.extend([1, 2, 5].map(|digit| tick(digit, exponent)));
            }
            ticks.retain(|tick| (self.low..=self.high).contains(&tick.at));
            while ticks.len() > most.max(1) {
                let mut keep = false;
                ticks.retain(|_| {
                    keep = !keep;
                    keep
                });
            }
        }
        ticks
    }
}

fn tick(digit: i32, exponent: i32) -> Tick {
    let label = match exponent {
        0..=3 => (digit * 10_i32.pow(exponent as u32)).to_string(),
        -2..0 => format!("{:.*}", -exponent as usize, f64::from(digit) * 10_f64.powi(exponent)),
        _ => format!("{digit}e{exponent}"),
    };
    Tick { at: f64::from(digit).log10() + f64::from(exponent), label }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(low: f64, high: f64, most: usize) -> Vec<String> {
        LogAxis { low: low.log10(), high: high.log10() }.ticks(most).into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn the_grid_stands_at_decades() {
        assert_eq!(labels(0.02, 1500.0, 9), ["0.1", "1", "10", "100", "1000"]);
        assert_eq!(labels(0.02, 1500.0, 3), ["0.1", "10", "1000"]);
        assert_eq!(labels(3e-6, 4e-2, 9), ["1e-5", "1e-4", "1e-3", "0.01"]);
        assert_eq!(labels(3e-4, 1.5e-3, 9), ["5e-4", "1e-3"]);
        assert_eq!(labels(0.15, 12.0, 9), ["0.2", "0.5", "1", "2", "5", "10"]);
        assert_eq!(labels(2e4, 3e7, 9), ["1e5", "1e6", "1e7"]);
    }

    #[test]
    fn nothing_positive_has_no_axis() {
        assert_eq!(LogAxis::over([0.0, -1.0, f64::NAN, f64::INFINITY]), None);
    }

    proptest! {
        #[test]
        fn an_axis_holds_all_it_was_made_of(values in prop::collection::vec(1e-12_f64..1e12, 1..30), zoom in 0_u8..5) {
            let axis = LogAxis::over(values.iter().copied()).unwrap();
            prop_assert!(values.iter().all(|value| axis.part(*value).is_some()));
            for tick in axis.ticks(6) {
                prop_assert!((axis.low..=axis.high).contains(&tick.at));
            }
            prop_assert!(axis.ticks(6).len() <= 6);
            let zoomed = axis.zoomed(zoom, values[0]);
            prop_assert!(zoomed.part(values[0]).is_some());
            prop_assert!(zoomed.low >= axis.low - 1e-9 && zoomed.high <= axis.high + 1e-9);
        }
    }
}
