//! One capture's result in the units in which a report gives it.

use vn100_analysis::FigureVerdict;
use vn100_protocol::Quantity;

use crate::{
    measured::Measured,
    units::{ChannelValues, NormValues, channel_values, norm_values},
};

/// One result of a report.
#[derive(Debug, Clone)]
pub struct Record<'a> {
    /// The result itself.
    pub measured: &'a Measured,
    pub(crate) channels: Vec<ChannelValues>,
    pub(crate) norms: Vec<NormValues>,
}

impl<'a> Record<'a> {
    /// The result in units.
    #[must_use]
    pub fn new(measured: &'a Measured) -> Self {
        let channels = channel_values(&measured.snapshot, &measured.assessment);
        Self { measured, channels, norms: norm_values(&measured.snapshot) }
    }

    /// Excluded before the first sample.
    pub(crate) fn skipped_s(&self) -> f64 {
        self.measured.snapshot.skipped.as_secs_f64()
    }

    /// What the data sheet's figures come to for `channel`; none without a sheet.
    pub(crate) fn verdicts(&self, channel: &ChannelValues) -> &[FigureVerdict] {
        let place = self.channels.iter().position(|other| other.name == channel.name);
        let verdicts = self.measured.verdicts.as_ref().zip(place);
        verdicts.and_then(|(verdicts, place)| verdicts.channels.get(place)).map_or(&[][..], Vec::as_slice)
    }

    /// The channels of the message, without what was read between its lines.
    pub(crate) fn streamed(&self) -> &[ChannelValues] {
        self.channels.get(..self.measured.snapshot.channels.len()).unwrap_or(&self.channels)
    }

    pub(crate) fn of(&self, quantity: Quantity) -> Vec<&ChannelValues> {
        self.channels.iter().filter(|channel| channel.quantity == quantity).collect()
    }
}

/// The letter by which a report names its record of that number, from 0: A, B, ..., Z, AA, ...
#[must_use]
pub fn record_letter(number: usize) -> String {
    let last = char::from(b'A' + (number % 26) as u8);
    match number / 26 {
        0 => last.to_string(),
        more => format!("{}{last}", record_letter(more - 1)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_continue_after_the_alphabet() {
        assert_eq!([0, 1, 25, 26, 27, 701, 702].map(record_letter), ["A", "B", "Z", "AA", "AB", "ZZ", "AAA"]);
    }
}
