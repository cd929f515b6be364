//! Values as bytes: little endian, each integer with as many bytes as its value needs. Reading
//! gives exactly what was written, to the bit.
//!
//! A type is given its form by [`encoded!`], or implements [`Encoded`] itself. A [`ByteReader`]
//! reads bytes of any origin: each value is checked against the range that sums have, each list
//! against the bytes that are left, and no more memory is allocated than for those.
//!
//! ```
//! use state_bytes::{ByteReader, Encoded};
//!
//! #[derive(Debug, PartialEq)]
//! struct Mean {
//!     count: u64,
//!     sum: i128,
//! }
//! state_bytes::encoded!(Mean { count, sum } if |mean| mean.count > 0);
//!
//! let mut bytes = Vec::new();
//! Mean { count: 2, sum: -7 }.encode(&mut bytes);
//! assert_eq!(bytes, [2, 13]);
//! assert_eq!(Mean::decode(&mut ByteReader::new(&bytes)), Ok(Mean { count: 2, sum: -7 }));
//! assert!(Mean::decode(&mut ByteReader::new(&[0, 13])).is_err());
//! ```

use std::{collections::BTreeMap, fmt, ops::Range, time::Duration};

use ethnum::I256;

/// Why bytes are not those of a sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadEncoding {
    /// The bytes end too early.
    Truncated,
    /// A value is none that a sum can have, or two values contradict each other.
    Contradictory,
}

impl fmt::Display for BadEncoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Truncated => "the bytes end before the state does",
            Self::Contradictory => "the bytes hold a value that no state has",
        })
    }
}

impl std::error::Error for BadEncoding {}

/// A type with a form in bytes.
pub trait Encoded: Sized {
    /// Appends the form of this value to `out`.
    fn encode(&self, out: &mut Vec<u8>);

    /// Reads a value from the front of `input`.
    ///
    /// # Errors
    /// [`BadEncoding`] when the bytes end too early, or hold what no value of this type can be.
    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding>;
}

/// Reads bytes from the front to the end.
#[derive(Clone, Copy, Debug)]
pub struct ByteReader<'a> {
    rest: &'a [u8],
}

impl<'a> ByteReader<'a> {
    /// A reader of these bytes.
    #[must_use]
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// Number of bytes that are left.
    #[must_use]
    pub const fn left(&self) -> usize {
        self.rest.len()
    }

    /// The next `length` bytes, as they are.
    ///
    /// # Errors
    /// [`BadEncoding::Truncated`] when fewer bytes are left.
    pub fn take(&mut self, length: usize) -> Result<&'a [u8], BadEncoding> {
        let (taken, rest) = self.rest.split_at_checked(length).ok_or(BadEncoding::Truncated)?;
        self.rest = rest;
        Ok(taken)
    }

    /// The next number, as [`encode_hash`] has written it.
    ///
    /// # Errors
    /// [`BadEncoding::Truncated`] when fewer than its bytes are left.
    pub fn hash(&mut self) -> Result<u64, BadEncoding> {
        let bytes = self.take(8)?;
        Ok(bytes.iter().rev().fold(0, |hash, byte| hash << 8 | u64::from(*byte)))
    }

    /// Seven bits a byte, the lowest first, as few bytes as there are.
    fn varint(&mut self) -> Result<u128, BadEncoding> {
        let mut value = 0_u128;
        for shift in (0..u128::BITS).step_by(7) {
            let byte = self.take(1)?[0];
            let bits = u128::from(byte & 0x7F);
            let is_last = byte < 0x80;
            if (bits << shift) >> shift != bits || is_last && bits == 0 && shift > 0 {
                return Err(BadEncoding::Contradictory);
            }
            value |= bits << shift;
            if is_last {
                return Ok(value);
            }
        }
        Err(BadEncoding::Contradictory)
    }
}

/// Appends all 64 bits of a number that is not a count.
pub fn encode_hash(hash: u64, out: &mut Vec<u8>) {
    out.extend_from_slice(&hash.to_le_bytes());
}

/// An error, [`BadEncoding::Contradictory`], unless `holds`.
pub fn check(holds: bool) -> Result<(), BadEncoding> {
    if holds { Ok(()) } else { Err(BadEncoding::Contradictory) }
}

/// The form of a structure: its fields, in this order, and what holds of them.
#[macro_export]
macro_rules! encoded {
    ($(@[$($generics:tt)*])? $type:ty { $($field:ident),+ $(,)? } $(if |$value:ident| $holds:expr)?) => {
        impl $(<$($generics)*>)? $crate::Encoded for $type {
            fn encode(&self, out: &mut Vec<u8>) {
                let Self { $($field),+ } = self;
                $($crate::Encoded::encode($field, out);)+
            }

            fn decode(input: &mut $crate::ByteReader<'_>) -> Result<Self, $crate::BadEncoding> {
                $(let $field = $crate::Encoded::decode(input)?;)+
                let decoded = Self { $($field),+ };
                $(let $value = &decoded; $crate::check($holds)?;)?
                Ok(decoded)
            }
        }
    };
    // a value without fields: its place in the list
    ($type:ty = $($case:path),+ $(,)?) => {
        impl $crate::Encoded for $type {
            fn encode(&self, out: &mut Vec<u8>) {
                let place = [$($case),+].iter().position(|case| case == self).unwrap_or_default();
                out.push(place as u8);
            }

            fn decode(input: &mut $crate::ByteReader<'_>) -> Result<Self, $crate::BadEncoding> {
                let place = usize::from(input.take(1)?[0]);
                [$($case),+].get(place).copied().ok_or($crate::BadEncoding::Contradictory)
            }
        }
    };
}

fn encode_varint(mut value: u128, out: &mut Vec<u8>) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

/// Unsigned numbers, with the largest that a sum has: there is room to add some.
macro_rules! unsigned {
    ($($type:ty: $most:expr),+) => {$(
        impl Encoded for $type {
            fn encode(&self, out: &mut Vec<u8>) {
                encode_varint(*self as u128, out);
            }

            fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
                let value = input.varint()?;
                check(value <= $most as u128)?;
                Ok(value as Self)
            }
        }
    )+};
}

/// 0, -1, 1, -2, ... as 0, 1, 2, 3, ...
macro_rules! signed {
    ($($type:ty: $most:expr),+) => {$(
        impl Encoded for $type {
            fn encode(&self, out: &mut Vec<u8>) {
                let wide = *self as i128;
                encode_varint((wide << 1 ^ wide >> 127) as u128, out);
            }

            fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
                let folded = input.varint()?;
                let value = (folded >> 1) as i128 ^ -((folded & 1) as i128);
                check(value.unsigned_abs() <= $most as u128)?;
                Self::try_from(value).map_err(|_| BadEncoding::Contradictory)
            }
        }
    )+};
}

unsigned!(u8: u8::MAX, u16: u16::MAX, u32: u32::MAX, u64: 1_u64 << 60, usize: 1_u64 << 48, u128: u128::MAX);
signed!(i32: 1_u64 << 31, i64: 1_u64 << 61, i128: 1_u128 << 120);

impl Encoded for I256 {
    fn encode(&self, out: &mut Vec<u8>) {
        let (high, low) = self.into_words();
        high.encode(out);
        (low as u128).encode(out);
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        let high = i128::decode(input)?;
        check(high.unsigned_abs() <= 1 << 60)?;
        Ok(Self::from_words(high, u128::decode(input)? as i128))
    }
}

impl Encoded for f64 {
    fn encode(&self, out: &mut Vec<u8>) {
        encode_hash(self.to_bits(), out);
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        let value = Self::from_bits(input.hash()?);
        check(value.is_finite())?;
        Ok(value)
    }
}

impl Encoded for bool {
    fn encode(&self, out: &mut Vec<u8>) {
        out.push(u8::from(*self));
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        match input.take(1)?[0] {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(BadEncoding::Contradictory),
        }
    }
}

impl Encoded for Duration {
    fn encode(&self, out: &mut Vec<u8>) {
        self.as_nanos().encode(out);
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        Ok(Self::from_nanos(u64::decode(input)?))
    }
}

impl Encoded for String {
    fn encode(&self, out: &mut Vec<u8>) {
        self.len().encode(out);
        out.extend_from_slice(self.as_bytes());
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        let length = usize::decode(input)?;
        let bytes = input.take(length)?;
        Ok(std::str::from_utf8(bytes).map_err(|_| BadEncoding::Contradictory)?.to_owned())
    }
}

impl<T: Encoded> Encoded for Option<T> {
    fn encode(&self, out: &mut Vec<u8>) {
        self.is_some().encode(out);
        if let Some(value) = self {
            value.encode(out);
        }
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        bool::decode(input)?.then(|| T::decode(input)).transpose()
    }
}

impl<T: Encoded> Encoded for Vec<T> {
    fn encode(&self, out: &mut Vec<u8>) {
        self.len().encode(out);
        self.iter().for_each(|value| value.encode(out));
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        let length = usize::decode(input)?;
        // no element has less than a byte
        if length > input.left() {
            return Err(BadEncoding::Truncated);
        }
        // grows with what is there, and not with what is claimed
        let mut values = Self::new();
        for _ in 0..length {
            values.push(T::decode(input)?);
        }
        Ok(values)
    }
}

impl<K: Encoded + Ord, V: Encoded> Encoded for BTreeMap<K, V> {
    fn encode(&self, out: &mut Vec<u8>) {
        self.len().encode(out);
        for (key, value) in self {
            key.encode(out);
            value.encode(out);
        }
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        let length = usize::decode(input)?;
        let mut map = Self::new();
        for _ in 0..length {
            let key = K::decode(input)?;
            check(map.last_key_value().is_none_or(|(last, _)| *last < key))?;
            map.insert(key, V::decode(input)?);
        }
        Ok(map)
    }
}

impl<T: Encoded, const N: usize> Encoded for [T; N] {
    fn encode(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|value| value.encode(out));
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        let values: Result<Vec<T>, _> = (0..N).map(|_| T::decode(input)).collect();
        values?.try_into().map_err(|_| BadEncoding::Contradictory)
    }
}

impl<T: Encoded> Encoded for Range<T> {
    fn encode(&self, out: &mut Vec<u8>) {
        self.start.encode(out);
        self.end.encode(out);
    }

    fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
        Ok(T::decode(input)?..T::decode(input)?)
    }
}

macro_rules! tuples {
    ($(($($part:ident $place:tt),+)),+) => {$(
        impl<$($part: Encoded),+> Encoded for ($($part,)+) {
            fn encode(&self, out: &mut Vec<u8>) {
                $(self.$place.encode(out);)+
            }

            fn decode(input: &mut ByteReader<'_>) -> Result<Self, BadEncoding> {
                Ok(($($part::decode(input)?,)+))
            }
        }
    )+};
}

tuples!((A 0, B 1), (A 0, B 1, C 2));

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn again<T: Encoded>(value: &T) -> Result<T, BadEncoding> {
        let mut bytes = Vec::new();
        value.encode(&mut bytes);
        let mut input = ByteReader::new(&bytes);
        let decoded = T::decode(&mut input)?;
        assert_eq!(input.left(), 0);
        Ok(decoded)
    }

    proptest! {
        #[test]
        fn what_is_read_is_what_was_written(
            wide in any::<u128>(),
            sum in -(1_i128 << 120)..=1_i128 << 120,
            block in -(1_i64 << 61)..=1_i64 << 61,
            count in any::<i32>(),
            list in proptest::collection::vec(any::<Option<u32>>(), 0..9),
            text in ".*",
        ) {
            prop_assert_eq!(again(&wide), Ok(wide));
            prop_assert_eq!(again(&(sum, block, count)), Ok((sum, block, count)));
            prop_assert_eq!(again(&(I256::from(sum) * I256::from(block))), Ok(I256::from(sum) * I256::from(block)));
            prop_assert_eq!(again(&list), Ok(list.clone()));
            prop_assert_eq!(again(&text), Ok(text.clone()));
        }

        #[test]
        fn any_bytes_give_a_value_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..40)) {
            let _ = Vec::<Vec<(u64, i128, I256)>>::decode(&mut ByteReader::new(&bytes));
            let _ = BTreeMap::<String, Option<f64>>::decode(&mut ByteReader::new(&bytes));
            let _ = u128::decode(&mut ByteReader::new(&bytes));
        }
    }

    #[test]
    fn a_number_has_one_form() {
        assert_eq!(u64::decode(&mut ByteReader::new(&[0x81, 0x00])), Err(BadEncoding::Contradictory));
        assert_eq!(u64::decode(&mut ByteReader::new(&[0x81])), Err(BadEncoding::Truncated));
        assert_eq!(u8::decode(&mut ByteReader::new(&[0x80, 0x02])), Err(BadEncoding::Contradictory));
        assert_eq!(Vec::<u8>::decode(&mut ByteReader::new(&[0xFF, 0xFF, 0x01])), Err(BadEncoding::Truncated));
    }
}
