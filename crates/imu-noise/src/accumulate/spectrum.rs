//! Power spectral density of one channel by Welch's method, in bounded memory and time.

pub(crate) mod density;
mod segments;

pub use segments::SpectrumPlan;

use segments::PowerSums;

/// Samples of a segment.
const LONG: usize = 512;

/// Samples of a segment of records too short to average over long ones.
const SHORT: usize = 128;

/// Fewest averages of long segments; below, the short ones are read out.
const MIN_LONG_SEGMENTS: u64 = 8;

/// Samples within which every segment is taken.
const DENSE_SAMPLES: u64 = 32_768;

/// Streaming power spectral density: Welch (1967), Hann window, segments of 512 samples without
/// their mean, half overlapping.
///
/// A record shorter than 8 such segments (2304 samples without gap) is read out from segments of
/// 128. A gap restarts the segment. Beyond 32 768 samples, those missing not counted, the segments
/// are spread evenly: every second up to twice that length, every fourth up to four times, and so
/// on, each with a weight of as many as it stands for. So the cost of a record grows with the
/// logarithm of its length, what comes late weighs as much as what came early, and the
/// [averages](Density::averages) stay above 120.
///
/// Sums are single precision: densities are good to 1e-5 of the largest. The same samples give the
/// same bits in any division over calls.
#[derive(Clone, Debug)]
pub struct Spectrum {
    plan: SpectrumPlan,
    /// Samples of the segment being filled.
    segment: Vec<i32>,
    /// Samples present so far.
    samples: u64,
    /// Number of the sample at which the next segment may start; at which `segment` starts when it
    /// is not empty.
    start: u64,
    long: PowerSums<LONG>,
    short: PowerSums<SHORT>,
}

impl Spectrum {
    pub(crate) fn new(plan: &SpectrumPlan) -> Self {
        Self {
            plan: plan.clone(),
            segment: Vec::with_capacity(LONG),
            samples: 0,
            start: 0,
            long: PowerSums::new(),
            short: PowerSums::new(),
        }
    }

    /// Adds the next samples.
    pub(crate) fn push(&mut self, mut counts: &[i32]) {
        while !counts.is_empty() {
            if self.segment.is_empty() {
                let skipped = self.start.saturating_sub(self.samples).min(counts.len() as u64) as usize;
                counts = &counts[skipped..];
                self.samples += skipped as u64;
                if counts.is_empty() {
                    return;
                }
                self.start = self.samples;
            }
            // In steps of half a short segment, whose ends fall on the same places in any division.
            let step = SHORT / 2 - self.segment.len() % (SHORT / 2);
            let (head, tail) = counts.split_at(step.min(counts.len()));
            self.segment.extend_from_slice(head);
            counts = tail;
            self.samples += head.len() as u64;
            if head.len() == step {
                self.step_filled();
            }
        }
    }

    /// The segment being filled is not continued.
    pub(crate) fn gap(&mut self) {
        self.segment.clear();
    }

    fn step_filled(&mut self) {
        if self.long.segments() < MIN_LONG_SEGMENTS
            && let Some(last) = self.segment.last_chunk()
        {
            // Gaps may keep every long segment from filling: the short ones must not grow without bound either.
            let stands_for = stands_for(self.samples);
            if (self.samples / (SHORT / 2) as u64).is_multiple_of(stands_for) {
                self.short.add(&self.plan.short, last, stands_for);
            }
        }
        if let Some(segment) = self.segment.first_chunk() {
            let stands_for = stands_for(self.start);
            self.long.add(&self.plan.long, segment, stands_for);
            self.start += (LONG / 2) as u64 * stands_for;
            if stands_for == 1 {
                self.segment.copy_within(LONG / 2.., 0);
                self.segment.truncate(LONG / 2);
            } else {
                self.segment.clear();
            }
        }
    }
}

/// Segments in place of which one at this number of samples is taken: 1, 2, 4, ...
fn stands_for(samples: u64) -> u64 {
    match (samples / DENSE_SAMPLES).checked_ilog2() {
        None => 1,
        Some(octave) => 2 << octave,
    }
}
