//! Regression on a series whose level wanders: how much likelier is it with a given shape added?

/// The mean of one block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mean {
    /// Number of the block.
    pub(super) block: u64,
    /// Mean of its samples.
    pub(super) mean: f64,
    /// Variance of the white noise of this mean, relative to that of a block with all its samples.
    pub(super) relative_variance: f64,
}

/// Variances of the random-walk step from block to block, over that of the white noise of a block mean: from white noise
/// to a random walk. Flicker is followed by those between.
const STEP_VARIANCES: [f64; 12] = [0.0, 1e-4, 4e-4, 1.6e-3, 6.4e-3, 0.026, 0.1, 0.4, 1.6, 6.4, 26.0, 400.0];

/// A shape and the evidence for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fit {
    /// Which of the shapes.
    pub(super) shape: usize,
    /// Least-squares multiple of the shape, under the noise that makes the series likeliest.
    pub(super) amplitude: f64,
    /// Twice the logarithm of the ratio of the likelihoods with and without the shape, each with the noise that suits it
    /// best.
    pub(super) evidence: f64,
    /// Standard deviation of the white noise of the mean of a full block beside the shape.
    pub(super) white_std: f64,
}

/// For each shape (its value at the place of each mean) the evidence for it in the series.
///
/// The noise is the local level model, white noise around a random walk, by its prediction errors: Harvey (1989),
/// "Forecasting, Structural Time Series Models and the Kalman Filter", 3.4 and 7.3. Empty for fewer than three means,
/// or when nothing but the shapes is in the series.
pub(super) fn fits(means: &[Mean], shapes: &[Vec<f64>]) -> Vec<Fit> {
    let mut without: Option<f64> = None;
    let mut with: Vec<Option<(f64, Fit)>> = vec![None; shapes.len()];
    for step_variance in STEP_VARIANCES {
        let errors = PredictionErrors::new(means, step_variance);
        let series: Vec<_> = errors.of(means.iter().map(|mean| mean.mean)).collect();
        let squares: f64 = series.iter().map(|error| error * error).sum();
        let Some(likelihood) = errors.likelihood(squares) else { return Vec::new() };
        without = Some(without.map_or(likelihood, |best| best.max(likelihood)));
        for (shape, best) in with.iter_mut().enumerate() {
            let (mut cross, mut own) = (0.0, 0.0);
            for (x, y) in errors.of(shapes[shape].iter().copied()).zip(&series) {
                cross += x * y;
                own += x * x;
            }
            if own <= 0.0 {
                continue;
            }
            let amplitude = cross / own;
            let rest = squares - cross * amplitude;
            let Some(likelihood) = errors.likelihood(rest) else { return Vec::new() };
            if best.is_none_or(|(highest, _)| likelihood > highest) {
                let white_std = (rest / series.len() as f64).sqrt();
                *best = Some((likelihood, Fit { shape, amplitude, evidence: 0.0, white_std }));
            }
        }
    }
    let Some(without) = without else { return Vec::new() };
    let evident = |(likelihood, fit): (f64, Fit)| Fit { evidence: 2.0 * (likelihood - without), ..fit };
    with.into_iter().flatten().map(evident).collect()
}

/// The filter that predicts each mean from those before it, for one ratio of the noises.
struct PredictionErrors {
    /// For each mean but the first: gain, and 1 over the standard deviation of its error.
    steps: Vec<(f64, f64)>,
    /// Sum of the logarithms of the variances of the errors.
    log_variances: f64,
}

impl PredictionErrors {
    fn new(means: &[Mean], step_variance: f64) -> Self {
        let mut log_variances = 0.0;
        let mut last: Option<Mean> = None;
        // Variance of the estimated level.
        let mut variance = 0.0;
        let steps = means.iter().filter_map(|mean| {
            let Some(before) = last.replace(*mean) else {
                variance = mean.relative_variance;
                return None;
            };
            variance += step_variance * (mean.block - before.block) as f64;
            let error_variance = variance + mean.relative_variance;
            let gain = variance / error_variance;
            variance *= mean.relative_variance / error_variance;
            log_variances += error_variance.ln();
            Some((gain, error_variance.sqrt().recip()))
        });
        Self { steps: steps.collect(), log_variances }
    }

    /// Errors in standard deviations, for all values but the first.
    fn of(&self, mut values: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
        let mut level = values.next().unwrap_or(0.0);
        values.zip(&self.steps).map(move |(value, (gain, scale))| {
            let error = value - level;
            level += gain * error;
            error * scale
        })
    }

    /// Logarithm of the likelihood up to a constant, with the most likely scale. `None` for a sum of squares of zero.
    fn likelihood(&self, squares: f64) -> Option<f64> {
        let n = self.steps.len() as f64;
        (n >= 2.0 && squares > 0.0).then(|| -0.5 * (n * squares.ln() + self.log_variances))
    }
}
