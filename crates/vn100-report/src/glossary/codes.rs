//! The codes of documents: verdicts, statuses, grades, and where rate, losses and window come from.

use vn100_analysis::noise::{Grade, Status, Verdict};
use vn100_analysis::{EndKind, MissingFrom, RateFrom, Remedy, Setting, WhyNoCoefficient, WindowFrom, Withheld};

use super::{Explanation, advice, plain};
use crate::codes::{
    Code, code_of_end, code_of_grade, code_of_missing, code_of_no_coefficient, code_of_rate, code_of_status,
    code_of_verdict, code_of_window, code_of_withheld,
};

/// The group of verdicts on figures of a data sheet.
pub(super) const VERDICTS: &str = "Verdicts";

pub(super) fn explanations() -> Vec<Explanation> {
    let mut all = Vec::new();
    all.extend(Status::ALL.map(|status| entry("Statuses of a parameter", code_of_status(status), of_status(status))));
    all.extend(Verdict::ALL.map(|verdict| entry(VERDICTS, code_of_verdict(verdict), of_verdict(verdict))));
    all.extend(Grade::ALL.map(|grade| entry("Grades of gyroscopes", code_of_grade(grade), GRADE)));
    all.extend(RateFrom::ALL.map(|from| entry("Origin of the rate (rate_from)", code_of_rate(from), of_rate(from))));
    all.extend(
        MissingFrom::ALL
            .map(|from| entry("Evidence of dropped samples (missing_from)", code_of_missing(from), of_missing(from))),
    );
    all.extend(
        WindowFrom::ALL
            .map(|from| entry("Origin of the averaging window (window_from)", code_of_window(from), of_window(from))),
    );
    all.extend(
        Withheld::ALL.map(|why| entry("Why B, K and R are only bounded (withheld)", code_of_withheld(why), WITHHELD)),
    );
    all.extend(WhyNoCoefficient::ALL.map(|why| {
        entry("No temperature coefficient (temperature.reason)", code_of_no_coefficient(why), NO_COEFFICIENT)
    }));
    all.extend(EndKind::ALL.map(|end| entry("Why a measurement ended (end_reason)", code_of_end(end), of_end(end))));
    all
}

/// Why it matters, what to do with places for the remedies, the remedies, and the source.
type Words = (&'static str, &'static str, &'static [Remedy], &'static str);

fn entry(group: &'static str, code: Code, (why, template, remedies, source): Words) -> Explanation {
    let mut letters = code.meaning.chars();
    let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    Explanation {
        group,
        code: code.code,
        // a word of verdicts may be that of several
        aliases: if plain(code.word) == code.code || group == VERDICTS { Vec::new() } else { vec![code.word] },
        title: code.word.into(),
        meaning: format!("{first}{}.", letters.as_str()),
        why,
        advice: advice(template, remedies),
        source,
    }
}

const INTERVALS: &str = "IEEE Std 952-1997, annex C (model); NIST SP 1065 (intervals)";

const fn of_status(status: Status) -> Words {
    match status {
        Status::Estimated => (
            "It is significantly above zero, and the interval has the stated confidence.",
            "Use the value; its interval is its uncertainty.",
            &[],
            INTERVALS,
        ),
        Status::Bounded => (
            "The upper bound is no estimate: the true value may be far below it.",
            "Compare the bound with the limit. For an estimate record longer; {} says how long.",
            &[Remedy::Plan],
            INTERVALS,
        ),
        Status::NotObservable => (
            "Other noise covers it at all averaging times of this record.",
            "Record longer; {} says how long.",
            &[Remedy::Plan],
            INTERVALS,
        ),
        Status::NotMeasurable => (
            "An attitude filter has removed it, or the ambient field covers it: what the curve shows at long averaging times is not the \
             sensor's.",
            "For B and K of a gyroscope measure the uncompensated message: {}.",
            &[Remedy::MeasureWith(Setting::Message("VNIMU"))],
            INTERVALS,
        ),
        Status::Moved => (
            "The motion is larger than the noise at all averaging times: no number of the record is a noise parameter.",
            "Record the sensor at rest, or exclude the time in which it moved ({}, {}).",
            &[Remedy::Skip(None), Remedy::EndEarlier],
            "",
        ),
        Status::ModelRejected => (
            "The record contains something that is not noise of the model, such as vibration or a step.",
            "Read the warnings for the cause, exclude the disturbed part ({}, {}), or record again.",
            &[Remedy::Skip(None), Remedy::EndEarlier],
            INTERVALS,
        ),
    }
}

const DECISION: &str = "JCGM 106:2012 (decision rule: guarded by the whole interval)";

const fn of_verdict(verdict: Verdict) -> Words {
    match verdict {
        Verdict::Pass => ("The limit is met with the confidence of the interval.", "Accept.", &[], DECISION),
        Verdict::Fail => (
            "The limit is exceeded with the confidence of the interval.",
            "Read the warnings first: a disturbed record fails too. Then repeat the measurement, and reject the unit.",
            &[],
            DECISION,
        ),
        Verdict::Typical => (
            "Typical figures are not guaranteed, and not limits.",
            "Nothing. Treat typical figures as limits with {}.",
            &[Remedy::TypicalIsLimit],
            DECISION,
        ),
        Verdict::AboveTypical => (
            "Noisier than many units, and within what the maker guarantees, because typical figures guarantee nothing.",
            "Look for vibration and aliasing. Treat typical figures as limits with {}.",
            &[Remedy::TypicalIsLimit],
            DECISION,
        ),
        Verdict::BelowTypical => (
            "Quieter than many units; where it is far below, a filter may be in the way.",
            "Check that the stream is not filtered or compensated.",
            &[],
            DECISION,
        ),
        Verdict::Inconclusive => (
            "Neither pass nor fail has the requested confidence.",
            "Record longer: the interval narrows. {} says how long.",
            &[Remedy::Plan],
            DECISION,
        ),
        Verdict::Consistent => (
            "Not decidable: the effect of the stream on the figure is unknown, and may be larger than the difference.",
            "State what is missing, mostly the averaging window ({}) or the rate ({}).",
            &[Remedy::GiveWindow, Remedy::GiveRate(None)],
            DECISION,
        ),
        Verdict::Undecided => (
            "Not decidable: there is no interval, or the stream may explain why it is beyond the figure.",
            "Record longer, and state the averaging window ({}).",
            &[Remedy::GiveWindow],
            DECISION,
        ),
        Verdict::NotComparable => (
            "A filter, the ambient field or the message hides the parameter.",
            "For B and K of a gyroscope measure the uncompensated message: {}.",
            &[Remedy::MeasureWith(Setting::Message("VNIMU"))],
            DECISION,
        ),
    }
}

const GRADE: Words = (
    "A rough class for choosing sensors: the worse of the classes by B and by N. No standard defines these limits.",
    "Compare parameters with the needs of the application, not classes.",
    &[],
    "",
);

const fn of_rate(from: RateFrom) -> Words {
    const MATTERS: &str =
        "All averaging times and densities rest on the rate: 1 % of it is 1 % of every tau and 0.5 % of N.";
    match from {
        RateFrom::Option => (MATTERS, "Nothing, if the sensor was set to it.", &[], ""),
        RateFrom::DeviceTime => (MATTERS, "Nothing.", &[], "VectorNav VN-100 User Manual, TimeStartup"),
        RateFrom::Device => (MATTERS, "Nothing.", &[], "VectorNav VN-100 User Manual, register 7"),
        RateFrom::Arrival => (MATTERS, "Nothing; state another rate with {}.", &[Remedy::GiveRate(None)], ""),
        RateFrom::Assumed => (MATTERS, "Set {} if the sensor did not run at 40 Hz.", &[Remedy::GiveRate(None)], ""),
    }
}

const fn of_missing(from: MissingFrom) -> Words {
    const MATTERS: &str =
        "Undetected dropped samples move all later samples in time, which distorts long averaging times.";
    match from {
        MissingFrom::DeviceTime => (MATTERS, "Nothing.", &[], "VectorNav VN-100 User Manual, TimeStartup"),
        MissingFrom::Counter => (MATTERS, "Nothing.", &[], "VectorNav VN-100 User Manual, register 30"),
        MissingFrom::Arrival => (MATTERS, "For exact counts let the sensor append its counter.", &[], ""),
        MissingFrom::RejectedRows => {
            (MATTERS, "Record with arrival times ({}), or let the sensor append its counter.", &[Remedy::Record], "")
        }
    }
}

const fn of_window(from: WindowFrom) -> Words {
    const MATTERS: &str = "The window decides how much noise aliases, and so how N relates to the data sheet.";
    const REGISTER: &str = "VectorNav VN-100 User Manual, register 85";
    match from {
        WindowFrom::Integrated => (MATTERS, "Nothing.", &[], "VectorNav VN-100 User Manual, register 80"),
        WindowFrom::Register | WindowFrom::Given => (MATTERS, "Nothing.", &[], REGISTER),
        WindowFrom::Default => (
            MATTERS,
            "State it with {}, or record with this program, which reads the register.",
            &[Remedy::GiveWindow],
            REGISTER,
        ),
    }
}

const WITHHELD: Words = (
    "Bias instability and random walk fitted to a drift of another cause would be too large.",
    "Keep the sensor at rest and at an even temperature, and leave its warm-up out ({}); a longer record distinguishes a cycle from a walk.",
    &[Remedy::Skip(None)],
    "",
);

const NO_COEFFICIENT: Words = (
    "Without a coefficient it is not known how much of the drift is temperature.",
    "Record the uncompensated message with its temperature ({}) through a change of several degrees, up and down.",
    &[Remedy::ReadTemperature],
    "",
);

const fn of_end(end: EndKind) -> Words {
    const WHOLE: &str = "The result holds all that was to be measured.";
    const PART: &str = "The result holds what came before, and its intervals are valid for that.";
    match end {
        EndKind::EndOfInput | EndKind::Duration | EndKind::Goals => (WHOLE, "Nothing.", &[], ""),
        EndKind::Stopped | EndKind::WallTime => (PART, "Measure longer where the record is too short.", &[], ""),
        EndKind::GaveUp => (
            PART,
            "Check cable, adapter, hub and supply of the sensor, and the power saving of the computer. A recording can be resumed.",
            &[],
            "",
        ),
        EndKind::SourceFailed => (PART, "Read the error: it names what failed.", &[], ""),
        EndKind::OtherMessage | EndKind::OtherRate => (
            PART,
            "The sensor has lost settings that were not saved, as by a restart: set them again ({}), and save them.",
            &[Remedy::Configure(Setting::Message("VNIMU"))],
            "",
        ),
        EndKind::NoMeasurement => (
            "There is no result.",
            "Set a message that is measured: {}.",
            &[Remedy::Configure(Setting::Message("VNIMU"))],
            "",
        ),
        EndKind::NotStarted => ("There is no result.", "Read the error: it names what failed.", &[], ""),
    }
}
