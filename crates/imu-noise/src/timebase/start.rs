//! The first lines: held until their rate is clear.

use super::stretches::{SNAP_TOLERANCE, Stretches, percentile_90, snap, steady};
use super::{NominalRate, Refusal, TOO_FAST, fastest};

/// Most stretches, and lines, held while no rate of the sensor is seen.
const START_STRETCHES: usize = 16;
const START_LINES: usize = 1024;

/// Stretches that contradict a known rate, at least: lines lost in a bunch make one or two look like a lower rate.
const CONTRADICTING_STRETCHES: usize = 4;

/// Time by which bunching may bend a record too short for a stretch.
const BUNCHING_S: f64 = 0.1;

/// Lines without a place, and what is known of their rate.
#[derive(Clone, Debug)]
pub(super) struct Start {
    rates_hz: &'static [f64],
    known_hz: Option<f64>,
    held_s: Vec<f64>,
    stretches: Stretches,
    stretch_rates_hz: Vec<f64>,
}

impl Start {
    pub(super) fn new(rates_hz: &'static [f64], known_hz: Option<f64>) -> Self {
        Self { rates_hz, known_hz, held_s: Vec::new(), stretches: Stretches::default(), stretch_rates_hz: Vec::new() }
    }

    /// Adds a line's stamp; the rate, when it is clear now, or why there is none.
    pub(super) fn push(&mut self, at_s: f64) -> Option<Result<NominalRate, Refusal>> {
        self.held_s.push(at_s);
        let stretch_hz = self.stretches.push(at_s);
        self.stretch_rates_hz.extend(stretch_hz);
        let full = self.stretch_rates_hz.len() >= START_STRETCHES || self.held_s.len() >= START_LINES;
        if full || stretch_hz.is_some() { self.decide(full) } else { None }
    }

    /// The same when these lines are all there will be; nothing for a single line, or none, of unknown rate.
    pub(super) fn finish(&self) -> Option<Result<NominalRate, Refusal>> {
        self.decide(true)
    }

    /// The stamps of the lines held.
    pub(super) fn take_held(&mut self) -> Vec<f64> {
        std::mem::take(&mut self.held_s)
    }

    /// The rate or the refusal; when `full` the best that can be had.
    fn decide(&self, full: bool) -> Option<Result<NominalRate, Refusal>> {
        let span_s = self.held_s.last()? - self.held_s.first()?;
        let intervals = self.held_s.len() - 1;
        let stretch_hz = percentile_90(&self.stretch_rates_hz);
        if let Some(known_hz) = self.known_hz {
            let expected_s = intervals as f64 / known_hz;
            let short = stretch_hz.is_none() && (span_s - expected_s).abs() <= SNAP_TOLERANCE * expected_s + BUNCHING_S;
            let agrees = stretch_hz.is_some_and(|hz| (hz / known_hz - 1.0).abs() <= SNAP_TOLERANCE);
            if agrees || short || steady(&[known_hz], 0.0, &self.held_s).is_some() {
                return Some(Ok(NominalRate::Known(known_hz)));
            }
        }
        let mean_hz = (span_s > 0.0).then(|| intervals as f64 / span_s);
        let Some(measured_hz) = stretch_hz.or(mean_hz) else {
            let lines = self.held_s.len() as u64;
            return (full && lines > 1).then_some(Err(Refusal::NoTimePasses { lines }));
        };
        let sensor_hz = snap(self.rates_hz, measured_hz, SNAP_TOLERANCE)
            .or_else(|| steady(self.rates_hz, measured_hz, &self.held_s));
        let fastest_hz = fastest(self.rates_hz);
        match (sensor_hz, self.known_hz) {
            (Some(other_hz), Some(known_hz)) if full || self.stretch_rates_hz.len() >= CONTRADICTING_STRETCHES => {
                Some(Err(Refusal::OtherRate { known_hz, measured_hz: other_hz }))
            }
            (Some(sensor_hz), None) => Some(Ok(NominalRate::Snapped(sensor_hz))),
            _ if !full => None,
            _ if measured_hz > TOO_FAST * fastest_hz => Some(Err(Refusal::TooFast { measured_hz, fastest_hz })),
            (_, Some(known_hz)) => Some(Err(Refusal::OtherRate { known_hz, measured_hz })),
            (None, None) => Some(Ok(NominalRate::Measured(measured_hz))),
        }
    }
}
