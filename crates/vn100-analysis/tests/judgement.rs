//! What records of simulated sensors say: verdicts, comparisons, warnings, plans.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::{sync::Arc, time::Duration};

use imu_noise::{Claim, Grade, Sensor, Term, Verdict};
use vn100_analysis::{
    Analysis, Assessment, CaveatKind, ChannelMeans, ComparedRecord, Comparison, Datasheet, DatasheetFigure, Detrend,
    Given, Goal, NoGrade, Plan, PlanningError, Recommendation, Settings, SheetOnboard, Snapshot, StreamUnknown,
    UnmetGoal, Untested, Want, WarningKind, WhyNone, WhyUnmet, WhyUse, WindowFrom, not_passed,
};
use vn100_protocol::stream::{Batch, StreamCounts};
use vn100_protocol::{
    AsyncRate, AsyncType, BaudRate, Channel, DeviceError, Layout, Quantity, Register, RegisterContents, RegisterFields,
    VNIMU, VNYMR,
};

/// Windows of four refreshes, averaged in both outputs.
const WINDOWS_OF_4: (u8, &str) = (85, "0,4,4,4,0,0,3,3,3,0");

/// Mean and standard deviation, in counts, of a sensor that lies still.
fn still(channel: &Channel) -> (f64, f64) {
    match channel.quantity {
        Quantity::AngularRate => (0.0, 300.0),
        Quantity::Acceleration => (if channel.name.ends_with('z') { -9806.0 } else { 0.0 }, 20.0),
        Quantity::MagneticField => (if channel.name.ends_with('x') { 5000.0 } else { 0.0 }, 30.0),
        _ => (21_000.0, 5.0),
    }
}

/// Ten minutes of white noise at 40 Hz, unless the settings say otherwise.
struct Simulated {
    layout: Layout,
    settings: Settings,
    samples: u64,
    seed: u64,
    registers: Vec<(u8, &'static str)>,
    level: fn(&Channel) -> (f64, f64),
    /// What is added to the noise, in counts, by the number of the sample.
    added: fn(&Channel, u64) -> f64,
    link: StreamCounts,
}

impl Default for Simulated {
    fn default() -> Self {
        let settings = Settings { rate_hz: Some(40.0), ..Settings::default() };
        let registers = vec![WINDOWS_OF_4];
        Self {
            layout: VNIMU.clone(),
            settings,
            samples: 24_000,
            seed: 1,
            registers,
            level: still,
            added: |_, _| 0.0,
            link: StreamCounts::default(),
        }
    }
}

impl Simulated {
    fn record(self) -> (Snapshot, Assessment) {
        let mut state = self.seed;
        let mut normal = || {
            let uniform = (0..12).map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / 2_f64.powi(53)
            });
            uniform.sum::<f64>() - 6.0
        };
        let levels: Vec<_> = self.layout.channels.iter().map(self.level).collect();
        let mut counts = Vec::new();
        for sample in 0..self.samples {
            for (channel, (mean, std)) in self.layout.channels.iter().zip(&levels) {
                counts.push((mean + std * normal() + (self.added)(channel, sample)).round() as i32);
            }
        }
        let reply = |&(register, fields): &(u8, &str)| RegisterContents {
            register: Register(register),
            fields: RegisterFields::new(fields).unwrap(),
        };
        let registers = self.registers.iter().map(reply).collect();
        let layout = Some(Arc::new(self.layout));
        let mut batch = Batch { layout, counts, registers, link: self.link, ..Batch::default() };
        batch.link.tally.samples = self.samples;
        let mut analysis = Analysis::new(self.settings);
        analysis.absorb(&batch);
        let snapshot = analysis.snapshot();
        let assessment = Assessment::new(&snapshot, 0.95);
        (snapshot, assessment)
    }
}

/// As of one sensor that stayed on, each an hour behind the one before.
fn compared(records: &[(Snapshot, Assessment)]) -> Comparison {
    compared_as(records, |number| Some(number * 3_600_000_000_000), true)
}

fn compared_as(
    records: &[(Snapshot, Assessment)],
    started_ns: impl Fn(i64) -> Option<i64>,
    stayed_on: bool,
) -> Comparison {
    let names = ["first", "second", "third"];
    let records: Vec<_> = (records.iter().zip(names).zip(0..))
        .map(|(((snapshot, assessment), name), number)| ComparedRecord {
            name,
            snapshot,
            assessment,
            started_ns: started_ns(number),
        })
        .collect();
    Comparison::of(&records, stayed_on, 0.95)
}

fn kinds(comparison: &Comparison) -> Vec<CaveatKind> {
    comparison.caveats.iter().map(|caveat| caveat.kind).collect()
}

fn named(warnings: &[vn100_analysis::Warning], kind: WarningKind) -> Vec<&str> {
    warnings.iter().filter(|warning| warning.kind == kind).flat_map(|w| &w.channels).map(String::as_str).collect()
}

fn figure(sensor: Sensor, term: Term, claim: Claim) -> DatasheetFigure {
    DatasheetFigure {
        sensor,
        term,
        claim,
        is_of_unknown_sides: false,
        is_minimum: false,
        printed: "as printed".into(),
        source: None,
    }
}

fn sheet(figures: Vec<DatasheetFigure>) -> Datasheet {
    Datasheet { name: "a sheet".into(), note: None, onboard: None, figures, typical_is_limit: false }
}

const LOUDER: fn(&Channel) -> (f64, f64) = |channel| {
    let (mean, std) = still(channel);
    (mean, if channel.quantity == Quantity::AngularRate { 1.5 * std } else { std })
};

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
    assert_eq!(quiet.axes.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["gyro_x", "gyro_y", "gyro_z"]);
    assert!((quiet.own() * 5_f64.sqrt() / quiet.white - 1.0).abs() < 1e-12);
    assert!(comparison.is_significant(gyro.lead().unwrap()));
    let accel = of(Quantity::Acceleration);
    assert!(!comparison.is_significant(accel.lead().unwrap()), "{accel:?}");
    assert!(gyro.tests.iter().chain(&accel.tests).all(|test| test.chance.corrected >= test.chance.p));
    assert_eq!(comparison.rankings.len(), 3);
    // every octave of the gyroscope that is known well differs at short averaging times
    let short = |quantity| comparison.octaves.iter().filter(move |test| test.quantity == quantity && test.tau_s < 1.0);
    assert_eq!(short(Quantity::AngularRate).count(), 3 * 6);
    for test in short(Quantity::AngularRate) {
        assert!((test.deviations[0] / test.deviations[1] - 1.5).abs() < 0.2, "{test:?}");
        assert_eq!((test.records, comparison.is_significant(test.chance)), ([0, 1], true), "{test:?}");
    }
    assert!(short(Quantity::Acceleration).all(|test| !comparison.is_significant(test.chance)));
    assert_eq!(short(Quantity::Temperature).count(), 0, "the weather's");
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
    let mut least = f64::INFINITY;
    for means in comparison.means.iter().filter(|means| means.quantity != Quantity::MagneticField) {
        let (spread, [difference]) = (means.spread.unwrap(), &means.differences[..]) else { panic!("{means:?}") };
        let test = difference.test.unwrap();
        assert_eq!(comparison.is_significant(test.chance), means.channel == "gyro_x", "{means:?}");
        assert_eq!(difference.difference, means.means[1].mean - means.means[0].mean);
        assert!((spread.deviation * 2_f64.sqrt() / difference.difference.abs() - 1.0).abs() < 1e-9);
        assert!(!means.bias_removed && spread.interval.is_none());
        // of white noise alone std/√n, and √2 of it
        let white = still_std(&means.channel) / 24_000_f64.sqrt();
        for mean in &means.means {
            let error = mean.error.unwrap();
            assert!(error.standard_error > 0.97 * white && error.tau_s == 600.0, "{means:?}");
            least = least.min(error.standard_error / white);
        }
        assert!(test.standard_error > 0.97 * 2_f64.sqrt() * white, "{means:?}");
    }
    // what a walk that the record does not show may do
    assert!((1.0..3.5).contains(&least), "{least}");
    // long averages of a field are the surroundings'
    let field = comparison.means.iter().filter(|means| means.quantity == Quantity::MagneticField);
    assert!(field.clone().all(|means| means.differences[0].test == Err(Untested::NoiseUnknown)));
    assert_eq!(field.count(), 3);
    let of = |serial, seed| {
        Simulated { registers: vec![WINDOWS_OF_4, (3, serial)], samples: 2000, seed, ..Simulated::default() }.record()
    };
    let same = compared(&[of("0100011981", 1), of("0100011981", 2)]);
    assert_eq!(kinds(&same), []);
    let other = compared(&[of("0100011981", 1), of("0100011982", 2)]);
    assert_eq!(kinds(&other), [CaveatKind::SeveralSensors]);
    assert!(other.means.iter().all(|means| means.spread.is_none()));
    assert!(other.means.iter().all(|means| means.differences[0].test == Err(Untested::SeveralSensors)));
    assert_eq!(other.recommended, Err(WhyNone::SeveralSensors));
}

/// In the unit of the channel.
fn still_std(name: &str) -> f64 {
    let channel = VNIMU.channels.iter().find(|channel| channel.name == name).unwrap();
    channel.in_unit(still(channel).1)
}

#[test]
fn a_difference_of_means_has_no_probability_where_nothing_bounds_what_lies_between() {
    let short = |seed| Simulated { samples: 4000, seed, ..Simulated::default() }.record();
    let records = [short(1), short(2)];
    let tests = |comparison: &Comparison| comparison.means[3].differences[0].test.map(|_| ());
    let unknown = compared_as(&records, |_| None, true);
    assert_eq!((kinds(&unknown), tests(&unknown)), (vec![CaveatKind::StartUnknown], Err(Untested::StartUnknown)));
    assert_eq!(unknown.caveats[0].records, [0, 1]);
    let off = compared_as(&records, |number| Some(number << 40), false);
    assert_eq!((kinds(&off), tests(&off)), (vec![CaveatKind::MayHaveBeenOff], Err(Untested::MayHaveBeenOff)));
    let at_once = compared_as(&records, |_| Some(5), true);
    assert_eq!((kinds(&at_once), tests(&at_once)), (vec![], Err(Untested::SameTime)));
    let known = compared(&records);
    assert_eq!((kinds(&known), tests(&known)), (vec![], Ok(())));
    // the longer the time between, the further may flicker and walk have gone
    let error = |between_ns: i64| {
        let comparison = compared_as(&records, |number| Some(number * between_ns), true);
        let of = |means: &ChannelMeans| means.differences[0].test.ok().map(|test| test.standard_error);
        comparison.means.iter().filter_map(of).collect::<Vec<_>>()
    };
    let (near, far) = (error(100_000_000_000), error(100_000_000_000_000));
    assert!(near.len() >= 5 && near.iter().zip(&far).all(|(near, far)| near <= far), "{near:?} {far:?}");
    assert!(near.iter().zip(&far).any(|(near, far)| near < far), "{near:?} {far:?}");
}

#[test]
fn records_of_the_same_samples_are_told_so_and_not_tested() {
    let record = |samples, skip_s| {
        let settings = Settings { rate_hz: Some(40.0), skip: Duration::from_secs(skip_s), ..Settings::default() };
        Simulated { samples, settings, ..Simulated::default() }.record()
    };
    let same = compared(&[record(8000, 0), record(8000, 0)]);
    assert_eq!(kinds(&same), [CaveatKind::SameSamples]);
    let text = same.caveats[0].text.to_string();
    assert!(text.contains("first and second hold the same samples: it is the same recording"), "{text}");
    assert_eq!((same.octaves.len(), same.means[0].differences[0].test), (0, Err(Untested::SameSamples)));
    assert!(same.rankings.iter().all(|ranking| ranking.tests.is_empty() && ranking.lead().is_none()));
    let shared = same.same_samples[0];
    assert_eq!((shared.records, shared.shared.of_first, shared.shared.of_second), ([0, 1], 1.0, 1.0));
    assert_eq!(same.recommended, Ok(Recommendation { record: 0, why: WhyUse::LongestOfQuiet }));
    // the second half of the first
    let part = compared(&[record(8000, 0), record(8000, 100)]);
    let text = part.caveats[0].text.to_string();
    assert!(text.starts_with("second is a part of first: all its samples are in it"), "{text}");
    let overlapping = Simulated { samples: 8000, settings: record_end(150), ..Simulated::default() }.record();
    let overlap = compared(&[overlapping, record(8000, 100)]);
    let text = overlap.caveats[0].text.to_string();
    assert!(text.starts_with("first and second overlap: about 3") && text.contains("which are 50 %"), "{text}");
    let others = compared(&[record(8000, 0), Simulated { samples: 8000, seed: 2, ..Simulated::default() }.record()]);
    assert!(others.same_samples.is_empty() && !others.octaves.is_empty());
}

fn record_end(duration_s: u64) -> Settings {
    let duration = Some(Duration::from_secs(duration_s));
    Settings { rate_hz: Some(40.0), duration, ..Settings::default() }
}

#[test]
fn the_record_to_use_is_undisturbed_quiet_and_long() {
    let quiet = |seed, samples| Simulated { seed, samples, ..Simulated::default() }.record();
    let louder = Simulated { level: LOUDER, seed: 9, ..Simulated::default() }.record();
    let stepped: fn(&Channel, u64) -> f64 =
        |channel, sample| if channel.name == "gyro_z" && sample >= 12_000 { 3000.0 } else { 0.0 };
    let disturbed = |seed| Simulated { added: stepped, seed, ..Simulated::default() }.record();
    let recommended = |records: &[(Snapshot, Assessment)]| compared(records).recommended;
    let used = |record, why| Ok(Recommendation { record, why });
    assert_eq!(recommended(&[disturbed(1), louder.clone()]), used(1, WhyUse::OnlyUndisturbed));
    assert_eq!(recommended(&[disturbed(1), disturbed(2)]), Err(WhyNone::AllDisturbed));
    assert_eq!(recommended(&[louder, quiet(2, 8000)]), used(1, WhyUse::Quietest));
    assert_eq!(recommended(&[quiet(2, 8000), quiet(3, 24_000)]), used(1, WhyUse::LongestOfQuiet));
    let [a, b] = [quiet(2, 8000), quiet(3, 8000)];
    let size = |(_, assessment): &(Snapshot, Assessment)| -> f64 {
        let white = |sensor: Sensor| -> f64 {
            let of = |noise: &vn100_analysis::ChannelNoise| noise.parameter(Term::White).unwrap().value.unwrap();
            let noise = assessment.channels.iter().filter_map(|channel| channel.noise.as_ref());
            noise.filter(|noise| noise.sensor == sensor).map(|noise| of(noise).powi(2)).sum()
        };
        [Sensor::Gyroscope, Sensor::Accelerometer, Sensor::Magnetometer].map(white).iter().product()
    };
    let smaller = usize::from(size(&b) < size(&a));
    assert_eq!(recommended(&[a, b]), used(smaller, WhyUse::SmallestOfQuiet));
    assert_eq!(recommended(&[quiet(2, 3), quiet(3, 3)]), Err(WhyNone::NotRanked));
}

#[test]
fn what_stands_between_two_records_is_a_caveat() {
    let at = |rate_hz| Settings { rate_hz: Some(rate_hz), ..Settings::default() };
    let kinds_of = |first: Simulated, second: Simulated| {
        kinds(&compared(&[first.record(), Simulated { seed: 2, ..second }.record()]))
    };
    let short = || Simulated { samples: 2000, ..Simulated::default() };
    assert_eq!(kinds_of(short(), Simulated { samples: 0, ..short() }), [CaveatKind::NoSamples]);
    let assumed = Simulated { settings: Settings::default(), ..short() };
    assert_eq!(kinds_of(short(), assumed), [CaveatKind::RateAssumed]);
    let other_rate = Simulated { settings: at(30.0), ..short() };
    assert_eq!(kinds_of(short(), other_rate), [CaveatKind::NoCommonTau, CaveatKind::Sampling]);
    assert_eq!(kinds_of(short(), Simulated { settings: at(20.0), ..short() }), [CaveatKind::Sampling]);
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
    assert!(moved.disturbances.iter().any(|event| event.record == 1 && event.warning.channels.len() == 3));
}

#[test]
fn verdicts_count_what_the_stream_makes_of_white_noise() {
    // the stream reads 4.74e-5: 2.236 times the sensor's own, to within 10 %
    let verdicts = |limit, simulated: Simulated| {
        let (snapshot, assessment) = simulated.record();
        let sheet = sheet(vec![figure(Sensor::Gyroscope, Term::White, Claim::Limit(limit))]);
        let verdicts = sheet.verdicts(&snapshot, &assessment);
        let failed = |name: &str| not_passed(&name.parse().unwrap(), &snapshot, Some(&verdicts)).len();
        let counts = (failed("gyro N"), failed("gyro_y N"), failed("accel N"));
        let figures = |channel| usize::from((6..9).contains(&channel));
        assert!(verdicts.channels.iter().enumerate().all(|(channel, all)| all.len() == figures(channel)));
        let verdict = &verdicts.channels[7][0];
        (verdict.verdict, verdict.unknown, counts)
    };
    for (limit, expected, unmet) in
        [(1e-4, Verdict::Pass, 0), (2.1e-5, Verdict::Inconclusive, 3), (1e-5, Verdict::Fail, 3)]
    {
        let known = verdicts(limit, Simulated::default());
        assert_eq!(known, (expected, None, (unmet, unmet / 3, 3)), "{limit}");
    }
    let unknown = |registers, settings| Simulated { registers, settings, ..Simulated::default() };
    let given = Simulated::default().settings;
    let window = verdicts(1e-4, unknown(Vec::new(), given.clone()));
    assert_eq!((window.0, window.1), (Verdict::Consistent, Some(StreamUnknown::Window)));
    let rate = verdicts(1e-4, unknown(vec![WINDOWS_OF_4], Settings::default()));
    assert_eq!((rate.0, rate.1), (Verdict::Consistent, Some(StreamUnknown::Rate)));
    // a line that was taken out is no matter to white noise
    let detrended = verdicts(1e-4, unknown(vec![WINDOWS_OF_4], Settings { detrend: Some(Detrend::Line), ..given }));
    assert_eq!((detrended.0, detrended.1), (Verdict::Pass, None));
}

#[test]
fn a_window_that_is_given_counts_as_the_register_where_there_is_none() {
    let limit = |limit| sheet(vec![figure(Sensor::Gyroscope, Term::White, Claim::Limit(limit))]);
    let record = |window, registers| {
        let settings = Settings { window, ..Simulated::default().settings };
        Simulated { registers, settings, ..Simulated::default() }.record()
    };
    let verdict = |sheet: &Datasheet, (snapshot, assessment): &(Snapshot, Assessment)| {
        let verdict = sheet.verdicts(snapshot, assessment).channels[6][0].clone();
        (verdict.verdict, (verdict.stream.factor * 100.0).round())
    };
    let contradicted = |(_, assessment): &(Snapshot, Assessment)| {
        assessment.warnings.iter().any(|warning| warning.to_string().contains("is not used"))
    };
    let (of_4, of_20) = (record(Some(4), Vec::new()), record(Some(20), Vec::new()));
    assert_eq!(verdict(&limit(1e-4), &of_4), (Verdict::Pass, 224.0));
    // without aliasing the sensor itself has 4.74e-5
    assert_eq!(verdict(&limit(4e-5), &of_20), (Verdict::Fail, 100.0));
    assert!(!contradicted(&of_4) && !contradicted(&of_20));
    let otherwise = record(Some(20), vec![WINDOWS_OF_4]);
    assert_eq!(verdict(&limit(1e-4), &otherwise), (Verdict::Pass, 224.0));
    assert!(contradicted(&otherwise) && !contradicted(&record(Some(4), vec![WINDOWS_OF_4])));
    // it is none of the magnetometer's
    let from = |channel: usize| of_4.1.channels[channel].onboard.unwrap().window_from;
    assert_eq!((from(0), from(3), from(6)), (WindowFrom::Default, WindowFrom::Given, WindowFrom::Given));
}

#[test]
fn bias_instability_is_judged_whatever_the_window_and_the_rate() {
    let bias = |is_minimum, limit| DatasheetFigure {
        is_minimum,
        ..figure(Sensor::Gyroscope, Term::BiasInstability, Claim::Limit(limit))
    };
    let walk = figure(Sensor::Gyroscope, Term::RateRandomWalk, Claim::Limit(1.0));
    let verdicts = |figures: Vec<DatasheetFigure>, registers: Vec<(u8, &'static str)>, settings: Settings| {
        let (snapshot, assessment) = Simulated { registers, settings, ..Simulated::default() }.record();
        let verdicts = sheet(figures).verdicts(&snapshot, &assessment).channels[7].clone();
        verdicts.iter().map(|verdict| (verdict.verdict, verdict.unknown)).collect::<Vec<_>>()
    };
    let given = Simulated::default().settings;
    let all = || vec![bias(false, 1.0), bias(true, 1.0), walk.clone()];
    let passed = (Verdict::Pass, None);
    assert_eq!(verdicts(all(), Vec::new(), given.clone()), [passed; 3]);
    let assumed = (Verdict::Consistent, Some(StreamUnknown::Rate));
    assert_eq!(verdicts(all(), vec![WINDOWS_OF_4], Settings::default()), [passed, passed, assumed]);
    let detrended = Settings { detrend: Some(Detrend::Line), ..given };
    let removed = (Verdict::Consistent, Some(StreamUnknown::LineRemoved));
    assert_eq!(verdicts(all(), vec![WINDOWS_OF_4], detrended), [removed; 3]);
}

#[test]
fn the_minimum_of_the_curve_is_compared_only_where_the_sheet_means_it() {
    let (snapshot, assessment) = Simulated::default().record();
    let measured = |is_minimum, term| {
        let figure = DatasheetFigure { is_minimum, ..figure(Sensor::Gyroscope, term, Claim::Limit(1.0)) };
        let name = figure.is_curve_minimum();
        (sheet(vec![figure]).verdicts(&snapshot, &assessment).channels[6][0].measured, name)
    };
    let noise = assessment.channels[6].noise.as_ref().unwrap();
    let [white, bias] = [Term::White, Term::BiasInstability].map(|term| noise.parameter(term).unwrap());
    let minimum = noise.curve_minimum().unwrap();
    assert!(minimum.upper != bias.upper && minimum.upper != white.upper);
    assert_eq!(measured(true, Term::BiasInstability), (minimum, true));
    assert_eq!(measured(false, Term::BiasInstability), (bias, false));
    // a density has no minimum
    assert_eq!(measured(true, Term::White), (white, false));
    let flicker = |is_minimum| {
        let figure = figure(Sensor::Gyroscope, Term::BiasInstability, Claim::Limit(0.664));
        sheet(vec![DatasheetFigure { is_minimum, ..figure }]).typical_noise(Sensor::Gyroscope)[0].1
    };
    assert!((flicker(true) - 1.0).abs() < 1e-3 && flicker(false) == 0.664);
}

#[test]
fn a_sheet_that_names_its_averaging_decides_for_other_sensors_unless_neighbours_share_values() {
    let verdict = |onboard: Option<(f64, u32)>, name: &'static str| {
        let layout = Layout { message: name.into(), ..VNIMU.clone() };
        let (snapshot, assessment) = Simulated { layout, registers: Vec::new(), ..Simulated::default() }.record();
        let figures = [Sensor::Gyroscope, Sensor::Magnetometer]
            .map(|sensor| figure(sensor, Term::White, Claim::Limit(1.0)))
            .to_vec();
        let onboard = onboard.map(|(refresh_hz, window)| SheetOnboard { refresh_hz, window });
        let verdicts = Datasheet { onboard, ..sheet(figures) }.verdicts(&snapshot, &assessment).channels;
        (verdicts[6][0].verdict, verdicts[0][0].verdict, (verdicts[6][0].stream.factor * 100.0).round())
    };
    let (pass, consistent) = (Verdict::Pass, Verdict::Consistent);
    assert_eq!(verdict(None, "a CSV file"), (consistent, consistent, 100.0));
    // what the sheet says is of gyroscope and accelerometer
    assert_eq!(verdict(Some((40.0, 1)), "a CSV file"), (pass, consistent, 100.0));
    assert_eq!(verdict(Some((800.0, 4)), "a CSV file"), (pass, consistent, 224.0));
    assert_eq!(verdict(Some((40.0, 8)), "a CSV file"), (consistent, consistent, 100.0));
    // of a sensor that this program knows the stream itself would say it
    assert_eq!(verdict(Some((40.0, 1)), "VNIMU").2, 224.0);
}

#[test]
fn a_density_of_unknown_sides_has_two_readings_and_passes_by_neither() {
    // the stream reads 4.74e-5 and the sensor itself 2.12e-5
    let judged = |claim, typical_is_limit| {
        let (snapshot, assessment) = Simulated::default().record();
        let figure = DatasheetFigure { is_of_unknown_sides: true, ..figure(Sensor::Gyroscope, Term::White, claim) };
        let sheet = Datasheet { typical_is_limit, ..sheet(vec![figure]) };
        let verdicts = sheet.verdicts(&snapshot, &assessment);
        let unmet = not_passed(&"gyro N".parse().unwrap(), &snapshot, Some(&verdicts)).len();
        (verdicts.channels[6][0].clone(), unmet)
    };
    let typical = |value: f64| Claim::Typical { from: value, to: value, rounding: 0.0 };
    let of = |claim, typical_is_limit| {
        let (verdict, unmet) = judged(claim, typical_is_limit);
        (verdict.verdict, [verdict.readings[0].verdict, verdict.readings[1].verdict], unmet)
    };
    use Verdict::{AboveTypical, BelowTypical, Consistent, Fail, Pass, Typical};
    assert_eq!(of(Claim::Limit(1e-4), false), (Consistent, [Pass, Pass], 3));
    assert_eq!(of(Claim::Limit(1e-6), false), (Fail, [Fail, Fail], 3));
    assert_eq!(of(typical(2.12e-5), false), (Consistent, [Typical, AboveTypical], 0));
    assert_eq!(of(typical(2.12e-5), true), (Consistent, [Pass, Fail], 3));
    assert_eq!(of(typical(1e-3), false), (Consistent, [BelowTypical, BelowTypical], 0));
    assert_eq!(of(typical(1e-6), false), (AboveTypical, [AboveTypical, AboveTypical], 0));
    assert_eq!(of(typical(1e-6), true), (Fail, [Fail, Fail], 3));
    let (verdict, _) = judged(Claim::Limit(1e-4), false);
    let [two, one] = [0, 1].map(|reading| verdict.readings[reading].expected.1);
    assert!(two == verdict.expected.1 && (two / one - 2_f64.sqrt()).abs() < 1e-12);
}

#[test]
fn what_is_typical_decides_nothing_unless_it_is_taken_for_a_limit() {
    let typical = Claim::Typical { from: 1e-6, to: 1e-6, rounding: 0.0 };
    let (snapshot, assessment) = Simulated::default().record();
    let failed = |claims: &[Claim], typical_is_limit| {
        let figures = claims.iter().map(|claim| figure(Sensor::Gyroscope, Term::White, *claim)).collect();
        let verdicts = Datasheet { typical_is_limit, ..sheet(figures) }.verdicts(&snapshot, &assessment);
        let found: Vec<_> = verdicts.channels[6].iter().map(|verdict| verdict.verdict).collect();
        (found, not_passed(&"gyro_x N".parse().unwrap(), &snapshot, Some(&verdicts)).len())
    };
    let limit = Claim::Limit(1e-4);
    assert_eq!(failed(&[limit, typical], false), (vec![Verdict::Pass, Verdict::AboveTypical], 0));
    assert_eq!(failed(&[limit, typical], true), (vec![Verdict::Pass, Verdict::Fail], 1));
    assert_eq!(failed(&[typical], false), (vec![Verdict::AboveTypical], 0));
    assert_eq!(failed(&[typical], true), (vec![Verdict::Fail], 1));
    let all = sheet([limit, typical].map(|claim| figure(Sensor::Gyroscope, Term::White, claim)).to_vec());
    assert_eq!(all.typical_noise(Sensor::Gyroscope), [(Term::White, 1e-6)]);
    assert_eq!(all.typical_noise(Sensor::Accelerometer), []);
    assert_eq!(not_passed(&"gyro N".parse().unwrap(), &snapshot, None), [("gyro N".to_owned(), None)]);
}

#[test]
fn nothing_is_judged_in_motion() {
    let all = sheet(vec![figure(Sensor::Gyroscope, Term::White, Claim::Limit(1e-4))]);
    let moving: fn(&Channel) -> (f64, f64) = |_| (0.0, 60_000.0);
    let (snapshot, assessment) = Simulated { level: moving, samples: 2000, ..Simulated::default() }.record();
    assert_eq!(assessment.motion.as_ref().map(|motion| motion.axes.len()), Some(6));
    assert!(all.verdicts(&snapshot, &assessment).channels.iter().all(Vec::is_empty));
}

#[test]
fn a_grade_needs_both_parameters_and_a_rate() {
    let grades = |simulated: Simulated| {
        let (_, assessment) = simulated.record();
        let of = |channel: usize| assessment.channels[channel].noise.as_ref().unwrap().grade();
        (of(3), of(6))
    };
    // N of 2.1e-5 is 0.073 deg/sqrt(h), and of B ten minutes show that it is small
    let industrial = Some(Ok((Grade::Industrial, Grade::Industrial)));
    assert_eq!(grades(Simulated::default()), (None, industrial));
    // without the window it is 0.036 to 0.163
    let unknown = Simulated { registers: Vec::new(), ..Simulated::default() };
    assert_eq!(grades(unknown).1, Some(Ok((Grade::Tactical, Grade::Industrial))));
    let assumed = Simulated { settings: Settings::default(), ..Simulated::default() };
    assert_eq!(grades(assumed).1, Some(Err(NoGrade::RateAssumed)));
    let compensated = Simulated { layout: VNYMR.clone(), ..Simulated::default() };
    let (_, assessment) = compensated.record();
    assert_eq!(assessment.channels[9].noise.as_ref().unwrap().grade(), Some(Err(NoGrade::BiasNotInStream)));
    let short = Simulated { samples: 10, ..Simulated::default() };
    assert!(matches!(grades(short).1, Some(Err(NoGrade::WhiteNotKnown | NoGrade::BiasNotKnown))));
}

#[test]
fn a_sensor_at_rest_reads_gravity_and_the_field_of_the_earth() {
    let warnings = |level| Simulated { level, samples: 2000, ..Simulated::default() }.record().1.warnings;
    let off: fn(&Channel) -> (f64, f64) = |channel| match (channel.quantity, still(channel)) {
        (Quantity::Acceleration | Quantity::MagneticField, (mean, std)) => (0.4 * mean, std),
        (_, level) => level,
    };
    for (level, axes) in [(still as fn(&Channel) -> (f64, f64), 0), (off, 3)] {
        let warnings = warnings(level);
        assert_eq!(named(&warnings, WarningKind::GravityMagnitude).len(), axes);
        assert_eq!(named(&warnings, WarningKind::FieldMagnitude).len(), axes);
        assert_eq!(named(&warnings, WarningKind::NotStationary).len(), 0);
        let folded = named(&warnings, WarningKind::DecimatedStream);
        assert_eq!(folded.len(), 9, "by 2.24, and 2.5 for the field: {folded:?}");
    }
    let coarse: fn(&Channel) -> (f64, f64) = |channel| match channel.quantity {
        Quantity::AngularRate => (0.0, 0.3),
        _ => still(channel),
    };
    assert_eq!(named(&warnings(coarse), WarningKind::QuantisationFloor), ["gyro_x", "gyro_y", "gyro_z"]);
}

#[test]
fn plans_take_the_sensors_own_settings_where_they_fit() {
    let quoted = sheet(vec![figure(Sensor::Gyroscope, Term::White, Claim::Limit(6e-5))]);
    let free = Given { rate: None, baud: None, confidence: 0.95 };
    let wants = |texts: &[&str]| texts.iter().map(|text| text.parse().unwrap()).collect::<Vec<Want>>();
    let plan = |texts: &[&str], given| Plan::new(&wants(texts), given, &quoted);
    let white = plan(&["gyro N ±5%"], free).unwrap();
    assert_eq!((white.message, white.rate.hz(), white.window, white.warm_up_s), (AsyncType::IMU, 40, 20, 600.0));
    assert_eq!((white.baud, white.wants[0].by_rule_s), (BaudRate::DEFAULT, None));
    let record_s = white.record_s.unwrap();
    assert!(record_s % 60.0 == 0.0 && record_s >= white.wants[0].record_s.unwrap() && record_s <= 600.0, "{record_s}");
    let walk = plan(&["gyro K >= 1e-5"], free).unwrap();
    let by_rule_s = walk.wants[0].by_rule_s.unwrap();
    assert!((by_rule_s - 20.0 * 3_f64.sqrt() * 6.0).abs() < 1e-6, "{by_rule_s}");
    assert_eq!((walk.warm_up_s, walk.wants[0].record_s), (1800.0, walk.wants[0].without_bias_instability_s));
    let fast = Given { rate: AsyncRate::new(200), ..free };
    let faster = plan(&["gyro N ±5%"], fast).unwrap();
    assert_eq!((faster.rate.hz(), faster.window), (200, 4));
    let slow = Given { baud: Some(BaudRate::ALL[0]), ..fast };
    let Err(PlanningError::DoesNotFit { rate_hz: 200, baud: 9600, highest_hz: Some(highest), .. }) =
        plan(&["gyro N ±5%"], slow)
    else {
        panic!("it fits");
    };
    let fitting = plan(&["gyro N ±5%"], Given { rate: None, ..slow }).unwrap();
    assert_eq!((fitting.rate.hz(), fitting.baud), (highest, BaudRate::ALL[0]));
    for (text, expected) in [("gyro B", "its own size"), ("accel N ±5%", "the white noise")] {
        let Err(PlanningError::NotQuoted { missing, datasheet, .. }) = plan(&[text], free) else { panic!("{text}") };
        assert_eq!((missing, datasheet.as_str()), (expected, "a sheet"));
    }
}

fn text(warnings: &[vn100_analysis::Warning], kind: WarningKind) -> String {
    let texts: Vec<_> =
        warnings.iter().filter(|warning| warning.kind == kind).map(|warning| warning.text.to_string()).collect();
    texts.join("|")
}

#[test]
fn vibration_steps_and_warm_up_are_named_with_their_place() {
    let added: fn(&Channel, u64) -> f64 = |channel, sample| {
        let at_s = sample as f64 * 0.025;
        match &*channel.name {
            "accel_x" | "accel_y" => 60.0 * (std::f64::consts::TAU * 5.0 * at_s).sin(),
            "gyro_x" => 1500.0 * (-at_s / 60.0).exp(),
            "gyro_z" if at_s >= 300.0 => 3000.0,
            _ => 0.0,
        }
    };
    let warnings = Simulated { added, ..Simulated::default() }.record().1.warnings;
    assert_eq!(named(&warnings, WarningKind::VibrationLine), ["accel_x", "accel_y"]);
    let lines = text(&warnings, WarningKind::VibrationLine);
    assert!(lines.contains("5.00 Hz on accel_") && lines.contains(", also on accel_"), "{lines}");
    assert!(lines.contains("A stream of 40 Hz shows 35.0, 45.0, 75.0 Hz and more"), "{lines}");
    assert_eq!(named(&warnings, WarningKind::WarmUp), ["gyro_x"]);
    let warm_up = text(&warnings, WarningKind::WarmUp);
    assert!(warm_up.contains("gyro_x begins +1.") && warm_up.contains("leaves that out"), "{warm_up}");
    assert_eq!(named(&warnings, WarningKind::NotStationary), ["gyro_z"]);
    let steps = text(&warnings, WarningKind::NotStationary);
    assert!(steps.contains("gyro_z a step of +2.9") && steps.contains("e-3 rad/s at 5:00"), "{steps}");
    let still = Simulated::default().record().1.warnings;
    for kind in [WarningKind::VibrationLine, WarningKind::WarmUp, WarningKind::NotStationary] {
        assert_eq!(named(&still, kind).len(), 0, "{kind:?}");
    }
}

#[test]
fn lines_that_are_no_samples_are_counted_and_named() {
    let mut link = StreamCounts::default();
    link.tally.other = 7;
    link.tally.rejected.checksum = 2;
    link.tally.rejected.unchecked = 3;
    link.tally.unchecked_sentences = 4;
    link.unsolicited_errors.count(DeviceError::OutputBufferOverflow);
    link.unsolicited_errors.count(DeviceError::OutputBufferOverflow);
    link.unsolicited_errors.count(DeviceError::from_code(3));
    let counted = Simulated { samples: 100, link, ..Simulated::default() };
    let warnings = counted.record().0.warnings;
    let damaged = text(&warnings, WarningKind::RejectedLines);
    assert!(damaged.starts_with("2 of 112 lines are damaged and left out; each between good ones counts"), "{damaged}");
    assert!(damaged.contains("baud rate"), "{damaged}");
    let unchecked = text(&warnings, WarningKind::UncheckedLines);
    assert!(unchecked.starts_with("3 of 112 lines are without a checksum and left out"), "{unchecked}");
    assert!(unchecked.contains("|4 of 112 lines are taken without a checksum"), "{unchecked}");
    let overflow = text(&warnings, WarningKind::LinkBudget);
    assert!(overflow.starts_with("the sensor said unasked, 2 times, "), "{overflow}");
    let unasked = text(&warnings, WarningKind::DeviceErrors);
    assert!(
        unasked.starts_with("the sensor said unasked, 1 time, ") && unasked.contains("another program"),
        "{unasked}"
    );
    assert_eq!(text(&warnings, WarningKind::RateAssumed), "");
    let unknown = Simulated { samples: 100, settings: Settings::default(), ..Simulated::default() }.record().0.warnings;
    assert!(text(&unknown, WarningKind::RateAssumed).contains("40 Hz"));
    for kind in [WarningKind::RejectedLines, WarningKind::UncheckedLines, WarningKind::LinkBudget] {
        assert_eq!(text(&unknown, kind), "", "{kind:?}");
    }
}

#[test]
fn a_goal_is_met_by_every_axis_meant_or_says_how_far_each_is() {
    let (snapshot, assessment) = Simulated::default().record();
    let goal = |text: &str| text.parse::<Goal>().unwrap();
    // Ten minutes of white noise: half widths of 0.9 %.
    for (text, is_met) in
        [("gyro N ±1.2%", true), ("accel N ±1.2%", true), ("gyro N ±0.6%", false), ("gyro K ±50%", false)]
    {
        assert_eq!(goal(text).is_met(&snapshot, &assessment), is_met, "{text}");
    }
    let unmet = UnmetGoal::of(&[goal("gyro N ±1.2%"), goal("gyro N ±0.6%")], &snapshot, &assessment);
    let [UnmetGoal { goal: unmet, why: WhyUnmet::EndedBefore(axes) }] = &unmet[..] else { panic!("{unmet:?}") };
    assert_eq!(unmet, &goal("gyro N ±0.6%"));
    assert_eq!(axes.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["gyro_x", "gyro_y", "gyro_z"]);
    assert!(axes.iter().all(|(_, width)| width.is_some_and(|width| (0.007..0.012).contains(&width))), "{axes:?}");
    let empty = Analysis::new(Settings::default()).snapshot();
    assert!(!goal("gyro N ±1.2%").is_met(&empty, &Assessment::new(&empty, 0.95)));
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
