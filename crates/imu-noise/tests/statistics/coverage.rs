//! Intervals and bounds hold at their level, on seeded records of known noise. The benchmark of the
//! same name does the same with more records.

use imu_noise::{Deviation, Estimator};

use crate::score::{CONFIDENCE, Cell, NOISES, RATE_HZ, ReadOut, TERMS, counts, tracked};
use crate::synthetic::Synthesis;

#[test]
fn intervals_hold_the_truth_and_absent_terms_are_not_estimated() {
    check(Estimator::Strided, Deviation::Allan, CONFIDENCE, 80);
}

#[test]
fn so_do_those_of_the_full_estimator() {
    check(Estimator::Full, Deviation::Allan, CONFIDENCE, 30);
}

#[test]
fn so_do_those_of_the_plain_estimator() {
    check(Estimator::Plain, Deviation::Allan, CONFIDENCE, 60);
}

#[test]
fn so_do_those_of_the_hadamard_deviation() {
    check(Estimator::Strided, Deviation::Hadamard, CONFIDENCE, 40);
}

#[test]
fn so_do_those_at_other_levels() {
    check(Estimator::Strided, Deviation::Allan, 0.68, 30);
    check(Estimator::Strided, Deviation::Allan, 0.99, 30);
}

fn check(estimator: Estimator, deviation: Deviation, confidence: f64, records: usize) {
    let mut synthesis = Synthesis::new((600.0 * RATE_HZ) as usize, 7);
    let mut cells = vec![Cell::default(); NOISES.len()];
    for _ in 0..records {
        let record = synthesis.next_record();
        for (cell, noise) in cells.iter_mut().zip(&NOISES) {
            let counts = counts(noise, &record);
            let read_out = ReadOut::new(&counts, estimator, deviation).at(confidence);
            let fit = read_out.fit(&read_out.model());
            cell.score(noise, &read_out, &fit);
            cell.score_tracked(&ReadOut::new(&tracked(&counts), estimator, deviation).at(confidence));
        }
    }
    // Three and a half standard deviations above the expected share, because a dozen shares are tested.
    let at_most = |share: f64| 100.0 * share + 350.0 * (share * (1.0 - share) / records as f64).sqrt();
    let (wrong_percent, invented_percent) = (at_most(1.0 - confidence), at_most(0.05));
    for (cell, noise) in cells.iter().zip(&NOISES) {
        let absent = [false, noise.flicker == 0.0, noise.step == 0.0, noise.ramp == 0.0];
        for ((term, score), absent) in TERMS.iter().zip(&cell.terms).zip(absent) {
            let held_percent = score.held_percent();
            assert!(held_percent > 100.0 - wrong_percent, "{}: {term:?} held in {held_percent} %", noise.name);
            assert!(!absent || score.estimated_percent() < invented_percent, "{}: {term:?} is not there", noise.name);
        }
        let minimum_percent = cell.minimum.held_percent();
        assert!(minimum_percent > 100.0 - wrong_percent, "{}: minimum held in {minimum_percent} %", noise.name);
        // without flicker the white noise and the walk determine its lower end, if the walk is visible
        let known_percent = cell.minimum.estimated_percent();
        let is_lifted = noise.step > 0.0 && noise.flicker == 0.0 && deviation == Deviation::Allan;
        assert!(!is_lifted || known_percent > 10.0, "{}: minimum known in {known_percent} %", noise.name);
        assert!(cell.below_white <= 1, "{}: {} below their white noise", noise.name, cell.below_white);
        let tracked_percent = cell.tracked_white.held_percent();
        assert!(tracked_percent > 100.0 - wrong_percent, "{}: N, tracked, held in {tracked_percent} %", noise.name);
        assert!(cell.tracked_white.estimated_percent() > 90.0, "{}: N, tracked", noise.name);
        // a ramp has no randomness of its own, so octaves that show it hold more often
        let most_off = if noise.ramp > 0.0 { 12.0 } else { 4.0 };
        let octaves_off = cell.octaves.held_percent() - 100.0 * confidence;
        assert!((-4.0..most_off).contains(&octaves_off), "{}: octaves held {octaves_off} % more often", noise.name);
        // With few windows and a ramp, the plain estimator needlessly rejects 4 in 100.
        let needless = if estimator == Estimator::Plain { records / 8 } else { records / 20 };
        assert!(cell.rejected <= needless, "{}: {} rejected", noise.name, cell.rejected);
    }
}
