//! The Allan deviation of one axis as laboratories print it: with the lines of N, B and K that the
//! graphical slope method draws, and what it reads off them.

use vn100_analysis::noise::{Deviation, GraphicalReading, Sensor, Term};
use vn100_analysis::protocol::Quantity;
use vn100_analysis::{ChannelResult, letter};

use super::{
    Colour, Figure, LegendSample, Shape, SlopedLine,
    allan::{axes, curve, id_of, series},
    plot::read_line,
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
    let of = |(term, ..): &(Term, _, _)| {
        let read = noise.classical.reading(*term)?;
        Some((*term, text(noise.sensor, *term, read), read_line(*term, read, factor)))
    };
    let lines: Vec<(Term, String, Option<SlopedLine>)> = GRAPHICAL.iter().filter_map(of).collect();
    let straight = || lines.iter().filter_map(|(.., line)| line.as_ref());
    // with room for the text below
    let reaches: Vec<f64> = straight().flat_map(|line| [line.deviation, 0.4 * line.deviation]).collect();
    let (x, y) = axes(&[&channel], &reaches, deviation)?;
    let mut legend = vec![(LegendSample::Both(solid(0, 1.0), Shape::Disc.filled()), "measured".to_owned())];
    let sample = |line: &SlopedLine| LegendSample::Line(quiet(1.3, line.dash));
    legend.extend(
        lines.iter().map(|(_, text, line)| (line.as_ref().map_or(LegendSample::Nothing, sample), text.clone())),
    );
    let id = format!("graphical-{}", id_of(&channel.name));
    let title = format!("{}: {}, graphical slope method", channel.name, deviation_name(deviation));
    let mut plot = Figure::with_square_decades(id, title, x, y, &legend);
    plot.draw(1, straight().map(|line| line.drawn(&plot, Colour::Quiet, 1.3)).collect());
    plot.draw(0, curve(&plot, 0, &channel.allan.points));
    plot.draw(1, straight().map(|line| line.symbol(&plot, Shape::Diamond.filled())).collect());
    for (term, text, line) in &lines {
        let before = if *term == Term::BiasInstability { "0.664 B: " } else { "" };
        line.iter().for_each(|line| line.label(&mut plot, 1, &format!("{before}{text}")));
    }
    plot.series = vec![series(channel.name.clone(), &channel.allan.points)];
    Some(plot)
}

/// As `N 0.3617 °/√h`, or why there is no value.
fn text(sensor: Sensor, term: Term, read: &GraphicalReading) -> String {
    match (read.value.zip(laboratory_unit(sensor, term)), read.not_read) {
        (Some((value, (unit, factor))), _) => {
            format!("{} {} {}", letter(term), digits(value * factor, 4), pretty_unit(unit))
        }
        (None, Some(why)) => format!("{} {}", letter(term), not_read(term, why)),
        (None, None) => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_goes_through_the_place_where_it_is_read() {
        let read = GraphicalReading { value: Some(2.0), unit: "", tau_s: Some(500.0), not_read: None };
        let line = |term| read_line(term, &read, 10.0).unwrap();
        assert_eq!(line(Term::White).at(1.0), 20.0);
        assert!((line(Term::White).at(4.0) - 10.0).abs() < 1e-12);
        assert!(
            (line(Term::RateRandomWalk).at(12.0) - 40.0).abs() < 1e-12 && line(Term::RateRandomWalk).at(3.0) == 20.0
        );
        let flat = line(Term::BiasInstability);
        assert!(flat.tau_s == 500.0 && flat.at(7.0) == flat.at(500.0) && (flat.at(1.0) - 0.664_28 * 20.0).abs() < 1e-9);
    }
}
