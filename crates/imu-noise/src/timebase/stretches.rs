//! Rates over stretches of 32 lines.

/// Intervals in a stretch, at least.
const STRETCH_INTERVALS: u64 = 31;

/// A rate measured over one stretch is this uncertain.
pub(super) const STRETCH_TOLERANCE: f64 = 0.05;

/// A part of the stream.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    pub(super) intervals: u64,
    pub(super) span_s: f64,
}

impl Stretch {
    pub(super) fn hz(self) -> f64 {
        self.intervals as f64 / self.span_s
    }
}

/// Cuts the stream into stretches of 32 lines, or some more: each begins and ends with the last
/// line of a read, where the lag is least, so that bunching bends its rate by one period in 31 at
/// most. The last line of one is the first of the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Stretches {
    /// Where the present stretch began: its first line's number and stamp.
    start: Option<(u64, f64)>,
    /// Number of the next line.
    line: u64,
    previous_s: f64,
}

impl Stretches {
    /// Adds a line's stamp; the stretch that ended with the line before, when one did.
    pub(super) fn push(&mut self, at_s: f64) -> Option<Stretch> {
        let (line, previous_s) = (self.line, self.previous_s);
        self.line += 1;
        self.previous_s = at_s;
        let waited_s = at_s - previous_s;
        let Some((start, start_s)) = self.start else {
            if line > 0 && waited_s > 0.0 {
                self.start = Some((line - 1, previous_s));
            }
            return None;
        };
        let intervals = line - 1 - start;
        if intervals < STRETCH_INTERVALS {
            return None;
        }
        let span_s = previous_s - start_s;
        if span_s <= 0.0 || waited_s < 0.5 * span_s / intervals as f64 {
            return None;
        }
        self.start = Some((line - 1, previous_s));
        Some(Stretch { intervals, span_s })
    }
}
