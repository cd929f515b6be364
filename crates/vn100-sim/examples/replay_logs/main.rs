//! Writes the captures of the `replay-logs` folder.
//!
//! `cargo run -p vn100-sim --example replay_logs -- replay-logs`

mod corruption;
mod packet;

use std::{error::Error, fs, path::PathBuf};

use vn100_sim::{Generator, Message, Profile, UnsupportedRate, capture::write_sentence};

const RATE_HZ: u32 = 40;

/// Runs of damaged lines in `gaps.vnymr`: first line (from 1), number of lines.
const GAPS: [(usize, usize); 8] = [(200, 1), (333, 1), (600, 3), (777, 1), (1000, 40), (1500, 3), (1900, 1), (2200, 1)];

/// Packets sent with each line of `binary-between.bin`: 200 Hz and 40 Hz.
const PACKETS_PER_LINE: u64 = 5;

/// Packets (from 0) of `binary-between.bin` whose payload contains a text like a sentence.
fn has_text(packet: u64) -> bool {
    packet % 40 == 7
}

/// Packets (from 0) of `binary-between.bin` whose CRC is wrong.
const BROKEN_PACKETS: [u64; 2] = [502, 1501];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).ok_or("usage: replay_logs FOLDER")?;
    for Log { name, bytes } in logs()? {
        fs::write(PathBuf::from(&folder).join(name), bytes)?;
    }
    Ok(())
}

/// A capture of the folder.
pub(crate) struct Log {
    pub(crate) name: &'static str,
    pub(crate) bytes: Vec<u8>,
}

/// All captures.
pub(crate) fn logs() -> Result<[Log; 4], UnsupportedRate> {
    Ok([
        Log { name: "clean-minute.vnymr", bytes: lines(1, 60)?.concat() },
        Log { name: "corrupted.vnymr", bytes: corruption::corrupted(lines(2, 20)?) },
        Log { name: "gaps.vnymr", bytes: gaps(lines(3, 60)?) },
        Log { name: "binary-between.bin", bytes: binary_between(4, 10)? },
    ])
}

fn generator(seed: u64) -> Result<Generator, UnsupportedRate> {
    Generator::new(&Profile::lab3(), RATE_HZ, seed)
}

fn write_ymr(line: &mut Vec<u8>, row: &[f32; 12]) {
    if let Some(message) = Message::named("VNYMR") {
        write_sentence(line, message, row, [0.0; 2], 1.0 / f64::from(RATE_HZ));
    }
}

/// The sentences of a good record.
fn lines(seed: u64, duration_s: u32) -> Result<Vec<Vec<u8>>, UnsupportedRate> {
    let mut generator = generator(seed)?;
    let line = |_| {
        let mut line = Vec::new();
        write_ymr(&mut line, &generator.next_row());
        line
    };
    Ok((0..duration_s * RATE_HZ).map(line).collect())
}

/// Runs of lines with a wrong check digit: gaps of known length in a record without time stamps.
fn gaps(mut lines: Vec<Vec<u8>>) -> Vec<u8> {
    for (first, length) in GAPS {
        for line in &mut lines[first - 1..][..length] {
            corruption::wrong_check_digit(line);
        }
    }
    lines.concat()
}

/// Packets at 200 Hz between sentences at 40 Hz; packet and sentence of one instant show the same
/// values, the packet first, and the four packets after them repeat these.
fn binary_between(seed: u64, duration_s: u32) -> Result<Vec<u8>, UnsupportedRate> {
    let mut generator = generator(seed)?;
    let mut bytes = Vec::new();
    let mut number = 0;
    for _ in 0..duration_s * RATE_HZ {
        let row = generator.next_row();
        let mut packets = Vec::new();
        for _ in 0..PACKETS_PER_LINE {
            let text = has_text(number).then_some(b"$VNYMR,+052.267*00\r\n\xFA\x01$\n");
            let mut packet = packet::packet(number, &row, text);
            if BROKEN_PACKETS.contains(&number) {
                packet::break_crc(&mut packet);
            }
            packets.push(packet);
            number += 1;
        }
        bytes.extend_from_slice(&packets[0]);
        write_ymr(&mut bytes, &row);
        bytes.extend(packets[1..].concat());
    }
    Ok(bytes)
}
