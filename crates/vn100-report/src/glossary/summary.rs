//! The words with which the summary begins, and the messages that it names.

use vn100_analysis::Remedy;
use vn100_analysis::protocol::{AsyncType, MESSAGES, PACKET_MESSAGES};

use super::{Explanation, entry};
use crate::summary::status::StatusWord;

pub(super) fn explanations() -> Vec<Explanation> {
    let words = StatusWord::ALL.into_iter().map(of_word);
    let sentences = MESSAGES.into_iter().map(|layout| {
        let about = AsyncType::from_header(layout.message.as_bytes()).and_then(AsyncType::description);
        of_message(&layout.message, "sentence", about.unwrap_or("measurements"), layout.compensated)
    });
    let packets = PACKET_MESSAGES.into_iter().map(|packet| {
        let about = packet.description.trim_start_matches("packets of ");
        of_message(packet.name, "binary packet", &about.replace("the same", "what BINARY carries,"), Some(false))
    });
    words.chain(sentences).chain(packets).collect()
}

fn of_word(status: StatusWord) -> Explanation {
    let (also, meaning, why, advice, remedies): (&[_], _, _, _, &'static [Remedy]) = match status {
        StatusWord::Moved => (
            &[],
            "The sensor was moved during the record.",
            "What the deviation shows is the motion. No noise parameters are given.",
            "Record at rest, or exclude the time in which it moved.",
            &[Remedy::Skip(None), Remedy::EndEarlier],
        ),
        StatusWord::Problem => (
            &[],
            "A warning of the severity problem: the numbers may be wrong, or belong to something else.",
            "Do not use the numbers before the cause is known.",
            "Read what stands beside it and do what its note says; record again where nothing else helps.",
            &[],
        ),
        StatusWord::Check => (
            &["caution"],
            "A warning of the severity caution: something was assumed, is missing, or disturbed the record.",
            "The numbers may differ from those of an undisturbed record by more than their intervals.",
            "Read what stands beside it, and decide whether it matters for the parameters in question.",
            &[],
        ),
        StatusWord::Limited => (
            &["note"],
            "Nothing is wrong, but the stream does not carry everything that the sensor measures.",
            "Some parameters are not given, or compare with a data sheet only by a factor.",
            "Where such a parameter is needed, record the message that the note names.",
            &[],
        ),
        StatusWord::Untested => (
            &[],
            "There are too few samples to test this aspect.",
            "What would disturb the numbers is not excluded.",
            "Record longer.",
            &[],
        ),
        StatusWord::Ok => (
            &[],
            "No warning of this aspect.",
            "The numbers can be used as they stand, as far as this aspect goes.",
            "Nothing.",
            &[],
        ),
    };
    entry("Words of the summary", ((status.word(), also), status.word(), [meaning, why, advice], remedies, ""))
}

fn of_message(name: &str, form: &str, about: &str, compensated: Option<bool>) -> Explanation {
    let is_packet = form == "binary packet";
    Explanation {
        group: "Messages",
        code: name.into(),
        title: format!("a {form} of the VN-100"),
        meaning: format!("It carries {about}."),
        why: match (compensated, is_packet) {
            (Some(true), _) => {
                "Compensated: the attitude filter has removed the bias, so that B and K of the gyroscope are not in it."
            }
            (None, _) => {
                "A setting of the sensor decides whether the attitude filter has removed the bias, and B and K of the gyroscope with it."
            }
            (Some(false), false) => "Uncompensated: what the sensor measures, with its bias.",
            (Some(false), true) => {
                "Uncompensated, up to 800 Hz, and with the time of the sensor, which shows rate and dropped samples exactly."
            }
        },
        remedies: &[Remedy::Plan],
        source: if is_packet {
            "VectorNav VN-100 User Manual, register 75"
        } else {
            "VectorNav VN-100 User Manual, register 6"
        },
        ..Explanation::default()
    }
}
