//! Every code has its explanation, and every explanation is of a code.

use std::collections::HashSet;

use vn100_analysis::WarningKind;
use vn100_analysis::noise::NoCoefficient;
use vn100_analysis::protocol::{MESSAGES, PACKET_MESSAGES};

use super::*;
use crate::{Consumer, codes::all_codes, remedies::remedy_words};

#[test]
fn every_code_warning_and_parameter_is_explained() {
    let no_coefficient = [
        NoCoefficient::Moved,
        NoCoefficient::BiasNotInStream,
        NoCoefficient::Constant,
        NoCoefficient::TooShort { blocks: 0 },
        NoCoefficient::Excursion { excursion_c: 0.0 },
        NoCoefficient::OneDirection { correlation: 1.0 },
    ];
    let words = WarningKind::ALL.map(WarningKind::name).into_iter().chain(no_coefficient.map(NoCoefficient::code));
    let words = words
        .chain(["N", "B", "K", "R", "Q", "ARW", "VRW", "BI", "RRW", "RR", "QN", "edf", "aliasing", "tau"])
        .chain(["CHECK", "PROBLEM", "limited", "MOVED", "untested", "ok"]);
    let codes = all_codes();
    assert_eq!(codes.len(), 4 + 6 + 6 + 4 + 5 + 4 + 4 + 6 + 6 + 11);
    let messages = MESSAGES.iter().map(|layout| layout.message.to_string());
    let messages = messages.chain(PACKET_MESSAGES.map(|packet| packet.name.into()));
    for code in codes.into_iter().map(|code| code.code).chain(words.map(String::from)).chain(messages) {
        assert!(!explain(&code).is_empty(), "{code}");
    }
}

#[test]
fn each_explanation_is_whole_sentences() {
    for entry in glossary() {
        let advice = entry.advice(remedy_words);
        for text in [&*entry.meaning, entry.why, &advice] {
            assert!(text.ends_with('.') && text.len() > 6 && !text.contains("{}"), "{}: {text:?}", entry.code);
            assert!(!text.contains("  "), "{}: {text:?}", entry.code);
        }
        assert!(!entry.title.is_empty(), "{}", entry.code);
    }
}

#[test]
fn a_program_is_said_to_give_the_variance_of_what_it_takes() {
    for consumer in &Consumer::ALL {
        let [entry] = &explain(consumer.name)[..] else { panic!("{}", consumer.name) };
        assert_eq!(entry.why.contains("K^2 t"), consumer.walk.is_some(), "{}: {}", consumer.name, entry.why);
    }
}

#[test]
fn a_name_is_that_of_one_thing_in_each_group() {
    let mut seen = HashSet::new();
    for entry in glossary() {
        for name in std::iter::once(&*entry.code).chain(entry.aliases) {
            assert!(seen.insert((entry.group, plain(name))), "{}: {name}", entry.group);
        }
    }
}

#[test]
fn messages_say_whether_they_are_compensated() {
    for (message, why) in
        [("VNYMR", "Compensated"), ("VNIMU", "Uncompensated"), ("vndtv", "A setting"), ("binary", "Uncomp")]
    {
        assert!(explain(message)[0].why.starts_with(why), "{message}");
    }
}

#[test]
fn names_are_found_in_any_spelling() {
    assert_eq!(explain("arw")[0].code, "N");
    assert_eq!(explain("Rate Random Walk")[0].code, "K");
    assert_eq!(explain("COMPENSATED_STREAM")[0].code, "compensated-stream");
    // a reason and a warning
    assert_eq!(explain("too-short").len(), 2);
    assert_eq!(explain("angle"), []);
    assert_eq!(explain("sensor's own N")[0].code, "aliasing");
    assert_eq!(explain("FAIL").len(), 1);
}
