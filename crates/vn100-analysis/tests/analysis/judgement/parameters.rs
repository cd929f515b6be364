//! How well a record shows the parameters of its noise.

use imu_noise::Term;
use vn100_protocol::Channel;

use super::simulated::Simulated;

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
