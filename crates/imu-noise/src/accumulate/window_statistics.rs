//! The change of mean from window to window, the spread within windows, and the windows in which
//! either was large.

use super::blocks::{BlockSums, WINDOW};

/// Significant bits of the fraction of a float: 8 bins per octave.
const FRACTION_BITS: u32 = 3;

/// The bits of the lowest bin, which holds all numbers below 1: they come from integers, so they are 0.
const LOWEST_BITS: u64 = 0.5_f64.to_bits() >> (f64::MANTISSA_DIGITS - 1 - FRACTION_BITS);

/// Number of cells whose highest numbers are kept.
const KEPT: usize = 16;

/// Windows of a cell, which begins at a multiple of this number: a stretch of high numbers is cut at
/// its end.
const CELL: u64 = 16;

/// Change of mean from window to window and spread within windows of 32 samples: constant over time
/// for white, flicker and random-walk noise.
#[derive(Clone, Debug, Default)]
pub(crate) struct WindowStatistics {
    /// |ΔΣc| of adjacent windows.
    pub(crate) changes: Magnitudes,
    /// n Σd² - (Σd)² of each window.
    pub(crate) spreads: Magnitudes,
    /// The last full window of the run.
    last: Option<Window>,
    pub(crate) extremes: Extremes,
}

/// The squares of 32 times how far the farthest sample of each window lies from those around it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Extremes {
    /// Of all windows but the last.
    pub(crate) squares: Magnitudes,
    /// The mean of the window before the last.
    before: Option<f64>,
    last: Option<BlockSums>,
}

impl Extremes {
    /// Adds a window, full or not.
    pub(crate) fn push(&mut self, sums: &BlockSums) {
        let Some(last) = self.last.replace(*sums) else { return };
        let before = self.before.replace(last.mean()).unwrap_or(f64::NAN);
        let square = (WINDOW as f64 * last.farthest([before, sums.mean()])).powi(2);
        self.squares.push(self.squares.total.into(), square, || square);
    }
}

/// A full window.
#[derive(Clone, Copy, Debug)]
struct Window {
    number: u64,
    sum: i64,
    spread: f64,
}

/// A change of mean below this share of the standard deviation in its windows is no peak: one
/// outlier moves the mean of 32 samples by a fifth of the deviation that it causes in them.
const LEAST_CHANGE: f64 = 0.5;

impl WindowStatistics {
    pub(crate) fn push(&mut self, number: u64, sums: &BlockSums, spread: f64) {
        let window = Window { number, sum: sums.sum, spread };
        if let Some(last) = self.last.replace(window) {
            self.add_change(&last, &window);
        }
        // A single outlier belongs to the tails; a disturbance has more.
        self.spreads.push(number, spread, || sums.spread_without_farthest(spread));
    }

    /// No change is computed across a break.
    pub(crate) const fn part(&mut self) {
        self.last = None;
    }

    /// The change between neighbours.
    fn add_change(&mut self, last: &Window, window: &Window) {
        if last.number + 1 == window.number {
            let change = (window.sum - last.sum).unsigned_abs() as f64;
            let least = LEAST_CHANGE * LEAST_CHANGE * window.spread.max(last.spread);
            self.changes.push(window.number, change, || if change * change < least { 0.0 } else { change });
        }
    }
}

/// Frequencies of positive numbers in bins of an eighth of an octave, and the highest peaks. At
/// most 2.4 KiB for numbers below 2^75.
#[derive(Clone, Debug, Default)]
pub(crate) struct Magnitudes {
    /// From the lowest bin on.
    frequencies: Vec<u32>,
    pub(crate) total: u32,
    last: Option<Cell>,
    /// Ascending peaks of the earlier cells.
    highest: Vec<PeakWindows>,
    /// The lowest of these, if the maximum number is kept.
    least: f64,
}

/// The numbers that the windows of a cell count as, 0 if they are too low to matter.
#[derive(Clone, Copy, Debug)]
struct Cell {
    number: u64,
    highest: f64,
    peaks: [f64; CELL as usize],
}

/// Consecutive windows of one cell whose numbers are at least half of the highest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PeakWindows {
    pub(crate) first_window: u64,
    pub(crate) last_window: u64,
    pub(crate) peak: f64,
}

impl Magnitudes {
    /// Adds the number of one window: not negative, and finite. `peak`, at most as high, is its
    /// number among the highest.
    pub(crate) fn push(&mut self, window: u64, number: f64, peak: impl FnOnce() -> f64) {
        let bin = bin_of(number);
        if self.frequencies.len() <= bin {
            self.frequencies.resize(bin + 1, 0);
        }
        self.frequencies[bin] = self.frequencies[bin].saturating_add(1);
        self.total = self.total.saturating_add(1);
        // A number below half of the lowest is not part of a higher one.
        if number >= self.least / 2.0 {
            let number = window / CELL;
            if self.last.is_none_or(|last| last.number != number) {
                self.begin_cell(number);
            }
            if let Some(last) = &mut self.last {
                let peak = peak();
                last.peaks[(window % CELL) as usize] = peak;
                last.highest = last.highest.max(peak);
            }
        }
    }

    fn begin_cell(&mut self, number: u64) {
        let ended = self.last.replace(Cell { number, highest: 0.0, peaks: [0.0; CELL as usize] });
        if let Some(stretch) = ended.filter(|ended| ended.highest >= self.least).and_then(|ended| ended.stretch()) {
            keep(&mut self.highest, stretch);
            self.least = if self.highest.len() == KEPT { self.highest[0].peak } else { 0.0 };
        }
    }

    /// The number that a fraction `p` of all does not exceed; `None` without numbers.
    pub(crate) fn quantile(&self, p: f64) -> Option<f64> {
        let mut missing = p * f64::from(self.total);
        for (bin, &frequency) in self.frequencies.iter().enumerate() {
            let frequency = f64::from(frequency);
            if frequency > 0.0 && missing <= frequency {
                let (lower, upper) = (lowest_of(bin), lowest_of(bin + 1));
                return Some(lower + (upper - lower) * missing / frequency);
            }
            missing -= frequency;
        }
        None
    }

    /// How many exceed `limit`.
    pub(crate) fn above(&self, limit: f64) -> f64 {
        let share = |bin: usize| {
            let (lower, upper) = (lowest_of(bin), lowest_of(bin + 1));
            ((upper - limit) / (upper - lower)).clamp(0.0, 1.0)
        };
        self.frequencies.iter().enumerate().map(|(bin, &frequency)| f64::from(frequency) * share(bin)).sum()
    }

    /// At most 16, in ascending order of their peaks; those of neighbouring cells may be parts of one.
    pub(crate) fn highest(&self) -> Vec<PeakWindows> {
        let mut highest = self.highest.clone();
        self.last.iter().filter_map(Cell::stretch).for_each(|stretch| keep(&mut highest, stretch));
        highest
    }
}

/// Keeps the highest; for equal peaks the first ones.
fn keep(highest: &mut Vec<PeakWindows>, stretch: PeakWindows) {
    let is_below = |kept: &PeakWindows| {
        let order = kept.peak.total_cmp(&stretch.peak).then(stretch.first_window.cmp(&kept.first_window));
        order.is_lt()
    };
    let place = highest.partition_point(is_below);
    highest.insert(place, stretch);
    if highest.len() > KEPT {
        highest.remove(0);
    }
}

impl Cell {
    /// The stretch around its highest number, the first of equal ones; `None` if it has none.
    fn stretch(&self) -> Option<PeakWindows> {
        let highest = |best: usize, (place, peak): (usize, &f64)| if *peak > self.peaks[best] { place } else { best };
        let place = self.peaks.iter().enumerate().fold(0, highest);
        let peak = self.peaks[place];
        let is_part = |number: &&f64| **number >= peak / 2.0;
        let before = self.peaks[..place].iter().rev().take_while(is_part).count() as u64;
        let behind = self.peaks[place + 1..].iter().take_while(is_part).count() as u64;
        let window = self.number * CELL + place as u64;
        (peak > 0.0).then_some(PeakWindows { first_window: window - before, last_window: window + behind, peak })
    }
}

fn bin_of(number: f64) -> usize {
    ((number.max(0.5).to_bits() >> (f64::MANTISSA_DIGITS - 1 - FRACTION_BITS)) - LOWEST_BITS) as usize
}

fn lowest_of(bin: usize) -> f64 {
    let lowest = f64::from_bits((bin as u64 + LOWEST_BITS) << (f64::MANTISSA_DIGITS - 1 - FRACTION_BITS));
    if lowest < 1.0 { 0.0 } else { lowest }
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};

    use super::*;

    fn of(numbers: &[f64]) -> Magnitudes {
        let mut magnitudes = Magnitudes::default();
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
        fn the_highest_numbers_are_those_of_the_highest_cells(
            numbers in vec((0.0..6_f64).prop_map(f64::exp2), 1..900),
        ) {
            let cells = numbers.chunks(CELL as usize).map(|cell| cell.iter().copied().fold(0.0, f64::max));
            let mut cells: Vec<f64> = cells.collect();
            cells.sort_by(|a, b| b.total_cmp(a));
            let mut kept: Vec<_> = of(&numbers).highest().iter().map(|stretch| stretch.peak).collect();
            kept.sort_by(|a, b| b.total_cmp(a));
            let places = cells.len().min(KEPT);
            prop_assert_eq!(&kept[..places], &cells[..places]);
        }
    }

    #[test]
    fn a_stretch_begins_and_ends_at_half_of_its_peak() {
        let mut numbers = vec![1.0; 100];
        numbers[40..46].copy_from_slice(&[3.0, 4.0, 9.0, 20.0, 11.0, 9.0]);
        let magnitudes = of(&numbers);
        let highest = magnitudes.highest().pop().unwrap();
        assert_eq!(highest, PeakWindows { first_window: 43, last_window: 44, peak: 20.0 });
    }
}
