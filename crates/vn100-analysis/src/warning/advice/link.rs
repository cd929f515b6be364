//! What a link or a file brings instead of samples: no valid lines, errors of the device, stamps
//! that are no time base.

use imu_noise::Refusal;
use vn100_protocol::DeviceError;
use vn100_protocol::stream::UnsolicitedErrors;

use super::{counted, lines, reasons};
use crate::{
    remedy::{Remedy, Setting, Text},
    snapshot::{RateFrom, Snapshot},
    warning::{Warning, WarningKind},
};

/// What it is likely to suffer from; `None` where it brings samples, or too little to say.
pub(super) fn no_valid_lines(snapshot: &Snapshot) -> Option<Text> {
    // within so many bytes a whole line must have been among them, wherever the first one began
    const ENOUGH_BYTES: u64 = 3 * 122;
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    if link.samples() > 0 {
        return None;
    }
    if let Some(rejected) = link.rejected_rows.filter(|rejected| rejected.total() > 0) {
        let text = Text::from(format!(
            "{} of a CSV file and no good row among them ({}): do its columns hold what their names say? ",
            lines(tally.rejected.total()),
            reasons(&rejected)
        ));
        return Some(text.remedy(Remedy::MapColumns).then(" names others, and their units"));
    }
    // damaged lines may be measurements: they must be few beside the answers
    let damaged_bytes = tally.rejected_sentence_bytes + tally.skipped_bytes;
    let is_clean = 10 * tally.rejected.total() <= link.answers() && 10 * damaged_bytes <= tally.valid_sentence_bytes;
    if link.connects > 0 && link.answers() > 0 && tally.valid_sentences() == tally.replies && is_clean {
        let text = Text::from(format!(
            "{}, all of them answers: the sensor sends nothing by itself. `",
            lines(link.answers())
        ));
        let text = text.remedy(Remedy::Configure(Setting::Message("VNYMR")));
        return Some(text.then("` makes it send, or VNIMU for the uncompensated measurements"));
    }
    if tally.bytes() < ENOUGH_BYTES {
        return None;
    }
    if tally.packets > 0 && link.other_message.is_none_or(|name| !name.to_string().starts_with("VN")) {
        let beside =
            link.other_message.map_or_else(String::new, |name| format!(", and sentences of others, such as {name}"));
        let text = Text::from(format!(
            "{} of the sensor, which are counted and not read{beside}, and no message this program measures. Record one of its ASCII \
             messages: `",
            counted(tally.packets, "binary packet")
        ));
        return Some(text.remedy(Remedy::Configure(Setting::Message("VNYMR"))).then("` makes it send, or VNIMU"));
    }
    if let Some(name) = link.other_message {
        let text = Text::from(format!(
            "{} good, none of a message this program measures; the first is {name}. $VNWRG,06,14*59 makes the sensor send VNYMR, \
             $VNWRG,06,19*54 VNIMU; `",
            lines(tally.valid_sentences())
        ));
        return Some(text.remedy(Remedy::Configure(Setting::Message("VNYMR"))).then("` does it"));
    }
    // garbled bytes hold hardly a sentence; a program that writes text changes whole ones
    if tally.rejected.grammar > 0 && tally.rejected_sentence_bytes > tally.skipped_bytes && link.connects == 0 {
        return Some(
            Text::from(format!(
                "{} and none as the sensor sends it: their fields are not those of the message, or not numbers. The program that wrote \
                 them has cut or changed them; as a table, ",
                lines(tally.rejected.total())
            ))
            .remedy(Remedy::MapColumns)
            .then(" names their columns"),
        );
    }
    let only_unchecked = tally.rejected.unchecked > 0 && tally.rejected.unchecked == tally.rejected.total();
    (tally.valid_sentences() == 0 && !only_unchecked && link.rejected_rows.is_none()).then(|| {
        Text::from(format!(
            "{} bytes and no valid line among them: wrong baud rate? If the rate is right, the host's receiver flips bits: close and \
             reopen the port",
            tally.bytes()
        ))
    })
}

/// One for each code.
pub(super) fn unsolicited(errors: &UnsolicitedErrors) -> impl Iterator<Item = Warning> {
    errors.iter().map(|(error, count)| {
        let said = format!("the sensor said unasked, {}, {error}", counted(count, "time"));
        let (kind, text) = match error {
            DeviceError::OutputBufferOverflow => (
                WarningKind::LinkBudget,
                format!("{said}: it leaves out what finds no room, and the record lacks it. To cure it {}", error.advice()),
            ),
            _ if error.is_unsolicited() => (WarningKind::DeviceErrors, format!("{said}: {}", error.advice())),
            _ => (
                WarningKind::DeviceErrors,
                format!(
                    "{said}. That is what it says to a command, and none was sent from here: look for another program on the line, and for \
                     noise on the wire to the sensor"
                ),
            ),
        };
        Warning::new(kind, Vec::new(), text)
    })
}

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
