//! How often the interval of the temperature coefficient holds, and how often one is proved that is
//! not there.

use std::f64::consts::TAU;

use super::{
    families::{self, Cell},
    generators::Flicker,
    random::Random,
    record::{self, Record, SCORED},
    scoring::limits,
};
use crate::{Arguments, figures, in_parallel};

/// Standard deviation of one reading of the temperature, which is printed to 0.1 °C.
const READING_C: f64 = 0.05;

/// Lags of the axes behind the temperature.
const LAGS_S: [f64; 2] = [0.0, 60.0];

/// In standard deviations of the white noise of a sample, per °C.
const COEFFICIENTS: [f64; 2] = [0.0, 0.1];

/// How the temperature of the surroundings changes.
#[derive(Clone, Copy)]
enum Course {
    /// A sine of 1.5 °C up and down; the record holds so many of them.
    Cycle(f64),
    /// By 8 °C towards another level until the middle of the record, and back.
    WarmAndCool,
    /// First order, stationary: correlated over a tenth of the record.
    Wander,
}

const COURSES: [(&str, Course); 3] =
    [("six cycles", Course::Cycle(6.0)), ("up and down", Course::WarmAndCool), ("wandering", Course::Wander)];

/// Of one channel.
struct Scored {
    holds: bool,
    half_width: f64,
    is_proved: bool,
}

pub(crate) fn measure(arguments: &Arguments) {
    let records = arguments.records;
    for minutes in arguments.minutes_or(&[10, 60]) {
        println!("### Temperature, {minutes} min, {records} records of 6 channels\n");
        println!(
            "| noise | temperature | lag s | coefficient | held % | 95 % limits | half width | proved, % of channels | false, % \
             of records | 95 % limits | withheld |"
        );
        println!("|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
        let cells = families::beside_temperature(60.0 * *minutes as f64);
        let flicker = Flicker::new(cells[0].samples());
        for cell in cells.iter().filter(|cell| arguments.cell.as_deref().is_none_or(|part| cell.name.contains(part))) {
            for (name, course) in COURSES {
                for (lag_s, coefficient) in LAGS_S.iter().flat_map(|lag| COEFFICIENTS.map(|of| (*lag, of))) {
                    // without an influence it has no lag
                    if coefficient == 0.0 && lag_s > 0.0 {
                        continue;
                    }
                    row(cell, (name, course), lag_s, coefficient, &flicker, arguments);
                }
            }
        }
        println!();
    }
}

fn row(
    cell: &Cell,
    (name, course): (&str, Course),
    lag_s: f64,
    coefficient: f64,
    flicker: &Flicker,
    arguments: &Arguments,
) {
    let label = format!("{} {name} {lag_s} {coefficient}", cell.name);
    let found: Vec<Vec<Option<Scored>>> = in_parallel(arguments.threads, arguments.records, |number| {
        let mut random = Random::of_record(arguments.seed, &label, cell.samples(), number);
        of_record(cell, course, lag_s, coefficient, flicker, &mut random)
    });
    let scored: Vec<&Scored> = found.iter().flatten().flatten().collect();
    let held = scored.iter().filter(|scored| scored.holds).count();
    let width = scored.iter().map(|scored| scored.half_width).sum::<f64>() / scored.len() as f64;
    let proved = scored.iter().filter(|scored| scored.is_proved).count();
    let are_false = found.iter().filter(|record| record.iter().flatten().any(|scored| scored.is_proved)).count();
    let percent = |count: usize, all: usize| 100.0 * count as f64 / all as f64;
    let range = |count: usize, all: usize| {
        let (lower, upper) = limits(count, all);
        format!("{:.1}-{:.1}", 100.0 * lower, 100.0 * upper)
    };
    let (of_false, range_of_false) = match coefficient == 0.0 {
        true => (format!("{:.1}", percent(are_false, found.len())), range(are_false, found.len())),
        false => (String::new(), String::new()),
    };
    let values = [
        ("held %", format!("{:.1}", percent(held, scored.len()))),
        ("limits", range(held, scored.len())),
        ("proved %", format!("{:.1}", percent(proved, scored.len()))),
        ("false %", of_false.clone()),
    ];
    let row = format!("{}, {name}, {coefficient} sd/°C, lag {lag_s} s", cell.name);
    figures::record("temperature", &row, &values);
    println!(
        "| {} | {name} | {lag_s} | {coefficient} | {:.1} | {} | {width:.4} | {:.1} | {of_false} | {range_of_false} | {} |",
        cell.name,
        percent(held, scored.len()),
        range(held, scored.len()),
        percent(proved, scored.len()),
        found.len() * SCORED - scored.len(),
    );
}

fn of_record(
    cell: &Cell,
    course: Course,
    lag_s: f64,
    coefficient: f64,
    flicker: &Flicker,
    random: &mut Random,
) -> Vec<Option<Scored>> {
    let mut record = Record::of(cell, flicker, random);
    let true_c = course.series(cell, random);
    let lagged_c = lagged(&true_c, lag_s * cell.rate_hz);
    let signs: [f64; SCORED] = std::array::from_fn(|_| random.sign());
    for (series, sign) in record.series.iter_mut().zip(signs) {
        series.iter_mut().zip(&lagged_c).for_each(|(value, degrees)| *value += sign * coefficient * degrees);
    }
    record.temperature_c = Some(true_c.iter().map(|degrees| degrees + READING_C * random.normal()).collect());
    let assessed = record.assess(cell, random);
    let scale = cell.step * record::counts_per_unit();
    let channels = record::scored().map(|(place, _)| assessed.assessment.channels[place].noise.as_ref());
    let scored = channels.zip(signs).map(|(noise, sign)| {
        let temperature = noise?.temperature.as_ref()?;
        let found = temperature.coefficient.ok()?;
        let truth = sign * coefficient / scale;
        Some(Scored {
            holds: found.lower <= truth && truth <= found.upper,
            half_width: (found.upper - found.lower) / 2.0 * scale,
            is_proved: temperature.is_proved,
        })
    });
    scored.collect()
}

impl Course {
    /// The temperature of the sensor at each sample, in °C.
    fn series(self, cell: &Cell, random: &mut Random) -> Vec<f64> {
        let samples = cell.samples();
        let share = |i: usize| i as f64 / samples as f64;
        match self {
            Self::Cycle(cycles) => {
                let phase = random.uniform();
                (0..samples).map(|i| 25.0 + 1.5 * (TAU * (cycles * share(i) + phase)).sin()).collect()
            }
            Self::WarmAndCool => {
                let constant = 0.15 + 0.1 * random.uniform();
                let risen = |share: f64| 8.0 * -(-share / constant).exp_m1();
                let at = |share: f64| match share < 0.5 {
                    true => risen(share),
                    false => risen(0.5) * (-(share - 0.5) / constant).exp(),
                };
                (0..samples).map(|i| 25.0 + at(share(i))).collect()
            }
            Self::Wander => {
                let memory = (-10.0 / samples as f64).exp();
                let kick = (1.0 - memory * memory).sqrt();
                let mut level = random.normal();
                let mut next = || {
                    level = memory * level + kick * random.normal();
                    25.0 + 1.5 * level
                };
                (0..samples).map(|_| next()).collect()
            }
        }
    }
}

/// Behind a first-order lag of so many samples, from a standstill.
fn lagged(values: &[f64], lag: f64) -> Vec<f64> {
    let gain = if lag > 0.0 { -(-1.0 / lag).exp_m1() } else { 1.0 };
    let mut level = values[0];
    let lagged = values.iter().map(|value| {
        level += gain * (value - level);
        level
    });
    lagged.collect()
}
