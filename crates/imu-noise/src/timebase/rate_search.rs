//! The rate of a sensor with known rates, found from its first samples.
//!
//! Samples that arrive singly and evenly show it at once, and so does a lower edge that varies by no
//! more than a reader causes. Otherwise the length of a description of the arrivals is computed for
//! each possible rate: the lateness of the samples, and the number and places of missing ones. Too
//! high a rate needs many missing samples, too low a rate late samples. The shortest description
//! counts if it is clearly the shortest.

use super::gap_event::NominalRate;
use super::interval_statistics::TOGETHER_PERIODS;
use super::sensor_rates::{LISTED_TOLERANCE, RUN, SensorRates, TOO_FAST, WHOLE_TOLERANCE, mean_hz, near};

/// Seconds, and intervals, of samples that arrive singly and evenly until their rate is certain: ten
/// times the longest bunching. Where half of the samples are missing, every second one is missing ten
/// times in a row with a chance of one in a million, and six times with one of four thousand.
const EVEN_S: f64 = 1.0;
const EVEN_INTERVALS: usize = 10;

/// The required share of samples that arrive singly; the others may arrive at once, or late. Chosen.
const MANY_SINGLE: f64 = 0.85;

/// Seconds until other evidence counts, and until the search ends, each with a number of samples.
const EVIDENCE_S: f64 = 2.0;
const LONGEST_S: f64 = 4.0;
const ENOUGH: usize = 2 * RUN;
const MOST_SAMPLES: usize = 1024;

/// The largest variation of the lag of samples, in periods, if a reader takes each in time.
const READER_PERIODS: f64 = 1.5;

/// Lateness in seconds below which descriptions of samples do not differ.
const RESOLUTION_S: f64 = 0.0005;

/// Phases of the lower edge that are tried, and the periods by which a sample may be before it.
const PHASES: u32 = 8;
const BEFORE_EDGE: f64 = 0.15;

/// The required advantage of a description, in nats and in nats per sample; and the cost of a rate
/// that the sensor does not have. Chosen.
const CLEARLY: f64 = 8.0;
const CLEARLY_PER_SAMPLE: f64 = 0.15;
const UNLISTED: f64 = 30.0;

#[derive(Clone, Debug)]
pub(super) struct RateSearch {
    rates: SensorRates,
    /// Number of samples before the clock was set back; their stamps are not used.
    unstamped: u64,
    pending_s: Vec<f64>,
}

impl RateSearch {
    pub(super) const fn new(rates: SensorRates) -> Self {
        Self { rates, unstamped: 0, pending_s: Vec::new() }
    }

    /// The number of pending samples.
    pub(super) const fn samples(&self) -> u64 {
        self.unstamped + self.pending_s.len() as u64
    }

    /// The clock was set back: the stamps so far cannot be compared with later ones.
    pub(super) fn restart_clock(&mut self) {
        self.unstamped = self.samples();
        self.pending_s.clear();
    }

    /// Takes the number of samples whose stamps are not used, and the stamps of the later ones.
    pub(super) fn take_pending(&mut self) -> (u64, Vec<f64>) {
        (std::mem::take(&mut self.unstamped), std::mem::take(&mut self.pending_s))
    }

    /// Adds a sample. Returns the result, as [`finish`](Self::finish), if the search ends with it.
    pub(super) fn push(&mut self, at_s: f64) -> Option<Result<NominalRate, f64>> {
        self.pending_s.push(at_s);
        let span_s = at_s - self.pending_s[0];
        let samples = self.pending_s.len();
        if span_s >= EVEN_S
            && let Some(hz) = self.even()
        {
            return Some(Ok(NominalRate::Snapped(hz)));
        }
        if samples >= MOST_SAMPLES || (span_s >= LONGEST_S && samples >= ENOUGH) {
            return self.finish();
        }
        let is_due = samples.is_multiple_of(RUN) && span_s >= EVIDENCE_S;
        let found = if is_due { self.found() } else { None };
        found.filter(|found| matches!(found, NominalRate::Snapped(_))).map(Ok)
    }

    /// The rate that all samples show, if no other follows, or how many of them arrive per second,
    /// unevenly: some are missing, or the rate is another one. `None` below two samples.
    pub(super) fn finish(&self) -> Option<Result<NominalRate, f64>> {
        let mean_hz = mean_hz(&self.pending_s)?;
        if mean_hz > TOO_FAST * self.rates.fastest() {
            return Some(Err(mean_hz));
        }
        if self.pending_s.len() < RUN {
            let whole = |hz: &f64| {
                let periods = self.pending_s.windows(2).map(|pair| (pair[1] - pair[0]) * hz);
                let is_whole = |periods: f64| periods > 0.5 && (periods - periods.round()).abs() < WHOLE_TOLERANCE;
                periods.clone().all(is_whole)
                    && 2 * periods.filter(|periods| *periods < 1.5).count() >= self.pending_s.len() - 1
            };
            let nearest_hz = self.rates.nearest(mean_hz, 5.0 * LISTED_TOLERANCE);
            let nearest_hz = nearest_hz.or_else(|| self.rates.0.iter().copied().filter(whole).min_by(f64::total_cmp));
            return Some(nearest_hz.map(NominalRate::Snapped).ok_or(mean_hz));
        }
        Some(self.found().ok_or(mean_hz))
    }

    /// The rate if most of the latest second of samples arrived singly and evenly.
    fn even(&self) -> Option<f64> {
        let last_s = self.pending_s.last()?;
        let since = self.pending_s.partition_point(|at_s| last_s - at_s > EVEN_S);
        let first = since.saturating_sub(1).min(self.pending_s.len().checked_sub(EVEN_INTERVALS + 1)?);
        let latest_s = &self.pending_s[first..];
        let mean_hz = mean_hz(latest_s)?;
        let listed_hz = self.rates.nearest(mean_hz, LISTED_TOLERANCE);
        let is_single = |hz: &f64| near(latest_s, *hz, 0.5 * WHOLE_TOLERANCE) >= 1.0;
        let are_many_single = |hz: &f64| {
            let exact = |hz: f64| near(latest_s, hz, 0.1 * WHOLE_TOLERANCE) >= MANY_SINGLE;
            let may_be = exact(*hz) || !exact(mean_hz);
            may_be && latest_s.len() >= RUN && near(latest_s, *hz, 0.75 * WHOLE_TOLERANCE) >= MANY_SINGLE
        };
        let nearest_hz = self.rates.nearest(mean_hz, 5.0 * LISTED_TOLERANCE);
        listed_hz.filter(is_single).or_else(|| nearest_hz.filter(are_many_single))
    }

    fn found(&self) -> Option<NominalRate> {
        let mean_hz = mean_hz(&self.pending_s)?;
        let near_hz = self.rates.nearest(mean_hz, 3.0 * LISTED_TOLERANCE);
        // reads at a pace of their own look like a higher rate with missing samples
        if let Some(hz) = near_hz.filter(|hz| self.pending_s.len() >= ENOUGH && self.is_read_in_time(*hz, 0)) {
            return Some(NominalRate::Snapped(hz));
        }
        let possible = self.rates.0.iter().copied().filter(|hz| *hz > 0.97 * mean_hz);
        let listed = possible.map(|hz| (self.description(hz), NominalRate::Snapped(hz)));
        let unlisted = (self.description(mean_hz) + UNLISTED, NominalRate::Measured(mean_hz));
        let mut all: Vec<(f64, NominalRate)> = listed.chain([unlisted]).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let clearly = CLEARLY + CLEARLY_PER_SAMPLE * self.pending_s.len() as f64;
        let others = all.get(1).map_or(f64::INFINITY, |second| second.0);
        if others - all[0].0 > clearly {
            return Some(all[0].1);
        }
        let late = self.pending_s.len() / 10;
        if let Some(hz) = near_hz.filter(|hz| self.is_read_in_time(*hz, late)) {
            return Some(NominalRate::Snapped(hz));
        }
        // one or two missing samples lower the mean
        let above_hz = near_hz.filter(|hz| *hz > mean_hz);
        self.is_read_in_time(mean_hz, late)
            .then(|| above_hz.map_or(NominalRate::Measured(mean_hz), NominalRate::Snapped))
    }

    /// Whether no sample is missing at this rate, and a reader takes all available samples, except
    /// in this many `late` reads: the last sample of each read is less than a period late.
    fn is_read_in_time(&self, hz: f64, late: usize) -> bool {
        // the read of the last sample may not be over
        let waits = |place: usize| {
            let next_s = self.pending_s.get(place + 1);
            next_s.is_some_and(|next_s| (next_s - self.pending_s[place]) * hz >= TOGETHER_PERIODS)
        };
        let ends = self.pending_s.iter().enumerate().skip(1).filter(|(place, _)| waits(*place));
        let mut lags: Vec<f64> = ends.map(|(place, at_s)| at_s * hz - place as f64).collect();
        lags.sort_by(f64::total_cmp);
        let most = lags.len().checked_sub(1 + late.min(lags.len() / 10)).and_then(|last| lags.get(last));
        let range = lags.first().zip(most).map(|(least, most)| most - least);
        lags.len() >= RUN / 2 && range.is_some_and(|range| range <= READER_PERIODS)
    }

    /// The length in nats of a description of the arrivals with this rate: lateness has an
    /// exponential distribution, and the number of missing samples a geometric one.
    fn description(&self, hz: f64) -> f64 {
        let samples = self.pending_s.len();
        let lags: Vec<f64> = self.pending_s.iter().enumerate().map(|(place, at_s)| at_s * hz - place as f64).collect();
        let least_later = lags.iter().rev().scan(f64::INFINITY, |least, lag| {
            *least = least.min(*lag);
            Some(*least)
        });
        let mut edge: Vec<f64> = least_later.collect();
        edge.reverse();
        let length = |phase: f64| {
            let missing = |place: usize| (edge[place] - phase + BEFORE_EDGE).floor();
            let late: f64 = (0..samples).map(|place| (lags[place] - phase - missing(place)).max(0.0)).sum();
            let late_s = late / (samples as f64 * hz) + RESOLUTION_S;
            let all = missing(samples - 1) - missing(0);
            let share = |part: f64, of: f64| if part > 0.0 { part * (part / of).ln() } else { 0.0 };
            let sent = all + samples as f64;
            samples as f64 * (1.0 + late_s.ln()) - share(samples as f64, sent) - share(all, sent)
        };
        (0..PHASES).map(|phase| length(f64::from(phase) / f64::from(PHASES))).fold(f64::INFINITY, f64::min)
    }
}
