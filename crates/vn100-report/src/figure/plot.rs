//! A figure while it is drawn: its frame and legend, and what every plot places in it.

use vn100_analysis::noise::{GraphicalReading, GraphicalReadings, Term};

use super::{
    Figure, PlotAxis,
    axes::{Scale, frame, square_decades},
    drawing::{Anchor, At, Colour, Dash, LETTERS, LayerKind, Marker, Primitive, Rectangle, Shape, Stroke},
    labels::free_place,
};

pub(super) const WIDTH: f64 = 480.0;
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

/// Of the rectangle in which a plot draws.
const AREA_HEIGHT: f64 = HEIGHT - 26.0 - 44.0;
const AREA_RIGHT: f64 = WIDTH - 18.0;

impl Figure {
    /// With decades as high as they are wide: the shorter side is continued.
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
        let texts: Vec<&str> = legend.iter().map(|(_, text)| text.as_str()).collect();
        let description = format!("{} over {}: {}", y.label(), x.label(), texts.join("; "));
        let mut figure = Self {
            id,
            title,
            description,
            x,
            y,
            area: Rectangle { left, top, width: AREA_RIGHT - left, height: AREA_HEIGHT },
            series: Vec::new(),
            units: Vec::new(),
            height: HEIGHT + top - 26.0,
            layers: Vec::new(),
        };
        figure.layers = vec![(LayerKind::Frame, frame(&figure)), (LayerKind::Legend, marks)];
        figure
    }

    /// Draws in a layer of its own that belongs to `series`.
    pub(super) fn draw(&mut self, series: usize, marks: Vec<Primitive>) {
        self.layers.push((LayerKind::Data(series), marks));
    }

    pub(super) fn line(&self, values: impl IntoIterator<Item = (f64, f64)>, stroke: Stroke) -> Primitive {
        Primitive::Line { points: values.into_iter().map(|(x, y)| self.place(x, y)).collect(), stroke }
    }

    /// A line through these places, with the symbol of the series at each.
    pub(super) fn marked_line(&self, series: usize, values: &[(f64, f64)], stroke: Stroke) -> Vec<Primitive> {
        let symbol = |(x, y): &(f64, f64)| self.symbol_of(series, *x, *y);
        let line = self.line(values.iter().copied(), stroke);
        [line].into_iter().chain(values.iter().map(symbol)).collect()
    }

    pub(super) fn symbol_of(&self, series: usize, x: f64, y: f64) -> Primitive {
        self.symbol(x, y, Shape::of_series(series).filled(), Colour::Series(series))
    }

    pub(super) fn symbol(&self, x: f64, y: f64, shape: Marker, colour: Colour) -> Primitive {
        Primitive::Symbol { at: self.place(x, y), shape, colour }
    }

    /// Writes a short text beside the first of these places where it keeps clear of all that is
    /// drawn so far, in a layer of `series`; nothing if it does not fit into the plot.
    pub(super) fn label(&mut self, series: usize, beside: &[(f64, f64)], text: &str) {
        let places: Vec<_> = beside.iter().map(|(x, y)| self.place(*x, *y)).collect();
        let drawn: Vec<&Primitive> = self.marks().map(|(_, mark)| mark).collect();
        if let Some((at, anchor)) = free_place(&drawn, &self.area, &places, width_of(text), width_of) {
            self.draw(series, vec![Primitive::text(at, text, anchor)]);
        }
    }
}

/// √(2 ln 2/π): the flat part of a curve over its B.
pub(super) const FLAT: f64 = 0.664_28;

/// A straight line on logarithmic scales, through the deviation at an averaging time.
pub(super) struct SlopedLine {
    pub(super) tau_s: f64,
    pub(super) deviation: f64,
    pub(super) slope: f64,
    pub(super) dash: Dash,
}

impl SlopedLine {
    pub(super) fn at(&self, tau_s: f64) -> f64 {
        self.deviation * (tau_s / self.tau_s).powf(self.slope)
    }

    /// From one side of the plot to the other.
    pub(super) fn drawn(&self, plot: &Figure, colour: Colour, width: f64) -> Primitive {
        let Scale { from, to, .. } = plot.x.scale;
        plot.line([from, to].map(|tau_s| (tau_s, self.at(tau_s))), Stroke { colour, width, dash: self.dash })
    }

    /// A symbol at the deviation that it goes through.
    pub(super) fn symbol(&self, plot: &Figure, shape: Marker) -> Primitive {
        plot.symbol(self.tau_s, self.deviation, shape, Colour::Ink)
    }

    /// Places along it that lie in the plot, from its left end.
    pub(super) fn along(&self, plot: &Figure) -> Vec<(f64, f64)> {
        const PLACES: usize = 48;
        let (x, y) = (plot.x.scale, plot.y.scale);
        let places = (1..PLACES).map(|place| x.from * (x.to / x.from).powf(place as f64 / PLACES as f64));
        places.map(|x| (x, self.at(x))).filter(|(_, value)| (y.from..=y.to).contains(value)).collect()
    }

    /// Writes a text at the deviation that it goes through, or else along it.
    pub(super) fn label(&self, plot: &mut Figure, series: usize, text: &str) {
        let places: Vec<_> = [(self.tau_s, self.deviation)].into_iter().chain(self.along(plot)).collect();
        plot.label(series, &places, text);
    }
}

/// The line through the place of a reading, in a plot of `factor` times the SI unit.
pub(super) fn read_line(term: Term, read: &GraphicalReading, factor: f64) -> Option<SlopedLine> {
    let (tau_s, level, slope, dash) = match term {
        Term::BiasInstability => (read.tau_s?, FLAT, 0.0, Dash::Dotted),
        Term::RateRandomWalk => (GraphicalReadings::RANDOM_WALK_TAU_S, 1.0, 0.5, Dash::Mixed),
        Term::White | Term::Quantization | Term::RateRamp => (GraphicalReadings::WHITE_TAU_S, 1.0, -0.5, Dash::Dashed),
    };
    Some(SlopedLine { tau_s, deviation: read.value? * level * factor, slope, dash })
}

/// Where a plot begins beside the numbers of its upright axis.
fn left_of(y: &PlotAxis) -> f64 {
    let labels = y.scale.ticks();
    let widths = labels.iter().filter_map(|tick| tick.label.as_deref()).map(width_of);
    widths.fold(0.0, f64::max) + LETTERS + 16.0
}

/// The width of a letter over its height: that of most letters of DejaVu Sans, the font that an
/// SVG names first.
const PER_LETTER: f64 = 0.64;

/// Of a text in letters of the usual size.
fn width_of(text: &str) -> f64 {
    LETTERS * PER_LETTER * text.chars().count() as f64
}

impl LegendSample {
    fn draw(self, (x, y): At, marks: &mut Vec<Primitive>) {
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
