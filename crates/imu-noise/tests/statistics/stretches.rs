//! Stretches with places shared by several channels, against individual runs and gaps.

use imu_noise::{ChannelSignal, Deviation, Estimator, Octaves, Sides, SpectrumPlan, Stretch, WindowPlans};
use proptest::{collection::vec, prelude::*};

const CHANNELS: usize = 3;

/// One part of a record.
#[derive(Clone, Debug)]
enum Step {
    /// For each place whether all channels have a sample, and whether each of them does.
    Places(Vec<(bool, [bool; CHANNELS])>),
    /// A gap of all channels, or of one.
    Gap(Option<u64>, Option<usize>),
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let places = |present: f64, own: f64| {
        let channels = [(); CHANNELS].map(|()| prop::bool::weighted(own));
        vec((prop::bool::weighted(present), channels), 1..=Stretch::MOST).prop_map(Step::Places)
    };
    let missing = || prop_oneof![Just(None), Just(Some(0)), (1_u64..3000).prop_map(Some)];
    let step = prop_oneof![
        3 => places(0.95, 1.0),
        2 => places(0.6, 1.0),
        2 => places(1.0, 1.0),
        1 => places(0.95, 0.98),
        1 => missing().prop_map(|missing| Step::Gap(missing, None)),
        1 => (missing(), 0..CHANNELS).prop_map(|(missing, channel)| Step::Gap(missing, Some(channel))),
    ];
    vec(step, 0..14)
}

/// Pseudo-random counts; a `shift` of 0 leaves all 32 bits.
fn counts(shift: u32) -> impl FnMut() -> i32 {
    let mut state = 1_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 32) as i32 >> shift
    }
}

/// A channel that takes stretches, and one that takes individual runs and gaps.
struct Pair {
    octaves: [Octaves; 2],
    signals: [ChannelSignal; 2],
}

impl Pair {
    fn push(&mut self, places: &[Option<i32>], plans: &mut WindowPlans) {
        let mut stretch = Stretch::EMPTY;
        places.iter().for_each(|place| assert_eq!(stretch.push(1, place.is_some()), 1));
        let samples: Vec<i32> = places.iter().copied().flatten().collect();
        self.octaves[0].push_stretch(&samples, &stretch, plans);
        self.signals[0].push_stretch(&samples, &stretch);
        for run in places.chunk_by(|a, b| a.is_some() == b.is_some()) {
            let samples: Vec<i32> = run.iter().copied().flatten().collect();
            if samples.is_empty() {
                self.octaves[1].gap(Some(run.len() as u64));
                self.signals[1].gap(Some(run.len() as u64));
            } else {
                self.octaves[1].push(&samples);
                self.signals[1].push(&samples);
            }
        }
    }

    fn gap(&mut self, missing: Option<u64>) {
        self.octaves.iter_mut().for_each(|octaves| octaves.gap(missing));
        self.signals.iter_mut().for_each(|signal| signal.gap(missing));
    }
}

proptest! {
    #[test]
    fn a_stretch_is_its_runs_and_gaps(
        steps in steps(),
        estimator in prop_oneof![3 => Just(Estimator::Strided), 1 => Just(Estimator::Plain), 1 => Just(Estimator::Full)],
        deviation in prop_oneof![Just(Deviation::Allan), Just(Deviation::Hadamard)],
        shift in prop_oneof![Just(24_u32), Just(12), Just(0)],
    ) {
        let plan = SpectrumPlan::new();
        let mut next = counts(shift);
        let mut channels = [(); CHANNELS].map(|()| Pair {
            octaves: [Octaves::new(estimator, deviation), Octaves::new(estimator, deviation)],
            signals: [ChannelSignal::new(&plan), ChannelSignal::new(&plan)],
        });
        for step in &steps {
            match step {
                Step::Places(places) => {
                    let mut plans = WindowPlans::new();
                    for (channel, pair) in channels.iter_mut().enumerate() {
                        let places = places.iter().map(|(all, own)| (*all && own[channel]).then(&mut next));
                        pair.push(&places.collect::<Vec<_>>(), &mut plans);
                    }
                }
                Step::Gap(missing, None) => channels.iter_mut().for_each(|pair| pair.gap(*missing)),
                Step::Gap(missing, Some(channel)) => channels[*channel].gap(*missing),
            }
        }
        for Pair { octaves: [a, b], signals: [c, d] } in &channels {
            prop_assert_eq!(a.sums().collect::<Vec<_>>(), b.sums().collect::<Vec<_>>());
            prop_assert_eq!(c.blocks(), d.blocks());
            let powers = |signal: &ChannelSignal| signal.spectrum().density(Sides::Two, 1.0, 0);
            prop_assert_eq!(powers(c), powers(d));
        }
    }
}
