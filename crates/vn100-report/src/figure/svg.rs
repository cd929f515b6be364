//! A drawing as SVG. On a page, colours come from its style sheet; alone, from the attributes.

use std::fmt::{self, Write};

use super::drawing::{Anchor, At, Colour, LayerKind, Marker, Primitive, Rectangle, Shape};
use super::{Figure, plot::WIDTH};

impl Figure {
    /// The figure as an element `svg` of an HTML page, with a title and a description for screen
    /// readers. A style sheet may give other colours to its classes.
    pub fn svg_element(&self) -> String {
        svg(self, "")
    }

    /// The figure as an SVG file of its own.
    pub fn svg_file(&self) -> String {
        let more = format!(
            " xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{}\" font-family=\"DejaVu Sans, Verdana, sans-serif\"",
            self.height
        );
        svg(self, &more)
    }
}

fn svg(figure: &Figure, attributes: &str) -> String {
    let mut out = String::new();
    // a String takes everything
    let _ = write_figure(&mut out, figure, attributes);
    out
}

fn write_figure(out: &mut String, figure: &Figure, attributes: &str) -> fmt::Result {
    let Figure { id, title, description, area, height, layers, .. } = figure;
    write!(out, "<svg{attributes} class=\"figure\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\">")?;
    write!(out, "<title>{}</title><desc>{}</desc>", escaped(title), escaped(description))?;
    let Rectangle { left, top, width, height } = area;
    write!(
        out,
        "<clipPath id=\"clip-{id}\"><rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/></clipPath>"
    )?;
    write!(out, "<rect width=\"100%\" height=\"100%\" class=\"paper\" fill=\"{}\"/>", Colour::Paper.look().1)?;
    for (kind, marks) in layers {
        write_layer(out, *kind, marks, id)?;
    }
    out.write_str("</svg>")
}

fn write_layer(out: &mut String, kind: LayerKind, marks: &[Primitive], id: &str) -> fmt::Result {
    match kind {
        LayerKind::Frame => out.write_str("<g class=\"frame\">")?,
        LayerKind::Legend => out.write_str("<g class=\"legend\">")?,
        LayerKind::Data(series) => {
            write!(out, "<g class=\"data series s{series}\" clip-path=\"url(#clip-{id})\">")?;
        }
    }
    for mark in marks {
        write_mark(out, mark)?;
    }
    out.write_str("</g>")
}

fn write_mark(out: &mut String, mark: &Primitive) -> fmt::Result {
    match mark {
        Primitive::Line { points, stroke } => {
            let (class, colour) = stroke.colour.look();
            write!(
                out,
                "<path fill=\"none\" class=\"l {class}\" stroke=\"{colour}\" stroke-width=\"{}\"",
                stroke.width
            )?;
            if !stroke.dash.lengths().is_empty() {
                let lengths: Vec<String> = stroke.dash.lengths().iter().map(ToString::to_string).collect();
                write!(out, " stroke-dasharray=\"{}\"", lengths.join(" "))?;
            }
            write!(out, " d=\"{}\"/>", path(points))
        }
        Primitive::Area { points, colour, opacity } => {
            let (class, colour) = colour.look();
            let path = path(points);
            write!(out, "<path class=\"a {class}\" fill=\"{colour}\" fill-opacity=\"{opacity}\" d=\"{path}Z\"/>")
        }
        Primitive::Symbol { at, shape, colour } => write_symbol(out, *at, *shape, *colour),
        Primitive::Text { at, text, size, anchor, upwards } => {
            let turned = if *upwards { "rotate(-90)" } else { "" };
            let anchor = match anchor {
                Anchor::Start => "",
                Anchor::Middle => " text-anchor=\"middle\"",
                Anchor::End => " text-anchor=\"end\"",
            };
            write!(out, "<text transform=\"translate({} {}){turned}\"{anchor}", short(at.0), short(at.1))?;
            write!(out, " font-size=\"{size}\" fill=\"{}\">{}</text>", Colour::Ink.look().1, escaped(text))
        }
    }
}

fn write_symbol(out: &mut String, at: At, shape: Marker, colour: Colour) -> fmt::Result {
    let (class, rgb) = colour.look();
    let paint = if shape.is_hollow {
        format!("class=\"h {class}\" fill=\"none\" stroke=\"{rgb}\" stroke-width=\"1.4\"")
    } else {
        format!("class=\"a {class}\" fill=\"{rgb}\"")
    };
    write!(out, "<g transform=\"translate({} {})\">", short(at.0), short(at.1))?;
    match shape.shape.corners() {
        [] => write!(out, "<circle r=\"{}\" {paint}/>", Shape::RADIUS)?,
        corners => write!(out, "<path d=\"{}Z\" {paint}/>", path(corners))?,
    }
    out.write_str("</g>")
}

fn path(points: &[At]) -> String {
    let mut out = String::with_capacity(points.len() * 10);
    for (index, (x, y)) in points.iter().enumerate() {
        let command = if index == 0 { "M" } else { "L" };
        let _ = write!(out, "{command}{} {}", short(*x), short(*y));
    }
    out
}

/// To a tenth, which no screen resolves.
fn short(value: f64) -> String {
    let text = format!("{value:.1}");
    match text.strip_suffix(".0") {
        Some("-0") => "0".into(),
        Some(whole) => whole.into(),
        None => text,
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_text_is_no_markup() {
        for (value, text) in [(0.0, "0"), (-0.01, "0"), (12.0, "12"), (12.34, "12.3"), (-0.26, "-0.3")] {
            assert_eq!(short(value), text);
        }
        assert_eq!(escaped("<b>&"), "&lt;b&gt;&amp;");
    }

    #[test]
    fn a_symbol_stands_at_its_place() {
        let svg = |shape| {
            let mut out = String::new();
            write_symbol(&mut out, (12.34, 5.0), shape, Colour::Series(1)).unwrap();
            out
        };
        assert_eq!(
            svg(Shape::Disc.filled()),
            "<g transform=\"translate(12.3 5)\"><circle r=\"3.1\" class=\"a c1\" fill=\"#d55e00\"/></g>"
        );
        assert_eq!(
            svg(Shape::Triangle.hollow()),
            "<g transform=\"translate(12.3 5)\"><path d=\"M0 -3.7L3.4 2.6L-3.4 2.6Z\" class=\"h c1\" fill=\"none\" stroke=\"#d55e00\" \
             stroke-width=\"1.4\"/></g>"
        );
    }
}
