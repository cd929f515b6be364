//! Warnings as data: the kind, the severity, the channels, what was found, and what can be done. The
//! words for them are those of the faces.

pub(crate) mod checks;
mod finding;

pub use finding::{Doubt, Doubtful, Event, Finding, Happening, Peak, Rejected, WarningKind};

use crate::remedy::Remedy;

/// What a warning concerns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aspect {
    /// Whether all samples arrived, and intact.
    Data,
    /// Rate and time stamps.
    Time,
    /// Whether the sensor lay still.
    AtRest,
    /// What the stream carries of the sensor's own noise.
    Message,
    /// What the numbers can resolve.
    Values,
}

impl Aspect {
    /// All aspects.
    pub const ALL: [Self; 5] = [Self::Data, Self::Time, Self::AtRest, Self::Message, Self::Values];

    /// The name of the aspect.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Data => "data",
            Self::Time => "time",
            Self::AtRest => "at rest",
            Self::Message => "message",
            Self::Values => "values",
        }
    }
}

/// What a warning means for the result, the gravest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Numbers of the result are wrong, or not those of the sensor, or the record is not complete.
    Problem,
    /// Numbers of the result are less certain, or mean less.
    Caution,
    /// A property of the stream that its user should know; healthy sensors have it as well.
    Note,
}

impl Severity {
    /// The code of the severity.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Problem => "problem",
            Self::Caution => "caution",
            Self::Note => "note",
        }
    }
}

/// One warning.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// The kind of the warning, which is that of its finding.
    pub kind: WarningKind,
    /// What the warning means for the result.
    pub severity: Severity,
    /// Names of the channels concerned; empty if all are.
    pub channels: Vec<String>,
    /// What was found.
    pub finding: Finding,
    /// What can be done about it in this case; empty if nothing but the general advice helps.
    pub remedies: Vec<Remedy>,
}

impl Warning {
    /// A warning that concerns all channels, with the severity of most findings of its kind and
    /// without a remedy of its own.
    pub fn new(finding: Finding) -> Self {
        let kind = finding.kind();
        Self { kind, severity: kind.severity(), channels: Vec::new(), finding, remedies: Vec::new() }
    }

    /// A warning of these channels; `None` if there are none.
    pub(crate) fn of_any(finding: Finding, channels: Vec<String>) -> Option<Self> {
        (!channels.is_empty()).then(|| Self::new(finding).of(channels))
    }

    /// The same, of these channels.
    pub fn of(self, channels: impl IntoIterator<Item = String>) -> Self {
        Self { channels: channels.into_iter().collect(), ..self }
    }

    /// The same, with another severity.
    pub fn as_severe_as(self, severity: Severity) -> Self {
        Self { severity, ..self }
    }

    /// The same, with one more remedy.
    pub fn cured_by(mut self, remedy: Remedy) -> Self {
        self.remedies.push(remedy);
        self
    }
}
