//! The sign of a quaternion, made continuous: q and -q are the same attitude.

use std::borrow::Cow;

use vn100_protocol::{Layout, Quantity, stream::AbsentCell};

#[derive(Debug, Clone)]
pub(crate) struct QuaternionSign {
    first: usize,
    /// The last quaternion as continued; zero before the first row, which keeps its sign.
    previous: [i32; 4],
    rows: Vec<i32>,
}

impl QuaternionSign {
    /// `None` for a layout without a whole quaternion.
    pub(crate) fn of(layout: &Layout) -> Option<Self> {
        let is_whole = |four: &[_]| four.iter().all(|quantity| *quantity == Quantity::Quaternion);
        let quantities: Vec<_> = layout.channels.iter().map(|channel| channel.quantity).collect();
        let first = quantities.windows(4).position(is_whole)?;
        Some(Self { first, previous: [0; 4], rows: Vec::new() })
    }

    /// Where an element is absent, all elements count as absent.
    pub(crate) fn complete_absent(&self, absent: &mut Cow<'_, [AbsentCell]>) {
        let elements = self.first..self.first + 4;
        let broken: Vec<_> = absent.iter().filter(|cell| elements.contains(&cell.channel)).copied().collect();
        if broken.is_empty() {
            return;
        }
        let all = absent.to_mut();
        all.extend(broken.iter().flat_map(|cell| elements.clone().map(|channel| AbsentCell { channel, ..*cell })));
        all.sort_by_key(|cell| (cell.row, cell.channel));
        all.dedup();
    }

    /// Rows with each quaternion in the sign that is nearer to the quaternion before, however long
    /// ago that was. Rows that lack its elements stay as they are.
    pub(crate) fn continued(&mut self, rows: &[i32], width: usize, absent: &[AbsentCell]) -> &[i32] {
        let lacking: Vec<_> = absent.iter().filter(|cell| cell.channel == self.first).map(|cell| cell.row).collect();
        self.rows.clear();
        self.rows.extend_from_slice(rows);
        for (place, row) in self.rows.chunks_exact_mut(width).enumerate() {
            if lacking.contains(&place) {
                continue;
            }
            let quaternion = &mut row[self.first..self.first + 4];
            let products =
                quaternion.iter().zip(self.previous).map(|(now, before)| f64::from(*now) * f64::from(before));
            if products.sum::<f64>() < 0.0 {
                // the least count has no opposite, and is beyond the limit of every channel
                quaternion.iter_mut().for_each(|count| *count = count.saturating_neg());
            }
            self.previous.copy_from_slice(quaternion);
        }
        &self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vn100_protocol::{VNQMR, VNYMR};

    #[test]
    fn only_a_whole_quaternion_has_a_sign() {
        assert!(QuaternionSign::of(&VNYMR).is_none());
        assert_eq!(QuaternionSign::of(&VNQMR).unwrap().first, 0);
        let three = Layout { channels: VNQMR.channels[1..].to_vec().into(), ..VNQMR.clone() };
        assert!(QuaternionSign::of(&three).is_none());
    }

    #[test]
    fn the_cutting_changes_nothing_and_the_other_channels_keep_theirs() {
        let mut row = vec![0; 13];
        row[..5].copy_from_slice(&[5, -5, 5, 5, -7]);
        let mut opposite = row.clone();
        opposite[..4].iter_mut().for_each(|count| *count = -*count);
        let mut sign = QuaternionSign::of(&VNQMR).unwrap();
        for sent in [&row, &opposite, &opposite, &row] {
            assert_eq!(sign.continued(sent, 13, &[]), row);
        }
        assert_eq!(sign.continued(&[opposite.clone(), opposite].concat(), 13, &[]), [row.clone(), row].concat());
    }
}
