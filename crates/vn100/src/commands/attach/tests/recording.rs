//! Recordings: resumed, and never resumed by two.

use vn100_driver::OutputSettings;

use super::{Bench, replayed};
use crate::commands::attach::Completion;

#[tokio::test(start_paused = true)]
async fn the_samples_of_a_sensor_are_a_table_of_the_measured_ones() {
    let bench = Bench::new("");
    let measured = bench.run("attach -d 2s --json --samples {}/samples.csv").await;
    assert_eq!(measured.completion, Completion::Complete);
    // rows that came before the rate was known may lie after the end
    let read = replayed(&bench.file("samples.csv"), "--rate 40 -d 2s").await;
    assert_eq!((measured.number("/timing/samples"), read.number("/timing/samples")), (80, 80));
    let channels = |document: &serde_json::Value| document["channels"].as_array().unwrap().clone();
    for (measured, read) in channels(&measured.document).iter().zip(channels(&read.document)) {
        assert_eq!((&measured["name"], &measured["statistics"]), (&read["name"], &read["statistics"]));
    }
}

/// A replay measures one message: another one after it would be recorded in vain.
#[tokio::test(start_paused = true)]
async fn a_recording_is_resumed_with_its_own_message_alone() {
    let bench = Bench::new("");
    for (name, rotation) in [("whole", ""), ("parts", "--rotate 1h")] {
        let attach = async |message: &str| {
            let options = format!("--duration 1s --resume --set-message {message} {rotation}");
            bench.run(&format!("attach {options} --record {{}}/{name}.mcap")).await
        };
        assert_eq!(attach("BINARY").await.completion, Completion::Complete);
        for (message, expected) in
            [("VNIMU", Completion::Failed), ("BINARY+MAG", Completion::Failed), ("BINARY", Completion::Complete)]
        {
            let resumed = attach(message).await;
            let error = resumed.error();
            assert_eq!(resumed.completion, expected, "{message}: {error}");
            let is_told = error.contains("holds BINARY, and a replay would not measure");
            assert_eq!(is_told, expected == Completion::Failed, "{error}");
        }
    }
}

/// What a sensor sends by itself is known after its first sample.
#[tokio::test(start_paused = true)]
async fn a_recording_that_goes_on_with_another_message_says_so() {
    let bench = Bench::new("");
    let record = async || bench.run("record --duration 2s --resume -o {}/on.mcap").await;
    let told = "on.mcap holds VNYMR, and a replay would not measure VNIMU behind it: record VNIMU to another file";
    assert_eq!((record().await.said(told), record().await.said(told)), (0, 0));
    bench.configure(OutputSettings { message: Some("VNIMU".into()), ..OutputSettings::default() }).await;
    assert_eq!(record().await.said(told), 1);
}

#[tokio::test(start_paused = true)]
async fn a_recording_is_resumed_by_one_at_a_time_and_replayed_to_its_end() {
    let bench = Bench::new("");
    let first = bench.run("record --duration 1s -o {}/resumed.mcap").await;
    assert_eq!((first.completion, first.said("resumed.mcap")), (Completion::Complete, 1), "{:?}", first.messages);
    let again = bench.run("record --duration 1s -o {}/resumed.mcap").await;
    assert_eq!(again.completion, Completion::Failed, "it exists");
    let mut second = bench.start("record --resume -o {}/resumed.mcap");
    second.until(|state| state.snapshot.timing.samples >= 80).await;
    let other = Bench::new("");
    let taken = bench.file("resumed.mcap");
    let refused = other.run(&format!("record --duration 1s --resume -o {}", taken.display())).await;
    assert_eq!(refused.completion, Completion::Failed);
    assert!(refused.error().contains("is being recorded to"), "{}", refused.error());
    second.stop.cancel();
    second.end().await;
    let whole = replayed(&taken, "").await;
    assert_eq!((whole.number("/timing/segments"), whole.number("/timing/gaps")), (2, 0));
    assert!(whole.number("/timing/samples") >= 120, "{}", whole.document["timing"]);
}

#[tokio::test(start_paused = true)]
async fn an_empty_recording_leaves_nothing_behind() {
    let bench = Bench::new("--faults unplug@0s+1h");
    let lost = bench.run("record --duration 1s -o {}/none.mcap").await;
    assert_eq!(lost.completion, Completion::NoData, "{}", lost.error());
    assert!(!bench.file("none.mcap").exists());
}
