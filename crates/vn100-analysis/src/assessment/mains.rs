//! Mains frequencies as a stream shows them: above half the output rate they are folded down.

/// The lowest harmonic of mains, in hertz, that shows at `line_hz` at this output rate.
pub(super) fn mains_hz(line_hz: f64, rate_hz: f64) -> Option<f64> {
    /// Mains keep their frequency to a few tenths of a percent.
    const WANDER: f64 = 0.002;
    /// As a share of the output rate, how far they may wander.
    const PLACED: f64 = 0.01;
    let shown_hz = |hz: f64| {
        // half way between two multiples of the output rate: from the lower one
        let multiple = (hz / rate_hz - 0.5).ceil();
        (hz - multiple * rate_hz).abs()
    };
    let harmonics = [1.0, 2.0, 3.0].into_iter().flat_map(|harmonic| [50.0, 60.0].map(|hz| harmonic * hz));
    // at a low rate the wander covers much of the band, and any line would be that of mains
    let mut placed = harmonics.filter(|hz| WANDER * hz <= PLACED * rate_hz);
    placed.find(|hz| (shown_hz(*hz) - line_hz).abs() <= WANDER * hz)
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
            assert_eq!(mains_hz(line_hz, rate_hz), expected, "{line_hz}");
        }
    }
}
