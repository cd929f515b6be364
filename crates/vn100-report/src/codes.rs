//! The codes of documents: the word for each in text and pages, and what it means. The project's
//! documentation has them as a table.

use vn100_analysis::noise::{Grade, NoCoefficient, Status, Verdict};
use vn100_analysis::{AxisTemperature, MissingFrom, RateFrom, WhyNoCoefficient, WindowFrom};

/// A code of documents.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// The key it is a value of.
    pub key: &'static str,
    /// Itself.
    pub code: &'static str,
    /// The word for it in text and pages.
    pub word: &'static str,
    /// What that means, in a sentence without its full stop.
    pub meaning: &'static str,
}

/// All codes, verdicts first.
#[must_use]
pub fn all_codes() -> Vec<Code> {
    let verdicts = Verdict::ALL.map(code_of_verdict).into_iter();
    let statuses = Status::ALL.map(code_of_status).into_iter();
    let grades = Grade::ALL.map(code_of_grade).into_iter();
    let rates = RateFrom::ALL.map(code_of_rate).into_iter();
    let missing = MissingFrom::ALL.map(code_of_missing).into_iter();
    let windows = WindowFrom::ALL.map(code_of_window).into_iter();
    let no_coefficients = WhyNoCoefficient::ALL.map(code_of_no_coefficient).into_iter();
    verdicts.chain(statuses).chain(grades).chain(rates).chain(missing).chain(windows).chain(no_coefficients).collect()
}

/// What is known of a temperature coefficient.
pub(crate) const fn status_of_temperature(temperature: &AxisTemperature) -> Status {
    match temperature.coefficient {
        Ok(_) => Status::Estimated,
        Err(WhyNoCoefficient::BiasNotInStream) => Status::NotMeasurable,
        Err(_) => Status::NotObservable,
    }
}

/// Why there is no temperature coefficient.
#[must_use]
pub const fn code_of_no_coefficient(why: WhyNoCoefficient) -> Code {
    let (name, meaning) = match why {
        WhyNoCoefficient::Moved => ("moved", "the sensor was moved"),
        WhyNoCoefficient::BiasNotInStream => {
            ("bias-not-in-stream", "a filter takes the bias out before the stream has it")
        }
        WhyNoCoefficient::Constant => ("constant", "the values do not vary"),
        WhyNoCoefficient::Temperature(NoCoefficient::TooShort { .. }) => {
            ("too-short", "fewer than 32 blocks with samples and temperature lie behind one another")
        }
        WhyNoCoefficient::Temperature(NoCoefficient::Excursion { .. }) => {
            ("excursion", "the temperature changed by less than 1 °C")
        }
        WhyNoCoefficient::Temperature(NoCoefficient::OneDirection { .. }) => {
            ("one-direction", "the temperature only rose or only fell: a drift of any other cause would look the same")
        }
    };
    code("temperature.reason", name, name, meaning)
}

const fn code(key: &'static str, code: &'static str, word: &'static str, meaning: &'static str) -> Code {
    Code { key, code, word, meaning }
}

/// A verdict on a figure of a data sheet.
#[must_use]
pub fn code_of_verdict(verdict: Verdict) -> Code {
    let of = |name, word, meaning| code("verdict", name, word, meaning);
    match verdict {
        Verdict::Pass => of(
            "pass",
            "pass",
            "the whole interval lies within the limit, the uncertainty of aliasing counted against it",
        ),
        Verdict::Fail => {
            of("fail", "fail", "the whole interval lies beyond the limit, and nothing that the stream does explains it")
        }
        Verdict::Typical => {
            of("typical", "typical", "the upper end of the interval lies within what is typical, which is no guarantee")
        }
        Verdict::AboveTypical => of(
            "above-typical",
            "above typical",
            "the whole interval lies above what is typical, which is no guarantee and fails nothing",
        ),
        Verdict::BelowTypical => of(
            "below-typical",
            "below typical",
            "the whole interval lies below what is typical: better than many sensors",
        ),
        Verdict::Inconclusive => of(
            "inconclusive",
            "inconclusive",
            "the interval spans the limit, or the upper end of what is typical; a longer record may decide",
        ),
        Verdict::Consistent => of(
            "consistent",
            "consistent",
            "nothing speaks against the figure, and what would decide is not known: averaging window, rate, a line removed, or whether the density is one- or two-sided",
        ),
        Verdict::Undecided => of(
            "undecided",
            "undecided",
            "there is no interval, or it lies beyond the figure and what the stream does to it is not known",
        ),
        Verdict::NotComparable => of("not-comparable", "not comparable", "the stream does not carry the parameter"),
    }
}

/// What is known of a parameter.
#[must_use]
pub const fn code_of_status(status: Status) -> Code {
    const fn of(name: &'static str, word: &'static str, meaning: &'static str) -> Code {
        code("status", name, word, meaning)
    }
    match status {
        Status::Estimated => {
            of("estimated", "estimated", "the parameter is there, and has a value and a two-sided interval")
        }
        Status::Bounded => {
            of("bounded", "at most", "it was not detected and may be zero; it is not above the upper bound")
        }
        Status::NotObservable => {
            of("not-observable", "not observable", "the record does not show it, mostly for its length")
        }
        Status::NotMeasurable => {
            of("not-measurable", "not measurable", "the stream does not carry it, however long the record")
        }
        Status::ModelRejected => of(
            "model-rejected",
            "no model fits",
            "no range of averaging times follows the noise model; N may have a bound by the curve all the same",
        ),
    }
}

/// A class of gyroscopes.
#[must_use]
pub fn code_of_grade(grade: Grade) -> Code {
    let of = |name, meaning| code("grade", name, name, meaning);
    match grade {
        Grade::Navigation => {
            of("navigation", "B below 0.01 deg/h and N below 0.002 deg/sqrt(h); no standard defines these")
        }
        Grade::Tactical => of("tactical", "B below 1 deg/h and N below 0.05 deg/sqrt(h)"),
        Grade::Industrial => of("industrial", "B below 30 deg/h and N below 0.5 deg/sqrt(h)"),
        Grade::Consumer => of("consumer", "B or N above that of industrial"),
    }
}

/// Where the sample rate comes from.
#[must_use]
pub fn code_of_rate(from: RateFrom) -> Code {
    let of = |name, word, meaning| code("rate_from", name, word, meaning);
    match from {
        RateFrom::Option => of("option", "as asked", "the user gave it"),
        RateFrom::Device => of("device", "as the sensor says", "the sensor printed its output rate"),
        RateFrom::Arrival => {
            of("arrival", "by the arrival of its lines", "the arrival times show which of its rates it sends at")
        }
        RateFrom::Assumed => of("assumed", "assumed", "nothing shows it: the factory default of 40 Hz"),
    }
}

/// By which evidence missing samples were counted.
#[must_use]
pub fn code_of_missing(from: MissingFrom) -> Code {
    let of = |name, word, meaning| code("missing_from", name, word, meaning);
    match from {
        MissingFrom::Counter => {
            of("counter", "the counter in each line", "the sensor counts its samples, and losses are exact")
        }
        MissingFrom::Arrival => of("arrival", "arrival times", "gaps between arrival times"),
        MissingFrom::RejectedRows => {
            of("bad-lines", "bad lines", "each damaged line counts as one sample; lines lost whole are not seen")
        }
    }
}

/// Where the averaging window comes from.
#[must_use]
pub fn code_of_window(from: WindowFrom) -> Code {
    let of = |name, word, meaning| code("window_from", name, word, meaning);
    match from {
        WindowFrom::Register => of("register", "register 85", "register 85 stands in the stream"),
        WindowFrom::Given => of("option", "as given", "the user said what register 85 was"),
        WindowFrom::Default => {
            of("default", "factory default", "nothing shows it: the factory default, which may have been changed")
        }
    }
}
