//! What of several recordings is no property of all of them together.

use imu_noise::{Status, Term};

use super::Pool;

/// Something that is not pooled, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct NotPooled {
    /// The part of the results.
    pub what: Unpooled,
    /// The reason, in words.
    pub reason: String,
}

/// A part of the results that is not pooled. Numbers are places in [`Pool::parts`] and
/// [`Pool::channels`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unpooled {
    /// A recording that does not belong with the others.
    Recording(usize),
    /// A parameter of a channel that too few recordings estimate.
    Parameter {
        /// Place of the channel.
        channel: usize,
        /// The parameter.
        term: Term,
    },
    /// R of every channel.
    RateRamp,
    /// Mean, standard deviation, distribution.
    Statistics,
    /// The power spectral density, and its peaks.
    Spectrum,
    /// Trends, disturbances, warm-up, temperature.
    Changes,
    /// The warnings.
    Warnings,
}

/// Never pooled, whatever the recordings.
const NEVER: [(Unpooled, &str); 5] = [
    (Unpooled::RateRamp, "a ramp has a sign, and is that of one recording"),
    (Unpooled::Statistics, "they rest on the bias of one recording: the next one has another"),
    (Unpooled::Spectrum, "its peaks are what one recording was exposed to"),
    (Unpooled::Changes, "they have their time in one recording"),
    (Unpooled::Warnings, "they are about one recording"),
];

impl Pool {
    /// What the pool does not contain, and why: recordings first, then parameters, then the results
    /// that are given with each recording only.
    #[must_use]
    pub fn not_pooled(&self) -> Vec<NotPooled> {
        let recordings =
            self.parts.iter().enumerate().filter_map(|(part, of)| {
                Some(NotPooled { what: Unpooled::Recording(part), reason: of.refused.clone()? })
            });
        let parameters = self.channels.iter().enumerate().flat_map(|(channel, pooled)| {
            let excluded =
                pooled.parameters.iter().filter(|found| found.pooled.is_none() && found.common_bound.is_none());
            excluded.map(move |found| {
                let parts = || found.parts.iter().flatten();
                let estimates = parts().filter(|part| part.status == Status::Estimated).count();
                NotPooled {
                    what: Unpooled::Parameter { channel, term: found.term },
                    reason: format!(
                        "{estimates} of {} recordings estimate it, and a pool needs three",
                        parts().count()
                    ),
                }
            })
        });
        let never = NEVER.iter().filter(|_| !self.channels.is_empty());
        let never = never.map(|(what, reason)| NotPooled { what: *what, reason: (*reason).to_owned() });
        recordings.chain(parameters).chain(never).collect()
    }
}
