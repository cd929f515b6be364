//! Finds lines that come again: a recording played in a loop, or lines stored twice. A living
//! sensor never repeats a whole line.

/// How many lines are remembered: the first ones, because a loop returns to its beginning.
const WITNESSES: usize = 1024;

/// Twice the witnesses, so that a probe meets an empty slot soon; 16 KiB.
const SLOTS: usize = 2 * WITNESSES;

/// A first look at one bit tells nearly every line from the witnesses: one in 64 goes on to the
/// table. 8 KiB.
const SIEVE_BITS: usize = 64 * WITNESSES;

/// Odd multipliers, one for each pair of channels: the fractional parts of the square roots of 2,
/// 3, 5, 7, 11, 13, 17 and 19.
const MULTIPLIERS: [u64; 8] = [
    0x6a09_e667_f3bc_c909,
    0xbb67_ae85_84ca_a73b,
    0x3c6e_f372_fe94_f82b,
    0xa54f_f53a_5f1d_36f1,
    0x510e_527f_ade6_82d1,
    0x9b05_688c_2b3e_6c1f,
    0x1f83_d9ab_fb41_bd6b,
    0x5be0_cd19_137e_2179,
];

/// Counts the lines that equal, in every channel, one of the first 1024.
#[derive(Debug, Clone)]
pub(crate) struct Repeats {
    sieve: Vec<u64>,
    // fingerprints by open addressing; 0 is an empty slot
    table: Vec<u64>,
    remembered: usize,
    repeated: u64,
}

impl Repeats {
    pub(crate) fn new() -> Self {
        Self { sieve: vec![0; SIEVE_BITS / 64], table: vec![0; SLOTS], remembered: 0, repeated: 0 }
    }

    /// Takes one line. Rows of more than 16 channels are told apart by their first 16.
    pub(crate) fn push(&mut self, counts: &[i32]) {
        let fingerprint = fingerprint(counts);
        let bit = (fingerprint >> 32) as usize % SIEVE_BITS;
        let (word, mask) = (&mut self.sieve[bit / 64], 1 << (bit % 64));
        let seen = *word & mask != 0;
        if !seen && self.remembered == WITNESSES {
            return;
        }
        *word |= mask;
        // the lowest bit is always set
        let mut slot = (fingerprint >> 1) as usize % SLOTS;
        while self.table[slot] != 0 {
            if self.table[slot] == fingerprint {
                self.repeated += 1;
                return;
            }
            slot = (slot + 1) % SLOTS;
        }
        if self.remembered < WITNESSES {
            self.table[slot] = fingerprint;
            self.remembered += 1;
        }
    }

    /// Lines that came again.
    pub(crate) fn repeated(&self) -> u64 {
        self.repeated
    }
}

/// Never zero. Two different rows share one with a probability of about 2^-63.
fn fingerprint(counts: &[i32]) -> u64 {
    let (pairs, odd) = counts.as_chunks::<2>();
    let last = odd.first().map(|&count| [count, 0]);
    let sum = (pairs.iter().chain(&last).zip(MULTIPLIERS)).fold(0_u64, |sum, (&[low, high], multiplier)| {
        let pair = u64::from(high.cast_unsigned()) << 32 | u64::from(low.cast_unsigned());
        sum.wrapping_add(pair.wrapping_mul(multiplier))
    });
    // the low bits choose the slot, and a product's low bits are its weakest
    (sum ^ sum >> 32) | 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn repeated(rows: impl IntoIterator<Item = [i32; 12]>) -> u64 {
        let mut repeats = Repeats::new();
        rows.into_iter().for_each(|row| repeats.push(&row));
        repeats.repeated()
    }

    fn row(i: i32) -> [i32; 12] {
        std::array::from_fn(|channel| (i.wrapping_mul(7919) ^ channel as i32).wrapping_mul(31) % 997)
    }

    #[test]
    fn a_loop_is_counted_from_its_second_pass_on() {
        assert_eq!(repeated((0..449).map(|i| row(i % 163))), 449 - 163);
    }

    #[test]
    fn a_long_loop_shows_by_its_first_lines() {
        assert_eq!(repeated((0..6000).map(|i| [i % 3000; 12])), 1024);
    }

    #[test]
    fn one_differing_channel_is_another_line() {
        for channel in 0..12 {
            let mut other = row(5);
            other[channel] += 1;
            assert_eq!(repeated([row(5), other]), 0, "channel {channel}");
        }
    }

    #[test]
    fn a_line_stored_twice_is_counted_once() {
        assert_eq!(repeated([row(1), row(1), row(2)]), 1);
    }
}
