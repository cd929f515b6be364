//! How often two means of one sensor that nothing moved are said to differ.

use vn100_analysis::{ComparedRecord, Comparison};

use super::{
    families,
    generators::Flicker,
    random::Random,
    record::{self, Record},
    scoring::limits,
};
use crate::{Arguments, figures, in_parallel};

/// Lengths of the records between the two.
const DEAD: [usize; 3] = [0, 2, 10];

/// One pair of records: of each channel, whether its means differ with p < 0.05, and the standard
/// error of the difference over that of white noise alone; `None` where it is not tested.
struct Tested {
    channels: Vec<Option<(bool, f64)>>,
    any: bool,
}

pub(crate) fn measure(arguments: &Arguments) {
    for minutes in arguments.minutes_or(&[10, 60]) {
        let duration_s = 60.0 * *minutes as f64;
        println!("### Means of two records of {minutes} min, {} pairs of 6 channels\n", arguments.records);
        println!(
            "| noise | lengths between | differ, % of channels | 95 % limits | untested % | differ after Holm, % of pairs | error over that of \
             white noise |"
        );
        println!("|---|---:|---:|---:|---:|---:|---:|");
        for dead in DEAD {
            for cell in families::of_means(duration_s) {
                // from the beginning of the first to the end of the second
                let whole = families::Cell { duration_s: (2 + dead) as f64 * duration_s, ..cell.clone() };
                let flicker = Flicker::new(whole.samples());
                let seed = format!("{} {dead}", cell.name);
                let tested = in_parallel(arguments.threads, arguments.records, |number| {
                    let mut random = Random::of_record(arguments.seed, &seed, cell.samples(), number);
                    pair(&cell, Record::of(&whole, &flicker, &mut random), &mut random)
                });
                row(&cell.name, dead, &tested);
            }
        }
        println!();
    }
}

fn pair(cell: &families::Cell, whole: Record, random: &mut Random) -> Tested {
    let start_s = cell.duration_s * (whole.series[0].len() / cell.samples() - 1) as f64;
    // the same levels in both
    let assessed = whole.ends(cell.samples()).map(|record| record.assess(cell, &mut random.clone()));
    let records: Vec<_> = (assessed.iter().zip([0.0, start_s]))
        .map(|(assessed, start_s)| ComparedRecord {
            name: "",
            snapshot: &assessed.snapshot,
            assessment: &assessed.assessment,
            started_ns: Some((start_s * 1e9) as i64),
        })
        .collect();
    let comparison = Comparison::of(&records, true, 0.95);
    let white = cell.truth().white * (2.0 / cell.duration_s).sqrt();
    let of = |(_, name): (usize, &str)| {
        let channel = comparison.means.iter().find(|means| means.channel == name).unwrap();
        let test = channel.differences[0].test.ok()?;
        let scale = record::counts_per_unit() * cell.step;
        Some((test.chance.p < 0.05, test.standard_error * scale / white))
    };
    let tests = comparison.means.iter().flat_map(|means| &means.differences);
    let tests = tests.filter_map(|difference| difference.test.ok());
    let mut tests = tests;
    Tested {
        channels: record::scored().map(of).collect(),
        any: tests.any(|test| comparison.is_significant(test.chance)),
    }
}

fn row(name: &str, dead: usize, tested: &[Tested]) {
    let channels: Vec<_> = tested.iter().flat_map(|tested| &tested.channels).collect();
    let known: Vec<_> = channels.iter().filter_map(|channel| **channel).collect();
    let differ = known.iter().filter(|(differs, _)| *differs).count();
    let (lower, upper) = limits(differ, known.len());
    let percent = |part: usize, of: usize| 100.0 * part as f64 / of.max(1) as f64;
    let values = [
        ("differ %", format!("{:.1}", percent(differ, known.len()))),
        ("limits", format!("{:.1} to {:.1}", 100.0 * lower, 100.0 * upper)),
    ];
    figures::record("means", &format!("{name}, {dead} lengths between"), &values);
    let mut errors: Vec<f64> = known.iter().map(|(_, error)| *error).collect();
    errors.sort_by(f64::total_cmp);
    println!(
        "| {name} | {dead} | {:.1} | {:.1} to {:.1} | {:.1} | {:.1} | {:.2} |",
        percent(differ, known.len()),
        100.0 * lower,
        100.0 * upper,
        percent(channels.len() - known.len(), channels.len()),
        percent(tested.iter().filter(|tested| tested.any).count(), tested.len()),
        errors.get(errors.len() / 2).copied().unwrap_or(f64::NAN)
    );
}
