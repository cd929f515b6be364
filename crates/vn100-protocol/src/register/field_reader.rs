//! Takes the fields of a register one after the other, and names the one that is wrong.

use alloc::borrow::ToOwned;
use core::str::{FromStr, Split};

use super::{Register, RegisterContents, RegisterValue, ValueError};

/// The fields not yet taken.
#[derive(Debug)]
pub struct FieldReader<'a> {
    pub(super) register: Register,
    fields: Split<'a, char>,
}

impl<'a> FieldReader<'a> {
    /// Begins with the first field, if the register is one of those that hold a `T`.
    pub(super) fn of<T: RegisterValue>(contents: &'a RegisterContents) -> Result<Self, ValueError> {
        if !T::REGISTERS.contains(&contents.register) {
            return Err(ValueError::Register { expected: T::REGISTERS, found: contents.register });
        }
        Ok(Self { register: contents.register, fields: contents.fields.iter() })
    }

    fn text(&mut self, name: &'static str) -> Result<&'a str, ValueError> {
        self.fields.next().ok_or(ValueError::Missing { register: self.register, name })
    }

    /// A field as `read` takes it; `expected` says what that is.
    pub(super) fn value<T>(
        &mut self,
        name: &'static str,
        expected: &'static str,
        read: impl FnOnce(&str) -> Option<T>,
    ) -> Result<T, ValueError> {
        let register = self.register;
        let text = self.text(name)?;
        read(text).ok_or_else(|| ValueError::Field { register, name, text: text.to_owned(), expected })
    }

    /// A whole number of the range of `T`.
    pub(super) fn integer<T: FromStr>(&mut self, name: &'static str) -> Result<T, ValueError> {
        self.value(name, "a whole number in range", integer)
    }

    /// A number as a finite 32-bit float, which is what the sensor keeps.
    fn float(&mut self, name: &'static str) -> Result<f32, ValueError> {
        self.value(name, "a finite number", |text| text.parse().ok().filter(|value: &f32| value.is_finite()))
    }

    pub(super) fn floats<const N: usize>(&mut self, name: &'static str) -> Result<[f32; N], ValueError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.float(name)?;
        }
        Ok(values)
    }

    /// The port, which the sensor repeats where the command named one.
    pub(super) fn optional_port(&mut self) -> Result<(), ValueError> {
        if self.fields.clone().next().is_some() {
            self.value("port", "1 or 2", |text| matches!(text, "1" | "2").then_some(()))?;
        }
        Ok(())
    }

    /// All that are left.
    pub(super) fn rest(&self) -> Split<'a, char> {
        self.fields.clone()
    }

    /// Nothing must be left.
    pub(super) fn end(mut self) -> Result<(), ValueError> {
        match self.fields.next() {
            Some(text) => Err(ValueError::Surplus { register: self.register, text: text.to_owned() }),
            None => Ok(()),
        }
    }
}

/// Digits alone: the standard library would take a sign, too.
pub(super) fn integer<T: FromStr>(text: &str) -> Option<T> {
    text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok())?
}
