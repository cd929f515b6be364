//! The sensor is left as it was found, however a command ends.

use proptest::prelude::*;
use tokio::time::{Duration, advance, sleep};
use vn100_driver::OutputSettings;

use super::{Bench, message, rate, replayed};
use crate::commands::attach::Completion;

#[tokio::test(start_paused = true)]
async fn what_is_configured_is_read_back_and_what_attach_changes_is_put_back() {
    let bench = Bench::new("");
    let configured = bench.configure(OutputSettings { window: Some(40), ..rate(20) }).await;
    assert!(configured.rate_is_kept());
    let registers = bench.registers(&[7, 85]).await;
    assert_eq!(registers[0], "20");
    assert!(registers[1].starts_with("0,40,40,40,") || registers[1].contains(",40,40,"), "{registers:?}");
    let refused = bench.set(rate(100)).await.unwrap_err().to_string();
    assert!(refused.contains("at most 50 Hz fit"), "{refused}");
    assert_eq!(bench.registers(&[7, 85]).await, registers);

    let measured = bench.run("attach --set-rate 50 --set-message VNIMU --duration 2s --json").await;
    let timing = &measured.document["timing"];
    assert_eq!((&timing["rate_hz"], &timing["rate_from"]), (&50.0.into(), &"device".into()));
    assert_eq!(measured.document["source"]["message"], "VNIMU");
    assert_eq!(measured.said("settings restored"), 1, "{:?}", measured.messages);
    assert_eq!(bench.registers(&[6, 7, 85]).await, ["14", "20", &registers[1]]);
}

/// A message is chosen again after packets; one only for a measurement gives them back.
#[tokio::test(start_paused = true)]
async fn a_sentence_is_measured_in_place_of_the_packets_set_before() {
    let bench = Bench::new("");
    bench.configure(OutputSettings { rate_hz: Some(800), ..message("BINARY") }).await;
    let packets = bench.registers(&[6, 75]).await;
    let measured = bench.run("attach --set-message VNIMU --set-rate 100 --duration 2s --json").await;
    assert_eq!(measured.document["source"]["message"], "VNIMU", "{:?}", measured.messages);
    assert_eq!(measured.document["timing"]["rate_hz"], 100.0);
    assert_eq!(bench.registers(&[6, 75]).await, packets);
    // a slower line has room again, also if a program left the output paused
    bench.pause().await;
    bench.configure(OutputSettings { baud: Some(115_200), ..message("VNYMR") }).await;
    assert_eq!(bench.run("attach --duration 2s --json").await.document["source"]["message"], "VNYMR");
    assert_eq!(bench.registers(&[5, 6, 75]).await, ["115200", "14", "0,1,05,0001,001C"]);
}

#[tokio::test(start_paused = true)]
async fn an_output_that_was_found_paused_and_set_is_left_so_by_attach_and_on_by_configure() {
    let bench = Bench::new("");
    bench.pause().await;
    let measured = bench.run("attach --set-rate 20 --duration 1s --json").await;
    assert_eq!(measured.completion, Completion::Complete, "{:?}", measured.messages);
    assert_eq!(measured.document["timing"]["rate_hz"], 20.0);
    assert_eq!(measured.said("its output was paused and is on now"), 1, "{:?}", measured.messages);
    assert_eq!(measured.said("settings restored, with its output paused"), 1, "{:?}", measured.messages);
    assert_eq!(bench.registers(&[7]).await, ["40"]);
    assert!(!bench.sends().await);
    bench.configure(rate(20)).await;
    assert!(bench.sends().await);
    assert_eq!(bench.run("attach --duration 1s --json").await.number("/link/outputs_resumed"), 0);
}

#[tokio::test(start_paused = true)]
async fn a_paused_sensor_that_is_only_listened_to_may_be_paused() {
    let bench = Bench::new("");
    bench.pause().await;
    let heard = bench.run("attach --listen-only --baud 115200 --duration 1s --json").await;
    assert_eq!(heard.completion, Completion::NoData);
    assert!(heard.error().contains("no data received; its output may be paused"), "{}", heard.error());
}

/// A command that is interrupted at this moment.
async fn interrupted(options: &str, was_paused: bool, after: Duration) {
    let bench = Bench::new("");
    if was_paused {
        bench.pause().await;
    }
    let before = bench.registers(&[6, 7, 75, 85]).await;
    // the last command resumes a paused output to be answered, and pauses it again
    assert_eq!(bench.sends().await, !was_paused);
    let running = bench.start(&format!("attach {options} --json --record {{}}/a.mcap"));
    sleep(after).await;
    running.stop.cancel();
    let outcome = running.end().await;
    let when = format!("{options:?}, paused {was_paused}, after {after:?}: {:?}", outcome.messages);
    assert_eq!(bench.sends().await, !was_paused, "{when}");
    assert_eq!(bench.registers(&[6, 7, 75, 85]).await, before, "{when}");
    let samples = outcome.number("/timing/samples");
    if samples == 0 {
        assert_eq!(outcome.completion, Completion::NoData, "{when}");
        // a recording is begun with the first bytes of the sensor, and holds them
        if bench.file("a.mcap").exists() {
            let read = replayed(&bench.file("a.mcap"), "").await;
            assert!(read.number("/link/bytes") > 0, "{when}");
        }
    } else {
        assert_eq!(outcome.completion, Completion::Complete, "{when}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 5, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn an_interrupt_at_any_moment_leaves_the_sensor_as_it_was_found(
        options in prop::sample::select(vec![
            "", "--set-rate 20", "--set-rate 50 --set-message VNIMU", "--set-message BINARY --set-rate 800", "--window 20",
        ]),
        was_paused: bool,
        after_ms in 0_u64..9000,
    ) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().start_paused(true).build().unwrap();
        runtime.block_on(interrupted(options, was_paused, Duration::from_millis(after_ms)));
    }
}

/// A recording of the first replies alone, as the interrupts in a fifth of the draws leave it.
#[tokio::test(start_paused = true)]
async fn an_interrupt_before_the_first_sample_leaves_a_recording_of_the_replies() {
    for after_ms in [154, 200, 439, 700] {
        interrupted("", true, Duration::from_millis(after_ms)).await;
    }
}

/// A paused sensor is measured by a host that stands still for a while.
async fn paused_again(stall_at: Duration, stall: Duration) -> Result<(), TestCaseError> {
    let bench = Bench::new("");
    bench.pause().await;
    let running = bench.start("attach --duration 2s --json");
    sleep(stall_at).await;
    advance(stall).await;
    let told = running.end().await;
    prop_assert_eq!(told.completion, Completion::Complete, "{:?}", told.messages);
    prop_assert!(!bench.sends().await, "{:?} at {:?}: {:?}", stall, stall_at, told.messages);
    prop_assert_eq!(told.said("its output is paused again"), 1);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_paused_sensor_is_paused_again_however_its_host_stands_still(at_ms in 0_u64..6000, for_ms in 30_u64..1500) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().start_paused(true).build().unwrap();
        runtime.block_on(paused_again(Duration::from_millis(at_ms), Duration::from_millis(for_ms)))?;
    }
}
