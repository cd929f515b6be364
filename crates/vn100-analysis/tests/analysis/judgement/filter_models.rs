//! The noise models that filters are given.

use vn100_analysis::FilterModels;

use super::simulated::Simulated;

#[test]
fn white_noise_and_walk_lie_above_the_upper_bounds_of_all_octaves_and_touch_one() {
    let (snapshot, assessment) = Simulated { samples: 4000, ..Simulated::default() }.record();
    let models = FilterModels::of(&snapshot, &assessment.channels, 0.95);
    let channels = snapshot.layout_channels().iter().zip(&snapshot.channels).zip(&assessment.channels);
    for (((channel, results), assessed), models) in channels.zip(&models) {
        let Some(models) = models else {
            assert!(assessed.noise.is_none(), "{} is an axis", channel.name);
            continue;
        };
        let bound = models.over_bound.unwrap();
        let above = results.octaves.iter().zip(&assessed.octaves).filter_map(|(sum, octave)| {
            let tau_s = sum.m as f64 / 40.0;
            let upper = channel.in_unit(sum.deviation_counts()?) * octave.relative?.upper;
            Some((bound.white.powi(2) / tau_s + bound.rate_random_walk.powi(2) * tau_s / 3.0) / upper.powi(2))
        });
        let least = above.fold(f64::INFINITY, f64::min);
        assert!((least - 1.0).abs() < 1e-6, "{}: {least} times the nearest bound", channel.name);
        // what long averages show of a field is none of the sensor
        assert!(models.gauss_markov.is_none() || !channel.name.starts_with("mag"), "{}", channel.name);
    }
    assert_eq!(models.iter().flatten().count(), 9);
}
