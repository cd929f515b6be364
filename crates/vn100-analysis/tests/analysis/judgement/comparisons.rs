//! What several records say of each other.

use std::{sync::Arc, time::Duration};

use vn100_analysis::{
    Assessment, CaveatKind, Comparison, OctaveTest, Parts, Settings, Snapshot, SourceFacts, SourceResult,
};
use vn100_protocol::{Channel, Quantity, VNYMR};

use super::simulated::{LOUDER, Simulated, WINDOWS_OF_4, still};

fn compared(records: &[(Snapshot, Assessment)]) -> Comparison {
    let result = |(snapshot, assessment): &(Snapshot, Assessment)| {
        let (snapshot, assessment) = (Arc::new(snapshot.clone()), Arc::new(assessment.clone()));
        SourceResult::new(SourceFacts::default(), snapshot, assessment, Parts::WithoutSignals)
    };
    Comparison::of(&records.iter().map(result).collect::<Vec<_>>(), &[], 0.95)
}

fn kinds(comparison: &Comparison) -> Vec<CaveatKind> {
    comparison.caveats.iter().map(|caveat| caveat.kind).collect()
}

#[test]
fn the_quietest_leads_where_noise_differs() {
    let comparison = compared(&[
        Simulated { level: LOUDER, ..Simulated::default() }.record(),
        Simulated { seed: 2, ..Simulated::default() }.record(),
    ]);
    let of = |quantity| comparison.rankings.iter().find(|ranking| ranking.quantity == quantity).unwrap();
    let gyro = of(Quantity::AngularRate);
    assert_eq!(gyro.records.iter().map(|record| record.record).collect::<Vec<_>>(), [1, 0]);
    assert_eq!((gyro.unit, gyro.folds_alike, gyro.not_ranked.len()), ("rad/s/sqrt(Hz)", true, 0));
    let quiet = &gyro.records[0];
    assert!((quiet.white / (300e-6 * 0.025_f64.sqrt()) - 1.0).abs() < 0.02, "{quiet:?}");
    assert!((gyro.records[1].white / quiet.white - 1.5).abs() < 0.03);
    assert!(quiet.lower < quiet.white && quiet.white < quiet.upper && quiet.upper < 1.05 * quiet.white);
    assert_eq!(quiet.axes.iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>(), ["gyro_x", "gyro_y", "gyro_z"]);
    assert!((quiet.own() * 5_f64.sqrt() / quiet.white - 1.0).abs() < 1e-12);
    assert!(gyro.lead().unwrap().differs && gyro.quietest == Some(1));
    let accel = of(Quantity::Acceleration);
    assert!(!accel.lead().unwrap().differs && accel.quietest.is_none(), "{accel:?}");
    assert!(gyro.tests.iter().chain(&accel.tests).all(|test| test.chance.corrected >= test.chance.p));
    assert_eq!(comparison.rankings.len(), 3);
    // every octave of the gyroscope that is known well differs at short averaging times
    let short = |sensor| {
        let channels = comparison.channels.iter().filter(move |channel| channel.name.starts_with(sensor));
        channels.flat_map(|channel| &channel.octaves).filter(|test: &&OctaveTest| test.tau_s < 1.0)
    };
    assert_eq!(short("gyro").count(), 3 * 6);
    for test in short("gyro") {
        assert!((test.deviations[0] / test.deviations[1] - 1.5).abs() < 0.2, "{test:?}");
        assert_eq!((test.records, test.chance.differs), ([0, 1], true), "{test:?}");
    }
    assert!(short("accel").all(|test| !test.chance.differs));
    assert_eq!(short("temp").count(), 0, "the weather's");
    assert_eq!(kinds(&comparison), []);
}

#[test]
fn means_spread_by_more_than_noise_where_a_bias_moved() {
    let shifted: fn(&Channel) -> (f64, f64) = |channel| {
        let (mean, std) = still(channel);
        (if channel.name == "gyro_x" { mean + 500.0 } else { mean }, std)
    };
    let (first, second) = (Simulated::default(), Simulated { seed: 3, level: shifted, ..Simulated::default() });
    let comparison = compared(&[first.record(), second.record()]);
    assert_eq!(comparison.means.len(), 9);
    for means in &comparison.means {
        let (spread, [first, second]) = (means.spread.unwrap(), &means.means[..]) else { panic!("{means:?}") };
        assert!((spread.deviation * 2_f64.sqrt() / (second.mean - first.mean).abs() - 1.0).abs() < 1e-9);
        assert!(!means.bias_removed && (spread.lower, spread.upper, spread.dof) == (None, None, 1));
    }
    let of_x = comparison.means.iter().find(|means| means.name == "gyro_x").unwrap();
    assert!((of_x.means[1].mean - of_x.means[0].mean - 500e-6).abs() < 20e-6, "{of_x:?}");
    let of = |serial, seed| {
        Simulated { registers: vec![WINDOWS_OF_4, (3, serial)], samples: 2000, seed, ..Simulated::default() }.record()
    };
    let same = compared(&[of("0100011981", 1), of("0100011981", 2)]);
    assert_eq!(kinds(&same), []);
    let other = compared(&[of("0100011981", 1), of("0100011982", 2)]);
    assert_eq!(kinds(&other), [CaveatKind::SeveralSensors]);
    assert!(other.means.iter().all(|means| means.spread.is_none()));
}

#[test]
fn records_of_the_same_samples_are_told_so_and_not_tested() {
    let record = |samples, skip_s| {
        let settings = Settings { rate_hz: Some(40.0), skip: Duration::from_secs(skip_s), ..Settings::default() };
        Simulated { samples, settings, ..Simulated::default() }.record()
    };
    let same = compared(&[record(8000, 0), record(8000, 0)]);
    assert_eq!(kinds(&same), [CaveatKind::SameSamples]);
    assert_eq!((same.channels.len(), same.caveats[0].records.clone()), (0, vec![0, 1]));
    assert!(same.rankings.iter().all(|ranking| ranking.tests.is_empty() && ranking.lead().is_none()));
    let shared = same.same_samples[0];
    assert_eq!((shared.records, shared.of_first, shared.of_second), ([0, 1], 1.0, 1.0));
    // the second half of the first
    let part = compared(&[record(8000, 0), record(8000, 100)]);
    let shared = part.same_samples[0];
    assert!(shared.of_first < 0.6 && shared.of_second == 1.0, "{shared:?}");
    let overlapping = Simulated { samples: 8000, settings: record_end(150), ..Simulated::default() }.record();
    let overlap = compared(&[overlapping, record(8000, 100)]);
    // by a sample of the rows
    let shared = overlap.same_samples[0];
    let is_near = |part: f64, expected: f64| (part - expected).abs() < 0.03;
    assert!(is_near(shared.of_first, 1.0 / 3.0) && is_near(shared.of_second, 0.5), "{shared:?}");
    let others = compared(&[record(8000, 0), Simulated { samples: 8000, seed: 2, ..Simulated::default() }.record()]);
    assert!(others.same_samples.is_empty() && !others.channels.is_empty());
}

fn record_end(duration_s: u64) -> Settings {
    let duration = Some(Duration::from_secs(duration_s));
    Settings { rate_hz: Some(40.0), duration, ..Settings::default() }
}

#[test]
fn what_stands_between_two_records_is_a_caveat() {
    let at = |rate_hz| Settings { rate_hz: Some(rate_hz), ..Settings::default() };
    let kinds_of = |first: Simulated, second: Simulated| {
        kinds(&compared(&[first.record(), Simulated { seed: 2, ..second }.record()]))
    };
    let short = || Simulated { samples: 2000, ..Simulated::default() };
    assert_eq!(kinds_of(short(), Simulated { samples: 0, ..short() }), [CaveatKind::NoSamples]);
    let one_mean = [short().record(), Simulated { samples: 0, ..short() }.record()];
    assert_eq!(kinds(&compared(&one_mean)), [CaveatKind::NoSamples]);
    let assumed = Simulated { settings: Settings::default(), ..short() };
    assert_eq!(kinds_of(short(), assumed), [CaveatKind::RateAssumed]);
    let other_rate = Simulated { settings: at(30.0), ..short() };
    assert_eq!(kinds_of(short(), other_rate), [CaveatKind::NoCommonTau, CaveatKind::Sampling]);
    assert_eq!(kinds_of(short(), Simulated { settings: at(20.0), ..short() }), [CaveatKind::Sampling]);
    // which of them is faster is no matter
    let at_rates = |first, second| {
        kinds_of(Simulated { settings: at(first), ..short() }, Simulated { settings: at(second), ..short() })
    };
    assert_eq!(at_rates(20.0, 40.0), [CaveatKind::Sampling]);
    assert_eq!(at_rates(40.0, 32.0), [CaveatKind::NoCommonTau, CaveatKind::Sampling]);
    let unaliased = Simulated { registers: vec![(85, "0,20,20,4,0,0,3,3,3,0")], ..short() };
    assert_eq!(kinds_of(short(), unaliased), [CaveatKind::Sampling]);
    let compensated = kinds_of(short(), Simulated { layout: VNYMR.clone(), ..short() });
    assert_eq!(compensated, [CaveatKind::Channels, CaveatKind::Compensation]);
    let moving: fn(&Channel) -> (f64, f64) = |channel| {
        let (mean, std) = still(channel);
        (mean, if channel.quantity == Quantity::AngularRate { 60_000.0 } else { std })
    };
    let moved = compared(&[short().record(), Simulated { level: moving, ..short() }.record()]);
    assert_eq!((kinds(&moved), moved.caveats[0].records.clone()), (vec![CaveatKind::Moved], vec![1]));
    assert!(moved.means.iter().all(|means| means.means.len() == 1), "a mean of a moved sensor is no bias");
    assert!(moved.disturbances.iter().any(|(record, warning)| *record == 1 && warning.channels.len() == 3));
}

#[test]
fn records_at_rates_that_fold_differently_are_not_ranked_as_they_are() {
    let at = |rate_hz: f64, seed| {
        let settings = Settings { rate_hz: Some(rate_hz), ..Settings::default() };
        Simulated { settings, seed, ..Simulated::default() }.record()
    };
    let folds_alike = |a: f64, b: f64| {
        let comparison = compared(&[at(a, 1), at(b, 2)]);
        comparison.rankings.iter().find(|ranking| ranking.quantity == Quantity::AngularRate).unwrap().folds_alike
    };
    assert!(folds_alike(40.0, 40.0));
    assert!(!folds_alike(40.0, 50.0));
    assert!(!folds_alike(50.0, 40.0));
}
