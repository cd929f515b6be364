//! The fitted noise model of one channel, as lines in its Allan plot.

use vn100_analysis::noise::{
    Parameter,
    Term::{self, BiasInstability, Quantization, RateRamp, RateRandomWalk, White},
};
use vn100_analysis::{ChannelNoise, letter};

use super::{
    Colour, Dash, LegendSample, Marker, Plot, Primitive, Stroke, allan::FLAT, axes::Scale, pretty_unit, quiet,
};
use crate::{
    numbers::digits,
    summary::parameter_unit,
    units::{ChannelValues, Point},
};

/// The noise that was fitted, as lines; its parameters `factor` times as large.
pub(super) struct FittedModel<'a> {
    noise: &'a ChannelNoise,
    factor: f64,
}

impl<'a> FittedModel<'a> {
    /// `None` for what has no noise parameters.
    pub(super) fn of(channel: &'a ChannelValues, factor: f64) -> Option<Self> {
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

    fn lines(&self, plot: &Plot) -> Vec<Reference> {
        let Scale { from, to, .. } = plot.place.x;
        // the middle of the flat part: from where white noise falls below it, to where the random walk or the record ends it
        let flat = |flicker: f64| {
            let begins = self.value(White).map_or(from, |white| (white / (FLAT * flicker)).powi(2)).clamp(from, to);
            let last = self.noise.fit.quality.map_or(to, |quality| quality.tau_max_s);
            let ends = self.value(RateRandomWalk).map_or(last, |walk| 3.0 * (FLAT * flicker / walk).powi(2)).min(last);
            (begins * ends.max(begins)).sqrt()
        };
        let at = |term, letter, tau_s, deviation, slope| {
            Some(Reference { term, dash: dash(term)?, letter, tau_s, deviation, slope })
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
        if self.noise.fit.quality.is_some() {
            legend.push((LegendSample::Line(MODEL), "fitted model".into()));
        }
        let classical = &self.noise.classical;
        if [classical.white, classical.bias_instability, classical.rate_random_walk].iter().any(Result::is_ok) {
            legend.push((LegendSample::Symbol(Marker::Ring, Colour::Ink), "graphical method".into()));
        }
        legend.extend(Term::ALL.into_iter().filter_map(|term| {
            let Parameter { value, upper, .. } = self.noise.parameter(term)?;
            let number = |value: f64| self.number(term, value);
            Some(match (value, upper, dash(term)) {
                (Some(value), _, Some(dash)) => {
                    (LegendSample::Line(quiet(1.1, dash)), format!("{} {}", letter(term), number(value)))
                }
                (Some(value), _, None) => (LegendSample::Nothing, format!("{} {}", letter(term), number(value))),
                // a bound is no line of the curve
                (None, Some(upper), _) => (LegendSample::Nothing, format!("{} ≤ {}", letter(term), number(upper))),
                (None, None, _) => return None,
            })
        }));
    }

    pub(super) fn below(&self, plot: &Plot) -> Vec<Primitive> {
        let Scale { from, to, .. } = plot.place.x;
        let lines = self.lines(plot);
        let line = |line: &Reference| plot.line([from, to].map(|tau_s| (tau_s, line.at(tau_s))), quiet(1.1, line.dash));
        lines.iter().map(line).collect()
    }

    pub(super) fn above(&self, plot: &Plot, points: &[Point]) -> Vec<Primitive> {
        let mut marks = Vec::new();
        let fitted: Vec<(f64, f64)> = points
            .iter()
            .filter_map(|point| Some((point.tau_s, point.fitted.filter(|fitted| *fitted > 0.0)?)))
            .collect();
        if !fitted.is_empty() {
            marks.push(plot.line(fitted, MODEL));
        }
        for Reference { term, letter, tau_s, deviation, slope, .. } in self.lines(plot) {
            marks.push(plot.symbol(tau_s, deviation, Marker::Diamond, Colour::Ink));
            let value = self.noise.parameter(term).and_then(|parameter| parameter.value);
            let text =
                value.map_or_else(|| letter.to_owned(), |value| format!("{letter}: {}", self.number(term, value)));
            marks.push(match slope {
                0.0 => plot.note_at_edge(deviation, &text),
                _ => plot.note(tau_s, deviation, text),
            });
        }
        let classical = &self.noise.classical;
        let read = [
            (Marker::Ring, 1.0, classical.white.map(|line| line.value)),
            (Marker::HollowTriangle, 3.0, classical.rate_random_walk.map(|line| line.value)),
        ];
        marks.extend((read.into_iter()).filter_map(|(shape, tau_s, value)| {
            Some(plot.symbol(tau_s, value.ok()? * self.factor, shape, Colour::Ink))
        }));
        if let Ok(flat) = classical.bias_instability {
            marks.push(plot.symbol(flat.tau_s, FLAT * flat.value * self.factor, Marker::HollowSquare, Colour::Ink));
        }
        marks
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

/// The line of one term, through the deviation at the averaging time where its letter is read.
struct Reference {
    term: Term,
    dash: Dash,
    letter: &'static str,
    tau_s: f64,
    deviation: f64,
    slope: f64,
}

impl Reference {
    fn at(&self, tau_s: f64) -> f64 {
        self.deviation * (tau_s / self.tau_s).powf(self.slope)
    }
}

const MODEL: Stroke = Stroke { colour: Colour::Series(1), width: 2.0, dash: Dash::Solid };
