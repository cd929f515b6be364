//! The table of the codes of documents: the word for each code in text and pages, and its meaning, as
//! `vn100 explain` lists them.

use serde::Serialize;
use serde_json::Value;
use vn100_analysis::noise::Term;

/// A code of documents.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// The key in documents whose value the code is.
    pub key: &'static str,
    /// The code itself.
    pub code: &'static str,
    /// The word for the code in text and pages.
    pub word: &'static str,
    /// The meaning of the code, in a sentence without a full stop.
    pub meaning: &'static str,
}

/// All codes, verdicts first.
#[must_use]
pub fn all_codes() -> Vec<Code> {
    let of_key = |(key, codes): &(&'static str, &'static [Words])| {
        let key = *key;
        codes.iter().map(move |&(code, word, meaning)| Code { key, code, word, meaning })
    };
    CODES.iter().flat_map(of_key).collect()
}

/// The word for a value of a kind that documents write as a code under this key; the code itself if
/// the table does not have it.
pub(crate) fn word_of(key: &str, value: impl Serialize) -> String {
    let name = name_of(value);
    let mut codes = CODES.iter().filter(|(of, _)| *of == key).flat_map(|(_, codes)| *codes);
    codes.find(|(code, ..)| *code == name).map_or(name, |(_, word, _)| (*word).to_owned())
}

/// The code of a value of a kind that documents write as a code.
pub(crate) fn name_of(value: impl Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(Value::String(code)) => code,
        _ => String::new(),
    }
}

pub(crate) fn term_name(term: Term) -> &'static str {
    match term {
        Term::Quantization => "quantization",
        Term::White => "white",
        Term::BiasInstability => "bias_instability",
        Term::RateRandomWalk => "rate_random_walk",
        Term::RateRamp => "rate_ramp",
    }
}

/// Code, word and meaning.
type Words = (&'static str, &'static str, &'static str);

const CODES: [(&str, &[Words]); 10] = [
    (
        "verdict",
        &[
            ("fail", "fail", "the whole interval lies beyond the limit, even with all that is not known of it"),
            (
                "undecided",
                "undecided",
                "the interval spans the limit, or what is not known; decided_by names what would decide",
            ),
            ("not-comparable", "not comparable", "the message does not carry the parameter"),
            ("pass", "pass", "the whole interval lies within the limit, even with all that is not known of it"),
        ],
    ),
    (
        "decided_by",
        &[
            ("rate", "a known sample rate", "the sample rate is assumed"),
            (
                "window",
                "a known averaging window",
                "the stream does not contain how the sensor averages, and so how much aliases",
            ),
            (
                "convention",
                "a sheet that says whether its density is one-sided",
                "a one-sided density is √2 times the two-sided one, and the value lies between both readings",
            ),
            (
                "unaliased",
                "a stream without aliasing",
                "how much aliasing raises the value is known to 10 %, and the value lies within that of the limit",
            ),
            (
                "longer-record",
                "a longer record",
                "the interval spans the limit, or there is none; it narrows with the record",
            ),
            (
                "nothing",
                "nothing",
                "the parameter is so near to the limit that 100 days of the noise in this record do not decide",
            ),
        ],
    ),
    (
        "status",
        &[
            ("estimated", "estimated", "the term was detected; it has a value and a two-sided confidence interval"),
            ("bounded", "upper bound", "the term was not detected and may be zero; only its upper bound is given"),
            ("not-observable", "not observable", "the record does not show it, mostly because it is too short"),
            ("not-measurable", "not measurable", "the message does not carry it, however long the record"),
            (
                "moved",
                "sensor moved",
                "the sensor was moved, and what its deviation shows is the motion; a record at rest shows the parameter",
            ),
            (
                "model-rejected",
                "model rejected",
                "no range of averaging times follows the noise model; N may still have an upper bound",
            ),
        ],
    ),
    (
        "grade",
        &[
            ("navigation", "navigation", "B below 0.01 deg/h and N below 0.002 deg/sqrt(h); no standard defines these"),
            ("tactical", "tactical", "B below 1 deg/h and N below 0.05 deg/sqrt(h)"),
            ("industrial", "industrial", "B below 30 deg/h and N below 0.5 deg/sqrt(h)"),
            ("consumer", "consumer", "B or N above the industrial limits"),
        ],
    ),
    (
        "rate_from",
        &[
            ("option", "as given", "given by the user"),
            ("device-time", "from device time", "each packet carries the time at which the sensor measured it"),
            ("device", "as reported by the sensor", "the sensor reported its output rate (register 07)"),
            ("arrival", "from arrival times", "the nominal rate of the sensor that the arrival times match"),
            ("assumed", "assumed", "unknown: the factory default of 40 Hz"),
        ],
    ),
    (
        "missing_from",
        &[
            (
                "device-time",
                "device time",
                "each packet carries the time at which the sensor measured it, so that dropped ones are counted exactly",
            ),
            ("counter", "row counter", "the sensor counts its samples, so that dropped ones are counted exactly"),
            ("arrival", "arrival times", "gaps in the arrival times"),
            (
                "bad-lines",
                "rejected lines",
                "each rejected line counts as one dropped sample; entirely missing lines are not detected",
            ),
        ],
    ),
    (
        "window_from",
        &[
            ("register", "register 85", "the capture contains register 85"),
            ("option", "as given", "the user gave the value of register 85"),
            ("integrated", "whole interval", "the sensor sends integrals over the interval between rows"),
            ("default", "factory default", "unknown: the factory default, which may have been changed"),
        ],
    ),
    (
        "withheld",
        &[
            ("level-change", "level change", "a warm-up, a step or a cycle poses as them"),
            ("temperature", "temperature", "what follows the temperature poses as them"),
            ("perhaps-cycle", "perhaps a cycle", "a cycle of the level explains the record about as well as they do"),
            (
                "perhaps-warm-up",
                "perhaps a warm-up",
                "a level that settles from the start on explains the record about as well as they do",
            ),
            (
                "perhaps-correlated",
                "perhaps correlated noise",
                "noise that is correlated over a small part of the record explains it about as well as they do",
            ),
            (
                "perhaps-switching",
                "perhaps switching noise",
                "noise that switches between two levels explains the record about as well as they do",
            ),
        ],
    ),
    (
        "temperature.reason",
        &[
            ("moved", "moved", "the sensor was moved"),
            (
                "bias-not-in-stream",
                "bias-not-in-stream",
                "a filter removes the bias before the sensor sends the samples",
            ),
            ("constant", "constant", "the values do not vary"),
            ("too-short", "too-short", "fewer than 32 consecutive blocks have samples and a temperature"),
            ("excursion", "excursion", "the temperature changed by less than 1 °C"),
            (
                "one-direction",
                "one-direction",
                "the temperature only rose or only fell, so that any other drift would look the same",
            ),
        ],
    ),
    (
        "end_reason",
        &[
            ("end-of-input", "end of the data", "all data was read"),
            ("duration", "duration reached", "the data time asked for has passed"),
            ("goals", "goals decided", "all goals are met, or one is out of reach"),
            ("stopped", "stopped", "the user stopped it, or a signal did"),
            ("gave-up", "sensor lost", "no sample came for as long as one was to be waited for"),
            ("wall-time", "wall time over", "it had taken as long by the clock as it was allowed to"),
            ("source-failed", "source failed", "reading failed; the result holds what came before"),
            ("other-message", "other message", "the sensor sent another message than the measured one"),
            ("other-rate", "other rate", "the sensor sent at another rate than that of the record"),
            ("no-measurement", "no measurement", "the sensor sent, and never a measurement"),
            ("not-started", "not started", "the source was not opened; nothing was measured"),
        ],
    ),
];
