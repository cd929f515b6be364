//! The recent samples of a channel, as they are drawn.

use crate::{accumulate::recent::Slot, snapshot::Snapshot};

/// The values of one column, in the unit of the channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HistoryColumn {
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Mean of all samples.
    pub mean: f64,
}

/// The columns of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    /// The columns, the oldest first; `None` if a column has no sample.
    pub columns: Vec<Option<HistoryColumn>>,
    /// Data time of a column, in seconds.
    pub column_s: f64,
}

impl History {
    /// The latest `most_slots` slots of the channel at this place, in at most `columns` columns,
    /// which begin at fixed times so that they do not flicker. `None` if the recent samples are
    /// not kept, or without a column.
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
        let columns = slots.chunk_by(|(a, _), (b, _)| a == b).map(|slots| {
            let slot = slots.iter().filter_map(|(_, slot)| *slot).reduce(merge)?;
            Some(HistoryColumn {
                min: value(slot.min as f64),
                max: value(slot.max as f64),
                mean: value(slot.sum as f64 / f64::from(slot.count)),
            })
        });
        let columns = columns.collect();
        let column_s = (recent.samples_per_slot * together) as f64 / snapshot.timing.rate_hz;
        Some(Self { columns, column_s })
    }
}

fn merge(a: Slot, b: Slot) -> Slot {
    Slot { min: a.min.min(b.min), max: a.max.max(b.max), sum: a.sum + b.sum, count: a.count + b.count }
}
