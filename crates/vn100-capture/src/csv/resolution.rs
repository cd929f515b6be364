//! How the numbers of a column become counts, with as many decimals as its first rows have.

use vn100_protocol::stream::RejectedRow;

use super::number::{LastDigit, Number};

/// Rows looked at, as far as the head of the file holds them.
pub(super) const SCANNED_ROWS: usize = 1000;

/// A channel that is not exact leaves room for values this many times larger than its first ones.
const HEADROOM: f64 = 64.0;

/// More decimals than this are never kept.
const MOST_DECIMALS: u32 = 18;

/// The fewest and the most decimals of a channel whose first numbers are all zero.
const UNSEEN_DECIMALS: (u32, u32) = (6, 9);

/// What the first rows of a column print.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ColumnScan {
    /// Numbers other than zero.
    nonzero: u32,
    largest: f64,
    printed: Most,
    significant: Most,
}

/// The most decimals, and how many numbers have them.
#[derive(Debug, Clone, Copy, Default)]
struct Most {
    decimals: u32,
    numbers: u32,
}

/// How a number becomes a count.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quantizer {
    pub(super) decimals: u8,
    pub(super) last_digit: LastDigit,
    /// Taken off every count.
    zero_counts: i64,
    pub(super) limit_counts: i32,
}

/// What is known of a channel beforehand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior {
    /// Fewer decimals than this are not taken.
    pub(super) decimals: u8,
    /// The largest magnitude of a value, where that is known.
    pub(super) limit: Option<f64>,
    /// As in [`Unit`](super::column_map::Unit).
    pub(super) zero_hundredths: i64,
}

impl Quantizer {
    #[inline]
    pub(super) fn count(&self, number: &Number) -> Result<i32, RejectedRow> {
        let count = number.count(self.decimals, self.last_digit)?.saturating_sub(self.zero_counts);
        if count.unsigned_abs() > u64::from(self.limit_counts.unsigned_abs()) {
            return Err(RejectedRow::Range);
        }
        i32::try_from(count).map_err(|_| RejectedRow::Range)
    }
}

impl ColumnScan {
    pub(super) fn add(&mut self, number: &Number) {
        let magnitude = number.magnitude();
        // zeros are printed shorter by some scripts, and are no evidence
        self.nonzero += u32::from(magnitude > 0.0);
        self.largest = self.largest.max(magnitude);
        self.printed.add(number.decimals(), magnitude);
        self.significant.add(number.significant_decimals(), magnitude);
    }

    pub(super) fn quantizer(&self, prior: Prior) -> Quantizer {
        let (decimals, last_digit) = self.resolution(prior);
        let power = 10_f64.powi(decimals.into());
        // a cast saturates
        let limit_counts = prior.limit.map_or(i32::MAX, |limit| (limit * power).round() as i32);
        let zero_counts = (prior.zero_hundredths as f64 * power / 100.0) as i64;
        Quantizer { decimals, last_digit, zero_counts, limit_counts }
    }

    /// The decimals as they stand, when they are a last digit: at least half of the numbers have
    /// them (nine in ten have where a script drops zeros at the end), and the largest number fits
    /// 32 bits with them. Otherwise the numbers are floats printed in full, whose last digits mean
    /// nothing: as many decimals as fit with room for larger values, and the rest is rounded away.
    fn resolution(&self, prior: Prior) -> (u8, LastDigit) {
        let prior_decimals = u32::from(prior.decimals);
        if prior.limit.is_some() && self.printed.decimals <= prior_decimals {
            return (prior.decimals, LastDigit::Exact);
        }
        for most in [self.printed, self.significant] {
            let kept = most.decimals.max(prior_decimals);
            let is_last_digit = self.nonzero > 0 && 2 * most.numbers >= self.nonzero;
            if is_last_digit && kept <= MOST_DECIMALS && fits(self.largest, kept) {
                return (kept as u8, LastDigit::Exact);
            }
        }
        let limit = prior.limit.unwrap_or(HEADROOM * self.largest);
        let wanted = if self.nonzero > 0 {
            self.printed.decimals.min(MOST_DECIMALS)
        } else {
            let (fewest, most) = UNSEEN_DECIMALS;
            self.printed.decimals.clamp(fewest, most)
        };
        let kept = (0..=wanted).rev().find(|&kept| fits(limit, kept));
        (kept.unwrap_or(0).max(prior_decimals) as u8, LastDigit::Rounded)
    }
}

/// Whether `largest` with this many decimals is a count of 32 bits.
fn fits(largest: f64, decimals: u32) -> bool {
    largest * 10_f64.powi(decimals as i32) <= f64::from(i32::MAX)
}

impl Most {
    fn add(&mut self, decimals: u32, magnitude: f64) {
        if decimals > self.decimals {
            *self = Self { decimals, numbers: 0 };
        }
        self.numbers += u32::from(decimals == self.decimals && magnitude > 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::{LastDigit::*, *};

    const ANY: Prior = Prior { decimals: 0, limit: None, zero_hundredths: 0 };
    const RATE: Prior = Prior { decimals: 6, limit: Some(40.0), zero_hundredths: 0 };

    fn resolution(fields: &[&str], prior: Prior) -> (u8, LastDigit) {
        let mut scan = ColumnScan::default();
        for field in fields {
            scan.add(&Number::parse(field.as_bytes()).unwrap());
        }
        scan.resolution(prior)
    }

    #[test]
    fn decimals_are_taken_as_they_stand() {
        assert_eq!(resolution(&["1.25", "-0.5", "0.25"], ANY), (2, Exact));
        assert_eq!(resolution(&["1.50", "-0.50"], ANY), (2, Exact));
        assert_eq!(resolution(&["3", "-4"], ANY), (0, Exact));
        assert_eq!(resolution(&["1e-05", "0.00012"], ANY), (5, Exact));
        // zeros are no evidence against a last digit
        assert_eq!(resolution(&["0.0", "0.0", "0.0", "0.125"], ANY), (3, Exact));
    }

    #[test]
    fn zeros_that_do_not_fit_are_dropped() {
        assert_eq!(resolution(&["9.851000000000", "-9.8"], ANY), (3, Exact));
        assert_eq!(resolution(&["0.000021", "2147483647"], ANY).1, Rounded);
    }

    #[test]
    fn floats_printed_in_full_are_rounded_with_room_above() {
        let floats = ["0.00123456789012345", "-0.0098765432109876", "0.0000456789012345678"];
        // 64 * 0.0098.. = 0.632: nine decimals fit, ten do not
        assert_eq!(resolution(&floats, ANY), (9, Rounded));
        // up to 40 rad/s must fit
        assert_eq!(resolution(&floats, RATE), (7, Rounded));
    }

    #[test]
    fn a_few_longer_numbers_are_floats() {
        // six significant digits: the longest are the smallest, and smaller ones come
        assert_eq!(resolution(&["0.123456", "0.0123456", "0.234567", "0.345678"], ANY), (7, Rounded));
    }

    #[test]
    fn a_known_message_keeps_its_decimals() {
        assert_eq!(resolution(&[], RATE), (6, Exact));
        assert_eq!(resolution(&["0.5", "0.25"], RATE), (6, Exact));
        assert_eq!(resolution(&["0.0000"], RATE), (6, Exact));
        assert_eq!(resolution(&["0.12345678"], RATE), (8, Exact));
        // as one script prints every float: the true decimals, then noise of the conversion
        assert_eq!(resolution(&["-1.234000000000000095e-03"], RATE), (7, Rounded));
    }

    #[test]
    fn nothing_but_zeros_leaves_room_for_decimals() {
        assert_eq!(resolution(&["0.0", "0"], ANY), (6, Rounded));
        assert_eq!(resolution(&["0.00000000"], ANY), (8, Rounded));
        assert_eq!(resolution(&[], ANY), (6, Rounded));
    }
}
