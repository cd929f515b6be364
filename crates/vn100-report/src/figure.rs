//! The figures of a report, made once for the page and for the files beside it: each is drawn once,
//! as SVG or as pixels, and keeps the numbers that it shows.
//!
//! Both come from one [`Drawing`] of lines, areas, symbols and texts, and the pixels are not made
//! from the SVG: a renderer of SVG with text brings 28 packages, and the fonts of the machine.

mod allan;
mod axes;
mod drawing;
mod fitted_model;
mod graphical;
mod histogram;
mod over_time;
mod png;
mod spectrum;
mod svg;

use thiserror::Error;
use vn100_analysis::protocol::Quantity;
use vn100_analysis::{SENSORS, axes_name};

pub use allan::allan_in_unit;
pub(crate) use axes::{PlotAxis, Scale, superscript};
pub(crate) use drawing::Rectangle;

use crate::{measured::Record, names::names_of, units::ChannelValues};
pub(crate) use allan::id_of;
use allan::{allan_of_axes, allan_of_each, allan_of_records};
use axes::{Place, frame, square_decades};
use drawing::{Anchor, Colour, Dash, Drawing, LETTERS, Layer, LayerKind, Marker, Primitive, Stroke};
use graphical::graphical;
use histogram::histogram;
use over_time::{envelope, segments};
use png::Font;
use spectrum::spectrum;

/// Those of one record and those of several.
#[derive(Debug, Clone, Default)]
pub struct Figures {
    /// The axes of each sensor together.
    pub(crate) allan_sensors: Vec<Figure>,
    pub(crate) allan_axes: Vec<Figure>,
    /// With the lines that the graphical slope method draws.
    pub(crate) graphical: Vec<Figure>,
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
        let mut all = Self::default();
        for (quantity, sensor) in SENSORS {
            let (id, name) = (axes_name(sensor), names_of(quantity).title);
            let axes = record.of(quantity);
            let sheet = axes.first().map_or(&[][..], |channel| record.verdicts(channel));
            all.allan_sensors.extend(allan_of_axes(id, name, &axes, sheet, deviation));
            all.allan_axes.extend(allan_of_each(&axes, deviation));
            all.graphical
                .extend(axes.iter().find(|channel| channel.name.ends_with("_y")).and_then(|y| graphical(y, deviation)));
            all.spectra.extend(spectrum(id, name, &axes));
            all.segments.extend(segments(id, name, &axes));
        }
        let series = record.of(Quantity::Value);
        all.allan_axes.extend(allan_of_each(&series, deviation));
        all.spectra.extend(spectrum("value", names_of(Quantity::Value).title, &series));
        for (quantity, id) in [(Quantity::Angle, "attitude"), (Quantity::Quaternion, "quaternion")] {
            all.segments.extend(segments(id, "Orientation", &record.of(quantity)));
        }
        // what was read between the lines has no such figure
        for channel in record.channels.iter().take(record.measured.snapshot.channels.len()) {
            all.times.extend(envelope(channel));
            all.histograms.extend(histogram(channel));
        }
        let Self { allan_sensors, allan_axes, graphical, times, histograms, spectra, segments } = &mut all;
        for figures in [allan_sensors, allan_axes, graphical, times, histograms, spectra, segments] {
            for figure in figures {
                figure.id.insert_str(0, prefix);
                figure.prefix = prefix.len();
            }
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
        let Self { allan_sensors, allan_axes, graphical, times, histograms, spectra, segments } = self;
        [allan_sensors, allan_axes, graphical, times, histograms, spectra, segments].into_iter().flatten()
    }
}

const WIDTH: f64 = 480.0;
const HEIGHT: f64 = 330.0;

/// A figure cannot be drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum DrawingError {
    /// This program was built with a damaged font.
    #[error("the embedded font is damaged")]
    Font,
    /// It has no area, or too much of it.
    #[error("a figure without a size cannot be drawn")]
    Size,
    /// The pixels make no file.
    #[error("the pixels cannot be written as PNG")]
    Png,
}

/// A figure as it is shown and kept.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Unique in a report, of letters, digits, `-` and `_`: the stem of its file.
    pub id: String,
    /// Length of what `id` begins with in a report of several records.
    prefix: usize,
    pub(crate) title: String,
    /// What it shows, with the values that stand in its legend.
    pub(crate) description: String,
    pub(crate) x: PlotAxis,
    pub(crate) y: PlotAxis,
    pub(crate) area: Rectangle,
    pub(crate) series: Vec<PlottedSeries>,
    /// Units to choose from, each with its value for 1 in that of `y`; empty where there is one.
    pub(crate) units: Vec<(String, f64)>,
    drawing: Drawing,
}

/// A series of values, as they can be read off a figure.
#[derive(Debug, Clone)]
pub(crate) struct PlottedSeries {
    pub(crate) name: String,
    pub(crate) values: Vec<Value>,
}

impl PlottedSeries {
    pub(crate) fn of(name: &str, points: &[(f64, f64)]) -> Self {
        let values = points.iter().map(|(x, y)| Value { x: *x, y: *y, reach: None }).collect();
        Self { name: name.into(), values }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Value {
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// How far it reaches: an interval, or smallest and largest.
    pub(crate) reach: Option<(f64, f64)>,
}

impl Figure {
    /// Its `id` without the run that it belongs to: kind, then channel or sensor, as
    /// `allan-gyro_y`.
    #[must_use]
    pub fn name(&self) -> &str {
        self.id.get(self.prefix..).unwrap_or(&self.id)
    }

    pub(crate) fn svg_element(&self) -> String {
        svg::element(&self.drawing, &self.id, [&self.title, &self.description], "")
    }

    /// A file of its own.
    #[must_use]
    pub fn svg_file(&self) -> String {
        svg::file(&self.drawing, &self.id, [&self.title, &self.description])
    }

    /// The same as pixels.
    ///
    /// # Errors
    /// None, unless the figure has no size, or this program was built with a damaged font.
    pub fn png_file(&self) -> Result<Vec<u8>, DrawingError> {
        png::file(&self.drawing)
    }
}

#[derive(Debug, Clone, Copy)]
enum LegendSample {
    Line(Stroke),
    Symbol(Marker, Colour),
    Both(Stroke, Marker),
    Area(Colour, f64),
    /// A text alone.
    Nothing,
}

struct Plot {
    figure: Figure,
    place: Place,
}

/// Of the rectangle in which a plot draws.
const AREA_HEIGHT: f64 = HEIGHT - 26.0 - 44.0;
const AREA_RIGHT: f64 = WIDTH - 18.0;

impl Plot {
    /// With decades as high as they are wide, so that a slope of −½ looks like one: the shorter
    /// side is continued.
    fn with_square_decades(
        id: String,
        title: String,
        mut x: PlotAxis,
        mut y: PlotAxis,
        legend: &[(LegendSample, String)],
    ) -> Self {
        let font = Font::new().ok();
        let (narrow, low) = (x.scale, y.scale);
        // longer scales may have wider labels
        for _ in 0..2 {
            let width = AREA_RIGHT - left_of(&y, font.as_ref());
            (x.scale, y.scale) = square_decades(narrow, low, width / AREA_HEIGHT);
        }
        Self::new(id, title, x, y, legend)
    }

    fn new(id: String, title: String, x: PlotAxis, y: PlotAxis, legend: &[(LegendSample, String)]) -> Self {
        const ROW: f64 = 16.0;
        const TITLE: f64 = 13.0;
        // without its font a figure has roughly the same layout; its pixels need it
        let font = Font::new().ok();
        let left = left_of(&y, font.as_ref());
        let title_mark = Primitive::Text {
            at: (left, 17.0),
            text: title.clone(),
            size: TITLE,
            anchor: Anchor::Start,
            upwards: false,
        };
        let (mut marks, mut x_next, mut y_next) = (vec![title_mark], left, 17.0 + ROW);
        for (sample, text) in legend {
            let before = if matches!(sample, LegendSample::Nothing) { 0.0 } else { 28.0 };
            let entry = before + width_of(text, font.as_ref()) + 12.0;
            if x_next > left && x_next + entry > WIDTH {
                (x_next, y_next) = (left, y_next + ROW);
            }
            sample.draw((x_next, y_next - 4.0), &mut marks);
            marks.push(Primitive::text((x_next + before, y_next), text, Anchor::Start));
            x_next += entry;
        }
        let top = if legend.is_empty() { 26.0 } else { y_next + 8.0 };
        let bottom = HEIGHT + top - 26.0;
        let area = Rectangle { left, top, width: AREA_RIGHT - left, height: AREA_HEIGHT };
        let place = Place { area, x: x.scale, y: y.scale };
        let layers = vec![
            Layer { kind: LayerKind::Frame, marks: frame(&place, &x, &y) },
            Layer { kind: LayerKind::Legend, marks },
        ];
        let drawing = Drawing { width: WIDTH, height: bottom, layers };
        let texts: Vec<&str> = legend.iter().map(|(_, text)| text.as_str()).collect();
        let description = format!("{} over {}: {}", y.label(), x.label(), texts.join("; "));
        Self {
            figure: Figure {
                id,
                prefix: 0,
                title,
                description,
                x,
                y,
                area,
                series: Vec::new(),
                units: Vec::new(),
                drawing,
            },
            place,
        }
    }

    /// Draws in a layer of its own that belongs to `series`.
    fn draw(&mut self, series: usize, marks: Vec<Primitive>) {
        let kind = LayerKind::Data { series, clip: self.place.area };
        self.figure.drawing.layers.push(Layer { kind, marks });
    }

    fn line(&self, values: impl IntoIterator<Item = (f64, f64)>, stroke: Stroke) -> Primitive {
        Primitive::Line { points: values.into_iter().map(|(x, y)| self.place.of(x, y)).collect(), stroke }
    }

    /// A line through these places, with the symbol of the series at each.
    fn marked_line(&self, series: usize, values: &[(f64, f64)], stroke: Stroke) -> Vec<Primitive> {
        let symbol = |(x, y): &(f64, f64)| self.symbol(*x, *y, Marker::of_series(series), Colour::Series(series));
        let line = self.line(values.iter().copied(), stroke);
        [line].into_iter().chain(values.iter().map(symbol)).collect()
    }

    fn symbol(&self, x: f64, y: f64, shape: Marker, colour: Colour) -> Primitive {
        Primitive::Symbol { at: self.place.of(x, y), shape, colour }
    }

    /// A short text above and right of a place, or left of it near the right edge.
    fn note(&self, x: f64, y: f64, text: impl Into<String>) -> Primitive {
        let (at, anchor) = self.note_place(x, y);
        Primitive::text(at, text, anchor)
    }

    fn note_place(&self, x: f64, y: f64) -> (drawing::At, Anchor) {
        let (left, top) = self.place.of(x, y);
        let near_edge = self.place.x.share(x) > 0.7;
        let (off, anchor) = if near_edge { (-6.0, Anchor::End) } else { (6.0, Anchor::Start) };
        ((left + off, top - 5.0), anchor)
    }

    /// What such a text covers, and some space beside it.
    fn note_room(&self, x: f64, y: f64, text: &str) -> Rectangle {
        let ((left, bottom), anchor) = self.note_place(x, y);
        let width = width_of(text, None) + 4.0;
        let left = if anchor == Anchor::End { left - width } else { left };
        Rectangle { left, top: bottom - LETTERS, width, height: LETTERS + 2.0 }
    }

    /// What a symbol covers.
    fn symbol_room(&self, x: f64, y: f64) -> Rectangle {
        let (left, top) = self.place.of(x, y);
        Rectangle { left: left - 3.0, top: top - 3.0, width: 6.0, height: 6.0 }
    }

    /// A short text above a level, at the left edge, where no curve of a sensor comes down to it.
    fn note_at_edge(&self, y: f64, text: &str) -> Primitive {
        let (left, top) = (self.place.area.left, self.place.of(1.0, y).1);
        Primitive::text((left + 8.0, top - 5.0), text, Anchor::Start)
    }

    fn done(self, series: Vec<PlottedSeries>) -> Figure {
        Figure { series, ..self.figure }
    }
}

/// Where a plot begins beside the numbers of its upright axis.
fn left_of(y: &PlotAxis, font: Option<&Font<'_>>) -> f64 {
    let labels = y.scale.ticks();
    let widths = labels.iter().filter_map(|tick| tick.label.as_deref()).map(|label| width_of(label, font));
    widths.fold(0.0, f64::max) + LETTERS + 16.0
}

/// Of a text in letters of the usual size.
fn width_of(text: &str, font: Option<&Font<'_>>) -> f64 {
    LETTERS * font.map_or(0.6 * text.len() as f64, |font| font.width(text))
}

impl LegendSample {
    fn draw(self, (x, y): drawing::At, marks: &mut Vec<Primitive>) {
        let line = |stroke| Primitive::Line { points: vec![(x, y), (x + 22.0, y)], stroke };
        let symbol = |shape, colour| Primitive::Symbol { at: (x + 11.0, y), shape, colour };
        match self {
            Self::Nothing => {}
            Self::Line(stroke) => marks.push(line(stroke)),
            Self::Symbol(shape, colour) => marks.push(symbol(shape, colour)),
            Self::Both(stroke, shape) => marks.extend([line(stroke), symbol(shape, stroke.colour)]),
            Self::Area(colour, opacity) => {
                let corners = [(0.0, -5.0), (22.0, -5.0), (22.0, 5.0), (0.0, 5.0)];
                let points = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
                marks.push(Primitive::Area { points, colour, opacity });
            }
        }
    }
}

fn solid(series: usize, width: f64) -> Stroke {
    Stroke { colour: Colour::Series(series), width, dash: Dash::Solid }
}

fn quiet(width: f64, dash: Dash) -> Stroke {
    Stroke { colour: Colour::Quiet, width, dash }
}

/// As people write units.
pub(crate) fn pretty_unit(unit: &str) -> String {
    let unit = match unit.strip_prefix('u') {
        Some(rest) if rest.starts_with("g/") || rest == "g" || rest == "rad" => format!("µ{rest}"),
        _ => unit.to_owned(),
    };
    let written = [
        ("sqrt(Hz)", "√Hz"),
        ("sqrt(h)", "√h"),
        ("sqrt(s)", "√s"),
        ("^1.5", "¹·⁵"),
        ("^2", "²"),
        ("^3", "³"),
        ("deg", "°"),
    ];
    written.into_iter().fold(unit, |unit, (plain, pretty)| unit.replace(plain, pretty))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_written_as_people_do() {
        for (unit, pretty) in [
            ("rad/s/sqrt(Hz)", "rad/s/√Hz"),
            ("m/s^2", "m/s²"),
            ("deg/h^1.5", "°/h¹·⁵"),
            ("ug/sqrt(Hz)", "µg/√Hz"),
            ("gauss", "gauss"),
            ("urad", "µrad"),
        ] {
            assert_eq!(pretty_unit(unit), pretty);
        }
    }
}
