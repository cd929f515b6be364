//! Why a plan of faults cannot be read.

use thiserror::Error;

use crate::device::BAUD_RATES;

/// A plan of faults has an item that is none.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FaultPlanError {
    /// There is no such fault.
    #[error(
        "`{item}` is no fault: use drop, flip, splice, stall, unplug, reboot, baud or badopen with @ and a time, or stale alone"
    )]
    Unknown {
        /// The item as written.
        item: String,
    },
    /// A fault must say when.
    #[error("`{item}` does not say when: write `@` and a time from power-up behind its name, such as `@12.5s`")]
    WhenMissing {
        /// The item as written.
        item: String,
    },
    /// A fault must say how long.
    #[error("`{item}` does not say how long: write `+` and a time behind the first, such as `@10s+2s`")]
    LengthMissing {
        /// The item as written.
        item: String,
    },
    /// This is no time.
    #[error("`{text}` in `{item}` is no time: write a number and one of ms, s, min, h, such as `12.5s`")]
    Time {
        /// The item as written.
        item: String,
        /// The part that is wrong.
        text: String,
    },
    /// This is no chance.
    #[error("`{text}` in `{item}` is no chance: write a number from 0 to 100 and `%`, such as `0.1%`")]
    Chance {
        /// The item as written.
        item: String,
        /// The part that is wrong.
        text: String,
    },
    /// What stands behind the colon is not for this fault.
    #[error(
        "`{detail}` behind the colon does not fit `{item}`: flip takes bit0 to bit7, unplug with two times takes other, baud needs one of {}",
        BAUD_RATES.map(|rate| rate.to_string()).join(", ")
    )]
    Detail {
        /// The item as written.
        item: String,
        /// The part that is wrong; empty where it is missing.
        detail: String,
    },
}
