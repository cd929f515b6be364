//! The letters of figures: a Latin and Greek part of DejaVu Sans, whose licence lies beside it.

use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

use super::DrawingError;

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
    use super::*;

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
