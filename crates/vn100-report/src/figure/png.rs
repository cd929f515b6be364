//! A drawing as pixels, with letters from an embedded font: the same bytes on every machine.

use tiny_skia::{FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Rect, StrokeDash, Transform};

use super::{
    DrawingError,
    drawing::{Anchor, At, Colour, Drawing, LayerKind, Primitive, Rectangle, Shape},
    font::Font,
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
                    [] => PathBuilder::from_circle(0.0, 0.0, Shape::RADIUS as f32),
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

#[cfg(test)]
mod tests {
    use super::super::drawing::{Dash, Layer, Stroke};
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
}
