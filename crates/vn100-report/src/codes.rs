//! The codes of documents: the word for each code in text and pages, and its meaning, as
//! `docs/words.md` lists them.

use serde::Serialize;
use serde_json::Value;
use vn100_analysis::noise::{Grade, NoCoefficient, Status, Term, Verdict};
use vn100_analysis::{DecidedBy, EndKind, MissingFrom, RateFrom, WhyNoCoefficient, WindowFrom, Withheld};

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
    let verdicts = Verdict::ALL.map(code_of_verdict).into_iter();
    let decided = DecidedBy::ALL.map(code_of_decided).into_iter();
    let statuses = Status::ALL.map(code_of_status).into_iter();
    let grades = Grade::ALL.map(code_of_grade).into_iter();
    let rates = RateFrom::ALL.map(code_of_rate).into_iter();
    let missing = MissingFrom::ALL.map(code_of_missing).into_iter();
    let windows = WindowFrom::ALL.map(code_of_window).into_iter();
    let withheld = Withheld::ALL.map(code_of_withheld).into_iter();
    let no_coefficients = WhyNoCoefficient::ALL.map(code_of_no_coefficient).into_iter();
    let ends = EndKind::ALL.map(code_of_end).into_iter();
    let origins = rates.chain(missing).chain(windows).chain(withheld).chain(no_coefficients);
    verdicts.chain(decided).chain(statuses).chain(grades).chain(origins).chain(ends).collect()
}

/// Why the slow terms of an axis are no more than bounded.
#[must_use]
pub(crate) const fn code_of_withheld(why: Withheld) -> Code {
    let (name, word, meaning) = match why {
        Withheld::LevelChange => ("level-change", "level change", "a warm-up, a step or a cycle poses as them"),
        Withheld::Temperature => ("temperature", "temperature", "what follows the temperature poses as them"),
        Withheld::MayBeCycle => {
            ("perhaps-cycle", "perhaps a cycle", "a cycle of the level explains the record about as well as they do")
        }
        Withheld::MayBeWarmUp => (
            "perhaps-warm-up",
            "perhaps a warm-up",
            "a level that settles from the start on explains the record about as well as they do",
        ),
        Withheld::MayBeProcess => (
            "perhaps-correlated",
            "perhaps correlated noise",
            "noise that is correlated over a small part of the record explains it about as well as they do",
        ),
    };
    code("withheld", name, word, meaning)
}

/// Why there is no temperature coefficient.
#[must_use]
pub(crate) const fn code_of_no_coefficient(why: WhyNoCoefficient) -> Code {
    let meaning = match why {
        WhyNoCoefficient::Moved => "the sensor was moved",
        WhyNoCoefficient::BiasNotInStream => "a filter removes the bias before the sensor sends the samples",
        WhyNoCoefficient::Constant => "the values do not vary",
        WhyNoCoefficient::Temperature(NoCoefficient::TooShort { .. }) => {
            "fewer than 32 consecutive blocks have samples and a temperature"
        }
        WhyNoCoefficient::Temperature(NoCoefficient::Excursion { .. }) => "the temperature changed by less than 1 °C",
        WhyNoCoefficient::Temperature(NoCoefficient::OneDirection { .. }) => {
            "the temperature only rose or only fell, so that any other drift would look the same"
        }
    };
    let name = why.code();
    code("temperature.reason", name, name, meaning)
}

const fn code(key: &'static str, code: &'static str, word: &'static str, meaning: &'static str) -> Code {
    Code { key, code, word, meaning }
}

/// A verdict on a figure of a data sheet.
#[must_use]
pub(crate) fn code_of_verdict(verdict: Verdict) -> Code {
    let of = |name, word, meaning| code("verdict", name, word, meaning);
    match verdict {
        Verdict::Pass => {
            of("pass", "pass", "the whole interval lies within the limit, even with all that is not known of it")
        }
        Verdict::Fail => {
            of("fail", "fail", "the whole interval lies beyond the limit, even with all that is not known of it")
        }
        Verdict::Undecided => of(
            "undecided",
            "undecided",
            "the interval spans the limit, or what is not known; decided_by names what would decide",
        ),
        Verdict::NotComparable => of("not-comparable", "not comparable", "the message does not carry the parameter"),
    }
}

/// What would decide an open verdict.
#[must_use]
pub(crate) const fn code_of_decided(by: DecidedBy) -> Code {
    let (name, word, meaning) = match by {
        DecidedBy::Rate => ("rate", "a known sample rate", "the sample rate is assumed"),
        DecidedBy::Window => (
            "window",
            "a known averaging window",
            "the stream does not contain how the sensor averages, and so how much aliases",
        ),
        DecidedBy::Convention => (
            "convention",
            "a sheet that says whether its density is one-sided",
            "a one-sided density is √2 times the two-sided one, and the value lies between both readings",
        ),
        DecidedBy::Unaliased => (
            "unaliased",
            "a stream without aliasing",
            "how much aliasing raises the value is known to 10 %, and the value lies within that of the limit",
        ),
        DecidedBy::LongerRecord => (
            "longer-record",
            "a longer record",
            "the interval spans the limit, or there is none; it narrows with the record",
        ),
        DecidedBy::Nothing => (
            "nothing",
            "nothing",
            "the parameter is so near to the limit that 100 days of the noise in this record do not decide",
        ),
    };
    code("decided_by", name, word, meaning)
}

/// What is known of a parameter.
#[must_use]
pub(crate) const fn code_of_status(status: Status) -> Code {
    const fn of(name: &'static str, word: &'static str, meaning: &'static str) -> Code {
        code("status", name, word, meaning)
    }
    match status {
        Status::Estimated => {
            of("estimated", "estimated", "the term was detected; it has a value and a two-sided confidence interval")
        }
        Status::Bounded => {
            of("bounded", "upper bound", "the term was not detected and may be zero; only its upper bound is given")
        }
        Status::NotObservable => {
            of("not-observable", "not observable", "the record does not show it, mostly because it is too short")
        }
        Status::NotMeasurable => {
            of("not-measurable", "not measurable", "the message does not carry it, however long the record")
        }
        Status::Moved => of(
            "moved",
            "sensor moved",
            "the sensor was moved, and what its deviation shows is the motion; a record at rest shows the parameter",
        ),
        Status::ModelRejected => of(
            "model-rejected",
            "model rejected",
            "no range of averaging times follows the noise model; N may still have an upper bound",
        ),
    }
}

/// A class of gyroscopes.
#[must_use]
pub(crate) fn code_of_grade(grade: Grade) -> Code {
    let of = |name, meaning| code("grade", name, name, meaning);
    match grade {
        Grade::Navigation => {
            of("navigation", "B below 0.01 deg/h and N below 0.002 deg/sqrt(h); no standard defines these")
        }
        Grade::Tactical => of("tactical", "B below 1 deg/h and N below 0.05 deg/sqrt(h)"),
        Grade::Industrial => of("industrial", "B below 30 deg/h and N below 0.5 deg/sqrt(h)"),
        Grade::Consumer => of("consumer", "B or N above the industrial limits"),
    }
}

/// The code for the source of the sample rate.
#[must_use]
pub(crate) fn code_of_rate(from: RateFrom) -> Code {
    let of = |name, word, meaning| code("rate_from", name, word, meaning);
    match from {
        RateFrom::Option => of("option", "as given", "given by the user"),
        RateFrom::DeviceTime => {
            of("device-time", "from device time", "each packet carries the time at which the sensor measured it")
        }
        RateFrom::Device => {
            of("device", "as reported by the sensor", "the sensor reported its output rate (register 07)")
        }
        RateFrom::Arrival => {
            of("arrival", "from arrival times", "the nominal rate of the sensor that the arrival times match")
        }
        RateFrom::Assumed => of("assumed", "assumed", "unknown: the factory default of 40 Hz"),
    }
}

/// The code for the evidence of dropped samples.
#[must_use]
pub(crate) fn code_of_missing(from: MissingFrom) -> Code {
    let of = |name, word, meaning| code("missing_from", name, word, meaning);
    match from {
        MissingFrom::DeviceTime => of(
            "device-time",
            "device time",
            "each packet carries the time at which the sensor measured it, so that dropped ones are counted exactly",
        ),
        MissingFrom::Counter => {
            of("counter", "row counter", "the sensor counts its samples, so that dropped ones are counted exactly")
        }
        MissingFrom::Arrival => of("arrival", "arrival times", "gaps in the arrival times"),
        MissingFrom::RejectedRows => of(
            "bad-lines",
            "rejected lines",
            "each rejected line counts as one dropped sample; entirely missing lines are not detected",
        ),
    }
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

/// Where the averaging window comes from.
#[must_use]
pub(crate) fn code_of_window(from: WindowFrom) -> Code {
    let of = |name, word, meaning| code("window_from", name, word, meaning);
    match from {
        WindowFrom::Register => of("register", "register 85", "the capture contains register 85"),
        WindowFrom::Given => of("option", "as given", "the user gave the value of register 85"),
        WindowFrom::Integrated => {
            of("integrated", "whole interval", "the sensor sends integrals over the interval between rows")
        }
        WindowFrom::Default => {
            of("default", "factory default", "unknown: the factory default, which may have been changed")
        }
    }
}

/// Why a measurement ended.
#[must_use]
pub(crate) const fn code_of_end(end: EndKind) -> Code {
    let (name, word, meaning) = match end {
        EndKind::EndOfInput => ("end-of-input", "end of the data", "all data was read"),
        EndKind::Duration => ("duration", "duration reached", "the data time asked for has passed"),
        EndKind::Goals => ("goals", "goals decided", "all goals are met, or one is out of reach"),
        EndKind::Stopped => ("stopped", "stopped", "the user stopped it, or a signal did"),
        EndKind::GaveUp => ("gave-up", "sensor lost", "no sample came for as long as one was to be waited for"),
        EndKind::WallTime => ("wall-time", "wall time over", "it had taken as long by the clock as it was allowed to"),
        EndKind::SourceFailed => {
            ("source-failed", "source failed", "reading failed; the result holds what came before")
        }
        EndKind::OtherMessage => {
            ("other-message", "other message", "the sensor sent another message than the measured one")
        }
        EndKind::OtherRate => ("other-rate", "other rate", "the sensor sent at another rate than that of the record"),
        EndKind::NoMeasurement => ("no-measurement", "no measurement", "the sensor sent, and never a measurement"),
        EndKind::NotStarted => ("not-started", "not started", "the source was not opened; nothing was measured"),
    };
    code("end_reason", name, word, meaning)
}
