//! The figures of a report. Each is drawn once, for the page and for the files beside it, as SVG,
//! and keeps the numbers that it shows.

mod allan;
mod axes;
mod drawing;
mod drift;
mod fitted_model;
mod graphical;
mod histogram;
mod labels;
mod over_time;
mod plot;
mod spectrum;
mod svg;

use std::collections::BTreeSet;

use vn100_analysis::noise::Deviation;
use vn100_analysis::protocol::Quantity;
use vn100_analysis::{ChannelResult, SENSORS, SourceResult, axes_name};

pub use allan::id_of;
pub use axes::{PlotAxis, Scale, Tick};
pub use drawing::{Anchor, At, Colour, Marker, Primitive, Rectangle, Stroke};
pub use over_time::last_minutes;
pub use spectrum::spectrum;

use crate::names::{names_of, run_name, run_prefix};
use allan::{allan_of_axes, allan_of_each, allan_of_records};
use drawing::{Dash, LayerKind, Shape};
use drift::drift;
use graphical::graphical;
use histogram::histogram;
use over_time::{envelope, segments};
use plot::{LegendSample, SlopedLine, quiet, solid};

/// The figures of one record, or those of several together.
#[derive(Debug, Clone, Default)]
pub struct Figures {
    /// The deviation over the averaging time, one figure a sensor with the curves of all its axes.
    pub allan_sensors: Vec<Figure>,
    /// The deviation of one axis with its fitted model; of several records, their curves of it.
    pub allan_axes: Vec<Figure>,
    /// The Allan deviation of the y axis of gyroscope and accelerometer, with the lines of the
    /// graphical slope method.
    pub graphical: Vec<Figure>,
    /// The drift of the angles while the sensor coasts.
    pub drifts: Vec<Figure>,
    /// One channel over the time of the record: range and mean of each block.
    pub times: Vec<Figure>,
    /// The histogram of one channel beside the normal curve of its mean and deviation.
    pub histograms: Vec<Figure>,
    /// The amplitude spectral density, one figure a sensor, with its significant peaks.
    pub spectra: Vec<Figure>,
    /// The standard deviation in each segment of the record, one figure a sensor.
    pub segments: Vec<Figure>,
    /// The last minutes of each channel; of a record that is measured alone.
    pub recent: Vec<Figure>,
}

/// The figures of a report.
#[derive(Debug, Clone)]
pub struct ReportFigures {
    /// Those of each record.
    pub records: Vec<Figures>,
    /// Those of all records together; empty for a single one.
    pub together: Figures,
}

impl ReportFigures {
    /// The figures of these records.
    pub fn of(records: &[SourceResult]) -> Self {
        if let [record] = records {
            return Self { records: vec![Figures::of(record, "")], together: Figures::default() };
        }
        let of_record = |(place, record)| Figures::of(record, &run_prefix(place));
        Self { records: records.iter().enumerate().map(of_record).collect(), together: Figures::together(records) }
    }
}

/// Columns of the last minutes.
const RECENT_COLUMNS: usize = 61;

impl Figures {
    /// The figures of one record; `prefix` makes their names unique in a report of several.
    pub(crate) fn of(record: &SourceResult, prefix: &str) -> Self {
        let mut all = Self::of_deviation_and_spectrum(record);
        let deviation = record.settings().deviation;
        for (quantity, _) in SENSORS {
            let axes = record.of(quantity).into_iter().map(|channel| shown_with(channel, record));
            let y = axes.into_iter().find(|channel| channel.name.ends_with("_y"));
            all.graphical.extend(y.and_then(|y| graphical(&y, deviation)));
        }
        if record.motion.is_none() && deviation == Deviation::Allan {
            all.drifts.extend(drift(&record.of(Quantity::AngularRate)));
        }
        // what was read between the lines has no such figure
        for channel in record.streamed() {
            all.times.extend(envelope(channel));
            all.histograms.extend(histogram(channel));
        }
        all.named(prefix)
    }

    /// The figures that say something while the record is measured: deviations, spectra, segments and
    /// the last minutes.
    pub fn live(record: &SourceResult) -> Self {
        let mut all = Self::of_deviation_and_spectrum(record);
        for (place, channel) in record.streamed().enumerate() {
            let history = record.history(place, RECENT_COLUMNS, usize::MAX);
            all.recent.extend(history.and_then(|history| last_minutes(&channel.name, &channel.unit, &history)));
        }
        all
    }

    fn of_deviation_and_spectrum(record: &SourceResult) -> Self {
        let deviation = record.settings().deviation;
        let mut all = Self::default();
        for (quantity, sensor) in SENSORS {
            let (id, name) = (axes_name(sensor), names_of(quantity).title);
            let axes: Vec<ChannelResult> =
                record.of(quantity).into_iter().map(|channel| shown_with(channel, record)).collect();
            let axes: Vec<&ChannelResult> = axes.iter().collect();
            let sheet = axes.first().map_or(&[][..], |channel| channel.verdicts());
            all.allan_sensors.extend(allan_of_axes(id, name, &axes, sheet, deviation));
            all.allan_axes.extend(allan_of_each(&axes, deviation));
            all.spectra.extend(spectrum(id, name, &axes));
            all.segments.extend(segments(id, name, &axes));
        }
        let series = record.of(Quantity::Value);
        all.allan_axes.extend(allan_of_each(&series, deviation));
        all.spectra.extend(spectrum("value", names_of(Quantity::Value).title, &series));
        for (quantity, id) in [(Quantity::Angle, "attitude"), (Quantity::Quaternion, "quaternion")] {
            all.segments.extend(segments(id, "Orientation", &record.of(quantity)));
        }
        all
    }

    fn named(mut self, prefix: &str) -> Self {
        let Self { allan_sensors, allan_axes, graphical, drifts, times, histograms, spectra, segments, recent: _ } =
            &mut self;
        let all = [allan_sensors, allan_axes, graphical, drifts, times, histograms, spectra, segments];
        all.into_iter().flatten().for_each(|figure| figure.id.insert_str(0, prefix));
        self
    }

    /// The curves of each channel of all records in one plot.
    fn together(records: &[SourceResult]) -> Self {
        let mut all = Self::default();
        let Some(first) = records.first() else { return all };
        let mut done = BTreeSet::new();
        let channels = SENSORS.iter().flat_map(|(quantity, _)| records.iter().flat_map(|record| record.of(*quantity)));
        for channel in channels.filter(|channel| done.insert((channel.quantity, &channel.name))) {
            let is_same = |other: &&ChannelResult| (&other.name, &other.unit) == (&channel.name, &channel.unit);
            let same: Vec<_> = (records.iter().enumerate())
                .filter_map(|(place, record)| Some((run_name(place), record.channels.iter().find(is_same)?)))
                .collect();
            all.allan_axes.extend(allan_of_records(&channel.name, &same, first.settings().deviation));
        }
        all
    }

    /// All figures, in the order of the page.
    pub fn all(&self) -> impl Iterator<Item = &Figure> {
        let Self { allan_sensors, allan_axes, graphical, drifts, times, histograms, spectra, segments, recent } = self;
        [allan_sensors, allan_axes, graphical, drifts, times, histograms, spectra, segments, recent]
            .into_iter()
            .flatten()
    }
}

/// The deviations of these channels of one sensor: of a single one with its model, of several with the
/// figures of the data sheet. `None` without a deviation.
pub fn deviations(record: &SourceResult, channels: &[&ChannelResult]) -> Option<Figure> {
    let deviation = record.settings().deviation;
    let axes: Vec<ChannelResult> = channels.iter().map(|channel| shown_with(channel, record)).collect();
    let axes: Vec<&ChannelResult> = axes.iter().collect();
    match &axes[..] {
        [_] => allan_of_each(&axes, deviation).pop(),
        [] => None,
        [first, ..] => allan_of_axes("axes", names_of(first.quantity).short, &axes, first.verdicts(), deviation),
    }
}

/// The channel, without noise parameters where the sensor was moved.
fn shown_with(channel: &ChannelResult, record: &SourceResult) -> ChannelResult {
    let mut channel = channel.clone();
    channel.noise = channel.noise.filter(|_| record.motion.is_none());
    channel
}

/// A figure, with the numbers that it shows.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Unique in a report, of letters, digits, `-` and `_`: the stem of its file.
    pub id: String,
    /// What is plotted, in a few words: the caption.
    pub title: String,
    /// What it shows, with the values that stand in its legend.
    pub(crate) description: String,
    /// The axis along.
    pub x: PlotAxis,
    /// The axis upwards.
    pub y: PlotAxis,
    /// The rectangle between the axes, in the coordinates of the SVG.
    pub area: Rectangle,
    /// The plotted numbers.
    pub series: Vec<PlottedSeries>,
    /// Units to choose from, each with its value for 1 in that of `y`; empty if there is one.
    pub units: Vec<(String, f64)>,
    height: f64,
    /// From the bottom up.
    layers: Vec<(LayerKind, Vec<Primitive>)>,
}

/// A series of values, as they can be read off a figure.
#[derive(Debug, Clone)]
pub struct PlottedSeries {
    /// The name in the legend: a channel, a record, or what is plotted of it.
    pub name: String,
    /// The values, in the order of the x axis.
    pub values: Vec<PlottedValue>,
}

impl PlottedSeries {
    pub(crate) fn of(name: &str, points: &[(f64, f64)]) -> Self {
        let values = points.iter().map(|(x, y)| PlottedValue { x: *x, y: *y, reach: None }).collect();
        Self { name: name.into(), values }
    }
}

/// One value of a series, in the units of the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlottedValue {
    /// Along the x axis.
    pub x: f64,
    /// Along the y axis.
    pub y: f64,
    /// From where to where it reaches: an interval, or the smallest and the largest sample; `None` if it
    /// has neither.
    pub reach: Option<(f64, f64)>,
}

impl Figure {
    /// The place of these values of both axes, in the coordinates of the drawing.
    pub fn place(&self, x: f64, y: f64) -> At {
        // farther outside nothing is drawn
        let far = |share: f64| share.clamp(-20.0, 21.0);
        let Rectangle { left, top, width, height } = self.area;
        (left + width * far(self.x.scale.share(x)), top + height * (1.0 - far(self.y.scale.share(y))))
    }

    /// What is drawn between the axes, from the bottom up, each with the number of its series.
    pub fn marks(&self) -> impl Iterator<Item = (usize, &Primitive)> {
        let of_series = self.layers.iter().filter_map(|(kind, marks)| match kind {
            LayerKind::Data(series) => Some((*series, marks)),
            LayerKind::Frame | LayerKind::Legend => None,
        });
        of_series.flat_map(|(series, marks)| marks.iter().map(move |mark| (series, mark)))
    }
}
