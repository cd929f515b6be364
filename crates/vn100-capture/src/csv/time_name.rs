//! Names of columns that hold times.

use super::stamp::StampUnit;

/// Names that are always those of times.
const STAMPS: [&str; 6] = ["t", "time", "timestamp", "bag_t", "rosbagtimestamp", "%time"];

/// Endings of the last word in other names of times.
const TIME_ENDINGS: [&str; 4] = ["time", "stamp", "stamps", "zeit"];

/// Words for times, alone or among others.
const TIME_WORDS: [&str; 8] = ["t", "utc", "epoch", "elapsed", "clock", "temps", "tiempo", "tempo"];

/// The words for the units in a name.
const UNIT_WORDS: [(&str, &[&str]); 4] = [
    ("s", &["s", "sec", "secs", "second", "seconds"]),
    ("ms", &["ms", "msec", "msecs", "millis", "millisec", "milliseconds"]),
    ("us", &["us", "µs", "usec", "usecs", "micros", "microsec", "microseconds"]),
    ("ns", &["ns", "nsec", "nsecs", "nanos", "nanosec", "nanosecs", "nanoseconds"]),
];

/// Whether the word, in lower case, is a unit of time.
pub(super) fn is_time_unit(word: &str) -> bool {
    UNIT_WORDS.iter().any(|(_, words)| words.contains(&word))
}

/// Whether a column of this name may hold times.
pub(super) fn is_time_name(name: &str) -> bool {
    let name = TimeName::of(name);
    name.is_stamp() || name.is_time() || name.words.iter().any(|word| TIME_WORDS.contains(&word.as_str()))
}

/// A name cut into words, with a unit at its end separated.
pub(super) struct TimeName {
    whole: String,
    pub(super) words: Vec<String>,
    pub(super) unit: Option<StampUnit>,
}

impl TimeName {
    pub(super) fn of(name: &str) -> Self {
        let whole = name.to_lowercase();
        let mut words: Vec<String> =
            whole.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).map(str::to_owned).collect();
        let unit = words.last().and_then(|last| {
            let (name, _) = UNIT_WORDS.iter().find(|(_, unit_words)| unit_words.contains(&last.as_str()))?;
            StampUnit::ALL.into_iter().find(|unit| unit.name == *name)
        });
        if unit.is_some() {
            words.pop();
        }
        Self { whole, words, unit }
    }

    pub(super) fn is_stamp(&self) -> bool {
        STAMPS.contains(&self.whole.as_str()) || STAMPS.contains(&self.words.join("_").as_str())
    }

    /// Whether the name may be that of a time: its last word is one for times, or it is nothing but
    /// a unit.
    pub(super) fn is_time(&self) -> bool {
        match self.words.last() {
            Some(word) => {
                TIME_ENDINGS.iter().any(|ending| word.ends_with(ending)) || TIME_WORDS.contains(&word.as_str())
            }
            None => self.unit.is_some(),
        }
    }
}
