//! The numbers of a message by their paths, such as `imu.angular_velocity.x`, and the steps that
//! lead to them through its bytes.

use super::{
    definition::{Definitions, Kind, Leaf, Length, MessageField},
    topic::Topic,
};

/// Levels of messages inside messages; real messages have fewer.
const MOST_LEVELS: usize = 16;

/// The most fields of a message that are read, and the most numbers that are listed.
const MOST: usize = 4096;

/// Elements of an array of fixed length that have paths of their own.
const MOST_ELEMENTS: u32 = 64;

/// The content of the messages of a type, in the order of the bytes.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Structure {
    /// All numbers and times with their paths.
    pub(super) leaves: Vec<(String, Leaf)>,
    /// The messages inside, each with its path and its type.
    pub(super) messages: Vec<(String, String)>,
    /// The steps that take all leaves.
    steps: Vec<Step>,
    fields: usize,
}

/// A step through the bytes of a message.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Step {
    /// Skip this many bytes, starting at a multiple of `align`.
    Skip { align: usize, bytes: u64 },
    /// Skip elements of fixed size, as the bytes of a text; the number before them is their count.
    SkipCounted { align: usize, each: u64 },
    /// Skip elements of varying size; if `count` is `None`, the number before them is their count.
    SkipEach { count: Option<u32>, steps: Vec<Step> },
    /// A field that cannot be skipped, for this reason.
    Unreadable(String),
    /// Take the leaf at this place among all.
    Take { place: usize, leaf: Leaf },
}

impl Structure {
    /// The content of the messages of a topic; `None` if their definition is not known. The error
    /// says in words why it cannot be used.
    pub(super) fn of(topic: &Topic) -> Result<Option<Self>, String> {
        let Some(definitions) = Definitions::of(topic)? else { return Ok(None) };
        let mut whole = Self::default();
        whole.steps = whole.message(&definitions, &topic.type_name, Some(""), 0);
        Ok(Some(whole))
    }

    /// The place of the leaf with this path among all.
    pub(super) fn place(&self, path: &str) -> Option<usize> {
        self.leaves.iter().position(|(other, _)| other == path)
    }

    pub(super) fn times(&self) -> impl Iterator<Item = (usize, &str)> {
        let leaves = self.leaves.iter().enumerate();
        leaves.filter(|(_, (_, leaf))| *leaf == Leaf::Time).map(|(place, (path, _))| (place, &**path))
    }

    /// The steps to the wanted leaves.
    ///
    /// # Errors
    /// The reason why one cannot be reached, in words.
    pub(super) fn steps(&self, wanted: impl IntoIterator<Item = usize>) -> Result<Vec<Step>, String> {
        let mut is_wanted = vec![false; self.leaves.len()];
        wanted.into_iter().for_each(|place| is_wanted[place] = true);
        let mut missing = is_wanted.iter().filter(|is_wanted| **is_wanted).count();
        let mut steps = Vec::new();
        for step in &self.steps {
            match step {
                _ if missing == 0 => break,
                Step::Unreadable(reason) => return Err(reason.clone()),
                Step::Take { place, leaf } if !is_wanted[*place] => add(&mut steps, skip(*leaf)),
                other => {
                    missing -= usize::from(matches!(other, Step::Take { .. }));
                    add(&mut steps, other.clone());
                }
            }
        }
        Ok(steps)
    }

    /// The steps through a message, whose fields have paths after `prefix`, if there is one.
    fn message(&mut self, types: &Definitions, name: &str, prefix: Option<&str>, level: usize) -> Vec<Step> {
        if level > MOST_LEVELS {
            return vec![Step::Unreadable(format!("it has messages inside messages, {MOST_LEVELS} levels deep"))];
        }
        let Some(fields) = types.fields(name) else {
            return vec![Step::Unreadable(format!("it lacks that of {name}"))];
        };
        let mut steps = Vec::new();
        for field in fields {
            self.fields += 1;
            if self.fields > MOST {
                steps.push(Step::Unreadable(format!("its messages have more than {MOST} fields")));
                break;
            }
            self.field(types, field, prefix, level).into_iter().for_each(|step| add(&mut steps, step));
        }
        steps
    }

    fn field(&mut self, types: &Definitions, field: &MessageField, prefix: Option<&str>, level: usize) -> Vec<Step> {
        let prefix = prefix.filter(|_| self.leaves.len() < MOST);
        let path = prefix.map(|prefix| format!("{prefix}{}", field.name));
        let count = match (field.length, &path) {
            (Length::One, _) => return self.element(types, &field.kind, path, level),
            (Length::Fixed(count), Some(path)) if count <= MOST_ELEMENTS => {
                let elements = (0..count).map(|place| format!("{path}[{place}]"));
                return elements.flat_map(|path| self.element(types, &field.kind, Some(path), level)).collect();
            }
            (Length::Fixed(count), _) => Some(count),
            (Length::Counted, _) => None,
        };
        let steps = self.element(types, &field.kind, None, level);
        vec![match (count, &*steps) {
            (_, [.., Step::Unreadable(reason)]) => Step::Unreadable(reason.clone()),
            (Some(count), [Step::Skip { align, bytes }]) if bytes % *align as u64 == 0 => {
                Step::Skip { align: *align, bytes: bytes.saturating_mul(count.into()) }
            }
            (None, [Step::Skip { align, bytes }]) if bytes % *align as u64 == 0 => {
                Step::SkipCounted { align: *align, each: *bytes }
            }
            _ => Step::SkipEach { count, steps },
        }]
    }

    /// The steps through one value; without a path it is not listed.
    fn element(&mut self, types: &Definitions, kind: &Kind, path: Option<String>, level: usize) -> Vec<Step> {
        vec![match (kind, path) {
            (Kind::Leaf(leaf), Some(path)) => {
                self.leaves.push((path, *leaf));
                Step::Take { place: self.leaves.len() - 1, leaf: *leaf }
            }
            (Kind::Leaf(leaf), None) => skip(*leaf),
            (Kind::Text, _) => Step::SkipCounted { align: 1, each: 1 },
            (Kind::WideText, _) => Step::Unreadable("a text of wide characters stands before the numbers".into()),
            (Kind::Message(name), path) => {
                let below = path.as_ref().map(|path| format!("{path}."));
                self.messages.extend(path.map(|path| (path, name.clone())));
                return self.message(types, name, below.as_deref(), level + 1);
            }
        }]
    }
}

const fn skip(leaf: Leaf) -> Step {
    let (bytes, align) = leaf.bytes_and_align();
    Step::Skip { align, bytes }
}

/// Adds a step; nothing is reached after one that cannot be skipped, and neighbours of one
/// alignment are skipped together.
fn add(steps: &mut Vec<Step>, step: Step) {
    match (steps.last_mut(), step) {
        (Some(Step::Unreadable(_)), _) => {}
        (Some(Step::Skip { align, bytes }), Step::Skip { align: same, bytes: more })
            if *align == same && *bytes % same as u64 == 0 =>
        {
            *bytes = bytes.saturating_add(more);
        }
        (_, step) => steps.push(step),
    }
}

#[cfg(test)]
mod tests {
    use super::{super::topic::Encoding, *};

    #[test]
    fn an_array_that_is_not_wanted_is_passed_over_in_one_step() {
        for length in [3, 4_000_000_000_u32] {
            let text = format!("uint16[{length}] raw\nfloat64 rate\n");
            let structure = Structure::of(&Topic::new("/raw", "a/Raw", Encoding::Ros1, Some(&text))).unwrap().unwrap();
            let rate = structure.place("rate").unwrap();
            let skip = Step::Skip { align: 2, bytes: 2 * u64::from(length) };
            assert_eq!(structure.steps([rate]).unwrap(), [skip, Step::Take { place: rate, leaf: Leaf::Float64 }]);
        }
    }
}
