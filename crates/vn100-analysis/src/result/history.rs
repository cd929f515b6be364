//! The recent samples of a channel, as they are drawn.

use super::BlockValues;
use crate::{accumulate::recent::Slot, snapshot::Snapshot};

/// The columns of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    /// The columns, the oldest first, which begin at negative times: at 0 the last one ends. `None`
    /// if a column has no sample.
    pub columns: Vec<Option<BlockValues>>,
    /// Data time of a column, in seconds.
    pub column_s: f64,
}

impl History {
    /// The latest `most_slots` slots of the channel at this place, in at most `columns` columns at fixed
    /// times, so that they do not flicker. `None` without a column, and if no samples are kept.
    pub(super) fn of(snapshot: &Snapshot, channel: usize, columns: usize, most_slots: usize) -> Option<Self> {
        let recent = snapshot.recent.as_ref()?;
        let layout = snapshot.layout.as_ref()?.channels.get(channel)?;
        let branch = snapshot.channels.get(channel)?.branch_counts;
        let slots = recent.slots(channel);
        let kept = slots.len().min(most_slots);
        // one column may be cut short at either end
        let together = kept.div_ceil(columns.checked_sub(1)?.max(1)).max(1) as u64;
        let first = recent.end - kept as u64;
        let of_columns = (first..).map(|place| place / together);
        let slots: Vec<_> = of_columns.zip(recent.slots(channel).skip(slots.len() - kept)).collect();
        let value = |counts: f64| layout.in_unit(counts - branch as f64);
        let columns: Vec<_> = slots.chunk_by(|(a, _), (b, _)| a == b).collect();
        let duration_s = (recent.samples_per_slot * together) as f64 / snapshot.timing.rate_hz;
        let length_s = columns.len() as f64 * duration_s;
        let column = |(place, slots): (usize, &&[(u64, Option<Slot>)])| {
            let slot = slots.iter().filter_map(|(_, slot)| *slot).reduce(merge)?;
            Some(BlockValues {
                start_s: place as f64 * duration_s - length_s,
                duration_s,
                count: slot.count.into(),
                mean: value(slot.sum as f64 / f64::from(slot.count)),
                std: None,
                min: value(slot.min as f64),
                max: value(slot.max as f64),
            })
        };
        Some(Self { columns: columns.iter().enumerate().map(column).collect(), column_s: duration_s })
    }
}

fn merge(a: Slot, b: Slot) -> Slot {
    Slot { min: a.min.min(b.min), max: a.max.max(b.max), sum: a.sum + b.sum, count: a.count + b.count }
}
