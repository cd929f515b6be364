//! Why records can be compared only in part, in words.

use vn100_analysis::protocol::Quantity;
use vn100_analysis::{
    BEFORE_FILTER_S, Caveat, CaveatKind, Comparison, Onboard, Remedy, RemedyWords, SameSamples, SourceResult,
};

use crate::numbers::plain::short;

/// A caveat of a comparison of `all`, with its consequence and its remedy.
pub fn caveat_in_words(caveat: &Caveat, all: &[SourceResult], comparison: &Comparison, words: RemedyWords) -> String {
    let records: Vec<&SourceResult> = caveat.records.iter().filter_map(|record| all.get(*record)).collect();
    let name = |record: &SourceResult| record.source.name.clone();
    match (caveat.kind, &records[..]) {
        (CaveatKind::SameSamples, [a, b]) => {
            let same = comparison.same_samples.iter().find(|same| same.records[..] == caveat.records[..]);
            let same = same.map_or_else(String::new, |same| same_samples(&name(a), &name(b), same));
            format!("{same}. They are not tested against each other")
        }
        (CaveatKind::NoSamples, [record, ..]) => format!("{} holds no samples and is not compared", name(record)),
        (CaveatKind::RateAssumed, [first, ..]) => {
            let names: Vec<String> = records.iter().map(|record| name(record)).collect();
            format!(
                "sample rate of {} unknown; {} Hz assumed, and all averaging times and N scale with it. Recordings of this program keep their \
                 rate: {}",
                names.join(", "),
                first.timing.rate_hz.map_or_else(String::new, short),
                words(&Remedy::GiveRate(None))
            )
        }
        (CaveatKind::Moved, [record, ..]) => {
            format!("{}: sensor moved. Its means are no bias and are excluded", name(record))
        }
        (CaveatKind::Channels, [a, b]) => {
            let lone: Vec<String> = [(a, b), (b, a)].into_iter().filter_map(|(own, other)| lone(own, other)).collect();
            format!("{}: not compared", lone.join("; "))
        }
        (CaveatKind::NoCommonTau, [a, b]) => {
            let [rate_a, rate_b] = [a, b].map(|record| record.timing.rate_hz.unwrap_or(f64::NAN));
            format!(
                "{} at {} Hz and {} at {} Hz have no averaging time in common: their octaves are not compared",
                name(a),
                (rate_a * 1e4).round() / 1e4,
                name(b),
                (rate_b * 1e4).round() / 1e4
            )
        }
        (CaveatKind::Sampling, [a, b]) => sampling(a, b),
        (CaveatKind::Compensation, [a, b]) => {
            let whether = match (a.source.compensated, b.source.compensated) {
                (None, _) => format!("may be removed in {}, which does not state it", name(a)),
                (_, None) => format!("may be removed in {}, which does not state it", name(b)),
                (Some(true), _) => format!("is removed in {} but not in {}", name(a), name(b)),
                (Some(false), _) => format!("is removed in {} but not in {}", name(b), name(a)),
            };
            format!("the gyroscope's bias {whether}: its octaves are compared up to {BEFORE_FILTER_S} s")
        }
        (CaveatKind::SeveralSensors, _) => {
            "the records have more than one serial number: their means are not repetitions of one sensor, and no turn-on to turn-on bias is \
             given"
                .into()
        }
        _ => String::new(),
    }
}

fn same_samples(a: &str, b: &str, same: &SameSamples) -> String {
    let (of_a, of_b) = (same.of_first, same.of_second);
    match (of_a >= SameSamples::WHOLE, of_b >= SameSamples::WHOLE) {
        (true, true) => format!("{a} and {b} hold the same samples: it is the same recording"),
        (true, false) => format!("{a} is a part of {b}: all its samples are in it"),
        (false, true) => format!("{b} is a part of {a}: all its samples are in it"),
        (false, false) => format!(
            "{a} and {b} overlap: about {:.0} % of the samples of the first are in the second, which are {:.0} % of that",
            100.0 * of_a,
            100.0 * of_b
        ),
    }
}

/// The channels, by name and unit, that one record alone has.
fn lone(own: &SourceResult, other: &SourceResult) -> Option<String> {
    let is_lone =
        |name: &str, unit: &str| !other.streamed().any(|channel| (&*channel.name, &*channel.unit) == (name, unit));
    let lone = own.streamed().filter(|channel| is_lone(&channel.name, &channel.unit));
    let lone: Vec<&str> = lone.map(|channel| &*channel.name).collect();
    (!lone.is_empty()).then(|| format!("{} alone has {}", own.source.name, lone.join(", ")))
}

fn sampling(a: &SourceResult, b: &SourceResult) -> String {
    let factor = |record: &SourceResult| {
        let onboard = record.of(Quantity::AngularRate).first()?.onboard?;
        Some(onboard.window.white_factor())
    };
    let (a, of_a, b, of_b) = (&a.source.name, factor(a), &b.source.name, factor(b));
    let differently = match of_a.zip(of_b) {
        Some((of_a, of_b)) => format!(
            "averages and decimates differently in {a} and {b}: aliasing raises its white noise differently (by {of_a:.2} in {a} and {of_b:.2} in \
             {b}, ±{:.0} %)",
            100.0 * Onboard::UNCERTAINTY
        ),
        // what it does on board is not known
        None => format!(
            "may average and decimate differently in {a} and {b}, and its white noise be raised differently by aliasing"
        ),
    };
    format!(
        "the sensor {differently}, so that differences of short octaves or of N need not be differences of the sensors"
    )
}
