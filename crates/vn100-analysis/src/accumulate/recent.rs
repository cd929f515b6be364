//! The last four minutes of every channel: smallest, largest and mean value of each half second.

use std::collections::VecDeque;

/// The number of slots that are kept: four minutes.
const MOST_SLOTS: usize = 480;

const SLOT_S: f64 = 0.5;

const SAME_RATE: f64 = 0.02;

/// The values of one channel in one slot, in counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Slot {
    /// Smallest value.
    pub min: i32,
    /// Largest value.
    pub max: i32,
    /// Sum of all values.
    pub sum: i64,
    /// Number of values; never 0.
    pub count: u32,
}

/// The latest samples in bounded memory. Slots begin at multiples of their length, missing samples
/// included; one without samples is `None` in every channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Recent {
    pub(crate) rate_hz: f64,
    /// Samples that a slot spans; its data time is this number over the sample rate.
    pub samples_per_slot: u64,
    /// Number of the slot after the last one: the slots of a channel are the latest before it.
    pub end: u64,
    channels: usize,
    /// The oldest slot of all channels first; a `count` of 0 stands for no samples.
    slots: VecDeque<Slot>,
}

impl Recent {
    pub(crate) fn new(channels: usize, rate_hz: f64) -> Self {
        let samples_per_slot = (SLOT_S * rate_hz).round().max(1.0) as u64;
        Self { rate_hz, samples_per_slot, end: 0, channels, slots: VecDeque::new() }
    }

    /// Whether this is the rate of the slots, to the error of a rate that is still measured.
    pub(crate) fn is_at(&self, rate_hz: f64) -> bool {
        (rate_hz / self.rate_hz - 1.0).abs() < SAME_RATE
    }

    /// The slots of a channel, the oldest first; at most 480. The last slot may still grow.
    pub fn slots(&self, channel: usize) -> impl ExactSizeIterator<Item = Option<Slot>> {
        let first = if channel < self.channels { channel } else { self.slots.len() };
        let slots = self.slots.iter().skip(first).step_by(self.channels.max(1));
        slots.map(|slot| (slot.count > 0).then_some(*slot))
    }

    /// Adds samples of one channel without a gap between them, the first with this absolute index.
    pub(crate) fn push(&mut self, channel: usize, index: u64, counts: &[i32]) {
        let mut index = index;
        let mut rest = counts;
        while !rest.is_empty() {
            let slot = index / self.samples_per_slot;
            self.advance(slot);
            let here =
                usize::try_from((slot + 1) * self.samples_per_slot - index).map_or(rest.len(), |n| n.min(rest.len()));
            let (now, later) = rest.split_at(here);
            // the oldest slots of a long batch have been dropped already
            let place = self.slots.len().checked_sub((self.end - slot) as usize * self.channels);
            if let Some(slot) = place.and_then(|place| self.slots.get_mut(place + channel)) {
                slot.add(now);
            }
            index += here as u64;
            rest = later;
        }
    }

    fn advance(&mut self, slot: u64) {
        let new = (slot + 1).saturating_sub(self.end);
        if new == 0 {
            return;
        }
        let new = new.min(MOST_SLOTS as u64) as usize * self.channels;
        self.slots.extend(std::iter::repeat_n(Slot::default(), new));
        self.slots.drain(..self.slots.len().saturating_sub(MOST_SLOTS * self.channels));
        self.end = slot + 1;
    }
}

impl Slot {
    fn add(&mut self, counts: &[i32]) {
        let Some(first) = counts.first() else { return };
        if self.count == 0 {
            (self.min, self.max) = (*first, *first);
        }
        for &count in counts {
            self.min = self.min.min(count);
            self.max = self.max.max(count);
            self.sum += i64::from(count);
            self.count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{collection::vec, prelude::*};

    fn slots(recent: &Recent, channel: usize) -> Vec<Option<(i32, i32, i64, u32)>> {
        recent.slots(channel).map(|slot| slot.map(|slot| (slot.min, slot.max, slot.sum, slot.count))).collect()
    }

    #[test]
    fn a_slot_spans_half_a_second_and_a_gap_is_empty() {
        let mut recent = Recent::new(2, 4.0);
        assert_eq!((recent.samples_per_slot, recent.slots(0).len(), recent.slots(9).len()), (2, 0, 0));
        recent.push(0, 0, &[5, -7, 1]);
        recent.push(1, 0, &[i32::MIN, i32::MIN, 3]);
        assert_eq!(slots(&recent, 0), [Some((-7, 5, -2, 2)), Some((1, 1, 1, 1))]);
        let lowest = i32::MIN;
        assert_eq!(slots(&recent, 1), [Some((lowest, lowest, 2 * i64::from(lowest), 2)), Some((3, 3, 3, 1))]);
        recent.push(0, 9, &[8]);
        assert_eq!(slots(&recent, 0)[1..], [Some((1, 1, 1, 1)), None, None, Some((8, 8, 8, 1))]);
        assert_eq!(slots(&recent, 1)[4], None);
    }

    #[test]
    fn only_the_last_minutes_stay() {
        let mut recent = Recent::new(1, 1.0);
        recent.push(0, 0, &(0..1000).collect::<Vec<_>>());
        let slots = slots(&recent, 0);
        assert_eq!((slots.len(), slots[0], slots[479]), (480, Some((520, 520, 520, 1)), Some((999, 999, 999, 1))));
        recent.push(0, 1_000_000_000_000, &[1]);
        assert_eq!(recent.slots(0).flatten().count(), 1, "a long gap takes no time");
    }

    proptest! {
        #[test]
        fn how_the_stream_is_cut_changes_nothing(counts in vec(any::<i32>(), 1..3000), cuts in vec(1_usize..400, 1..40)) {
            let mut whole = Recent::new(1, 40.0);
            whole.push(0, 7, &counts);
            let mut pieces = Recent::new(1, 40.0);
            let mut at = 0;
            for cut in cuts.iter().cycle() {
                if at == counts.len() {
                    break;
                }
                let end = (at + cut).min(counts.len());
                pieces.push(0, 7 + at as u64, &counts[at..end]);
                at = end;
            }
            prop_assert_eq!(whole, pieces);
        }
    }
}
