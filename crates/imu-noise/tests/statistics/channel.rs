//! A channel equals its accumulators, for any division.

use imu_noise::{ChannelAccumulator, Deviation, Estimator, Histogram, Moments, Octaves};
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
}
