//! Why a stream brings bytes and no samples.

use super::{lines, reasons};
use crate::{
    remedy::{Remedy, Setting, Text},
    snapshot::Snapshot,
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
    if let Some(name) = link.other_message {
        let text = Text::from(format!(
            "{} good, none of a message this program measures; the first is {name}. $VNWRG,06,14*59 makes the sensor send VNYMR, \
             $VNWRG,06,19*54 VNIMU; `",
            lines(tally.valid_sentences())
        ));
        return Some(text.remedy(Remedy::Configure(Setting::Message("VNYMR"))).then("` does it"));
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
