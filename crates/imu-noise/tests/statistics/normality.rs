//! Normality is confirmed for normal records, including correlated and rounded ones, rejected for
//! others, and left open if it cannot be decided.

use imu_noise::{ChannelSignal, Moments, Normality, NotJudged, SpectrumPlan};

use crate::synthetic::{Random, Synthesis};

const SAMPLES: usize = 6000;

#[test]
fn normal_records_are_consistent_as_often_as_stated() {
    // correlation from sample to sample, standard deviation in counts
    for (correlation, std_counts) in [(0.0, 0.7), (0.0, 1000.0), (0.6, 1.5), (0.8, 100.0)] {
        let mut synthesis = Synthesis::new(SAMPLES, 8);
        let (mut skewness2, mut kurtosis2, mut inconsistent) = (0.0, 0.0, 0);
        let records = 300;
        for _ in 0..records {
            let white = synthesis.next_record().0;
            let judged = judge(&rounded(&correlated(&white, correlation), std_counts)).unwrap();
            skewness2 += (judged.skewness / judged.skewness_error).powi(2) / f64::from(records);
            kurtosis2 += (judged.excess_kurtosis / judged.excess_kurtosis_error).powi(2) / f64::from(records);
            assert_eq!(judged.is_consistent(), judged.p() > 0.01, "{judged:?} {}", judged.p());
            inconsistent += usize::from(!judged.is_consistent());
        }
        // four standard deviations of a mean of 300 squares; 3 are expected
        let right = 0.67..1.33;
        assert!(right.contains(&skewness2) && right.contains(&kurtosis2), "{correlation}: {skewness2} {kurtosis2}");
        assert!(inconsistent <= 10, "{correlation}: {inconsistent} of {records}");
    }
}

#[test]
fn other_distributions_are_not_consistent() {
    let mut random = Random(9);
    let uniform: Vec<f64> = (0..SAMPLES).map(|_| random.uniform() - 0.5).collect();
    let exponential: Vec<f64> = (0..SAMPLES).map(|_| -(1.0 - random.uniform()).ln()).collect();
    let flat = judge(&rounded(&uniform, 1000.0)).unwrap();
    assert!(!flat.is_consistent() && (flat.excess_kurtosis + 1.2).abs() < 0.05, "{flat:?}");
    let skewed = judge(&rounded(&exponential, 1000.0)).unwrap();
    assert!(!skewed.is_consistent() && (skewed.skewness - 2.0).abs() < 0.3, "{skewed:?}");
}

#[test]
fn it_is_undecided_without_evidence() {
    let (white, _, walk) = Synthesis::new(SAMPLES, 10).next_record();
    let short = judge(&rounded(&white[..900], 100.0)).unwrap_err();
    assert!(matches!(short, NotJudged::TooShort { effective_samples, .. } if effective_samples <= 900.0), "{short}");
    let few = judge(&rounded(&white[..120], 100.0)).unwrap_err();
    assert_eq!(few.to_string(), "at most 120 independent samples, 1000 needed");
    let slow = judge(&rounded(&correlated(&white, 0.97), 1000.0)).unwrap_err();
    assert!(matches!(slow, NotJudged::TooShort { .. } | NotJudged::Wandering { .. }), "{slow}");
    let coarse = judge(&rounded(&white, 0.4)).unwrap_err();
    assert!(matches!(coarse, NotJudged::Quantised { std_counts, .. } if std_counts < 0.6), "{coarse}");
    let constant = judge(&[5; SAMPLES]).unwrap_err();
    assert!(matches!(constant, NotJudged::Quantised { std_counts: 0.0, .. }), "{constant}");
    let wandering = judge(&rounded(&walk, 10.0)).unwrap_err();
    assert!(matches!(wandering, NotJudged::Wandering { slow_share, .. } if slow_share > 0.5), "{wandering}");
}

fn judge(counts: &[i32]) -> Result<Normality, NotJudged> {
    let mut signal = ChannelSignal::new(&SpectrumPlan::new());
    let mut moments = Moments::new();
    signal.push(counts);
    moments.push(counts);
    signal.normality(&moments)
}

/// A first-order autoregressive process with the variance of the white noise that drives it.
fn correlated(white: &[f64], correlation: f64) -> Vec<f64> {
    let drive = (1.0 - correlation * correlation).sqrt();
    let values = white.iter().scan(white[0], |value, white| {
        *value = correlation * *value + drive * white;
        Some(*value)
    });
    values.collect()
}

fn rounded(values: &[f64], counts: f64) -> Vec<i32> {
    values.iter().map(|value| (counts * value).round() as i32).collect()
}
