//! One capture's result in the units in which a report gives it.

use vn100_analysis::{Assessment, FigureVerdict, Snapshot};
use vn100_protocol::Quantity;

use super::capture_file::CaptureFile;
use crate::{
    measured::Measured,
    source_document::Origin,
    units::{ChannelValues, NormValues, channel_values, norm_values},
};

pub(crate) struct Record<'a> {
    pub(crate) measured: &'a Measured,
    /// `None` where it is no file, or could not be read again.
    pub(crate) file: Option<CaptureFile>,
    pub(crate) channels: Vec<ChannelValues>,
    pub(crate) norms: Vec<NormValues>,
}

impl<'a> Record<'a> {
    pub(crate) fn new(measured: &'a Measured, file: Option<CaptureFile>) -> Self {
        let channels = channel_values(&measured.snapshot, &measured.assessment);
        Self { measured, file, channels, norms: norm_values(&measured.snapshot) }
    }

    pub(crate) fn origin(&self) -> &Origin {
        &self.measured.origin
    }

    pub(crate) fn snapshot(&self) -> &Snapshot {
        &self.measured.snapshot
    }

    pub(crate) fn assessment(&self) -> &Assessment {
        &self.measured.assessment
    }

    /// Left out before the first sample.
    pub(crate) fn skipped_s(&self) -> f64 {
        self.snapshot().skipped.as_secs_f64()
    }

    /// What the data sheet's figures come to for `channel`; none without a sheet.
    pub(crate) fn verdicts(&self, channel: &ChannelValues) -> &[FigureVerdict] {
        let place = self.channels.iter().position(|other| other.name == channel.name);
        let verdicts = self.measured.verdicts.as_ref().zip(place);
        verdicts.and_then(|(verdicts, place)| verdicts.channels.get(place)).map_or(&[][..], Vec::as_slice)
    }

    /// The channels of the message, without what was read between its lines.
    pub(crate) fn streamed(&self) -> &[ChannelValues] {
        self.channels.get(..self.snapshot().channels.len()).unwrap_or(&self.channels)
    }

    /// The channels of one sensor, in their order.
    pub(crate) fn of(&self, quantity: Quantity) -> Vec<&ChannelValues> {
        self.channels.iter().filter(|channel| channel.quantity == quantity).collect()
    }
}
