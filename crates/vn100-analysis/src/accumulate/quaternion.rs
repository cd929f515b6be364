//! The sign of a quaternion, made continuous: q and -q are the same attitude.

use std::ops::Range;

use vn100_protocol::{Layout, Quantity};

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

    /// Places of the elements in a row.
    pub(crate) fn elements(&self) -> Range<usize> {
        self.first..self.first + 4
    }

    /// Rows with each quaternion in the sign that is nearer to the quaternion before, however long
    /// ago that was. Rows at the places `lacking` lack an element and stay as they are.
    pub(crate) fn continued(&mut self, rows: &[i32], width: usize, lacking: &[usize]) -> &[i32] {
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

    /// Rows of a message that is nothing but a quaternion.
    fn continued(sign: &mut QuaternionSign, rows: &[[i32; 4]]) -> Vec<i32> {
        sign.continued(rows.as_flattened(), 4, &[]).to_vec()
    }

    fn sign() -> QuaternionSign {
        let layout = Layout { channels: VNQMR.channels[..4].to_vec().into(), ..VNQMR.clone() };
        QuaternionSign::of(&layout).unwrap()
    }

    #[test]
    fn only_a_whole_quaternion_has_a_sign() {
        assert!(QuaternionSign::of(&VNYMR).is_none());
        assert_eq!(QuaternionSign::of(&VNQMR).unwrap().first, 0);
        let three = Layout { channels: VNQMR.channels[1..].to_vec().into(), ..VNQMR.clone() };
        assert!(QuaternionSign::of(&three).is_none());
    }

    #[test]
    fn the_first_row_keeps_its_sign_and_the_others_follow() {
        let rows = [[0, 0, -6, -8], [0, 0, 6, 8], [0, 1, -6, -8], [0, 0, -8, 6]];
        let expected = [0, 0, -6, -8, 0, 0, -6, -8, 0, 1, -6, -8, 0, 0, -8, 6];
        assert_eq!(continued(&mut sign(), &rows), expected);
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
