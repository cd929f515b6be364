//! A plot while it is drawn: its frame and legend, and what every plot places in it.

use super::{
    Figure, PlotAxis, PlottedSeries,
    axes::{Place, frame, square_decades},
    drawing::{
        self, Anchor, Colour, Dash, Drawing, LETTERS, Layer, LayerKind, Marker, Primitive, Rectangle, Shape, Stroke,
    },
    labels::free_place,
};

const WIDTH: f64 = 480.0;
const HEIGHT: f64 = 330.0;

#[derive(Debug, Clone, Copy)]
pub(super) enum LegendSample {
    Line(Stroke),
    Symbol(Marker, Colour),
    Both(Stroke, Marker),
    Area(Colour, f64),
    /// A text alone.
    Nothing,
}

/// A figure that is being drawn.
pub(super) struct Plot {
    figure: Figure,
    pub(super) place: Place,
}

/// Of the rectangle in which a plot draws.
const AREA_HEIGHT: f64 = HEIGHT - 26.0 - 44.0;
const AREA_RIGHT: f64 = WIDTH - 18.0;

impl Plot {
    /// With decades as high as they are wide, so that a slope of −½ looks like one: the shorter
    /// side is continued.
    pub(super) fn with_square_decades(
        id: String,
        title: String,
        mut x: PlotAxis,
        mut y: PlotAxis,
        legend: &[(LegendSample, String)],
    ) -> Self {
        let (narrow, low) = (x.scale, y.scale);
        // longer scales may have wider labels
        for _ in 0..2 {
            let width = AREA_RIGHT - left_of(&y);
            (x.scale, y.scale) = square_decades(narrow, low, width / AREA_HEIGHT);
        }
        Self::new(id, title, x, y, legend)
    }

    pub(super) fn new(id: String, title: String, x: PlotAxis, y: PlotAxis, legend: &[(LegendSample, String)]) -> Self {
        const ROW: f64 = 16.0;
        const TITLE: f64 = 13.0;
        let left = left_of(&y);
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
            let entry = before + width_of(text) + 12.0;
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
    pub(super) fn draw(&mut self, series: usize, marks: Vec<Primitive>) {
        self.figure.drawing.layers.push(Layer { kind: LayerKind::Data(series), marks });
    }

    pub(super) fn line(&self, values: impl IntoIterator<Item = (f64, f64)>, stroke: Stroke) -> Primitive {
        Primitive::Line { points: values.into_iter().map(|(x, y)| self.place.of(x, y)).collect(), stroke }
    }

    /// A line through these places, with the symbol of the series at each.
    pub(super) fn marked_line(&self, series: usize, values: &[(f64, f64)], stroke: Stroke) -> Vec<Primitive> {
        let symbol =
            |(x, y): &(f64, f64)| self.symbol(*x, *y, Shape::of_series(series).filled(), Colour::Series(series));
        let line = self.line(values.iter().copied(), stroke);
        [line].into_iter().chain(values.iter().map(symbol)).collect()
    }

    pub(super) fn symbol(&self, x: f64, y: f64, shape: Marker, colour: Colour) -> Primitive {
        Primitive::Symbol { at: self.place.of(x, y), shape, colour }
    }

    /// Places along a curve that lie in the plot, from its left end.
    pub(super) fn along(&self, curve: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        const PLACES: usize = 48;
        let (x, y) = (self.place.x, self.place.y);
        let places = (1..PLACES).map(|place| x.from * (x.to / x.from).powf(place as f64 / PLACES as f64));
        places.map(|x| (x, curve(x))).filter(|(_, value)| (y.from..=y.to).contains(value)).collect()
    }

    /// Writes a short text beside the first of these places where it keeps clear of all that is
    /// drawn so far, in a layer of `series`; nothing if it does not fit into the plot.
    pub(super) fn label(&mut self, series: usize, beside: &[(f64, f64)], text: &str) {
        let places: Vec<_> = beside.iter().map(|(x, y)| self.place.of(*x, *y)).collect();
        if let Some((at, anchor)) =
            free_place(&self.figure.drawing, &self.place.area, &places, width_of(text), width_of)
        {
            self.draw(series, vec![Primitive::text(at, text, anchor)]);
        }
    }

    pub(super) fn done(self, series: Vec<PlottedSeries>) -> Figure {
        Figure { series, ..self.figure }
    }
}

/// Where a plot begins beside the numbers of its upright axis.
fn left_of(y: &PlotAxis) -> f64 {
    let labels = y.scale.ticks();
    let widths = labels.iter().filter_map(|tick| tick.label.as_deref()).map(width_of);
    widths.fold(0.0, f64::max) + LETTERS + 16.0
}

/// The width of a letter over its height: that of most letters of DejaVu Sans, the font that an SVG
/// names first.
const PER_LETTER: f64 = 0.64;

/// Of a text in letters of the usual size.
fn width_of(text: &str) -> f64 {
    LETTERS * PER_LETTER * text.chars().count() as f64
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

pub(super) fn solid(series: usize, width: f64) -> Stroke {
    Stroke { colour: Colour::Series(series), width, dash: Dash::Solid }
}

pub(super) fn quiet(width: f64, dash: Dash) -> Stroke {
    Stroke { colour: Colour::Quiet, width, dash }
}
