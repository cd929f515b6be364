//! Sums of first-order Gauss-Markov processes.

use rand_chacha::ChaCha8Rng;

use crate::normal::normal;

/// Noise that is correlated over a time: a stationary first-order Gauss-Markov process of two-sided
/// density 2σ²T/(1 + (2πfT)²).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussMarkov {
    /// T, where the covariance is σ²/e, in seconds; above zero.
    pub correlation_time_s: f64,
    /// Standard deviation σ, in the unit of the channel.
    pub sigma: f64,
}

/// The samples of a sum of processes.
#[derive(Debug, Clone)]
pub(crate) struct Processes {
    sampled: Vec<Sampled>,
    rng: ChaCha8Rng,
}

/// x' = φx + step·w, exact for a sampled process with φ = exp(-Δt/T), step² = σ²(1 - φ²).
#[derive(Debug, Clone)]
struct Sampled {
    phi: f64,
    step: f64,
    level: f64,
}

impl Processes {
    /// Processes in the stationary state, sampled every `interval_s`.
    pub(crate) fn new(processes: &[GaussMarkov], interval_s: f64, mut rng: ChaCha8Rng) -> Self {
        let sampled = |process: &GaussMarkov| {
            let intervals = interval_s / process.correlation_time_s;
            Sampled {
                phi: (-intervals).exp(),
                step: process.sigma * (-(-2.0 * intervals).exp_m1()).sqrt(),
                level: process.sigma * normal(&mut rng),
            }
        };
        Self { sampled: processes.iter().map(sampled).collect(), rng }
    }

    /// The next sample; zero without a process.
    pub(crate) fn advance(&mut self) -> f64 {
        let mut sum = 0.0;
        for process in &mut self.sampled {
            sum += process.level;
            process.level = process.phi * process.level + process.step * normal(&mut self.rng);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn processes_start_and_stay_stationary_and_correlated() {
        let seeds = 4000;
        let parts = [(0.05, 1.0), (0.5, 2.0), (20.0, 0.5)]
            .map(|(correlation_time_s, sigma)| GaussMarkov { correlation_time_s, sigma });
        let (mut first, mut later, mut product) = (0.0, 0.0, 0.0);
        for seed in 0..seeds {
            let mut processes = Processes::new(&parts, 0.025, ChaCha8Rng::seed_from_u64(seed));
            first += processes.advance().powi(2);
            let at_98 = (1..=98).map(|_| processes.advance()).last().unwrap();
            let at_99 = processes.advance();
            later += at_99 * at_99;
            product += at_98 * at_99;
        }
        let variance: f64 = parts.iter().map(|part| part.sigma.powi(2)).sum();
        let covariance: f64 =
            parts.iter().map(|part| part.sigma.powi(2) * (-0.025 / part.correlation_time_s).exp()).sum();
        // a mean of n squares of normal deviates varies by sqrt(2/n)
        let tolerance = 4.5 * (2.0 / seeds as f64).sqrt();
        for (sum, expected) in [(first, variance), (later, variance), (product, covariance)] {
            let relative = sum / seeds as f64 / expected - 1.0;
            assert!(relative.abs() < tolerance, "{relative}");
        }
    }

    #[test]
    fn none_is_silent() {
        assert_eq!(Processes::new(&[], 0.025, ChaCha8Rng::seed_from_u64(1)).advance(), 0.0);
    }
}
