//! The first samples, pending until their rate is known.

use super::base_step::rate_by_base_step;
use super::gap_event::{NominalRate, Refusal};
use super::rate_estimates::{
    COARSE_TOLERANCE, LISTED_TOLERANCE, RUN, RateStretch, StretchCutter, TOO_FAST, fastest, is_whole_periods,
    lowest_whole_rate, rate_by_intervals, rate_by_stretches, rounded, snap,
};
use super::read_pattern::BUNCHING_S;

/// The most pending stretches without a rate. Chosen: half of [`MAX_SAMPLES`] where they are short.
pub(super) const MANY_STRETCHES: usize = 16;

/// The most pending samples: 5 s at 200 Hz, in which a reader has caught up with a backlog.
const MAX_SAMPLES: usize = 1024;

/// The number of stretches from which one kind of estimate is enough: bunching biases four
/// stretches together by one period in 124.
const SEVERAL_STRETCHES: usize = 4;

/// The least number of runs with a lower edge: the first runs may be a backlog. Chosen.
const MIN_EDGE_RUNS: usize = 8;

/// Number of consecutive single intervals, and seconds of them, that confirm a known rate: ten
/// times [`BUNCHING_S`], so that neither reads at a steady pace nor a backlog that is being read
/// look like them.
const PERIODIC_INTERVALS: usize = 4;
const PERIODIC_S: f64 = 1.0;

/// The fraction of a period by which each of these intervals may differ from one period. Chosen.
const PERIODIC_TOLERANCE: f64 = 0.1;

/// Seconds of arrivals at a listed rate, and the relative difference from it, that outweigh another
/// rate that the sensor reports. Chosen: a pace that is not that of the sensor is so near to one of
/// eleven rates with a probability of 1 in 100.
const CONTRADICTION_S: f64 = 5.0;
const CONTRADICTION_TOLERANCE: f64 = 0.002;

/// The factor from which whole periods of a higher rate show dropped samples. A reader at a steady
/// pace, one of the rates of the sensor, has the same effect up to a factor of 1.6 (25 Hz read at
/// 40 Hz).
const READER_PACE: f64 = 1.75;

/// The rate that was found, and how samples are tracked with it.
pub(super) type InitialRate = (NominalRate, TrackedRate);

/// The rate, in Hz, by which samples are due.
#[derive(Clone, Copy, Debug)]
pub(super) enum TrackedRate {
    /// A listed or known rate: exact except for the error of a clock.
    Listed(f64),
    /// A measured rate, so inaccurate that the fitted rate replaces it as the record grows.
    Measured(f64),
}

impl TrackedRate {
    pub(super) const fn hz(self) -> f64 {
        match self {
            Self::Listed(hz) | Self::Measured(hz) => hz,
        }
    }
}

#[derive(Clone, Debug, Default)]
pub(super) struct RateSearch {
    /// The rates of the sensor, and the known rate.
    listed_hz: Vec<f64>,
    fastest_hz: f64,
    known_hz: Option<f64>,
    /// Whether the known rate is one that the sensor reports, which arrival times may show to be
    /// false.
    is_reported: bool,
    /// Number of samples before the clock was set back; their stamps are not used.
    unstamped: u64,
    pending_s: Vec<f64>,
    cutter: StretchCutter,
    stretches: Vec<RateStretch>,
}

impl RateSearch {
    pub(super) fn new(rates_hz: &[f64], known_hz: Option<f64>) -> Self {
        Self {
            listed_hz: rates_hz.iter().copied().chain(known_hz).collect(),
            fastest_hz: fastest(rates_hz),
            known_hz,
            ..Self::default()
        }
    }

    pub(super) fn set_reported_rate(&mut self, reported_hz: f64) {
        self.listed_hz.push(reported_hz);
        self.known_hz = Some(reported_hz);
        self.is_reported = true;
    }

    pub(super) fn push(&mut self, at_s: f64) -> Option<Result<InitialRate, Refusal>> {
        self.pending_s.push(at_s);
        if let Some(known_hz) = self.known_hz.filter(|&known_hz| self.is_periodic_at(known_hz)) {
            return Some(Ok((NominalRate::Known(known_hz), TrackedRate::Listed(known_hz))));
        }
        let stretch = self.cutter.push(at_s);
        self.stretches.extend(stretch);
        let is_full = self.pending_s.len() >= MAX_SAMPLES;
        let must_decide = is_full || self.stretches.len() >= MANY_STRETCHES;
        if is_full || stretch.is_some() { self.decide(must_decide, is_full) } else { None }
    }

    /// The decision if no sample follows; `None` for a single sample, or none, of unknown rate.
    pub(super) fn finish(&self) -> Option<Result<InitialRate, Refusal>> {
        self.decide(true, true)
    }

    /// The clock was set back: the stamps so far cannot be compared with those that follow.
    pub(super) fn restart(&mut self) {
        self.unstamped = self.samples();
        self.pending_s.clear();
        self.cutter = StretchCutter::default();
        self.stretches.clear();
    }

    /// Takes the number of samples whose stamps are not used, and the stamps of those that follow.
    pub(super) fn take_pending(&mut self) -> (u64, Vec<f64>) {
        (std::mem::take(&mut self.unstamped), std::mem::take(&mut self.pending_s))
    }

    pub(super) fn samples(&self) -> u64 {
        self.unstamped + self.pending_s.len() as u64
    }

    /// The rate, once it is certain; the most likely rate if it `must_decide`. A known rate is
    /// contradicted only when `is_final`.
    fn decide(&self, must_decide: bool, is_final: bool) -> Option<Result<InitialRate, Refusal>> {
        let sure = self.sure_rate(must_decide);
        if let Some(known_hz) = self.known_hz {
            let agreed = sure.filter(|tracked| is_near(tracked.hz(), known_hz));
            if let Some(tracked) = agreed.or_else(|| self.fallback_at(known_hz, sure, must_decide)) {
                return Some(Ok((NominalRate::Known(known_hz), tracked)));
            }
            match sure {
                Some(TrackedRate::Listed(hz)) if self.is_reported => {
                    if self.is_strong_evidence(hz) {
                        return Some(Ok((NominalRate::Snapped(hz), TrackedRate::Listed(hz))));
                    }
                    if !is_final {
                        return None;
                    }
                }
                Some(TrackedRate::Listed(_)) => {}
                _ if !is_final => return None,
                _ => {}
            }
        }
        let Some(tracked) = sure.or_else(|| if must_decide { self.fallback_rate() } else { None }) else {
            let samples = self.pending_s.len() as u64;
            return (must_decide && samples > 1).then_some(Err(Refusal::NoTimePasses { samples }));
        };
        let measured_hz = tracked.hz();
        Some(match (tracked, self.known_hz) {
            (TrackedRate::Measured(_), _) if measured_hz > TOO_FAST * self.fastest_hz => {
                Err(Refusal::TooFast { measured_hz, fastest_hz: self.fastest_hz })
            }
            (_, Some(known_hz)) => Err(Refusal::OtherRate { known_hz, measured_hz }),
            (TrackedRate::Listed(hz), None) => Ok((NominalRate::Snapped(hz), tracked)),
            (TrackedRate::Measured(hz), None) => Ok((NominalRate::Measured(hz), tracked)),
        })
    }

    /// Whether the samples have arrived at this rate for so long and so exactly that the sensor
    /// cannot be sending at another one.
    fn is_strong_evidence(&self, hz: f64) -> bool {
        let estimates_hz = [rate_by_intervals(&self.pending_s), rate_by_stretches(&self.stretches)];
        let is_exact = |measured_hz: &f64| (measured_hz / hz - 1.0).abs() <= CONTRADICTION_TOLERANCE;
        self.span_s().is_some_and(|span_s| span_s >= CONTRADICTION_S) && estimates_hz.iter().flatten().any(is_exact)
    }

    /// Whether no sample is dropped at this rate: at a low rate that is known long before a stretch
    /// ends.
    fn is_periodic_at(&self, hz: f64) -> bool {
        let intervals = PERIODIC_INTERVALS.max((PERIODIC_S * hz).ceil() as usize);
        let Some(first) = self.pending_s.len().checked_sub(1).and_then(|last| last.checked_sub(intervals)) else {
            return false;
        };
        let last_s = &self.pending_s[first..];
        let is_single = |pair: &[f64]| ((pair[1] - pair[0]) * hz - 1.0).abs() < PERIODIC_TOLERANCE;
        let mean_hz = intervals as f64 / (last_s[intervals] - last_s[0]);
        (mean_hz / hz - 1.0).abs() <= LISTED_TOLERANCE && last_s.windows(2).all(is_single)
    }

    /// A listed rate if intervals and stretches agree, or one of them after several stretches.
    fn sure_rate(&self, must_decide: bool) -> Option<TrackedRate> {
        let by_intervals_hz = rate_by_intervals(&self.pending_s);
        let by_stretches_hz =
            rate_by_stretches(&self.stretches).filter(|hz| by_intervals_hz.is_some() || !self.is_biased_by_loss(*hz));
        let listed = |hz: f64| snap(&self.listed_hz, hz, LISTED_TOLERANCE);
        let (intervals_listed, stretches_listed) = (by_intervals_hz.and_then(listed), by_stretches_hz.and_then(listed));
        if intervals_listed.is_some() && intervals_listed == stretches_listed {
            return intervals_listed.map(TrackedRate::Listed);
        }
        // reads at a pace of their own make intervals of another rate; then the stretches are right
        let differ = by_intervals_hz.zip(by_stretches_hz).is_some_and(|(a, b)| (a / b - 1.0).abs() > COARSE_TOLERANCE);
        let several = self.stretches.len() >= SEVERAL_STRETCHES && !differ;
        let listed_hz = stretches_listed.or(intervals_listed).filter(|_| must_decide || several);
        if listed_hz.is_some() || !must_decide {
            return listed_hz.map(TrackedRate::Listed);
        }
        // a list of rates is stronger evidence than a common step
        let by_step_hz = if self.listed_hz.is_empty() { rate_by_base_step(&self.pending_s) } else { None };
        let hz = by_step_hz.or(if differ { by_stretches_hz } else { by_intervals_hz.or(by_stretches_hz) });
        hz.map(|hz| TrackedRate::Measured(rounded(hz)))
    }

    /// The rate where neither intervals nor stretches show one: that of the lower edge, of whole
    /// periods, of the fastest stretch (which has the fewest dropped samples), or the mean rate.
    fn fallback_rate(&self) -> Option<TrackedRate> {
        let edge_hz = self.known_hz.or_else(|| self.mean_hz()).and_then(|near_hz| self.edge_hz(near_hz));
        let is_listed = |hz: f64| snap(&self.listed_hz, hz, LISTED_TOLERANCE).is_some();
        let is_sound = |hz: &f64| self.known_hz.is_some() || (is_listed(*hz) && !self.is_biased_by_loss(*hz));
        let hz = edge_hz
            .filter(is_sound)
            .or_else(|| lowest_whole_rate(&self.pending_s, &self.listed_hz))
            .or_else(|| self.fastest_stretch_hz())
            .or_else(|| self.mean_hz())?;
        let near_hz = snap(&self.listed_hz, hz, COARSE_TOLERANCE);
        Some(near_hz.map_or(TrackedRate::Measured(rounded(hz)), TrackedRate::Listed))
    }

    /// Whether dropped samples have lowered the rate to this one: they bias stretches and edge, but
    /// leave whole periods.
    fn is_biased_by_loss(&self, hz: f64) -> bool {
        lowest_whole_rate(&self.pending_s, &self.listed_hz).is_some_and(|whole_hz| whole_hz > READER_PACE * hz)
    }

    /// How samples are tracked at a known rate that is not confirmed, where nothing more reliable
    /// contradicts it.
    fn fallback_at(&self, known_hz: f64, sure: Option<TrackedRate>, must_decide: bool) -> Option<TrackedRate> {
        let several = self.stretches.len() >= SEVERAL_STRETCHES;
        let other_stretches = several && rate_by_stretches(&self.stretches).is_some_and(|hz| !is_near(hz, known_hz));
        if (must_decide || several) && !other_stretches && is_whole_periods(&self.pending_s, known_hz) {
            return Some(TrackedRate::Listed(known_hz));
        }
        if !must_decide {
            return None;
        }
        if self.stretches.is_empty() {
            return self.spans_time_at(known_hz).then_some(TrackedRate::Listed(known_hz));
        }
        if matches!(sure, Some(TrackedRate::Listed(_))) {
            return None;
        }
        // a few dropped samples bias the stretches, and reads at a steady pace the intervals, but
        // not the edge
        let whole_hz = lowest_whole_rate(&self.pending_s, &self.listed_hz);
        let sound_hz = self.edge_hz(known_hz).into_iter().chain(whole_hz);
        let fastest_hz = self.fastest_stretch_hz().filter(|_| sure.is_none());
        let near_hz = sound_hz.chain(fastest_hz).find(|&hz| is_near(hz, known_hz));
        let near_hz = near_hz.or_else(|| (sure.is_none() && self.spans_time_at(known_hz)).then_some(known_hz))?;
        Some(TrackedRate::Listed(snap(&self.listed_hz, near_hz, LISTED_TOLERANCE).unwrap_or(known_hz)))
    }

    /// The rate of the lower edge of the lags: the median step between the earliest arrivals of
    /// neighbouring runs. A backlog or dropped samples bias the edge only where they are in most
    /// runs.
    fn edge_hz(&self, near_hz: f64) -> Option<f64> {
        let lags_s: Vec<f64> =
            self.pending_s.iter().enumerate().map(|(sample, at_s)| at_s - sample as f64 / near_hz).collect();
        let least_s: Vec<f64> =
            lags_s.chunks_exact(RUN).map(|run| run.iter().copied().fold(f64::INFINITY, f64::min)).collect();
        if least_s.len() < MIN_EDGE_RUNS {
            return None;
        }
        let mut steps_s: Vec<f64> = least_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let middle = steps_s.len() / 2;
        let step_s = *steps_s.select_nth_unstable_by(middle, f64::total_cmp).1;
        let period_s = near_hz.recip() + step_s / RUN as f64;
        (period_s > 0.0).then(|| period_s.recip())
    }

    fn fastest_stretch_hz(&self) -> Option<f64> {
        self.stretches.iter().map(|stretch| stretch.hz()).max_by(f64::total_cmp)
    }

    fn mean_hz(&self) -> Option<f64> {
        let span_s = self.span_s()?;
        (span_s > 0.0).then(|| (self.pending_s.len() - 1) as f64 / span_s)
    }

    /// Whether the pending samples span the time that they take at this rate, apart from bunching.
    fn spans_time_at(&self, known_hz: f64) -> bool {
        let expected_s = self.pending_s.len().saturating_sub(1) as f64 / known_hz;
        let within_s = COARSE_TOLERANCE * expected_s + BUNCHING_S;
        self.span_s().is_some_and(|span_s| (span_s - expected_s).abs() <= within_s)
    }

    fn span_s(&self) -> Option<f64> {
        Some(self.pending_s.last()? - self.pending_s.first()?)
    }
}

fn is_near(measured_hz: f64, known_hz: f64) -> bool {
    (measured_hz / known_hz - 1.0).abs() <= COARSE_TOLERANCE
}
