//! Fits to one channel, and the columns that it adds to the model.

use super::{
    ChannelCurve, NoiseFit, NoiseModel, Parameter, Status, Term,
    channel_fit::ChannelFit,
    gauss_markov,
    model::{Beside, BesideKind, Model},
};
use crate::accumulate::record::{Deviation, Octave};
use crate::infer::narrow_bands::NarrowBand;
use crate::infer::power_law::expected_variance;
use crate::infer::roll_off::RollOff;
use crate::infer::slow_cycle::SlowCycle;

/// Lines with a power of their own in the fit.
const MOST_LINES: usize = 5;

/// After so many times its correlation beyond one sample a filter has forgotten.
const SETTLED: f64 = 4.0;

/// In samples.
const SHORTEST_CORRELATION: f64 = 16.0;

/// Behind a filter, of the first averaging factor in use.
const BEHIND_FILTER: f64 = 4.0;

/// Of the record: longer processes look like a random walk.
const LONGEST_CORRELATION: f64 = 1.0 / 16.0;

impl NoiseModel {
    /// Fits the model to one channel.
    ///
    /// Generalised least squares with the covariance of all octaves from the fitted model itself,
    /// on statistics made normal, with squared amplitudes that cannot be negative. Each line of the
    /// spectrum is a term of its own, with its frequency known and its power free, and so is a
    /// cycle of the level. Where that does not hold with p >= 0.01, or χ² falls by more than 8 with
    /// them, Gauss-Markov processes with correlation times of 16 samples times powers of four, up
    /// to a sixteenth of the record, join the terms; where it falls by 3 to 8 the interval of N
    /// covers the fits with and without them, and by 8 to 16 those of N, B and K do. Where that
    /// does not hold either, or the lower end of N lies above what the curve itself leaves, the
    /// model is rejected, and N is bounded by the curve. It is bounded by the fit where lines cover
    /// more than half of the frequencies.
    ///
    /// Behind a proved filter of unknown transfer the terms are fitted from the first octave on
    /// that averages over four times its memory, the second at the earliest; a known window is
    /// tried first. If a filter is possible but not proved, and neither a window nor
    /// quantisation is in the model, both fits are made: intervals and bounds of N, B and K cover
    /// both, and a term that only one of them shows is bounded. If only the fit behind the filter
    /// follows the model, it is the result. A rejected model without window and quantisation
    /// bounds N by octaves of ten times the filter's memory and more, ten samples if that is not
    /// known.
    ///
    /// Whether a random walk is there is decided by the level of the channel, by the likelihood of
    /// the cosine coefficients of its block means and of the octaves up to half a block: where
    /// level and slope are known, the octaves bound K, and the model has white noise, flicker
    /// noise, a random walk and a ramp, but no line, cycle, process or filter. K and its interval
    /// are those of the octaves, or, where these do not exclude zero, of that likelihood, the upper
    /// end the larger of both.
    ///
    /// A parameter is [`Status::Estimated`] where zero is excluded by more than 1.96 standard
    /// deviations (χ² falls by 3.84, or twice the log-likelihood of the level), else bounded from
    /// above. Interval and bound are the
    /// amplitudes that the data do not exclude at the level `confidence` (0 < p < 1), the other
    /// terms fitted anew for each of them; the bound is the upper end of the two-sided interval, so
    /// that the level holds whichever comes out.
    #[must_use]
    pub fn fit(&self, curve: &ChannelCurve<'_>, confidence: f64) -> NoiseFit {
        self.fit_first(&[self.fitted], self.octaves.len(), curve, confidence)
    }

    /// As [`fit`](Self::fit), without a ramp, to as many of the first `octaves` as follow the
    /// model, half of them at least, without the longest: for streams whose long averaging times
    /// show something else, such as a filter that takes slow changes out.
    #[must_use]
    pub fn fit_part(&self, curve: &ChannelCurve<'_>, octaves: usize, confidence: f64) -> NoiseFit {
        let octaves = self.octaves.partition_point(|(place, _)| *place < octaves);
        let fitted = self.fitted.min(octaves);
        let ends: Vec<usize> = (0..=fitted / 2).map(|excluded| fitted - excluded).collect();
        let curve = ChannelCurve { slope_unit_s: None, ..*curve };
        let mut fit = self.fit_first(&ends, octaves, &curve, confidence);
        fit.parameters[Term::RateRamp as usize] = None;
        fit
    }

    /// To as many of the first octaves as follow the model, `ends` of them, in falling order; the
    /// first `octaves` are known.
    fn fit_first(&self, ends: &[usize], octaves: usize, curve: &ChannelCurve<'_>, confidence: f64) -> NoiseFit {
        let fit = ChannelFit::new(self, ends, octaves, curve, confidence);
        fit.map_or_else(|| self.without_values(Status::NotObservable), |fit| fit.noise_fit())
    }

    /// Nothing else in the model explains what a filter makes of the shortest averaging times: a
    /// window does, and quantisation.
    pub(super) fn may_be_filtered(&self) -> bool {
        self.window.is_none() && !self.terms.contains(Term::Quantization)
    }

    /// The model behind a filter of unknown transfer, and the first octave that averages over what
    /// it remembers; `None` if there is none.
    pub(super) fn filtered(&self, model: &Model, fitted: usize, roll_off: RollOff) -> Option<(Model, usize)> {
        let shortest = (SETTLED * (roll_off.correlation_samples - 1.0)).max(2.0);
        let first = self.octaves[..fitted].iter().position(|(_, octave)| octave.m as f64 >= shortest)?;
        Some((model.filtered(self.octaves[first].1.m as f64), first))
    }

    /// A column for each of the strongest bands, `most` of them at most, and one for the others.
    pub(super) fn lines(&self, bands: &[NarrowBand], most: usize) -> Vec<Beside> {
        let mut bands: Vec<&NarrowBand> = bands.iter().filter(|band| band.power > 0.0).collect();
        bands.sort_by(|a, b| b.power.total_cmp(&a.power));
        let separate = most.saturating_sub(1).clamp(1, MOST_LINES).min(bands.len());
        let (strongest, others) = bands.split_at(separate);
        let groups = strongest.iter().map(core::slice::from_ref).chain((!others.is_empty()).then_some(others));
        groups
            .map(|group| {
                let total: f64 = group.iter().map(|band| band.power).sum();
                let variance = |(_, octave): &(usize, Octave)| {
                    let of = |band: &&NarrowBand| {
                        let (mean, spread) = band.variance(self.shape.deviation, octave.m);
                        let mean = octave.expected(mean, |m| band.variance(Deviation::Allan, m).0);
                        (band.power / total * mean, band.power / total * spread)
                    };
                    group
                        .iter()
                        .map(of)
                        .fold((0.0_f64, 0.0_f64), |(mean, spread), of| (mean + of.0, spread.hypot(of.1)))
                };
                let noise = group.iter().map(|band| band.power / total * band.noise_density).sum::<f64>();
                let noise = noise / self.shape.samples as f64;
                let (variances, spread) = self.octaves.iter().map(variance).unzip();
                Beside { variances, kind: BesideKind::Line { noise, spread, slope: 0.0 } }
            })
            .collect()
    }

    pub(super) fn cycle(&self, cycle: &SlowCycle) -> Beside {
        let variance = |(_, octave): &(usize, Octave)| {
            let of = |deviation, m| cycle.variance(&self.shape, deviation, m);
            let (mean, spread) = of(self.shape.deviation, octave.m);
            (octave.expected(mean, |m| of(Deviation::Allan, m).0), spread)
        };
        let (variances, spread) = self.octaves.iter().map(variance).unzip();
        let noise = cycle.noise_density / self.shape.samples as f64;
        let slope = cycle.slope(self.shape.samples).powi(2);
        Beside { variances, kind: BesideKind::Line { noise, spread, slope } }
    }

    /// Behind a filter, `shortest` is the first averaging factor in use: processes not much longer
    /// are what the filter makes.
    pub(super) fn gauss_markov_processes(&self, shortest: f64) -> Vec<Beside> {
        let first = SHORTEST_CORRELATION.max(BEHIND_FILTER * shortest);
        let times = core::iter::successors(Some(first), |time| Some(4.0 * time));
        let process = |time: f64| {
            let phase = |lag| gauss_markov::phase_covariance(lag, time);
            let variance = |(_, octave): &(usize, Octave)| expected_variance(octave, self.shape.deviation, phase);
            Beside { variances: self.octaves.iter().map(variance).collect(), kind: BesideKind::GaussMarkov { time } }
        };
        times.take_while(|time| *time <= self.shape.samples as f64 * LONGEST_CORRELATION).map(process).collect()
    }

    pub(super) fn without_values(&self, status: Status) -> NoiseFit {
        let parameter = |term| self.terms.contains(term).then_some(Parameter::without_value(status));
        NoiseFit::of_parameters(Term::ALL.map(parameter))
    }
}
