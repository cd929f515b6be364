//! The Allan deviation of one axis as laboratories print it: with the lines of N, B and K that the
//! graphical slope method draws, and what it reads off them.

use vn100_analysis::noise::{ClassicalReading, Deviation, NotRead, SlopeLine, Term};
use vn100_analysis::protocol::Quantity;
use vn100_analysis::{ChannelResult, NoiseResult, letter};

use super::{
    Colour, Dash, Figure, LegendSample, Shape, SlopedLine,
    allan::{axes, curve, id_of, series},
    fitted_model::FLAT,
    quiet, solid,
};
use crate::{
    graphical::{GRAPHICAL, not_read},
    names::deviation_name,
    numbers::digits,
    units::{laboratory_unit, pretty_unit},
};

/// In deg/s or m/s². `None` for another quantity or deviation, and without any deviation.
pub(crate) fn graphical(channel: &ChannelResult, deviation: Deviation) -> Option<Figure> {
    let (unit, factor) = match channel.quantity {
        Quantity::AngularRate => ("deg/s", 180.0 / std::f64::consts::PI),
        Quantity::Acceleration => ("m/s^2", 1.0),
        _ => return None,
    };
    let noise = channel.noise.as_ref().filter(|_| deviation == Deviation::Allan)?;
    let channel = channel.in_unit(unit, factor);
    let lines: Vec<Result<Line, (Term, NotRead)>> = (GRAPHICAL.iter())
        .map(|(term, ..)| match noise.classical.of(*term) {
            Ok(line) => Ok(Line::new(*term, line, factor)),
            Err(why) => Err((*term, why)),
        })
        .collect();
    // with room for the text below
    let reaches: Vec<f64> =
        lines.iter().flatten().flat_map(|Line { line, .. }| [line.deviation, 0.4 * line.deviation]).collect();
    let (x, y) = axes(&[&channel], &reaches, deviation)?;
    let mut legend = vec![(LegendSample::Both(solid(0, 1.0), Shape::Disc.filled()), "measured".to_owned())];
    legend.extend(lines.iter().map(|line| match line {
        Ok(line) => (LegendSample::Line(quiet(1.3, line.line.dash)), line.text(noise)),
        Err((term, why)) => (LegendSample::Nothing, format!("{} {}", letter(*term), not_read(*term, *why))),
    }));
    let id = format!("graphical-{}", id_of(&channel.name));
    let title = format!("{}: {}, graphical slope method", channel.name, deviation_name(deviation));
    let mut plot = Figure::with_square_decades(id, title, x, y, &legend);
    let straight = || lines.iter().flatten().map(|Line { line, .. }| line);
    plot.draw(1, straight().map(|line| line.drawn(&plot, Colour::Quiet, 1.3)).collect());
    plot.draw(0, curve(&plot, 0, &channel.allan.points));
    let read = |line: &SlopedLine| plot.symbol(line.tau_s, line.deviation, Shape::Diamond.filled(), Colour::Ink);
    plot.draw(1, straight().map(read).collect());
    for line in lines.iter().flatten() {
        let text = match line.term {
            Term::BiasInstability => format!("0.664 B: {}", line.text(noise)),
            _ => line.text(noise),
        };
        line.line.label(&mut plot, 1, &text);
    }
    plot.series = vec![series(channel.name.clone(), &channel.allan.points)];
    Some(plot)
}

/// A straight line through the place at which its parameter is read.
struct Line {
    term: Term,
    /// In the unit of the parameter.
    value: f64,
    /// In the unit of the plot.
    line: SlopedLine,
}

impl Line {
    fn new(term: Term, SlopeLine { value, tau_s }: SlopeLine, factor: f64) -> Self {
        let (tau_s, level, slope, dash) = match term {
            Term::BiasInstability => (tau_s, FLAT, 0.0, Dash::Dotted),
            Term::RateRandomWalk => (ClassicalReading::RANDOM_WALK_TAU_S, 1.0, 0.5, Dash::Mixed),
            Term::White | Term::Quantization | Term::RateRamp => {
                (ClassicalReading::WHITE_TAU_S, 1.0, -0.5, Dash::Dashed)
            }
        };
        Self { term, value, line: SlopedLine { tau_s, deviation: value * level * factor, slope, dash } }
    }

    /// As `N 0.3617 °/√h`.
    fn text(&self, noise: &NoiseResult) -> String {
        let unit = laboratory_unit(noise.sensor, self.term);
        unit.map_or_else(String::new, |(unit, factor)| {
            format!("{} {} {}", letter(self.term), digits(self.value * factor, 4), pretty_unit(unit))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_goes_through_the_place_where_it_is_read() {
        let line = |term| Line::new(term, SlopeLine { value: 2.0, tau_s: 500.0 }, 10.0).line;
        assert_eq!(line(Term::White).at(1.0), 20.0);
        assert!((line(Term::White).at(4.0) - 10.0).abs() < 1e-12);
        assert!(
            (line(Term::RateRandomWalk).at(12.0) - 40.0).abs() < 1e-12 && line(Term::RateRandomWalk).at(3.0) == 20.0
        );
        let flat = line(Term::BiasInstability);
        assert!(flat.tau_s == 500.0 && flat.at(7.0) == flat.at(500.0) && (flat.at(1.0) - 0.664_28 * 20.0).abs() < 1e-9);
    }
}
