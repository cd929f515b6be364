//! A channel equals its accumulators, for any division.

use imu_noise::{ChannelAccumulator, Deviation, Estimator, Histogram, Moments, Octaves, RecordShape};
use proptest::{collection::vec, prelude::*};

proptest! {
    #[test]
    fn a_channel_equals_its_parts(parts in vec(vec(-9000..9000, 0..600), 0..5), missing in 0_u64..20) {
        let mut channel = ChannelAccumulator::new(Estimator::Strided, Deviation::Hadamard);
        let mut moments = Moments::new();
        let mut histogram = Histogram::new();
        let mut octaves = Octaves::new(Estimator::Strided, Deviation::Hadamard);
        for part in &parts {
            channel.push(part);
            channel.gap(Some(missing));
            octaves.push(part);
            octaves.gap(Some(missing));
        }
        moments.push(&parts.concat());
        histogram.push(&parts.concat());
        prop_assert_eq!(channel.moments(), &moments);
        prop_assert_eq!(channel.histogram(), &histogram);
        prop_assert!(channel.octaves().sums().eq(octaves.sums()));
    }

    #[test]
    fn slope_and_kinds_of_noise_do_not_depend_on_the_division(parts in vec(vec(-9000..9000, 0..900), 1..8)) {
        let read_out = |parts: &[Vec<i32>]| {
            let mut channel = ChannelAccumulator::new(Estimator::Strided, Deviation::Allan);
            parts.iter().for_each(|part| channel.push(part));
            let octaves: Vec<_> = channel.octaves().sums().map(|sum| sum.octave()).collect();
            let variances: Vec<_> = channel.octaves().sums().filter_map(|sum| sum.variance_counts2()).collect();
            let shape = RecordShape {
                samples: channel.moments().count(),
                interval_s: 1.0,
                estimator: Estimator::Strided,
                deviation: Deviation::Allan,
            };
            (channel.slope_counts(), channel.noise_types(&octaves, &variances, &shape))
        };
        prop_assert_eq!(read_out(&parts), read_out(&[parts.concat()]));
    }
}
