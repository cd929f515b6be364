//! White noise and a walk through the recursion of each program, as its own code has it: the variance
//! of the integral must be N² t, that of the bias K² t.

use proptest::prelude::*;
use vn100_analysis::noise::{Sensor, Term};

use super::{super::filter_noise::FilterNoise, *};

/// A sensor at a rate, and how long its samples are integrated.
#[derive(Debug, Clone, Copy)]
struct Case {
    white: f64,
    walk: f64,
    rate_hz: f64,
    steps: u32,
}

impl Case {
    fn step_s(self) -> f64 {
        1.0 / self.rate_hz
    }

    fn time_s(self) -> f64 {
        f64::from(self.steps) / self.rate_hz
    }
}

/// The variance of the integrated white noise and of the bias, of the numbers typed for N and K.
type Recursion = fn(Case, f64, f64) -> (f64, Option<f64>);

/// By program. Of each only the arithmetic of the lines that its row names.
fn recursion(name: &str) -> Recursion {
    match name {
        "kalibr" => |case, n, k| {
            // IccSensors.py:628 noise_density / sqrt(1/update_rate) weighs a sample; the motion term of
            // the bias has the weight 1/random_walk^2 per second: the diffusion is its inverse
            let weight_of_sample = 1.0 / (n / (1.0 / case.rate_hz).sqrt()).powi(2);
            let white = f64::from(case.steps) * case.step_s().powi(2) / weight_of_sample;
            (white, Some(case.time_s() / (1.0 / (k * k))))
        },
        // Propagator.cpp:463 Qc = sigma^2/dt, :820 G = dt
        "openvins" => |case, n, k| {
            let dt = case.step_s();
            repeated(case, |p, b| (p + dt * (n * n / dt) * dt, b + dt * (k * k / dt) * dt))
        },
        // CombinedImuFactor.cpp:164 C (wCov/dt) C', :177 dt biasCov, with biasAccOmegaInt = 0
        "gtsam" => |case, n_covariance, k_covariance| {
            let dt = case.step_s();
            repeated(case, |p, b| (p + dt * (n_covariance / dt) * dt, b + dt * k_covariance))
        },
        // imuPreintegration.cpp:215 pow(imuNoise, 2) for GTSAM, :375 sqrt(deltaTij) imuBiasN
        "lio-sam" => |case, n, k| {
            let dt = case.step_s();
            let (white, _) = repeated(case, |p, b| (p + dt * (n * n / dt) * dt, b));
            (white, Some((case.time_s().sqrt() * k).powi(2)))
        },
        // integration_base.h:31 noise of two samples, :122 V = dt/2 of each, dt of the bias
        "vins" => |case, n, w| {
            let dt = case.step_s();
            repeated(case, |p, b| (p + 2.0 * (0.5 * dt * n).powi(2), b + (dt * w).powi(2)))
        },
        // esekfom.hpp:381 (dt f_w) Q (dt f_w)'
        "fast-lio" => |case, n_covariance, k_covariance| {
            let dt = case.step_s();
            repeated(case, |p, b| (p + dt * n_covariance * dt, b + dt * k_covariance * dt))
        },
        // kf_gins.cpp:342 units, gi_engine.cpp:47 Qc, :275 F = -1/T, :292 Qd = (Phi Qd Phi' + Qd)/2
        "kf-gins" => |case, arw, gbstd| {
            let (dt, tau) = (case.step_s(), 4.0 * 3600.0);
            let (arw, gbstd) = (arw.to_radians() / 60.0, gbstd.to_radians() / 3600.0);
            let phi = 1.0 - dt / tau;
            repeated(case, |p, b| {
                let noise = 2.0 / tau * gbstd * gbstd * dt;
                (p + arw * arw * dt, phi * phi * b + (phi * phi * noise + noise) / 2.0)
            })
        },
        // Imu.msg: a variance of each sample
        "ros" => |case, covariance, _| {
            let (white, _) = repeated(case, |p, b| (p + covariance * case.step_s().powi(2), b));
            (white, None)
        },
        // GaussianNoiseModel.cc:114 Normal(stddev), :126 phi = exp(-dt/tau), variance s² tau/2 (1 - phi²)
        "gazebo" => |case, stddev, walk| {
            let (dt, tau) = (case.step_s(), 36_000.0);
            let noise = -walk * walk * tau / 2.0 * (-2.0 * dt / tau).exp_m1();
            let phi = (-dt / tau).exp();
            repeated(case, |p, b| (p + (stddev * dt).powi(2), phi * phi * b + noise))
        },
        // "single-sided": bandwidth = rate; density sqrt(bandwidth), walk / sqrt(bandwidth)
        "matlab" => |case, n, k| {
            let bandwidth = case.rate_hz;
            repeated(case, |p, b| (p + n * n * bandwidth * case.step_s().powi(2), b + k * k / bandwidth))
        },
        _ => panic!("{name} has no recursion here"),
    }
}

fn repeated(case: Case, step: impl Fn(f64, f64) -> (f64, f64)) -> (f64, Option<f64>) {
    let (white, bias) = (0..case.steps).fold((0.0, 0.0), |(white, bias), _| step(white, bias));
    (white, Some(bias))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn every_program_propagates_what_was_measured(
        white in 1e-6_f64..1e-1,
        walk in 1e-8_f64..1e-2,
        rate_hz in 20.0_f64..1000.0,
        steps in 50_u32..3000,
    ) {
        let case = Case { white, walk, rate_hz, steps };
        for consumer in &Consumer::ALL {
            let typed = |formula: Formula, value| (formula.typed)(Sensor::Gyroscope, value, rate_hz);
            let typed_walk = consumer.walk.map_or(0.0, |formula| typed(formula, walk));
            let (angle, bias) = recursion(consumer.name)(case, typed(consumer.white, case.white), typed_walk);
            let of = |found: f64, density: f64| found / (density * density * case.time_s());
            prop_assert!((of(angle, white) - 1.0).abs() < 1e-6, "{} N: {}", consumer.name, of(angle, white));
            prop_assert_eq!(bias.is_some(), consumer.walk.is_some());
            if let Some(bias) = bias {
                // a Gauss-Markov process forgets: t/tau at most
                let forgotten = if ["kf-gins", "gazebo"].contains(&consumer.name) { case.time_s() / 14_400.0 } else { 0.0 };
                let ratio = of(bias, walk);
                prop_assert!(ratio < 1.0 + 1e-6 && ratio > 1.0 - 1e-6 - forgotten, "{} K: {ratio}", consumer.name);
            }
        }
    }
}

/// Seeded normal deviates (SplitMix64, then Box and Muller).
struct Normal(u64);

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// Samples of white noise and a walk, summed as a filter does, scatter as the recursions say.
#[test]
fn simulated_samples_scatter_as_the_recursions_foretell() {
    let case = Case { white: 1e-3, walk: 2e-3, rate_hz: 100.0, steps: 400 };
    let mut normal = Normal(11);
    let (mut angles, mut biases) = (0.0, 0.0);
    let runs = 2000;
    for _ in 0..runs {
        let (mut angle, mut bias) = (0.0, 0.0);
        for _ in 0..case.steps {
            angle += case.step_s() * case.white * case.rate_hz.sqrt() * normal.next();
            bias += case.walk / case.rate_hz.sqrt() * normal.next();
        }
        angles += angle * angle / f64::from(runs);
        biases += bias * bias / f64::from(runs);
    }
    for consumer in &Consumer::ALL {
        let typed = |formula: Formula, value| (formula.typed)(Sensor::Gyroscope, value, case.rate_hz);
        let walk = consumer.walk.map_or(0.0, |formula| typed(formula, case.walk));
        let (angle, bias) = recursion(consumer.name)(case, typed(consumer.white, case.white), walk);
        // 2000 runs: a variance to 3 %
        let close = |found: f64, foretold: f64| (found / foretold - 1.0).abs() < 0.12;
        assert!(close(angles, angle) && bias.is_none_or(|bias| close(biases, bias)), "{}", consumer.name);
    }
}

/// The accelerometer is typed as the gyroscope is, but in its own units.
#[test]
fn the_accelerometer_has_its_own_units() {
    for consumer in &Consumer::ALL {
        let typed = |formula: Formula, sensor| (formula.typed)(sensor, 1e-3, 200.0);
        let ratio = |formula| typed(formula, Sensor::Accelerometer) / typed(formula, Sensor::Gyroscope);
        let formulas = [Some(consumer.white), consumer.walk];
        let expected = match consumer.name {
            // m/s/√h beside deg/√h, mGal beside deg/h
            "kf-gins" => [1.0_f64.to_radians(), 1e5 * 1.0_f64.to_radians() / 3600.0],
            _ => [1.0, 1.0],
        };
        for (formula, expected) in formulas.into_iter().zip(expected) {
            assert!(formula.is_none_or(|formula| (ratio(formula) / expected - 1.0).abs() < 1e-12), "{}", consumer.name);
        }
    }
}

/// A sheet that has everything, at 200 Hz.
fn of_sheet() -> FilterNoise {
    let sheet = crate::built_in_datasheet("adis16470").unwrap().unwrap();
    let mut noise = FilterNoise::of_datasheet(&sheet, crate::SheetStream { rate_hz: 200.0, aliasing: 1.0 });
    noise.scale_factor_ppm = Some(300.0);
    noise
}

#[test]
fn a_file_without_a_required_value_is_not_written() {
    let mut noise = of_sheet();
    assert!(Consumer::ALL.iter().all(|consumer| consumer.file(&noise).is_ok()));
    noise.rate_hz = None;
    noise.scale_factor_ppm = None;
    for consumer in &Consumer::ALL {
        let needs = consumer.needs_rate || consumer.name == "kf-gins";
        assert_eq!(consumer.file(&noise).is_err(), needs, "{}", consumer.name);
    }
    // no bias instability, and no walk of it
    let bmi088 = crate::built_in_datasheet("bmi088").unwrap().unwrap();
    let noise = FilterNoise::of_datasheet(&bmi088, crate::SheetStream { rate_hz: 200.0, aliasing: 1.0 });
    for consumer in &Consumer::ALL {
        assert_eq!(consumer.file(&noise).is_err(), consumer.walk.is_some(), "{}", consumer.name);
    }
}

#[test]
fn a_walk_of_a_data_sheet_is_the_upper_end_of_its_range() {
    let noise = of_sheet();
    let expected = 8.0_f64.to_radians() / 3600.0 / 60.0_f64.sqrt();
    let found = noise.value(Sensor::Gyroscope, Term::RateRandomWalk).unwrap();
    assert!((found / expected - 1.0).abs() < 1e-9, "{found}, expected {expected}");
    let white = noise.value(Sensor::Gyroscope, Term::White).unwrap();
    assert!((white / (0.34_f64.to_radians() / 60.0) - 1.0).abs() < 1e-9, "the random walk, which has one meaning");
    let text = Consumer::named("kalibr").unwrap().file(&noise).unwrap();
    assert!(text.contains("from a data sheet: Analog Devices ADIS16470") && text.contains("upper end of"), "{text}");
}
