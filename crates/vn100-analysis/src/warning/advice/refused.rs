//! The warning for stamps that are no time base: why, what cannot be seen then, and what to do.

use imu_noise::Refusal;

use crate::{
    remedy::{Remedy, Text},
    snapshot::{RateFrom, Snapshot},
};

/// `over` when the link was lost since, and the stamps that came then are used again.
pub(super) fn refused(refusal: Refusal, over: bool, snapshot: &Snapshot) -> Text {
    let timing = &snapshot.timing;
    // the stamps of a link are those of its reads
    let is_link = snapshot.link.connects > 0;
    let advice = match refusal {
        Refusal::TooFast { .. } if is_link => ", as bytes come that were held back",
        Refusal::TooFast { .. } => "; were they stamped when a file was read? Give the rate",
        Refusal::NoTimePasses { .. } if !is_link => "; give the rate",
        Refusal::NoTimePasses { .. } | Refusal::Backwards { .. } | Refusal::OtherRate { .. } => "",
    };
    let unseen = match refusal {
        // says so itself
        Refusal::OtherRate { known_hz, .. } if known_hz == timing.rate_hz => match timing.rate_from {
            RateFrom::Option => Text::from(". ")
                .remedy(Remedy::GiveRate(None))
                .then(" gave that rate: if the stamps are right, give none"),
            RateFrom::Device => ". The sensor says that rate".into(),
            RateFrom::Arrival | RateFrom::Assumed => ". The lines before told that rate by their arrival".into(),
        },
        Refusal::OtherRate { .. } => ". The lines before told that rate by their arrival".into(),
        Refusal::Backwards { .. } | Refusal::TooFast { .. } | Refusal::NoTimePasses { .. } => {
            ". Lines lost whole cannot be seen from there on".into()
        }
    };
    let until = if over { ". That was so until the link was lost" } else { "" };
    Text::from(format!("{refusal}{advice}")).append(unseen).then(until)
}
