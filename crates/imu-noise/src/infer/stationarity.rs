//! Whether a record is of one piece: disturbances of a second, a warm-up, a change of level.

mod level;
mod local_level;
mod magnitudes;
mod watch;

pub use level::{LevelChange, LevelShape};
pub use watch::Disturbance;

pub(crate) use level::change;
pub(crate) use watch::Watch;
