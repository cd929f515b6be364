//! The fields of a register in the form of the wire, and a reader for them in sequence.

use alloc::{format, string::String};
use core::{
    fmt,
    str::{FromStr, Split},
};

use super::{Register, RegisterContents, RegisterValue, ValueError};

/// The fields of a register: text separated by commas, as after the register number of a read or a
/// write.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct RegisterFields(String);

impl RegisterFields {
    /// The longest text in bytes: the receive buffer of 256 characters (UM001) less `$VNWRG,nnn,`,
    /// `*`, four digits, CR and LF.
    pub const MAX_LENGTH: usize = 238;

    /// Fields from a text; an empty text is one empty field. `None` for a text above
    /// [`MAX_LENGTH`](Self::MAX_LENGTH), and for one with a character that would break the sentence:
    /// anything but printable ASCII, `$` and `*`.
    pub fn new(text: impl Into<String>) -> Option<Self> {
        let text = text.into();
        (text.len() <= Self::MAX_LENGTH && text.chars().all(is_field_character)).then_some(Self(text))
    }

    /// The text, including its commas.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The fields in order; there is at least one.
    pub fn iter(&self) -> Split<'_, char> {
        self.0.split(',')
    }

    /// Fields from a text of printed numbers and commas, or from a received sentence, which need no
    /// check.
    pub(crate) fn trusted(text: String) -> Self {
        debug_assert!(text.chars().all(is_field_character), "{text:?}");
        Self(text)
    }

    /// Whether a sensor that was sent these fields may reply with `echo`: numbers may be printed
    /// differently, and up to `extra` fields may follow.
    pub(crate) fn means(&self, echo: &Self, extra: usize) -> bool {
        let (asked, got) = (self.iter().count(), echo.iter().count());
        (asked..=asked + extra).contains(&got) && self.iter().zip(echo.iter()).all(|(asked, got)| is_same(asked, got))
    }
}

impl fmt::Display for RegisterFields {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

fn is_field_character(character: char) -> bool {
    matches!(character, ' '..='~') && !matches!(character, '$' | '*')
}

fn is_same(asked: &str, got: &str) -> bool {
    // a point distinguishes a number from a hexadecimal mask such as 01E5
    if asked.contains('.') || got.contains('.') {
        return match (asked.parse::<f64>(), got.parse::<f64>()) {
            // the sensor stores 32-bit floats and prints six digits of them
            (Ok(asked), Ok(got)) if asked.is_finite() => (asked - got).abs() <= 1e-5 * asked.abs(),
            _ => asked == got,
        };
    }
    let [asked, got] = [asked, got].map(|field| field.trim_start_matches('0'));
    asked.eq_ignore_ascii_case(got)
}

/// Reads the fields of a register in sequence, and names the wrong field in an error.
#[derive(Debug)]
pub struct FieldReader<'a> {
    register: Register,
    fields: Split<'a, char>,
}

impl<'a> FieldReader<'a> {
    pub(super) fn of<T: RegisterValue>(contents: &'a RegisterContents) -> Result<Self, ValueError> {
        if !T::REGISTERS.contains(&contents.register) {
            let problem = format!("it does not have this value; register {} does", T::REGISTERS[0]);
            return Err(ValueError { register: contents.register, problem });
        }
        Ok(Self { register: contents.register, fields: contents.fields.iter() })
    }

    /// The next field, as `read` parses it; `expected` describes the form.
    pub(super) fn value<T>(
        &mut self,
        name: &'static str,
        expected: &'static str,
        read: impl FnOnce(&str) -> Option<T>,
    ) -> Result<T, ValueError> {
        let error = |problem| ValueError { register: self.register, problem };
        let text = self.fields.next().ok_or_else(|| error(format!("the {name} is missing")))?;
        read(text).ok_or_else(|| error(format!("{name} is {text:?}, expected {expected}")))
    }

    pub(super) fn integer<T: FromStr>(&mut self, name: &'static str) -> Result<T, ValueError> {
        self.value(name, "a whole number in range", integer)
    }

    /// Finite 32-bit floats, which the sensor stores.
    pub(super) fn floats<const N: usize>(&mut self, name: &'static str) -> Result<[f32; N], ValueError> {
        let mut values = [0.0; N];
        for value in &mut values {
            let finite = |text: &str| text.parse().ok().filter(|value: &f32| value.is_finite());
            *value = self.value(name, "a finite number", finite)?;
        }
        Ok(values)
    }

    /// The port, which the sensor repeats if the command named one.
    pub(super) fn optional_port(&mut self) -> Result<(), ValueError> {
        if self.has_more() {
            self.value("port", "1 or 2", |text| matches!(text, "1" | "2").then_some(()))?;
        }
        Ok(())
    }

    pub(super) fn has_more(&self) -> bool {
        self.fields.clone().next().is_some()
    }

    pub(super) fn end(mut self) -> Result<(), ValueError> {
        match self.fields.next() {
            Some(text) => {
                let problem = format!("more fields than are known, from {text:?} on");
                Err(ValueError { register: self.register, problem })
            }
            None => Ok(()),
        }
    }
}

/// A text of digits only: the standard library would accept a sign as well.
pub(crate) fn integer<T: FromStr>(text: &str) -> Option<T> {
    text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    fn means(asked: &str, echo: &str, extra: usize) -> bool {
        RegisterFields::new(asked).unwrap().means(&RegisterFields::new(echo).unwrap(), extra)
    }

    #[test]
    fn numbers_may_be_printed_differently() {
        for (asked, echo) in [
            ("50", "50"),
            ("50", "050"),
            ("0", "00"),
            ("1,4,06,0001,001c", "1,4,6,1,001C"),
            ("1.002110,0", "1.00211,0"),
            ("+00.000000", "0"),
            ("-9.7937461", "-9.793746"),
            ("-9.71e30893", "-9.71e30893"),
            ("", ""),
        ] {
            assert!(means(asked, echo, 0), "{asked} {echo}");
        }
    }

    #[test]
    fn other_numbers_are_not_the_same() {
        for (asked, echo) in [
            ("50", "40"),
            ("50", "5"),
            ("50", "50,1"),
            ("50,1", "50"),
            ("01E5", "10E4"),
            ("1.0", "1.001"),
            ("0.0", "x"),
        ] {
            assert!(!means(asked, echo, 0), "{asked} {echo}");
        }
        assert!(means("50", "50,1", 1));
        assert!(!means("50,1", "50", 1));
    }

    #[test]
    fn characters_that_would_break_the_sentence_are_refused() {
        for text in ["1*2", "$VNWNV", "1\r\n", "µ"] {
            assert_eq!(RegisterFields::new(text), None);
        }
        assert!(RegisterFields::new("1".repeat(RegisterFields::MAX_LENGTH)).is_some());
        assert_eq!(RegisterFields::new("1".repeat(239)), None);
    }
}
