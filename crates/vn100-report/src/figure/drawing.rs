//! What a figure consists of, before it becomes SVG.

pub(crate) type At = (f64, f64);

/// A drawing of a fixed size, in layers from the bottom up.
#[derive(Debug, Clone, Default)]
pub(crate) struct Drawing {
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) layers: Vec<Layer>,
}

#[derive(Debug, Clone)]
pub(crate) struct Layer {
    pub(crate) kind: LayerKind,
    pub(crate) marks: Vec<Primitive>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum LayerKind {
    Frame,
    Legend,
    /// One series of data, cut off at the edges of the rectangle.
    Data {
        series: usize,
        clip: Rectangle,
    },
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

#[derive(Debug, Clone)]
pub(crate) enum Primitive {
    Line { points: Vec<At>, stroke: Stroke },
    Area { points: Vec<At>, colour: Colour, opacity: f64 },
    Symbol { at: At, shape: Marker, colour: Colour },
    Text { at: At, text: String, size: f64, anchor: Anchor, upwards: bool },
}

/// Of the letters of a figure, but for its title.
pub(crate) const LETTERS: f64 = 11.5;

impl Primitive {
    /// A line of letters along the x axis.
    pub(crate) fn text(at: At, text: impl Into<String>, anchor: Anchor) -> Self {
        Self::Text { at, text: text.into(), size: LETTERS, anchor, upwards: false }
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Stroke {
    pub(crate) colour: Colour,
    pub(crate) width: f64,
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
}

/// Distinct without colour, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Marker {
    Disc,
    Square,
    Triangle,
    Diamond,
    /// Hollow, for what is no result of the fit, or hardly known.
    Ring,
    HollowSquare,
    HollowTriangle,
    HollowDiamond,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// Colours by what they are for. A page replaces them by its own, by their class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Colour {
    Ink,
    Paper,
    Axis,
    Grid,
    FineGrid,
    Quiet,
    Series(usize),
}

/// Distinct to the colour-blind: M. Okabe and K. Ito, "Color Universal Design" (2008).
const SERIES: [(&str, [u8; 3]); 6] = [
    ("c0", [0, 114, 178]),
    ("c1", [213, 94, 0]),
    ("c2", [0, 158, 115]),
    ("c3", [204, 121, 167]),
    ("c4", [230, 159, 0]),
    ("c5", [86, 180, 233]),
];

impl Colour {
    /// Class in a style sheet, and red, green and blue.
    const fn look(self) -> (&'static str, [u8; 3]) {
        match self {
            Self::Ink => ("ink", [26, 26, 26]),
            Self::Paper => ("paper", [255, 255, 255]),
            Self::Axis => ("axis", [90, 90, 90]),
            Self::Grid => ("grid", [200, 200, 200]),
            Self::FineGrid => ("fine", [232, 232, 232]),
            Self::Quiet => ("quiet", [110, 110, 110]),
            Self::Series(index) => SERIES[index % SERIES.len()],
        }
    }

    pub(crate) const fn rgb(self) -> [u8; 3] {
        self.look().1
    }

    pub(crate) const fn class(self) -> &'static str {
        self.look().0
    }
}

impl Marker {
    pub(crate) const fn of_series(series: usize) -> Self {
        match series % 4 {
            0 => Self::Disc,
            1 => Self::Square,
            2 => Self::Triangle,
            _ => Self::Diamond,
        }
    }

    pub(crate) const fn hollow(self) -> Self {
        match self {
            Self::Disc | Self::Ring => Self::Ring,
            Self::Square | Self::HollowSquare => Self::HollowSquare,
            Self::Triangle | Self::HollowTriangle => Self::HollowTriangle,
            Self::Diamond | Self::HollowDiamond => Self::HollowDiamond,
        }
    }

    pub(crate) const fn is_hollow(self) -> bool {
        matches!(self, Self::Ring | Self::HollowSquare | Self::HollowTriangle | Self::HollowDiamond)
    }

    /// The corners about its middle; none for a circle of radius [`RADIUS`](Self::RADIUS).
    pub(crate) const fn corners(self) -> &'static [At] {
        match self {
            Self::Disc | Self::Ring => &[],
            Self::Square | Self::HollowSquare => &[(-2.8, -2.8), (2.8, -2.8), (2.8, 2.8), (-2.8, 2.8)],
            Self::Triangle | Self::HollowTriangle => &[(0.0, -3.7), (3.4, 2.6), (-3.4, 2.6)],
            Self::Diamond | Self::HollowDiamond => &[(0.0, -4.0), (4.0, 0.0), (0.0, 4.0), (-4.0, 0.0)],
        }
    }

    pub(crate) const RADIUS: f64 = 3.1;
}

impl Dash {
    pub(crate) const fn of_series(series: usize) -> Self {
        match series % 4 {
            0 => Self::Solid,
            1 => Self::Dashed,
            2 => Self::Mixed,
            _ => Self::Dotted,
        }
    }
}
