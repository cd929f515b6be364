//! The one assessment of a source, refreshed as its record grows.

use std::sync::{Arc, Mutex, PoisonError};

use vn100_analysis::{Assessment, Snapshot};

/// The assessment of one source, made on the thread of the first reader that requests it, and made
/// again after the record has grown by a twentieth. An assessment takes as long as the measurement
/// of many seconds of data, and the measurement never waits for it. Clones share it.
#[derive(Debug, Clone)]
pub struct Assessor {
    confidence: f64,
    latest: Arc<Mutex<Option<Arc<Assessment>>>>,
}

impl Assessor {
    /// An assessor at the level `confidence`, 0 < p < 1.
    pub(crate) fn new(confidence: f64) -> Self {
        Self { confidence, latest: Arc::default() }
    }

    /// The assessment of this snapshot, or of an earlier one with more than nineteen twentieths of
    /// its samples. The call takes milliseconds if a new assessment is made.
    pub(crate) fn latest(&self, snapshot: &Snapshot) -> Arc<Assessment> {
        // an assessment that panicked was not kept
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let samples = snapshot.timing.samples;
        if let Some(latest) = &*latest
            && (latest.samples..latest.samples + latest.samples.div_ceil(20)).contains(&samples)
            && latest.channels.len() == snapshot.channels.len()
        {
            return Arc::clone(latest);
        }
        let assessment = Arc::new(self.exact(snapshot));
        *latest = Some(Arc::clone(&assessment));
        assessment
    }

    /// The assessment of exactly this snapshot, for a final result.
    pub fn exact(&self, snapshot: &Snapshot) -> Assessment {
        Assessment::new(snapshot, self.confidence)
    }
}
