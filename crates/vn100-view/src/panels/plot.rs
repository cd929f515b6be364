//! A figure of the report, drawn with the signs of a terminal: lines as dots of braille, symbols and
//! texts as signs, and a grid where its ticks have room.

use ratatui::{
    Frame,
    buffer::Buffer,
    layout::{Position, Rect},
    style::Style,
    symbols::Marker,
    widgets::{
        Paragraph,
        canvas::{Canvas, Points},
    },
};
use vn100_report::{
    figure::{Anchor, At, Colour, Figure, Primitive, Tick},
    numbers::plain::{digits_trimmed, fitted},
};

use crate::theme::{SIGNS, Theme};

/// Columns left of a plot, for the labels of its grid.
const LABELS: u16 = 8;

/// Rows of a plot that show the shape of a curve, with one of labels. Texts beside it have the rest.
pub(crate) const LEAST_ROWS: u16 = 4;

/// Dots between those of a line that is no measurement.
const SPARSE: f64 = 3.0;

pub(crate) struct Plot<'a> {
    pub(crate) figure: &'a Figure,
    /// The places of its first series among the axes of the sensor.
    pub(crate) axes: &'a [usize],
    pub(crate) theme: Theme,
}

impl Plot<'_> {
    /// Draws it with further lines, each in the colour of a series, and marks a place of the axis along.
    pub(crate) fn draw(&self, frame: &mut Frame<'_>, area: Rect, more: &[(usize, Vec<At>)], cursor: Option<f64>) {
        if area.width < LABELS + 10 || area.height < LEAST_ROWS {
            let text = Paragraph::new(" The curve needs a larger screen.").style(self.theme.faint());
            frame.render_widget(text, area);
            return;
        }
        let chart = Rect::new(area.x + LABELS, area.y, area.width - LABELS, area.height - 1);
        self.draw_grid(frame.buffer_mut(), chart);
        self.draw_lines(frame, chart, more);
        let buffer = frame.buffer_mut();
        self.draw_texts(buffer, chart);
        let cursor = cursor.map(|x| self.figure.place(x, self.figure.y.scale.from));
        self.draw_signs(buffer, chart, cursor);
        // a line between the two would look like the bar of a point
        if let Some((column, row)) = cursor.and_then(|at| self.cell(chart, at)) {
            put(buffer, column, chart.top(), "│", Style::new());
            put(buffer, column, row, "│", Style::new());
        }
    }

    /// A place as a share of the rectangle: from the left, and from the top.
    fn share(&self, (x, y): At) -> At {
        let area = self.figure.area;
        ((x - area.left) / area.width, (y - area.top) / area.height)
    }

    /// The cell at a place of the drawing; `None` outside of the chart.
    fn cell(&self, chart: Rect, at: At) -> Option<(u16, u16)> {
        let (along, down) = self.share(at);
        let of = |share: f64, cells: u16| (share * f64::from(cells - 1)).round();
        let is_inside = (-1e-9..1.0 + 1e-9).contains(&along) && (-1e-9..1.0 + 1e-9).contains(&down);
        is_inside.then(|| (chart.x + of(along, chart.width) as u16, chart.y + of(down, chart.height) as u16))
    }

    /// The place among the axes of the sensor; `None` of what is no measurement.
    fn axis(&self, colour: Colour) -> Option<usize> {
        match colour {
            Colour::Series(series) => self.axes.get(series).copied(),
            _ => None,
        }
    }

    fn style(&self, colour: Colour) -> Style {
        self.axis(colour).map_or(self.theme.faint(), |axis| self.theme.axis(axis))
    }

    fn draw_grid(&self, buffer: &mut Buffer, chart: Rect) {
        let (x, y) = (&self.figure.x, &self.figure.y);
        let mut last_row = u16::MAX;
        for (tick, label) in labelled(&y.scale.ticks(), y.scale.log) {
            let Some((_, row)) = self.cell(chart, self.figure.place(x.scale.from, tick)) else { continue };
            if last_row.abs_diff(row) > 1 {
                put(buffer, chart.x, row, &"┈".repeat(chart.width.into()), self.theme.faint());
                put(buffer, chart.x.saturating_sub(label.len() as u16 + 1), row, &label, Style::new());
                last_row = row;
            }
        }
        let mut free_from = chart.x;
        for (tick, label) in labelled(&x.scale.ticks(), x.scale.log) {
            let Some((column, _)) = self.cell(chart, self.figure.place(tick, y.scale.from)) else { continue };
            let width = label.len() as u16;
            let start = column.saturating_sub(width / 2).min(chart.right().saturating_sub(width));
            if start >= free_from {
                (chart.top()..chart.bottom()).for_each(|row| put(buffer, column, row, "┊", self.theme.faint()));
                put(buffer, start, chart.bottom(), &label, Style::new());
                free_from = start + width + 2;
            }
        }
        let unit = self.theme.spelled(x.unit.as_str());
        put(buffer, chart.x - LABELS, chart.bottom(), &format!(" {unit}"), self.theme.faint());
    }

    fn draw_lines(&self, frame: &mut Frame<'_>, chart: Rect, more: &[(usize, Vec<At>)]) {
        let (width, height) = (f64::from(2 * chart.width - 1), f64::from(4 * chart.height - 1));
        let dot = |at: At| {
            let (along, down) = self.share(at);
            (along * width, (1.0 - down) * height)
        };
        let within = |(x, y): &At| (-0.5..width + 0.5).contains(x) && (-0.5..height + 0.5).contains(y);
        let beside = self.beside(chart);
        let mut layers: Vec<(Vec<At>, Style)> = Vec::new();
        for (series, mark) in self.figure.marks() {
            let (dots, colour) = match mark {
                Primitive::Line { points, stroke } => {
                    let is_bar = points.iter().all(|(x, _)| (x - points[0].0).abs() < 7.0);
                    let shift = if is_bar { 2.0 * f64::from(beside(series)) } else { 0.0 };
                    let points: Vec<At> = points.iter().map(|at| dot(*at)).map(|(x, y)| (x + shift, y)).collect();
                    let is_measured = self.axis(stroke.colour).is_some() && stroke.width >= 1.0;
                    (dotted(&points, if is_measured { 1.0 } else { SPARSE }), stroke.colour)
                }
                Primitive::Area { points, colour, .. } => {
                    (filled(&points.iter().map(|at| dot(*at)).collect::<Vec<_>>()), *colour)
                }
                Primitive::Symbol { .. } | Primitive::Text { .. } => continue,
            };
            layers.push((dots, self.style(colour)));
        }
        layers.extend(more.iter().map(|(series, points)| {
            let points: Vec<At> = points.iter().map(|at| dot(*at)).collect();
            (dotted(&points, SPARSE), self.style(Colour::Series(*series)))
        }));
        layers.iter_mut().for_each(|(dots, _)| dots.retain(within));
        let canvas = Canvas::default().marker(Marker::Braille).x_bounds([0.0, width]).y_bounds([0.0, height]);
        frame.render_widget(
            canvas.paint(|context| {
                // in one layer: no line erases the dots of another in its cells
                for (dots, style) in &layers {
                    context.draw(&Points { coords: dots, color: Theme::colour_of(*style) });
                }
            }),
            chart,
        );
    }

    fn draw_texts(&self, buffer: &mut Buffer, chart: Rect) {
        for (_, mark) in self.figure.marks() {
            let Primitive::Text { at, text, anchor, .. } = mark else { continue };
            let Some((column, row)) = self.cell(chart, *at) else { continue };
            let text = self.theme.spelled(plain_powers(text));
            let width = text.chars().count() as u16;
            let start = match anchor {
                Anchor::Start => column,
                Anchor::Middle => column.saturating_sub(width / 2),
                Anchor::End => column.saturating_sub(width),
            };
            let start = start.min(chart.right().saturating_sub(width)).max(chart.x);
            put(buffer, start, row, &text, self.theme.faint());
        }
    }

    /// By how many columns the signs and bars of a series stand beside their place: where there is room
    /// between the points, those of several axes stand side by side.
    fn beside(&self, chart: Rect) -> impl Fn(usize) -> i16 {
        let apart = self.figure.series.first().and_then(|series| match &series.values[..] {
            [first, second, ..] => {
                let [first, second] = [first, second].map(|value| self.share(self.figure.place(value.x, value.y)).0);
                Some((second - first) * f64::from(chart.width - 1))
            }
            _ => None,
        });
        let count = self.axes.len();
        let has_room = apart.is_some_and(|columns| columns > count as f64);
        move |series| if has_room && series < count { series as i16 - (count / 2) as i16 } else { 0 }
    }

    /// Without room side by side, the signs of several axes in one cell take turns from point to point.
    fn draw_signs(&self, buffer: &mut Buffer, chart: Rect, cursor: Option<At>) {
        let beside = self.beside(chart);
        let mut signs = Vec::new();
        let mut drawn = vec![0; self.axes.len()];
        for (series, mark) in self.figure.marks() {
            let Primitive::Symbol { at, shape, colour } = mark else { continue };
            let Some((column, row)) = self.cell(chart, *at) else { continue };
            let axis = self.axis(*colour);
            let sign = match axis {
                Some(axis) => SIGNS.get(axis).unwrap_or(&"●"),
                None if shape.is_hollow => "○",
                None => "◇",
            };
            let is_chosen = axis.is_some() && cursor.is_some_and(|(x, _)| (x - at.0).abs() < 1e-6);
            let style = self.style(*colour);
            let style = if is_chosen { style.patch(self.theme.chosen()) } else { style };
            let turn = drawn.get_mut(series).filter(|_| axis.is_some()).map(|drawn| {
                *drawn += 1;
                (series + *drawn) % self.axes.len()
            });
            if let Some(column) = column.checked_add_signed(if axis.is_some() { beside(series) } else { 0 }) {
                signs.push((turn, (column, row), sign, style));
            }
        }
        signs.sort_by_key(|(turn, ..)| *turn);
        for (_, (column, row), sign, style) in signs {
            put(buffer, column, row, sign, style);
        }
    }
}

pub(crate) fn put(buffer: &mut Buffer, x: u16, y: u16, text: &str, style: Style) {
    for (x, sign) in (x..).zip(text.chars()) {
        if let Some(cell) = buffer.cell_mut(Position::new(x, y)) {
            cell.set_char(sign).set_style(style);
        }
    }
}

/// The ticks with a number, as the number is written on a terminal.
fn labelled(ticks: &[Tick], is_log: bool) -> Vec<(f64, String)> {
    let step = ticks.first().zip(ticks.get(1)).map_or(1.0, |(a, b)| b.value - a.value);
    let is_whole = |decimals: &i32| (step * 10_f64.powi(*decimals)).fract().abs() < 1e-6;
    let decimals = (0..9).find(is_whole).unwrap_or(9) as usize;
    let number = |value| if is_log { digits_trimmed(value, 3) } else { fitted(value, decimals, 7) };
    ticks.iter().filter(|tick| tick.label.is_some()).map(|tick| (tick.value, number(tick.value))).collect()
}

/// Dots along a line, so many apart.
fn dotted(points: &[At], apart: f64) -> Vec<At> {
    const MOST: f64 = 4000.0;
    let between = |pair: &[At]| {
        let ((x, y), (dx, dy)) = (pair[0], (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1));
        let steps = (dx.abs().max(dy.abs()) / apart).ceil().clamp(1.0, MOST);
        (0..steps as u32).map(move |step| {
            let part = f64::from(step) / steps;
            (x + part * dx, y + part * dy)
        })
    };
    points.windows(2).flat_map(between).chain(points.last().copied()).collect()
}

/// The dots of an area between an upper and a lower line.
fn filled(corners: &[At]) -> Vec<At> {
    let edges = || corners.iter().zip(corners.iter().cycle().skip(1));
    let ends = |pick: fn(f64, f64) -> f64| corners.iter().map(|(x, _)| *x).reduce(pick).unwrap_or(0.0);
    let columns = ends(f64::min).round() as i32..=ends(f64::max).round() as i32;
    let column = |column: i32| {
        let x = f64::from(column);
        let crossed = edges().filter(|(a, b)| (a.0.min(b.0) - 0.5..=a.0.max(b.0) + 0.5).contains(&x));
        let height = |(a, b): (&At, &At)| {
            let part = if a.0 == b.0 { 0.0 } else { ((x - a.0) / (b.0 - a.0)).clamp(0.0, 1.0) };
            a.1 + part * (b.1 - a.1)
        };
        let (low, high) = crossed
            .map(height)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| (low.min(height), high.max(height)));
        let rows = (low <= high).then(|| low.round() as i32..=high.round() as i32).into_iter().flatten();
        rows.map(move |row| (x, f64::from(row))).collect::<Vec<_>>()
    };
    columns.flat_map(column).collect()
}

/// The text of a figure with its powers of ten as on a terminal: `5.92·10⁻⁴` as `5.92e-4`.
fn plain_powers(text: &str) -> String {
    const RAISED: [char; 11] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹', '⁻'];
    let mut parts = text.split("·10");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        let rest = part.trim_start_matches(RAISED);
        let raised = part[..part.len() - rest.len()].chars();
        let plain = |sign| RAISED.iter().position(|raised| *raised == sign).filter(|place| *place < 10);
        let power: String = raised.map(|sign| plain(sign).map_or("-".into(), |digit| digit.to_string())).collect();
        format!("{text}e{power}{rest}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_a_figure_are_those_of_a_terminal() {
        for (text, plain) in [("N: 5.92·10⁻⁴ m/s²", "N: 5.92e-4 m/s²"), ("1.2·10¹² x", "1.2e12 x"), ("K", "K")]
        {
            assert_eq!(plain_powers(text), plain);
        }
    }

    #[test]
    fn an_area_has_every_dot_between_its_lines() {
        let band = [(0.0, 2.0), (3.0, 2.0), (3.0, 0.0), (0.0, 0.0)];
        assert_eq!(filled(&band).len(), 12);
        assert_eq!(dotted(&[(0.0, 0.0), (4.0, 1.0)], 1.0).len(), 5);
        assert!(filled(&[]).len() < 2 && dotted(&[], 1.0).is_empty());
    }
}
