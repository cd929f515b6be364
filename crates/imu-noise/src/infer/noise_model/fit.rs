//! The fit of one channel: which octaves follow the model, and the parameters that they show.

use std::ops::Range;

use super::{
    FitQuality, GaussMarkovProcess, NoiseFit, NoiseModel, Parameter, Status, Term, gauss_markov,
    least_squares::dot,
    model::{Beside, BesideKind, Model},
    parameter::ramp,
    regression::{Regression, Solution},
};
use crate::accumulate::record::{Deviation, Octave};
use crate::infer::chi_squared;
use crate::infer::narrow_bands::NarrowBand;
use crate::infer::power_law::expected_variance;
use crate::infer::roll_off::RollOff;
use crate::infer::slow_cycle::SlowCycle;

/// Fits with a smaller probability are not believed.
const LEAST_P: f64 = 0.01;

/// By how much χ² must fall with Gauss-Markov processes where the model holds without them: chosen
/// for the coverage of N beside weak processes (the benchmark `cells`).
const PROCESS: f64 = 8.0;

/// By so much it falls where such processes can neither be said to be there nor to be absent: the
/// interval of N covers both.
const PERHAPS_A_PROCESS: f64 = 3.0;

/// Below, such processes may have taken what is flicker noise or a walk, and left too much to the
/// white noise: intervals and bounds of all three cover the fit without them.
const A_PROCESS_BEYOND_DOUBT: f64 = 16.0;

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

struct Accepted<'a> {
    model: &'a Model,
    regression: Regression<'a>,
    solution: Solution,
    range: Range<usize>,
    quality: FitQuality,
    /// Octaves that could have a part in the fit, and all that are known.
    known: (usize, usize),
}

/// The statistics of one channel.
#[derive(Clone, Copy, Debug, Default)]
pub struct ChannelCurve<'a> {
    /// In the order of the octaves, in the unit of the channel squared. Where one is missing, zero
    /// or no number, nothing is observable.
    pub variances: &'a [f64],
    /// Slope of the regression line, in the unit of the channel per second; without it, a ramp is
    /// not observable and is not in the model.
    pub slope_unit_s: Option<f64>,
    /// Lines of its spectrum, in the unit of the channel.
    pub bands: &'a [NarrowBand],
    /// A cycle of its level, of few periods or many.
    pub cycle: Option<SlowCycle>,
    /// A filter slower than the output, where the spectrum shows one or may show one, and its
    /// transfer is unknown.
    pub roll_off: Option<RollOff>,
    /// Fourth cumulant of the samples, in the unit to the fourth: excess kurtosis times variance
    /// squared; 0 for a normal distribution. Independent samples with heavy tails make every
    /// octave less certain.
    pub fourth_cumulant: f64,
}

impl<'a> ChannelCurve<'a> {
    /// A channel without lines.
    #[must_use]
    pub const fn new(variances: &'a [f64], slope_unit_s: Option<f64>) -> Self {
        Self { variances, slope_unit_s, bands: &[], cycle: None, roll_off: None, fourth_cumulant: 0.0 }
    }
}

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
    /// tried first. Where a filter is possible but not proved, and neither a window nor
    /// quantisation is in the model, both fits are made: intervals and bounds of N, B and K cover
    /// both, and a term that only one of them shows is bounded. If only the fit behind the filter
    /// follows the model, it is the result. A rejected model without window and quantisation
    /// bounds N by octaves of ten times the filter's memory and more, ten samples where that is not
    /// known.
    ///
    /// A parameter is [`Status::Estimated`] where zero is excluded by more than 1.96 standard
    /// deviations (χ² falls by 3.84), else bounded from above. Interval and bound are the
    /// amplitudes that the data do not exclude at the level `confidence` (0 < p < 1), the other
    /// terms fitted anew for each of them; the bound is the upper end of the two-sided interval, so
    /// that the level holds whichever comes out.
    #[must_use]
    pub fn fit(&self, curve: &ChannelCurve<'_>, confidence: f64) -> NoiseFit {
        self.fit_first(core::iter::once(0..self.fitted), self.octaves.len(), curve, confidence)
    }

    /// As [`fit`](Self::fit), without a ramp, to as many of the first `octaves` as follow the
    /// model, half of them at least, without the longest: for streams whose long averaging times
    /// show something else, such as a filter that takes slow changes out.
    #[must_use]
    pub fn fit_part(&self, curve: &ChannelCurve<'_>, octaves: usize, confidence: f64) -> NoiseFit {
        let octaves = self.octaves.partition_point(|(place, _)| *place < octaves);
        let fitted = self.fitted.min(octaves);
        let parts = (0..=fitted / 2).map(|excluded| 0..fitted - excluded);
        let curve = ChannelCurve { slope_unit_s: None, ..*curve };
        let mut fit = self.fit_first(parts, octaves, &curve, confidence);
        fit.parameters[Term::RateRamp as usize] = None;
        fit
    }

    /// To the first of `ranges`, each from 0 on and shorter than the one before, that follows the
    /// model; the first `octaves` are known.
    fn fit_first(
        &self,
        ranges: impl Iterator<Item = Range<usize>> + Clone,
        octaves: usize,
        curve: &ChannelCurve<'_>,
        confidence: f64,
    ) -> NoiseFit {
        let fitted = ranges.clone().next().map_or(0, |range| range.end);
        let mut values: Vec<f64> = self.octaves.iter().filter_map(|(i, _)| curve.variances.get(*i).copied()).collect();
        let slope = curve.slope_unit_s.map(|slope| slope * self.shape.interval_s);
        let (model, slope) = match (&self.with_ramp, slope) {
            (Some(model), Some(slope)) => (Some(model), Some(slope)),
            _ => (self.without_ramp.as_ref(), None),
        };
        let usable = values.len() == self.octaves.len() && values.iter().all(|value| value.is_finite() && *value > 0.0);
        values.extend(slope.map(|slope| slope * slope));
        let Some(model) = model.filter(|_| usable) else { return self.without_values(Status::NotObservable) };
        if fitted + usize::from(slope.is_some()) <= model.terms() {
            return self.without_values(Status::NotObservable);
        }
        let most = fitted.saturating_sub(model.terms() + 1 + usize::from(curve.cycle.is_some()));
        let mut lines = self.lines(curve.bands, most);
        lines.extend(curve.cycle.map(|cycle| self.cycle(&cycle)));
        let tails = curve.fourth_cumulant.max(0.0) / self.shape.samples as f64;
        let with_lines = model.beside(lines).with_tails(tails);
        let behind = |roll_off| self.filtered(&with_lines, fitted, roll_off);
        let proved = curve.roll_off.filter(|roll_off| roll_off.is_proved);
        // what a filter makes of the shortest averaging times, quantisation and a window make too
        let may_be_filtered = self.window.is_none() && !self.terms.contains(Term::Quantization);
        let roll_off = if may_be_filtered { curve.roll_off } else { proved };
        let filtered = roll_off.and_then(behind);
        if proved.is_some() && filtered.is_none() && self.window.is_none() {
            return self.without_values(Status::NotObservable);
        }
        let white = filtered.as_ref().map_or(model, |(behind_filter, _)| behind_filter).white().to_vec();
        let ceiling = |roll_off, risk| self.white_ceiling(&white, &values[..octaves], roll_off, risk);
        let lacks_free_band = curve.bands.iter().map(|band| band.share_of_band).sum::<f64>() > 0.5;
        let solve = |model: &Model, range: Range<usize>| {
            let regression = Regression::new(model, &values, range.clone());
            let solution = regression.fit()?;
            let positive = solution.parameters.iter().filter(|parameter| **parameter > 0.0).count();
            let dof = regression.statistics().checked_sub(positive).filter(|dof| *dof > 0)?;
            let p = chi_squared::probability_above(solution.chi2, dof as f64)?;
            let tau_s = |i: usize| self.octaves[i].1.m as f64 * self.shape.interval_s;
            let (tau_min_s, tau_max_s) = (tau_s(range.start), tau_s(range.end - 1));
            let quality = FitQuality { tau_min_s, tau_max_s, chi2: solution.chi2, dof, p };
            Some((solution, quality))
        };
        let read_out = |model: &Model, range: Range<usize>, (solution, quality): (Solution, FitQuality)| {
            let doubtless = ceiling(roll_off, 0.01);
            let regression = Regression::new(model, &values, range.clone());
            let accepted = Accepted { model, regression, solution, range, quality, known: (fitted, octaves) };
            let fit = self.read_out(&accepted, slope, confidence);
            let white = fit.parameter(Term::White).and_then(|white| white.lower);
            let scale = Term::White.per_second(self.shape.interval_s);
            let mut fit = white.is_none_or(|lower| (lower / scale).powi(2) <= doubtless).then_some(fit)?;
            fit.lacks_free_band = lacks_free_band;
            if lacks_free_band {
                fit.not_proved(Term::White);
            }
            Some(fit)
        };
        let attempt = |model: &Model, first: usize| {
            let with_processes = model.beside(self.gauss_markov_processes(self.octaves[first].1.m as f64));
            let ranges = ranges.clone().map(|range| range.start.max(first)..range.end);
            let found = ranges.clone().find_map(|range| {
                let without = solve(model, range.clone()).filter(|(_, quality)| quality.p >= LEAST_P)?;
                // χ² cannot fall by more than all of it
                let possible = without.1.chi2 > PERHAPS_A_PROCESS;
                let with = possible.then(|| solve(&with_processes, range.clone())).flatten();
                let fall = with.as_ref().map_or(0.0, |(_, with)| without.1.chi2 - with.chi2);
                let with = with.filter(|_| fall > PERHAPS_A_PROCESS);
                let with = with.and_then(|with| read_out(&with_processes, range.clone(), with));
                if fall > A_PROCESS_BEYOND_DOUBT {
                    return with.map(NoiseFit::with_proved_processes);
                }
                let without = read_out(model, range, without);
                let (mut fit, other, terms) = match fall > PROCESS {
                    true => (with?, without, &[Term::White, Term::BiasInstability, Term::RateRandomWalk][..]),
                    false => (without?, with, &[Term::White][..]),
                };
                if let Some(other) = other {
                    terms.iter().for_each(|term| fit.widen(*term, &other));
                }
                Some(fit)
            });
            found.or_else(|| {
                ranges.clone().find_map(|range| {
                    let with = solve(&with_processes, range.clone()).filter(|(_, quality)| quality.p >= LEAST_P)?;
                    read_out(&with_processes, range, with).map(NoiseFit::with_proved_processes)
                })
            })
        };
        // A known window explains its own roll-off.
        let whole = (proved.is_none() || self.window.is_some()).then(|| attempt(&with_lines, 0)).flatten();
        let is_settled = whole.is_some() && proved.is_some();
        let behind_filter = filtered.filter(|_| !is_settled).and_then(|(model, first)| attempt(&model, first));
        let fit = match (whole, behind_filter) {
            // a filter that only may be there
            (Some(mut whole), Some(behind_filter)) => {
                whole.cover(&behind_filter);
                Some(whole)
            }
            (whole, behind_filter) => whole.or_else(|| {
                let may_be_filtered = proved.is_none();
                Some(NoiseFit { roll_off: proved, may_be_filtered, ..behind_filter? })
            }),
        };
        fit.unwrap_or_else(|| {
            let mut rejected = NoiseFit { lacks_free_band, ..self.without_values(Status::ModelRejected) };
            // a filter may be why
            let ceiling = ceiling(roll_off.or(may_be_filtered.then_some(RollOff::POSSIBLE)), 1.0 - confidence);
            if let Some(white) = &mut rejected.parameters[Term::White as usize]
                && ceiling.is_finite()
            {
                *white = Parameter::bounded(ceiling.sqrt() * Term::White.per_second(self.shape.interval_s));
            }
            rejected
        })
    }

    /// The model behind a filter of unknown transfer, and the first octave that averages over what
    /// it remembers; `None` where there is none.
    fn filtered(&self, model: &Model, fitted: usize, roll_off: RollOff) -> Option<(Model, usize)> {
        let shortest = (SETTLED * (roll_off.correlation_samples - 1.0)).max(2.0);
        let first = self.octaves[..fitted].iter().position(|(_, octave)| octave.m as f64 >= shortest)?;
        Some((model.filtered(self.octaves[first].1.m as f64), first))
    }

    /// What the squared N is above with the probability `risk` at most, per sample: a variance is
    /// that of the white noise and whatever adds, so that its upper end bounds N². The upper ends
    /// of all octaves hold together (Bonferroni), with the degrees of freedom of a random walk,
    /// which has fewest. Behind an unknown filter those octaves count that average over ten times
    /// its correlation, less the most that the filter can take from them.
    fn white_ceiling(&self, white: &[f64], values: &[f64], roll_off: Option<RollOff>, risk: f64) -> f64 {
        let shortest = roll_off.map_or(0.0, |roll_off| 10.0 * roll_off.correlation_samples.max(1.0));
        let octaves = self.octaves.iter().zip(&self.least_edf).zip(values).zip(white);
        let counted: Vec<(f64, f64)> = octaves
            .filter(|((((_, octave), edf), _), _)| octave.m as f64 >= shortest && **edf >= 10.0)
            .map(|(((_, edf), value), white)| (value / white, *edf))
            .collect();
        let each = risk / counted.len() as f64;
        let bound = |(value, edf): &(f64, f64)| Some(value * edf / chi_squared::quantile(each, *edf)?);
        counted.iter().filter_map(bound).fold(f64::INFINITY, f64::min)
    }

    /// A column for each of the strongest bands, `most` of them at most, and one for the others.
    fn lines(&self, bands: &[NarrowBand], most: usize) -> Vec<Beside> {
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

    fn cycle(&self, cycle: &SlowCycle) -> Beside {
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
    fn gauss_markov_processes(&self, shortest: f64) -> Vec<Beside> {
        let first = SHORTEST_CORRELATION.max(BEHIND_FILTER * shortest);
        let times = core::iter::successors(Some(first), |time| Some(4.0 * time));
        let process = |time: f64| {
            let phase = |lag| gauss_markov::phase_covariance(lag, time);
            let variance = |(_, octave): &(usize, Octave)| expected_variance(octave, self.shape.deviation, phase);
            Beside { variances: self.octaves.iter().map(variance).collect(), kind: BesideKind::GaussMarkov { time } }
        };
        times.take_while(|time| *time <= self.shape.samples as f64 * LONGEST_CORRELATION).map(process).collect()
    }

    fn without_values(&self, status: Status) -> NoiseFit {
        let parameter = |term| self.terms.contains(term).then_some(Parameter::without_value(status));
        NoiseFit::of_parameters(Term::ALL.map(parameter))
    }

    fn read_out(&self, accepted: &Accepted<'_>, slope: Option<f64>, confidence: f64) -> NoiseFit {
        let Accepted { model, regression, solution, range, quality, known: (fitted, octaves) } = accepted;
        let mut fit = self.without_values(Status::NotObservable);
        fit.quality = Some(*quality);
        fit.processes = model
            .gauss_markov_times()
            .zip(&solution.parameters[model.terms()..])
            .filter_map(|(time, square)| Some((time?, square)).filter(|(_, square)| **square > 0.0))
            .map(|(time, square)| GaussMarkovProcess {
                correlation_time_s: time * self.shape.interval_s,
                sigma: square.sqrt(),
            })
            .collect();
        // What noise may be at most makes slopes; a measured noise is known to some degrees of freedom.
        let mut upper_bounds = solution.parameters.clone();
        let mut deviations = vec![0.0; upper_bounds.len()];
        for (i, deviation) in deviations.iter_mut().enumerate().skip(model.terms()) {
            *deviation = solution.standard_deviation(i).unwrap_or_default();
        }
        for (i, &term) in self.noise.iter().enumerate() {
            let parameter = Parameter::of(regression, solution, i, confidence);
            if parameter.status == Status::Bounded {
                upper_bounds[i] = parameter.upper.map_or(upper_bounds[i], |upper| upper * upper);
            } else {
                deviations[i] = solution.standard_deviation(i).unwrap_or_default();
            }
            fit.parameters[term as usize] = Some(parameter.scaled(term.per_second(self.shape.interval_s)));
            for (j, &other) in self.noise[..i].iter().enumerate() {
                if solution.parameters[i] > 0.0 && solution.parameters[j] > 0.0 {
                    fit.correlations.extend(solution.correlation(i, j).map(|correlation| (other, term, correlation)));
                }
            }
        }
        if let Some(slope) = slope {
            let per_parameter = model.slope_variances();
            let variance = dot(&per_parameter, &upper_bounds);
            let error: f64 = per_parameter.iter().zip(&deviations).map(|(c, deviation)| (c * deviation).powi(2)).sum();
            let parameter = ramp(slope, variance.sqrt(), 2.0 * variance * variance / error, confidence);
            fit.parameters[Term::RateRamp as usize] =
                Some(parameter.scaled(Term::RateRamp.per_second(self.shape.interval_s)));
        }
        let expected = |i: usize| (self.octaves[i].1.m, model.expected(&solution.parameters, i));
        fit.expected = range.clone().filter(|i| *i < self.octaves.len()).map(expected).collect();
        let edf = model.edf(&solution.parameters, &upper_bounds, &self.least_edf);
        // octaves too long to be fitted may follow the model all the same
        let end = if range.end == *fitted { *octaves } else { range.end };
        fit.edf = self.octaves[..end].iter().map(|(_, octave)| octave.m).zip(edf).skip(range.start).collect();
        fit
    }
}
