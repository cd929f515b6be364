//! What happens in a session, in words for the user.

use vn100_analysis::{RateChange, Snapshot};
use vn100_pipeline::{NO_MEASUREMENT_AFTER, RateEvent};

/// That the rate has changed, or is again what it was.
pub(crate) fn rate_event(event: RateEvent) -> String {
    match event {
        RateEvent::Changed(RateChange { from_hz, to_hz, .. }) => {
            format!("the rate changed from {from_hz} to {to_hz} Hz: what comes so is left out")
        }
        RateEvent::Restored(hz) => format!("lines come at {hz} Hz again"),
    }
}

/// Why a stream that still brings lines is over.
#[derive(Debug)]
pub(crate) struct Ceased {
    /// In a word, for a recording.
    pub(crate) reason: &'static str,
    /// With what cures it.
    pub(crate) told: String,
}

/// Of a stream whose measurements have ceased while others come; `None` where there never was one,
/// which the warnings say.
pub(crate) fn other_messages(name: &str, snapshot: &Snapshot) -> Option<Ceased> {
    let message = &snapshot.layout.as_ref()?.message;
    let instead =
        snapshot.link.other_message.map_or("binary packets".into(), |name| format!("other messages, such as {name}"));
    let rate = snapshot.rate_change.map_or(String::new(), |change| format!(" --set-rate {}", change.from_hz));
    let told = format!(
        "{name}: no {message} has come for {} s but {instead}{LOST}`vn100 configure {name} --set-message {message}{rate}` cures it; --save \
         keeps it",
        NO_MEASUREMENT_AFTER.as_secs()
    );
    Some(Ceased { reason: "the sensor sends another message", told })
}

/// Of a stream that ends behind a change of its rate; `None` where there was none.
pub(crate) fn other_rate(name: &str, snapshot: &Snapshot) -> Option<Ceased> {
    let RateChange { from_hz, to_hz, .. } = snapshot.rate_change?;
    let told = format!(
        "{name}: lines come at {to_hz} Hz, no longer at {from_hz}{LOST}`vn100 configure {name} --set-rate {from_hz}` cures it; --save \
         keeps it"
    );
    Some(Ceased { reason: "the sensor sends at another rate", told })
}

const LOST: &str = ", as after a restart that lost settings that were not saved; the result holds what came before. ";
