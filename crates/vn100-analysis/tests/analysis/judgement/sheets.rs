//! What a data sheet says of a record: verdicts and grades.

use imu_noise::{Claim, Grade, Parameter, Sensor, Status, Term, Verdict};
use vn100_analysis::{
    Assessment, Datasheet, DatasheetFigure, DecidedBy, Finding, Goal, NoGrade, Parts, Settings, SheetOnboard, Snapshot,
    SourceFacts, SourceResult, WindowFrom,
};
use vn100_protocol::{Channel, Layout, VNIMU, VNYMR};

use super::simulated::{Simulated, WINDOWS_OF_4};

pub(crate) fn figure(sensor: Sensor, term: Term, claim: Claim) -> DatasheetFigure {
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

pub(crate) fn sheet(figures: Vec<DatasheetFigure>) -> Datasheet {
    Datasheet { name: "a sheet".into(), note: None, onboard: None, figures, typical_is_limit: false }
}

/// The number of verdicts on a parameter that are no pass.
fn not_passed(name: &str, sheet: Option<&Datasheet>, (snapshot, assessment): &(Snapshot, Assessment)) -> usize {
    let (snapshot, assessment) = (snapshot.clone().into(), assessment.clone().into());
    let mut result = SourceResult::new(SourceFacts::default(), snapshot, assessment, Parts::WithoutSignals);
    sheet.into_iter().for_each(|sheet| result.judge(sheet));
    result.find_deciding_records();
    result.not_passed(&name.parse().unwrap()).len()
}

#[test]
fn verdicts_count_what_the_stream_makes_of_white_noise() {
    // the stream reads 4.74e-5: 2.236 times the sensor's own, to within 10 %
    let verdicts = |limit, simulated: Simulated| {
        let record = simulated.record();
        let sheet = sheet(vec![figure(Sensor::Gyroscope, Term::White, Claim::Limit(limit))]);
        let verdicts = sheet.verdicts(&record.0, &record.1);
        let failed = |name: &str| not_passed(name, Some(&sheet), &record);
        let counts = (failed("gyro N"), failed("gyro_y N"), failed("accel N"));
        let figures = |channel| usize::from((6..9).contains(&channel));
        assert!(verdicts.iter().enumerate().all(|(channel, all)| all.len() == figures(channel)));
        let verdict = &verdicts[7][0];
        (verdict.verdict.unwrap(), verdict.decided_by, counts)
    };
    let unaliased = Some(DecidedBy::Unaliased);
    for (limit, expected, by, unmet) in
        [(1e-4, Verdict::Pass, None, 0), (2.1e-5, Verdict::Undecided, unaliased, 3), (1e-5, Verdict::Fail, None, 3)]
    {
        let known = verdicts(limit, Simulated::default());
        assert_eq!(known, (expected, by, (unmet, unmet / 3, 3)), "{limit}");
    }
    let unknown = |registers, settings| Simulated { registers, settings, ..Simulated::default() };
    let given = Simulated::default().settings;
    // with any window the stream reads 1 to 4.47 times the sensor's own
    for (limit, expected, by) in [
        (1e-4, Verdict::Pass, None),
        (2.1e-5, Verdict::Undecided, Some(DecidedBy::Window)),
        (9e-6, Verdict::Fail, None),
    ] {
        let window = verdicts(limit, unknown(Vec::new(), given.clone()));
        assert_eq!((window.0, window.1), (expected, by), "{limit}");
    }
    // at the rate of the sensor it makes no difference
    let every_refresh = Settings { rate_hz: Some(800.0), ..given.clone() };
    let no_decimation = verdicts(1e-4, unknown(Vec::new(), every_refresh));
    assert_eq!((no_decimation.0, no_decimation.1), (Verdict::Pass, None));
    let rate = verdicts(1e-4, unknown(vec![WINDOWS_OF_4], Settings::default()));
    assert_eq!((rate.0, rate.1), (Verdict::Undecided, Some(DecidedBy::Rate)));
}

#[test]
fn a_window_that_is_given_counts_as_the_register_where_there_is_none() {
    let limit = |limit| sheet(vec![figure(Sensor::Gyroscope, Term::White, Claim::Limit(limit))]);
    let record = |window, registers| {
        let settings = Settings { window, ..Simulated::default().settings };
        Simulated { registers, settings, ..Simulated::default() }.record()
    };
    let verdict = |sheet: &Datasheet, (snapshot, assessment): &(Snapshot, Assessment)| {
        let verdict = sheet.verdicts(snapshot, assessment)[6][0].clone();
        (verdict.verdict.unwrap(), (verdict.factor.1 * 100.0).round())
    };
    let contradicted = |(_, assessment): &(Snapshot, Assessment)| {
        assessment.warnings.iter().any(|warning| matches!(warning.finding, Finding::WindowIgnored(..)))
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
        let verdicts = sheet(figures).verdicts(&snapshot, &assessment)[7].clone();
        verdicts.iter().map(|verdict| (verdict.verdict.unwrap(), verdict.decided_by)).collect::<Vec<_>>()
    };
    let given = Simulated::default().settings;
    let all = || vec![bias(false, 1.0), bias(true, 1.0), walk.clone()];
    let passed = (Verdict::Pass, None);
    assert_eq!(verdicts(all(), Vec::new(), given.clone()), [passed; 3]);
    let assumed = (Verdict::Undecided, Some(DecidedBy::Rate));
    assert_eq!(verdicts(all(), vec![WINDOWS_OF_4], Settings::default()), [passed, passed, assumed]);
}

#[test]
fn the_minimum_of_the_curve_is_compared_only_where_the_sheet_means_it() {
    let (snapshot, assessment) = Simulated::default().record();
    let measured = |is_minimum, term| {
        let figure = DatasheetFigure { is_minimum, ..figure(Sensor::Gyroscope, term, Claim::Limit(1.0)) };
        let name = figure.is_curve_minimum();
        (sheet(vec![figure]).verdicts(&snapshot, &assessment)[6][0].measured, name)
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
fn a_sheet_of_another_sensor_is_compared_with_the_stream_as_it_is_unless_it_names_its_averaging() {
    let verdict = |onboard: Option<(f64, u32)>, name: &'static str| {
        let layout = Layout { message: name.into(), ..VNIMU.clone() };
        let (snapshot, assessment) = Simulated { layout, registers: Vec::new(), ..Simulated::default() }.record();
        let figures = [Sensor::Gyroscope, Sensor::Magnetometer]
            .map(|sensor| figure(sensor, Term::White, Claim::Limit(1.0)))
            .to_vec();
        let onboard = onboard.map(|(refresh_hz, window)| SheetOnboard { refresh_hz, window: Some(window) });
        let verdicts = Datasheet { onboard, ..sheet(figures) }.verdicts(&snapshot, &assessment);
        let of = |channel: usize| verdicts[channel][0].verdict.unwrap();
        (of(6), of(0), (verdicts[6][0].factor.1 * 100.0).round())
    };
    let (pass, undecided) = (Verdict::Pass, Verdict::Undecided);
    assert_eq!(verdict(None, "a CSV file"), (pass, pass, 100.0));
    // what the sheet says is of gyroscope and accelerometer
    assert_eq!(verdict(Some((40.0, 1)), "a CSV file"), (pass, pass, 100.0));
    assert_eq!(verdict(Some((800.0, 4)), "a CSV file"), (pass, pass, 224.0));
    assert_eq!(verdict(Some((40.0, 8)), "a CSV file"), (undecided, pass, 100.0));
    // of a sensor that this program knows the stream itself would say it
    assert_eq!(verdict(Some((40.0, 1)), "VNIMU").2, 447.0);
}

#[test]
fn a_density_of_unknown_sides_is_decided_only_by_both_readings() {
    // the stream reads 4.74e-5 and the sensor itself 2.12e-5
    let judged = |claim, typical_is_limit| {
        let record = Simulated::default().record();
        let figure = DatasheetFigure { is_of_unknown_sides: true, ..figure(Sensor::Gyroscope, Term::White, claim) };
        let sheet = Datasheet { typical_is_limit, ..sheet(vec![figure]) };
        (sheet.verdicts(&record.0, &record.1)[6][0].clone(), not_passed("gyro N", Some(&sheet), &record))
    };
    let typical = |value: f64| Claim::Typical { from: value, to: value, rounding: 0.0 };
    let of = |claim, typical_is_limit| {
        let (verdict, unmet) = judged(claim, typical_is_limit);
        (verdict.verdict, verdict.decided_by, unmet)
    };
    use Verdict::{Fail, Pass, Undecided};
    let convention = Some(DecidedBy::Convention);
    assert_eq!(of(Claim::Limit(1e-4), false), (Some(Pass), None, 0));
    assert_eq!(of(Claim::Limit(2.5e-5), false), (Some(Undecided), convention, 3));
    assert_eq!(of(Claim::Limit(1e-6), false), (Some(Fail), None, 3));
    assert_eq!(of(typical(2.5e-5), false), (None, None, 3));
    assert_eq!(of(typical(2.5e-5), true), (Some(Undecided), convention, 3));
    assert_eq!(of(typical(1e-6), true), (Some(Fail), None, 3));
    // the ratio has no one value, and holds both
    let (verdict, _) = judged(typical(2.12e-5), false);
    let [lower, upper] = [verdict.ratio.lower.unwrap(), verdict.ratio.upper.unwrap()];
    assert_eq!(verdict.ratio.value, None);
    assert!((0.85..0.95).contains(&lower) && (1.5..1.65).contains(&upper), "{lower} {upper}");
    let (low, high) = verdict.expected;
    assert!((high / low / (2_f64.sqrt() * 1.1 / 0.9) - 1.0).abs() < 1e-12);
}

#[test]
fn what_is_typical_has_a_ratio_and_decides_only_if_it_is_taken_for_a_limit() {
    let typical = Claim::Typical { from: 1e-6, to: 1e-6, rounding: 0.0 };
    let record = Simulated::default().record();
    let (snapshot, assessment) = &record;
    let failed = |claims: &[Claim], typical_is_limit| {
        let figures = claims.iter().map(|claim| figure(Sensor::Gyroscope, Term::White, *claim)).collect();
        let sheet = Datasheet { typical_is_limit, ..sheet(figures) };
        let found: Vec<_> = sheet.verdicts(snapshot, assessment)[6].iter().map(|verdict| verdict.verdict).collect();
        (found, not_passed("gyro_x N", Some(&sheet), &record))
    };
    let limit = Claim::Limit(1e-4);
    assert_eq!(failed(&[limit, typical], false), (vec![Some(Verdict::Pass), None], 0));
    assert_eq!(failed(&[limit, typical], true), (vec![Some(Verdict::Pass), Some(Verdict::Fail)], 1));
    assert_eq!(failed(&[typical], false), (vec![None], 1));
    assert_eq!(failed(&[typical], true), (vec![Some(Verdict::Fail)], 1));
    // as a limit, a sensor at the figure passes although its stream is known to 10 % only
    let own = Claim::Typical { from: 2.12e-5, to: 2.12e-5, rounding: 0.0 };
    assert_eq!(failed(&[own], true), (vec![Some(Verdict::Pass)], 0));
    let judged = sheet(vec![figure(Sensor::Gyroscope, Term::White, own)]).verdicts(snapshot, assessment);
    let ratio = judged[6][0].ratio;
    assert!((ratio.value.unwrap() - 1.0).abs() < 0.05, "{ratio:?}");
    assert!(ratio.lower.unwrap() < 0.92 && ratio.upper.unwrap() > 1.1, "{ratio:?}");
    let all = sheet([limit, typical].map(|claim| figure(Sensor::Gyroscope, Term::White, claim)).to_vec());
    assert_eq!(all.typical_noise(Sensor::Gyroscope), [(Term::White, 1e-6)]);
    assert_eq!(all.typical_noise(Sensor::Accelerometer), []);
    assert_eq!(not_passed("gyro N", None, &record), 1);
}

#[test]
fn nothing_is_judged_in_motion() {
    let all = sheet(vec![figure(Sensor::Gyroscope, Term::White, Claim::Limit(1e-4))]);
    let moving: fn(&Channel) -> (f64, f64) = |_| (0.0, 60_000.0);
    let (snapshot, assessment) = Simulated { level: moving, samples: 2000, ..Simulated::default() }.record();
    assert_eq!(assessment.motion.as_ref().map(|motion| motion.axes.len()), Some(6));
    assert!(all.verdicts(&snapshot, &assessment).iter().all(Vec::is_empty));
    for noise in assessment.channels.iter().filter_map(|channel| channel.noise.as_ref()) {
        let unaliased = noise.unaliased_white();
        let known = Term::ALL.into_iter().filter_map(|term| noise.parameter(term)).chain(unaliased);
        known.chain(noise.curve_minimum()).for_each(|found| assert_eq!(found, Parameter::without_value(Status::Moved)));
        assert!(noise.fit.quality.is_none() && noise.white_budget.sampling.is_none());
    }
    let goals: Vec<Goal> = ["gyro N ±99%", "accel_x N ±99%"].map(|goal| goal.parse().unwrap()).into();
    assert_eq!(Goal::unmet(&goals, &snapshot, &assessment).len(), 2);
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
    let settings = Settings { quantization: true, ..Simulated::default().settings };
    let (_, asked) = Simulated { layout: VNYMR.clone(), settings, samples: 2000, ..Simulated::default() }.record();
    // the filter takes the bias out, and no quantisation noise
    for (channel, terms) in [(3, [true, false]), (9, [true, true])] {
        let noise = asked.channels[channel].noise.as_ref().unwrap();
        let found = [Term::Quantization, Term::BiasInstability].map(|term| noise.parameter(term));
        assert_eq!(found.map(|parameter| parameter.is_some()), terms, "{found:?}");
        assert_ne!(found[0].unwrap().status, Status::NotMeasurable);
        assert!(found[1].is_none_or(|bias| bias.status == Status::NotMeasurable));
    }
    let short = Simulated { samples: 10, ..Simulated::default() };
    assert_eq!(grades(short).1, Some(Err(NoGrade::WhiteNotKnown)));
}
