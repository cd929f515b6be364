//! Clean records of twelve channels give no warning; disturbed ones give the kind and place of the
//! disturbance. The benchmark of the same name does the same with more and longer records.

use imu_noise::SpectrumPlan;

use crate::disturbed::{Channel, Disturbance, Findings, NOISES, RATE_HZ};
use crate::synthetic::{Random, Synthesis};

const SAMPLES: usize = (600.0 * RATE_HZ) as usize;

#[test]
fn clean_records_give_no_warning() {
    let plan = SpectrumPlan::new();
    let mut random = Random(3);
    let mut synthesis = Synthesis::new(SAMPLES, 4);
    for _ in 0..10 {
        for number in 0..12 {
            let record = synthesis.next_record();
            for noise in &NOISES {
                let found = Findings::of(&Channel::new(noise, number, &record, &mut random).clean(), &plan);
                assert!(found.is_clean(), "{}: {found:?}", noise.name);
            }
        }
    }
}

#[test]
fn disturbances_are_found_at_their_places() {
    let warm_up = Disturbance::WarmUp { sigmas: 24.0, time_constant_s: 60.0 };
    let plan = SpectrumPlan::new();
    let mut random = Random(5);
    let mut synthesis = Synthesis::new(SAMPLES, 6);
    let records: Vec<_> = (0..20).map(|_| synthesis.next_record()).collect();
    for disturbance in [Disturbance::Slam, Disturbance::Push, Disturbance::Line, Disturbance::LateLine, warm_up] {
        let mut found = 0;
        for (record, number) in records.iter().zip(0..) {
            for noise in &NOISES {
                let channel = Channel::new(noise, number, record, &mut random);
                found += usize::from(channel.shows(disturbance, &plan, &mut random));
            }
        }
        assert!(found >= 57, "{disturbance:?} found in {found} of 60");
    }
}
