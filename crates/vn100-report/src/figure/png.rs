//! A drawing as pixels: the same bytes on every machine. Its letters are a Latin and Greek part of
//! DejaVu Sans, whose licence lies beside it.

use tiny_skia::{FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Rect, StrokeDash, Transform};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

use super::{
    DrawingError,
    drawing::{Anchor, At, Colour, Drawing, LayerKind, Marker, Primitive, Rectangle},
};

/// Pixels in a unit of the drawing.
const SCALE: f32 = 2.5;

pub(crate) fn file(drawing: &Drawing) -> Result<Vec<u8>, DrawingError> {
    let side = |length: f64| (length as f32 * SCALE).round() as u32;
    let (width, height) = (side(drawing.width), side(drawing.height));
    let mut canvas =
        Canvas { pixels: Pixmap::new(width, height).ok_or(DrawingError::Size)?, mask: None, font: Font::new()? };
    let [r, g, b] = Colour::Paper.rgb();
    canvas.pixels.fill(tiny_skia::Color::from_rgba8(r, g, b, 255));
    for layer in &drawing.layers {
        canvas.mask = match layer.kind {
            LayerKind::Data { clip, .. } => mask(width, height, clip),
            LayerKind::Frame | LayerKind::Legend => None,
        };
        layer.marks.iter().for_each(|mark| canvas.mark(mark));
    }
    canvas.pixels.encode_png().map_err(|_| DrawingError::Png)
}

struct Canvas<'a> {
    pixels: Pixmap,
    mask: Option<Mask>,
    font: Font<'a>,
}

impl Canvas<'_> {
    fn mark(&mut self, mark: &Primitive) {
        match mark {
            Primitive::Line { points, stroke } => {
                let dash = stroke.dash.lengths().iter().map(|length| *length as f32).collect();
                self.stroke(path(points, false), stroke.colour, stroke.width, StrokeDash::new(dash, 0.0), at(0.0, 0.0));
            }
            Primitive::Area { points, colour, opacity } => {
                self.fill(path(points, true), *colour, *opacity, at(0.0, 0.0))
            }
            Primitive::Symbol { at: (x, y), shape, colour } => {
                let outline = match shape.corners() {
                    [] => PathBuilder::from_circle(0.0, 0.0, Marker::RADIUS as f32),
                    corners => path(corners, true),
                };
                match shape.is_hollow() {
                    true => self.stroke(outline, *colour, 1.4, None, at(*x, *y)),
                    false => self.fill(outline, *colour, 1.0, at(*x, *y)),
                }
            }
            Primitive::Text { at: (x, y), text, size, anchor, upwards } => {
                let (outline, width) = self.font.outline(text, *size as f32);
                let along = match anchor {
                    Anchor::Start => 0.0,
                    Anchor::Middle => -width / 2.0,
                    Anchor::End => -width,
                };
                let turn = if *upwards { Transform::from_rotate(-90.0) } else { Transform::identity() };
                let place = at(*x, *y).pre_concat(turn).pre_translate(along, 0.0);
                self.fill(outline, Colour::Ink, 1.0, place);
            }
        }
    }

    fn stroke(&mut self, path: Option<Path>, colour: Colour, width: f64, dash: Option<StrokeDash>, place: Transform) {
        let Some(path) = path else { return };
        let stroke = tiny_skia::Stroke {
            width: width as f32,
            line_cap: LineCap::Butt,
            line_join: LineJoin::Round,
            dash,
            ..tiny_skia::Stroke::default()
        };
        self.pixels.stroke_path(&path, &paint(colour, 1.0), &stroke, place, self.mask.as_ref());
    }

    fn fill(&mut self, path: Option<Path>, colour: Colour, opacity: f64, place: Transform) {
        let Some(path) = path else { return };
        self.pixels.fill_path(&path, &paint(colour, opacity), FillRule::Winding, place, self.mask.as_ref());
    }
}

fn at(x: f64, y: f64) -> Transform {
    Transform::from_scale(SCALE, SCALE).pre_translate(x as f32, y as f32)
}

fn mask(width: u32, height: u32, clip: Rectangle) -> Option<Mask> {
    let mut mask = Mask::new(width, height)?;
    let area = Rect::from_xywh(clip.left as f32, clip.top as f32, clip.width as f32, clip.height as f32)?;
    mask.fill_path(&PathBuilder::from_rect(area), FillRule::Winding, true, at(0.0, 0.0));
    Some(mask)
}

fn paint(colour: Colour, opacity: f64) -> Paint<'static> {
    let [r, g, b] = colour.rgb();
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(r, g, b, (255.0 * opacity).round() as u8);
    paint
}

/// `None` for fewer than two points.
fn path(points: &[At], closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (index, (x, y)) in points.iter().enumerate() {
        match index {
            0 => builder.move_to(*x as f32, *y as f32),
            _ => builder.line_to(*x as f32, *y as f32),
        }
    }
    if closed {
        builder.close();
    }
    builder.finish()
}

static DEJAVU_SANS: &[u8] = include_bytes!("../../assets/DejaVuSans-subset.ttf");

const UNKNOWN: char = '?';

pub(crate) struct Font<'a> {
    face: Face<'a>,
}

impl Font<'_> {
    pub(crate) fn new() -> Result<Self, DrawingError> {
        let face = Face::parse(DEJAVU_SANS, 0).map_err(|_| DrawingError::Font)?;
        Ok(Self { face })
    }

    /// Width of `text` at a size of 1.
    pub(crate) fn width(&self, text: &str) -> f64 {
        let units: f64 = text.chars().map(|letter| f64::from(self.advance(self.glyph(letter)))).sum();
        units / f64::from(self.face.units_per_em())
    }

    /// `text` from 0 along its base line, y pointing down, and its width. No path for blanks alone.
    pub(crate) fn outline(&self, text: &str, size: f32) -> (Option<Path>, f32) {
        let scale = size / f32::from(self.face.units_per_em());
        let mut pen = Pen { builder: PathBuilder::new(), x: 0.0, scale };
        for letter in text.chars() {
            let glyph = self.glyph(letter);
            self.face.outline_glyph(glyph, &mut pen);
            pen.x += f32::from(self.advance(glyph)) * scale;
        }
        (pen.builder.finish(), pen.x)
    }

    fn glyph(&self, letter: char) -> GlyphId {
        self.face.glyph_index(letter).or_else(|| self.face.glyph_index(UNKNOWN)).unwrap_or_default()
    }

    fn advance(&self, glyph: GlyphId) -> u16 {
        self.face.glyph_hor_advance(glyph).unwrap_or_default()
    }
}

struct Pen {
    builder: PathBuilder,
    x: f32,
    scale: f32,
}

impl Pen {
    fn place(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x * self.scale, -y * self.scale)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.builder.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.builder.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.place(x1, y1), self.place(x, y));
        self.builder.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.place(x1, y1), self.place(x2, y2), self.place(x, y));
        self.builder.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.builder.close();
    }
}

#[cfg(test)]
mod tests {
    use crate::figure::drawing::{Dash, Layer, Stroke};

    use super::*;

    #[test]
    fn marks_leave_their_colour_and_are_cut_at_the_edge() {
        let stroke = Stroke { colour: Colour::Series(1), width: 4.0, dash: Dash::Solid };
        let line = Primitive::Line { points: vec![(0.0, 10.0), (40.0, 10.0)], stroke };
        let clip = Rectangle { left: 10.0, top: 0.0, width: 20.0, height: 20.0 };
        let layer = Layer { kind: LayerKind::Data { series: 0, clip }, marks: vec![line] };
        let bytes = file(&Drawing { width: 40.0, height: 20.0, layers: vec![layer] }).unwrap();
        let pixels = Pixmap::decode_png(&bytes).unwrap();
        let colour = |x: f32, y: f32| {
            let pixel = pixels.pixel((x * SCALE) as u32, (y * SCALE) as u32).unwrap();
            [pixel.red(), pixel.green(), pixel.blue()]
        };
        assert_eq!((pixels.width(), pixels.height()), (100, 50));
        assert_eq!(colour(20.0, 10.0), Colour::Series(1).rgb());
        assert_eq!(colour(5.0, 10.0), Colour::Paper.rgb());
        assert_eq!(colour(20.0, 4.0), Colour::Paper.rgb());
    }

    #[test]
    fn all_letters_of_figures_are_in_the_font() {
        let font = Font::new().unwrap();
        for letter in "azAZ019 .,:;()/+-−–√·×±≤≥°µστχ²³⁰¹⁴⁵⁶⁷⁸⁹⁻½".chars() {
            assert!(font.face.glyph_index(letter).is_some(), "{letter}");
        }
        assert!(font.width("mm") > 2.0 * font.width("i"));
        assert_eq!(font.outline(" ", 12.0).0, None);
    }
}
