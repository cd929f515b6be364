//! The fitted noise model of one channel, as lines in its Allan plot.

use vn100_analysis::noise::{
    Parameter,
    Term::{self, BiasInstability, Quantization, RateRamp, RateRandomWalk, White},
};
use vn100_analysis::{ChannelResult, NoiseResult, Point, letter};

use super::{
    Colour, Dash, Figure, LegendSample, Primitive, Shape, SlopedLine, Stroke,
    axes::Scale,
    plot::{FLAT, read_line},
    quiet,
};
use crate::{
    numbers::digits,
    units::{parameter_unit, pretty_unit},
};

/// The noise that was fitted, as lines; its parameters `factor` times as large.
pub(super) struct FittedModel<'a> {
    noise: &'a NoiseResult,
    factor: f64,
}

impl<'a> FittedModel<'a> {
    /// `None` for what has no noise parameters.
    pub(super) fn of(channel: &'a ChannelResult, factor: f64) -> Option<Self> {
        Some(Self { noise: channel.noise.as_ref()?, factor })
    }

    fn value(&self, term: Term) -> Option<f64> {
        Some(self.noise.parameter(term)?.value? * self.factor)
    }

    /// A parameter in the unit of data sheets.
    fn number(&self, term: Term, value: f64) -> String {
        let (unit, factor) = parameter_unit(self.noise.sensor, term);
        format!("{} {}", digits(value * factor, 3), pretty_unit(unit))
    }

    /// Where its letters stand, and its deviations: all of that is to be seen.
    pub(super) fn reaches(&self, points: &[Point]) -> Vec<f64> {
        let fitted = points.iter().filter_map(|point| point.fitted);
        fitted.chain([Quantization, White, RateRandomWalk].into_iter().filter_map(|term| self.value(term))).collect()
    }

    /// The line of each term, through the deviation at the averaging time where its letter is read.
    fn lines(&self, plot: &Figure) -> Vec<(Term, &'static str, SlopedLine)> {
        let Scale { from, to, .. } = plot.x.scale;
        // the middle of the flat part: from where white noise falls below it, to where the random walk or the record ends it
        let flat = |flicker: f64| {
            let begins = self.value(White).map_or(from, |white| (white / (FLAT * flicker)).powi(2)).clamp(from, to);
            let last = self.noise.fit.map_or(to, |quality| quality.tau_max_s);
            let ends = self.value(RateRandomWalk).map_or(last, |walk| 3.0 * (FLAT * flicker / walk).powi(2)).min(last);
            (begins * ends.max(begins)).sqrt()
        };
        let at = |term, letter, tau_s, deviation, slope| {
            Some((term, letter, SlopedLine { tau_s, deviation, slope, dash: dash(term)? }))
        };
        let flat_part = |flicker| at(BiasInstability, "0.664 B", flat(flicker), FLAT * flicker, 0.0);
        [
            self.value(Quantization).and_then(|rounding| at(Quantization, "Q", 3_f64.sqrt(), rounding, -1.0)),
            self.value(White).and_then(|white| at(White, "N", 1.0, white, -0.5)),
            self.value(BiasInstability).and_then(flat_part),
            self.value(RateRandomWalk).and_then(|walk| at(RateRandomWalk, "K", 3.0, walk, 0.5)),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    pub(super) fn legend(&self, legend: &mut Vec<(LegendSample, String)>) {
        if self.noise.fit.is_some() {
            legend.push((LegendSample::Line(MODEL), "fitted model".into()));
        }
        let is_read = |term: &Term| self.noise.classical.reading(*term).is_some_and(|read| read.value.is_some());
        if Term::ALL.iter().any(is_read) {
            legend.push((LegendSample::Symbol(Shape::Disc.hollow(), Colour::Ink), "graphical method".into()));
        }
        legend.extend(Term::ALL.into_iter().filter_map(|term| {
            // a bound is no line of the curve
            let dash = dash(term).filter(|_| self.value(term).is_some());
            let sample = dash.map_or(LegendSample::Nothing, |dash| LegendSample::Line(quiet(1.1, dash)));
            Some((sample, self.text(term)?))
        }));
    }

    pub(super) fn below(&self, plot: &Figure) -> Vec<Primitive> {
        self.lines(plot).iter().map(|(.., line)| line.drawn(plot, Colour::Quiet, 1.1)).collect()
    }

    /// Its curve, where its terms are read, and what the graphical rules read.
    pub(super) fn draw_above(&self, plot: &mut Figure, points: &[Point]) {
        let mut marks = Vec::new();
        let fitted: Vec<(f64, f64)> = points
            .iter()
            .filter_map(|point| Some((point.tau_s, point.fitted.filter(|fitted| *fitted > 0.0)?)))
            .collect();
        if !fitted.is_empty() {
            marks.push(plot.line(fitted, MODEL));
        }
        let lines = self.lines(plot);
        marks.extend(lines.iter().map(|(.., line)| line.symbol(plot, Shape::Diamond.filled())));
        let read = [(White, Shape::Disc), (RateRandomWalk, Shape::Triangle), (BiasInstability, Shape::Square)];
        marks.extend(read.into_iter().filter_map(|(term, shape)| {
            Some(read_line(term, self.noise.classical.reading(term)?, self.factor)?.symbol(plot, shape.hollow()))
        }));
        plot.draw(1, marks);
        for (term, letter, line) in &lines {
            let value = self.noise.parameter(*term).and_then(|parameter| parameter.value);
            let value = value.map_or_else(String::new, |value| format!(": {}", self.number(*term, value)));
            line.label(plot, 1, &format!("{letter}{value}"));
        }
    }

    /// Of one axis among others: where its white noise is read, and the lines of its flicker floor
    /// and random walk, in the colour of `series`; each with its letter.
    pub(super) fn draw_among(&self, plot: &mut Figure, series: usize, name: &str) {
        let lines = self.lines(plot);
        let mark = |(term, _, line): &(Term, &str, SlopedLine)| match term {
            White => line.symbol(plot, Shape::Diamond.hollow()),
            _ => line.drawn(plot, Colour::Series(series), 0.8),
        };
        let marks = lines.iter().map(mark).collect();
        plot.draw(series, marks);
        for (_, letter, line) in lines.iter().filter(|(term, ..)| *term != White) {
            plot.label(series, &line.along(plot), &format!("{letter} {name}"));
        }
    }

    /// A parameter with its letter and unit, or its upper bound.
    fn text(&self, term: Term) -> Option<String> {
        let Parameter { value, upper, .. } = self.noise.parameter(term)?;
        let (sign, number) = value.map(|value| ("", value)).or_else(|| Some(("≤ ", upper?)))?;
        Some(format!("{} {sign}{}", letter(term), self.number(term, number)))
    }

    /// N, B and K with their units, or the upper bound of each.
    pub(super) fn values(&self) -> Vec<String> {
        [White, BiasInstability, RateRandomWalk].into_iter().filter_map(|term| self.text(term)).collect()
    }
}

/// How the line of a term is drawn; a ramp has none.
fn dash(term: Term) -> Option<Dash> {
    match term {
        Quantization | BiasInstability => Some(Dash::Dotted),
        White => Some(Dash::Dashed),
        RateRandomWalk => Some(Dash::Mixed),
        RateRamp => None,
    }
}

const MODEL: Stroke = Stroke { colour: Colour::Series(1), width: 2.0, dash: Dash::Solid };
