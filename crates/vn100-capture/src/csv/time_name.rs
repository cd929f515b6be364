//! Names of columns that hold times.

use super::{
    stamp::{StampUnit, time_unit},
    words::words,
};

/// Names that always mean times.
const STAMPS: [&str; 6] = ["t", "time", "timestamp", "bag_t", "rosbagtimestamp", "%time"];

/// Endings of the last word in other names of times.
const TIME_ENDINGS: [&str; 4] = ["time", "stamp", "stamps", "zeit"];

/// Words for times, alone or among others.
const TIME_WORDS: [&str; 8] = ["t", "utc", "epoch", "elapsed", "clock", "temps", "tiempo", "tempo"];

/// Names of the time at which the sensor measured, in words.
const DEVICE_TIMES: [&[&str]; 4] =
    [&["device", "time"], &["time", "startup"], &["sample", "time", "fine"], &["sampletimefine"]];

/// A name cut into words, with a unit at its end separated.
pub(super) struct TimeName {
    whole: String,
    pub(super) words: Vec<String>,
    pub(super) unit: Option<StampUnit>,
}

impl TimeName {
    pub(super) fn of(name: &str) -> Self {
        let (whole, mut words) = (name.to_lowercase(), words(name));
        let unit = words.last().and_then(|last| time_unit(last));
        if unit.is_some() {
            words.pop();
        }
        Self { whole, words, unit }
    }

    /// Whether the name means the time at which the sensor measured.
    pub(super) fn is_device_time(&self) -> bool {
        DEVICE_TIMES.iter().any(|known| self.words == *known)
    }

    /// The unit that the name states or implies.
    pub(super) fn unit(&self) -> Option<StampUnit> {
        let are_ticks = self.words.last().is_some_and(|word| word == "fine" || word == "sampletimefine");
        self.unit.or_else(|| (are_ticks && self.is_device_time()).then_some(StampUnit::TICKS))
    }

    /// Whether the name means the time in the header of a message, which is the time of the
    /// measurement and not of its recording.
    pub(super) fn is_of_header(&self) -> bool {
        self.words.iter().any(|word| word == "header") && self.words.iter().any(|word| word == "stamp")
    }

    pub(super) fn is_stamp(&self) -> bool {
        STAMPS.contains(&self.whole.as_str()) || STAMPS.contains(&self.words.join("_").as_str())
    }

    /// Whether the name may mean a time: its last word means times, or it is only a unit.
    pub(super) fn is_time(&self) -> bool {
        match self.words.last() {
            Some(word) => {
                TIME_ENDINGS.iter().any(|ending| word.ends_with(ending)) || TIME_WORDS.contains(&word.as_str())
            }
            None => self.unit.is_some(),
        }
    }
}
