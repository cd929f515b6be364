//! Random numbers: xoshiro256++ (Blackman and Vigna, 2021), seeded by SplitMix64.

/// Independent for every record of every cell.
#[derive(Clone)]
pub(crate) struct Random {
    state: [u64; 4],
    spare: Option<f64>,
}

impl Random {
    pub(crate) fn of_record(seed: u64, cell: &str, samples: usize, number: usize) -> Self {
        let named = cell.bytes().map(u64::from).chain([samples as u64, number as u64]);
        let mut hash = named.fold(split_mix(seed), |hash, value| split_mix(hash ^ value));
        let state = std::array::from_fn(|_| {
            hash = split_mix(hash);
            hash
        });
        Self { state, spare: None }
    }

    fn next(&mut self) -> u64 {
        let [a, b, c, d] = &mut self.state;
        let result = a.wrapping_add(*d).rotate_left(23).wrapping_add(*a);
        let shifted = *b << 17;
        *c ^= *a;
        *d ^= *b;
        *b ^= *c;
        *a ^= *d;
        *c ^= shifted;
        *d = d.rotate_left(45);
        result
    }

    /// From 0 to 1, without 1.
    pub(crate) fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// 1 or -1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.uniform() < 0.5 { -1.0 } else { 1.0 }
    }

    /// By the polar method (Marsaglia and Bray, 1964).
    pub(crate) fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        loop {
            let (x, y) = (2.0 * self.uniform() - 1.0, 2.0 * self.uniform() - 1.0);
            let squared = x * x + y * y;
            if squared > 0.0 && squared < 1.0 {
                let factor = (-2.0 * squared.ln() / squared).sqrt();
                self.spare = Some(factor * y);
                return factor * x;
            }
        }
    }

    /// Laplace, standard deviation 1.
    pub(crate) fn laplace(&mut self) -> f64 {
        let exponential = -(1.0 - self.uniform()).ln();
        self.sign() * exponential / 2_f64.sqrt()
    }

    /// Student, five degrees of freedom, standard deviation 1.
    pub(crate) fn student5(&mut self) -> f64 {
        let squares: f64 = (0..5).map(|_| self.normal().powi(2)).sum();
        self.normal() * (3.0 / squares).sqrt()
    }
}

fn split_mix(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
