//! Every corruption that a serial line can cause, each at a fixed line.
#![expect(clippy::ptr_arg, reason = "the corruptions of the table have one type")]

use super::packet::crc16;

/// Damage to one line.
type Corruption = fn(&mut Vec<u8>);

/// The corrupted lines (from 1) of the 800, and their corruptions. Line ends belong to their line.
const CASES: &[(usize, Corruption)] = &[
    (1, junk_before),
    (40, flipped_bit),
    (80, two_flipped_bits),
    (120, lost_byte),
    (160, extra_byte),
    (200, lost_tail_and_line_end),
    (201, lost_head),
    (240, cut_short),
    (280, dollar_inside),
    (320, no_checksum),
    (340, check_digits_xx),
    (360, wrong_crc16),
    (380, right_crc16),
    (400, acceleration_out_of_range),
    (420, eleven_fields),
    (440, nan_field),
    (460, long_line_without_end),
    (480, junk_before),
    (500, false_packet_before),
    (520, byte_not_ascii_inside),
    (540, only_line_feed),
    (560, only_carriage_return),
    (580, bit_6_flipped_everywhere),
    (600, wrong_check_digit),
    (800, cut_short),
];

/// The record with every corruption in its place.
pub(crate) fn corrupted(mut lines: Vec<Vec<u8>>) -> Vec<u8> {
    for (number, corrupt) in CASES {
        corrupt(&mut lines[number - 1]);
    }
    lines.concat()
}

/// Length of `*HH` CR LF.
const TAIL: usize = 5;

/// The place of the last whole digit of the yaw: `$VNYMR,+052.267`.
const YAW_DIGIT: usize = 10;

/// One digit becomes another. Rejected: checksum.
fn flipped_bit(line: &mut Vec<u8>) {
    line[YAW_DIGIT] ^= 0x01;
}

/// The same bit of two digits: the XOR passes, but `p`..`y` are no digits. Rejected: grammar.
fn two_flipped_bits(line: &mut Vec<u8>) {
    line[YAW_DIGIT] ^= 0x40;
    line[YAW_DIGIT + 2] ^= 0x40;
}

/// A digit is lost, the number stays a number. Rejected: checksum.
fn lost_byte(line: &mut Vec<u8>) {
    line.remove(YAW_DIGIT);
}

/// One digit too many, the number stays a number. Rejected: checksum.
fn extra_byte(line: &mut Vec<u8>) {
    line.insert(YAW_DIGIT, b'7');
}

/// With [`lost_head`] on the next line: bytes lost across the line end splice two lines into one.
/// Rejected, once for both lines: checksum.
fn lost_tail_and_line_end(line: &mut Vec<u8>) {
    line.truncate(70);
}

/// The second half of [`lost_tail_and_line_end`].
fn lost_head(line: &mut Vec<u8>) {
    line.drain(..40);
}

/// The line stops; the next `$`, or the end of the file, ends it. Rejected: truncated.
fn cut_short(line: &mut Vec<u8>) {
    line.truncate(60);
}

/// A byte in the middle turns into `$`. Rejected, twice: the part before it is truncated, the part
/// after it fails the checksum.
fn dollar_inside(line: &mut Vec<u8>) {
    line[60] = b'$';
}

/// No `*` and no check digits. Rejected: unchecked.
fn no_checksum(line: &mut Vec<u8>) {
    let start = line.len() - TAIL;
    line.drain(start..start + 3);
}

/// `*XX`, the placeholder allowed only in commands. Rejected: checksum.
fn check_digits_xx(line: &mut Vec<u8>) {
    replace_check(line, "XX");
}

/// Four check digits, but of another line. Rejected: checksum.
fn wrong_crc16(line: &mut Vec<u8>) {
    let crc = crc16(body(line)) ^ 0x0100;
    replace_check(line, &format!("{crc:04X}"));
}

/// The other checksum that the sensor can be set to. Good.
fn right_crc16(line: &mut Vec<u8>) {
    let crc = crc16(body(line));
    replace_check(line, &format!("{crc:04X}"));
}

/// Acceleration x, six times the range of the sensor, with the correct checksum. Rejected: range.
fn acceleration_out_of_range(line: &mut Vec<u8>) {
    replace_field(line, 7, Some("+999.000"));
}

/// One field less, with the correct checksum. Rejected: grammar.
fn eleven_fields(line: &mut Vec<u8>) {
    replace_field(line, 12, None);
}

/// A field that some float parsers accept, with the correct checksum. Rejected: grammar.
fn nan_field(line: &mut Vec<u8>) {
    replace_field(line, 11, Some("nan"));
}

/// 400 printable bytes, no line end. Rejected: too long, once; the search continues after its `$`.
fn long_line_without_end(line: &mut Vec<u8>) {
    *line = b"$VNYMR,".iter().chain(b"+000.000,".iter().cycle()).take(400).copied().collect();
}

/// Bytes of another baud rate before a line, without a loss. Good; the eight bytes are skipped.
fn junk_before(line: &mut Vec<u8>) {
    line.splice(..0, *b"\x00\xFE\x80\xC3\x9F\xFF\x7F\xE6");
}

/// The head of a packet, but a line in place of its payload. Good; the four bytes are skipped.
fn false_packet_before(line: &mut Vec<u8>) {
    line.splice(..0, *b"\xFA\x01\x39\x07");
}

/// Bit 7 of a digit. Rejected: truncated there; the rest of the line is skipped.
fn byte_not_ascii_inside(line: &mut Vec<u8>) {
    line[YAW_DIGIT] ^= 0x80;
}

/// A line end as some adapters rewrite it. Good.
fn only_line_feed(line: &mut Vec<u8>) {
    line.remove(line.len() - 2);
}

/// The other half of a line end. Good.
fn only_carriage_return(line: &mut Vec<u8>) {
    line.pop();
}

/// Bit 6 of every byte after `$`: letters become control characters, digits letters. Rejected:
/// truncated right after `$`; the rest of the line is skipped.
fn bit_6_flipped_everywhere(line: &mut Vec<u8>) {
    for byte in &mut line[1..] {
        *byte ^= 0x40;
    }
}

/// The last check digit is changed. Rejected: checksum.
pub(crate) fn wrong_check_digit(line: &mut Vec<u8>) {
    let digit = line.len() - TAIL + 2;
    line[digit] = if line[digit] == b'0' { b'1' } else { b'0' };
}

/// The bytes that the checksum covers.
fn body(line: &[u8]) -> &[u8] {
    &line[1..line.len() - TAIL]
}

fn replace_check(line: &mut Vec<u8>, digits: &str) {
    let start = line.len() - TAIL + 1;
    line.splice(start..start + 2, digits.bytes());
}

/// Another text for a field (0 is the header), or no such field; the checksum is corrected.
fn replace_field(line: &mut Vec<u8>, index: usize, text: Option<&str>) {
    let mut fields: Vec<&[u8]> = body(line).split(|&byte| byte == b',').collect();
    match text {
        Some(text) => fields[index] = text.as_bytes(),
        None => _ = fields.remove(index),
    }
    let body = fields.join(&b',');
    let check = body.iter().fold(0, |xor, byte| xor ^ byte);
    *line = [b"$", body.as_slice(), format!("*{check:02X}\r\n").as_bytes()].concat();
}
