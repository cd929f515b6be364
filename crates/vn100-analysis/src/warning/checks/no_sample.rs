//! What arrives instead of samples.

use super::all_lines;
use crate::{
    remedy::{Remedy, Setting},
    snapshot::Snapshot,
    warning::{Finding, Rejected, Warning},
};

/// What was found if no sample arrives; `None` if samples arrive, or too few bytes to say.
pub(super) fn warning(snapshot: &Snapshot) -> Option<Warning> {
    // this many bytes contain a whole sentence, wherever the first one began
    const ENOUGH_BYTES: u64 = 3 * 122;
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    if link.samples() > 0 {
        return None;
    }
    let configure = |header| Remedy::Configure(Setting::Message(header));
    let (rejected, all) = (tally.rejected.total(), all_lines(tally));
    if let Some(rows) = link.rejected_rows.filter(|rows| rows.total() > 0) {
        let found = Finding::AllRejected(Rejected::Rows(rows), rows.total(), all);
        return Some(Warning::new(found).cured_by(Remedy::MapColumns(None)));
    }
    // damaged sentences may be measurements: they must be few in comparison with the replies
    let damaged_bytes = tally.rejected_sentence_bytes + tally.skipped_bytes;
    let is_clean = 10 * rejected <= link.answers() && 10 * damaged_bytes <= tally.valid_sentence_bytes;
    let has_replies_alone = link.answers() > 0 && tally.valid_sentences() == tally.replies && tally.packets == 0;
    if link.connects > 0 && has_replies_alone && is_clean {
        // register 6 holds the output of the port by which it was read
        let set = snapshot.registers.get(&6).filter(|output| !output.is_empty() && !output.starts_with('0'));
        return Some(Warning::new(Finding::OnlyReplies(link.answers(), set.cloned())).cured_by(configure("VNYMR")));
    }
    if tally.bytes() < ENOUGH_BYTES {
        return None;
    }
    let is_foreign = link.other_message.is_none_or(|name| !name.to_string().starts_with("VN"));
    let impossible = tally.measured_packets.rejected;
    if tally.packets > 0 && is_foreign && impossible > 0 {
        return Some(Warning::new(Finding::AllRejected(Rejected::PacketNumbers, impossible, tally.packets)));
    }
    if tally.packets > 0 && is_foreign || link.other_message.is_some() {
        let found = Finding::NothingMeasured(tally.packets, tally.valid_sentences(), link.other_message);
        return Some(Warning::new(found).cured_by(configure(if is_foreign { "BINARY" } else { "VNIMU" })));
    }
    // garbled bytes contain few sentences; a program that writes text changes whole ones
    if tally.rejected.grammar > 0 && tally.rejected_sentence_bytes > tally.skipped_bytes && link.connects == 0 {
        let found = Finding::AllRejected(Rejected::Malformed, rejected, all);
        return Some(Warning::new(found).cured_by(Remedy::MapColumns(None)));
    }
    let only_unchecked = tally.rejected.unchecked > 0 && tally.rejected.unchecked == rejected;
    let is_nothing = tally.valid_sentences() == 0 && !only_unchecked && link.rejected_rows.is_none();
    is_nothing.then(|| Warning::new(Finding::NoSentence(tally.bytes())))
}
