//! The fit of one channel: with and without Gauss-Markov processes, with and without a filter.

use std::ops::Range;

use super::{
    ChannelCurve, FitQuality, GaussMarkovProcess, NoiseFit, NoiseModel, Parameter, Status, Term,
    level_likelihood::{LevelLikelihood, ShortOctaves},
    model::Model,
    parameter::{PRESENT, ramp},
    regression::{Regression, Solution},
};
use crate::accumulate::record::Octave;
use crate::infer::chi_squared;
use crate::infer::least_squares::dot;
use crate::infer::level_series::LevelSeries;
use crate::infer::roll_off::RollOff;

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

/// The only terms beside which the level decides on K.
const WALKING: [Term; 3] = [Term::White, Term::BiasInstability, Term::RateRandomWalk];

/// One channel, its models, and the octaves that may follow them.
pub(super) struct ChannelFit<'a> {
    noise_model: &'a NoiseModel,
    /// The octaves, then the squared slope if it is known.
    values: Vec<f64>,
    /// Of the regression line, per sample.
    slope: Option<f64>,
    /// How many octaves may have a part in the fit, in falling order: the first that follows a
    /// model counts.
    ends: &'a [usize],
    /// Octaves that could have a part in the fit, and all that are known.
    known: (usize, usize),
    /// The terms with the lines and the cycle of the channel.
    model: Model,
    /// The same behind its filter of unknown transfer, and the first octave that averages over what
    /// that remembers.
    behind_filter: Option<(Model, usize)>,
    /// That filter, proved or possible.
    roll_off: Option<RollOff>,
    /// Expected value of each octave for white noise of parameter 1.
    white: Vec<f64>,
    level: Option<&'a LevelSeries>,
    lacks_free_band: bool,
    confidence: f64,
}

/// A solution that follows its model.
struct Accepted<'a> {
    model: &'a Model,
    range: Range<usize>,
    solution: Solution,
    quality: FitQuality,
}

impl<'a> ChannelFit<'a> {
    /// `None` if the channel does not show more than it has parameters.
    pub(super) fn new(
        noise_model: &'a NoiseModel,
        ends: &'a [usize],
        octaves: usize,
        curve: &ChannelCurve<'a>,
        confidence: f64,
    ) -> Option<Self> {
        let fitted = *ends.first()?;
        let mut values: Vec<f64> =
            noise_model.octaves.iter().filter_map(|(i, _)| curve.variances.get(*i).copied()).collect();
        let usable =
            values.len() == noise_model.octaves.len() && values.iter().all(|value| value.is_finite() && *value > 0.0);
        let slope = curve.slope_unit_s.map(|slope| slope * noise_model.shape.interval_s);
        let (terms, slope) = match (&noise_model.with_ramp, slope) {
            (Some(model), Some(slope)) => (Some(model), Some(slope)),
            _ => (noise_model.without_ramp.as_ref(), None),
        };
        values.extend(slope.map(|slope| slope * slope));
        let terms = terms.filter(|_| usable)?;
        if fitted + usize::from(slope.is_some()) <= terms.terms() {
            return None;
        }
        let most = fitted.saturating_sub(terms.terms() + 1 + usize::from(curve.cycle.is_some()));
        let mut lines = noise_model.lines(curve.bands, most);
        lines.extend(curve.cycle.map(|cycle| noise_model.cycle(&cycle)));
        let tails = curve.fourth_cumulant.max(0.0) / noise_model.shape.samples as f64;
        let model = terms.beside(lines).with_tails(tails);
        let roll_off = curve.roll_off.filter(|roll_off| roll_off.is_proved || noise_model.may_be_filtered());
        let behind_filter = roll_off.and_then(|roll_off| noise_model.filtered(&model, fitted, roll_off));
        let is_proved = roll_off.is_some_and(|roll_off| roll_off.is_proved);
        if is_proved && behind_filter.is_none() && noise_model.window.is_none() {
            return None;
        }
        let white = behind_filter.as_ref().map_or(terms, |(behind_filter, _)| behind_filter).white().to_vec();
        Some(Self {
            noise_model,
            values,
            slope,
            ends,
            known: (fitted, octaves),
            model,
            behind_filter,
            roll_off,
            white,
            level: curve.level,
            lacks_free_band: curve.bands.iter().map(|band| band.share_of_band).sum::<f64>() > 0.5,
            confidence,
        })
    }

    pub(super) fn noise_fit(&self) -> NoiseFit {
        let proved = self.roll_off.filter(|roll_off| roll_off.is_proved);
        // a known window explains its own roll-off
        let is_explained = proved.is_none() || self.noise_model.window.is_some();
        let whole = is_explained.then(|| self.following(&self.model, 0)).flatten();
        let is_settled = whole.is_some() && proved.is_some();
        let behind_filter = self.behind_filter.as_ref().filter(|_| !is_settled);
        let behind_filter = behind_filter.and_then(|(model, first)| self.following(model, *first));
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
        fit.unwrap_or_else(|| self.rejected())
    }

    /// The fit of `model` to the first range that follows it, from octave `first` on.
    fn following(&self, model: &Model, first: usize) -> Option<NoiseFit> {
        let shortest = self.noise_model.octaves[first].1.m as f64;
        let with_processes = model.beside(self.noise_model.gauss_markov_processes(shortest));
        let ranges = || self.ends.iter().map(|end| first..*end);
        let found = ranges().find_map(|range| self.with_or_without(model, &with_processes, &range));
        found.or_else(|| {
            ranges().find_map(|range| {
                let with = self.solve(&with_processes, &range).filter(|with| with.quality.p >= LEAST_P)?;
                self.read_out(with).map(NoiseFit::with_proved_processes)
            })
        })
    }

    /// If `model` holds: the fit with Gauss-Markov processes, or the one without them, whichever
    /// the record shows, with intervals that cover both where it does not decide.
    fn with_or_without(&self, model: &Model, with_processes: &Model, range: &Range<usize>) -> Option<NoiseFit> {
        let without = self.solve(model, range).filter(|without| without.quality.p >= LEAST_P)?;
        // χ² cannot fall by more than all of it
        let possible = without.quality.chi2 > PERHAPS_A_PROCESS;
        let with = possible.then(|| self.solve(with_processes, range)).flatten();
        let fall = with.as_ref().map_or(0.0, |with| without.quality.chi2 - with.quality.chi2);
        let with = with.filter(|_| fall > PERHAPS_A_PROCESS).and_then(|with| self.read_out(with));
        if fall > A_PROCESS_BEYOND_DOUBT {
            return with.map(NoiseFit::with_proved_processes);
        }
        let without = self.read_out(without);
        let (mut fit, other, terms) = match fall > PROCESS {
            true => (with?, without, &[Term::White, Term::BiasInstability, Term::RateRandomWalk][..]),
            false => (without?, with, &[Term::White][..]),
        };
        if let Some(other) = other {
            terms.iter().for_each(|term| fit.widen(*term, &other));
        }
        Some(fit)
    }

    fn solve<'m>(&self, model: &'m Model, range: &Range<usize>) -> Option<Accepted<'m>> {
        let regression = Regression::new(model, &self.values, range.clone());
        let solution = regression.fit()?;
        let positive = solution.parameters.iter().filter(|parameter| **parameter > 0.0).count();
        let dof = regression.statistics().checked_sub(positive).filter(|dof| *dof > 0)?;
        let p = chi_squared::probability_above(solution.chi2, dof as f64)?;
        let tau_s = |i: usize| self.noise_model.octaves[i].1.m as f64 * self.noise_model.shape.interval_s;
        let (tau_min_s, tau_max_s) = (tau_s(range.start), tau_s(range.end - 1));
        let quality = FitQuality { tau_min_s, tau_max_s, chi2: solution.chi2, dof, p };
        Some(Accepted { model, range: range.clone(), solution, quality })
    }

    /// `None` where N lies above what the curve itself leaves.
    fn read_out(&self, accepted: Accepted<'_>) -> Option<NoiseFit> {
        let doubtless = self.white_ceiling(self.roll_off, 0.01);
        let mut fit = self.parameters(&accepted);
        let white = fit.parameter(Term::White).and_then(|white| white.lower);
        let scale = Term::White.per_second(self.noise_model.shape.interval_s);
        if white.is_some_and(|lower| (lower / scale).powi(2) > doubtless) {
            return None;
        }
        fit.lacks_free_band = self.lacks_free_band;
        if self.lacks_free_band {
            fit.not_proved(Term::White);
        }
        Some(fit)
    }

    /// No model holds: N is bounded by the curve.
    fn rejected(&self) -> NoiseFit {
        let without_values = self.noise_model.without_values(Status::ModelRejected);
        let mut rejected = NoiseFit { lacks_free_band: self.lacks_free_band, ..without_values };
        // a filter may be why
        let roll_off = self.roll_off.or(self.noise_model.may_be_filtered().then_some(RollOff::POSSIBLE));
        let ceiling = self.white_ceiling(roll_off, 1.0 - self.confidence);
        if let Some(white) = &mut rejected.parameters[Term::White as usize]
            && ceiling.is_finite()
        {
            *white = Parameter::bounded(ceiling.sqrt() * Term::White.per_second(self.noise_model.shape.interval_s));
        }
        rejected
    }

    fn parameters(&self, accepted: &Accepted<'_>) -> NoiseFit {
        let Accepted { model, range, solution, quality } = accepted;
        let regression = Regression::new(model, &self.values, range.clone());
        let interval_s = self.noise_model.shape.interval_s;
        let mut fit = self.noise_model.without_values(Status::NotObservable);
        fit.quality = Some(*quality);
        fit.processes = model
            .gauss_markov_times()
            .zip(&solution.parameters[model.terms()..])
            .filter_map(|(time, square)| Some((time?, square)).filter(|(_, square)| **square > 0.0))
            .map(|(time, square)| GaussMarkovProcess { correlation_time_s: time * interval_s, sigma: square.sqrt() })
            .collect();
        // What noise may be at most makes slopes; a measured noise is known to some degrees of freedom.
        let mut upper_bounds = solution.parameters.clone();
        let mut shown = solution.parameters.clone();
        let mut deviations = vec![0.0; upper_bounds.len()];
        for (i, deviation) in deviations.iter_mut().enumerate().skip(model.terms()) {
            *deviation = solution.standard_deviation(i).unwrap_or_default();
        }
        for (i, &term) in self.noise_model.noise.iter().enumerate() {
            let mut parameter = Parameter::of(&regression, solution, i, self.confidence);
            let by_octaves = parameter.status;
            if term == Term::RateRandomWalk
                && let Some((decided, squares)) = self.walk_of_level(accepted, parameter)
            {
                parameter = decided;
                if let Some(squares) = squares {
                    shown[..squares.len()].copy_from_slice(&squares);
                }
            }
            if by_octaves == Status::Bounded || parameter.status == Status::Bounded {
                upper_bounds[i] = parameter.upper.map_or(upper_bounds[i], |upper| upper * upper);
            } else {
                deviations[i] = solution.standard_deviation(i).unwrap_or_default();
            }
            fit.parameters[term as usize] = Some(parameter.scaled(term.per_second(interval_s)));
            for (j, &other) in self.noise_model.noise[..i].iter().enumerate() {
                if solution.parameters[i] > 0.0 && solution.parameters[j] > 0.0 {
                    fit.correlations.extend(solution.correlation(i, j).map(|correlation| (other, term, correlation)));
                }
            }
        }
        if let Some(slope) = self.slope {
            let per_parameter = model.slope_variances();
            let variance = dot(&per_parameter, &upper_bounds);
            let error: f64 = per_parameter.iter().zip(&deviations).map(|(c, deviation)| (c * deviation).powi(2)).sum();
            let parameter = ramp(slope, variance.sqrt(), 2.0 * variance * variance / error, self.confidence);
            fit.parameters[Term::RateRamp as usize] = Some(parameter.scaled(Term::RateRamp.per_second(interval_s)));
        }
        let expected = |i: usize| (self.noise_model.octaves[i].1.m, model.expected(&shown, i));
        fit.expected = range.clone().filter(|i| *i < self.noise_model.octaves.len()).map(expected).collect();
        let edf = model.edf(&shown, &upper_bounds, &self.noise_model.least_edf);
        // octaves too long to be fitted may follow the model all the same
        let (fitted, octaves) = self.known;
        let end = if range.end == fitted { octaves } else { range.end };
        fit.edf =
            self.noise_model.octaves[..end].iter().map(|(_, octave)| octave.m).zip(edf).skip(range.start).collect();
        fit
    }

    /// K, decided by the level, and the squares of white noise, flicker noise and the walk where it
    /// finds a walk that the octaves do not. `None` if the level is not known or does not
    /// decide: without a slope the record may have a gap of unknown length.
    fn walk_of_level(&self, accepted: &Accepted<'_>, by_octaves: Parameter) -> Option<(Parameter, Option<[f64; 3]>)> {
        let Accepted { model, range, solution, .. } = accepted;
        let is_alone = model.basis.len() == model.terms() && self.noise_model.noise == WALKING;
        let level = self.level.filter(|_| is_alone && self.slope.is_some())?;
        let bound = by_octaves.upper?;
        let is_short = |octave: &Octave| 2 * octave.m <= level.block_samples;
        let octaves = &self.noise_model.octaves[range.clone()];
        let short = octaves.iter().take_while(|(_, octave)| is_short(octave)).count();
        let (residuals, mut columns) = solution.rows();
        let [Some(white), Some(flicker), Some(walk)] = core::array::from_fn(|_| columns.next()) else { return None };
        let octaves = ShortOctaves {
            residuals: &residuals[..short],
            by_term: [white, flicker, walk].map(|column| &column[..short]),
            at: *solution.parameters.first_chunk()?,
        };
        let likelihood = LevelLikelihood::new(level, octaves);
        let walk = likelihood.walk()?;
        let p = Some(walk.p());
        match by_octaves.status {
            _ if walk.evidence <= PRESENT => {
                // where neither shows a walk, the octaves show how far from one they are
                let p = by_octaves.p.map(|p| p.max(walk.p()));
                Some((Parameter { p, ..by_octaves.not_proved() }, None))
            }
            Status::Estimated => Some((Parameter { p, ..by_octaves }, None)),
            _ => {
                let z = chi_squared::normal_two_sided(self.confidence)?;
                let (lower, best, upper) = likelihood.interval(&walk, z)?;
                let found = Parameter::estimated(best.sqrt(), lower.sqrt(), bound.max(upper.sqrt()));
                Some((Parameter { p, ..found }, Some(walk.squares)))
            }
        }
    }

    /// What the squared N is above with the probability `risk` at most, per sample: a variance is
    /// that of the white noise and whatever adds, so that its upper end bounds N². The upper ends
    /// of all octaves hold together (Bonferroni), with the degrees of freedom of a random walk,
    /// which has fewest. Behind an unknown filter those octaves count that average over ten times
    /// its correlation, less the most that the filter can take from them.
    fn white_ceiling(&self, roll_off: Option<RollOff>, risk: f64) -> f64 {
        let shortest = roll_off.map_or(0.0, |roll_off| 10.0 * roll_off.correlation_samples.max(1.0));
        let values = &self.values[..self.known.1];
        let octaves = self.noise_model.octaves.iter().zip(&self.noise_model.least_edf).zip(values).zip(&self.white);
        let counted: Vec<(f64, f64)> = octaves
            .filter(|((((_, octave), edf), _), _)| octave.m as f64 >= shortest && **edf >= 10.0)
            .map(|(((_, edf), value), white)| (value / white, *edf))
            .collect();
        let each = risk / counted.len() as f64;
        let bound = |(value, edf): &(f64, f64)| Some(value * edf / chi_squared::quantile(each, *edf)?);
        counted.iter().filter_map(bound).fold(f64::INFINITY, f64::min)
    }
}
