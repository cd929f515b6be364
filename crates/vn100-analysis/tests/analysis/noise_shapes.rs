//! White noise with something beside it on one axis: what is said of N there, and of what lies beside.

use std::{f64::consts::TAU, sync::Arc};

use imu_noise::{Parameter, Status, Term};
use vn100_analysis::{Analysis, Assessment, Finding, Settings, Warning, WarningKind};
use vn100_protocol::{Layout, Quantity, Register, RegisterContents, RegisterFields, VNIMU, stream::Batch};

const RATE_HZ: f64 = 40.0;

/// Of the white noise of every axis, in counts.
const WHITE: f64 = 100.0;

const SHAPED: &str = "gyro_y";

pub(crate) struct Lcg(pub(crate) u64);

impl Lcg {
    /// Nearly normal, of variance 1.
    pub(crate) fn normal(&mut self) -> f64 {
        let uniform = (0..12).map(|_| {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / 2_f64.powi(53)
        });
        uniform.sum::<f64>() - 6.0
    }
}

/// Twenty minutes of white noise on every axis; that of [`SHAPED`] as `shape` leaves it.
fn assessed(shape: impl Fn(&mut Vec<f64>, &mut Lcg)) -> Assessment {
    let window = RegisterContents {
        register: Register::IMU_FILTER,
        fields: RegisterFields::new("0,4,4,4,0,0,3,3,3,0").unwrap(),
    };
    assessed_with(vec![window], shape)
}

fn assessed_with(registers: Vec<RegisterContents>, shape: impl Fn(&mut Vec<f64>, &mut Lcg)) -> Assessment {
    const SAMPLES: usize = 48_000;
    let layout: Layout = VNIMU.clone();
    let mut random = Lcg(20_261_122);
    let columns: Vec<Vec<f64>> = (layout.channels.iter())
        .map(|channel| {
            let mut column: Vec<f64> = (0..SAMPLES).map(|_| WHITE * random.normal()).collect();
            if channel.name == SHAPED {
                shape(&mut column, &mut random);
            }
            let level = match channel.quantity {
                Quantity::Acceleration if channel.name.ends_with('z') => -9807.0,
                Quantity::MagneticField if channel.name.ends_with('x') => 5000.0,
                Quantity::Temperature | Quantity::Pressure => 25_000.0,
                _ => 0.0,
            };
            column.iter().map(|value| value + level).collect()
        })
        .collect();
    let counts = (0..SAMPLES).flat_map(|row| columns.iter().map(move |column| column[row].round() as i32));
    let counts = counts.collect();
    let mut batch = Batch { layout: Some(Arc::new(layout)), counts, registers, ..Batch::default() };
    batch.link.tally.samples = SAMPLES as u64;
    let mut analysis = Analysis::new(Settings { rate_hz: Some(RATE_HZ), ..Settings::default() });
    analysis.absorb(&batch);
    Assessment::new(&analysis.snapshot(), 0.95)
}

fn only(assessment: &Assessment, kind: WarningKind) -> &Warning {
    let found: Vec<&Warning> = assessment.warnings.iter().filter(|warning| warning.kind == kind).collect();
    assert_eq!(found.len(), 1, "{kind:?}: {:?}", assessment.warnings);
    assert_eq!(found[0].channels, [SHAPED], "{kind:?}");
    found[0]
}

/// The axis that was shaped, and its N.
fn white(assessment: &Assessment) -> (&imu_noise::NoiseFit, Parameter) {
    let place = VNIMU.channels.iter().position(|channel| channel.name == SHAPED).unwrap();
    let fit = &assessment.channels[place].noise.as_ref().unwrap().fit;
    (fit, fit.parameter(Term::White).unwrap())
}

/// N of the white noise, in the unit of the axis.
fn truth() -> f64 {
    let channel = VNIMU.channels.iter().find(|channel| channel.name == SHAPED).unwrap();
    channel.in_unit(WHITE) / RATE_HZ.sqrt()
}

#[test]
fn white_noise_alone_has_no_such_warning() {
    let assessment = assessed(|_, _| {});
    for kind in [WarningKind::CorrelatedNoise, WarningKind::LowPass, WarningKind::VibrationLine] {
        assert!(assessment.warnings.iter().all(|warning| warning.kind != kind), "{:?}", assessment.warnings);
    }
    let (fit, n) = white(&assessment);
    assert!(n.lower.unwrap() < truth() && truth() < n.upper.unwrap(), "{n:?}");
    assert_eq!((fit.apparent_white(), fit.lacks_free_band, fit.correlation_samples), (None, false, None));
}

#[test]
fn correlated_noise_has_an_apparent_random_walk_beside_n() {
    let (time_s, sigma) = (5.0, 0.3 * WHITE);
    let assessment = assessed(|column, random| {
        let memory = f64::exp(-1.0 / (time_s * RATE_HZ));
        let mut level = sigma * random.normal();
        for value in column {
            *value += level;
            level = memory * level + sigma * (1.0 - memory * memory).sqrt() * random.normal();
        }
    });
    let (fit, n) = white(&assessment);
    assert!(n.lower.unwrap() < truth() && truth() < n.upper.unwrap(), "{n:?}, not {}", truth());
    let apparent = truth() * (1.0 + 2.0 * (sigma / WHITE).powi(2) * time_s * RATE_HZ).sqrt();
    let found = fit.apparent_white().unwrap();
    assert!((found / apparent - 1.0).abs() < 0.25, "{found}, not {apparent}");
    let Finding::Correlated(said) = &only(&assessment, WarningKind::CorrelatedNoise).finding else { panic!() };
    assert!(said.iter().any(|(.., apparent)| *apparent == found), "{said:?}");
}

#[test]
fn behind_a_low_pass_n_is_that_of_low_frequencies() {
    let assessment = assessed(|column, _| {
        let mut last = 0.0;
        for value in column {
            last = 0.6 * last + 0.4 * *value;
            *value = last;
        }
    });
    let (fit, n) = white(&assessment);
    assert!(n.lower.unwrap() < truth() && truth() < n.upper.unwrap(), "{n:?}, not {}", truth());
    // (1 + 0.6)/(1 - 0.6) samples
    let remembered = fit.correlation_samples.unwrap();
    assert!((remembered / 4.0 - 1.0).abs() < 0.15, "{remembered}");
    assert_eq!(only(&assessment, WarningKind::LowPass).finding, Finding::LowPass(remembered));
}

#[test]
fn n_behind_a_weak_filter_is_that_of_low_frequencies() {
    for part in [0.010, 0.025, 0.1] {
        let assessment = assessed_with(Vec::new(), |column: &mut Vec<f64>, _: &mut Lcg| {
            let mut last = 0.0;
            for value in column {
                (last, *value) = (*value, *value - part * last);
            }
        });
        let (_, n) = white(&assessment);
        let filtered = (1.0 - part) * truth();
        assert!(n.lower.unwrap() < filtered && filtered < n.upper.unwrap(), "{n:?}, not {filtered}");
    }
}

#[test]
fn a_low_pass_removes_no_bias() {
    for draws in 0..12 {
        let assessment = assessed(|column, random| {
            (0..draws).for_each(|_| _ = random.normal());
            let fresh: Vec<f64> = (0..column.len() + 3).map(|_| WHITE * random.normal()).collect();
            // the average of four, as sensors are delivered with
            *column = fresh.windows(4).map(|four| four.iter().sum::<f64>() / 4.0).collect();
        });
        let is_of_filter = |warning: &Warning| warning.kind == WarningKind::CompensatedStream;
        assert!(!assessment.warnings.iter().any(is_of_filter), "{draws}: {:?}", assessment.warnings);
        assert!(white(&assessment).0.correlation_samples.is_some());
    }
}

#[test]
fn where_lines_leave_no_free_band_n_is_bounded() {
    let assessment = assessed(|column, _| {
        for line in 1..40 {
            // half a hertz apart
            let (frequency_hz, phase) = (0.5 * f64::from(line), f64::from(line * line));
            for (sample, value) in (0..).zip(column.iter_mut()) {
                *value += WHITE * (TAU * frequency_hz * f64::from(sample) / RATE_HZ + phase).sin();
            }
        }
    });
    let (fit, n) = white(&assessment);
    assert!(fit.lacks_free_band, "{n:?} {:?}", fit.quality);
    assert_eq!((n.status, n.value), (Status::Bounded, None));
    assert!(n.upper.unwrap() > truth(), "{n:?}, not {}", truth());
    assert!(assessment.warnings.iter().any(|warning| warning.finding == Finding::NoFreeBand));
}

#[test]
fn what_rounding_hides_is_not_measurable_wherever_the_level_lies() {
    const STEP: f64 = 400.0;
    let rounded = |level: f64, walk: f64, deviation: f64| {
        assessed(move |column, random| {
            let mut at = level * STEP;
            for value in column {
                at += walk * STEP * random.normal();
                *value = ((deviation * STEP / WHITE * *value + at) / STEP).round() * STEP;
            }
        })
    };
    let place = VNIMU.channels.iter().position(|channel| channel.name == SHAPED).unwrap();
    let status = |assessment: &Assessment, term| {
        assessment.channels[place].noise.as_ref().and_then(|noise| noise.parameter(term)).unwrap().status
    };
    // in the middle of a step and at its edge, where half of the values are the next
    for level in [0.0, 0.3, 0.5] {
        let hidden = rounded(level, 0.0, 0.25);
        for term in [Term::White, Term::BiasInstability, Term::RateRandomWalk] {
            assert_eq!(status(&hidden, term), Status::NotMeasurable, "{term:?} at {level}");
        }
        only(&hidden, WarningKind::QuantisationFloor);
        assert_eq!(status(&rounded(level, 0.0, 1.0), Term::White), Status::Estimated, "at {level}");
    }
    let walking = rounded(0.0, 0.05, 0.1);
    assert_eq!(status(&walking, Term::White), Status::NotMeasurable);
    assert_ne!(status(&walking, Term::RateRandomWalk), Status::NotMeasurable, "a walk over many steps");
}
