//! What finds spectral peaks has in common: the noise around each point of a spectrum, and where
//! between two points a peak lies.
//!
//! Two searches use it. `spectral_lines` reports: local maxima of the spectrum of the samples that
//! twelve clean channels hardly ever show. `narrow_bands` protects the fit: all points of high
//! power of two spectra, at a higher rate of false alarms, with the width of what drifts or is
//! swept. Neither result can be derived from the other.

use core::f64::consts::PI;

use crate::accumulate::spectrum::Powers;

/// Lowest point examined: below, the noise around a point includes the point, and drift leaks in.
pub(super) const LOWEST: usize = 4;

/// Points on either side that a line of one frequency reaches under the Hann window.
pub(super) const REACH: usize = 2;

/// Up to so many cycles per sum of samples the spectrum of the sums shows what is slow, beyond that
/// of the samples.
pub(super) const JOINED: f64 = 0.45;

impl Powers {
    /// The power at point k, mirrored about half the sampling rate as every sampled spectrum is.
    pub(super) fn power(&self, k: usize) -> f64 {
        let last = self.segment_samples / 2;
        self.powers[if k > last { 2 * last - k } else { k }]
    }

    /// For each point the median of those up to `most` points away, as many on either side, so that
    /// a slope cancels. Infinite below [`LOWEST`].
    pub(super) fn floors(&self, most: usize) -> Vec<f64> {
        let last = self.segment_samples / 2;
        let mut floors = vec![f64::INFINITY; LOWEST.min(last + 1)];
        // in rising order: from point 1 on at first, then as many on either side
        let mut around: Vec<f64> = Vec::with_capacity(2 * most + 1);
        let place = |around: &[f64], power: f64| around.partition_point(|other| other.total_cmp(&power).is_lt());
        let mut end = 1;
        for k in LOWEST..=last {
            let side = points_on_a_side(k, most);
            // as many on either side as before: one takes the place of another
            if around.len() == 2 * side + 1 && end == k + side {
                let (from, to) = (place(&around, self.power(k - side - 1)), place(&around, self.power(end)));
                if from < to {
                    around.copy_within(from + 1..to, from);
                    around[to - 1] = self.power(end);
                } else {
                    around.copy_within(to..from, to + 1);
                    around[to] = self.power(end);
                }
                end += 1;
            }
            while end <= k + side {
                let power = self.power(end);
                around.insert(place(&around, power), power);
                end += 1;
            }
            if around.len() > 2 * side + 1 {
                around.remove(place(&around, self.power(k - side - 1)));
            }
            floors.push(around[side]);
        }
        floors
    }
}

/// Points on either side of point k in the median of at most `most` on a side.
pub(super) fn points_on_a_side(k: usize, most: usize) -> usize {
    most.min(k - 1)
}

/// Where the line of the highest point `peak` lies, in points, by the power `above` the noise.
///
/// Grandke (1983): of a line at k + δ the Hann window passes to k and k + 1 amplitudes in the ratio
/// (1 + δ)/(2 - δ).
pub(super) fn interpolated(peak: usize, above: impl Fn(usize) -> f64) -> f64 {
    let (below, here, beyond) = (above(peak - 1).max(0.0), above(peak), above(peak + 1).max(0.0));
    let ratio = (below.max(beyond) / here).sqrt();
    let off = ((2.0 * ratio - 1.0) / (ratio + 1.0)).max(0.0);
    peak as f64 + if beyond >= below { off } else { -off }
}

/// Whether a line at `fast` cycles per sample lies at `slow` in the spectrum of the sums of so many
/// samples, folded, within `reach` cycles per sum.
pub(super) fn is_folded(fast: f64, slow: f64, samples: f64, reach: f64) -> bool {
    let cycles = fast * samples;
    ((cycles - cycles.round()).abs() - slow * samples).abs() < reach
}

/// Share of the power of a line that the means over so many samples have.
pub(super) fn passed(frequency: f64, samples: f64) -> f64 {
    let phase = PI * frequency;
    ((phase * samples).sin() / (samples * phase.sin())).powi(2)
}
