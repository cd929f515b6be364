//! The time base against streams whose losses, clock and bunching are known.

mod clock;
mod link;
mod losses;
mod properties;
mod rate;
mod recordings;
