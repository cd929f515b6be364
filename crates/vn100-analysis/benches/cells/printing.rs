//! Markdown tables.

use imu_noise::Term;

use crate::{Arguments, figures};

use super::{
    families::{Cell, Family},
    record::Took,
    scoring::{RecordScore, TERMS, Tally},
};

/// A table of one family; `scores` of `records` for each cell, in their order. With one thread the
/// CPU time of an assessment is known.
pub(crate) fn family(family: &Family, minutes: usize, arguments: &Arguments, scores: &[RecordScore]) {
    let records = arguments.records;
    println!("### {}, {minutes} min, {records} records of 6 channels\n", family.name);
    println!(
        "| cell | | held % | 95 % limits | missed % | estimated % | not observable | rejected | bias % | rms error % | of bound | \
         half width % | false, % of records |"
    );
    println!("|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    let mut recorded = Vec::new();
    for (cell, scores) in family.cells.iter().zip(scores.chunks(records.max(1))) {
        rows(cell, scores);
        let shares = shares(cell, scores);
        figures::record("cells", &format!("{}, {minutes} min", cell.name), &recorded_cell(shares));
        recorded.push(shares);
    }
    if arguments.cell.is_none() {
        figures::record("families", &format!("{}, {minutes} min", family.name), &recorded_family(&recorded));
    }
    println!();
    if arguments.threads > 1 {
        return;
    }
    let median_ms = |of: fn(&Took) -> f64| {
        let mut times: Vec<f64> = scores.iter().map(|score| of(&score.took)).collect();
        times.sort_by(f64::total_cmp);
        1e3 * times.get(times.len() / 2).copied().unwrap_or_default()
    };
    let (cpu_ms, wall_ms) = (median_ms(|took| took.cpu_s), median_ms(|took| took.wall_s));
    println!("An assessment of 11 channels takes {wall_ms:.1} ms in the median, {cpu_ms:.1} ms of CPU.\n");
}

fn rows(cell: &Cell, scores: &[RecordScore]) {
    let truth = cell.truth();
    for (place, term) in TERMS.into_iter().enumerate() {
        let is_shown = match term {
            Term::White => true,
            Term::RateRamp => truth.ramp != 0.0,
            _ => truth.is_of_model,
        };
        if !is_shown {
            continue;
        }
        let channels = scores.iter().flat_map(|score| &score.channels);
        let tally = Tally::new(channels.map(|statements| statements[place]));
        let samples = scores.iter().map(|score| score.samples as f64).sum::<f64>() / scores.len() as f64;
        let of_bound = tally.rms_error().filter(|_| term == Term::White).map(|error| error * (2.0 * samples).sqrt());
        let (lower, upper) = tally.held_limits();
        let absent: Vec<usize> = match term {
            Term::White => (1..TERMS.len()).filter(|place| truth.of(TERMS[*place]) == 0.0).collect(),
            _ => (truth.of(term) == 0.0).then_some(place).into_iter().collect(),
        };
        let are_false = |score: &&RecordScore| absent.iter().any(|place| score.estimates(*place));
        let false_share = (truth.is_of_model && !absent.is_empty())
            .then(|| scores.iter().filter(are_false).count() as f64 / scores.len() as f64);
        let share = |count: usize| percent(count as f64 / tally.of as f64);
        println!(
            "| {} | {} | {} | {}-{} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            if place == 0 { &cell.name } else { "" },
            vn100_analysis::letter(term),
            share(tally.held),
            percent(lower),
            percent(upper),
            share(tally.missed()),
            share(tally.estimated),
            tally.not_observable,
            tally.rejected,
            tally.bias().map_or("".into(), |bias| format!("{:+.2}", 100.0 * bias)),
            tally.rms_error().map_or("".into(), |error| format!("{:.2}", 100.0 * error)),
            of_bound.map_or("".into(), |ratio| format!("{ratio:.2}")),
            tally.half_width().map_or("".into(), |width| format!("{:.2}", 100.0 * width)),
            false_share.map_or("".into(), percent),
        );
    }
}

/// Of one cell, in percent: N held, N estimated, B held, K held, and records with a false term.
fn shares(cell: &Cell, scores: &[RecordScore]) -> [Option<f64>; 5] {
    let truth = cell.truth();
    let tally =
        |place: usize| Tally::new(scores.iter().flat_map(|score| &score.channels).map(|channel| channel[place]));
    let share = |count: usize, of: usize| 100.0 * count as f64 / of as f64;
    let held = |place: usize| share(tally(place).held, tally(place).of);
    let of_model = |value: f64| truth.is_of_model.then_some(value);
    let is_false =
        |score: &&RecordScore| (1..TERMS.len()).any(|place| truth.of(TERMS[place]) == 0.0 && score.estimates(place));
    let false_percent = share(scores.iter().filter(is_false).count(), scores.len());
    let estimated = share(tally(0).estimated, tally(0).of);
    [Some(held(0)), Some(estimated), of_model(held(1)), of_model(held(2)), of_model(false_percent)]
}

const SHARES: [&str; 5] = ["N held", "N estimated", "B held", "K held", "false"];

fn recorded_cell(shares: [Option<f64>; 5]) -> [(&'static str, String); 5] {
    std::array::from_fn(|place| (SHARES[place], shares[place].map_or("-".into(), |share| format!("{share:.1}"))))
}

/// The lowest and the highest of the cells.
fn recorded_family(cells: &[[Option<f64>; 5]]) -> Vec<(&'static str, String)> {
    let range = |place: usize| {
        let shares = || cells.iter().filter_map(|cell| cell[place]);
        let (lowest, highest) = (shares().fold(f64::INFINITY, f64::min), shares().fold(0.0, f64::max));
        if lowest > highest { "-".into() } else { format!("{lowest:.1} to {highest:.1}") }
    };
    let ranges = SHARES.iter().enumerate().map(|(place, name)| (*name, range(place)));
    [("cells", cells.len().to_string())].into_iter().chain(ranges).collect()
}

fn percent(share: f64) -> String {
    format!("{:.1}", 100.0 * share)
}
