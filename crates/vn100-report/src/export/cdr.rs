//! ROS 2 messages as bytes: plain CDR, little endian (OMG Common Data Representation, version 1).

/// What stands before every message: the encoding, and two bytes of options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A message being written. Each number is aligned to its own size, counted from behind the
/// encapsulation.
pub(super) struct Cdr {
    bytes: Vec<u8>,
}

impl Cdr {
    pub(super) fn new() -> Self {
        Self { bytes: ENCAPSULATION.to_vec() }
    }

    /// `std_msgs/msg/Header`: the time in nanoseconds, and the frame.
    pub(super) fn header(&mut self, stamp_ns: u64, frame: &str) {
        const SECOND_NS: u64 = 1_000_000_000;
        // seconds are an int32 there: enough until 2038
        self.put(&i32::try_from(stamp_ns / SECOND_NS).unwrap_or(i32::MAX).to_le_bytes());
        self.put(&((stamp_ns % SECOND_NS) as u32).to_le_bytes());
        self.put(&(frame.len() as u32 + 1).to_le_bytes());
        self.bytes.extend(frame.as_bytes());
        self.bytes.push(0);
    }

    pub(super) fn floats(&mut self, values: &[f64]) {
        for value in values {
            self.put(&value.to_le_bytes());
        }
    }

    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    fn put(&mut self, number: &[u8]) {
        while !(self.bytes.len() - ENCAPSULATION.len()).is_multiple_of(number.len()) {
            self.bytes.push(0);
        }
        self.bytes.extend(number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_where_their_size_asks() {
        let mut message = Cdr::new();
        message.header(1_500_000_002_000_000_003, "imu");
        message.floats(&[1.0]);
        let bytes = message.into_bytes();
        assert_eq!(bytes[4..8], 1_500_000_002_i32.to_le_bytes());
        assert_eq!(bytes[8..12], 3_u32.to_le_bytes());
        assert_eq!(bytes[12..20], *b"\x04\0\0\0imu\0");
        assert_eq!(bytes[20..28], 1.0_f64.to_le_bytes(), "16 bytes in, no filling");
        let mut padded = Cdr::new();
        padded.header(0, "vn100");
        padded.floats(&[2.0]);
        assert_eq!(padded.into_bytes()[28..36], 2.0_f64.to_le_bytes(), "18 bytes in, filled to 24");
    }
}
