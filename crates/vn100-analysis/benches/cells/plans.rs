//! How many records of the planned length show what they were planned for.

use imu_noise::{Aim, Parameter, Status, Term, Wanted};
use vn100_analysis::{Plan, letter};

use super::{
    families::{self, Cell, Truth},
    generators::Flicker,
    random::Random,
    record::{self, Record},
    scoring::limits,
};
use crate::{Arguments, RATE_HZ, figures, in_parallel};

/// Axes that a want is for; a record has two sensors of them.
const AXES: usize = 3;

/// Of the limit, in the truth.
const OF_LIMIT: f64 = 0.8;

pub(crate) fn measure(arguments: &Arguments) {
    println!("### Records of the planned length, {} of two sensors\n", arguments.records);
    println!("| noise | want | planned s | met, % of sensors | 95 % limits | met by one axis % |");
    println!("|---|---|---:|---:|---:|---:|");
    let (white, flicker, walk) = (families::clean(), families::disturbed(1.0), families::walking());
    let both = families::walking_beside_flicker();
    let limit = flicker.truth().bias_instability / OF_LIMIT;
    for (name, cell, term, aim) in [
        ("white", &white, Term::White, Aim::HalfWidth(0.05)),
        ("white and flicker", &flicker, Term::White, Aim::HalfWidth(0.1)),
        ("white and flicker", &flicker, Term::White, Aim::HalfWidth(0.05)),
        ("white and flicker", &flicker, Term::White, Aim::HalfWidth(0.01)),
        ("white and flicker", &flicker, Term::BiasInstability, Aim::Found),
        ("white and flicker", &flicker, Term::BiasInstability, Aim::HalfWidth(0.2)),
        ("white and flicker", &flicker, Term::BiasInstability, Aim::Below(limit)),
        ("white and walk", &walk, Term::RateRandomWalk, Aim::Found),
        ("white, flicker and walk", &both, Term::RateRandomWalk, Aim::Found),
    ] {
        row(name, cell, term, aim, arguments);
    }
}

fn row(name: &str, cell: &Cell, term: Term, aim: Aim, arguments: &Arguments) {
    let truth = all(&cell.truth());
    // a walk is planned for each axis alone
    let together = if term == Term::RateRandomWalk { 1 } else { AXES };
    let missed = 1.0 - Plan::MET_IN.powf(1.0 / together as f64);
    let wanted = Wanted { term, aim, truth: &truth, missed, tests: 18 };
    let Some(record_s) = wanted.record_s(1.0 / RATE_HZ, 0.95) else { return };
    let cell = Cell { duration_s: record_s, ..cell.clone() };
    let flicker = Flicker::new(cell.samples());
    let seed = format!("{name} {term:?} {aim:?}");
    let shown: Vec<Vec<bool>> = in_parallel(arguments.threads, arguments.records, |number| {
        let mut random = Random::of_record(arguments.seed, &seed, cell.samples(), number);
        let assessed = Record::of(&cell, &flicker, &mut random).assess(&cell, &mut random);
        let scale = record::counts_per_unit() * cell.step;
        let is_met = |(place, _): (usize, &str)| {
            let noise = assessed.assessment.channels[place].noise.as_ref();
            noise.and_then(|noise| noise.parameter(term)).is_some_and(|parameter| is_shown(&parameter, aim, scale))
        };
        record::scored().map(is_met).collect()
    });
    let sensors: Vec<bool> =
        shown.iter().flat_map(|axes| axes.chunks(AXES)).map(|axes| axes.iter().all(|is_met| *is_met)).collect();
    let met = sensors.iter().filter(|is_met| **is_met).count();
    let (lower, upper) = limits(met, sensors.len());
    let of_axes =
        shown.iter().flatten().filter(|is_met| **is_met).count() as f64 / shown.iter().flatten().count() as f64;
    let values = [
        ("planned s", format!("{record_s:.0}")),
        ("met %", format!("{:.0}", 100.0 * met as f64 / sensors.len() as f64)),
        ("limits", format!("{:.0} to {:.0}", 100.0 * lower, 100.0 * upper)),
        ("one axis %", format!("{:.0}", 100.0 * of_axes)),
    ];
    figures::record("plans", &format!("{name}, {} {aim:?}", letter(term)), &values);
    println!(
        "| {name} | {} {aim:?} | {record_s:.0} | {:.0} | {:.0} to {:.0} | {:.0} |",
        letter(term),
        100.0 * met as f64 / sensors.len() as f64,
        100.0 * lower,
        100.0 * upper,
        100.0 * of_axes
    );
}

fn all(truth: &Truth) -> Vec<(Term, f64)> {
    let all = [
        (Term::White, truth.white),
        (Term::BiasInstability, truth.bias_instability),
        (Term::RateRandomWalk, truth.walk),
    ];
    all.into_iter().filter(|(_, value)| *value > 0.0).collect()
}

/// `scale`: units of the cell in one of the channel.
fn is_shown(parameter: &Parameter, aim: Aim, scale: f64) -> bool {
    let is_estimated = parameter.status == Status::Estimated;
    match aim {
        Aim::Found => is_estimated,
        Aim::HalfWidth(most) => is_estimated && parameter.relative_half_width().is_some_and(|width| width <= most),
        Aim::Below(limit) => parameter.upper.is_some_and(|upper| upper * scale <= limit),
        Aim::Above(limit) => parameter.lower.is_some_and(|lower| lower * scale >= limit),
    }
}
