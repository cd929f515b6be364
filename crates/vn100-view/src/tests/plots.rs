//! What the panel of curves shows beside the deviation, and the reference in it.

use std::sync::Arc;

use super::{PLAIN, SIZES, check, damaged, drawn, measured, nothing, one, text};
use crate::{
    reference::Reference,
    source::SourceView,
    state::{ShownAxes, ShownPlot, ViewState},
};

#[test]
fn the_spectrum_in_place_of_the_deviation() {
    let state = ViewState { plot: ShownPlot::Spectrum, ..one() };
    check("plot-spectrum", &state, &[measured()]);
    for source in [nothing(), damaged()] {
        for size in SIZES {
            let state = ViewState { axes: ShownAxes::One(2), ..state.clone() };
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
    let reference = Reference::of("bench-monday.mcap".into(), &earlier.result);
    SourceView { reference: Some(Arc::new(reference)), ..measured() }
}

#[test]
fn the_curve_of_an_earlier_record_lies_in_the_plot() {
    let source = with_reference();
    let screen = |state: &ViewState| text(&drawn(state, std::slice::from_ref(&source), PLAIN, (120, 40)));
    assert!(screen(&one()).contains("R bench-"), "{}", screen(&one()));
    let group = one().group(&source).unwrap();
    let plot = crate::panels::curve::AllanPlot::new(&one(), &source, &group);
    for curve in &plot.curves {
        let (own, earlier) = (curve.points[0].deviation.unwrap(), curve.reference.as_ref().unwrap().points[0].1);
        assert!((earlier / own - 1.5).abs() < 1e-9, "{own} {earlier}");
    }
}

#[test]
fn no_reference_where_another_deviation_was_measured() {
    let source = with_reference();
    let mut reference = (**source.reference.as_ref().unwrap()).clone();
    reference.deviation = imu_noise::Deviation::Hadamard;
    let source = SourceView { reference: Some(Arc::new(reference)), ..source };
    let group = one().group(&source).unwrap();
    let plot = crate::panels::curve::AllanPlot::new(&one(), &source, &group);
    assert!(plot.curves.iter().all(|curve| curve.reference.is_none()));
}

#[tokio::test]
async fn a_reference_is_measured_from_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("still.vnymr");
    let mut generator = vn100_sim::Generator::new(&vn100_sim::Profile::named("lab3").unwrap(), 40, 1).unwrap();
    let mut capture = Vec::new();
    vn100_sim::write_capture(&mut capture, &mut generator, vn100_sim::Message::named("VNIMU").unwrap(), 4000).unwrap();
    std::fs::write(&file, capture).unwrap();
    let stop = tokio_util::sync::CancellationToken::new();
    let settings = vn100_analysis::Settings { rate_hz: Some(40.0), ..Default::default() };
    let reference = Reference::measure(file, settings.clone(), &stop).await.unwrap().unwrap();
    assert_eq!(reference.name, "still.vnymr");
    let gyro = measured().result.channels.into_iter().find(|channel| channel.name == "gyro_y").unwrap();
    assert!(reference.curve(&gyro).unwrap().len() > 8);
    std::fs::write(folder.path().join("empty"), "nothing\n").unwrap();
    let refused = Reference::measure(folder.path().join("empty"), settings, &stop).await.unwrap();
    assert!(refused.unwrap_err().starts_with("no reference: "));
}
