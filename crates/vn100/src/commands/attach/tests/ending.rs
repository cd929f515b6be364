//! Why a measurement ends, and what is said of it.

use proptest::prelude::*;
use tokio::time::{Duration, advance, timeout};
use vn100_session::Command;

use super::{Bench, rate, replayed};
use crate::commands::attach::Completion;

#[tokio::test(start_paused = true)]
async fn a_sensor_that_returns_at_another_rate_ends_the_measurement() {
    let bench = Bench::new("--faults reboot@15s");
    bench.configure(rate(20)).await;
    let told = bench.run("attach --duration 60s --json --record {}/rate.mcap").await;
    assert_eq!((told.completion, &told.document["timing"]["rate_hz"]), (Completion::Failed, &20.0.into()));
    assert!(told.number("/timing/samples") > 0 && told.warned("stream-changed"));
    assert_eq!(told.said("the rate changed from 20 to 40 Hz"), 1, "{:?}", told.messages);
    let error = told.error();
    assert!(error.contains("configure imu --set-rate 20 --save`"), "{error}");
    let replayed = replayed(&bench.file("rate.mcap"), "").await;
    assert_eq!(
        (replayed.completion, &replayed.document["channels"]),
        (Completion::Complete, &told.document["channels"])
    );
    assert_eq!(replayed.document["source"]["recorded"]["end_reason"], "the sensor sends at another rate");
}

#[tokio::test(start_paused = true)]
async fn what_is_excluded_by_hand_is_excluded_by_the_same_option_of_a_replay() {
    let bench = Bench::new("");
    let mut running = bench.start("attach --json --record {}/left-out.mcap");
    for (samples, command) in [(100, Command::EndWarmUp), (60, Command::StartOver), (80, Command::EndWarmUp)] {
        running.until(|state| state.snapshot.timing.samples >= samples).await;
        running.commands.send(command).await.unwrap();
        running.until(|state| state.snapshot.timing.samples < 40).await;
    }
    running.until(|state| state.snapshot.timing.samples >= 100).await;
    running.commands.send(Command::Stop).await.unwrap();
    let told = running.end().await;
    assert_eq!(
        (told.said("are excluded, as by --skip"), told.said("started over after")),
        (2, 1),
        "{:?}",
        told.messages
    );
    let whole = replayed(&bench.file("left-out.mcap"), "").await;
    let reason = whole.document["source"]["recorded"]["end_reason"].as_str().unwrap().to_owned();
    let skip = reason.strip_prefix("stopped; the first ").and_then(|rest| rest.strip_suffix(" s excluded by command"));
    let skip = skip.unwrap_or_else(|| panic!("{reason}"));
    let document = replayed(&bench.file("left-out.mcap"), &format!("--skip {skip}")).await;
    assert!(document.number("/timing/samples") < whole.number("/timing/samples"));
    assert_eq!(document.number("/timing/samples"), told.number("/timing/samples"));
    let channels = document.document["channels"].as_array().unwrap();
    for (live, replayed) in told.document["channels"].as_array().unwrap().iter().zip(channels) {
        for part in ["name", "statistics", "allan", "noise"] {
            assert_eq!(live[part], replayed[part], "{}", live["name"]);
        }
    }
}

/// A session whose host stands still now and then: all its timers and bytes are late at once.
async fn with_stalls(options: String, reboot_at_s: u64, stalls: Vec<(u64, u64)>) -> Result<(), TestCaseError> {
    let bench = Bench::new(&format!("--faults reboot@{reboot_at_s}s"));
    bench.configure(rate(20)).await;
    let running = bench.start(&format!("attach --duration 60s --json {options}"));
    let stalling = tokio::spawn(async move {
        for (after_ms, for_ms) in stalls {
            tokio::time::sleep(Duration::from_millis(after_ms)).await;
            advance(Duration::from_millis(for_ms)).await;
        }
    });
    let told = timeout(Duration::from_secs(300), running.end()).await;
    prop_assert!(told.is_ok(), "it does not end");
    let told = told.unwrap();
    stalling.abort();
    let timing = told.document["timing"].clone();
    // the rate of the sensor is 20 Hz before the reboot and 40 Hz after it
    if timing["rate_hz"] == 20.0 {
        prop_assert_eq!(&told.document["end_reason"], "other-rate", "{}", timing);
    } else {
        prop_assert_eq!(&timing["rate_hz"], 40.0, "{}", &timing);
        prop_assert_eq!(told.expected_samples(), 2400, "{}", timing);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_restart_at_any_moment_ends_the_measurement_or_comes_before_it(
        reboot_at_s in 6_u64..40,
        stalls in prop::collection::vec((100_u64..6000, 50_u64..3000), 0..6),
    ) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().start_paused(true).build().unwrap();
        runtime.block_on(with_stalls(String::new(), reboot_at_s, stalls))?;
    }
}

/// All samples of a sensor that loses none, however its host stands still.
async fn nothing_is_lost(rate_hz: u32, message: &str, stalls: Vec<(u64, u64)>) -> Result<(), TestCaseError> {
    let bench = Bench::new("");
    let running = bench.start(&format!("attach --set-rate {rate_hz} --set-message {message} --duration 20s --json"));
    let stalling = tokio::spawn(async move {
        for (after_ms, for_ms) in stalls {
            tokio::time::sleep(Duration::from_millis(after_ms)).await;
            advance(Duration::from_millis(for_ms)).await;
        }
    });
    let told = timeout(Duration::from_secs(300), running.end()).await;
    stalling.abort();
    prop_assert!(told.is_ok(), "it does not end");
    let told = told.unwrap();
    let timing = &told.document["timing"];
    prop_assert_eq!(
        (told.completion, timing["missing"].as_u64()),
        (Completion::Complete, Some(0)),
        "{} {:?}",
        timing,
        told.messages
    );
    prop_assert_eq!(
        (told.number("/timing/samples"), told.number("/timing/segments")),
        (20 * u64::from(rate_hz), 1),
        "{}",
        timing
    );
    prop_assert_eq!(bench.registers(&[6, 7]).await, ["14", "40"]);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 5, failure_persistence: None, ..ProptestConfig::default() })]

    /// Up to the two and a half seconds in which a sensor that does not answer is not lost yet.
    #[test]
    fn a_host_that_stands_still_loses_nothing(
        (message, rate_hz) in prop::sample::select(vec![("VNYMR", 1), ("VNYMR", 10), ("VNYMR", 40), ("VNIMU", 100), ("BINARY", 200)]),
        stalls in prop::collection::vec((100_u64..6000, 50_u64..2000), 0..5),
    ) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().start_paused(true).build().unwrap();
        runtime.block_on(nothing_is_lost(rate_hz, message, stalls))?;
    }
}
