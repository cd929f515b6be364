//! Seeded records of white noise, flicker noise and random walk, exact in distribution.

use std::f64::consts::{PI, TAU};

/// Makes independent records of the same length.
pub(crate) struct Synthesis {
    samples: usize,
    random: Random,
    /// Square roots of the spectrum of differenced flicker noise.
    spectrum: Vec<f64>,
    twiddles: Vec<(f64, f64)>,
    spare: Option<Vec<f64>>,
}

impl Synthesis {
    pub(crate) fn new(samples: usize, seed: u64) -> Self {
        let size = (2 * samples).next_power_of_two();
        let twiddles = (0..size / 2).map(|i| (TAU * i as f64 / size as f64).sin_cos()).map(|(s, c)| (c, -s)).collect();
        let mut synthesis = Self { samples, random: Random(seed), spectrum: Vec::new(), twiddles, spare: None };
        // Autocovariance of (1 - B)^(1/2) w, embedded in a circle (Davies and Harte, 1987).
        let mut circle = vec![(0.0, 0.0); size];
        let mut covariance = 4.0 / PI;
        for k in 0..=size / 2 {
            circle[k].0 = covariance;
            circle[(size - k) % size].0 = covariance;
            covariance *= (k as f64 - 0.5) / (k as f64 + 1.5);
        }
        synthesis.transform(&mut circle);
        synthesis.spectrum = circle.iter().map(|(power, _)| (power.max(0.0) / size as f64).sqrt()).collect();
        synthesis
    }

    /// White noise with standard deviation 1, flicker noise with B = 1, a walk with steps of
    /// standard deviation 1.
    pub(crate) fn next_record(&mut self) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let white = (0..self.samples).map(|_| self.random.normal()).collect();
        let walk = cumulative((0..self.samples).map(|_| self.random.normal()));
        (white, self.flicker(), walk)
    }

    fn flicker(&mut self) -> Vec<f64> {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let random = &mut self.random;
        let mut values: Vec<_> =
            self.spectrum.iter().map(|root| (root * random.normal(), root * random.normal())).collect();
        self.transform(&mut values);
        self.spare = Some(cumulative(values[..self.samples].iter().map(|(_, imaginary)| *imaginary)));
        cumulative(values[..self.samples].iter().map(|(real, _)| *real))
    }

    /// Fast Fourier transform, decimation in frequency with the result in natural order.
    fn transform(&self, values: &mut [(f64, f64)]) {
        let size = values.len();
        let mut half = size / 2;
        while half > 0 {
            let step = size / (2 * half);
            for part in values.chunks_mut(2 * half) {
                let (low, high) = part.split_at_mut(half);
                for (i, (a, b)) in low.iter_mut().zip(high).enumerate() {
                    let (c, s) = self.twiddles[i * step];
                    let difference = (a.0 - b.0, a.1 - b.1);
                    *a = (a.0 + b.0, a.1 + b.1);
                    *b = (difference.0 * c - difference.1 * s, difference.0 * s + difference.1 * c);
                }
            }
            half /= 2;
        }
        let bits = size.ilog2();
        for i in 0..size {
            let j = i.reverse_bits() >> (usize::BITS - bits);
            if i < j {
                values.swap(i, j);
            }
        }
    }
}

fn cumulative(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let sums = values.scan(0.0, |sum, value| {
        *sum += value;
        Some(*sum)
    });
    sums.collect()
}

/// SplitMix64 (Steele, Lea and Flood, 2014) and the polar method for normal numbers.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// A uniform number from 0 to 1.
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}
