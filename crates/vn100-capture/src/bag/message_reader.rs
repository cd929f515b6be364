//! Takes numbers out of the bytes of a message, step by step.
//!
//! CDR: <https://www.omg.org/spec/DDSI-RTPS/>, with each number at a multiple of its size from the
//! fifth byte on.

use super::{
    definition::Number,
    fields::{Leaf, Step},
    topic::Encoding,
};

/// A value taken from a message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Taken {
    Number(f64),
    /// A time in nanoseconds.
    Time(i64),
}

/// Takes the values of the slots; `None` where the message ends too early, or is in a form that is
/// not read.
pub(super) fn take(steps: &[Step], encoding: &Encoding, message: &[u8], slots: &mut [Taken]) -> Option<()> {
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
    cursor.walk(steps, slots)
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
    fn walk(&mut self, steps: &[Step], slots: &mut [Taken]) -> Option<()> {
        for step in steps {
            match step {
                Step::Skip { align, bytes } => self.skip(*align, *bytes)?,
                Step::SkipText => {
                    let length = self.count()?;
                    self.skip(1, length.into())?;
                }
                Step::SkipCounted { align, each } => {
                    let count = self.count()?;
                    if count > 0 {
                        self.skip(*align, u64::from(count).checked_mul(*each)?)?;
                    }
                }
                Step::SkipEach { count, steps } => {
                    let count = match count {
                        Some(count) => *count,
                        None => self.count()?,
                    };
                    for _ in 0..count {
                        let before = self.at;
                        self.walk(steps, slots)?;
                        // elements of no size, however many there are
                        if self.at == before {
                            break;
                        }
                    }
                }
                Step::Take { slot, leaf } => slots[*slot] = self.leaf(*leaf)?,
            }
        }
        Some(())
    }

    fn leaf(&mut self, leaf: Leaf) -> Option<Taken> {
        Some(match leaf {
            Leaf::Time => {
                // seconds of ROS 1 are unsigned, those of ROS 2 have a sign
                let seconds = self.number::<4>()?;
                let seconds = match self.form {
                    Form::Ros1 => u32::from_le_bytes(seconds).into(),
                    Form::Cdr { .. } => i64::from(i32::from_le_bytes(seconds)),
                };
                Taken::Time(seconds * 1_000_000_000 + i64::from(u32::from_le_bytes(self.number()?)))
            }
            Leaf::Number(number) => Taken::Number(match number {
                Number::I8 => i8::from_le_bytes(self.number()?).into(),
                Number::U8 => u8::from_le_bytes(self.number()?).into(),
                Number::I16 => i16::from_le_bytes(self.number()?).into(),
                Number::U16 => u16::from_le_bytes(self.number()?).into(),
                Number::I32 => i32::from_le_bytes(self.number()?).into(),
                Number::U32 => u32::from_le_bytes(self.number()?).into(),
                Number::I64 => i64::from_le_bytes(self.number()?) as f64,
                Number::U64 => u64::from_le_bytes(self.number()?) as f64,
                Number::F32 => f32::from_le_bytes(self.number()?).into(),
                Number::F64 => f64::from_le_bytes(self.number()?),
            }),
        })
    }

    fn count(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.number()?))
    }

    /// The next bytes, the lowest first.
    fn number<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.align(N)?;
        let mut bytes: [u8; N] = *self.bytes.get(self.at..)?.first_chunk()?;
        if matches!(self.form, Form::Cdr { big_endian: true }) {
            bytes.reverse();
        }
        self.at += N;
        Some(bytes)
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
