//! The texts, tables and documents of a record.

use proptest::prelude::*;
use serde_json::Value;
use vn100_analysis::{
    CaveatKind, Comparison, Completion, Finding, Outages, SourceResult, Warning, WarningKind,
    protocol::{Layout, VNIMU, stream::BagReport},
};

use super::fixture::{at_rest, long_at_rest, measured};
use crate::remedies::page_words;
use crate::{Consumer, Document, Evaluation, FilterNoise, caveats::caveat_in_words, metrics_text, summary::Summary};

fn document(result: &SourceResult) -> Value {
    serde_json::to_value(Document::new(result, page_words)).unwrap()
}

#[test]
fn statistics_have_as_many_decimals_as_their_quantity_needs() {
    let summary = Summary::new(long_at_rest(), page_words);
    let rows: Vec<_> = (summary.statistics.iter())
        .map(|row| {
            format!("{} {}: {}; {}; {}", row.label, row.unit, row.means.join(" "), row.stds.join(" "), row.remark)
        })
        .collect();
    let expected = [
        "gyro deg/s: 0.0516 -0.0286 0.0261; 0.0114 0.0115 0.0219; ",
        "accel m/s²: 0.1196 -0.0799 -9.8000; 0.0400 0.0397 0.0402; norm 9.8010",
        "mag gauss: 0.2100 -0.0300 0.4100; 0.0005 0.0005 0.0005; norm 0.4616",
        "temp °C: 25.100; 0.104; ",
        "baro kPa: 101.325; 0.008; ",
    ];
    assert_eq!(rows, expected);
}

/// Beside losses of other kinds as without them.
#[test]
fn an_outage_stands_in_the_line_of_the_data() {
    for kind in [None, Some(WarningKind::Gaps), Some(WarningKind::RejectedLines), Some(WarningKind::Incomplete)] {
        let mut result = long_at_rest().clone();
        result.link.outages = Outages { times: 2, down_ns: Some(11_584_000_000), ..Outages::default() };
        let said = Warning::new(Finding::Said("losses".into()));
        result.warnings = kind.map(|kind| Warning { kind, severity: kind.severity(), ..said }).into_iter().collect();
        let summary = Summary::new(&result, page_words);
        let data = summary.statuses.iter().find(|status| status.aspect == "data").unwrap();
        let said = data.findings.iter().filter(|(text, _)| text == "link lost 2 times, 11.6 s without it");
        assert_eq!(said.count(), 1, "{kind:?}: {:?}", data.findings);
    }
}

#[test]
fn the_file_for_kalibr_says_of_each_value_what_it_is() {
    let kalibr = Consumer::named("kalibr").unwrap();
    let text = kalibr.file(&FilterNoise::of(long_at_rest(), 60.0)).unwrap();
    for lines in [
        "m/s^2/sqrt(Hz): accel_z, estimated\n",
        "\naccelerometer_noise_density: 0.0063428\n",
        ": accel_z, by its bias instability over 60 s, B not detected, upper bound\n",
        "\naccelerometer_random_walk: 2.6964e-4\n",
        "rad/s/sqrt(Hz): gyro_y, estimated\n",
        "\ngyroscope_noise_density: 3.1845e-5\n",
        ": gyro_z, estimated\n",
        "\ngyroscope_random_walk: 3.0589e-5\n",
    ] {
        assert!(text.contains(lines), "{lines:?} is not in:\n{text}");
    }
}

#[test]
fn a_file_for_a_filter_names_its_record_and_asks_for_more_only_than_it_has() {
    for span_s in [1.0, 60.0, 600.0, 1e5] {
        let noise = FilterNoise::of(long_at_rest(), span_s);
        for consumer in Consumer::ALL.iter().filter(|consumer| consumer.name != "kf-gins") {
            let text = consumer.file(&noise).unwrap();
            let name = &long_at_rest().source.name;
            assert!(text.contains(&format!("record {name}")), "{text}");
            assert_eq!(text.contains("rostopic is a placeholder"), text.contains("rostopic: "), "{text}");
            assert!(consumer.walk.is_some() || !text.contains(" K "), "{text}");
            let (_, asked) = text.split_once("too sure takes at least: ").unwrap();
            for least in asked.lines().next().unwrap().split(", ") {
                let (name, least) = least.split_at("N of the ".len() + least["N of the ".len()..].find(' ').unwrap());
                let value = |text: &str| text.split_whitespace().next().unwrap().parse::<f64>().unwrap();
                let (_, own) = text.split_once(&format!("{name} = ")).unwrap();
                assert!(value(least) > value(own), "{least} {text}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn a_refused_file_blames_what_hides_the_noise(std in 0.15_f64..0.25, samples in 8000_u64..16_000) {
        let refusal = |samples, accel: (f64, f64)| {
            let channels = [[(2100.0, 5.0); 3], [accel; 3], [(300.0, 200.0); 3]].concat();
            let channels = [&channels[..], &[(251.0, 1.0), (101_325.0, 8.0)]].concat();
            let record = measured((&VNIMU, 40.0), samples, &channels, |_, _, _| 0.0);
            let error = Consumer::named("kalibr").unwrap().file(&FilterNoise::of(&record, 60.0)).unwrap_err();
            format!("{error} {}", error.advice(page_words))
        };
        let rounded = refusal(samples, (120.0, std));
        prop_assert!(rounded.contains("more digits") && !rounded.contains("short"), "{}", rounded);
        let short = refusal(6, (120.0, 40.0));
        prop_assert!(short.contains("record is too short") && !short.contains("digits"), "{}", short);
    }

    #[test]
    fn what_is_done_on_board_is_stated_only_if_it_is_known(hz in 20_u32..100, times in 2_u32..5) {
        let said = |layout: &Layout| {
            let of = |hz| measured((layout, f64::from(hz)), 512, &vec![(0.0, 50.0); layout.channels.len()], |_, _, _| 0.0);
            let records = [of(hz * times), of(hz)];
            let comparison = Comparison::of(&records, &[], 0.95);
            let caveat = comparison.caveats.iter().find(|caveat| caveat.kind == CaveatKind::Sampling).unwrap();
            caveat_in_words(caveat, &records, &comparison, page_words)
        };
        let of_table = said(&Layout { message: "CSV".into(), ..VNIMU.clone() });
        prop_assert!(of_table.starts_with("the sensor may average and decimate differently"), "{}", of_table);
        let of_vn100 = said(&VNIMU);
        prop_assert!(of_vn100.starts_with("the sensor averages and decimates differently"), "{}", of_vn100);
    }
}

#[test]
fn metrics_have_the_parameters_of_a_sensor_at_rest_alone() {
    let metrics = |vibrations: &[(f64, f64)]| {
        let source = (&at_rest(4096, vibrations), None);
        metrics_text(&[source])
    };
    let (rest, moved) = (metrics(&[]), metrics(&[(1.0, 5000.0)]));
    for name in ["vn100_white_noise{", "vn100_bias_instability{", "vn100_rate_random_walk{"] {
        assert!(rest.contains(name) && !moved.contains(name), "{name} in {moved}");
    }
    assert!(moved.contains("vn100_channel_std{"), "{moved}");
}

#[test]
fn the_counts_of_a_bag_stand_under_their_names() {
    let mut measured = at_rest(64, &[]);
    let (topic, type_name) = ("/imu".into(), "sensor_msgs/msg/Imu".into());
    let bag = BagReport { topic, type_name, ..BagReport::default() };
    measured.source.bag =
        Some(BagReport { messages: 1, used: 2, without_sample: 3, unreadable: 4, other_messages: 5, ..bag });
    let bag = &document(&measured)["source"]["bag"];
    let names = ["messages", "used", "without_sample", "unreadable", "other_messages"];
    assert_eq!(names.map(|name| bag[name].as_u64()), [1, 2, 3, 4, 5].map(Some));
}

#[test]
fn a_parameter_that_must_pass_and_does_is_not_reported() {
    for (figure, unmet) in [("gyro B", 0), ("accel B", 1)] {
        let fail_on = vec![figure.parse().unwrap()];
        let complete = Evaluation::new(None, fail_on, false).unwrap().complete(long_at_rest().clone());
        assert_eq!(complete.unmet.len(), unmet, "{:?}", complete.unmet);
        let expected = if unmet == 0 { Completion::Complete } else { Completion::NotMet };
        assert_eq!(complete.completion, expected);
    }
}
