//! Continuous counts of a wrapping angle.

/// Makes a continuous series of the counts of a wrapping angle, across any division into slices.
///
/// Each step is taken the short way round: into (-half a turn, half a turn]. The first sample is
/// brought to the principal branch, the same half-open interval.
///
/// ```
/// use imu_noise::Unwrap;
///
/// let mut yaw = Unwrap::new(360_000); // 1 count = 0.001 degrees
/// let mut counts = [179_990, -179_995, 179_999];
/// assert_eq!(yaw.unwrap(&mut counts), 3);
/// assert_eq!(counts, [179_990, 180_005, 179_999]);
/// assert_eq!(yaw.turn_offset_counts(180_001.5), 360_000);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unwrap {
    turn_counts: i64,
    /// The last wrapped count, and the difference of the continuous count to it, a multiple of a turn.
    last: Option<(i64, i64)>,
}

impl Unwrap {
    /// Unwraps an angle with `turn_counts` counts in a full turn: 360 000 for degrees with three
    /// decimals.
    ///
    /// # Panics
    /// If `turn_counts` is not positive.
    pub fn new(turn_counts: i32) -> Self {
        assert!(turn_counts > 0, "a turn has {turn_counts} counts, it needs at least 1");
        Self { turn_counts: turn_counts.into(), last: None }
    }

    /// Replaces the counts by the continuous series. Returns the number of continuous ones: fewer
    /// than all if the angle has left the range of `i32` (after 5965 turns of 360 000 counts). The
    /// rest is unchanged, and unwrapping it restarts in the principal branch; accumulators need a
    /// break without loss there ([`gap(Some(0))`](crate::Octaves::gap)).
    #[must_use = "the counts behind the returned number still wrap"]
    pub fn unwrap(&mut self, counts: &mut [i32]) -> usize {
        for (i, count) in counts.iter_mut().enumerate() {
            let wrapped = i64::from(*count);
            let offset = match self.last {
                Some((last, offset)) => offset - self.turns(wrapped - last) * self.turn_counts,
                None => -self.turns(wrapped) * self.turn_counts,
            };
            let Ok(continuous) = i32::try_from(wrapped + offset) else {
                self.last = None;
                return i;
            };
            *count = continuous;
            self.last = Some((wrapped, offset));
        }
        counts.len()
    }

    /// The whole turns, in counts, that are to be subtracted to bring a mean of the continuous series to
    /// the principal branch, and minimum and maximum with it; 0 for a mean that is not finite.
    pub fn turn_offset_counts(&self, mean_counts: f64) -> i64 {
        let turn = self.turn_counts as f64;
        // Ties go to the upper end of the branch. A cast of NaN is 0.
        let turns = ((mean_counts - turn / 2.0) / turn).ceil();
        if turns.is_finite() { (turns as i64).saturating_mul(self.turn_counts) } else { 0 }
    }

    /// Whole turns in `counts`: the rest is in (-half a turn, half a turn].
    #[inline]
    fn turns(&self, counts: i64) -> i64 {
        // Doubled, because half of an odd number of counts is not whole.
        if 2 * counts.abs() < self.turn_counts {
            return 0;
        }
        -(self.turn_counts - 2 * counts).div_euclid(2 * self.turn_counts)
    }
}
