//! The last minutes of a channel in as many columns as there is room for.

use imu_noise::counts_to_unit;
use vn100_analysis::Slot;

use super::source::Source;

/// Values of one column, in the unit of the channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Column {
    pub(crate) min: f64,
    pub(crate) max: f64,
    pub(crate) mean: f64,
}

/// The oldest column first; `None` where nothing came.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct History {
    pub(crate) columns: Vec<Option<Column>>,
    /// Data time of a column, in seconds.
    pub(crate) column_s: f64,
}

/// The heights of the bars of a sparkline.
const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

impl Source {
    /// The latest `most_slots` of a channel in at most `columns` columns. Columns begin at fixed
    /// times, so that they do not flicker.
    pub(crate) fn history(&self, channel: usize, columns: usize, most_slots: usize) -> Option<History> {
        let recent = self.snapshot.recent.as_ref()?;
        let layout = self.snapshot.layout.as_ref()?.channels.get(channel)?;
        let branch = self.snapshot.channels.get(channel)?.branch_counts;
        let slots = recent.slots(channel);
        let kept = slots.len().min(most_slots);
        // one column may be cut short at either end
        let together = kept.div_ceil(columns.checked_sub(1)?.max(1)).max(1) as u64;
        let first = recent.end() - kept as u64;
        let mut history = Vec::new();
        let mut number = None;
        let mut merged: Vec<Option<Slot>> = Vec::new();
        for (place, slot) in slots.skip(recent.slots(channel).len() - kept).enumerate() {
            let column = (first + place as u64) / together;
            if number != Some(column) {
                number = Some(column);
                merged.push(None);
            }
            if let (Some(last), Some(slot)) = (merged.last_mut(), slot) {
                *last = Some(last.map_or(slot, |sum| merge(sum, slot)));
            }
        }
        let value = |counts: f64| counts_to_unit(counts - branch as f64, layout.decimals) * layout.scale;
        history.extend(merged.into_iter().map(|slot| {
            slot.map(|slot| Column {
                min: value(slot.min as f64),
                max: value(slot.max as f64),
                mean: value(slot.sum as f64 / f64::from(slot.count)),
            })
        }));
        let column_s = (recent.samples_per_slot() * together) as f64 / self.snapshot.timing.rate_hz;
        Some(History { columns: history, column_s })
    }

    /// The means of the last minutes as bars, between the lowest and the highest of them.
    pub(crate) fn sparkline(&self, channel: usize, columns: usize) -> String {
        let Some(history) = (columns >= 8).then(|| self.history(channel, columns, usize::MAX)).flatten() else {
            return String::new();
        };
        let means = history.columns.iter().flatten().map(|column| column.mean);
        let (low, high) =
            means.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), mean| (low.min(mean), high.max(mean)));
        let bar = |column: &Option<Column>| {
            column.map_or(' ', |column| {
                let height = (column.mean - low) / (high - low);
                BARS[if height.is_finite() { (height * 7.0).round() as usize } else { 3 }.min(7)]
            })
        };
        history.columns.iter().map(bar).collect()
    }
}

fn merge(a: Slot, b: Slot) -> Slot {
    Slot { min: a.min.min(b.min), max: a.max.max(b.max), sum: a.sum + b.sum, count: a.count + b.count }
}
