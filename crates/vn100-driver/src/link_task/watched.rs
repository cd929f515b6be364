//! A link that is up, as it is watched.

use std::time::Duration;

use tokio::time::Instant;

use super::silence::Silence;
use crate::{health::Health, link_state::Up};

/// How long after a silence began the sensor is asked again, or given up where asking is not
/// allowed.
const SILENCE: Duration = Duration::from_secs(10);

pub(super) struct Watch {
    pub(super) up: Up,
    pub(super) health: Health,
    /// When the sensor last spoke by itself.
    pub(super) heard: Instant,
    pub(super) silence: Option<Silence>,
    /// Whether it has told that it restarts, and has sent nothing since.
    pub(super) is_restarting: bool,
}

impl Watch {
    /// When the link counts as silent, or is looked at again if it is.
    pub(super) fn next_look(&self) -> Instant {
        match &self.silence {
            Some(silence) => silence.looked + SILENCE,
            None => self.heard + self.health.silent_after(),
        }
    }
}
