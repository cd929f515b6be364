//! Markdown tables.

use imu_noise::Term;

use crate::Arguments;

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
    for (cell, scores) in family.cells.iter().zip(scores.chunks(records.max(1))) {
        rows(cell, scores);
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

fn percent(share: f64) -> String {
    format!("{:.1}", 100.0 * share)
}
