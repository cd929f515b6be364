//! Angles made continuous.

use imu_noise::Unwrap;
use proptest::{collection::vec, prelude::*};

const TURN: i32 = 360_000;

/// All pieces of a series, as a caller takes them.
fn pieces(unwrap: &mut Unwrap, counts: &[i32]) -> Vec<Vec<i32>> {
    let mut counts = counts.to_vec();
    let mut pieces = Vec::new();
    let mut start = 0;
    while start < counts.len() {
        let together = unwrap.unwrap(&mut counts[start..]);
        pieces.push(counts[start..start + together].to_vec());
        start += together;
    }
    pieces
}

fn wrapped(angle: i64) -> i32 {
    let principal = angle.rem_euclid(TURN.into());
    i32::try_from(if principal > i64::from(TURN / 2) { principal - i64::from(TURN) } else { principal }).unwrap()
}

#[test]
fn steps_take_the_short_way_and_half_a_turn_is_positive() {
    assert_eq!(pieces(&mut Unwrap::new(TURN), &[0, 180_000, 0, -180_000]), [[0, 180_000, 360_000, 540_000]]);
    // Half an odd turn is no whole count.
    assert_eq!(pieces(&mut Unwrap::new(7), &[3, -3, 3, 0]), [[3, 4, 3, 0]]);
}

#[test]
fn leaving_the_range_of_i32_breaks_the_series() {
    let third = TURN / 3;
    let steps = 2 * (i32::MAX / third) as usize;
    for direction in [1, -1] {
        let counts: Vec<_> = (0..steps as i64).map(|i| wrapped(direction * i * i64::from(third))).collect();
        let pieces = pieces(&mut Unwrap::new(TURN), &counts);
        assert_eq!(pieces.len(), 2);
        let lengths: usize = pieces.iter().map(Vec::len).sum();
        assert_eq!(lengths, steps);
        for piece in &pieces {
            assert!(piece[0].unsigned_abs() <= TURN.unsigned_abs() / 2);
            assert!(piece.windows(2).all(|pair| pair[1] - pair[0] == direction as i32 * third));
        }
        assert!(i32::MAX.abs_diff(pieces[0].last().unwrap().saturating_abs()) < TURN.unsigned_abs());
    }
}

#[test]
fn a_mean_returns_to_the_principal_branch() {
    let unwrap = Unwrap::new(TURN);
    for (mean, offset) in
        [(0.0, 0), (180_000.0, 0), (180_000.5, 360_000), (-180_000.0, -360_000), (-179_999.5, 0), (1e6, 1_080_000)]
    {
        assert_eq!(unwrap.turn_offset_counts(mean), offset, "{mean}");
    }
    for mean in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(unwrap.turn_offset_counts(mean), 0);
    }
}

#[test]
#[should_panic(expected = "a turn has 0 counts")]
fn a_turn_needs_counts() {
    let _ = Unwrap::new(0);
}

proptest! {
    #[test]
    fn wrapping_is_undone_in_any_division(
        start in -180_000_i64 + 1..=180_000,
        steps in vec(-179_999_i64..=180_000, 0..200),
        cuts in vec(0_usize..200, 0..4),
    ) {
        let mut angle = start;
        let mut angles = vec![start];
        for step in steps {
            angle += step;
            angles.push(angle);
        }
        let counts: Vec<_> = angles.iter().map(|&angle| wrapped(angle)).collect();
        let mut unwrap = Unwrap::new(TURN);
        let mut found = Vec::new();
        let mut begin = 0;
        let mut ends: Vec<_> = cuts.into_iter().filter(|&cut| cut < counts.len()).chain([counts.len()]).collect();
        ends.sort_unstable();
        for end in ends {
            found.extend(pieces(&mut unwrap, &counts[begin..end]).concat());
            begin = end;
        }
        let found: Vec<_> = found.into_iter().map(i64::from).collect();
        prop_assert_eq!(found, angles);
    }
}
