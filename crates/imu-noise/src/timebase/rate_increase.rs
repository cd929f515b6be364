//! Samples that arrive early: their rate has risen, or those before them were late.

use super::gap_event::GapEvent;
use super::judgement::{CONFIRMATIONS, Judgement};
use super::rate_estimates::{COARSE_TOLERANCE, StretchCutter, TOO_FAST, fastest, snap};
use super::rate_search::MANY_STRETCHES;

/// The factor of an increase: less than 1.25, the smallest step between rates of the sensor, and
/// more than [`COARSE_TOLERANCE`].
const HIGHER: f64 = 1.1;

/// Total time in periods by which the samples of a stretch must be early: at 1.1 times the rate it
/// is 2.8.
const EARLY_STRETCH_PERIODS: f64 = 2.0;

/// Most pending samples: 20 s at 200 Hz.
const MAX_HELD: usize = 4096;

/// The samples from the first early one on, and the events that are valid if the rate has not
/// changed.
#[derive(Clone, Debug, Default)]
pub(super) struct SuspectedIncrease {
    rates_hz: &'static [f64],
    period_s: f64,
    /// When the sample before the first one was due, and the period fitted until then.
    due_before_s: f64,
    pub(super) fitted_before_s: Option<f64>,
    pub(super) stamps_s: Vec<f64>,
    pub(super) events: Vec<GapEvent>,
    cutter: StretchCutter,
    /// Total time by which the samples of the present stretch arrived early.
    pub(super) early_s: f64,
    /// Place among the samples, and stamp, of the last sample that was early by more than the
    /// tolerance.
    last_early: (usize, f64),
    /// The higher rate that the last stretch showed.
    higher_hz: Option<f64>,
    /// Number of consecutive stretches that are too fast for the sensor.
    too_fast: usize,
    judgement: Option<Judgement>,
}

impl SuspectedIncrease {
    pub(super) fn new(
        rates_hz: &'static [f64],
        period_s: f64,
        due_before_s: f64,
        fitted_before_s: Option<f64>,
    ) -> Self {
        let last_early = (0, due_before_s);
        Self { rates_hz, period_s, due_before_s, fitted_before_s, last_early, ..Self::default() }
    }

    /// Notes that the next sample, at `at_s`, is early by `early_s`, and whether by more than the
    /// tolerance.
    pub(super) fn add_early(&mut self, at_s: f64, early_s: f64, is_suspicious: bool) {
        self.early_s += early_s;
        if is_suspicious {
            self.last_early = (self.stamps_s.len(), at_s);
        }
    }

    /// Adds a sample. The suspicion is cleared once [`CONFIRMATIONS`] samples and the window of the
    /// reads have passed without an early sample.
    pub(super) fn push(&mut self, at_s: f64, window_s: f64) {
        self.stamps_s.push(at_s);
        if let Some(stretch) = self.cutter.push(at_s) {
            self.end_stretch(stretch.hz());
        }
        let (early, early_at_s) = self.last_early;
        let quiet = self.stamps_s.len() > early + CONFIRMATIONS && at_s - early_at_s >= window_s;
        if self.judgement.is_none() && (quiet || self.stamps_s.len() >= MAX_HELD) {
            self.judgement = Some(Judgement::IncreaseCleared);
        }
    }

    /// Keeps an event on the samples added pending. Returns the judgement once there is one.
    pub(super) fn hold(&mut self, event: GapEvent) -> Option<Judgement> {
        self.events.push(event);
        self.judgement.take()
    }

    /// The events before the rate changed to `to_hz`, and the stamps of the samples after the
    /// change. Against a rate between the two, the lag rises until the change and decreases after
    /// it.
    pub(super) fn split(mut self, to_hz: f64) -> (Vec<GapEvent>, Vec<f64>) {
        let between_s = 0.5 * (self.period_s + to_hz.recip());
        let (mut place, mut most_lag_s) = (0, self.due_before_s + between_s);
        for (sample, at_s) in self.stamps_s.iter().enumerate() {
            let lag_s = at_s - sample as f64 * between_s;
            if lag_s > most_lag_s {
                (place, most_lag_s) = (sample + 1, lag_s);
            }
        }
        let mut left = place as u64;
        let before = self.events.into_iter().map_while(|event| match event {
            _ if left == 0 => None,
            GapEvent::Samples(samples) => {
                let samples = samples.min(left);
                left -= samples;
                Some(GapEvent::Samples(samples))
            }
            other => Some(other),
        });
        (before.collect(), self.stamps_s.split_off(place))
    }

    /// Ends a stretch. Two consecutive stretches at the same higher rate are an increase.
    fn end_stretch(&mut self, stretch_hz: f64) {
        let is_early = std::mem::take(&mut self.early_s) > EARLY_STRETCH_PERIODS * self.period_s;
        self.too_fast = if is_early && stretch_hz > TOO_FAST * fastest(self.rates_hz) { self.too_fast + 1 } else { 0 };
        if self.too_fast >= MANY_STRETCHES {
            self.judgement = Some(Judgement::TooFast(stretch_hz));
        }
        let higher_hz =
            snap(self.rates_hz, stretch_hz, COARSE_TOLERANCE).filter(|&hz| is_early && hz * self.period_s > HIGHER);
        match higher_hz {
            Some(to_hz) if self.higher_hz == higher_hz => self.judgement = Some(Judgement::Increased(to_hz)),
            _ => self.higher_hz = higher_hz,
        }
    }
}
