//! Block sums against exact tables, for any division and with gaps.

use proptest::{collection::vec, prelude::*};

use super::*;
use crate::accumulate::aligned_sums::{AlignedBlock, AlignedSums};
use crate::accumulate::record::{Deviation, Estimator};
use crate::oracle;

fn identified(block: u64, runs: &[(Option<u64>, &[i32])]) -> LagOneSums {
    let mut aligned = AlignedSums::new(block);
    let mut identification = LagOneSums::new(block);
    let complete = |block: AlignedBlock, of: u64, identification: &mut LagOneSums| {
        if block.present == of {
            identification.push(block.number, block.sum);
        }
    };
    for (missing, counts) in runs {
        if *missing != Some(0) {
            aligned.gap(*missing, |found| complete(found, block, &mut identification));
            if missing.is_none() {
                identification.part();
            }
        }
        aligned.push(counts, |found| complete(found, block, &mut identification));
    }
    identification
}

#[test]
fn lag_one_is_that_of_the_exact_table() {
    let mut used = 0;
    for row in oracle::table("noise_id_lag1.csv") {
        let field = |name| oracle::field(&row, name).unwrap();
        let number = |name| field(name).parse::<f64>().unwrap();
        if number("detrend") == 1.0 {
            continue;
        }
        let counts = match field("series") {
            "nist1000" => oracle::nist1000(),
            series => oracle::series(&format!("{series}.txt")),
        };
        let m = number("m") as u64;
        for block in [1, m] {
            let sums = identified(block, &[(Some(0), &counts)]);
            assert_eq!(sums.series(m).unwrap()[0].count, number("blocks") as u64);
            let alpha = sums.alpha(m).unwrap();
            assert!((alpha - number("alpha")).abs() < 1e-9, "{row:?}: {alpha}");
            assert_eq!(alpha.round(), number("alpha_int"), "{row:?}: {alpha}");
        }
        used += 1;
    }
    assert_eq!(used, 33);
}

#[test]
fn neighbours_across_a_gap_are_none() {
    let counts = oracle::series("imu_b_gyro_white_flicker_rrw.txt");
    // Two runs whose block sums are known one by one.
    let (first, second) = (&counts[..1000], &counts[1008..3000]);
    let blocks = |run: &[i32]| run.chunks_exact(8).map(|block| block.iter().map(|&c| f64::from(c)).sum()).collect();
    let runs: [Vec<f64>; 2] = [blocks(first), blocks(second)];
    let n = (runs[0].len() + runs[1].len()) as f64;
    let mean = runs.iter().flatten().sum::<f64>() / n;
    let squares: f64 = runs.iter().flatten().map(|b| (b - mean).powi(2)).sum();
    let products: f64 =
        runs.iter().flat_map(|run| run.windows(2)).map(|pair| (pair[0] - mean) * (pair[1] - mean)).sum();
    let alpha = identified(8, &[(Some(0), first), (Some(8), second)]).alpha(8).unwrap();
    let autocorrelation = products / squares;
    assert!((alpha + 2.0 * autocorrelation / (1.0 + autocorrelation)).abs() < 1e-9, "{alpha}");
}

#[test]
fn constant_and_short_data_have_no_kind() {
    assert_eq!(identified(64, &[(Some(0), &[5; 64 * 40])]).alpha(64), None);
    assert_eq!(identified(64, &[(Some(0), &oracle::nist1000())]).alpha(64), None);
    let identification = identified(64, &[(Some(0), &oracle::series("imu_a_acc_white.txt"))]);
    assert!(identification.alpha(64).is_some());
    for m in [0, 1, 32, 65, 96, 1 << 40] {
        assert_eq!(identification.alpha(m), None, "{m}");
    }
}

#[test]
fn slopes_identify_the_noise_of_pure_curves() {
    let shape =
        RecordShape { samples: 1 << 20, interval_s: 1.0, estimator: Estimator::Strided, deviation: Deviation::Allan };
    let octaves: Vec<_> = (6..20).map(|k| Octave::whole(1 << k, shape.windows(1 << k))).collect();
    for law in [PowerLaw::FlickerPhase, PowerLaw::White, PowerLaw::Flicker, PowerLaw::RandomWalk] {
        let variances: Vec<_> = octaves.iter().map(|octave| law.variance(shape.deviation, octave.m)).collect();
        let types = noise_types(&octaves, &variances, &shape, |_| None);
        assert!(types[..8].iter().all(|noise| *noise == Some(law)), "{law:?}: {types:?}");
        assert_eq!(types[13], None);
    }
}

proptest! {
    #[test]
    fn any_division_gives_the_same(parts in vec(vec(-4000..4000, 0..700), 0..8)) {
        let whole = identified(4, &[(Some(0), &parts.concat())]);
        let divided: Vec<_> = parts.iter().map(|part| (Some(0), part.as_slice())).collect();
        let divided = identified(4, &divided);
        for m in [4, 8, 16, 32] {
            prop_assert_eq!(whole.alpha(m), divided.alpha(m));
        }
    }
}
