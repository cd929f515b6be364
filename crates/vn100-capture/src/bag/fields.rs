//! The numbers of a message by their paths, such as `imu.angular_velocity.x`, and the steps that
//! lead to them through its bytes.

use std::collections::BTreeMap;

use super::definition::{Definitions, Kind, Length, MessageField, Number};

/// Levels of messages inside messages; real messages have fewer.
const MOST_LEVELS: usize = 16;

/// The most numbers of a message that are listed, and the most steps that one message may take.
const MOST: usize = 4096;

/// Elements of an array of fixed length that have paths of their own.
const MOST_ELEMENTS: u32 = 64;

/// The type of value at a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Leaf {
    Number(Number),
    Time,
}

/// One number, time or message inside a message.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum PathTarget {
    Leaf(Leaf),
    /// A message of this type.
    Message(String),
}

/// A step through the bytes of a message.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Step {
    /// Skip this many bytes, starting at a multiple of `align`.
    Skip { align: usize, bytes: u64 },
    /// Skip a text.
    SkipText,
    /// Skip elements of fixed size; the number before them is their count.
    SkipCounted { align: usize, each: u64 },
    /// Skip elements of varying size; if `count` is `None`, the number before them is their count.
    SkipEach { count: Option<u32>, steps: Vec<Step> },
    /// A field that cannot be skipped.
    Unreadable,
    /// Take the value for this slot.
    Take { slot: usize, leaf: Leaf },
}

/// All numbers, times and messages of a type with their paths, in the order of the bytes.
pub(super) fn places(definitions: &Definitions, type_name: &str) -> Vec<(String, PathTarget)> {
    let mut places = Vec::new();
    add_places(definitions, type_name, "", 0, &mut places);
    places
}

fn add_places(
    definitions: &Definitions,
    type_name: &str,
    prefix: &str,
    level: usize,
    places: &mut Vec<(String, PathTarget)>,
) {
    for field in definitions.fields(type_name).unwrap_or_default() {
        for path in paths(field, prefix) {
            if level > MOST_LEVELS || places.len() >= MOST {
                return;
            }
            match &field.kind {
                Kind::Number(number) => places.push((path, PathTarget::Leaf(Leaf::Number(*number)))),
                Kind::Time => places.push((path, PathTarget::Leaf(Leaf::Time))),
                Kind::Text | Kind::WideText => {}
                Kind::Message(inner) => {
                    let below = format!("{path}.");
                    places.push((path, PathTarget::Message(inner.clone())));
                    add_places(definitions, inner, &below, level + 1, places);
                }
            }
        }
    }
}

/// The paths of a field: none if the number of its elements varies or is large.
fn paths(field: &MessageField, prefix: &str) -> Vec<String> {
    let name = format!("{prefix}{}", field.name);
    match field.length {
        Length::One => vec![name],
        Length::Fixed(count) if count <= MOST_ELEMENTS => {
            (0..count).map(|element| format!("{name}[{element}]")).collect()
        }
        Length::Fixed(_) | Length::Counted => Vec::new(),
    }
}

/// The steps to the wanted values, each given by its path and its slot.
///
/// # Errors
/// The reason why the definition cannot be used, in words.
pub(super) fn steps(
    definitions: &Definitions,
    type_name: &str,
    slots: &BTreeMap<String, usize>,
) -> Result<Vec<Step>, String> {
    let mut walk = Walk { definitions, slots, steps: 0 };
    let mut steps = walk.message(type_name, "", 0)?;
    let last = steps.iter().rposition(|step| matches!(step, Step::Take { .. }));
    steps.truncate(last.map_or(0, |last| last + 1));
    if has_unreadable(&steps) {
        return Err("a text of wide characters stands before the numbers".into());
    }
    Ok(steps)
}

fn has_unreadable(steps: &[Step]) -> bool {
    steps.iter().any(|step| match step {
        Step::Unreadable => true,
        Step::SkipEach { steps, .. } => has_unreadable(steps),
        _ => false,
    })
}

struct Walk<'a> {
    definitions: &'a Definitions,
    slots: &'a BTreeMap<String, usize>,
    steps: usize,
}

impl Walk<'_> {
    fn message(&mut self, type_name: &str, prefix: &str, level: usize) -> Result<Vec<Step>, String> {
        if level > MOST_LEVELS {
            return Err(format!("it has messages inside messages, {MOST_LEVELS} levels deep"));
        }
        let fields = self.definitions.fields(type_name).ok_or_else(|| format!("it lacks that of {type_name}"))?;
        let mut steps = Vec::new();
        for field in fields {
            self.steps += 1;
            if self.steps > MOST {
                return Err(format!("its messages have more than {MOST} fields"));
            }
            self.field(field, prefix, level, &mut steps)?;
        }
        Ok(steps)
    }

    fn field(&mut self, field: &MessageField, prefix: &str, level: usize, steps: &mut Vec<Step>) -> Result<(), String> {
        let path = format!("{prefix}{}", field.name);
        let below = format!("{path}[");
        let is_wanted = |slots: &BTreeMap<String, usize>| {
            slots.range(below.clone()..).next().is_some_and(|(wanted, _)| wanted.starts_with(&below))
        };
        match field.length {
            Length::One => self.element(&field.kind, &path, level, steps),
            Length::Fixed(count) if count <= MOST_ELEMENTS && is_wanted(self.slots) => {
                (0..count).try_for_each(|place| self.element(&field.kind, &format!("{path}[{place}]"), level, steps))
            }
            Length::Fixed(_) | Length::Counted => {
                // paths below have no slots, because those of elements contain a bracket
                let mut each = Vec::new();
                self.element(&field.kind, &below, level, &mut each)?;
                steps.push(match (field.length, &*each) {
                    (Length::Fixed(count), [Step::Skip { align, bytes }]) => {
                        Step::Skip { align: *align, bytes: bytes * u64::from(count) }
                    }
                    (Length::Fixed(count), _) => Step::SkipEach { count: Some(count), steps: each },
                    (_, [Step::Skip { align, bytes }]) => Step::SkipCounted { align: *align, each: *bytes },
                    _ => Step::SkipEach { count: None, steps: each },
                });
                Ok(())
            }
        }
    }

    fn element(&mut self, kind: &Kind, path: &str, level: usize, steps: &mut Vec<Step>) -> Result<(), String> {
        let slot = self.slots.get(path).copied();
        let step = match (kind, slot) {
            (Kind::Number(number), Some(slot)) => Step::Take { slot, leaf: Leaf::Number(*number) },
            (Kind::Time, Some(slot)) => Step::Take { slot, leaf: Leaf::Time },
            (Kind::Number(number), None) => Step::Skip { align: number.bytes(), bytes: number.bytes() as u64 },
            (Kind::Time, None) => Step::Skip { align: 4, bytes: 8 },
            (Kind::Text, _) => Step::SkipText,
            (Kind::WideText, _) => Step::Unreadable,
            (Kind::Message(inner), _) => {
                steps.extend(self.message(inner, &format!("{path}."), level + 1)?);
                return Ok(());
            }
        };
        steps.push(step);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{
        super::topic::{Encoding, Topic},
        *,
    };

    #[test]
    fn an_array_that_is_not_wanted_is_passed_over_in_one_step() {
        for length in [3, 4_000_000_000_u32] {
            let text = format!("uint16[{length}] raw\nfloat64 rate\n");
            let topic = Topic::new("/raw", "a/Raw", Encoding::Ros1, Some(&text));
            let definitions = Definitions::of(&topic).unwrap().unwrap();
            let steps = steps(&definitions, "a/Raw", &[("rate".to_owned(), 0)].into()).unwrap();
            let skip = Step::Skip { align: 2, bytes: 2 * u64::from(length) };
            assert_eq!(steps, [skip, Step::Take { slot: 0, leaf: Leaf::Number(Number::F64) }]);
        }
    }
}
