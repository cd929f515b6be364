//! Takes numbers out of the bytes of a message, step by step.
//!
//! In CDR, <https://www.omg.org/spec/DDSI-RTPS/>, the offset of each number is a multiple of its
//! length, counted from the fifth byte.

use super::{definition::Leaf, structure::Step, topic::Encoding};

/// A value taken from a message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Taken {
    Number(f64),
    /// An integer, which may have no exact float.
    Integer(i64),
    /// A time in nanoseconds.
    Time(i64),
}

impl Taken {
    /// The value as a float; `None` for a time.
    pub(super) const fn number(self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(number),
            Self::Integer(number) => Some(number as f64),
            Self::Time(_) => None,
        }
    }

    /// The value as a time in nanoseconds; a number is a time in units of `in_unit` nanoseconds.
    /// `None` beyond 292 years.
    pub(super) fn nanoseconds(self, in_unit: i64) -> Option<i64> {
        match self {
            Self::Time(at_ns) => Some(at_ns),
            Self::Integer(number) => number.checked_mul(in_unit),
            Self::Number(number) => {
                const MOST_NS: f64 = i64::MAX as f64;
                let at_ns = (number * in_unit as f64).round();
                (-MOST_NS < at_ns && at_ns < MOST_NS).then_some(at_ns as i64)
            }
        }
    }
}

/// Takes the values to their places; `None` if the message ends too early, or its encoding is not
/// supported.
pub(super) fn take(steps: &[Step], encoding: &Encoding, message: &[u8], values: &mut [Taken]) -> Option<()> {
    let mut cursor = match encoding {
        Encoding::Ros1 => Cursor { bytes: message, at: 0, form: Form::Ros1 },
        Encoding::Cdr => {
            let (&[_, form, _, _], bytes) = message.split_first_chunk()?;
            let big_endian = match (message[0], form) {
                (0, 0) => true,
                (0, 1) => false,
                _ => return None,
            };
            Cursor { bytes, at: 0, form: Form::Cdr { big_endian } }
        }
        Encoding::Other(_) => return None,
    };
    cursor.walk(steps, values)
}

#[derive(Clone, Copy)]
enum Form {
    Ros1,
    Cdr { big_endian: bool },
}

struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    form: Form,
}

impl Cursor<'_> {
    fn walk(&mut self, steps: &[Step], values: &mut [Taken]) -> Option<()> {
        for step in steps {
            match step {
                Step::Skip { align, bytes } => self.skip(*align, *bytes)?,
                Step::Unreadable(_) => return None,
                Step::SkipCounted { align, each } => {
                    let count = self.count()?;
                    if count > 0 {
                        self.skip(*align, u64::from(count).checked_mul(*each)?)?;
                    }
                }
                Step::SkipEach { count, steps } => {
                    for _ in 0..count.or_else(|| self.count())? {
                        let before = self.at;
                        self.walk(steps, values)?;
                        // elements without bytes, of any number
                        if self.at == before {
                            break;
                        }
                    }
                }
                Step::Take { place, leaf } => values[*place] = self.leaf(*leaf)?,
            }
        }
        Some(())
    }

    fn leaf(&mut self, leaf: Leaf) -> Option<Taken> {
        Some(match leaf {
            Leaf::Time => {
                // seconds of ROS 1 are unsigned, seconds of ROS 2 are signed
                let seconds = match self.form {
                    Form::Ros1 => self.bits(4)?.cast_signed(),
                    Form::Cdr { .. } => self.signed(4)?,
                };
                Taken::Time(seconds * 1_000_000_000 + self.bits(4)?.cast_signed())
            }
            Leaf::Signed(bytes) => Taken::Integer(self.signed(bytes)?),
            Leaf::Unsigned(bytes) => {
                let number = self.bits(bytes)?;
                i64::try_from(number).map_or(Taken::Number(number as f64), Taken::Integer)
            }
            Leaf::Float32 => Taken::Number(f32::from_bits(self.bits(4)? as u32).into()),
            Leaf::Float64 => Taken::Number(f64::from_bits(self.bits(8)?)),
        })
    }

    fn count(&mut self) -> Option<u32> {
        Some(self.bits(4)? as u32)
    }

    fn signed(&mut self, bytes: u8) -> Option<i64> {
        let unused = 64 - 8 * u32::from(bytes);
        Some(self.bits(bytes)?.cast_signed() << unused >> unused)
    }

    /// The bits of the next number, of eight bytes at most. Inlined, because most callers know its length.
    #[inline(always)]
    fn bits(&mut self, bytes: u8) -> Option<u64> {
        let length = usize::from(bytes);
        self.align(length)?;
        let number = self.bytes.get(self.at..self.at + length)?;
        self.at += length;
        let mut whole = [0; 8];
        whole[..length].copy_from_slice(number);
        if matches!(self.form, Form::Cdr { big_endian: true }) {
            whole[..length].reverse();
        }
        Some(u64::from_le_bytes(whole))
    }

    fn skip(&mut self, align: usize, bytes: u64) -> Option<()> {
        self.align(align)?;
        self.at = self.at.checked_add(usize::try_from(bytes).ok()?)?;
        (self.at <= self.bytes.len()).then_some(())
    }

    fn align(&mut self, to: usize) -> Option<()> {
        if matches!(self.form, Form::Cdr { .. }) {
            self.at = self.at.checked_next_multiple_of(to)?;
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{structure::Structure, topic::Topic};
    use super::*;

    const TEXT: &str = "# a comment\nuint8 KIND=3 # of two\nstring NAME=a # b\nHeader[] spare\nstd_msgs/Empty none\n\
        uint8 flag 1\nstring<=5 note\nint16[<=3] few\nInner[2] inner\nfloat64 x\nwstring behind\n\
        ================================================================================\n\
        MSG: demo_msgs/Inner\nfloat32 y -1.5\n\
        ================================================================================\n\
        MSG: std_msgs/Empty\n\
        ================================================================================\n\
        MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";

    fn taken(encoding: Encoding, message: &[u8]) -> Option<[Taken; 2]> {
        let topic = Topic::new("/demo", "demo_msgs/msg/Demo", encoding.clone(), Some(TEXT));
        let structure = Structure::of(&topic).unwrap().unwrap();
        let places = ["inner[1].y", "x"].map(|path| structure.place(path).unwrap());
        let mut values = vec![Taken::Number(0.0); structure.leaves.len()];
        take(&structure.steps(places).unwrap(), &encoding, message, &mut values)?;
        Some(places.map(|place| values[place]))
    }

    #[test]
    fn numbers_are_at_multiples_of_their_size_only_in_cdr() {
        let found = Some([Taken::Number(2.5), Taken::Number(-7.0)]);
        let numbers = |order: fn(&[u8]) -> Vec<u8>| {
            let number = |bytes: &[u8]| order(bytes);
            let inner = [number(&1.5_f32.to_le_bytes()), number(&2.5_f32.to_le_bytes())].concat();
            (inner, number(&(-7.0_f64).to_le_bytes()), number(&1_u32.to_le_bytes()), number(&2_u32.to_le_bytes()))
        };
        let forwards = |bytes: &[u8]| bytes.to_vec();
        let backwards = |bytes: &[u8]| bytes.iter().rev().copied().collect();
        for (kind, order) in [(1, forwards as fn(&[u8]) -> Vec<u8>), (0, backwards)] {
            let (inner, x, one, two) = numbers(order);
            // no header, an empty message, a flag; at 8 a text with its zero, at 16 one number of two bytes
            let head =
                [&[0, kind, 0, 0][..], &[0; 4], &[9, 1, 0, 0], &two, b"t\0", &[0; 2], &one, &[5, 0], &[0; 2]].concat();
            let message = [&head[..], &inner, &x].concat();
            assert_eq!(taken(Encoding::Cdr, &message), found, "{kind}");
            assert_eq!(taken(Encoding::Cdr, &message[..message.len() - 1]), None);
        }
        let (inner, x, one, _) = numbers(forwards);
        let message = [&[0; 4][..], &[1], &one, b"t", &one, &[5, 0], &inner, &x].concat();
        assert_eq!(taken(Encoding::Ros1, &message), found);
        assert_eq!(taken(Encoding::Other("json".into()), &message), None);
        assert_eq!(taken(Encoding::Cdr, &[9, 9, 0, 0]), None);
    }

    #[test]
    fn fields_after_a_text_of_wide_characters_are_not_reached() {
        let topic = Topic::new("/demo", "demo_msgs/Demo", Encoding::Cdr, Some("wstring a\nfloat64 x\n"));
        let structure = Structure::of(&topic).unwrap().unwrap();
        assert!(structure.steps(structure.place("x")).is_err());
    }
}
