//! What the panel of curves shows beside the deviation, and the reference in it.

use std::sync::Arc;

use vn100_report::goals::Goals;
use vn100_session::{Playback, Speed};

use super::{PLAIN, SIZES, check, damaged, drawn, measured, nothing, one, text};
use crate::{reference::Reference, source::SourceView, state::ViewState};

#[test]
fn the_spectrum_in_place_of_the_deviation() {
    let state = ViewState { shows_spectrum: true, ..one() };
    check("plot-spectrum", &state, &[measured()]);
    for source in [nothing(), damaged()] {
        for size in SIZES {
            let state = ViewState { axis: Some(2), ..state.clone() };
            drawn(&state, std::slice::from_ref(&source), PLAIN, size);
        }
    }
}

/// An earlier record with one and a half of the noise.
fn with_reference() -> SourceView {
    let mut earlier = measured();
    for channel in &mut earlier.result.channels {
        channel.allan.points.iter_mut().for_each(|point| *point = point.times(1.5));
    }
    let reference = Reference { name: "bench-monday.mcap".into(), result: earlier.result };
    SourceView { reference: Some(Arc::new(reference)), ..measured() }
}

#[test]
fn the_curve_of_an_earlier_record_lies_in_the_plot() {
    let source = with_reference();
    let screen = |source: &SourceView| text(&drawn(&one(), std::slice::from_ref(source), PLAIN, (120, 40)));
    let with = screen(&source);
    assert!(with.contains("┈ bench-"), "{with}");
    let dots = |screen: &str| screen.chars().filter(|sign| ('\u{2801}'..='\u{28ff}').contains(sign)).count();
    assert!(dots(&with) > dots(&screen(&measured())), "{with}");
    let gyro = source.result.channels.iter().find(|channel| channel.name == "gyro_x").unwrap();
    let earlier = source.reference.as_ref().unwrap();
    assert!(earlier.curve(gyro, imu_noise::Deviation::Allan).is_some());
    assert_eq!(earlier.curve(gyro, imu_noise::Deviation::Hadamard), None, "another deviation was measured");
}

/// At the least documented size too, with all that may stand above the panel of curves.
#[test]
fn curves_are_drawn_at_every_size_and_texts_give_way() {
    let playback = Playback { at_end: false, paused: false, samples: 9, total: Some(10), speed: Speed::Max };
    let until = vec!["gyro N ±0.5%".parse().unwrap()];
    let goals = Arc::new(Goals { until, ..Goals::default() });
    for (height, cursor, shows_spectrum) in
        (16..30).flat_map(|height| [(height, None, false), (height, Some(3), false), (height, None, true)])
    {
        let source = SourceView { playback: Some(playback), goals: Arc::clone(&goals), ..measured() };
        let state = ViewState { cursor, shows_spectrum, ..one() };
        let screen = text(&drawn(&state, &[source], PLAIN, (60, height)));
        let dots =
            screen.lines().skip(5).filter(|line| line.contains(|sign| ('\u{2801}'..='\u{28ff}').contains(&sign)));
        assert!(dots.count() >= 2, "{height} {cursor:?} {shows_spectrum}\n{screen}");
    }
}

#[tokio::test]
async fn a_reference_is_measured_from_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("still.vnymr");
    let mut generator = vn100_sim::Generator::new(&vn100_sim::Profile::lab3(), 40, 1).unwrap();
    let mut capture = Vec::new();
    let message = vn100_sim::Message::named("VNIMU").unwrap();
    (0..4000).for_each(|_| vn100_sim::capture::write_next(&mut capture, message, &mut generator));
    std::fs::write(&file, capture).unwrap();
    let stop = tokio_util::sync::CancellationToken::new();
    let settings = vn100_analysis::Settings { rate_hz: Some(40.0), ..Default::default() };
    let reference = Reference::measure(file, settings.clone(), &stop).await.unwrap().unwrap();
    assert_eq!(reference.name, "still.vnymr");
    let gyro = measured().result.channels.into_iter().find(|channel| channel.name == "gyro_y").unwrap();
    assert!(reference.curve(&gyro, imu_noise::Deviation::Allan).unwrap().len() > 8);
    std::fs::write(folder.path().join("empty"), "nothing\n").unwrap();
    let refused = Reference::measure(folder.path().join("empty"), settings, &stop).await.unwrap();
    assert!(refused.unwrap_err().starts_with("no reference: "));
}
