//! Scales, their ticks and labels, and the frame that they make around a plot.

use super::{
    Figure,
    drawing::{Anchor, At, Colour, Dash, LETTERS, Primitive, Rectangle, Stroke},
};
use crate::numbers::superscript;

/// The range of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// The value at the left or lower end, in the unit of the axis.
    pub from: f64,
    /// The value at the right or upper end, in the unit of the axis.
    pub to: f64,
    /// Whether the scale is logarithmic: both ends are positive then.
    pub log: bool,
}

/// A tick of an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// Its place, in the unit of the axis.
    pub value: f64,
    /// Its number as a figure writes it; `None` for the fine ones.
    pub label: Option<String>,
}

impl Scale {
    /// Around `values`, with some room at both ends.
    pub(crate) fn around(values: impl Iterator<Item = f64>, log: bool) -> Self {
        const ROOM: f64 = 0.05;
        let usable = values.filter(|value| value.is_finite() && (!log || *value > 0.0));
        let (low, high) = usable.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        if low > high {
            let (from, to) = if log { (0.1, 10.0) } else { (0.0, 1.0) };
            return Self { from, to, log };
        }
        let (from, to) = if log {
            let (low, high) = (low.log10(), high.log10());
            let room = (ROOM * (high - low)).max(0.08);
            (10_f64.powf(low - room), 10_f64.powf(high + room))
        } else {
            let span = if high > low { high - low } else { low.abs().max(1.0) * 1e-3 };
            (low - ROOM * span, high + ROOM * span)
        };
        Self { from, to, log }
    }

    /// 0 at the beginning, 1 at the end.
    pub(crate) fn share(&self, value: f64) -> f64 {
        match *self {
            Self { from, to, log: false } => (value - from) / (to - from),
            // far outside, but a number
            Self { from, .. } if value <= 0.0 => self.share(from * 1e-3),
            Self { from, to, .. } => (value / from).ln() / (to / from).ln(),
        }
    }

    /// Numbers at the ticks of a linear scale are in units of ten to this power.
    pub(crate) fn exponent(&self) -> i32 {
        let largest = self.from.abs().max(self.to.abs());
        if self.log || largest == 0.0 || (0.05..2e4).contains(&largest) {
            return 0;
        }
        3 * (largest.log10() / 3.0).floor() as i32
    }

    /// The ticks between both ends, in rising order.
    pub fn ticks(&self) -> Vec<Tick> {
        let Self { from, to, log } = *self;
        if log { log_ticks(from, to) } else { linear_ticks(from, to, self.exponent()) }
    }
}

/// Both continued, the one that is too short alike at both ends, so that a decade is as long along
/// as it is upwards, in a rectangle `aspect` times as wide as high.
pub(crate) fn square_decades(x: Scale, y: Scale, aspect: f64) -> (Scale, Scale) {
    let decades = |scale: Scale| (scale.to / scale.from).log10();
    let upwards = decades(y).max(decades(x) / aspect);
    let continued = |scale: Scale, to_decades: f64| {
        let more = 10_f64.powf((to_decades - decades(scale)).max(0.0) / 2.0);
        Scale { from: scale.from / more, to: scale.to * more, ..scale }
    };
    (continued(x, upwards * aspect), continued(y, upwards))
}

fn linear_ticks(from: f64, to: f64, exponent: i32) -> Vec<Tick> {
    const ABOUT: f64 = 6.5;
    let raw = (to - from) / ABOUT;
    let power = 10_f64.powf(raw.log10().floor());
    let step = power * [1.0, 2.0, 2.5, 5.0, 10.0].into_iter().find(|nice| nice * power >= raw).unwrap_or(10.0);
    let unit = 10_f64.powi(exponent);
    let is_whole = |value: f64| (value - value.round()).abs() < 1e-6;
    let decimals = (0..12).find(|d| is_whole(step / unit * 10_f64.powi(*d))).unwrap_or(12) as usize;
    let (first, last) = ((from / step).ceil() as i64, (to / step).floor() as i64);
    (first..=last)
        .map(|n| {
            let value = n as f64 * step;
            let text = format!("{:.decimals$}", value / unit);
            Tick { value, label: Some(text.replace('-', "−")) }
        })
        .collect()
}

fn log_ticks(from: f64, to: f64) -> Vec<Tick> {
    let decades = (to / from).log10();
    let (first, last) = (from.log10().floor() as i32, to.log10().ceil() as i32);
    let plain = (-2..=4).contains(&(from.log10().ceil() as i32)) && (-2..=4).contains(&(to.log10().floor() as i32));
    let every = if decades > 9.0 { 2 } else { 1 };
    let mut ticks = Vec::new();
    for decade in first..=last {
        for digit in 1..=9 {
            let value = f64::from(digit) * 10_f64.powi(decade);
            let labelled = match digit {
                1 => decade.rem_euclid(every) == 0,
                2 | 5 => decades < 1.6,
                _ => decades < 0.6,
            };
            if (from..=to).contains(&value) {
                ticks.push(Tick { value, label: labelled.then(|| power_of_ten(digit, decade, plain)) });
            }
        }
    }
    ticks
}

fn power_of_ten(digit: i32, decade: i32, plain: bool) -> String {
    if plain {
        let decimals = (-decade).max(0) as usize;
        return format!("{:.decimals$}", f64::from(digit) * 10_f64.powi(decade));
    }
    let power = format!("10{}", superscript(decade));
    if digit == 1 { power } else { format!("{digit}·{power}") }
}

/// An axis of a figure.
#[derive(Debug, Clone)]
pub struct PlotAxis {
    /// The quantity along it, such as `frequency`.
    pub name: String,
    /// The unit of its values, as people write it; empty if it has none.
    pub unit: String,
    /// Where it begins and ends.
    pub scale: Scale,
}

impl PlotAxis {
    pub(crate) fn new(name: &str, unit: impl Into<String>, scale: Scale) -> Self {
        Self { name: name.into(), unit: unit.into(), scale }
    }

    /// Name and unit, with the power of ten of its numbers.
    pub(crate) fn label(&self) -> String {
        let Self { name, unit, scale } = self;
        match (scale.exponent(), unit.as_str()) {
            (0, "") => name.clone(),
            (0, unit) => format!("{name} ({unit})"),
            (exponent, "") => format!("{name} (10{})", superscript(exponent)),
            (exponent, unit) => format!("{name} (10{} {unit})", superscript(exponent)),
        }
    }
}

/// Grid, edges, and the numbers and names of both axes.
pub(crate) fn frame(figure: &Figure) -> Vec<Primitive> {
    let Figure { x, y, .. } = figure;
    let Rectangle { left, top, width, height } = figure.area;
    let (right, bottom) = (left + width, top + height);
    let stroke = |colour, width| Stroke { colour, width, dash: Dash::Solid };
    let line = |from: At, to: At, tick: &Tick| {
        let colour = if tick.label.is_some() { Colour::Grid } else { Colour::FineGrid };
        Primitive::Line { points: vec![from, to], stroke: stroke(colour, 0.8) }
    };
    let (along, up) = (x.scale.ticks(), y.scale.ticks());
    let mut marks = Vec::new();
    // the fine lines lie below the others
    for fine in [true, false] {
        for tick in along.iter().filter(|tick| tick.label.is_none() == fine) {
            let x = figure.place(tick.value, 0.0).0;
            marks.push(line((x, top), (x, bottom), tick));
        }
        for tick in up.iter().filter(|tick| tick.label.is_none() == fine) {
            let y = figure.place(0.0, tick.value).1;
            marks.push(line((left, y), (right, y), tick));
        }
    }
    let corners = vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
    marks.push(Primitive::Line { points: corners, stroke: stroke(Colour::Axis, 1.0) });
    for tick in &along {
        let at = (figure.place(tick.value, 0.0).0, bottom + LETTERS + 4.0);
        marks.extend(tick.label.clone().map(|label| Primitive::text(at, label, Anchor::Middle)));
    }
    for tick in &up {
        let at = (left - 5.0, figure.place(0.0, tick.value).1 + 0.36 * LETTERS);
        marks.extend(tick.label.clone().map(|label| Primitive::text(at, label, Anchor::End)));
    }
    marks.push(Primitive::text((left + width / 2.0, bottom + 2.0 * LETTERS + 10.0), x.label(), Anchor::Middle));
    marks.push(Primitive::Text {
        at: (LETTERS + 1.0, top + height / 2.0),
        text: y.label(),
        size: LETTERS,
        anchor: Anchor::Middle,
        upwards: true,
    });
    marks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale) -> Vec<String> {
        scale.ticks().into_iter().filter_map(|tick| tick.label).collect()
    }

    #[test]
    fn decades_are_labelled_and_split_in_nine() {
        let scale = Scale { from: 1e-5, to: 1e-3, log: true };
        assert_eq!(labels(scale), ["10⁻⁵", "10⁻⁴", "10⁻³"]);
        assert_eq!(scale.ticks().len(), 19);
        assert_eq!(labels(Scale { from: 0.02, to: 300.0, log: true }), ["0.1", "1", "10", "100"]);
        assert_eq!(labels(Scale { from: 1.5e-4, to: 9e-4, log: true }), ["2·10⁻⁴", "5·10⁻⁴"]);
        // from hundredths to ten thousands as people write them
        assert_eq!(labels(Scale { from: 0.011, to: 0.09, log: true }), ["0.02", "0.05"]);
        assert_eq!(
            labels(Scale { from: 1500.0, to: 50_000.0, log: true }),
            ["2000", "5000", "10000", "20000", "50000"]
        );
        assert_eq!(labels(Scale { from: 0.0011, to: 0.009, log: true }), ["2·10⁻³", "5·10⁻³"]);
        assert_eq!(scale.share(1e-4), 0.5);
    }

    #[test]
    fn linear_ticks_are_round_numbers_with_a_common_power() {
        assert_eq!(labels(Scale { from: -9.93, to: -9.84, log: false }), ["−9.92", "−9.90", "−9.88", "−9.86", "−9.84"]);
        let small = Scale { from: -3.1e-3, to: 4.2e-3, log: false };
        assert_eq!(labels(small), ["−2", "0", "2", "4"]);
        let axis = PlotAxis { name: "gyro_y".into(), unit: "rad/s".into(), scale: small };
        assert_eq!(axis.label(), "gyro_y (10⁻³ rad/s)");
        assert_eq!(PlotAxis::new("samples", "", small).label(), "samples (10⁻³)");
    }

    #[test]
    fn decades_are_as_high_as_they_are_wide() {
        let scale = |from, to| Scale { from, to, log: true };
        let decades = |scale: Scale| (scale.to / scale.from).log10();
        for (x, y) in [(scale(0.01, 1e4), scale(1.0, 10.0)), (scale(1.0, 10.0), scale(1e-3, 1e3))] {
            let (wide, high) = square_decades(x, y, 1.5);
            assert!((decades(wide) / decades(high) - 1.5).abs() < 1e-9, "{wide:?} {high:?}");
            for (short, long) in [(x, wide), (y, high)] {
                assert!(long.from <= short.from * 1.000_001 && long.to >= short.to * 0.999_999, "{short:?} {long:?}");
            }
        }
    }

    #[test]
    fn scales_hold_all_values_whatever_they_are() {
        for (values, log) in [(vec![], false), (vec![], true), (vec![0.0], false), (vec![5.0, 5.0], false)] {
            let scale = Scale::around(values.iter().copied(), log);
            let Scale { from, to, .. } = scale;
            assert!(from < to && !scale.ticks().is_empty(), "{values:?} {log}");
        }
        let scale = Scale::around([1e-4, f64::NAN, 0.0, 3e-3].into_iter(), true);
        assert!(scale.share(1e-4) > 0.0 && scale.share(3e-3) < 1.0 && scale.share(0.0).is_finite());
    }
}
