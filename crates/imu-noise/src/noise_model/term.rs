//! The components of the noise of a rate.

/// A component of the noise of a rate, with its letter in IEEE Std 952 and its Allan variance.
///
/// Amplitudes follow the two-sided spectrum: N is what Kalibr calls noise density, and a one-sided amplitude density
/// is √2 N.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Term {
    /// Q, unit · s: 3 Q²/τ². Rounding of an angle; rounding of a rate is white.
    Quantization,
    /// N, unit/√Hz: N²/τ. Angle or velocity random walk.
    White,
    /// B, unit: (2 ln 2/π) B². Flicker noise.
    BiasInstability,
    /// K, unit/√s: K² τ/3.
    RateRandomWalk,
    /// R, unit/s, with a sign: R² τ²/2. Not random.
    RateRamp,
}

impl Term {
    /// All terms, in the order in which results are given.
    pub const ALL: [Self; 5] =
        [Self::Quantization, Self::White, Self::BiasInstability, Self::RateRandomWalk, Self::RateRamp];

    /// From an amplitude in sample intervals to one in seconds.
    pub(super) fn per_second(self, interval_s: f64) -> f64 {
        match self {
            Self::Quantization => interval_s,
            Self::White => interval_s.sqrt(),
            Self::BiasInstability => 1.0,
            Self::RateRandomWalk => 1.0 / interval_s.sqrt(),
            Self::RateRamp => 1.0 / interval_s,
        }
    }
}

/// A set of terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Terms(u8);

impl Terms {
    /// What a rate may have: white noise, bias instability, rate random walk, and a ramp.
    pub const RATE: Self = Self::of(&[Term::White, Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp]);
    /// White noise alone.
    pub const WHITE: Self = Self::of(&[Term::White]);

    /// The set of `terms`.
    #[must_use]
    pub const fn of(terms: &[Term]) -> Self {
        let mut set = 0;
        let mut i = 0;
        while i < terms.len() {
            set |= 1 << terms[i] as u8;
            i += 1;
        }
        Self(set)
    }

    /// Whether `term` is in the set.
    #[must_use]
    pub const fn contains(self, term: Term) -> bool {
        self.0 & (1 << term as u8) != 0
    }
}
