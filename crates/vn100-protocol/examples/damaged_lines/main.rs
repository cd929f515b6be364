//! Lines with flipped bits between good ones: the number of corrupt values that pass, and of good
//! lines that are lost.
//!
//! `cargo run --release -p vn100-protocol --example damaged_lines`, with the number of damaged
//! lines as an argument if it is not ten million. The theoretical leak is that of XOR-8 and the
//! grammar; the measured leak may only be smaller, because of the limits of values.
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

mod theory;

use vn100_protocol::{Decoder, Item, Options, xor8};

/// Bits flipped in one line.
const FLIPS: [u32; 5] = [1, 2, 3, 4, 8];

/// Bytes of a line, all of them the same.
const LENGTH: usize = 122;

/// Pairs of a damaged and a good line that are decoded at once.
const PAIRS: u64 = 1000;

fn main() {
    let lines = std::env::args().nth(1).and_then(|lines| lines.parse().ok()).unwrap_or(10_000_000);
    println!("flips |    lines | corrupt values let in |  of all | by theory | let in unharmed | good lines lost");
    for flips in FLIPS {
        let found = damage(lines / FLIPS.len() as u64, flips);
        let of_all = found.corrupt as f64 / found.damaged as f64;
        println!(
            "{flips:5} | {:8} | {:21} | {of_all:7.1e} | {:9.1e} | {:15} | {:15}",
            found.damaged, found.corrupt, found.theory, found.unharmed, found.lost
        );
    }
}

/// The fates of the lines.
#[derive(Debug, Default)]
struct Found {
    damaged: u64,
    /// Damaged lines that were read with other values than sent.
    corrupt: u64,
    /// Damaged lines that were read as sent: the damage was after the checksum, or changed the sign
    /// of a zero.
    unharmed: u64,
    /// Good lines that were not read as sent.
    lost: u64,
    /// Chance of a damaged line to pass the checksum and the grammar.
    theory: f64,
}

/// Sends about `lines` lines with this many flipped bits, each followed by a good line.
fn damage(lines: u64, flips: u32) -> Found {
    let mut random = Random(flips.into());
    let mut found = Found::default();
    let mut decoder = Decoder::new(Options::default());
    let batches = lines.div_ceil(PAIRS);
    for _ in 0..batches {
        let sent: Vec<[i32; 12]> = (0..2 * PAIRS).map(|_| random.counts()).collect();
        let mut bytes: Vec<u8> = sent.iter().flat_map(|counts| line(counts).into_bytes()).collect();
        found.theory += theory::chance_to_pass(&bytes[..LENGTH], flips) / batches as f64;
        bytes.chunks_mut(2 * LENGTH).for_each(|pair| random.flip(&mut pair[..LENGTH], flips));
        found.damaged += PAIRS;
        found.lost += PAIRS;
        let mut at = 0;
        // a batch is a stream of its own
        while let (consumed, Some(item)) = decoder.next(&bytes[at..], true) {
            at += consumed;
            let Item::Sample(sample) = item else { continue };
            let line = (at - 1) / LENGTH;
            match (line % 2, sample.counts() == sent[line]) {
                (0, true) => found.unharmed += 1,
                (_, false) => found.corrupt += 1,
                (_, true) => found.lost -= 1,
            }
        }
    }
    found
}

/// The line as the sensor prints it.
fn line(counts: &[i32; 12]) -> String {
    let forms = [(8, 3), (8, 4), (7, 3), (10, 6)].into_iter().flat_map(|form| [form; 3]);
    let body = counts.iter().zip(forms).fold("VNYMR".to_owned(), |body, (&count, (width, decimals))| {
        let value = f64::from(count) / 10_f64.powi(decimals as i32);
        format!("{body},{value:+0width$.decimals$}")
    });
    format!("${body}*{:02X}\r\n", xor8(body.as_bytes()))
}

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % limit
    }

    /// The counts of a sensor at rest.
    fn counts(&mut self) -> [i32; 12] {
        const AT_REST: [i32; 12] = [52_267, 265, -4, 2263, 1184, 624, 49, -9, -9722, 0, 0, 0];
        const SPREAD: [i32; 12] = [20, 20, 20, 40, 40, 40, 60, 60, 60, 3000, 3000, 3000];
        let mut counts = AT_REST;
        for (count, spread) in counts.iter_mut().zip(SPREAD) {
            *count += self.below(2 * spread as u64 + 1) as i32 - spread;
        }
        counts
    }

    /// Flips this many different bits.
    fn flip(&mut self, line: &mut [u8], flips: u32) {
        let mut flipped = Vec::new();
        while flipped.len() < flips as usize {
            let bit = self.below(8 * line.len() as u64) as usize;
            if !flipped.contains(&bit) {
                flipped.push(bit);
                line[bit / 8] ^= 1 << (bit % 8);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damage_costs_its_own_lines_and_is_accepted_as_often_as_predicted() {
        for flips in FLIPS {
            let found = damage(40_000, flips);
            assert_eq!(found.lost, 0, "{flips} flips");
            let expected = found.theory * found.damaged as f64;
            let corrupt = found.corrupt as f64;
            assert!(corrupt <= expected + 5.0 * expected.sqrt(), "{flips} flips: {corrupt} of {expected}");
            // the range rejects some, and most pass it
            assert!(corrupt >= 0.5 * expected - 5.0 * expected.sqrt(), "{flips} flips: {corrupt} of {expected}");
        }
    }
}
