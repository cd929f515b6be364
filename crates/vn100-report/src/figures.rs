//! All figures of a report, made once for the page and for the files beside it.

use vn100_analysis::{SENSORS, axes_name};
use vn100_protocol::Quantity;

use crate::{
    figure::{Figure, allan_of_axes, allan_of_axis, allan_of_records, envelope, histogram, segments, spectrum},
    names::names_of,
    record::Record,
    units::ChannelValues,
};

/// Those that say the same of one record, or of several.
#[derive(Debug, Clone, Default)]
pub struct Figures {
    /// The axes of each sensor together.
    pub(crate) allan_sensors: Vec<Figure>,
    pub(crate) allan_axes: Vec<Figure>,
    pub(crate) times: Vec<Figure>,
    pub(crate) histograms: Vec<Figure>,
    pub(crate) spectra: Vec<Figure>,
    pub(crate) segments: Vec<Figure>,
}

impl Figures {
    /// Of one record; `prefix` makes its names unique in a report of several.
    #[must_use]
    pub fn of(record: &Record<'_>, prefix: &str) -> Self {
        let deviation = record.measured.snapshot.deviation;
        let skipped_s = record.skipped_s();
        let mut all = Self::default();
        for (quantity, sensor) in SENSORS {
            let (id, name) = (axes_name(sensor), names_of(quantity).title);
            let axes = record.of(quantity);
            all.allan_sensors.extend(allan_of_axes(id, name, &axes, deviation));
            for channel in &axes {
                all.allan_axes.extend(allan_of_axis(channel, deviation));
            }
            all.spectra.extend(spectrum(id, name, &axes));
            all.segments.extend(segments(id, name, &axes, skipped_s));
        }
        for (quantity, id) in [(Quantity::Angle, "attitude"), (Quantity::Quaternion, "quaternion")] {
            all.segments.extend(segments(id, "Orientation", &record.of(quantity), skipped_s));
        }
        for channel in record.streamed() {
            all.times.extend(envelope(channel, skipped_s));
            all.histograms.extend(histogram(channel));
        }
        let Self { allan_sensors, allan_axes, times, histograms, spectra, segments } = &mut all;
        for figures in [allan_sensors, allan_axes, times, histograms, spectra, segments] {
            figures.iter_mut().for_each(|figure| figure.id.insert_str(0, prefix));
        }
        all
    }

    /// The curves of each channel of all records in one plot.
    #[must_use]
    pub fn together(records: &[Record<'_>], names: &[String]) -> Self {
        let mut all = Self::default();
        for (quantity, _) in SENSORS {
            let mut done: Vec<&str> = Vec::new();
            for channel in records.iter().flat_map(|record| record.of(quantity)) {
                if done.contains(&channel.name.as_str()) {
                    continue;
                }
                done.push(&channel.name);
                let same: Vec<_> = (records.iter().zip(names))
                    .filter_map(|(record, name)| {
                        let is_same =
                            |other: &&ChannelValues| (&other.name, &other.unit) == (&channel.name, &channel.unit);
                        Some((name.clone(), record.channels.iter().find(is_same)?))
                    })
                    .collect();
                let Some(first) = records.first() else { continue };
                all.allan_axes.extend(allan_of_records(&channel.name, &same, first.measured.snapshot.deviation));
            }
        }
        all
    }

    /// All of them, in the order of the page.
    pub fn all(&self) -> impl Iterator<Item = &Figure> {
        let Self { allan_sensors, allan_axes, times, histograms, spectra, segments } = self;
        [allan_sensors, allan_axes, times, histograms, spectra, segments].into_iter().flatten()
    }
}
