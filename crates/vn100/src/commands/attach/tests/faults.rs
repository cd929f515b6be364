//! Each fault of the link or the sensor, with its counts.

use vn100_driver::OutputSettings;

use super::{Bench, assert_same_but_source, message, rate, replayed};
use crate::commands::attach::Completion;

#[tokio::test(start_paused = true)]
async fn the_baud_rate_is_found_and_a_replay_equals_the_measurement() {
    for baud in [57_600, 460_800, 921_600] {
        let bench = Bench::new(&format!("--faults baud@0s:{baud}"));
        let live = bench.run("attach --duration 2s --json --record {}/live.mcap").await;
        assert_eq!((live.number("/timing/samples"), live.completion), (80, Completion::Complete), "{baud}");
        assert_eq!((live.number("/timing/missing"), live.number("/link/reconnects")), (0, 0));
        live.assert_conserved();
        assert_eq!(live.said(&format!("at {baud} baud")), 1, "{:?}", live.messages);
        let recorded = replayed(&bench.file("live.mcap"), "").await;
        assert_eq!(recorded.completion, Completion::Complete);
        assert_eq!(recorded.document["source"]["recorded"]["complete"], true);
        assert_eq!(recorded.document["source"]["device"], live.document["source"]["device"]);
        assert_same_but_source(&recorded.document, &live.document);
    }
}

#[tokio::test(start_paused = true)]
async fn messages_with_a_quaternion_or_without_attitude_are_measured() {
    let bench = Bench::new("");
    for (name, rate_hz, channels) in [("VNMAR", 100_u32, 9), ("VNQMR", 50, 13)] {
        let options = format!("attach --set-message {name} --set-rate {rate_hz} --duration 2s --json");
        let measured = bench.run(&options).await;
        assert_eq!(measured.document["source"]["message"], name);
        assert_eq!(measured.document["timing"]["rate_hz"], f64::from(rate_hz));
        assert_eq!(measured.document["channels"].as_array().unwrap().len(), channels);
        assert_eq!(measured.number("/timing/samples"), 2 * u64::from(rate_hz));
        measured.assert_conserved();
    }
    let too_fast = OutputSettings { message: Some("VNQMR".into()), ..rate(100) };
    let refused = bench.set(too_fast).await.unwrap_err().to_string();
    assert!(refused.contains("at most 50 Hz fit"), "{refused}");
}

#[tokio::test(start_paused = true)]
async fn a_counter_in_each_line_makes_the_losses_exact() {
    for seed in 1..=8 {
        let bench = Bench::new(&format!("--faults flip@0.02% --seed {seed}"));
        bench.configure(OutputSettings { count: Some(true), ..OutputSettings::default() }).await;
        let measured = bench.run("attach --duration 10s --json").await;
        assert_eq!(measured.document["timing"]["missing_from"], "counter");
        assert_eq!(measured.expected_samples(), 400, "seed {seed}");
        measured.assert_conserved();
    }
}

#[tokio::test(start_paused = true)]
async fn settings_are_restored_under_the_other_name() {
    let bench = Bench::new("--faults unplug@12s+1s:other");
    let measured = bench.run("attach --set-rate 20 --duration 12s --json").await;
    assert_eq!(measured.completion, Completion::Complete, "{:?}", measured.messages);
    assert_eq!(measured.said("settings restored"), 1, "{:?}", measured.messages);
    assert_eq!(measured.document["timing"]["rate_hz"], 20.0);
    assert_eq!((measured.expected_samples(), measured.number("/timing/segments")), (240, 2));
    assert_eq!(bench.registers(&[7]).await, ["40"]);
}

#[tokio::test(start_paused = true)]
async fn another_message_is_named_with_the_line_that_cures_it() {
    let bench = Bench::new("");
    let configured = bench.configure(message("VNYPR")).await;
    assert!(configured.rate_is_kept(), "its lines come as set");
    let told = crate::words::describe(&configured);
    assert!(told.contains("the message (register 06) from 14 to 1;"), "{told}");
    let told = bench.run("attach --json").await;
    assert_eq!(told.completion, Completion::NoData);
    assert!(told.number("/link/other_messages") > 0);
    assert!(told.document["warnings"].to_string().contains("VNYPR"), "{}", told.document["warnings"]);
}
