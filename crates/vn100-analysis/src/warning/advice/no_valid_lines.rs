//! Why a stream brings bytes and no samples.

use super::{lines, reasons};
use crate::snapshot::Snapshot;

/// What it is likely to suffer from; `None` where it brings samples, or too little to say.
pub(super) fn no_valid_lines(snapshot: &Snapshot) -> Option<String> {
    // within so many bytes a whole line must have been among them, wherever the first one began
    const ENOUGH_BYTES: u64 = 3 * 122;
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    if link.samples() > 0 {
        return None;
    }
    if let Some(odd) = link.odd_rows.filter(|odd| odd.total() > 0) {
        return Some(format!(
            "{} of a CSV file and no good row among them ({}): do its columns hold what their names say? --columns names others, and \
             their units",
            lines(tally.bad.total()),
            reasons(&odd)
        ));
    }
    // damaged lines may be measurements: they must be few beside the answers
    let damaged_bytes = tally.bad_line_bytes + tally.skipped_bytes;
    let is_clean = 10 * tally.bad.total() <= link.answers() && 10 * damaged_bytes <= tally.good_line_bytes;
    if link.connects > 0 && link.answers() > 0 && tally.good_lines() == tally.replies && is_clean {
        return Some(format!(
            "{}, all of them answers: the sensor sends nothing by itself. `vn100 configure PORT --set-message VNYMR` makes it send, or \
             VNIMU for the uncompensated measurements",
            lines(link.answers())
        ));
    }
    if tally.bytes() < ENOUGH_BYTES {
        return None;
    }
    if let Some(name) = link.other_message {
        return Some(format!(
            "{} good, none of a message this program measures; the first is {name}. $VNWRG,06,14*59 makes the sensor send VNYMR, \
             $VNWRG,06,19*54 VNIMU; `vn100 configure PORT --set-message VNYMR` does it",
            lines(tally.good_lines())
        ));
    }
    let only_unchecked = tally.bad.unchecked > 0 && tally.bad.unchecked == tally.bad.total();
    (tally.good_lines() == 0 && !only_unchecked && link.odd_rows.is_none()).then(|| {
        format!(
            "{} bytes and no valid line among them: wrong baud rate? If the rate is right, the host's receiver flips bits: close and \
             reopen the port",
            tally.bytes()
        )
    })
}
