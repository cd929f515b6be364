//! The structures that explain a record about as well, and what they say of each parameter together.
//!
//! One penalised log-likelihood compares all of them: memories of the short filter, with and without
//! Gauss-Markov processes, with a warm-up or a cycle of the mean. A limit of a parameter is where the
//! best of all has fallen by what the level allows; a term is there if the best without it is that
//! much worse.

use core::{cell::OnceCell, f64::consts::PI, ops::Range};
use schemars::JsonSchema;
use serde::Serialize;
use std::sync::Arc;

use super::{
    crossing::crossing,
    density::{Component, FLICKER, WALK, WHITE},
    scoring::{Rows, Scored, Structure},
    shapes::{MeanShape, MeanShapes},
    spectral_rows::ChannelData,
    switching,
    thresholds::{
        AS_FILTER, AS_GOOD_AS_ZERO, BENT_LINE, BESIDE_KNOWN_AVERAGING, BEYOND_FILTER, CYCLE, DEFINITE, FILTER_IN_VALUE,
        FILTERS, HOPELESS, LEAST_RISE, LIKE_A_FILTER, MOST_DEFINITE, NEGLIGIBLE, NO_DENSITY, OVERDISPERSED, PRESENT,
        PROCESSES, PROCESSES_IN_VALUE, RAMP_PRESENT, RELAXATION, STOPPED, SWITCHING_PARAMETERS,
    },
};
use crate::infer::chi_squared;

/// Standard deviations of a logarithm that is not known.
const VAGUE: f64 = 30.0;

/// Halvings of the range in which a quantile is sought.
const BISECTIONS: usize = 50;

/// Places of the components in the columns of a model.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(super) components: Vec<Component>,
    pub(super) quantization: Option<usize>,
    pub(super) processes: Range<usize>,
    pub(super) cosines: Range<usize>,
}

/// One structure, fitted.
pub(super) struct Candidate {
    /// Place among the filters.
    pub(super) filter: usize,
    pub(super) has_processes: bool,
    /// Effective number of its cosines.
    effective: f64,
    /// Penalised.
    pub(super) score: f64,
    pub(super) scored: Scored,
    pub(super) variances: Vec<f64>,
}

/// Why bias instability, random walk and ramp of an axis are no more than bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Withheld {
    /// A warm-up, a step or a cycle poses as them.
    LevelChange,
    /// What follows the temperature poses as them.
    Temperature,
    /// A cycle of the level explains the record about as well as they do.
    #[serde(rename = "perhaps-cycle")]
    MayBeCycle,
    /// A level that settles from the start on explains the record about as well as they do.
    #[serde(rename = "perhaps-warm-up")]
    MayBeWarmUp,
    /// Noise that is correlated over a small part of the record explains it about as well as they
    /// do.
    #[serde(rename = "perhaps-correlated")]
    MayBeProcess,
    /// Noise that switches between two levels explains the record about as well as they do.
    #[serde(rename = "perhaps-switching")]
    MayBeSwitching,
}

/// What the record says of one parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) value: f64,
    pub(super) lower: f64,
    pub(super) upper: f64,
    /// Standard deviations by which zero is excluded.
    pub(super) evidence: f64,
    /// Why it is not there, though it would be if nothing else were possible.
    pub(super) rival: Option<Withheld>,
}

pub(super) struct Search<'a> {
    pub(super) data: &'a ChannelData<'a>,
    layout: &'a Layout,
    shapes: Option<Arc<MeanShapes>>,
    /// The mean may have a ramp.
    pub(super) has_ramp: bool,
    /// Standard deviations of the limits.
    pub(super) z: f64,
    pub(super) rows: Rows,
    pub(super) candidates: Vec<Candidate>,
    /// Coefficients of shapes of the mean that are there beyond doubt.
    definite: Vec<Vec<f64>>,
    /// By how much squared deviations exceed the expected ones, 1 at least, and these.
    pub(super) dispersion: f64,
    pub(super) chi2: f64,
    pub(super) dof: usize,
    /// By how much two levels explain the level better than the likeliest structure does.
    switching: OnceCell<f64>,
}

/// A shape of the mean with its penalty.
struct Nuisance {
    coefficients: Vec<Vec<f64>>,
    penalty: f64,
    rival: Withheld,
}

impl<'a> Search<'a> {
    /// With no structure fitted.
    pub(super) fn new(
        data: &'a ChannelData<'a>,
        layout: &'a Layout,
        shapes: Option<Arc<MeanShapes>>,
        has_ramp: bool,
        z: f64,
    ) -> Self {
        let rows = data.rows();
        Self {
            data,
            layout,
            shapes,
            has_ramp,
            z,
            rows,
            candidates: Vec::new(),
            definite: Vec::new(),
            dispersion: 1.0,
            chi2: 0.0,
            dof: 1,
            switching: OnceCell::new(),
        }
    }

    /// With the structures of a record; `None` where none explains it.
    pub(super) fn of_record(mut self) -> Option<Self> {
        self.find_definite_shapes();
        self.searched()
    }

    /// The same in what is expected on average, which has no definite shape and does not switch.
    pub(super) fn of_expectation(self) -> Option<Self> {
        Self { switching: OnceCell::from(f64::NEG_INFINITY), ..self }.searched()
    }

    fn searched(mut self) -> Option<Self> {
        self.scan_filters();
        self.add_processes();
        self.judge();
        self.candidates.sort_by(|a, b| b.score.total_cmp(&a.score));
        (!self.candidates.is_empty()).then_some(self)
    }

    /// The relative variance of a component whose data are what is expected, without a filter or processes.
    pub(super) fn relative_variance(&self, column: usize) -> Option<f64> {
        let plain = self.candidate(0, false, None)?;
        let relative = plain.variances[column] / plain.scored.parameters[column].powi(2);
        relative.is_finite().then_some(relative)
    }

    pub(super) fn best(&self) -> &Candidate {
        &self.candidates[0]
    }

    fn ramp(&self) -> Option<&[f64]> {
        self.shapes.as_deref().filter(|_| self.has_ramp).map(|shapes| shapes.ramp.as_slice())
    }

    pub(super) fn structure<'s>(&'s self, filter: usize, has_processes: bool, more: &'s [Vec<f64>]) -> Structure<'s> {
        let Layout { quantization, processes, cosines, components } = self.layout;
        let lines = components.len()..components.len() + self.data.lines.len();
        let mut columns = vec![WHITE];
        // a few processes are as good as flicker noise: they stand in its place
        columns.extend((!has_processes).then_some(FLICKER));
        columns.push(WALK);
        columns.extend(*quantization);
        columns.extend(lines);
        columns.extend(self.short_processes().filter(|_| filter == AS_FILTER));
        if has_processes {
            // shorter ones are part of the filter
            let shortest = f64::max(BEYOND_FILTER * FILTERS[filter].memory, LIKE_A_FILTER);
            let is_longer = |column: &usize| self.process_time(*column) >= shortest;
            columns.extend(processes.clone().filter(is_longer));
        }
        let shapes = self.known_shapes().into_iter().chain(more.iter().map(Vec::as_slice)).collect();
        let cosine_variances = FILTERS[filter].variances(self.rows.mean_density);
        Structure {
            components: columns,
            cosines: cosines.start..cosines.start + cosine_variances.len(),
            cosine_variances,
            shapes,
            is_restricted: self.ramp().is_some(),
            ..Structure::default()
        }
    }

    /// Of a column; 0 of one that is none.
    fn process_time(&self, column: usize) -> f64 {
        self.layout.components[column].process_time().unwrap_or(0.0)
    }

    /// The columns of the processes that stand in the place of a filter; none if the record is too short.
    fn short_processes(&self) -> impl Iterator<Item = usize> {
        self.layout.processes.clone().filter(|column| self.process_time(*column) < LIKE_A_FILTER)
    }

    /// Shapes that no noise explains, beside whatever it is.
    fn find_definite_shapes(&mut self) {
        let Some(shapes) = self.shapes.clone() else { return };
        for _ in 0..MOST_DEFINITE {
            let rows = &self.rows;
            let Some(fitted) = rows.fit(&self.structure(0, true, &[]), None) else { return };
            let variances = &fitted.expected[rows.first_level..];
            let known = self.known_shapes();
            let find = |is_cycle| shapes.likeliest(&rows.level, variances, &known, |of| is_of(of, is_cycle), DEFINITE);
            let found = [false, true].into_iter().filter_map(find).max_by(|a, b| a.rise.total_cmp(&b.rise));
            let Some(found) = found.filter(|found| found.rise > DEFINITE) else { return };
            self.definite.extend(found.coefficients);
        }
    }

    /// The ramp, and the shapes that are there beyond doubt.
    fn known_shapes(&self) -> Vec<&[f64]> {
        self.ramp().into_iter().chain(self.definite.iter().map(Vec::as_slice)).collect()
    }

    fn scan_filters(&mut self) {
        let filters = if self.layout.cosines.is_empty() { 1 } else { AS_FILTER };
        let mut best = f64::NEG_INFINITY;
        for of_memory in FILTERS[..filters].chunk_by(|a, b| a.memory == b.memory) {
            let mut likeliest = f64::NEG_INFINITY;
            for _ in of_memory {
                let near = self.candidates.last().map(|candidate| &candidate.scored);
                let Some(candidate) = self.candidate(self.candidates.len(), false, near) else { continue };
                likeliest = likeliest.max(candidate.score);
                self.candidates.push(candidate);
            }
            best = best.max(likeliest);
            if likeliest < best - HOPELESS {
                break;
            }
        }
        if filters > 1 && self.short_processes().next().is_some() {
            let near = self.candidates.first().map(|candidate| &candidate.scored);
            let candidate = self.candidate(AS_FILTER, false, near);
            self.candidates.extend(candidate);
        }
    }

    fn candidate(&self, filter: usize, has_processes: bool, near: Option<&Scored>) -> Option<Candidate> {
        let structure = self.structure(filter, has_processes, &[]);
        let mut scored = self.rows.fit(&structure, near)?;
        let short: f64 = self.short_processes().map(|column| scored.parameters[column]).sum();
        if filter == AS_FILTER && scored.parameters[WHITE] < STOPPED * short {
            return None;
        }
        let variances = self.rows.variances(&structure, &mut scored);
        // each counts by the part of it that the record decides, and not what is known before (the trace
        // of the smoother, Hastie and Tibshirani, 1990)
        let decided = |(column, variance): (usize, &f64)| 1.0 - (variances[column] / variance).min(1.0);
        let cosines = structure.cosines.clone().zip(&structure.cosine_variances).map(decided).sum::<f64>();
        let effective = cosines + if filter == AS_FILTER { 1.0 } else { 0.0 };
        let is_filtered = filter > 0;
        let unexpected = if is_filtered && self.data.is_averaging_known { BESIDE_KNOWN_AVERAGING } else { 0.0 };
        let of_filter = if is_filtered { (FILTERS.len() as f64 - 1.0).ln() } else { 0.0 };
        let penalty = unexpected + of_filter + effective + if has_processes { PROCESSES } else { 0.0 };
        let score = scored.log_likelihood - penalty;
        Some(Candidate { filter, has_processes, score, effective, scored, variances })
    }

    /// With processes, the orders that are near to the best one.
    fn add_processes(&mut self) {
        if self.layout.processes.is_empty() {
            return;
        }
        let best = self.candidates.iter().map(|candidate| candidate.score).fold(f64::NEG_INFINITY, f64::max);
        // processes may take the place of cosines
        let takes_place = |filter: usize| [0, AS_FILTER].contains(&filter);
        let is_near = |candidate: &&Candidate| candidate.score > best - HOPELESS || takes_place(candidate.filter);
        let near = self.candidates.iter().filter(is_near);
        let added: Vec<Candidate> =
            near.filter_map(|near| self.candidate(near.filter, true, Some(&near.scored))).collect();
        self.candidates.extend(added);
    }

    /// How well the likeliest structure explains the rows of density and octaves.
    fn judge(&mut self) {
        let Some(best) = self.candidates.iter().max_by(|a, b| a.score.total_cmp(&b.score)) else { return };
        let rows = &self.rows;
        let squared = |row: usize| {
            let off = best.scored.powers[row] / best.scored.expected[row] - 1.0;
            rows.alone[row] * off * off
        };
        let is_counted = |row: &usize| *row < rows.first_level;
        let chi2: f64 = (0..rows.power.len()).filter(is_counted).map(squared).sum();
        let others = best.scored.parameters[..self.layout.cosines.start].iter();
        let others = others.chain(&best.scored.parameters[self.layout.cosines.end..]);
        let positive = others.filter(|parameter| **parameter != 0.0).count() + best.effective.round() as usize;
        let dof = rows.first_level.saturating_sub(positive).max(1);
        let limit = dof as f64 + OVERDISPERSED * (2.0 * dof as f64).sqrt();
        let dispersion = if chi2 > limit { chi2 / dof as f64 } else { 1.0 };
        (self.chi2, self.dof, self.dispersion) = (chi2, dof, dispersion);
    }

    /// Half the square of the standard deviations of a limit.
    fn drop(&self) -> f64 {
        0.5 * self.z * self.z * self.dispersion
    }

    /// N² by all structures, each with the weight of its likelihood.
    pub(super) fn white(&self) -> Found {
        let of_value = |candidate: &Candidate| {
            let is_filtered = candidate.filter > 0;
            let penalties = [(is_filtered, FILTER_IN_VALUE), (candidate.has_processes, PROCESSES_IN_VALUE)];
            candidate.score - penalties.iter().filter(|(is_in, _)| *is_in).map(|(_, penalty)| penalty).sum::<f64>()
        };
        let most = self.candidates.iter().map(of_value).fold(f64::NEG_INFINITY, f64::max);
        let weighted = self.candidates.iter().map(|candidate| {
            let weight = (of_value(candidate) - most).exp();
            (weight, weight * candidate.scored.parameters[WHITE])
        });
        let (weight, sum) = weighted.fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
        let value = sum / weight;
        let (lower, upper) = self.limits_of_white();
        // so small a part of the value, or of all noise, is as good as zero
        let least = f64::max(AS_GOOD_AS_ZERO * value, NO_DENSITY * self.rows.mean_density);
        let lower = if lower < least { 0.0 } else { lower };
        let evidence = if lower > 0.0 { f64::INFINITY } else { 0.0 };
        Found { value, lower: lower.min(value), upper: upper.max(value), evidence, rival: None }
    }

    /// Over all structures: the quantiles of their mixture, each normal in the logarithm on either side
    /// of its likeliest value.
    fn limits_of_white(&self) -> (f64, f64) {
        let best = self.best().score;
        let target = (2.0 * self.drop()).sqrt();
        let parts: Vec<Part> = self
            .candidates
            .iter()
            .map(|candidate| (((candidate.score - best) / self.dispersion).exp(), candidate))
            .filter(|(weight, _)| *weight > NEGLIGIBLE)
            .map(|(weight, candidate)| {
                let profile = Profile::new(self, candidate, WHITE);
                let value = candidate.scored.parameters[WHITE];
                if value <= 0.0 {
                    let logarithm = profile.upper(self.drop()).ln() - target;
                    return Part { weight, logarithm, below: VAGUE, above: 1.0 };
                }
                let by_covariance = profile.deviation / value;
                // where it matters, by the likelihood itself
                let is_exact = weight > 0.05 || !by_covariance.is_finite();
                let (below, above) = match is_exact {
                    true => ((value / profile.lower(self.drop())).ln(), (profile.upper(self.drop()) / value).ln()),
                    false => (target * by_covariance, target * by_covariance),
                };
                let deviation = |distance: f64| (distance / target).min(VAGUE);
                Part { weight, logarithm: value.ln(), below: deviation(below), above: deviation(above) }
            })
            .filter(|part| part.logarithm.is_finite())
            .collect();
        if parts.is_empty() {
            return (0.0, f64::INFINITY);
        }
        let total: f64 = parts.iter().map(|part| part.weight).sum();
        let risk = chi_squared::normal_above(self.z);
        let end = |sign: f64| {
            let outside = |at: f64| parts.iter().map(|part| part.weight * part.outside(at, sign)).sum::<f64>() / total;
            let ends = parts.iter().flat_map(|part| [part.logarithm, part.end(sign, self.z * 3.0)]);
            let (mut low, mut high) =
                ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), end| (low.min(end), high.max(end)));
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                if (outside(middle) > risk) == (sign > 0.0) { low = middle } else { high = middle }
            }
            (0.5 * (low + high)).exp()
        };
        (end(-1.0), end(1.0))
    }

    /// B² or K².
    pub(super) fn slow(&self, column: usize, is_beside_processes: bool) -> Found {
        let with_processes = self.likeliest(true).filter(|_| is_beside_processes);
        let mut explained: Vec<&Candidate> = self.likeliest(false).into_iter().chain(with_processes).collect();
        explained.sort_by(|a, b| b.score.total_cmp(&a.score));
        let Some(likeliest) = explained.first() else {
            return Found { value: 0.0, lower: 0.0, upper: f64::INFINITY, evidence: 0.0, rival: None };
        };
        let plain: Vec<Option<(f64, Scored)>> = explained.iter().map(|of| self.without(column, of, &[])).collect();
        let base = explained.iter().zip(&plain).find(|(of, _)| !of.has_processes);
        let without = base.and_then(|(of, plain)| Some((of.score, plain.as_ref()?)));
        let is_there =
            without.is_none_or(|(score, (bare, _))| 2.0 * (score - bare) / self.dispersion > PRESENT * PRESENT);
        // a shape of the mean instead of the term matters where the term would be there without it
        let nuisances = match without {
            Some((_, (_, without))) if is_there => self.nuisances(&self.known_shapes(), &without.expected),
            _ => Vec::new(),
        };
        let mut bare = (f64::NEG_INFINITY, None);
        for (candidate, plain) in explained.iter().zip(&plain) {
            let process = candidate.has_processes.then_some(Withheld::MayBeProcess);
            let beside = nuisances.iter().filter_map(|of| {
                let (score, _) = self.without(column, candidate, &of.coefficients)?;
                Some((score - of.penalty, Some(of.rival)))
            });
            let all = plain.iter().map(|(score, _)| (*score, process)).chain(beside);
            bare = all.fold(bare, |best, other| if other.0 > best.0 { other } else { best });
        }
        let mut evidence = (2.0 * (likeliest.score - bare.0).max(0.0) / self.dispersion).sqrt();
        let mut rival = bare.1.filter(|_| is_there && evidence <= PRESENT);
        let blocks = (self.rows.level.len() + 1) as f64;
        let switching = || self.best().score + self.switching_rise() - SWITCHING_PARAMETERS * 0.5 * blocks.ln();
        if evidence > PRESENT && switching() > likeliest.score - 0.5 * PRESENT * PRESENT {
            (evidence, rival) = (0.0, Some(Withheld::MayBeSwitching));
        }
        let value = likeliest.scored.parameters[column];
        let (lower, upper) = self.limits_of(column, &explained, evidence > PRESENT);
        Found { value, lower, upper, evidence, rival }
    }

    /// A structure without a component, with further shapes of the mean: its score, and the fit.
    fn without(&self, column: usize, of: &Candidate, more: &[Vec<f64>]) -> Option<(f64, Scored)> {
        let structure = self.structure(of.filter, of.has_processes, more);
        let known = structure.shapes.len() - more.len();
        let structure = Structure { held: Some((column, 0.0)), ..structure };
        let without = self.rows.fit(&structure, Some(&of.scored))?;
        // a shape with a multiple of unknown variance: of its likeliest one
        let significances = self.rows.significances(&structure, &without, known);
        let spread = significances.iter().map(|square| 0.5 * square.max(1.0).ln()).sum::<f64>();
        Some((of.score - (of.scored.log_likelihood - without.log_likelihood) - spread, without))
    }

    /// The limits of a component by all of these structures, the likeliest one first; the lower one is 0
    /// unless the component `is_present`.
    fn limits_of(&self, column: usize, explained: &[&Candidate], is_present: bool) -> (f64, f64) {
        let most = explained.first().map_or(f64::NEG_INFINITY, |likeliest| likeliest.score);
        let (mut lower, mut upper) = (f64::INFINITY, 0.0_f64);
        for with in explained {
            let drop = self.drop() - (most - with.score);
            if drop <= 0.0 {
                break;
            }
            let profile = Profile::new(self, with, column);
            if is_present {
                lower = lower.min(profile.lower(drop));
            }
            let value = with.scored.parameters[column];
            if value + 0.7 * (2.0 * drop).sqrt() * profile.deviation > upper || value == 0.0 && upper == 0.0 {
                upper = upper.max(profile.upper(drop));
            }
        }
        (if lower.is_finite() { lower } else { 0.0 }, upper)
    }

    /// The slope of the level, in its own unit per block; `None` if that is not in the model.
    pub(super) fn slope(&self) -> Option<Found> {
        self.ramp()?;
        let (best, rows) = (self.best(), &self.rows);
        let structure = self.structure(best.filter, best.has_processes, &[]);
        let fit = |shapes: Vec<&[f64]>| {
            rows.fit(&Structure { shapes, is_restricted: false, ..structure.clone() }, Some(&best.scored))
        };
        let definite: Vec<&[f64]> = self.definite.iter().map(Vec::as_slice).collect();
        let (with, without) = (&best.scored, fit(definite.clone())?);
        let (most, mut bare, mut rival) = (with.unrestricted(), without.log_likelihood, None);
        if 2.0 * (most - bare) > RAMP_PRESENT * RAMP_PRESENT {
            for Nuisance { coefficients, penalty, rival: name } in self.nuisances(&definite, &without.expected) {
                let instead = coefficients.iter().map(Vec::as_slice);
                let Some(instead) = fit(definite.iter().copied().chain(instead).collect()) else { continue };
                let score = instead.log_likelihood - penalty + BENT_LINE;
                if score > bare {
                    (bare, rival) = (score, Some(name));
                }
            }
        }
        let evidence = (2.0 * (most - bare).max(0.0)).sqrt();
        let value = with.multiples.first().copied()?;
        let [lower, upper] = [-1.0, 1.0].map(|sign| rows.limit_of_multiple(&structure, with, sign, self.drop()));
        let rival = rival.filter(|_| evidence <= RAMP_PRESENT);
        Some(Found { value, lower: lower?, upper: upper?, evidence, rival })
    }

    /// The likeliest structure with or without processes.
    pub(super) fn likeliest(&self, has_processes: bool) -> Option<&Candidate> {
        self.candidates.iter().find(|other| other.has_processes == has_processes)
    }

    /// See [`switching`](Self::switching): of the level without the shapes that it is known to have.
    fn switching_rise(&self) -> f64 {
        let of_record = || {
            let (rows, best) = (&self.rows, &self.best().scored);
            let rest = |(k, coefficient): (usize, &f64)| {
                let each = self.known_shapes().into_iter().zip(&best.multiples);
                coefficient - each.map(|(shape, multiple)| multiple * shape[k]).sum::<f64>()
            };
            let rest: Vec<f64> = rows.level.iter().enumerate().map(rest).collect();
            let each = rest.iter().zip(&best.expected[rows.first_level..]);
            let known: f64 = each.map(|(rest, expected)| -0.5 * (rest * rest / expected + expected.ln())).sum();
            switching::log_likelihood(&levels(&rest), self.ramp().is_some()) - (known - best.restriction)
        };
        *self.switching.get_or_init(of_record)
    }

    /// Whether processes explain the record better than the terms alone, beyond the penalty.
    pub(super) fn rise_by_processes(&self) -> f64 {
        let score = |has_processes| self.likeliest(has_processes).map_or(f64::NEG_INFINITY, |of| of.score);
        score(true) - score(false)
    }

    /// The likeliest warm-up and the likeliest cycle beside the shapes `known` in noise of these variances.
    fn nuisances(&self, known: &[&[f64]], expected: &[f64]) -> Vec<Nuisance> {
        let Some(shapes) = self.shapes.as_deref() else { return Vec::new() };
        let (level, variances) = (&self.rows.level, &expected[self.rows.first_level..]);
        let find = |(is_cycle, penalty, rival)| {
            let found = shapes.likeliest(level, variances, known, |of| is_of(of, is_cycle), LEAST_RISE)?;
            (found.rise > LEAST_RISE).then_some(Nuisance { coefficients: found.coefficients, penalty, rival })
        };
        [(false, RELAXATION, Withheld::MayBeWarmUp), (true, CYCLE, Withheld::MayBeCycle)]
            .into_iter()
            .filter_map(find)
            .collect()
    }
}

/// What one structure says of the logarithm of a component.
struct Part {
    weight: f64,
    logarithm: f64,
    /// Standard deviations on either side.
    below: f64,
    above: f64,
}

impl Part {
    /// Probability of what lies beyond, above or below.
    fn outside(&self, at: f64, sign: f64) -> f64 {
        let off = at - self.logarithm;
        chi_squared::normal_above(sign * off / if off > 0.0 { self.above } else { self.below })
    }

    fn end(&self, sign: f64, z: f64) -> f64 {
        self.logarithm + sign * z * if sign > 0.0 { self.above } else { self.below }
    }
}

/// The likelihood along one component.
struct Profile<'a> {
    rows: &'a Rows,
    structure: Structure<'a>,
    best: &'a Scored,
    column: usize,
    /// Standard deviation of the component.
    deviation: f64,
}

impl<'a> Profile<'a> {
    fn new(search: &'a Search<'_>, best: &'a Candidate, column: usize) -> Self {
        let (rows, scored) = (&search.rows, &best.scored);
        let structure = search.structure(best.filter, best.has_processes, &[]);
        let variance = match scored.parameters[column] > 0.0 {
            true => best.variances[column],
            // at zero the component alone
            false => {
                let each = rows.columns[column].iter().zip(&rows.weight).zip(&scored.expected);
                1.0 / each.map(|((x, weight), expected)| weight * (x / expected).powi(2)).sum::<f64>()
            }
        };
        Self { rows, structure, best: scored, column, deviation: variance.sqrt() }
    }

    fn fall(&self, value: f64) -> f64 {
        let structure = Structure { held: Some((self.column, value)), ..self.structure.clone() };
        let found = self.rows.fit(&structure, Some(self.best));
        found.map_or(f64::INFINITY, |found| self.best.log_likelihood - found.log_likelihood)
    }

    fn upper(&self, drop: f64) -> f64 {
        let best = self.best.parameters[self.column];
        best + crossing(drop, self.deviation, |distance| self.fall(best + distance))
    }

    fn lower(&self, drop: f64) -> f64 {
        let best = self.best.parameters[self.column];
        if best <= 0.0 || self.fall(0.0) <= drop {
            return 0.0;
        }
        best * (-crossing(drop, self.deviation / best, |distance| self.fall(best * (-distance).exp()))).exp()
    }
}

/// The level by block from its cosine coefficients, see [`LevelSeries`](crate::infer::level_series).
fn levels(coefficients: &[f64]) -> Vec<f64> {
    let blocks = coefficients.len() + 1;
    let scale = (2.0 / blocks as f64).sqrt();
    let at = |block: usize| {
        let turn = PI * (block as f64 + 0.5) / blocks as f64;
        let each = (1..).zip(coefficients).map(|(k, coefficient)| coefficient * (f64::from(k) * turn).cos());
        scale * each.sum::<f64>()
    };
    (0..blocks).map(at).collect()
}

/// Warm-up or cycle.
const fn is_of(shape: MeanShape, is_cycle: bool) -> bool {
    matches!(shape, MeanShape::Cycle(_)) == is_cycle
}
