//! How the octaves of a record vary together, by pairs of noise components.

use std::{array, collections::HashMap, sync::Arc};

use crate::accumulate::record::{Estimator, Octave, RecordShape};
use crate::infer::confidence::{correlations, variance_inflation};
use crate::infer::power_law::{difference_autocovariance, difference_pairs};

/// Generalised covariance of the phase, at an integer lag.
pub(super) type Phase<'a> = &'a dyn Fn(f64) -> f64;

/// The same of many lags, in their place: as quick as the formula allows.
pub(super) type Phases<'a> = &'a dyn Fn(&mut [f64]);

pub(super) struct Component<'a> {
    pub(super) phase: Phase<'a>,
    pub(super) phases: Phases<'a>,
    /// Uncorrelated between samples of the phase: differences are alike only where their edges
    /// meet.
    pub(super) meets_at_edges: bool,
    /// Samples beyond which correlations depend on the ratio of averaging factors only.
    pub(super) scale: u64,
}

/// A formula of one lag for many of them.
pub(super) fn of_each(phase: impl Fn(f64) -> f64) -> impl Fn(&mut [f64]) {
    move |lags| lags.iter_mut().for_each(|lag| *lag = phase(*lag))
}

/// Where the sampled forms have become those of continuous noise as far as correlations go (0.4 %).
const CONTINUOUS_LEVEL: u32 = 4;

/// For octaves a and b and components p and q: the mean over all pairs of windows of κ_p κ_q, with
/// κ the correlation of the two differences.
///
/// Covariances of mean squares are twice the mean of squared covariances (Isserlis, 1918), and
/// those of independent components add: cov(V_a, V_b) = 2 Σ_pq √(V_pa V_pb V_qa V_qb) · mean(κ_p
/// κ_q), where V_pa is what component p contributes to octave a.
#[derive(Clone, Debug)]
pub(super) struct JointMeans {
    /// By p and q, and by a and b <= a.
    means: [[Vec<f64>; MOST_COMPONENTS]; MOST_COMPONENTS],
    coherences: Coherences,
}

/// Components at most: quantisation, white noise, flicker noise, random walk.
pub(super) const MOST_COMPONENTS: usize = 4;

/// By p and q, symmetric; 0 for components that there are not.
type Means = [[f64; MOST_COMPONENTS]; MOST_COMPONENTS];

/// Between short octaves of this level and octaves by this many levels longer. They do not depend
/// on the length of the record.
type Coherences = HashMap<(u32, u32), Arc<Coherence>>;

impl JointMeans {
    /// `known`: of the same components, estimator and deviation.
    pub(super) fn new(octaves: &[Octave], shape: &RecordShape, noise: &[Component<'_>], known: Option<&Self>) -> Self {
        let scale = noise.iter().map(|component| component.scale).max().unwrap_or(1);
        let last_own = CONTINUOUS_LEVEL.saturating_add(scale.max(1).ilog2());
        let mut coherences = known.map(|known| known.coherences.clone()).unwrap_or_default();
        let mut means: Vec<Means> = Vec::with_capacity(octaves.len() * (octaves.len() + 1) / 2);
        // Cross terms hardly depend on the stride: sparse windows represent all overlaps.
        let sparse = match shape.estimator {
            Estimator::Full => RecordShape { estimator: Estimator::Strided, ..*shape },
            _ => *shape,
        };
        let mut rho: Vec<Vec<f64>> = Vec::new();
        for (a, long) in octaves.iter().enumerate() {
            for short in &octaves[..a] {
                // octaves that all look the same, by the ratio of their lengths
                let level = short.m.ilog2().min(last_own);
                let ratio = long.m.ilog2() - short.m.ilog2();
                let new = || Arc::new(Coherence::new(&sparse, 1 << level, 1 << (level + ratio), noise));
                let coherence = coherences.entry((level, ratio)).or_insert_with(new);
                let stride_ratio = sparse.stride(long.m) / sparse.stride(short.m);
                let pairs = Pairs { short: sparse.windows(short.m), long: sparse.windows(long.m), stride_ratio };
                let gaps = (shape.share_of_windows(long) * shape.share_of_windows(short)).sqrt();
                means.push(coherence.means(&pairs).map(|row| row.map(|mean| mean / gaps)));
            }
            // All overlaps are the one grid that does not scale with the octave.
            if long.m.ilog2() <= last_own || shape.estimator == Estimator::Full || rho.is_empty() {
                rho = noise.iter().map(|component| correlations(shape, long.m, component.phase)).collect();
            }
            means.push(Self::of_one_octave(long, shape, &rho));
        }
        let of = |p: usize, q: usize| means.iter().map(|means| means[p][q]).collect();
        Self { means: array::from_fn(|p| array::from_fn(|q| of(p, q))), coherences }
    }

    /// Of the first `N` components, for octave `a` and every one up to it.
    pub(super) fn up_to<const N: usize>(&self, a: usize) -> [[&[f64]; N]; N] {
        array::from_fn(|p| array::from_fn(|q| &self.means[p][q][a * (a + 1) / 2..][..=a]))
    }

    fn of_one_octave(octave: &Octave, shape: &RecordShape, rho: &[Vec<f64>]) -> Means {
        let windows = shape.windows(octave.m) as f64 * shape.share_of_windows(octave);
        let mut means = Means::default();
        for p in 0..rho.len() {
            for q in 0..=p {
                means[p][q] = variance_inflation(shape, octave.m, &rho[p], &rho[q]) / windows;
                means[q][p] = means[p][q];
            }
        }
        means
    }
}

/// Windows of two octaves at strides s and `stride_ratio` · s.
struct Pairs {
    short: u64,
    long: u64,
    stride_ratio: u64,
}

impl Pairs {
    /// Pairs of windows where the short one starts less than `lag` strides s after the long one.
    fn before(&self, lag: i64) -> f64 {
        // Σ over long windows j of clamp(lag + ratio · j, 0, short); counts are below 2^63
        let (short, long, ratio) = (self.short as i64, self.long as i64, self.stride_ratio as i64);
        let first = (-lag.div_euclid(ratio)).clamp(0, long);
        let full = (-(lag - short).div_euclid(ratio)).clamp(first, long);
        let (first, full, lag) = (first as f64, full as f64, lag as f64);
        let partial = full - first;
        let rest = self.long as f64 - full;
        partial * lag + self.stride_ratio as f64 * partial * (first + full - 1.0) / 2.0 + self.short as f64 * rest
    }
}

/// Correlations of the differences of two octaves at selected distances of their starts.
#[derive(Debug)]
struct Coherence {
    components: usize,
    /// In strides of the short octave, ascending: each set of correlations is for distances up to
    /// the next.
    bounds: Vec<i64>,
    /// By distance and component.
    correlations: Vec<f64>,
}

impl Coherence {
    fn new(shape: &RecordShape, short: u64, long: u64, noise: &[Component<'_>]) -> Self {
        let (short_f, long_f) = (short as f64, long as f64);
        let stride = shape.stride(short);
        let dense = noise.iter().any(|component| component.meets_at_edges);
        let order = shape.deviation.order() as i64;
        let lags = distances(order, (short / stride) as i64, (long / stride) as i64, dense);
        let between = lags.windows(2).map(|pair| (pair[0] + pair[1] + 1).div_euclid(2));
        let (first, end) = (lags.first().copied(), lags.last().map(|lag| lag + 1));
        let bounds = first.into_iter().chain(between).chain(end).collect();
        let variance =
            |component: &Component<'_>, m| difference_autocovariance(shape.deviation, m, 0.0, component.phase);
        let norms: Vec<_> =
            noise.iter().map(|component| (variance(component, short_f) * variance(component, long_f)).sqrt()).collect();
        let pairs = difference_pairs(shape.deviation, short_f, long_f);
        let mut at = Vec::with_capacity(lags.len() * pairs.len());
        for lag in &lags {
            let lag = (lag * stride as i64) as f64;
            at.extend(pairs.iter().map(|(apart, _)| lag + apart));
        }
        let mut correlations = vec![0.0; lags.len() * noise.len()];
        let mut phases = Vec::new();
        for (p, (component, norm)) in noise.iter().zip(&norms).enumerate() {
            phases.clone_from(&at);
            (component.phases)(&mut phases);
            let of_component = correlations[p..].iter_mut().step_by(noise.len());
            for (correlation, phases) in of_component.zip(phases.chunks_exact(pairs.len())) {
                let covariance: f64 = phases.iter().zip(&pairs).map(|(phase, (_, weight))| weight * phase).sum();
                *correlation = covariance / norm;
            }
        }
        Self { components: noise.len(), bounds, correlations }
    }

    fn means(&self, pairs: &Pairs) -> Means {
        let all = pairs.short as f64 * pairs.long as f64;
        let mut means = Means::default();
        let mut bounds = self.bounds.iter().map(|bound| pairs.before(*bound));
        let mut before = bounds.next().unwrap_or_default();
        for (bound, rho) in bounds.zip(self.correlations.chunks(self.components)) {
            let weight = (bound - before) / all;
            before = bound;
            if weight == 0.0 {
                continue;
            }
            for (means, rho_p) in means.iter_mut().zip(rho) {
                means.iter_mut().zip(rho).for_each(|(mean, rho_q)| *mean += weight * rho_p * rho_q);
            }
        }
        means
    }
}

/// Distances of starts, in strides of the short octave: close together where an edge of a long
/// block passes through a short window (`dense`: every one), wider away from the edges, out to
/// where flicker noise is forgotten.
fn distances(order: i64, short: i64, long: i64, dense: bool) -> Vec<i64> {
    const TAIL: i64 = 4;
    let fine = if dense || long / short <= 2 { 1 } else { (short / 4).max(1) };
    let (first, last) = (-order * short - TAIL * long, (order + TAIL) * long);
    let mut lags = Vec::new();
    let mut lag = first;
    while lag <= last {
        lags.push(lag);
        let to_edges = (0..=order).map(|edge| edge * long);
        // Distance to the nearest stretch [edge - order · short, edge], and to the next one ahead.
        let distance =
            to_edges.clone().map(|edge| (edge - order * short - lag).max(lag - edge).max(0)).min().unwrap_or(0);
        let ahead =
            to_edges.map(|edge| edge - order * short - lag).filter(|ahead| *ahead > 0).min().unwrap_or(i64::MAX);
        lag += (distance / 4).max(fine).min(ahead);
    }
    lags
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::accumulate::record::Deviation;
    use crate::infer::power_law::{PowerLaw, difference_covariance};

    /// The mean over every pair of windows, one by one.
    fn by_definition(shape: &RecordShape, a: u64, b: u64, p: PowerLaw, q: PowerLaw) -> f64 {
        let correlation = |law: PowerLaw, lag: i64| {
            let phase = |lag| law.phase_covariance(lag);
            let variance = |m| difference_autocovariance(shape.deviation, m as f64, 0.0, phase);
            let covariance = difference_covariance(shape.deviation, a as f64, b as f64, lag as f64, phase);
            covariance / (variance(a) * variance(b)).sqrt()
        };
        let starts = |m| (0..shape.windows(m)).map(move |i| (i * shape.stride(m)) as i64);
        let mut pairs_at_lag = BTreeMap::new();
        for i in starts(a) {
            starts(b).for_each(|j| *pairs_at_lag.entry(i - j).or_insert(0.0) += 1.0);
        }
        let sum: f64 = pairs_at_lag.iter().map(|(&lag, pairs)| pairs * correlation(p, lag) * correlation(q, lag)).sum();
        sum / (shape.windows(a) * shape.windows(b)) as f64
    }

    #[test]
    fn means_are_those_over_every_pair_of_windows() {
        let laws = [PowerLaw::White, PowerLaw::Flicker, PowerLaw::RandomWalk];
        let phases = laws.map(|law| move |lag: f64| law.phase_covariance(lag));
        let slices = phases.map(of_each);
        let noise: Vec<Component<'_>> = (phases.iter().zip(&slices))
            .map(|(phase, phases)| Component { phase, phases, meets_at_edges: false, scale: 1 })
            .collect();
        for (samples, estimator, deviation) in [
            (70, Estimator::Strided, Deviation::Allan),
            (260, Estimator::Strided, Deviation::Allan),
            (150, Estimator::Strided, Deviation::Hadamard),
            (150, Estimator::Plain, Deviation::Allan),
            (150, Estimator::Full, Deviation::Allan),
        ] {
            let shape = RecordShape { samples, interval_s: 1.0, estimator, deviation };
            let octaves: Vec<Octave> = (0..12)
                .map(|k| Octave::whole(1 << k, shape.windows(1 << k)))
                .filter(|octave| octave.terms > 0)
                .collect();
            let joint = JointMeans::new(&octaves, &shape, &noise, None);
            for a in 0..octaves.len() {
                for b in 0..=a {
                    for p in 0..laws.len() {
                        for q in 0..laws.len() {
                            let found = joint.up_to::<3>(a)[p][q][b];
                            let expected = by_definition(&shape, octaves[a].m, octaves[b].m, laws[p], laws[q]);
                            let scale = (joint.up_to::<3>(a)[p][p][a] * joint.up_to::<3>(b)[q][q][b]).sqrt();
                            let error = (found - expected).abs() / scale;
                            assert!(error < 0.02, "{shape:?} {a} {b} {p} {q}: {found}, not {expected}, {error}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn octaves_of_a_long_record_are_hardly_correlated_when_far_apart() {
        let flicker = |lag: f64| PowerLaw::Flicker.phase_covariance(lag);
        let noise = [Component { phase: &flicker, phases: &of_each(flicker), meets_at_edges: false, scale: 1 }];
        let shape = RecordShape {
            samples: 1 << 30,
            interval_s: 1.0,
            estimator: Estimator::Strided,
            deviation: Deviation::Allan,
        };
        let octaves: Vec<Octave> = (0..24).map(|k| Octave::whole(1 << k, shape.windows(1 << k))).collect();
        let joint = JointMeans::new(&octaves, &shape, &noise, None);
        let mean = |a, b| joint.up_to::<1>(a)[0][0][b];
        let correlation = |a, b| mean(a, b) / (mean(a, a) * mean(b, b)).sqrt();
        for a in 1..octaves.len() {
            assert!((0.5..0.85).contains(&correlation(a, a - 1)), "{a}: {}", correlation(a, a - 1));
        }
        assert!(correlation(20, 4).abs() < 0.01, "{}", correlation(20, 4));
    }
}
