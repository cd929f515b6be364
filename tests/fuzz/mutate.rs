//! Seeds with small changes, the same in every run.

#[rustfmt::skip]
/// Pieces of the formats: more likely to have an effect than random bytes.
const TOKENS: [&[u8]; 24] = [
    b"$", b"*", b",", b"\r\n", b"\n", b"\0", b"\xFA", b"\xFA\x01\x08\x00", b"$VNYMR,", b"$VNIMU,", b"-", b"+", b".", b"99999999",
    b"-2147483648", b"18446744073709551615", b"9223372036854775807", b"1e308", b"nan", b"%", b"=", b"\"", b"\x1f\x8b", b"\xff\xff\xff\xff",
];

/// The longest input.
const LONGEST: usize = 6000;

/// Makes inputs from seeds.
pub(crate) struct Mutator<'a> {
    state: u64,
    seeds: &'a [Vec<u8>],
}

impl<'a> Mutator<'a> {
    /// The same `seed` and `seeds` give the same inputs.
    pub(crate) fn new(seed: u64, seeds: &'a [Vec<u8>]) -> Self {
        Self { state: seed, seeds }
    }

    /// One of the seeds with one to six changes.
    pub(crate) fn next_input(&mut self) -> Vec<u8> {
        let mut input = self.seed().to_vec();
        for _ in 0..=self.below(6) {
            self.change(&mut input);
        }
        input.truncate(LONGEST);
        input
    }

    fn change(&mut self, input: &mut Vec<u8>) {
        let from = self.below(input.len() + 1);
        let to = (from + 1 + self.below(40)).min(input.len());
        match self.below(8) {
            0 if from < input.len() => input[from] ^= 1 << self.below(8),
            1 if from < input.len() => input[from] = self.below(256) as u8,
            2 => drop(input.drain(from..to)),
            3 => {
                let again = input[from..to].to_vec();
                input.splice(from..from, again);
            }
            4 => {
                let other = self.seed();
                let start = self.below(other.len() + 1);
                let piece = &other[start..(start + self.below(300)).min(other.len())];
                input.splice(from..to, piece.iter().copied());
            }
            5 if self.below(4) == 0 => input.truncate(from),
            _ => {
                let token = TOKENS[self.below(TOKENS.len())];
                input.splice(from..from, token.iter().copied());
            }
        }
    }

    fn seed(&mut self) -> &'a [u8] {
        &self.seeds[self.below(self.seeds.len())]
    }

    /// A number below `limit`, which is not 0.
    fn below(&mut self, limit: usize) -> usize {
        // SplitMix64 (Steele, Lea and Flood 2014)
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % limit as u64) as usize
    }
}
