//! What a figure consists of, before it becomes SVG.

/// A place in a drawing: from the left and from the top.
pub type At = (f64, f64);

/// What a layer of a drawing holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum LayerKind {
    Frame,
    Legend,
    /// One series of data, cut off at the edges of the rectangle.
    Data(usize),
}

/// A part of a drawing, in its coordinates: from the left and from the top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// The left edge.
    pub left: f64,
    /// The upper edge.
    pub top: f64,
    /// The length of the upper and the lower edge.
    pub width: f64,
    /// The length of the left and the right edge.
    pub height: f64,
}

impl Rectangle {
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        let meet = |from: f64, length: f64, other: f64, other_length: f64| {
            from < other + other_length && other < from + length
        };
        meet(self.left, self.width, other.left, other.width) && meet(self.top, self.height, other.top, other.height)
    }
}

/// A mark of a drawing.
#[derive(Debug, Clone)]
pub enum Primitive {
    /// A line.
    Line {
        /// The points that it goes through.
        points: Vec<At>,
        /// How it is drawn.
        stroke: Stroke,
    },
    /// A tinted area.
    Area {
        /// Its corners.
        points: Vec<At>,
        /// Its colour.
        colour: Colour,
        /// Its opacity, 0 to 1.
        opacity: f64,
    },
    /// A symbol.
    Symbol {
        /// Its middle.
        at: At,
        /// What it is.
        shape: Marker,
        /// Its colour.
        colour: Colour,
    },
    /// A line of text.
    Text {
        /// The place of its anchor on its baseline.
        at: At,
        /// The text.
        text: String,
        /// Height of its letters.
        size: f64,
        /// The part of the text at that place.
        anchor: Anchor,
        /// Whether it reads upwards.
        upwards: bool,
    },
}

/// Of the letters of a figure, but for its title.
pub(crate) const LETTERS: f64 = 11.5;

impl Primitive {
    /// A line of letters along the x axis.
    pub(crate) fn text(at: At, text: impl Into<String>, anchor: Anchor) -> Self {
        Self::Text { at, text: text.into(), size: LETTERS, anchor, upwards: false }
    }
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Stroke {
    /// Its colour.
    pub colour: Colour,
    /// Its width; below 1 for what lies behind the measurement.
    pub width: f64,
    pub(crate) dash: Dash,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dash {
    Solid,
    Dashed,
    Dotted,
    Mixed,
}

impl Dash {
    pub(crate) const fn lengths(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[6.0, 3.5],
            Self::Dotted => &[1.5, 3.0],
            Self::Mixed => &[7.0, 3.0, 1.5, 3.0],
        }
    }

    pub(crate) const fn of_series(series: usize) -> Self {
        match series % 4 {
            0 => Self::Solid,
            1 => Self::Dashed,
            2 => Self::Mixed,
            _ => Self::Dotted,
        }
    }
}

/// A symbol, distinct from others without colour, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Marker {
    pub(crate) shape: Shape,
    /// Whether only its outline is drawn: it is no result of the fit, or hardly known.
    pub is_hollow: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    Disc,
    Square,
    Triangle,
    Diamond,
}

/// The part of a text that stands at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Its beginning.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// Colours by what they are for. A page replaces them by its own, by their class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour {
    /// Of letters, and of what is read off a curve.
    Ink,
    /// Of the background.
    Paper,
    /// Of the frame.
    Axis,
    /// Of the lines of a grid.
    Grid,
    /// Of the lines between them.
    FineGrid,
    /// Of what is no measurement.
    Quiet,
    /// Of a series, by its number.
    Series(usize),
}

/// Distinct to the colour-blind: M. Okabe and K. Ito, "Color Universal Design" (2008).
const SERIES: [(&str, &str); 6] =
    [("c0", "#0072b2"), ("c1", "#d55e00"), ("c2", "#009e73"), ("c3", "#cc79a7"), ("c4", "#e69f00"), ("c5", "#56b4e9")];

impl Colour {
    /// Class in a style sheet, and red, green and blue in hexadecimal digits.
    pub(crate) const fn look(self) -> (&'static str, &'static str) {
        match self {
            Self::Ink => ("ink", "#1a1a1a"),
            Self::Paper => ("paper", "#ffffff"),
            Self::Axis => ("axis", "#5a5a5a"),
            Self::Grid => ("grid", "#c8c8c8"),
            Self::FineGrid => ("fine", "#e8e8e8"),
            Self::Quiet => ("quiet", "#6e6e6e"),
            Self::Series(index) => SERIES[index % SERIES.len()],
        }
    }
}

impl Shape {
    pub(crate) const fn filled(self) -> Marker {
        Marker { shape: self, is_hollow: false }
    }

    pub(crate) const fn hollow(self) -> Marker {
        Marker { shape: self, is_hollow: true }
    }

    pub(crate) const fn of_series(series: usize) -> Self {
        match series % 4 {
            0 => Self::Disc,
            1 => Self::Square,
            2 => Self::Triangle,
            _ => Self::Diamond,
        }
    }

    /// The corners about its middle; none for a circle of radius [`RADIUS`](Self::RADIUS).
    pub(crate) const fn corners(self) -> &'static [At] {
        match self {
            Self::Disc => &[],
            Self::Square => &[(-2.8, -2.8), (2.8, -2.8), (2.8, 2.8), (-2.8, 2.8)],
            Self::Triangle => &[(0.0, -3.7), (3.4, 2.6), (-3.4, 2.6)],
            Self::Diamond => &[(0.0, -4.0), (4.0, 0.0), (0.0, 4.0), (-4.0, 0.0)],
        }
    }

    pub(crate) const RADIUS: f64 = 3.1;
}
