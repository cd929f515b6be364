//! How well a record shows the parameters of its noise.

use std::sync::Arc;

use imu_noise::{Status, Term};
use vn100_analysis::{Drifting, Parts, SourceFacts, SourceResult};
use vn100_protocol::Channel;

use super::simulated::{Simulated, still};

fn result(seed: u64, level: fn(&Channel) -> (f64, f64)) -> SourceResult {
    let (snapshot, assessment) = Simulated { seed, level, ..Simulated::default() }.record();
    SourceResult::new(SourceFacts::default(), Arc::new(snapshot), Arc::new(assessment), Parts::All)
}

/// The status of the drifts of this kind, by axis.
fn drifts(result: &SourceResult, of: Drifting) -> Vec<(&str, Status)> {
    let mut drifts: Vec<_> = result.drift.iter().filter(|drift| drift.of == of).collect();
    drifts.retain(|drift| drift.coast_s == 10.0);
    drifts.into_iter().map(|drift| (drift.axis.as_str(), drift.status)).collect()
}

#[test]
fn what_rounding_hides_neither_drifts_nor_inflates() {
    use Status::{Estimated, NotMeasurable};
    let rounded = result(3, |channel| match &*channel.name {
        "gyro_z" | "accel_x" => (0.4, 0.25),
        _ => still(channel),
    });
    let angles = [("gyro_x", Estimated), ("gyro_y", Estimated), ("gyro_z", NotMeasurable)];
    assert_eq!(drifts(&rounded, Drifting::Angle), angles);
    // the tilt of x and y takes gyro_z
    let along = [("accel_x", NotMeasurable), ("accel_y", NotMeasurable), ("accel_z", Estimated)];
    assert_eq!(drifts(&rounded, Drifting::Velocity), along);
    let inflated = rounded.channels.iter().filter(|axis| axis.inflation.is_some()).map(|axis| axis.name.as_str());
    assert_eq!(inflated.collect::<Vec<_>>(), ["accel_y", "accel_z", "gyro_x", "gyro_y"]);
}

#[test]
fn without_gravity_there_is_no_tilt_and_no_drift_along_an_axis() {
    let dead = result(4, |channel| if channel.name == "accel_z" { (0.0, 0.0) } else { still(channel) });
    for of in [Drifting::Velocity, Drifting::Position] {
        assert!(drifts(&dead, of).iter().all(|(_, status)| *status == Status::NotMeasurable), "{of:?}");
    }
    assert!(drifts(&dead, Drifting::Angle).iter().all(|(_, status)| *status == Status::Estimated));
}

#[test]
fn a_filter_takes_white_noise_as_it_is() {
    let factors = |seed| result(seed, still).channels.into_iter().filter_map(|axis| axis.inflation?.white_factor);
    let mut factors: Vec<f64> = (10..14).flat_map(factors).collect();
    factors.sort_by(f64::total_cmp);
    assert_eq!(factors.len(), 24);
    assert!(factors[0] > 0.999 && factors[12] < 1.02 && factors[23] < 1.2, "{factors:?}");
}

#[test]
fn rare_large_values_widen_the_interval_of_white_noise() {
    let width = |added| {
        let assessment = Simulated { added, ..Simulated::default() }.record().1;
        let white = assessment.channels[6].noise.as_ref().unwrap().parameter(Term::White).unwrap();
        (white.upper.unwrap() - white.lower.unwrap()) / white.value.unwrap()
    };
    // six deviations to either side, one sample in 64
    let rare: fn(&Channel, u64) -> f64 = |_, sample| {
        let mixed = (sample + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mixed = (mixed ^ mixed >> 32).wrapping_mul(0xd6e8_feb8_6659_fd93) >> 32;
        match mixed % 128 {
            0 => 1800.0,
            1 => -1800.0,
            _ => 0.0,
        }
    };
    let (normal, heavy) = (width(|_, _| 0.0), width(rare));
    // by the root of 1 + half the excess kurtosis of 7.7
    assert!((heavy / normal / 2.2 - 1.0).abs() < 0.25, "{heavy}, {normal} of normal noise");
}
