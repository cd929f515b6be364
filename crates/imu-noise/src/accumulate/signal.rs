//! Spectrum, blocks and windows of one channel, by which a disturbed deviation is recognised.

use std::mem;

use super::aligned_sums::{AlignedBlock, AlignedSums};
use super::blocks::{Block, BlockSums, Blocks, Spreads, WINDOW};
use super::piece::{Piece, PieceNotAppended};
use super::spectrum::{Spectrum, SpectrumPlan};
use super::window_statistics::WindowStatistics;
use state_bytes::{BadEncoding, ByteReader, Encoded, check};

/// Windows in a sum of the slowest spectrum, and how many of them must be full.
const WINDOWS: u64 = 32;
const LEAST_WINDOWS: u64 = 24;

/// Spectrum, block statistics and disturbance windows of one channel.
///
/// The result is the same, bit by bit, for any division of the samples over calls of
/// [`push`](Self::push). A sensor at rest takes 21 KiB of memory at first and 40 KiB from hours on,
/// blocks 7.5 KiB of them and spectra most of the others, whatever the length of the record.
///
/// ```
/// use imu_noise::{ChannelSignal, Sides, SpectrumPlan};
///
/// let mut accelerometer = ChannelSignal::new(&SpectrumPlan::new());
/// let fan_5_hz = |i: u32| 100.0 * (std::f64::consts::TAU * 5.0 * 0.025 * f64::from(i)).sin();
/// let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 16) as i32 % 41 - 20;
/// accelerometer.push(&(0..4000).map(|i| fan_5_hz(i) as i32 + noise(i * i)).collect::<Vec<_>>());
/// let lines = accelerometer.lines(0.025, 3);
/// assert!(lines.len() == 1 && (lines[0].frequency_hz - 5.0).abs() < 1e-2);
/// assert_eq!(accelerometer.spectrum().density(Sides::One, 0.025, 3).unwrap().points.len(), 256);
/// ```
#[derive(Clone, Debug)]
pub struct ChannelSignal {
    spectrum: Spectrum,
    /// Of the sums of windows: the spectrum up to 1/64 of the sampling rate, in finer steps.
    slow_spectrum: Spectrum<i64>,
    /// Of the sums of as many windows as a window has samples, for what is slower still. A sum that
    /// lacks a few windows is enlarged in proportion.
    slowest_spectrum: Spectrum<i64>,
    sums: AlignedSums,
    blocks: Blocks,
    pub(crate) windows: WindowStatistics,
    piece: Piece,
    /// Samples of the record before the piece, and up to its end.
    samples_before: u64,
    samples: u64,
    /// Missing samples are among these.
    counts_missing: bool,
    /// The end of a window, all of it, where the piece begins within one.
    head: Option<Vec<i32>>,
    /// The last samples, without a gap between them, of the window that is not full.
    window: Vec<i32>,
}

impl ChannelSignal {
    /// A channel without samples.
    #[must_use]
    pub fn new(plan: &SpectrumPlan) -> Self {
        Self {
            spectrum: Spectrum::new(plan, false),
            slow_spectrum: Spectrum::new(plan, true),
            slowest_spectrum: Spectrum::new(plan, true),
            sums: AlignedSums::new(WINDOWS, 0),
            blocks: Blocks::new(),
            windows: WindowStatistics::new(),
            piece: Piece::starting_at(0),
            samples_before: 0,
            samples: 0,
            counts_missing: false,
            head: None,
            window: Vec::with_capacity(WINDOW),
        }
    }

    /// The accumulator for a piece of a record whose first sample has this absolute index.
    /// `samples_before` is the number of samples of the record before the piece, without the
    /// missing ones. To be called before any sample.
    #[must_use]
    pub fn starting_at(mut self, index: u64, samples_before: u64) -> Self {
        self.piece = Piece::starting_at(index);
        (self.samples_before, self.samples) = (samples_before, samples_before);
        self.spectrum.start_at(index, samples_before);
        let window = index.div_ceil(WINDOW as u64);
        self.slow_spectrum.start_at(window, window);
        let sum = window.div_ceil(WINDOWS);
        self.slowest_spectrum.start_at(sum, sum);
        self.sums = AlignedSums::new(WINDOWS, window);
        self
    }

    /// The accumulator with segments of the spectrum that are spaced by all places of the record,
    /// including missing samples: for a channel whose number of samples before a piece is not
    /// known. To be called before any sample.
    #[must_use]
    pub const fn counting_missing(mut self) -> Self {
        self.spectrum.count_missing();
        self.counts_missing = true;
        self
    }

    /// Adds the next samples, in time order.
    pub fn push(&mut self, mut counts: &[i32]) {
        self.spectrum.push(counts);
        self.samples += counts.len() as u64;
        while !counts.is_empty() {
            let room = WINDOW - (self.piece.end % WINDOW as u64) as usize;
            let (now, later) = counts.split_at(room.min(counts.len()));
            if now.len() == WINDOW {
                self.add_window(now);
            } else {
                self.window.extend_from_slice(now);
                if now.len() == room {
                    self.end_window(true);
                }
            }
            self.piece.end += now.len() as u64;
            counts = later;
        }
    }

    /// Adds a gap: `Some(missing)` samples, or an unknown number, which counts as none in the
    /// index. The count of seconds continues. A segment of the spectrum or a disturbance window
    /// that lacks a sample is not used, and none spans a break, which is `Some(0)` or an unknown
    /// number.
    pub fn gap(&mut self, missing: Option<u64>) {
        let missing = self.piece.room_for(missing.unwrap_or(0));
        self.end_window(false);
        self.spectrum.gap(missing);
        self.piece.end += missing;
        self.samples += if self.counts_missing { missing } else { 0 };
        if missing == 0 {
            self.piece.part();
            // The window of the break lacks samples: the break is behind it, in any division.
            self.miss_windows_up_to(self.piece.end.div_ceil(WINDOW as u64));
            self.slow_spectrum.gap(0);
            // a sum of means of either side of a break is a mean as well
            self.windows.part();
        }
    }

    /// Appends the piece of the record that follows this one. The result is the same, bit by bit,
    /// as of one record of all samples, in whatever order neighbours are appended. Samples between
    /// the two pieces count as missing.
    ///
    /// # Errors
    /// [`PieceNotAppended`] where `next` begins before this piece ends, or was begun after another
    /// number of samples. Then nothing is appended.
    pub fn append(&mut self, next: &Self) -> Result<(), PieceNotAppended> {
        self.piece.check_follows(&next.piece)?;
        let between = next.piece.start.saturating_sub(self.piece.end);
        let samples = self.samples + if self.counts_missing { between } else { 0 };
        if next.counts_missing != self.counts_missing {
            return Err(PieceNotAppended::OtherKind);
        }
        if next.samples_before != samples {
            return Err(PieceNotAppended::OtherSamples { samples, samples_before: next.samples_before });
        }
        match between {
            0 => {}
            between => self.gap(Some(between)),
        }
        if let Some(head) = &next.head {
            self.window.extend_from_slice(head);
            self.end_window(true);
        } else if next.is_within_window() {
            self.window.extend_from_slice(&next.window);
        } else {
            self.end_window(false);
        }
        self.spectrum.append(&next.spectrum);
        if !next.is_within_window() {
            self.window.clone_from(&next.window);
            // the sums of a piece within a window begin behind that window, which is still open
            self.slow_spectrum.append(&next.slow_spectrum);
            self.sums.append(&next.sums, |sum| add_sum(sum, &mut self.slowest_spectrum));
            // likewise
            if !next.sums.is_within_block() {
                self.slowest_spectrum.append(&next.slowest_spectrum);
            }
        }
        self.blocks.append(&next.blocks);
        self.windows.append(&next.windows);
        self.samples = next.samples;
        self.piece.append(&next.piece);
        Ok(())
    }

    /// Adds `by` to the counts of all samples so far; the counts must have room for that.
    pub fn shift(&mut self, by: i64) {
        let shifted = |count: i32| (i64::from(count) + by) as i32;
        self.spectrum.shift(shifted);
        let by_window = by * WINDOW as i64;
        self.slow_spectrum.shift(|sum| sum + by_window);
        self.slowest_spectrum.shift(|sum| sum + by_window * WINDOWS as i64);
        self.sums.shift(by_window);
        self.blocks.shift(by);
        self.windows.shift(by);
        self.head.iter_mut().flatten().chain(&mut self.window).for_each(|count| *count = shifted(*count));
    }

    /// Appends the form in bytes to `out`.
    pub fn encode(&self, out: &mut Vec<u8>) {
        self.spectrum.encode(out);
        self.slow_spectrum.encode(out);
        self.slowest_spectrum.encode(out);
        self.sums.encode(out);
        self.blocks.encode(out);
        self.windows.encode(out);
        self.piece.encode(out);
        self.samples_before.encode(out);
        self.samples.encode(out);
        self.counts_missing.encode(out);
        self.head.encode(out);
        self.window.encode(out);
    }

    /// Reads the form from the front of `input`; the spectra continue with this plan.
    ///
    /// # Errors
    /// As [`Encoded::decode`].
    pub fn decode(plan: &SpectrumPlan, input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        let signal = Self {
            spectrum: Spectrum::decode(plan, input)?,
            slow_spectrum: Spectrum::decode(plan, input)?,
            slowest_spectrum: Spectrum::decode(plan, input)?,
            sums: Encoded::decode(input)?,
            blocks: Encoded::decode(input)?,
            windows: Encoded::decode(input)?,
            piece: Encoded::decode(input)?,
            samples_before: Encoded::decode(input)?,
            samples: Encoded::decode(input)?,
            counts_missing: Encoded::decode(input)?,
            head: Encoded::decode(input)?,
            window: Encoded::decode(input)?,
        };
        let is_part = |part: &Vec<i32>| part.len() < WINDOW;
        check(is_part(&signal.window) && signal.head.iter().all(is_part))?;
        Ok(signal)
    }

    /// The power spectral density, with its peaks.
    #[must_use]
    pub const fn spectrum(&self) -> &Spectrum {
        &self.spectrum
    }

    /// Of the sums of so many samples: 32, and 1024.
    pub(crate) fn slow_spectra(&self) -> [(&Spectrum<i64>, u64); 2] {
        let window = WINDOW as u64;
        [(&self.slow_spectrum, window), (&self.slowest_spectrum, WINDOWS * window)]
    }

    /// Mean, standard deviation and extremes of the blocks of the record, in time order: at most
    /// [`MAX_BLOCKS`](crate::MAX_BLOCKS), without those that have no sample.
    #[must_use]
    pub fn blocks(&self) -> Vec<Block> {
        let mut blocks = self.blocks.clone();
        if let Some(head) = &self.head {
            blocks.add(self.piece.start, &BlockSums::of(head).0);
        }
        if let (Some(place), false) = (self.piece.end.checked_sub(1), self.window.is_empty()) {
            blocks.add(place, &BlockSums::of(&self.window).0);
        }
        blocks.iter().collect()
    }

    /// It has a gap of unknown length.
    pub(crate) const fn is_parted(&self) -> bool {
        self.piece.is_parted()
    }

    /// First sample, length and spreads of the blocks that have full windows.
    pub(crate) fn spreads(&self) -> Vec<(u64, u64, Spreads)> {
        self.blocks.spreads().map(|(first, length, spreads)| (first, length, *spreads)).collect()
    }

    /// Of a piece that ends in the window that it begins in, no sample missing.
    fn is_within_window(&self) -> bool {
        let places = self.piece.end - self.piece.start;
        self.head.is_none() && !self.piece.is_parted() && self.window.len() as u64 == places
    }

    /// Ends the window of the place behind the last one, at its end or because samples are missing.
    fn end_window(&mut self, is_at_end: bool) {
        let window = mem::take(&mut self.window);
        let end = (self.piece.end / WINDOW as u64 + 1) * WINDOW as u64;
        let is_part = window.len() < WINDOW && window.len() as u64 == end - self.piece.start;
        if is_at_end && is_part && !self.piece.is_parted() {
            self.head = Some(window);
            return;
        }
        if !window.is_empty() {
            self.add_window(&window);
        }
        self.window = window;
        self.window.clear();
    }

    /// The samples of the window of the place behind the last one.
    fn add_window(&mut self, window: &[i32]) {
        let (sums, spread) = BlockSums::of(window);
        self.blocks.add(self.piece.end, &sums);
        if window.len() == WINDOW {
            let number = self.piece.end / WINDOW as u64;
            self.windows.push(number, &sums, spread);
            self.miss_windows_up_to(number);
            self.slow_spectrum.push(&[sums.sum]);
            self.sums.push(&[sums.sum], |sum| add_sum(sum, &mut self.slowest_spectrum));
        }
    }

    fn miss_windows_up_to(&mut self, number: u64) {
        match number.saturating_sub(self.slow_spectrum.end()) {
            0 => {}
            missing => {
                self.slow_spectrum.gap(missing);
                self.sums.gap(Some(missing), |sum| add_sum(sum, &mut self.slowest_spectrum));
            }
        }
    }
}

fn add_sum(sum: AlignedBlock, spectrum: &mut Spectrum<i64>) {
    if sum.present < LEAST_WINDOWS {
        return;
    }
    if let missing @ 1.. = sum.number.saturating_sub(spectrum.end()) {
        spectrum.gap(missing);
    }
    // rounded once; below 2^46
    let whole = sum.sum * WINDOWS as i64;
    spectrum.push(&[if sum.present == WINDOWS { sum.sum } else { whole / sum.present as i64 }]);
}
