//! Spectrum, blocks and windows of one channel, used to recognise a disturbed deviation.

use std::mem;

use super::blocks::{Block, BlockSums, Blocks, Spreads, WINDOW};
use super::places::room_for;
use super::spectrum::{Spectrum, SpectrumPlan};
use super::stretch::Stretch;
use super::window_statistics::{Magnitudes, WindowStatistics};

/// Windows in a sum of the slowest spectrum, and the number of them that must be full.
const WINDOWS: u64 = 32;
const LEAST_WINDOWS: u64 = 24;

/// Spectrum, block statistics and disturbance windows of one channel.
///
/// The result is the same, bit by bit, for any division of the samples over calls of
/// [`push`](Self::push). A sensor at rest takes 21 KiB at first and 40 KiB from hours on.
///
/// ```
/// use imu_noise::{ChannelSignal, Sides, SpectrumPlan};
///
/// let mut accelerometer = ChannelSignal::new(&SpectrumPlan::new());
/// let fan_5_hz = |i: u32| 100.0 * (std::f64::consts::TAU * 5.0 * 0.025 * f64::from(i)).sin();
/// let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 16) as i32 % 41 - 20;
/// accelerometer.push(&(0..4000).map(|i| fan_5_hz(i) as i32 + noise(i * i)).collect::<Vec<_>>());
/// let lines: Vec<_> = accelerometer.narrow_bands(1e-3, 0.025).iter().filter_map(|band| band.line).collect();
/// assert!(lines.len() == 1 && (lines[0].frequency_hz - 5.0).abs() < 1e-2);
/// assert_eq!(accelerometer.spectrum().density(Sides::One, 0.025, 3).unwrap().points_unit2_hz.len(), 256);
/// ```
#[derive(Clone, Debug)]
pub struct ChannelSignal {
    spectrum: Spectrum,
    /// The spectrum of the sums of windows: up to 1/64 of the sampling rate, in finer steps.
    slow: SumSpectrum,
    /// The spectrum of the sums of as many windows as one has samples.
    slowest: SumSpectrum,
    blocks: Blocks,
    pub(crate) windows: WindowStatistics,
    /// Absolute index of the next place.
    end: u64,
    /// Whether there was a gap of unknown length, or a break.
    pub(crate) is_parted: bool,
    /// The last samples, without a gap between them, of the incomplete window.
    window: Vec<i32>,
}

/// The spectrum of sums of this many windows. A sum that lacks a few of them is enlarged in proportion.
#[derive(Clone, Debug)]
struct SumSpectrum {
    windows: u64,
    /// The number of windows that a sum has at least.
    least: u64,
    spectrum: Spectrum<i64>,
    /// The number of the present sum, and the windows in it so far.
    number: u64,
    sum: i64,
    present: u64,
}

impl ChannelSignal {
    /// A channel without samples.
    pub fn new(plan: &SpectrumPlan) -> Self {
        Self {
            spectrum: Spectrum::new(plan, false),
            slow: SumSpectrum::new(plan, 1, 1),
            slowest: SumSpectrum::new(plan, WINDOWS, LEAST_WINDOWS),
            blocks: Blocks::new(),
            windows: WindowStatistics::default(),
            end: 0,
            is_parted: false,
            window: Vec::with_capacity(WINDOW),
        }
    }

    /// Spaces the segments by all places of the record, missing ones too; before any sample.
    pub const fn count_missing(&mut self) {
        self.spectrum.counts_missing = true;
    }

    /// Adds the next samples, in time order.
    pub fn push(&mut self, mut counts: &[i32]) {
        self.spectrum.push(counts);
        while !counts.is_empty() {
            let room = WINDOW - (self.end % WINDOW as u64) as usize;
            let (now, later) = counts.split_at(room.min(counts.len()));
            if now.len() == WINDOW {
                self.add_window(now);
            } else {
                self.window.extend_from_slice(now);
                if now.len() == room {
                    self.end_window();
                }
            }
            self.end += now.len() as u64;
            counts = later;
        }
    }

    /// Adds the samples of a stretch, in time order: like [`push`](Self::push) of its runs and
    /// [`gap`](Self::gap) between them.
    pub fn push_stretch(&mut self, counts: &[i32], stretch: &Stretch) {
        for (missing, run) in stretch.runs_of(counts) {
            if missing > 0 {
                self.gap(Some(missing as u64));
            }
            self.push(run);
        }
    }

    /// Adds a gap: `Some(missing)` samples, or an unknown number, which counts as none in the index. No
    /// segment of the spectrum and no disturbance window lacks a sample, or spans a break: `Some(0)` or
    /// an unknown number.
    pub fn gap(&mut self, missing: Option<u64>) {
        let missing = room_for(self.end, missing.unwrap_or(0));
        self.end_window();
        self.spectrum.gap(missing);
        self.end += missing;
        if missing == 0 {
            self.spectrum.part();
            self.is_parted = true;
            // The window of the break lacks samples, so the break comes after it, in any division.
            self.slow.miss_up_to(self.end.div_ceil(WINDOW as u64));
            self.slow.spectrum.part();
            // a sum of means from both sides of a break is a mean as well
            self.windows.part();
        }
    }

    /// The power spectral density, with its peaks.
    pub const fn spectrum(&self) -> &Spectrum {
        &self.spectrum
    }

    /// The spectra of the sums of this many samples: 32, and 1024.
    pub(crate) fn slow_spectra(&self) -> [(&Spectrum<i64>, u64); 2] {
        [&self.slow, &self.slowest].map(|slow| (&slow.spectrum, slow.windows * WINDOW as u64))
    }

    /// Mean, standard deviation and extremes of the blocks of the record, in time order: at most
    /// [`MAX_BLOCKS`](crate::MAX_BLOCKS), without empty ones.
    pub fn blocks(&self) -> Vec<Block> {
        let mut blocks = self.blocks.clone();
        if let (Some(place), false) = (self.end.checked_sub(1), self.window.is_empty()) {
            blocks.add(place, &BlockSums::of(&self.window).0);
        }
        blocks.iter().collect()
    }

    /// First sample, length and spreads of the blocks that have full windows.
    pub(crate) fn spreads(&self) -> Vec<(u64, u64, Spreads)> {
        self.blocks.spreads().map(|(first, length, spreads)| (first, length, *spreads)).collect()
    }

    /// See [`Extremes`](super::window_statistics::Extremes); an empty window ends the last.
    pub(crate) fn extremes(&self) -> Magnitudes {
        let mut extremes = self.windows.extremes.clone();
        for window in [&self.window[..], &[]] {
            extremes.push(&BlockSums::of(window).0);
        }
        extremes.squares
    }

    /// Ends the window of the next place, at its end or because samples are missing.
    fn end_window(&mut self) {
        let mut window = mem::take(&mut self.window);
        if !window.is_empty() {
            self.add_window(&window);
        }
        window.clear();
        self.window = window;
    }

    /// The samples of the window of the next place.
    fn add_window(&mut self, window: &[i32]) {
        let (sums, spread) = BlockSums::of(window);
        self.blocks.add(self.end, &sums);
        self.windows.extremes.push(&sums);
        if window.len() == WINDOW {
            let number = self.end / WINDOW as u64;
            self.windows.push(number, &sums, spread);
            self.slow.push(number, sums.sum);
            self.slowest.push(number, sums.sum);
        }
    }
}

impl SumSpectrum {
    fn new(plan: &SpectrumPlan, windows: u64, least: u64) -> Self {
        Self { windows, least, spectrum: Spectrum::new(plan, true), number: 0, sum: 0, present: 0 }
    }

    fn push(&mut self, window: u64, sum: i64) {
        if self.number != window / self.windows {
            self.end_sum();
            self.number = window / self.windows;
        }
        self.sum += sum;
        self.present += 1;
        if (window + 1).is_multiple_of(self.windows) {
            self.end_sum();
        }
    }

    fn end_sum(&mut self) {
        let (sum, present) = (mem::take(&mut self.sum), mem::take(&mut self.present));
        if present >= self.least {
            self.miss_up_to(self.number);
            // rounded once; below 2^46
            let whole = sum * self.windows as i64;
            self.spectrum.push(&[whole / present as i64]);
        }
    }

    fn miss_up_to(&mut self, number: u64) {
        if let missing @ 1.. = number.saturating_sub(self.spectrum.end) {
            self.spectrum.gap(missing);
        }
    }
}
