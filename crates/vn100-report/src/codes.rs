//! The codes of documents: the word for each in text and pages, and its meaning, which the schemas of
//! the documents say too.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use vn100_analysis::noise::{Grade, Status, Verdict, Withheld};
use vn100_analysis::{DecidedBy, EndKind, MissingFrom, RateFrom, WindowFrom};

use crate::schema::schema_of;

#[derive(Debug)]
pub(crate) struct Code {
    /// The key in documents whose value the code is.
    pub(crate) key: &'static str,
    /// The code itself.
    pub(crate) code: String,
    /// The word for the code in text and pages, if it is another than the code.
    pub(crate) word: Option<&'static str>,
    /// The meaning of the code, in a sentence.
    pub(crate) meaning: String,
}

/// All codes, verdicts first.
pub(crate) fn all_codes() -> Vec<Code> {
    let of_key = |(key, meanings): (&'static str, Meanings)| {
        meanings.into_iter().map(move |(code, meaning)| Code { key, word: other_word(key, &code), code, meaning })
    };
    let all = [
        ("verdict", meanings_of::<Verdict>()),
        ("decided_by", meanings_of::<DecidedBy>()),
        ("status", meanings_of::<Status>()),
        ("grade", meanings_of::<Grade>()),
        ("rate_from", meanings_of::<RateFrom>()),
        ("missing_from", meanings_of::<MissingFrom>()),
        ("window_from", meanings_of::<WindowFrom>()),
        ("withheld", meanings_of::<Withheld>()),
        ("temperature.reason", NO_COEFFICIENT.map(|(code, meaning)| (code.into(), meaning.into())).into()),
        ("end_reason", meanings_of::<EndKind>()),
    ];
    all.into_iter().flat_map(of_key).collect()
}

/// The word for a value of a kind that documents write as a code under this key.
pub(crate) fn word_of(key: &str, value: impl Serialize) -> String {
    let code = name_of(value);
    other_word(key, &code).map_or_else(|| code.replace('-', " "), str::to_owned)
}

fn other_word(key: &str, code: &str) -> Option<&'static str> {
    let mut words = WORDS.iter().filter(|(of, _)| *of == key).flat_map(|(_, words)| *words);
    words.find(|(of, _)| *of == code).map(|(_, word)| *word)
}

/// The code of a value of a kind that documents write as a code.
pub(crate) fn name_of(value: impl Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(Value::String(code)) => code,
        _ => String::new(),
    }
}

/// Codes, each with its meaning.
type Meanings = Vec<(String, String)>;

/// The codes of a kind in their order, with what the schema says of each.
pub(crate) fn meanings_of<T: JsonSchema>() -> Meanings {
    let schema = schema_of::<T>();
    let variants = schema.get("oneOf").and_then(Value::as_array).into_iter().flatten();
    let text = |variant: &Value, key| variant[key].as_str().unwrap_or_default().to_owned();
    variants.map(|variant| (text(variant, "const"), text(variant, "description"))).collect()
}

/// The words that differ from their codes by more than hyphens, by key.
const WORDS: [(&str, &[(&str, &str)]); 7] = [
    (
        "decided_by",
        &[
            ("rate", "a known sample rate"),
            ("window", "a known averaging window"),
            ("convention", "a sheet that says whether its density is one-sided"),
            ("unaliased", "a stream without aliasing"),
            ("longer-record", "a longer record"),
        ],
    ),
    ("status", &[("bounded", "upper bound"), ("moved", "sensor moved")]),
    (
        "rate_from",
        &[
            ("option", "as given"),
            ("device-time", "from device time"),
            ("device", "as reported by the sensor"),
            ("arrival", "from arrival times"),
        ],
    ),
    ("missing_from", &[("counter", "row counter"), ("arrival", "arrival times"), ("bad-lines", "rejected lines")]),
    (
        "window_from",
        &[
            ("register", "register 85"),
            ("option", "as given"),
            ("integrated", "whole interval"),
            ("default", "factory default"),
        ],
    ),
    (
        "withheld",
        &[
            ("perhaps-cycle", "perhaps a cycle"),
            ("perhaps-warm-up", "perhaps a warm-up"),
            ("perhaps-correlated", "perhaps correlated noise"),
            ("perhaps-switching", "perhaps switching noise"),
        ],
    ),
    (
        "end_reason",
        &[
            ("end-of-input", "end of the data"),
            ("duration", "duration reached"),
            ("goals", "goals decided"),
            ("gave-up", "sensor lost"),
            ("wall-time", "wall time over"),
        ],
    ),
];

/// Why there is no temperature coefficient.
const NO_COEFFICIENT: [(&str, &str); 6] = [
    ("moved", "The sensor was moved."),
    ("bias-not-in-stream", "A filter removes the bias before the sensor sends the samples."),
    ("constant", "The values do not vary."),
    ("too-short", "Fewer than 32 consecutive blocks have samples and a temperature."),
    ("excursion", "The temperature changed by less than 1 °C."),
    ("one-direction", "The temperature only rose or only fell, so that any other drift would look the same."),
];
