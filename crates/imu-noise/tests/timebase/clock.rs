//! Stamps out of order, and clocks that are set back.

use crate::link::{Link, gap, place};

#[test]
fn a_stamp_out_of_order_is_no_time() {
    let stamps_s: Vec<f64> = Link::steady(40.0).stamps(2000).collect();
    let mut swapped = stamps_s.clone();
    swapped.swap(700, 701);
    swapped.swap(1500, 1501);
    let mut wrong = stamps_s.clone();
    wrong[5] = 0.0;
    wrong[1000] = 3.0;
    let mut with_loss = wrong.clone();
    with_loss.drain(1400..1402);
    for (stamps_s, expected) in [(swapped, vec![]), (wrong, vec![]), (with_loss, vec![(1400, gap(2))])] {
        let (events, summary) = place(stamps_s);
        assert_eq!((events, summary.backwards, summary.refusal), (expected, 2, None));
        assert!(summary.offset_ppm.unwrap().abs() < 5.0, "{summary:?}");
    }
}

#[test]
fn a_clock_set_back_is_followed() {
    for set_at in [1, 5, 20, 40, 700, 1990, 1999] {
        for by_s in [0.02, 0.04, 0.06, 0.09, 0.2, 0.9, 3600.0] {
            let start_s = 4000.0;
            let stamps = Link { start_s, ..Link::steady(40.0) }.stamps(2000).enumerate();
            let kept = stamps.filter(|(line, _)| *line != 1200);
            let set = kept.map(|(line, stamp_s)| if line < set_at { stamp_s } else { stamp_s - by_s });
            let (events, summary) = place(set);
            let case = format!("{by_s} s at line {set_at}: {summary:?}");
            assert_eq!((events, summary.refusal), (vec![(1200, gap(1))], None), "{case}");
            assert!(summary.offset_ppm.is_some_and(|ppm| ppm.abs() < 5.0), "{case}");
        }
    }
}

#[test]
fn lines_in_doubt_when_the_clock_is_set_back_are_no_loss() {
    // Every 1000 lines, after 8 late ones.
    let stamps = Link { start_s: 100.0, ..Link::steady(40.0) }.stamps(4000).enumerate();
    let stamps = stamps.map(|(line, stamp_s)| {
        let late_s = if line < 3000 && line % 1000 >= 992 { 0.03 } else { 0.0 };
        stamp_s + late_s - 30.0 * (line / 1000) as f64
    });
    let (events, summary) = place(stamps);
    assert_eq!((events, summary.backwards), (vec![], 3));
    assert!(summary.offset_ppm.unwrap().abs() < 5.0, "{summary:?}");
}
