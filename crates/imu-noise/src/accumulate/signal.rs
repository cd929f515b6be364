//! Spectra, blocks and windows of one channel: what may invalidate its deviation.

use super::blocks::{Block, Blocks, Spreads, Sums, WINDOW};
use super::piece::FARTHEST;
use super::spectrum::{Spectrum, SpectrumPlan};
use super::window_statistics::WindowStatistics;

/// Spectrum, block statistics and watch for disturbances of one channel.
///
/// The same, bit by bit, for any division of the samples over calls of [`push`](Self::push). Holds
/// 19 KiB of a sensor at rest (blocks 7.5 KiB, spectra 8.7 KiB, watch the rest), for any length of
/// record; below 22 KiB whatever the counts.
///
/// ```
/// use imu_noise::{ChannelSignal, Sides, SpectrumPlan};
///
/// let mut accelerometer = ChannelSignal::new(&SpectrumPlan::new());
/// let fan_5_hz = |i: u32| 100.0 * (std::f64::consts::TAU * 5.0 * 0.025 * f64::from(i)).sin();
/// let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 16) as i32 % 41 - 20;
/// accelerometer.push(&(0..4000).map(|i| fan_5_hz(i) as i32 + noise(i * i)).collect::<Vec<_>>());
/// let lines = accelerometer.spectrum().lines(0.025, 3);
/// assert!(lines.len() == 1 && (lines[0].frequency_hz - 5.0).abs() < 1e-2);
/// assert_eq!(accelerometer.spectrum().density(Sides::One, 0.025, 3).unwrap().points.len(), 256);
/// ```
#[derive(Clone, Debug)]
pub struct ChannelSignal {
    spectrum: Spectrum,
    /// Of the sums of windows: the spectrum up to 1/64 of the sampling rate, in finer steps.
    slow_spectrum: Spectrum<i64>,
    blocks: Blocks,
    pub(crate) windows: WindowStatistics,
    next: u64,
    window: Vec<i32>,
}

impl ChannelSignal {
    /// A channel without samples.
    #[must_use]
    pub fn new(plan: &SpectrumPlan) -> Self {
        Self {
            spectrum: Spectrum::new(plan),
            slow_spectrum: Spectrum::new(plan),
            blocks: Blocks::new(),
            windows: WindowStatistics::new(),
            next: 0,
            window: Vec::with_capacity(WINDOW),
        }
    }

    /// Adds the next samples, in time order.
    pub fn push(&mut self, mut counts: &[i32]) {
        self.spectrum.push(counts);
        while !counts.is_empty() {
            let room = WINDOW - (self.next % WINDOW as u64) as usize;
            let (head, tail) = counts.split_at(room.min(counts.len()));
            if head.len() == WINDOW {
                self.add_window(head);
            } else {
                self.window.extend_from_slice(head);
                if head.len() == room {
                    self.end_window();
                }
            }
            self.next += head.len() as u64;
            counts = tail;
        }
    }

    /// Samples are missing here: `Some(missing)`, or an unknown number, which counts as none.
    /// Seconds of data continue; no segment of the spectrum and no window for disturbances reaches
    /// across.
    pub fn gap(&mut self, missing: Option<u64>) {
        self.spectrum.gap();
        self.slow_spectrum.gap();
        self.end_window();
        self.windows.gap();
        let beyond = self.next.saturating_add(missing.unwrap_or(0));
        self.next = self.next.max(beyond.min(FARTHEST));
    }

    /// The power spectral density and its lines.
    #[must_use]
    pub const fn spectrum(&self) -> &Spectrum {
        &self.spectrum
    }

    /// Of the sums of 32 samples.
    pub(crate) const fn slow_spectrum(&self) -> &Spectrum<i64> {
        &self.slow_spectrum
    }

    /// Mean, deviation and extremes of the blocks of the record, in time order: at most
    /// [`MAX_BLOCKS`](crate::MAX_BLOCKS), those without a sample excluded.
    #[must_use]
    pub fn blocks(&self) -> Vec<Block> {
        let mut blocks = self.blocks.clone();
        if let (Some(sample), false) = (self.next.checked_sub(1), self.window.is_empty()) {
            blocks.add(sample, &Sums::of(&self.window).0);
        }
        blocks.iter().collect()
    }

    /// First sample, length and spreads of the blocks that have full windows.
    pub(crate) fn spreads(&self) -> Vec<(u64, u64, Spreads)> {
        self.blocks.spreads().map(|(first, length, spreads)| (first, length, *spreads)).collect()
    }

    fn end_window(&mut self) {
        if self.window.is_empty() {
            return;
        }
        let window = std::mem::take(&mut self.window);
        self.add_window(&window);
        self.window = window;
        self.window.clear();
    }

    fn add_window(&mut self, window: &[i32]) {
        let (sums, spread) = Sums::of(window);
        self.blocks.add(self.next, &sums);
        if window.len() == WINDOW {
            self.windows.push(self.next / WINDOW as u64, &sums, spread);
            self.slow_spectrum.push(&[sums.sum]);
        }
    }
}
