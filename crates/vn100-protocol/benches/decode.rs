//! What a line costs, in nanoseconds of this thread and in ratio to a loop over nom's `double`.
//!
//! The kernels take turns, so that whatever slows the machine down slows all of them; the median of
//! the rounds counts.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use std::{fmt::Write as _, hint::black_box};

use nom::{
    IResult, Parser, bytes::complete::tag, character::complete::char, number::complete::double, sequence::preceded,
};
use rustix::time::{ClockId, clock_gettime};
use vn100_protocol::{Decoder, Item, Options, xor8};

const LINES: usize = 4_000;
const ROUNDS: usize = 41;

/// Does its work over a buffer of lines and returns a number that depends on all of it: for a
/// parser, the sum of its counts or values.
type Kernel = fn(&[u8]) -> f64;

fn main() {
    let usual = capture(usual_line);
    let other_widths = capture(line_of_other_widths);
    let kernels: [(&str, &[u8], Kernel); 5] = [
        ("bare read", &usual, read),
        ("decoder, usual lines", &usual, decode),
        ("decoder, other widths", &other_widths, decode),
        ("nom double, usual lines", &usual, nom_double),
        ("nom double, other widths", &other_widths, nom_double),
    ];
    assert_eq!(decode(&usual), decode(&other_widths));
    assert_eq!(nom_double(&usual), nom_double(&other_widths));

    let mut rounds = kernels.map(|_| Vec::with_capacity(ROUNDS));
    for _ in 0..ROUNDS {
        for ((_, bytes, kernel), times) in kernels.iter().zip(&mut rounds) {
            let before = thread_ns();
            black_box(kernel(black_box(bytes)));
            times.push((thread_ns() - before) as f64 / LINES as f64);
        }
    }
    let medians = rounds.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[ROUNDS / 2]
    });
    println!("{:<26}{:>9}{:>24}", "", "ns/line", "of the nom double loop");
    for ((name, ..), ns) in kernels.iter().zip(medians) {
        println!("{name:<26}{ns:>9.1}{:>24.3}", ns / medians[3]);
    }
}

fn thread_ns() -> i64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

fn capture(line: fn(&mut Noise) -> String) -> Vec<u8> {
    let mut noise = Noise(1);
    (0..LINES).flat_map(|_| line(&mut noise).into_bytes()).collect()
}

/// A linear congruential generator (Knuth's MMIX constants); only its high bits are used.
struct Noise(u64);

impl Noise {
    fn within(&mut self, limit: i32) -> i32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as i32 % (2 * limit + 1) - limit
    }
}

fn usual_line(noise: &mut Noise) -> String {
    let forms = [(180_000, 8, 3), (6_000, 8, 4), (20_000, 7, 3), (3_000, 10, 6)];
    let mut body = "VNYMR".to_owned();
    for (limit, width, decimals) in forms.into_iter().flat_map(|form| [form; 3]) {
        let value = f64::from(noise.within(limit)) / 10_f64.powi(decimals as i32);
        write!(body, ",{value:+0width$.decimals$}").unwrap();
    }
    format!("${body}*{:02X}\r\n", xor8(body.as_bytes()))
}

/// The same values, with one digit more before the point of each acceleration.
fn line_of_other_widths(noise: &mut Noise) -> String {
    let usual = usual_line(noise);
    let fields: Vec<_> = usual[1..usual.len() - 5].split(',').collect();
    let mut body = fields[0].to_owned();
    for (index, field) in fields.iter().enumerate().skip(1) {
        let (sign, digits) = field.split_at(1);
        let zero = if (7..10).contains(&index) { "0" } else { "" };
        write!(body, ",{sign}{zero}{digits}").unwrap();
    }
    format!("${body}*{:02X}\r\n", xor8(body.as_bytes()))
}

fn read(bytes: &[u8]) -> f64 {
    let (words, rest) = bytes.as_chunks::<8>();
    let folded = words.iter().fold(rest.len() as u64, |acc, word| acc ^ u64::from_ne_bytes(*word));
    folded as f64
}

fn decode(bytes: &[u8]) -> f64 {
    let mut decoder = Decoder::new(Options::default());
    let mut sum = 0;
    let mut lines = 0;
    decoder.push(bytes, |item| {
        if let Item::Sample(sample) = item {
            sum += sample.counts().iter().map(|&count| i64::from(count)).sum::<i64>();
            lines += 1;
        }
    });
    assert_eq!(lines, LINES);
    sum as f64
}

fn nom_double(mut bytes: &[u8]) -> f64 {
    let mut sum = 0.0;
    while !bytes.is_empty() {
        let end = memchr::memchr(b'\n', bytes).unwrap();
        let body = &bytes[1..end - 4];
        let digits = u8::from_str_radix(std::str::from_utf8(&bytes[end - 3..end - 1]).unwrap(), 16).unwrap();
        assert_eq!(xor8(body), digits);
        let (_, values) = ymr_of_doubles(body).unwrap();
        sum += values.iter().sum::<f64>();
        bytes = &bytes[end + 1..];
    }
    sum
}

fn ymr_of_doubles(body: &[u8]) -> IResult<&[u8], [f64; 12]> {
    let (mut rest, _) = tag(&b"VNYMR"[..]).parse(body)?;
    let mut values = [0.0; 12];
    for value in &mut values {
        (rest, *value) = preceded(char(','), double).parse(rest)?;
    }
    Ok((rest, values))
}
