//! The cost of a line, in nanoseconds of this thread and relative to a loop over nom's `double`.
//!
//! The kernels take turns, so that a slow machine slows all of them; the median of the rounds
//! counts.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

#[path = "../../../benches/figures.rs"]
mod figures;

use std::{fmt::Write as _, hint::black_box};

use nom::{
    IResult, Parser, bytes::complete::tag, character::complete::char, number::complete::double, sequence::preceded,
};
use rustix::time::{ClockId, clock_gettime};
use vn100_protocol::{
    Decoder, Item, Options, crc16,
    stream::{Batch, ReadOptions, SampleReader},
    xor8,
};

const LINES: usize = 4_000;
const ROUNDS: usize = 41;

/// Processes a buffer of lines and returns a number that depends on all of it: for a parser, the
/// sum of its counts or values.
type Kernel = fn(&[u8]) -> f64;

fn main() {
    let usual = capture(usual_line);
    let inertial = capture(inertial_line);
    let other_widths = capture(line_of_other_widths);
    let packets = packets();
    let kernels: [(&str, &[u8], Kernel); 10] = [
        ("bare read", &usual, read),
        ("decoder, usual lines", &usual, decode),
        ("decoder, usual $VNIMU", &inertial, decode),
        ("decoder, other widths", &other_widths, decode),
        ("nom double, usual lines", &usual, nom_double),
        ("nom double, other widths", &other_widths, nom_double),
        ("copy of packets", &packets, copy),
        ("crc of packets", &packets, crc),
        ("frames of packets", &packets, frames),
        ("rows of packets", &packets, rows),
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
        println!("{name:<26}{ns:>9.1}{:>24.3}", ns / medians[4]);
        figures::record("parsing", name, &[("ns each", format!("{ns:.1}"))]);
    }
    let (ours, nom) = (medians[1], medians[4]);
    figures::record(
        "peers",
        "a sentence, `double` of nom",
        &[
            ("vn100", format!("{ours:.1} ns")),
            ("the other", format!("{nom:.1} ns")),
            ("ratio", format!("{:.1}", nom / ours)),
        ],
    );
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
    line(noise, "VNYMR", forms.into_iter().flat_map(|form| [form; 3]))
}

fn inertial_line(noise: &mut Noise) -> String {
    let forms = [(6_000, 8, 4), (20_000, 7, 3), (3_000, 10, 6)];
    line(noise, "VNIMU", forms.into_iter().flat_map(|form| [form; 3]).chain([(400, 5, 1), (110_000, 10, 3)]))
}

/// A line of numbers with a largest count, a width and decimals each.
fn line(noise: &mut Noise, message: &str, forms: impl Iterator<Item = (i32, usize, usize)>) -> String {
    let mut body = message.to_owned();
    for (limit, width, decimals) in forms {
        let value = f64::from(noise.within(limit)) / 10_f64.powi(decimals as i32);
        write!(body, ",{value:+0width$.decimals$}").unwrap();
    }
    format!("${body}*{:02X}\r\n", xor8(body.as_bytes()))
}

/// Packets of 44 bytes: device time, acceleration, angular rate, temperature.
fn packets() -> Vec<u8> {
    let mut noise = Noise(1);
    let packet = |number: u64| {
        let mut packet = vec![0xFA, 0x05, 0x01, 0x00, 0x1C, 0x00];
        packet.extend((1_000_000_000 + number * 1_250_000).to_le_bytes());
        let values = [0, 1, 2, 3, 4, 5, 6].map(|_| noise.within(20_000) as f32 / 1000.0);
        packet.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        packet.extend(crc16(&packet[1..]).to_be_bytes());
        packet
    };
    (0..LINES as u64).flat_map(packet).collect()
}

fn copy(bytes: &[u8]) -> f64 {
    black_box(bytes.to_vec()).len() as f64
}

fn crc(bytes: &[u8]) -> f64 {
    bytes.chunks(44).map(|packet| crc16(&packet[1..])).fold(0, |sum, crc| sum ^ crc).into()
}

fn frames(bytes: &[u8]) -> f64 {
    let mut decoder = Decoder::new(Options::default());
    let mut length = 0;
    decoder.push(bytes, |item| {
        if let Item::Packet(packet) = item {
            length += packet.raw.len();
        }
    });
    assert_eq!(length, bytes.len());
    length as f64
}

/// The path of a capture: batches of counts and device times.
fn rows(bytes: &[u8]) -> f64 {
    let mut reader = SampleReader::new(ReadOptions::default());
    reader.push(bytes, None);
    let batches = reader.take_batches();
    assert_eq!(batches.iter().map(Batch::row_count).sum::<usize>(), LINES);
    batches.iter().flat_map(|batch| &batch.counts).map(|&count| i64::from(count)).sum::<i64>() as f64
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
