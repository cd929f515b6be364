//! Change of mean from window to window, spread within windows, and when either was large.

use super::blocks::Sums;

/// Bits of the fraction of a float that count: 8 bins an octave.
const FRACTION_BITS: u32 = 3;

const KEPT: usize = 8;

/// Change of mean from window to window and spread within windows of 32 samples: the same all the
/// time for white, flicker and random-walk noise.
#[derive(Clone, Debug)]
pub(crate) struct WindowStatistics {
    /// |ΔΣc| of adjacent windows.
    pub(crate) changes: Magnitudes,
    /// n Σd² - (Σd)² of each window.
    pub(crate) spreads: Magnitudes,
    /// The last full window, its sum and its spread.
    last: Option<(u64, i64, f64)>,
}

/// A change of mean below this share of the standard deviation in its windows is no peak: one
/// sample far out moves the mean of 32 by a fifth of the deviation that it gives them.
const LEAST_CHANGE: f64 = 0.5;

impl WindowStatistics {
    pub(crate) const fn new() -> Self {
        Self { changes: Magnitudes::new(), spreads: Magnitudes::new(), last: None }
    }

    pub(crate) fn push(&mut self, window: u64, sums: &Sums, spread: f64) {
        if let Some((last, sum, spread_before)) = self.last
            && last + 1 == window
        {
            let change = (sums.sum - sum).unsigned_abs() as f64;
            let least = LEAST_CHANGE * LEAST_CHANGE * spread.max(spread_before);
            self.changes.push(window, change, || if change * change < least { 0.0 } else { change });
        }
        self.last = Some((window, sums.sum, spread));
        // One sample far out is a matter of the tails: a disturbance has more.
        self.spreads.push(window, spread, || sums.spread_without_farthest(spread));
    }

    pub(crate) const fn gap(&mut self) {
        self.last = None;
    }
}

/// Frequencies of positive numbers in bins of an eighth of an octave, and the highest peaks. At
/// most 2.4 KiB for numbers below 2^75; half a KiB for those of most records.
#[derive(Clone, Debug)]
pub(crate) struct Magnitudes {
    first: u16,
    frequencies: Vec<u32>,
    pub(crate) total: u32,
    current: Option<PeakWindows>,
    /// Rising peaks.
    highest: Vec<PeakWindows>,
    /// Half of the lowest peak once all are kept: no smaller number is part of a higher one.
    least: f64,
}

/// Windows in a row whose numbers are at least half of the highest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PeakWindows {
    pub(crate) first_window: u64,
    pub(crate) last_window: u64,
    pub(crate) peak: f64,
}

impl Magnitudes {
    pub(crate) const fn new() -> Self {
        Self { first: 0, frequencies: Vec::new(), total: 0, current: None, highest: Vec::new(), least: 0.0 }
    }

    /// Adds the number of one window: not negative, and finite. `peak`, at most as high, is what it
    /// counts for among the highest.
    pub(crate) fn push(&mut self, window: u64, number: f64, peak: impl FnOnce() -> f64) {
        self.count(number);
        // Most numbers are part of no stretch that would be kept.
        if number >= self.least || self.current.is_some() {
            self.stretch(window, peak());
        }
    }

    fn stretch(&mut self, window: u64, number: f64) {
        if let Some(current) = &mut self.current {
            let follows = current.last_window + 1 == window;
            if follows && number >= current.peak / 2.0 {
                if current.peak < number / 2.0 {
                    current.first_window = window;
                }
                current.last_window = window;
                current.peak = current.peak.max(number);
                return;
            }
            let ended = *current;
            self.keep(ended);
            self.current = None;
            if follows {
                // The tail of a high stretch, which is not to take the place of another.
                return;
            }
        }
        if number >= self.least {
            self.current = Some(PeakWindows { first_window: window, last_window: window, peak: number });
        }
    }

    /// The number that the share `p` of all does not exceed; `None` without numbers.
    pub(crate) fn quantile(&self, p: f64) -> Option<f64> {
        let mut missing = p * f64::from(self.total);
        for (bin, &frequency) in (self.first..).zip(&self.frequencies) {
            let frequency = f64::from(frequency);
            if frequency > 0.0 && missing <= frequency {
                let (lower, upper) = (lowest_of(bin), lowest_of(bin + 1));
                return Some(lower + (upper - lower) * missing / frequency);
            }
            missing -= frequency;
        }
        None
    }

    /// At most 9.
    pub(crate) fn highest(&self) -> impl Iterator<Item = &PeakWindows> {
        self.highest.iter().chain(&self.current)
    }

    fn count(&mut self, number: f64) {
        let bin = bin_of(number);
        if self.frequencies.is_empty() {
            self.first = bin;
        }
        if bin < self.first {
            let lower = usize::from(self.first - bin);
            self.frequencies.splice(..0, std::iter::repeat_n(0, lower));
            self.first = bin;
        }
        let place = usize::from(bin - self.first);
        if self.frequencies.len() <= place {
            self.frequencies.resize(place + 1, 0);
        }
        self.frequencies[place] = self.frequencies[place].saturating_add(1);
        self.total = self.total.saturating_add(1);
    }

    fn keep(&mut self, stretch: PeakWindows) {
        if self.highest.len() == KEPT {
            if stretch.peak <= self.highest[0].peak {
                return;
            }
            self.highest.remove(0);
        }
        let place = self.highest.partition_point(|kept| kept.peak < stretch.peak);
        self.highest.insert(place, stretch);
        if self.highest.len() == KEPT {
            self.least = self.highest[0].peak / 2.0;
        }
    }
}

/// Numbers below 1 share the lowest bin: they come from integers, and are 0.
fn bin_of(number: f64) -> u16 {
    let bits = number.max(0.5).to_bits() >> (f64::MANTISSA_DIGITS - 1 - FRACTION_BITS);
    bits as u16
}

fn lowest_of(bin: u16) -> f64 {
    let lowest = f64::from_bits(u64::from(bin) << (f64::MANTISSA_DIGITS - 1 - FRACTION_BITS));
    if lowest < 1.0 { 0.0 } else { lowest }
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};

    use super::*;

    fn of(numbers: &[f64]) -> Magnitudes {
        let mut magnitudes = Magnitudes::new();
        (0..).zip(numbers).for_each(|(window, &number)| magnitudes.push(window, number, || number));
        magnitudes
    }

    proptest! {
        #[test]
        fn quantiles_lie_in_the_bin_of_the_number_at_that_place(
            numbers in vec((0.0..40_f64).prop_map(f64::exp2), 1..300),
            p in 0.01..0.99_f64,
        ) {
            let mut sorted = numbers.clone();
            sorted.sort_by(f64::total_cmp);
            let exact = sorted[((p * numbers.len() as f64).ceil() as usize).max(1) - 1];
            let quantile = of(&numbers).quantile(p).unwrap();
            prop_assert!((quantile / exact).ln().abs() <= 1.125_f64.ln() + 1e-12, "{} {}", quantile, exact);
        }

        #[test]
        fn the_highest_numbers_are_the_peaks_of_the_highest_stretches(
            numbers in vec((0.0..6_f64).prop_map(f64::exp2), 1..400),
        ) {
            // All stretches: each ends with the number below half of its peak, which is part of none.
            let mut stretches: Vec<f64> = Vec::new();
            let mut peak = 0.0_f64;
            for &number in &numbers {
                if peak > 0.0 && number < peak / 2.0 {
                    stretches.push(peak);
                    peak = 0.0;
                } else {
                    peak = peak.max(number);
                }
            }
            stretches.extend((peak > 0.0).then_some(peak));
            stretches.sort_by(|a, b| b.total_cmp(a));
            let mut kept: Vec<_> = of(&numbers).highest().map(|stretch| stretch.peak).collect();
            kept.sort_by(|a, b| b.total_cmp(a));
            let places = stretches.len().min(KEPT);
            prop_assert_eq!(&kept[..places], &stretches[..places]);
        }
    }

    #[test]
    fn a_stretch_begins_and_ends_at_half_of_its_peak() {
        let mut numbers = vec![1.0; 100];
        numbers[40..46].copy_from_slice(&[3.0, 4.0, 9.0, 20.0, 11.0, 9.0]);
        let magnitudes = of(&numbers);
        let highest = magnitudes.highest().max_by(|a, b| a.peak.total_cmp(&b.peak)).unwrap();
        assert_eq!(*highest, PeakWindows { first_window: 43, last_window: 44, peak: 20.0 });
    }

    #[test]
    fn without_numbers_there_is_no_quantile() {
        assert_eq!(Magnitudes::new().quantile(0.5), None);
    }
}
