//! The rests and coasts for which the drift is given.

use std::time::Duration;

/// A rest, over which the mean is taken for the bias, and the coast after it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coast {
    /// Length of the rest; zero observes nothing.
    pub rest: Duration,
    /// Length of the coast; zero observes nothing.
    pub coast: Duration,
}

impl Coast {
    /// Ten seconds, a minute and ten minutes, each after a rest as long.
    pub const DEFAULTS: [Self; 3] = [Self::after_as_long(10), Self::after_as_long(60), Self::after_as_long(600)];

    const fn after_as_long(s: u64) -> Self {
        Self { rest: Duration::from_secs(s), coast: Duration::from_secs(s) }
    }
}
