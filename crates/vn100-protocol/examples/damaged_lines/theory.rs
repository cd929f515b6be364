//! The chance that flipped bits of a line pass XOR-8 and a strict grammar.
//!
//! Flips pass if every byte stays of its kind (a digit a digit, a sign a sign, others unchanged),
//! and the changes of all bytes cancel: their XOR, with the change of the number in the check
//! digits, is zero. Counting the ways of `k` flips byte by byte, by the XOR so far and the flips
//! used, gives the chance exactly: ways that change a number, of all ways to choose `k` of the
//! bits.

/// The largest counted number of flips, plus one.
const MOST: usize = 9;

/// The number of ways to use this many flips, for this XOR.
type Ways = Vec<[f64; MOST]>;

/// The chance that `flips` different random bits of a whole `line` leave a line with other numbers
/// that passes.
pub(super) fn chance_to_pass(line: &[u8], flips: u32) -> f64 {
    let flips = flips as usize;
    let bits = 8.0 * line.len() as f64;
    let all: f64 = (0..flips).map(|taken| (bits - taken as f64) / (taken + 1) as f64).product();
    let (body, tail) = line.split_at(line.iter().position(|&byte| byte == b'*').unwrap_or(line.len()));
    let mut ways = nothing_changed();
    body.iter().for_each(|&byte| ways = with_byte(&ways, &changes(byte)));
    // numbers that stay the same do no harm
    ways[0][0] = 0.0;
    for (place, &byte) in tail.iter().enumerate() {
        let changes = match place {
            0 => vec![(0, 0)],
            1 => check_digit_changes(byte, 4),
            2 => check_digit_changes(byte, 0),
            // any other byte ends the line as well
            _ => (0..=u8::MAX).filter(|mask| !is_check_digit(byte ^ mask)).map(|mask| (0, mask.count_ones())).collect(),
        };
        ways = with_byte(&ways, &changes);
    }
    ways[0][flips] / all
}

fn nothing_changed() -> Ways {
    let mut ways = vec![[0.0; MOST]; 256];
    ways[0][0] = 1.0;
    ways
}

/// Adds one byte with these possible changes: each is an XOR and a number of flips.
fn with_byte(ways: &Ways, changes: &[(u8, u32)]) -> Ways {
    let mut with = vec![[0.0; MOST]; 256];
    for &(xor, price) in changes {
        let price = price as usize;
        for before in 0..256 {
            for used in price..MOST {
                with[before ^ usize::from(xor)][used] += ways[before][used - price];
            }
        }
    }
    with
}

/// The bytes that a byte before the `*` can become without breaking the grammar.
fn changes(byte: u8) -> Vec<(u8, u32)> {
    let alike: &[u8] = match byte {
        b'0'..=b'9' => b"0123456789",
        b'+' | b'-' => b"+-",
        _ => return vec![(0, 0)],
    };
    alike.iter().map(|other| (byte ^ other, (byte ^ other).count_ones())).collect()
}

/// The digits that a check digit can become, each with the change of its number.
fn check_digit_changes(digit: u8, shift: u32) -> Vec<(u8, u32)> {
    let value = |digit: u8| if digit <= b'9' { digit - b'0' } else { digit - b'A' + 10 };
    let others = (b'0'..=b'F').filter(|&other| is_check_digit(other));
    others.map(|other| ((value(digit) ^ value(other)) << shift, (digit ^ other).count_ones())).collect()
}

fn is_check_digit(byte: u8) -> bool {
    matches!(byte, b'0'..=b'9' | b'A'..=b'F')
}
