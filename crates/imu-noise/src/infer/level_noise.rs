//! The noise of the means of consecutive blocks, and shapes of their level, by cosine coefficients.
//!
//! The discrete cosine transform (DCT-II) of the means of a series of blocks makes white noise,
//! flicker noise and a random walk with a free level independent, the second but nearly: a noise is
//! a spectrum, a shape a vector, and a least-squares fit a sum of products.

use core::f64::consts::{PI, TAU};

use multiversion::multiversion;

use super::level_shapes::{BlockShape, Levels, Shaped, Weighted, cosine_table, dot, shapes};

/// Amplitudes of flicker noise and random walk over the white noise of a block mean, in variance.
const FLICKER: [f64; 6] = [0.0, 0.05, 0.3, 2.0, 12.0, 70.0];
const WALK: [f64; 5] = [0.0, 0.01, 0.08, 0.6, 4.0];

/// Walks over flicker noise, without white noise.
const WALK_OVER_FLICKER: [f64; 3] = [0.0, 0.05, 0.5];

/// The likeliest fit of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LevelFit {
    pub(super) shape: BlockShape,
    /// Least-squares multiple under the noise that makes the series likeliest; not negative for a
    /// cycle.
    pub(super) amplitude: f64,
    /// The noise fitted together with the shape: its place, and the variance that its spectrum is a
    /// multiple of.
    pub(super) noise: (usize, f64),
    /// Twice the log-likelihood ratio with and without the shape, each with the noise that suits it
    /// best.
    pub(super) evidence: f64,
    /// Standard deviation of a block mean, the shape removed, by the noise at the highest
    /// frequency.
    pub(super) short_std: f64,
}

/// Everything that a search in series of one length has in common.
///
/// Coefficients of even number are those of what is symmetric about the middle of the series, the
/// others those of what is antisymmetric: each is known from half of the blocks. The even ones come
/// first.
#[derive(Clone, Debug)]
pub(super) struct LevelNoise {
    blocks: usize,
    /// Cosines by block of the first half, the middle one included, and by coefficient.
    cosines: Vec<Vec<f64>>,
    /// How many coefficients are of what is symmetric.
    symmetric: usize,
    shapes: Vec<Shaped>,
    noises: Vec<NoiseSpectrum>,
}

#[derive(Clone, Debug)]
struct NoiseSpectrum {
    /// By coefficient: 1 over the variance.
    weights: Vec<f64>,
    /// Geometric mean of the variances.
    mean_variance: f64,
    /// Variance of the highest coefficient.
    last: f64,
    /// By shape: 1 over the weighted square of its coefficients; of a cycle those of the cosine and
    /// of the sine, whose product is 0; 0 if there is none.
    over_squares: Vec<[f64; 2]>,
}

/// The cosines of all blocks behind one, by coefficient: from one block to those before it what
/// lies between is added.
struct SumsBehind {
    block: usize,
    sums: Vec<f64>,
}

impl SumsBehind {
    fn new(noise: &LevelNoise) -> Self {
        Self { block: noise.blocks - 1, sums: vec![0.0; noise.blocks - 1] }
    }

    /// `block` is none behind the last one asked for.
    fn behind(&mut self, block: usize, noise: &LevelNoise) -> &[f64] {
        while self.block > block {
            self.sums.iter_mut().zip(noise.cosines_of(self.block)).for_each(|(sum, cosine)| *sum += cosine);
            self.block -= 1;
        }
        &self.sums
    }
}

impl LevelNoise {
    /// For series of so many means, 16 or more.
    pub(super) fn new(blocks: usize) -> Self {
        // cos(πk(2i + 1)/2n) repeats after a turn
        let table = cosine_table(blocks);
        let scale = (2.0 / blocks as f64).sqrt();
        let numbers: Vec<usize> = (2..blocks).step_by(2).chain((1..blocks).step_by(2)).collect();
        let cosine = |k: usize, i: usize| scale * table[2 * k * (2 * i + 1) % table.len()];
        let cosines = (0..blocks.div_ceil(2)).map(|i| numbers.iter().map(|k| cosine(*k, i)).collect()).collect();
        let symmetric = numbers.iter().filter(|k| **k % 2 == 0).count();
        let mut search = Self { blocks, cosines, symmetric, shapes: shapes(blocks, &table), noises: Vec::new() };
        let mut sums = SumsBehind::new(&search);
        let of_shape = |shaped: &Shaped| {
            let mut squares = search.of_levels(&shaped.levels, &mut sums);
            squares.iter_mut().flatten().for_each(|coefficient| *coefficient *= *coefficient);
            squares
        };
        let squares: Vec<_> = search.shapes.iter().map(of_shape).collect();
        search.noises = noise_spectra(&spectra(blocks, &numbers), &squares);
        search
    }

    pub(super) fn blocks(&self) -> usize {
        self.blocks
    }

    /// The cosine coefficients of `values`, one of each block.
    fn coefficients(&self, values: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.blocks - 1];
        let (symmetric, antisymmetric) = sums.split_at_mut(self.symmetric);
        let mirrored = values.iter().rev();
        for (place, ((cosines, value), mirror)) in self.cosines.iter().zip(values).zip(mirrored).enumerate() {
            let mirror = if 2 * place + 1 == self.blocks { 0.0 } else { *mirror };
            let (of_symmetric, of_antisymmetric) = cosines.split_at(self.symmetric);
            symmetric.iter_mut().zip(of_symmetric).for_each(|(sum, cosine)| *sum += cosine * (value + mirror));
            antisymmetric.iter_mut().zip(of_antisymmetric).for_each(|(sum, cosine)| *sum += cosine * (value - mirror));
        }
        sums
    }

    /// Of one block, by coefficient.
    fn cosines_of(&self, block: usize) -> impl Iterator<Item = f64> {
        let mirror = self.blocks - 1 - block;
        let (place, sign) = if mirror < block { (mirror, -1.0) } else { (block, 1.0) };
        let (symmetric, antisymmetric) = self.cosines[place].split_at(self.symmetric);
        symmetric.iter().copied().chain(antisymmetric.iter().map(move |cosine| sign * cosine))
    }

    /// Of a cycle those of the cosine and those of the sine.
    fn of_levels(&self, levels: &Levels, sums: &mut SumsBehind) -> [Vec<f64>; 2] {
        match levels {
            Levels::Each(values) => [self.coefficients(values), Vec::new()],
            Levels::Behind(at, part) => {
                let sums = sums.behind(*at, self);
                [sums.iter().zip(self.cosines_of(*at)).map(|(sum, cosine)| sum + part * cosine).collect(), Vec::new()]
            }
            Levels::Cycle(cosine, sine) => [(cosine, 1.0), (sine, -1.0)].map(|(half, sign)| {
                let mirrored = half.iter().take(self.blocks / 2).rev().map(|value| sign * value);
                self.coefficients(&half.iter().copied().chain(mirrored).collect::<Vec<_>>())
            }),
        }
    }

    /// By block, what the coefficients `weighted` are.
    #[inline(always)]
    fn weigh(&self, weighted: &[f64], by_block: &mut Weighted) {
        let (of_symmetric, of_antisymmetric) = weighted.split_at(self.symmetric);
        by_block.each.resize(self.blocks, 0.0);
        by_block.symmetric.clear();
        by_block.antisymmetric.clear();
        for (place, cosines) in self.cosines.iter().enumerate() {
            let (symmetric, antisymmetric) = cosines.split_at(self.symmetric);
            let (symmetric, antisymmetric) = (dot(symmetric, of_symmetric), dot(antisymmetric, of_antisymmetric));
            let mirror = self.blocks - 1 - place;
            by_block.each[mirror] = symmetric - antisymmetric;
            by_block.each[place] = symmetric + antisymmetric;
            let both = if mirror == place { 1.0 } else { 2.0 };
            by_block.symmetric.push(both * symmetric);
            by_block.antisymmetric.push(both * antisymmetric);
        }
        by_block.behind.clone_from(&by_block.each);
        let mut sum = 0.0;
        for value in by_block.behind.iter_mut().rev() {
            sum += *value;
            *value = sum;
        }
    }

    /// For every shape its likeliest fit; nothing if a shape is all there is.
    pub(super) fn fits(&self, means: &[f64]) -> Vec<LevelFit> {
        let series = self.coefficients(means);
        let count = series.len() as f64;
        let (without, best) = likeliest(self, &series);
        let fit = |(shaped, (with, place, [a, b], residual)): (&Shaped, Likeliest)| {
            let noise: &NoiseSpectrum = self.noises.get(place)?;
            let variance = residual / count;
            (with > 0.0 && without.is_finite() && variance > 0.0).then(|| LevelFit {
                shape: shaped.shape,
                amplitude: if matches!(shaped.shape, BlockShape::Cycle(_)) { a.hypot(b) } else { a },
                noise: (place, variance),
                evidence: count * (without / with).ln(),
                short_std: (variance * noise.last).sqrt(),
            })
        };
        self.shapes.iter().zip(best).filter_map(fit).collect()
    }
}

impl LevelNoise {
    /// The multiple of a shape in the noise of `fit` at which the evidence, were every coefficient
    /// as large as is expected of it, reaches `evidence`; `None` for a shape that is not examined.
    pub(super) fn detectable(&self, shape: BlockShape, fit: &LevelFit, evidence: f64) -> Option<f64> {
        let shaped = self.shapes.iter().find(|shaped| shaped.shape == shape)?;
        let (noise, variance) = (self.noises.get(fit.noise.0)?, fit.noise.1);
        let [coefficients, _] = self.of_levels(&shaped.levels, &mut SumsBehind::new(self));
        let count = coefficients.len() as f64;
        let expected = |amplitude: f64| {
            let power = |(weight, x): (&f64, &f64)| variance / weight + (amplitude * x).powi(2);
            let powers: Vec<f64> = noise.weights.iter().zip(&coefficients).map(power).collect();
            let residuals = self.noises.iter().map(|other| dot(&other.weights, &powers) * other.mean_variance);
            let without = residuals.fold(f64::INFINITY, f64::min);
            count * (without / (count * variance * noise.mean_variance)).ln()
        };
        let mut low = 0.0;
        let mut high = fit.short_std;
        while expected(high) < evidence {
            (low, high) = (high, 2.0 * high);
            if !high.is_finite() {
                return None;
            }
        }
        for _ in 0..10 {
            let middle = f64::midpoint(low, high);
            if expected(middle) < evidence { low = middle } else { high = middle }
        }
        Some(high)
    }
}

/// The residual of a shape times the mean variance in the noise that makes that smallest, the place
/// of this noise, the multiples of the shape, and the residual.
type Likeliest = (f64, usize, [f64; 2], f64);

/// The residual of `series` without a shape, likewise, and that of every shape. The profile
/// likelihood is a falling function of it.
#[multiversion(targets("x86_64+avx2"))]
fn likeliest(search: &LevelNoise, series: &[f64]) -> (f64, Vec<Likeliest>) {
    let mut without = f64::INFINITY;
    let mut best = vec![(f64::INFINITY, 0, [0.0; 2], 0.0); search.shapes.len()];
    let mut weighted = vec![0.0; series.len()];
    let mut by_block = Weighted::default();
    for (place, noise) in search.noises.iter().enumerate() {
        for ((weighted, value), weight) in weighted.iter_mut().zip(series).zip(&noise.weights) {
            *weighted = value * weight;
        }
        let residual = dot(&weighted, series);
        without = without.min(residual * noise.mean_variance);
        search.weigh(&weighted, &mut by_block);
        for ((shaped, [first, second]), best) in search.shapes.iter().zip(&noise.over_squares).zip(&mut best) {
            let [a, b] = shaped.products(&by_block);
            let multiples = [a * first, b * second];
            let gain = a * multiples[0] + b * multiples[1];
            let with = (residual - gain) * noise.mean_variance;
            if with < best.0 {
                *best = (with, place, multiples, residual - gain);
            }
        }
    }
    (without, best)
}

/// `shapes`: the squared coefficients of each; of a cycle of both.
#[multiversion(targets("x86_64+avx2"))]
fn noise_spectra(spectra: &[Vec<f64>], shapes: &[[Vec<f64>; 2]]) -> Vec<NoiseSpectrum> {
    let of = |variances: &Vec<f64>| {
        let weights: Vec<f64> = variances.iter().map(|variance| 1.0 / variance).collect();
        let over = |squares: &Vec<f64>| if squares.is_empty() { 0.0 } else { 1.0 / dot(&weights, squares) };
        NoiseSpectrum {
            over_squares: shapes.iter().map(|[first, second]| [over(first), over(second)]).collect(),
            mean_variance: (variances.iter().map(|variance| variance.ln()).sum::<f64>() / variances.len() as f64).exp(),
            last: variances.iter().copied().fold(f64::INFINITY, f64::min),
            weights,
        }
    };
    spectra.iter().map(of).collect()
}

/// Variance of the coefficient `k` of block means of flicker noise, folded at half a cycle per
/// block.
pub(super) fn flicker_variance(k: usize, blocks: usize) -> f64 {
    let omega = PI * k as f64 / blocks as f64;
    let folded = |m: i32| (TAU * f64::from(m) + omega).abs().powi(-3);
    4.0 * (omega / 2.0).sin().powi(2) * (-20..=20).map(folded).sum::<f64>()
}

/// The same of a random walk.
pub(super) fn walk_variance(k: usize, blocks: usize) -> f64 {
    let square = (PI * k as f64 / (2 * blocks) as f64).sin().powi(2);
    (3.0 - 2.0 * square) / (12.0 * square)
}

/// Variances of the coefficients of these `numbers`, of every noise.
fn spectra(blocks: usize, numbers: &[usize]) -> Vec<Vec<f64>> {
    let flicker: Vec<f64> = numbers.iter().map(|k| flicker_variance(*k, blocks)).collect();
    let walk: Vec<f64> = numbers.iter().map(|k| walk_variance(*k, blocks)).collect();
    let mixed = |white: f64, f: f64, w: f64| {
        flicker.iter().zip(&walk).map(|(flicker, walk)| white + f * flicker + w * walk).collect()
    };
    let with_white = FLICKER.iter().flat_map(|f| WALK.iter().map(|w| mixed(1.0, *f, *w)));
    let without = WALK_OVER_FLICKER.iter().map(|w| mixed(0.0, 1.0, *w)).chain([walk.clone()]);
    with_white.chain(without).collect()
}

#[cfg(test)]
mod tests {
    use super::{super::level_shapes::MOST_PER_BLOCK, *};

    /// White noise, by a generator of congruences.
    fn noise(blocks: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..blocks).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect()
    }

    fn best(fits: &[LevelFit], is_meant: impl Fn(BlockShape) -> bool) -> LevelFit {
        let meant = fits.iter().filter(|fit| is_meant(fit.shape));
        *meant.max_by(|a, b| a.evidence.total_cmp(&b.evidence)).unwrap()
    }

    #[test]
    fn the_fit_is_that_of_the_whole_covariance_matrix() {
        // White noise with a walk of 0.6: the coefficients are independent, so that generalised least squares
        // with the matrix of the means gives the same.
        let blocks = 20;
        let search = LevelNoise::new(blocks);
        let numbers: Vec<usize> = (2..blocks).step_by(2).chain((1..blocks).step_by(2)).collect();
        let variances = &spectra(blocks, &numbers)[3];
        let one =
            |at: usize| search.coefficients(&(0..blocks).map(|i| f64::from(u8::from(i == at))).collect::<Vec<_>>());
        let covariance = |i: usize, j: usize| -> f64 {
            one(i).iter().zip(one(j)).zip(variances).map(|((a, b), variance)| a * b * variance).sum()
        };
        // a walk through the middles of the blocks has a step variance of 0.6, and differences 2/3 and 1/6 of it
        let difference = |i: usize, j: usize| {
            covariance(i + 1, j + 1) - covariance(i + 1, j) - covariance(i, j + 1) + covariance(i, j)
        };
        assert!((difference(9, 9) - (2.0 + 0.6 * 2.0 / 3.0)).abs() < 0.02, "{}", difference(9, 9));
        assert!((difference(9, 10) - (-1.0 + 0.6 / 6.0)).abs() < 0.02, "{}", difference(9, 10));
    }

    #[test]
    fn cycles_are_sines_about_the_middle() {
        for blocks in [16, 17, 70] {
            let mut found = 0;
            for Shaped { shape, levels } in shapes(blocks, &cosine_table(blocks)) {
                let (BlockShape::Cycle(frequency), Levels::Cycle(cosine, sine)) = (shape, levels) else { continue };
                for (i, (cosine, sine)) in cosine.iter().zip(&sine).enumerate() {
                    let angle = TAU * frequency * (i as f64 - 0.5 * (blocks - 1) as f64);
                    assert!((cosine - angle.cos()).abs() < 1e-12 && (sine - angle.sin()).abs() < 1e-12, "{blocks} {i}");
                }
                found += 1;
            }
            let most = (2.0 * MOST_PER_BLOCK * blocks as f64) as usize;
            // in halves from 1 on, and four quarters between them
            assert_eq!(found, most - 1 + 4, "{blocks}");
        }
    }

    #[test]
    fn steps_have_the_coefficients_of_their_blocks() {
        for blocks in [16, 17, 70] {
            let search = LevelNoise::new(blocks);
            for (at, part) in [(4, 1.0), (4, 0.5), (blocks - 4, 0.5), (blocks - 4, 1.0)] {
                let level = |block: usize| if block == at { part } else { f64::from(u8::from(block > at)) };
                let by_block = search.coefficients(&(0..blocks).map(level).collect::<Vec<_>>());
                let [step, _] = search.of_levels(&Levels::Behind(at, part), &mut SumsBehind::new(&search));
                assert!(step.iter().zip(&by_block).all(|(a, b)| (a - b).abs() < 1e-12), "{blocks} {at} {part}");
            }
        }
    }

    #[test]
    fn shapes_are_found_where_and_as_large_as_they_are() {
        let blocks = 70;
        let search = LevelNoise::new(blocks);
        let with = |seed: u64, added: &dyn Fn(f64) -> f64| -> Vec<LevelFit> {
            let means: Vec<f64> = noise(blocks, seed).iter().zip(0..).map(|(x, i)| x + added(f64::from(i))).collect();
            search.fits(&means)
        };
        let step = best(&with(1, &|i| if i < 30.0 { 0.0 } else { -5.0 }), |shape| matches!(shape, BlockShape::Step(_)));
        assert!(step.shape == BlockShape::Step(30.0) && (step.amplitude + 5.0).abs() < 1.0, "{step:?}");
        let cycle =
            best(&with(2, &|i| 3.0 * (TAU * 0.1707 * i + 1.0).sin()), |shape| matches!(shape, BlockShape::Cycle(_)));
        let BlockShape::Cycle(frequency) = cycle.shape else { panic!("{cycle:?}") };
        assert!((frequency - 0.1707).abs() < 0.004 && (cycle.amplitude - 3.0).abs() < 0.8, "{cycle:?}");
        let warm_up =
            best(&with(3, &|i| 20.0 * (-(i + 0.5) / 8.0).exp()), |shape| matches!(shape, BlockShape::Relaxation(_)));
        assert!(warm_up.shape == BlockShape::Relaxation(8.0) && (warm_up.amplitude - 20.0).abs() < 3.0, "{warm_up:?}");
        for fit in [step, cycle, warm_up] {
            assert!(fit.evidence > 40.0 && (fit.short_std - 1.0).abs() < 0.3, "{fit:?}");
        }
    }

    #[test]
    fn noise_alone_is_no_evidence_and_no_noise_says_nothing() {
        let search = LevelNoise::new(24);
        for seed in 0..20 {
            let fits = search.fits(&noise(24, seed));
            assert!(fits.iter().all(|fit| fit.evidence < 20.0), "{seed}");
        }
        assert_eq!(search.fits(&[0.0; 24]).len(), 0);
    }
}
