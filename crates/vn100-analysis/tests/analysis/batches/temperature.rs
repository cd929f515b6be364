//! The temperature of the sensor, in the stream or asked for between the rows.

use vn100_analysis::{AxisTemperature, noise::NoCoefficient};

use super::*;

/// Half an hour at 40 Hz, all axes following two degrees up and down every 400 s; `channels` of a
/// row by their names.
fn batch(layout: &Layout, polled: bool) -> Batch {
    let mut batch = Batch { layout: Some(Arc::new(layout.clone())), ..Batch::default() };
    let mut state = 1_u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1 << 24) as f64 - 0.5
    };
    for row in 0..72_000 {
        let degrees = 2.0 * (std::f64::consts::TAU * f64::from(row) / 16_000.0).sin();
        let gravity = |name: &str| if name == "accel_z" { -9810.0 } else { 0.0 };
        for channel in &*layout.channels {
            let value = match &*channel.name {
                "temperature" => 250.0 + 10.0 * degrees + noise(),
                "pressure" => 101_325.0 + 10.0 * noise(),
                name if name.starts_with("accel") => gravity(name) + 3.0 * degrees + 20.0 * noise(),
                name if name.starts_with("gyro") => 100.0 * degrees + 2000.0 * noise(),
                name if name.starts_with("mag") => 4000.0 + 50.0 * noise(),
                _ => 20.0 * noise(),
            };
            batch.counts.push(value.round() as i32);
        }
        if polled && row % 200 == 0 {
            let kind = MarkKind::Temperature((250.0 + 10.0 * degrees).round() as i32);
            batch.marks.push(Mark { before_row: row as usize + 1, kind });
        }
    }
    batch
}

fn settings() -> Settings {
    Settings { rate_hz: Some(40.0), ..Settings::default() }
}

fn assessed(batch: &Batch) -> (Snapshot, Assessment) {
    let mut analysis = Analysis::new(settings());
    analysis.absorb(batch);
    let snapshot = analysis.snapshot();
    let assessment = Assessment::new(&snapshot, 0.95);
    (snapshot, assessment)
}

fn of<'a>((snapshot, assessment): &'a (Snapshot, Assessment), name: &str) -> &'a AxisTemperature {
    let place = snapshot.layout_channels().iter().position(|channel| channel.name == name).unwrap();
    assessment.channels[place].noise.as_ref().unwrap().temperature.as_ref().unwrap()
}

#[test]
fn axes_follow_the_temperature_of_the_stream() {
    let batch = batch(&VNIMU, false);
    let measured = assessed(&batch);
    for (name, truth) in [("accel_x", 3e-3), ("accel_z", 3e-3), ("gyro_y", 1e-4)] {
        let found = of(&measured, name);
        let coefficient = found.coefficient.unwrap();
        assert!((coefficient.value / truth - 1.0).abs() < 0.1, "{name} {coefficient:?}");
        assert!(coefficient.lower < truth && truth < coefficient.upper, "{name} {coefficient:?}");
        assert!(found.is_proved && !found.is_polled);
        assert!(
            found.share_as_noise().is_some_and(|share| share > 0.9)
                && found.excursion_c.is_some_and(|range| (3.9..4.2).contains(&range))
        );
    }
    let status = |(snapshot, assessment): &(Snapshot, Assessment), term| {
        let place = snapshot.layout_channels().iter().position(|channel| channel.name == "gyro_y").unwrap();
        assessment.channels[place].noise.as_ref().unwrap().parameter(term).unwrap().status
    };
    for term in [Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp] {
        assert_ne!(status(&measured, term), imu_noise::Status::Estimated, "{term:?}");
    }
    let (_, assessment) = &measured;
    let warning = assessment.warnings.iter().find(|warning| warning.kind == WarningKind::FollowsTemperature).unwrap();
    assert_eq!(warning.channels.len(), 6);
    assert!(measured.1.channels[8].stationarity.level_change.is_some(), "a cycle of the level");
}

#[test]
fn readings_between_the_rows_are_as_good_however_the_stream_is_cut() {
    let batch = batch(&VNYMR, true);
    let measured = assessed(&batch);
    let found = of(&measured, "accel_y");
    let coefficient = found.coefficient.unwrap();
    assert!(found.is_polled && found.is_proved);
    assert!(coefficient.lower < 3e-3 && 3e-3 < coefficient.upper, "{coefficient:?}");
    // the attitude filter of this message takes the bias out
    assert_eq!(of(&measured, "gyro_x").coefficient, Err(NoCoefficient::BiasNotInStream));

    let mut analysis = Analysis::new(settings());
    let width = VNYMR.channels.len();
    let mut marks = batch.marks.iter().peekable();
    for (place, rows) in batch.counts.chunks(37 * width).enumerate() {
        let (from, to) = (37 * place, 37 * place + rows.len() / width);
        let mut part = Batch { counts: rows.to_vec(), layout: batch.layout.clone(), ..Batch::default() };
        while let Some(mark) = marks.next_if(|mark| mark.before_row <= to) {
            part.marks.push(Mark { before_row: mark.before_row - from, ..*mark });
        }
        analysis.absorb(&part);
    }
    let snapshot = analysis.snapshot();
    let cut = (snapshot.clone(), Assessment::new(&snapshot, 0.95));
    assert_eq!(of(&cut, "accel_y"), found);
}

#[test]
fn without_a_temperature_there_is_nothing_to_say() {
    let (snapshot, assessment) = assessed(&batch(&VNYMR, false));
    assert!(snapshot.temperature.is_none());
    assert!(assessment.channels.iter().flat_map(|channel| &channel.noise).all(|noise| noise.temperature.is_none()));
}
