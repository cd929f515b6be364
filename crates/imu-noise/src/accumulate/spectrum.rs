//! Streaming power spectral density by Welch's method.

mod places;
mod power_sums;

use schemars::JsonSchema;
use serde::Serialize;
use std::sync::Arc;

use realfft::RealFftPlanner;

use super::counts::counts_to_unit;
use super::places::room_for;
use places::Places;
use power_sums::{SegmentPowerSums, Transform};

pub(crate) const LONG: usize = 512;

/// Samples of a segment of records that are too short to average over long segments.
pub(crate) const SHORT: usize = 128;

/// Segments begin at multiples of half their length.
const STEP: u64 = LONG as u64 / 2;

/// Up to this many samples every segment is taken.
const DENSE_SAMPLES: u64 = 32_768;

/// With this many complete long segments, the short ones are not used.
const MIN_LONG_SEGMENTS: u64 = 8;

/// Streaming power spectral density: Welch (1967), Hann window, segments of 512 samples without
/// their mean, half overlapping, on the grid of the absolute index; of 128 samples for a record with
/// fewer than 8 segments, and in the place of a segment that lacks samples or spans a break.
///
/// Beyond 32 768 samples the segments are spread evenly, ever farther apart as the record doubles,
/// each weighted by the number that it represents: the [averages](Density::averages) stay above 120.
///
/// Transforms are single precision: densities are good to 1e-5 of the largest. Each is rounded once,
/// to multiples of 2^-12 counts²: for any division over calls the sums have the same bits on
/// processors with the same vector instructions.
#[derive(Clone, Debug)]
pub struct Spectrum<T = i32> {
    plan: SpectrumPlan,
    /// Absolute index after the last place.
    pub(crate) end: u64,
    /// Samples of the record so far: they determine the spacing of segments.
    samples: u64,
    /// Whether missing samples count among these.
    pub(crate) counts_missing: bool,
    /// The places from the first open segment on.
    recent: Places<T>,
    open: Vec<Segment>,
    long: SegmentPowerSums<LONG>,
    /// The power sums of short segments, within segments with missing samples and at the beginning.
    short: SegmentPowerSums<SHORT>,
}

#[derive(Clone, Copy, Debug)]
struct Segment {
    start: u64,
    /// The number of segments that it represents.
    stands_for: u64,
    /// Whether short segments are taken from it as well, although none of its samples is missing.
    is_early: bool,
}

/// Of samples, or of sums of samples below 2^53.
impl<T: Copy + Default + Into<i64>> Spectrum<T> {
    pub(crate) fn new(plan: &SpectrumPlan, counts_missing: bool) -> Self {
        Self {
            plan: plan.clone(),
            end: 0,
            samples: 0,
            counts_missing,
            recent: Places::default(),
            open: Vec::new(),
            long: SegmentPowerSums::new(),
            short: SegmentPowerSums::new(),
        }
    }

    pub(crate) fn push(&mut self, mut counts: &[T]) {
        while !counts.is_empty() {
            self.begin_segment();
            let (now, later) = counts.split_at(self.room(counts.len() as u64));
            if !self.open.is_empty() {
                self.recent.values.extend_from_slice(now);
            }
            self.samples += now.len() as u64;
            self.continue_by(now.len() as u64);
            counts = later;
        }
    }

    /// Samples are missing here.
    pub(crate) fn gap(&mut self, missing: u64) {
        let end = self.end + room_for(self.end, missing);
        // segments that begin and end in the gap have no sample
        let ended_before = self.end + LONG as u64;
        let resumed = end.saturating_sub(LONG as u64) / STEP * STEP;
        while self.end < end {
            if (ended_before..resumed).contains(&self.end) {
                self.open.clear();
                self.recent.clear();
                self.miss(resumed - self.end);
            }
            self.begin_segment();
            let places = self.room(end - self.end) as u64;
            if !self.open.is_empty() {
                self.recent.miss(places);
            }
            self.miss(places);
        }
    }

    /// No segment reaches across this place.
    pub(crate) fn part(&mut self) {
        self.end_segments(usize::MAX);
        self.recent.clear();
    }

    pub(crate) fn powers(&self) -> Option<Powers> {
        if self.long.segments >= MIN_LONG_SEGMENTS {
            return Some(self.long.powers());
        }
        let mut with_open = self.clone();
        with_open.part();
        (with_open.short.segments > 0).then(|| with_open.short.powers())
    }

    /// The number of these places up to the next start of a segment.
    fn room(&self, places: u64) -> usize {
        (STEP - self.end % STEP).min(places) as usize
    }

    fn begin_segment(&mut self) {
        let start = self.end;
        // 1, 2, 4, ... from the number of samples on
        let stands_for = (self.samples / DENSE_SAMPLES).checked_ilog2().map_or(1, |octave| 2 << octave);
        if start.is_multiple_of(STEP * stands_for) {
            if self.open.is_empty() {
                self.recent.first = start;
            }
            let is_early = self.samples < MIN_LONG_SEGMENTS * STEP;
            self.open.push(Segment { start, stands_for, is_early });
        }
    }

    fn miss(&mut self, places: u64) {
        self.samples += if self.counts_missing { places } else { 0 };
        self.continue_by(places);
    }

    fn continue_by(&mut self, places: u64) {
        self.end += places;
        if self.end.is_multiple_of(STEP) {
            let is_full = |segment: &&Segment| segment.start + LONG as u64 <= self.end;
            self.end_segments(self.open.iter().take_while(is_full).count());
            match self.open.first() {
                Some(first) => self.recent.drop_before(first.start),
                None => self.recent.clear(),
            }
        }
    }

    /// Adds the powers of the first open segments, at most so many.
    fn end_segments(&mut self, most: usize) {
        let Self { plan, recent, open, long, short, .. } = self;
        for segment in open.drain(..most.min(open.len())) {
            let whole = recent.whole(segment.start);
            if let Some(values) = whole {
                long.add(&plan.long, values, segment.stands_for);
            }
            if whole.is_none() || segment.is_early {
                for start in (segment.start..).step_by(SHORT / 2).take(LONG / SHORT) {
                    if let Some(values) = recent.whole(start) {
                        short.add(&plan.short, values, segment.stands_for);
                    }
                }
            }
        }
    }
}

/// Which frequencies a density counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sides {
    /// Only positive ones, as in spectrum analysers: √2 times the two-sided amplitude, twice its
    /// power. White noise has the power density 2 N².
    One,
    /// Negative ones as well (IEEE Std 952): the amplitude density is N itself, the power density N².
    Two,
}

/// A power spectral density at evenly spaced frequencies.
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    /// The frequencies over which it is spread.
    pub sides: Sides,
    /// Samples of a segment.
    pub segment_samples: usize,
    /// Segments transformed.
    pub segments: u64,
    /// The equivalent number of independent segments. Each point has about twice as many degrees of
    /// freedom (the last point, at half the sampling rate, as many).
    pub averages: f64,
    /// Frequency of the first point, and step from point to point: 1/(segment_samples·interval).
    pub step_hz: f64,
    /// Density in unit²/Hz of each point, up to half the sampling rate. Windowing spreads a line over
    /// four points; the first point is low, because the mean of each segment is removed.
    pub points_unit2_hz: Vec<f64>,
}

#[derive(Clone, Debug)]
pub(crate) struct Powers {
    pub(crate) segment_samples: usize,
    pub(crate) segments: u64,
    pub(crate) averages: f64,
    /// Means of |X_k|²/n for k = 0..=n/2.
    pub(crate) powers: Vec<f64>,
}

impl Spectrum {
    /// The density of a channel sampled every `interval_s` seconds with `decimals` digits. `None`
    /// before the first segment is full, and if `interval_s` is not positive.
    pub fn density(&self, sides: Sides, interval_s: f64, decimals: u8) -> Option<Density> {
        let Powers { segment_samples, segments, averages, powers } = self.powers()?;
        if interval_s.is_nan() || interval_s <= 0.0 {
            return None;
        }
        let step_hz = 1.0 / (segment_samples as f64 * interval_s);
        let points_unit2_hz = powers.iter().skip(1).map(|power| {
            // At half the sampling rate as well: this frequency is its own negative, but its point
            // is half as wide.
            let counts2_hz = power * interval_s * if sides == Sides::One { 2.0 } else { 1.0 };
            counts_to_unit(counts_to_unit(counts2_hz, decimals), decimals)
        });
        let points_unit2_hz = points_unit2_hz.collect();
        Some(Density { sides, segment_samples, segments, averages, step_hz, points_unit2_hz })
    }
}

/// Window and Fourier transform, made once and shared by the channels, because a copy is a reference.
#[derive(Clone, Debug)]
pub struct SpectrumPlan {
    long: Arc<Transform<LONG>>,
    short: Arc<Transform<SHORT>>,
}

impl SpectrumPlan {
    /// Windows and transforms for both lengths of segments.
    pub fn new() -> Self {
        let mut planner = RealFftPlanner::new();
        Self { long: Arc::new(Transform::new(&mut planner)), short: Arc::new(Transform::new(&mut planner)) }
    }
}

impl Default for SpectrumPlan {
    fn default() -> Self {
        Self::new()
    }
}
