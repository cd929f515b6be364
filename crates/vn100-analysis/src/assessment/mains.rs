//! Mains frequencies as a stream shows them: above half the output rate they are folded down.

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

    /// The true frequency, in hertz.
    pub(super) fn hz(self) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mains_are_found_by_their_alias() {
        for (line_hz, rate_hz, expected) in [
            (20.0, 40.0, Some(60.0)),
            (10.05, 40.0, Some(50.0)),
            (5.0, 55.0, Some(50.0)),
            (50.0, 200.0, Some(50.0)),
            (100.0, 400.0, Some(100.0)),
            (20.0, 200.0, Some(180.0)),
            (10.0, 25.0, Some(60.0)),
            (18.45, 40.0, None),
            (0.23, 1.0, None),
            (0.1, 5.0, None),
        ] {
            assert_eq!(Mains::at(line_hz, rate_hz).map(Mains::hz), expected, "{line_hz}");
        }
    }
}
