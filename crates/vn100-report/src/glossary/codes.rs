//! The codes of documents: why they matter and what to do, most of them as a group.

use vn100_analysis::{Remedy, Setting};

use super::Explanation;
use crate::codes::{Code, all_codes};

pub(super) fn explanations() -> Vec<Explanation> {
    all_codes().into_iter().map(entry).collect()
}

fn entry(Code { key, code, word, meaning }: Code) -> Explanation {
    let (group, source) = group(key);
    let (why, advice, remedies) = words(key, &code);
    let title = word.map_or_else(|| code.replace('-', " "), str::to_owned);
    Explanation { group, code, aliases: word.into_iter().collect(), title, meaning, why, advice, remedies, source }
}

/// Why a code matters, what to do, and the remedies.
fn words(key: &str, code: &str) -> (&'static str, &'static str, &'static [Remedy]) {
    match (key, code) {
        ("status", "estimated") => ("The interval has the stated confidence.", "Use the value.", &[]),
        ("status", "moved" | "model-rejected") => (
            "The motion or the disturbance is larger than the noise at the averaging times that would show it.",
            "Read the warnings for the cause, and record at rest.",
            &[Remedy::Skip(None), Remedy::EndEarlier],
        ),
        ("status", "not-measurable") => (
            "An attitude filter has removed it, or the ambient field covers it: what the curve shows there is not the sensor's.",
            "For B and K of a gyroscope measure the uncompensated message.",
            &[Remedy::MeasureWith(Setting::Message("VNIMU"))],
        ),
        ("status", "not-observable") => (
            "The record is too short for it, or other noise hides all of it: it has neither value nor bound.",
            "Record longer, or without what hides it.",
            &[Remedy::Plan],
        ),
        ("status", _) => (
            "Other noise covers it at the averaging times of this record: it may be far below a bound.",
            "Compare the bound with the limit, or record longer.",
            &[Remedy::Plan],
        ),
        ("verdict", _) => (
            "A limit is decided with the confidence of the whole interval; typical figures are no guarantee, and have a ratio.",
            "Read the warnings before a unit is rejected: a disturbed record fails too.",
            &[Remedy::Plan, Remedy::TypicalIsLimit],
        ),
        ("decided_by", _) => (
            "Without it the verdict stays open, however the rest is known.",
            "Say what is not known of the stream or the sheet, average 800/rate refreshes so that nothing aliases, or record longer. A parameter that nothing decides \
             lies at the limit.",
            &[Remedy::GiveRate(None), Remedy::GiveWindow, Remedy::Plan],
        ),
        ("grade", _) => (
            "A rough class for choosing sensors: the worse of the classes by B and by N.",
            "Compare parameters with the needs of the application, not classes.",
            &[],
        ),
        ("rate_from", _) => (
            "All averaging times and densities rest on the rate: 1 % of it is 1 % of every tau and 0.5 % of N.",
            "Give the rate if this one is wrong.",
            &[Remedy::GiveRate(None)],
        ),
        ("missing_from", _) => (
            "Undetected dropped samples move all later samples in time, which distorts long averaging times.",
            "For exact counts let the sensor append its counter, or measure packets with its time.",
            &[Remedy::Record],
        ),
        ("window_from", _) => (
            "The window decides how much noise aliases, and so how N relates to the data sheet.",
            "A recording of this program holds the register.",
            &[Remedy::GiveWindow],
        ),
        ("withheld", _) => (
            "Bias instability and random walk fitted to a drift of another cause would be too large.",
            "Keep the sensor at rest and at an even temperature; a longer record distinguishes a cycle from a walk.",
            &[Remedy::Skip(None)],
        ),
        ("temperature.reason", _) => (
            "Without a coefficient it is not known how much of the drift is temperature.",
            "Record the uncompensated message with its temperature through a change of several degrees, up and down.",
            &[Remedy::ReadTemperature],
        ),
        ("end_reason", "end-of-input" | "duration" | "goals") => {
            ("The result holds all that was to be measured.", "Nothing.", &[])
        }
        ("end_reason", "no-measurement" | "not-started") => {
            ("There is no result.", "Read the error: it names what failed.", &[])
        }
        ("end_reason", "stopped" | "wall-time") => (
            "The result holds what came before, and its intervals are valid for that.",
            "Measure longer if it is too short.",
            &[],
        ),
        _ => (
            "The result holds what came before, and its intervals are valid for that.",
            "Check cable, adapter and supply of the sensor. After a restart set it again, and save the settings.",
            &[],
        ),
    }
}

/// The title of the codes under a key, and the standard or manual that defines them.
fn group(key: &str) -> (&'static str, &'static str) {
    const MANUAL: &str = "VectorNav VN-100 User Manual, registers 7, 30, 80 and 85";
    match key {
        "status" => ("Statuses of a parameter", "IEEE Std 952-1997, annex C (model); NIST SP 1065 (intervals)"),
        "verdict" => ("Verdicts", "JCGM 106:2012 (decision rule: guarded by the whole interval)"),
        "decided_by" => ("What would decide a verdict (decided_by)", ""),
        "grade" => ("Grades of gyroscopes", ""),
        "rate_from" => ("Origin of the rate (rate_from)", MANUAL),
        "missing_from" => ("Evidence of dropped samples (missing_from)", MANUAL),
        "window_from" => ("Origin of the averaging window (window_from)", MANUAL),
        "withheld" => ("Why B, K and R are only bounded (withheld)", ""),
        "temperature.reason" => ("No temperature coefficient (temperature.reason)", ""),
        _ => ("Why a measurement ended (end_reason)", ""),
    }
}
