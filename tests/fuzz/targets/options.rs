//! The values of options as a user may type them: read or refused, unchanged after printing and
//! reading again, and used in a measurement.

use std::{fmt, str::FromStr, sync::Arc, time::Duration};

use vn100_analysis::{Analysis, Assessment, Goal, NoiseFigure, Settings, Want};
use vn100_capture::ColumnMap;
use vn100_protocol::VNYMR;
use vn100_protocol::stream::Batch;
use vn100_sim::fault::FaultPlan;

/// Each line is tried as every kind of value.
pub(crate) fn check(input: &[u8]) {
    let text = String::from_utf8_lossy(input);
    for value in text.lines() {
        comes_back::<ColumnMap>(value);
        _ = value.parse::<FaultPlan>().map_err(|error| error.to_string());
        comes_back::<NoiseFigure>(value);
        comes_back::<Want>(value);
        comes_back::<Goal>(value);
    }
    let durations: Vec<Duration> = text.lines().filter_map(|value| humantime::parse_duration(value).ok()).collect();
    let rate_hz = text.lines().find_map(|value| value.parse().ok().filter(|hz| (1e-3..=1e5).contains(hz)));
    let until = text.lines().filter_map(|value| value.parse().ok()).collect();
    measure(Settings {
        rate_hz,
        skip: durations.first().copied().unwrap_or_default(),
        duration: durations.get(1).copied(),
        until,
        ..Settings::default()
    });
}

fn comes_back<T: FromStr<Err: fmt::Display> + fmt::Display + fmt::Debug>(text: &str) {
    match text.parse::<T>() {
        Ok(value) => {
            let printed = value.to_string();
            match printed.parse::<T>() {
                Ok(again) => assert_eq!(again.to_string(), printed),
                Err(error) => panic!("{text:?} reads as {value:?}, prints as {printed:?}, and then: {error}"),
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Every sample is measured or left out, for any requested times.
fn measure(settings: Settings) {
    let rows = 200;
    let counts = (0..rows * VNYMR.channels.len()).map(|index| (index * 7919 % 101) as i32).collect();
    let mut batch = Batch { layout: Some(Arc::new(VNYMR.clone())), counts, ..Batch::default() };
    batch.link.tally.samples = rows as u64;
    let mut analysis = Analysis::new(settings);
    analysis.absorb(&batch);
    analysis.finish();
    let snapshot = analysis.snapshot();
    assert_eq!(snapshot.timing.samples + snapshot.timing.excluded, rows as u64);
    assert!(analysis.seconds() <= 1_000 * rows as u64);
    let goals = &analysis.settings().until;
    if !goals.is_empty() {
        let assessment = Assessment::new(&snapshot, 0.95);
        for goal in goals {
            _ = goal.is_met(&snapshot, &assessment);
        }
    }
}
