//! Definitions of message types, as ROS 1 and 2 write them.
//!
//! The first definition is of the message itself; each further one follows a line of `=` and `MSG:
//! package/Type`. The form: <https://wiki.ros.org/msg>,
//! <https://docs.ros.org/en/rolling/Concepts/Basic/About-Interfaces.html>.

use std::{borrow::Cow, collections::BTreeMap};

use super::{
    standard_types,
    topic::{Encoding, Topic, short_type},
};

/// The most types, and the most fields of one type: no message has as many.
const MOST: usize = 4096;

#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Definitions {
    types: BTreeMap<String, Vec<MessageField>>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct MessageField {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) length: Length,
}

/// The type of a field, or of each of its elements.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    Leaf(Leaf),
    Text,
    /// Text of wide characters, which programs encode in different sizes.
    WideText,
    Message(String),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Length {
    One,
    Fixed(u32),
    /// As many elements as the number before them states.
    Counted,
}

/// A number of so many bytes, or a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Leaf {
    Signed(u8),
    Unsigned(u8),
    Float32,
    Float64,
    /// Seconds and nanoseconds, of four bytes each.
    Time,
}

impl Definitions {
    /// The definitions of the messages of a topic, from the bag or of the standard types; `None` if
    /// neither has them. The error says in words why a definition cannot be used.
    pub(super) fn of(topic: &Topic) -> Result<Option<Self>, String> {
        let standard = || standard_types::definition(&topic.type_name, &topic.encoding);
        let Some(text) = topic.definition.as_deref().map(Cow::from).or_else(|| standard().map(Cow::from)) else {
            return Ok(None);
        };
        Self::parse(&topic.type_name, &text, topic.encoding == Encoding::Ros1).map(Some)
    }

    fn parse(type_name: &str, text: &str, ros1: bool) -> Result<Self, String> {
        let mut definitions = Self::default();
        let mut current = type_name.to_owned();
        definitions.types.insert(current.clone(), Vec::new());
        for line in text.lines() {
            let line = line.trim();
            if line.len() >= 20 && line.bytes().all(|byte| byte == b'=') {
                continue;
            }
            if let Some(name) = line.strip_prefix("MSG:") {
                current = short_type(name.trim());
                definitions.types.insert(current.clone(), Vec::new());
            } else if let Some(field) = MessageField::parse(line, &current, ros1)? {
                definitions.types.entry(current.clone()).or_default().push(field);
            }
            let is_large = definitions.types.len() > MOST || definitions.types[&current].len() > MOST;
            if is_large {
                return Err(format!("it has more than {MOST} types or fields"));
            }
        }
        if !ros1 {
            // a structure without fields takes one byte
            let fill = || MessageField { name: "_".into(), kind: Kind::Leaf(Leaf::Unsigned(1)), length: Length::One };
            definitions.types.values_mut().filter(|fields| fields.is_empty()).for_each(|fields| fields.push(fill()));
        }
        Ok(definitions)
    }

    /// The fields of a type; `None` for one that is not defined.
    pub(super) fn fields(&self, type_name: &str) -> Option<&[MessageField]> {
        self.types.get(type_name).map(Vec::as_slice)
    }
}

impl MessageField {
    /// The field of a line; `None` for a comment, a blank line or a constant.
    fn parse(line: &str, of_type: &str, ros1: bool) -> Result<Option<Self>, String> {
        let line = line.split('#').next().unwrap_or("").trim();
        let Some((kind, rest)) = line.split_once(char::is_whitespace) else {
            return if line.is_empty() { Ok(None) } else { Err(format!("the line {line:?} has no name")) };
        };
        let rest = rest.trim();
        let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        if rest[name.len()..].trim_start().starts_with('=') {
            return Ok(None);
        }
        let (element, length) = match kind.split_once('[') {
            None => (kind, Length::One),
            Some((element, "]")) => (element, Length::Counted),
            Some((element, bound)) if bound.starts_with("<=") => (element, Length::Counted),
            Some((element, count)) => {
                let count = count.strip_suffix(']').and_then(|count| count.trim().parse().ok());
                (element, Length::Fixed(count.ok_or_else(|| format!("the length in {kind:?} is no number"))?))
            }
        };
        // the bound of a bounded text
        let element = element.split("<=").next().unwrap_or(element);
        Ok(Some(Self { name, kind: Kind::parse(element, of_type, ros1)?, length }))
    }
}

impl Kind {
    fn parse(name: &str, of_type: &str, ros1: bool) -> Result<Self, String> {
        Ok(match name {
            "byte" if ros1 => Self::Leaf(Leaf::Signed(1)),
            "bool" | "uint8" | "byte" | "char" => Self::Leaf(Leaf::Unsigned(1)),
            "int8" => Self::Leaf(Leaf::Signed(1)),
            "int16" => Self::Leaf(Leaf::Signed(2)),
            "uint16" => Self::Leaf(Leaf::Unsigned(2)),
            "int32" => Self::Leaf(Leaf::Signed(4)),
            "uint32" => Self::Leaf(Leaf::Unsigned(4)),
            "int64" => Self::Leaf(Leaf::Signed(8)),
            "uint64" => Self::Leaf(Leaf::Unsigned(8)),
            "float32" => Self::Leaf(Leaf::Float32),
            "float64" => Self::Leaf(Leaf::Float64),
            "string" => Self::Text,
            "time" | "duration" if ros1 => Self::Leaf(Leaf::Time),
            "wstring" => Self::WideText,
            "Header" => Self::Message("std_msgs/Header".into()),
            name => match short_type(name) {
                name if name == "builtin_interfaces/Time" || name == "builtin_interfaces/Duration" => {
                    Self::Leaf(Leaf::Time)
                }
                name if name.contains('/') => Self::Message(name),
                name => {
                    let package = of_type.split('/').next().unwrap_or_default();
                    Self::Message(format!("{package}/{name}"))
                }
            },
        })
    }
}

impl Leaf {
    /// Length in bytes, and the number of which its offset in CDR is a multiple.
    pub(super) const fn bytes_and_align(self) -> (u64, usize) {
        match self {
            Self::Signed(bytes) | Self::Unsigned(bytes) => (bytes as u64, bytes as usize),
            Self::Float32 => (4, 4),
            Self::Float64 => (8, 8),
            Self::Time => (8, 4),
        }
    }
}
