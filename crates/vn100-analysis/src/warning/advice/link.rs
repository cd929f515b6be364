//! What a link or a file delivers instead of samples: no valid sentences, errors of the device,
//! stamps that are no time base.

use imu_noise::timebase::Refusal;
use vn100_protocol::DeviceError;
use vn100_protocol::stream::UnsolicitedErrors;

use super::{counted, lines, reasons};
use crate::{
    remedy::{Remedy, Setting, Text},
    snapshot::{RateFrom, Snapshot},
    warning::{Warning, WarningKind},
};

/// What was found where no sample arrives, and the likely cause; `None` where samples arrive, or
/// too few bytes have arrived to say.
pub(super) fn no_valid_lines(snapshot: &Snapshot) -> Option<(String, Text)> {
    // this many bytes contain a whole sentence, wherever the first one began
    const ENOUGH_BYTES: u64 = 3 * 122;
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    if link.samples() > 0 {
        return None;
    }
    if let Some(rejected) = link.rejected_rows.filter(|rejected| rejected.total() > 0) {
        let headline = format!("all {} of a CSV file rejected ({})", lines(tally.rejected.total()), reasons(&rejected));
        let details = Text::from("If its columns do not hold what their names say, ")
            .remedy(Remedy::MapColumns(None))
            .then(" names others, and their units.");
        return Some((headline, details));
    }
    // damaged sentences may be measurements: they must be few in comparison with the replies
    let damaged_bytes = tally.rejected_sentence_bytes + tally.skipped_bytes;
    let is_clean = 10 * tally.rejected.total() <= link.answers() && 10 * damaged_bytes <= tally.valid_sentence_bytes;
    let has_replies_alone = link.answers() > 0 && tally.valid_sentences() == tally.replies && tally.packets == 0;
    if link.connects > 0 && has_replies_alone && is_clean {
        let replies = lines(link.answers());
        let switch_on = |text: &str| Text::from(text).remedy(Remedy::Configure(Setting::Message("VNYMR")));
        // register 6 holds the output of the port by which it was read
        let set = snapshot.registers.get(&6).filter(|output| !output.is_empty() && !output.starts_with('0'));
        let (headline, details) = match set {
            Some(output) => (
                format!("{replies}, all of them replies, though output {output} is set (register 6)"),
                switch_on("The output is paused, as by a program that was stopped in mid-command, or nothing of it arrives. `")
                    .then("` resumes it."),
            ),
            None => (
                format!("{replies}, all of them replies: asynchronous output is off"),
                switch_on("Switch it on with `").then("`, or VNIMU for the uncompensated measurements."),
            ),
        };
        return Some((headline, details));
    }
    if tally.bytes() < ENOUGH_BYTES {
        return None;
    }
    if tally.packets > 0 && link.other_message.is_none_or(|name| !name.to_string().starts_with("VN")) {
        let impossible = tally.measured_packets.rejected;
        if impossible > 0 {
            let headline =
                format!("{} rejected for numbers that no sensor measures", counted(impossible, "binary packet"));
            let details = "Their angular rates or accelerations are no numbers (NaN), or beyond any range. The sensor is broken or \
                           still starting, or what wrote the file put them there.";
            return Some((headline, Text::from(details)));
        }
        let beside =
            link.other_message.map_or_else(String::new, |name| format!(" and other sentences, such as {name}"));
        let headline = format!("{}{beside}, and no message that is measured", counted(tally.packets, "binary packet"));
        let details = Text::from("They have neither angular rate nor acceleration. Packets that have both come with `")
            .remedy(Remedy::Configure(Setting::Message("BINARY")))
            .then("`, sentences with VNYMR or VNIMU.");
        return Some((headline, details));
    }
    if let Some(name) = link.other_message {
        let headline = format!(
            "{} valid, none of a message that is measured; the first is {name}",
            lines(tally.valid_sentences())
        );
        let details = match link.connects {
            0 => Text::from("Measured are VNYMR, VNQMR, VNMAR, VNIMU and VNDTV. `")
                .remedy(Remedy::Configure(Setting::Message("VNIMU")))
                .then("` makes a sensor send one of them for the next recording."),
            _ => Text::from("$VNWRG,06,14*59 makes the sensor send VNYMR, $VNWRG,06,19*54 VNIMU, as does `")
                .remedy(Remedy::Configure(Setting::Message("VNYMR")))
                .then("`."),
        };
        return Some((headline, details));
    }
    // garbled bytes contain few sentences; a program that writes text changes whole ones
    if tally.rejected.grammar > 0 && tally.rejected_sentence_bytes > tally.skipped_bytes && link.connects == 0 {
        let headline = format!("all {} malformed", lines(tally.rejected.total()));
        let details = Text::from(
            "Their fields are not those of the message, or not numbers: the program that wrote them has cut or changed them. As a table, ",
        )
        .remedy(Remedy::MapColumns(None))
        .then(" names their columns.");
        return Some((headline, details));
    }
    let only_unchecked = tally.rejected.unchecked > 0 && tally.rejected.unchecked == tally.rejected.total();
    (tally.valid_sentences() == 0 && !only_unchecked && link.rejected_rows.is_none()).then(|| {
        let headline = format!("{} bytes without a valid line", tally.bytes());
        let details = match link.connects {
            0 => "The file is no capture of a VN-100, or was recorded at a wrong baud rate.",
            _ => "The baud rate is probably wrong. If it is right, the host's receiver flips bits: close and reopen the port.",
        };
        (headline, details.into())
    })
}

/// One warning for each code.
pub(super) fn unsolicited(errors: &UnsolicitedErrors) -> impl Iterator<Item = Warning> {
    errors.iter().map(|(error, count)| {
        let headline = format!("unsolicited device error, {}: {error}", counted(count, "time"));
        let (kind, details) = match error {
            DeviceError::OutputBufferOverflow => (
                WarningKind::LinkBudget,
                format!("The sensor drops what its output buffer cannot hold, and the record lacks it. To avoid it, {}.", error.advice()),
            ),
            _ if error.is_unsolicited() => (WarningKind::DeviceErrors, format!("{}.", capitalised(error.advice()))),
            _ => (
                WarningKind::DeviceErrors,
                "The sensor reports that in reply to a command, and none was sent from here: look for another program on the link, and \
                 for noise on the wire to the sensor."
                    .into(),
            ),
        };
        Warning::new(kind, Vec::new(), headline, details)
    })
}

/// The warning that another program has the port open.
pub(super) fn shared_port(program: &str) -> Warning {
    let details =
        "Each byte reaches only one of the two programs: samples are missing, and lines are cut. End that program.";
    Warning::new(WarningKind::PortShared, Vec::new(), format!("{program} has the port open too"), details)
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The consequence of a refusal; `is_over` where the link was lost after it, and the stamps after
/// that are used again.
pub(super) fn refused(refusal: Refusal, is_over: bool, snapshot: &Snapshot) -> Text {
    let timing = &snapshot.timing;
    // the stamps of a link are those of its reads
    let is_link = snapshot.link.connects > 0;
    let cause = match refusal {
        Refusal::TooFast { .. } if is_link => "Delayed bytes arrive like that. ",
        Refusal::TooFast { .. } => "They may have been stamped when a file was read: set the rate. ",
        Refusal::NoTimePasses { .. } if !is_link => "Set the rate. ",
        Refusal::Uneven { .. } => "Samples are missing, or the sensor has another rate: set the rate. ",
        Refusal::Pairs { .. } => "Measure each source alone, or set the rate. ",
        Refusal::Backwards { .. } => "Stamp with a clock that is not set meanwhile, and keep the lines in order. ",
        Refusal::OtherRate { .. } => "Averaging times use the known rate; entirely missing lines cannot be detected. ",
        Refusal::NoTimePasses { .. } => "",
    };
    let effect = match refusal {
        // says so itself
        Refusal::OtherRate { known_hz, .. } if known_hz == timing.rate_hz => match timing.rate_from {
            RateFrom::Option => {
                Text::default().remedy(Remedy::GiveRate(None)).then(" set that rate: if the stamps are right, omit it.")
            }
            RateFrom::DeviceTime | RateFrom::Device => "The sensor reports that rate.".into(),
            RateFrom::Arrival | RateFrom::Assumed => "The arrival times before showed that rate.".into(),
        },
        Refusal::OtherRate { .. } => "The arrival times before showed that rate.".into(),
        Refusal::Backwards { .. }
        | Refusal::TooFast { .. }
        | Refusal::NoTimePasses { .. }
        | Refusal::Pairs { .. }
        | Refusal::Uneven { .. } => "Entirely missing lines cannot be detected from there on.".into(),
    };
    let until = if is_over { " It lasted until the link disconnected." } else { "" };
    Text::from(cause).append(effect).then(until)
}
