//! Mains frequencies as a stream shows them: above half the output rate they are folded down.

use std::{cmp::Ordering, fmt};

/// A harmonic of the mains that a stream shows at another frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mains {
    harmonic: u32,
    mains_hz: f64,
    rate_hz: f64,
}

impl Mains {
    /// The lowest harmonic of mains that shows at `line_hz` at this output rate.
    pub(super) fn at(line_hz: f64, rate_hz: f64) -> Option<Self> {
        /// Mains keep their frequency to a few tenths of a percent.
        const WANDER: f64 = 0.002;
        /// As a share of the output rate, how far they may wander.
        const PLACED: f64 = 0.01;
        let candidates = [1, 2, 3]
            .into_iter()
            .flat_map(|harmonic| [50.0, 60.0].map(|mains_hz| Self { harmonic, mains_hz, rate_hz }));
        // at a low rate the wander covers much of the band, and any line would be that of mains
        let mut placed = candidates.filter(|mains| WANDER * mains.hz() <= PLACED * rate_hz);
        placed.find(|mains| (mains.shown_hz() - line_hz).abs() <= WANDER * mains.hz())
    }

    fn hz(self) -> f64 {
        f64::from(self.harmonic) * self.mains_hz
    }

    /// The multiple of the output rate next to it.
    fn nearest_multiple(self) -> f64 {
        // half way between two of them: the lower one
        (self.hz() / self.rate_hz - 0.5).ceil()
    }

    fn shown_hz(self) -> f64 {
        (self.hz() - self.nearest_multiple() * self.rate_hz).abs()
    }
}

impl fmt::Display for Mains {
    /// With the arithmetic of its alias.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (hz, multiple) = (self.hz(), self.nearest_multiple());
        write!(f, "{} Hz", self.mains_hz)?;
        if self.harmonic > 1 {
            write!(f, ", {hz} Hz of it")?;
        }
        let rate = if multiple == 1.0 { format!("{}", self.rate_hz) } else { format!("{multiple} x {}", self.rate_hz) };
        match hz.total_cmp(&(multiple * self.rate_hz)) {
            _ if multiple == 0.0 => Ok(()),
            Ordering::Less => write!(f, ", which shows at {rate} - {hz} = {:.2} Hz", self.shown_hz()),
            Ordering::Equal | Ordering::Greater => {
                write!(f, ", which shows at {hz} - {rate} = {:.2} Hz", self.shown_hz())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mains_are_named_with_the_arithmetic_of_their_alias() {
        for (line_hz, rate_hz, expected) in [
            (20.0, 40.0, Some("60 Hz, which shows at 60 - 40 = 20.00 Hz")),
            (10.05, 40.0, Some("50 Hz, which shows at 50 - 40 = 10.00 Hz")),
            (5.0, 55.0, Some("50 Hz, which shows at 55 - 50 = 5.00 Hz")),
            (50.0, 200.0, Some("50 Hz")),
            (100.0, 400.0, Some("50 Hz, 100 Hz of it")),
            (20.0, 200.0, Some("60 Hz, 180 Hz of it, which shows at 200 - 180 = 20.00 Hz")),
            (10.0, 25.0, Some("60 Hz, which shows at 60 - 2 x 25 = 10.00 Hz")),
            (18.45, 40.0, None),
            (0.23, 1.0, None),
            (0.1, 5.0, None),
        ] {
            assert_eq!(Mains::at(line_hz, rate_hz).map(|mains| mains.to_string()).as_deref(), expected, "{line_hz}");
        }
    }
}
