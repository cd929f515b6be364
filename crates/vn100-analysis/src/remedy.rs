//! What the user can do, as data that the faces put into words.

use std::fmt;

/// An action of the user against a limit of the result.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Remedy {
    /// Give the nominal sample rate: this one in hertz, where it was measured.
    GiveRate(Option<f64>),
    /// Exclude the beginning of the record: this many minutes, where the length is known.
    Skip(Option<f64>),
    /// End the measurement before the end of the record.
    EndEarlier,
    /// Accept sentences that carry no checksum.
    AcceptUnchecked,
    /// Name the columns of a CSV file, or the fields of messages, and their units: by this map, if
    /// one is known.
    MapColumns(Option<String>),
    /// State whether a filter has removed the bias from the rates.
    SayCompensated,
    /// Give the data sheet of the sensor.
    GiveDatasheet,
    /// State the setting of register 85.
    GiveWindow,
    /// Measure the packets of a stream that carries sentences as well.
    MeasurePackets,
    /// Judge by typical figures as by limits.
    TypicalIsLimit,
    /// Set the sensor permanently.
    Configure(Setting),
    /// Set the sensor for one measurement.
    MeasureWith(Setting),
    /// Measure the live sensor, where the latency of the port is shortened.
    MeasureLive,
    /// Poll the temperature of a live sensor between its sentences.
    ReadTemperature,
    /// Record the live sensor, with its temperature and the conditions.
    Record,
    /// Plan how long a record must be.
    Plan,
    /// Write the file for Kalibr.
    ExportKalibr,
    /// State that the sensor was not switched off between two records.
    SayStayedOn,
}

/// A setting of the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Setting {
    /// The message, by its header.
    Message(&'static str),
    /// The averaging window of register 85, in refreshes.
    Window(u32),
}

/// The words of a face for a remedy: its option or command.
pub type RemedyWords = fn(&Remedy) -> String;

/// The words of no face: what is to be set or done.
impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::GiveRate(None) => f.write_str("the sample rate"),
            Self::GiveRate(Some(hz)) => write!(f, "the sample rate {hz:.4} Hz"),
            Self::Skip(None) => f.write_str("a skip"),
            Self::Skip(Some(minutes)) => write!(f, "a skip of {minutes} min"),
            Self::EndEarlier => f.write_str("a duration"),
            Self::AcceptUnchecked => f.write_str("the option for unchecked lines"),
            Self::MapColumns(None) => f.write_str("a map of columns"),
            Self::MapColumns(Some(map)) => write!(f, "the map of columns {map}"),
            Self::SayCompensated => f.write_str("the statement on compensation"),
            Self::GiveDatasheet => f.write_str("a data sheet"),
            Self::GiveWindow => f.write_str("the averaging window"),
            Self::MeasurePackets => f.write_str("the choice of packets"),
            Self::TypicalIsLimit => f.write_str("what is typical as a limit"),
            Self::Configure(setting) | Self::MeasureWith(setting) => setting.fmt(f),
            Self::MeasureLive => f.write_str("a live measurement"),
            Self::ReadTemperature => f.write_str("the option for the temperature"),
            Self::Record => f.write_str("a recording"),
            Self::Plan => f.write_str("a plan"),
            Self::ExportKalibr => f.write_str("the export for Kalibr"),
            Self::SayStayedOn => f.write_str("that it stayed on"),
        }
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Message(header) => write!(f, "register 6 set to {header}"),
            Self::Window(refreshes) => write!(f, "register 85 set to {refreshes}"),
        }
    }
}

/// Sentences that contain remedies, which each face puts into its own words.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Text {
    parts: Vec<TextPart>,
}

#[derive(Debug, Clone, PartialEq)]
enum TextPart {
    Words(String),
    Remedy(Remedy),
}

impl Text {
    /// This text, followed by these words.
    #[must_use]
    pub fn then(mut self, words: impl Into<String>) -> Self {
        self.parts.push(TextPart::Words(words.into()));
        self
    }

    /// This text, followed by a remedy.
    #[must_use]
    pub fn remedy(mut self, remedy: Remedy) -> Self {
        self.parts.push(TextPart::Remedy(remedy));
        self
    }

    /// This text, followed by another text.
    #[must_use]
    pub fn append(mut self, text: Self) -> Self {
        self.parts.extend(text.parts);
        self
    }

    /// The remedies, in the order of the sentences.
    pub fn remedies(&self) -> impl Iterator<Item = &Remedy> {
        self.parts.iter().filter_map(|part| match part {
            TextPart::Words(_) => None,
            TextPart::Remedy(remedy) => Some(remedy),
        })
    }

    /// The sentences that contain a remedy, in the words of a face and without their full stops.
    #[must_use]
    pub fn actions(&self, words: RemedyWords) -> Vec<String> {
        let (mut actions, mut sentence, mut is_action) = (Vec::new(), String::new(), false);
        for part in &self.parts {
            match part {
                TextPart::Remedy(remedy) => {
                    sentence += &words(remedy);
                    is_action = true;
                }
                TextPart::Words(all) => {
                    let mut sentences = all.split_inclusive(". ").peekable();
                    while let Some(piece) = sentences.next() {
                        sentence += piece;
                        if sentences.peek().is_some() || piece.ends_with(". ") {
                            let ended = std::mem::take(&mut sentence);
                            actions.extend(is_action.then_some(ended));
                            is_action = false;
                        }
                    }
                }
            }
        }
        actions.extend(is_action.then_some(sentence));
        actions.iter().map(|action| action.trim().trim_end_matches('.').to_owned()).collect()
    }

    /// All sentences, in the words of a face.
    #[must_use]
    pub fn in_words(&self, words: RemedyWords) -> String {
        let part = |part: &TextPart| match part {
            TextPart::Words(words) => words.clone(),
            TextPart::Remedy(remedy) => words(remedy),
        };
        self.parts.iter().map(part).collect()
    }
}

impl From<String> for Text {
    fn from(words: String) -> Self {
        Self::default().then(words)
    }
}

impl From<&str> for Text {
    fn from(words: &str) -> Self {
        Self::default().then(words)
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.in_words(Remedy::to_string))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_names_what_can_be_done_and_keeps_the_rest() {
        let text = Text::from("if it is wrong give ").remedy(Remedy::GiveRate(Some(40.000_04))).then("; or ");
        let text = text.append(Text::default().remedy(Remedy::Skip(Some(11.0))).then(" leaves that out"));
        assert_eq!(
            text.to_string(),
            "if it is wrong give the sample rate 40.0000 Hz; or a skip of 11 min leaves that out"
        );
        assert_eq!(text.in_words(|_| "*".into()), "if it is wrong give *; or * leaves that out");
        let remedies: Vec<_> = text.remedies().cloned().collect();
        assert_eq!(remedies, [Remedy::GiveRate(Some(40.000_04)), Remedy::Skip(Some(11.0))]);
    }

    #[test]
    fn the_sentences_that_name_what_can_be_done_are_actions() {
        let text = Text::from("It is 1.5 wide. Set ").remedy(Remedy::GiveWindow).then(" if known. It may not be. ");
        let text = text.append(Text::default().remedy(Remedy::Plan).then(" says how long"));
        assert_eq!(text.actions(|_| "*".into()), ["Set * if known", "* says how long"]);
        assert!(Text::from("Nothing helps. ").actions(|_| "*".into()).is_empty());
    }

    #[test]
    fn settings_are_named_by_their_registers() {
        let [message, window] = [Setting::Message("VNIMU"), Setting::Window(20)].map(|setting| setting.to_string());
        assert_eq!((&*message, &*window), ("register 6 set to VNIMU", "register 85 set to 20"));
        assert_eq!(
            Remedy::Configure(Setting::Window(4)).to_string(),
            Remedy::MeasureWith(Setting::Window(4)).to_string()
        );
    }
}
