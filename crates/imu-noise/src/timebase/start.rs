//! The first lines: held until their rate is clear.

use super::listed::{TOO_FAST, fastest, snap};
use super::rate::{even, is_whole, rounded, steady, whole};
use super::stretches::{STRETCH_TOLERANCE, Stretch, Stretches};
use super::{NominalRate, Refusal};

/// Most stretches held while no rate is clear.
const START_STRETCHES: usize = 16;

/// Most lines held; a backlog of the reader has drained by then.
const START_LINES: usize = 1024;

/// Lines whose earliest arrival is taken together.
const EDGE_LINES: usize = 32;

/// Fewest such groups that have a lower edge: the first ones may be a backlog.
const MIN_EDGE_GROUPS: usize = 8;

/// Stretches after which one kind of evidence is enough: together they bend by one period in 124.
const SEVERAL_STRETCHES: usize = 4;

/// A measured rate is this near to that of the sensor: what the stretches bend, and far more than a
/// clock is off.
const LISTED_TOLERANCE: f64 = 0.01;

/// A rate given beforehand is this near to the measured one.
const KNOWN_TOLERANCE: f64 = 0.05;

/// So many intervals in a row, and so long a time of them, bear out a known rate: ten times as long
/// as bunching usually lasts, so that reads at another pace, and what drains of a backlog, do not
/// look like it.
const EVEN_INTERVALS: usize = 4;
const EVEN_S: f64 = 1.0;

/// Part of a period by which each of these intervals may be longer or shorter.
const EVEN_TOLERANCE: f64 = 0.1;

/// Reads at another pace make all intervals whole periods of it: 1.6 times as fast as the lines at
/// most, 25 Hz read at 40, if some are to be single ones at one of the sensor's rates.
const PACED: f64 = 1.75;

/// Time by which bunching may bend a short record.
const BUNCHING_S: f64 = 0.1;

/// What the first lines were held for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beginning {
    /// The rate lines stand for.
    pub(super) nominal: NominalRate,
    /// The rate by which they are placed.
    pub(super) placing: Placing,
}

/// A rate to place lines by, in Hz.
#[derive(Clone, Copy, Debug)]
pub(super) enum Placing {
    /// One of the sensor's, or the one given: right but for a clock's error.
    Listed(f64),
    /// As measured: too coarse not to be mended as the record grows.
    Measured(f64),
}

impl Placing {
    pub(super) const fn hz(self) -> f64 {
        match self {
            Self::Listed(hz) | Self::Measured(hz) => hz,
        }
    }
}

/// Lines without a place, and what is known of their rate.
#[derive(Clone, Debug)]
pub(super) struct Start {
    /// The sensor's rates, and the known one.
    listed_hz: Vec<f64>,
    fastest_hz: f64,
    known_hz: Option<f64>,
    /// Lines before the clock went back.
    unstamped: u64,
    held_s: Vec<f64>,
    cutter: Stretches,
    stretches: Vec<Stretch>,
}

impl Start {
    pub(super) fn new(rates_hz: &[f64], known_hz: Option<f64>) -> Self {
        Self {
            listed_hz: rates_hz.iter().copied().chain(known_hz).collect(),
            fastest_hz: fastest(rates_hz),
            known_hz,
            unstamped: 0,
            held_s: Vec::new(),
            cutter: Stretches::default(),
            stretches: Vec::new(),
        }
    }

    /// The rate is said to be this one.
    pub(super) fn know(&mut self, known_hz: f64) {
        self.listed_hz.push(known_hz);
        self.known_hz = Some(known_hz);
    }

    /// Adds a line's stamp; the rate, when it is clear now, or why there is none.
    pub(super) fn push(&mut self, at_s: f64) -> Option<Result<Beginning, Refusal>> {
        self.held_s.push(at_s);
        if let Some(known_hz) = self.known_hz.filter(|&known_hz| self.comes_evenly_at(known_hz)) {
            let placing = Placing::Listed(known_hz);
            return Some(Ok(Beginning { nominal: NominalRate::Known(known_hz), placing }));
        }
        let stretch = self.cutter.push(at_s);
        self.stretches.extend(stretch);
        let lasting = self.held_s.len() >= START_LINES;
        let full = lasting || self.stretches.len() >= START_STRETCHES;
        if lasting || stretch.is_some() { self.decide(full, lasting) } else { None }
    }

    /// The same when these lines are all there will be; nothing for a single line, or none, of
    /// unknown rate.
    pub(super) fn finish(&self) -> Option<Result<Beginning, Refusal>> {
        self.decide(true, true)
    }

    /// The clock went back: the stamps so far have nothing to do with those that follow.
    pub(super) fn restart(&mut self) {
        self.unstamped += self.held_s.len() as u64;
        self.held_s.clear();
        self.cutter = Stretches::default();
        self.stretches.clear();
    }

    /// Lines held whose stamps are not used, and the stamps of those behind them.
    pub(super) fn take_held(&mut self) -> (u64, Vec<f64>) {
        (std::mem::take(&mut self.unstamped), std::mem::take(&mut self.held_s))
    }

    /// Lines held.
    pub(super) fn lines(&self) -> u64 {
        self.unstamped + self.held_s.len() as u64
    }

    /// The rate or the refusal: when `full` the best that can be had, unless a known rate is
    /// contradicted by what may not be `lasting`.
    fn decide(&self, full: bool, lasting: bool) -> Option<Result<Beginning, Refusal>> {
        let clear = self.clear(full);
        if let Some(known_hz) = self.known_hz {
            let nominal = NominalRate::Known(known_hz);
            let agreed = clear.filter(|placing| is_near(placing.hz(), known_hz));
            if let Some(placing) = agreed.or_else(|| self.unclear_at(known_hz, clear, full)) {
                return Some(Ok(Beginning { nominal, placing }));
            }
            if !lasting && !matches!(clear, Some(Placing::Listed(_))) {
                return None;
            }
        }
        let Some(placing) = clear.or_else(|| if full { self.unclear() } else { None }) else {
            let lines = self.held_s.len() as u64;
            return (full && lines > 1).then_some(Err(Refusal::NoTimePasses { lines }));
        };
        let measured_hz = placing.hz();
        Some(match (placing, self.known_hz) {
            (Placing::Measured(_), _) if measured_hz > TOO_FAST * self.fastest_hz => {
                Err(Refusal::TooFast { measured_hz, fastest_hz: self.fastest_hz })
            }
            (_, Some(known_hz)) => Err(Refusal::OtherRate { known_hz, measured_hz }),
            (Placing::Listed(hz), None) => Ok(Beginning { nominal: NominalRate::Snapped(hz), placing }),
            (Placing::Measured(hz), None) => Ok(Beginning { nominal: NominalRate::Measured(hz), placing }),
        })
    }

    /// Whether the last lines came alone, none lost, at this rate. At a low one that is known long
    /// before a stretch is over.
    fn comes_evenly_at(&self, hz: f64) -> bool {
        let intervals = EVEN_INTERVALS.max((EVEN_S * hz).ceil() as usize);
        let Some(first) = self.held_s.len().checked_sub(1).and_then(|last| last.checked_sub(intervals)) else {
            return false;
        };
        let last_s = &self.held_s[first..];
        let even = |pair: &[f64]| ((pair[1] - pair[0]) * hz - 1.0).abs() < EVEN_TOLERANCE;
        let mean_hz = intervals as f64 / (last_s[intervals] - last_s[0]);
        (mean_hz / hz - 1.0).abs() <= LISTED_TOLERANCE && last_s.windows(2).all(even)
    }

    /// The rate by intervals or stretches, once one of them is clear; when `full` it need not be
    /// one of the sensor's.
    fn clear(&self, full: bool) -> Option<Placing> {
        let steady_hz = steady(&self.held_s);
        let even_hz = even(&self.stretches).filter(|hz| steady_hz.is_some() || !self.is_bent_by_losses(*hz));
        let listed = |hz: f64| snap(&self.listed_hz, hz, LISTED_TOLERANCE);
        let (steady_listed, even_listed) = (steady_hz.and_then(listed), even_hz.and_then(listed));
        if steady_listed.is_some() && steady_listed == even_listed {
            return steady_listed.map(Placing::Listed);
        }
        // Lines read once in a while look like some of a faster stream; losses bend the stretches in the end.
        let differ = steady_hz.zip(even_hz).is_some_and(|(a_hz, b_hz)| (a_hz / b_hz - 1.0).abs() > STRETCH_TOLERANCE);
        let several = self.stretches.len() >= SEVERAL_STRETCHES && !differ;
        let listed_hz = even_listed.or(steady_listed).filter(|_| full || several);
        if listed_hz.is_some() || !full {
            return listed_hz.map(Placing::Listed);
        }
        let hz = if differ { even_hz } else { steady_hz.or(even_hz) };
        hz.map(|hz| Placing::Measured(rounded(hz)))
    }

    /// The likeliest rate where neither intervals nor stretches tell one.
    fn unclear(&self) -> Option<Placing> {
        let edge_hz = self.known_hz.or_else(|| self.mean_hz()).and_then(|near_hz| self.edge_hz(near_hz));
        let is_listed = |hz: f64| snap(&self.listed_hz, hz, LISTED_TOLERANCE).is_some();
        // The fastest stretch has the fewest losses.
        let is_sound = |hz: &f64| self.known_hz.is_some() || (is_listed(*hz) && !self.is_bent_by_losses(*hz));
        let hz = edge_hz
            .filter(is_sound)
            .or_else(|| whole(&self.held_s, &self.listed_hz))
            .or_else(|| self.fastest_stretch_hz())
            .or_else(|| self.mean_hz())?;
        let near_hz = snap(&self.listed_hz, hz, STRETCH_TOLERANCE);
        Some(near_hz.map_or(Placing::Measured(rounded(hz)), Placing::Listed))
    }

    /// Whether losses all the time made this of a higher rate: they bend stretches and edge, even
    /// to another of the sensor's rates by chance, but leave whole periods.
    fn is_bent_by_losses(&self, hz: f64) -> bool {
        whole(&self.held_s, &self.listed_hz).is_some_and(|whole_hz| whole_hz > PACED * hz)
    }

    /// How lines are placed whose rate is not clear, or clear only as measured, if nothing better
    /// contradicts the known one.
    fn unclear_at(&self, known_hz: f64, clear: Option<Placing>, full: bool) -> Option<Placing> {
        let several = self.stretches.len() >= SEVERAL_STRETCHES;
        // Lines read once in a while look like some of a faster stream, but come evenly.
        let other_even = several && even(&self.stretches).is_some_and(|hz| !is_near(hz, known_hz));
        if (full || several) && !other_even && is_whole(&self.held_s, known_hz) {
            return Some(Placing::Listed(known_hz));
        }
        if !full {
            return None;
        }
        if self.stretches.is_empty() {
            return self.is_short_at(known_hz).then_some(Placing::Listed(known_hz));
        }
        if matches!(clear, Some(Placing::Listed(_))) {
            return None;
        }
        // A few losses spoil the stretches, and reads at a steady pace make intervals of their own: not so the edge.
        let whole_hz = whole(&self.held_s, &self.listed_hz);
        let sound_hz = self.edge_hz(known_hz).into_iter().chain(whole_hz);
        let fastest_hz = self.fastest_stretch_hz().filter(|_| clear.is_none());
        let near_hz = sound_hz.chain(fastest_hz).find(|&hz| is_near(hz, known_hz));
        let near_hz = near_hz.or_else(|| (clear.is_none() && self.is_short_at(known_hz)).then_some(known_hz))?;
        Some(Placing::Listed(snap(&self.listed_hz, near_hz, LISTED_TOLERANCE).unwrap_or(known_hz)))
    }

    /// The rate of the lower edge of the lags: the median step between the earliest arrivals of
    /// neighbouring groups of lines, against any rate near it. A backlog or losses bend it only
    /// when most groups have some.
    fn edge_hz(&self, near_hz: f64) -> Option<f64> {
        let lags_s: Vec<f64> =
            self.held_s.iter().enumerate().map(|(line, at_s)| at_s - line as f64 / near_hz).collect();
        let least_s: Vec<f64> =
            lags_s.chunks_exact(EDGE_LINES).map(|group| group.iter().copied().fold(f64::INFINITY, f64::min)).collect();
        if least_s.len() < MIN_EDGE_GROUPS {
            return None;
        }
        let mut steps_s: Vec<f64> = least_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let middle = steps_s.len() / 2;
        let step_s = *steps_s.select_nth_unstable_by(middle, f64::total_cmp).1;
        let period_s = near_hz.recip() + step_s / EDGE_LINES as f64;
        (period_s > 0.0).then(|| period_s.recip())
    }

    /// The rate of the fastest stretch: losses lower those of others.
    fn fastest_stretch_hz(&self) -> Option<f64> {
        self.stretches.iter().map(|stretch| stretch.hz()).max_by(f64::total_cmp)
    }

    fn mean_hz(&self) -> Option<f64> {
        let span_s = self.span_s()?;
        (span_s > 0.0).then(|| (self.held_s.len() - 1) as f64 / span_s)
    }

    /// Whether so many lines at this rate take that long, but for bunching.
    fn is_short_at(&self, known_hz: f64) -> bool {
        let expected_s = self.held_s.len().saturating_sub(1) as f64 / known_hz;
        let within_s = KNOWN_TOLERANCE * expected_s + BUNCHING_S;
        self.span_s().is_some_and(|span_s| (span_s - expected_s).abs() <= within_s)
    }

    fn span_s(&self) -> Option<f64> {
        Some(self.held_s.last()? - self.held_s.first()?)
    }
}

fn is_near(measured_hz: f64, known_hz: f64) -> bool {
    (measured_hz / known_hz - 1.0).abs() <= KNOWN_TOLERANCE
}
