//! An archive as a table: a row for each recording and channel.

use std::collections::BTreeSet;

use super::tables::{Table, number};
use crate::document::archive::{ArchiveDocument, ChannelRow, RecordingRow};

pub(super) const HEADER: [&str; 27] = [
    "name",
    "serial",
    "model",
    "message",
    "started_ns",
    "rate_hz",
    "duration_s",
    "samples",
    "missing",
    "channel",
    "unit",
    "mean",
    "std",
    "white_status",
    "white",
    "white_lower",
    "white_upper",
    "bias_instability_status",
    "bias_instability",
    "bias_instability_lower",
    "bias_instability_upper",
    "rate_random_walk_status",
    "rate_random_walk",
    "rate_random_walk_upper",
    "verdicts",
    "warnings",
    "error",
];

/// The table as CSV, in SI units; a recording that could not be read is a row with its error.
#[must_use]
pub fn archive_table(archive: &ArchiveDocument) -> String {
    let mut table = Table(String::new());
    table.row(&HEADER);
    for recording in &archive.recordings {
        let rows = recording.channels.iter().map(Some).chain(recording.channels.is_empty().then_some(None));
        for channel in rows {
            let cells = cells(recording, channel);
            table.row(&cells.iter().map(String::as_str).collect::<Vec<_>>());
        }
    }
    table.0
}

fn cells(recording: &RecordingRow, channel: Option<&ChannelRow>) -> Vec<String> {
    let text = |text: &Option<String>| text.clone().unwrap_or_default();
    let mut cells = vec![
        recording.name.clone(),
        text(&recording.serial),
        text(&recording.model),
        text(&recording.message),
        recording.started_ns.map_or_else(String::new, |ns| ns.to_string()),
        number(recording.rate_hz),
        number(Some(recording.duration_s)),
        recording.samples.to_string(),
        recording.missing.to_string(),
    ];
    let parameter = |name: &str| {
        let found = channel.and_then(|channel| channel.noise.iter().find(|found| found.parameter == name));
        let status = found.map_or_else(String::new, |found| found.status.to_owned());
        let [middle, lower, upper] =
            found.map_or([None; 3], |found| [found.value, found.lower, found.upper]).map(number);
        [status, middle, lower, upper]
    };
    cells.extend(channel.map_or_else(
        || vec![String::new(); 4],
        |channel| vec![channel.name.clone(), channel.unit.clone(), number(channel.mean), number(channel.std)],
    ));
    cells.extend(parameter("white"));
    cells.extend(parameter("bias_instability"));
    let [status, middle, _, upper] = parameter("rate_random_walk");
    cells.extend([status, middle, upper]);
    let verdicts = channel.iter().flat_map(|channel| &channel.verdicts);
    let verdicts: Vec<_> =
        verdicts.map(|judged| format!("{} {} {}", judged.parameter, judged.claim, judged.verdict)).collect();
    let mut named = BTreeSet::new();
    let kinds = recording.warnings.iter().map(|warning| warning.kind);
    let kinds: Vec<_> = kinds.filter(|kind| named.insert(*kind)).collect();
    cells.extend([verdicts.join("; "), kinds.join("; "), text(&recording.error)]);
    cells
}
