//! A result as text for people: a summary, or the head of a recording.

mod populations;
mod summary;

use std::fmt;

use imu_noise::{Sensor, Term};
use vn100_analysis::{SourceResult, letter};
use vn100_report::{
    facts,
    names::{ParameterNames, parameter_names},
    printable,
};

pub(crate) use populations::write_populations;
pub(crate) use summary::summary;
use vn100_report::{remedies::remedy_words, warnings::in_words};

/// Columns a line may take; what every terminal has.
pub(crate) const WIDTH: usize = 80;

/// What `write` puts into a text.
pub(crate) fn text(write: impl FnOnce(&mut String) -> fmt::Result) -> String {
    let mut out = String::new();
    // a String takes everything
    let _ = write(&mut out);
    out
}

pub(crate) fn fill(text: &str, first_indent: &str, indent: &str) -> String {
    let options = textwrap::Options::new(WIDTH).initial_indent(first_indent).subsequent_indent(indent);
    // an exponent stays with its number
    textwrap::fill(text, options.word_splitter(textwrap::WordSplitter::NoHyphenation))
}

/// Name, short name and symbol: `Angle Random Walk (ARW) N`.
pub(crate) fn parameter_name(sensor: Sensor, term: Term) -> String {
    let ParameterNames { name, short, .. } = parameter_names(sensor, term);
    let short = if short.is_empty() { String::new() } else { format!(" ({short})") };
    format!("{name}{short} {}", letter(term))
}

/// The samples of a recording, those missing, and their rate.
pub(crate) fn counts(result: &SourceResult) -> String {
    let timing = &result.timing;
    let missing = timing.missing.map_or("unknown".into(), |missing| missing.to_string());
    let rate = timing.rate_hz.map_or_else(String::new, |rate_hz| format!(", {rate_hz} Hz"));
    format!("{} samples, {missing} missing{rate}", timing.samples)
}

/// The source with its rate, counts and losses, and its warnings. Ends with a line feed.
pub(crate) fn head(result: &SourceResult) -> String {
    let message = result.source.message.as_deref().unwrap_or("no message");
    let mut out = format!("{}: {message}\n", printable(&result.source.name));
    for (name, value) in facts::timing(result).iter().filter(|(_, value)| value != facts::NOT_RECORDED) {
        out += &fill(value, &format!("  {name:<19}"), &" ".repeat(21));
        out.push('\n');
    }
    for warning in &result.warnings {
        let text =
            format!("{} ({}): {}", warning.kind.name(), warning.severity.name(), in_words(warning, remedy_words));
        out += &fill(&text, "! ", "  ");
        out.push('\n');
    }
    if let Some(first) = result.warnings.first() {
        out += &format!("  (`vn100 explain {}` explains a kind of warning)\n", first.kind.name());
    }
    out
}
