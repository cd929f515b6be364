//! What was asked of a measurement, as a user would ask for it again: what a report says of it.

use std::{path::Path, time::Duration};

use vn100_analysis::AveragingTimes;

use crate::args::MeasureArgs;

/// Options, in the order in which they were added.
#[derive(Debug, Default)]
pub(crate) struct MeasureOptions(Vec<String>);

impl MeasureOptions {
    /// An option that is set, with its value; an empty one has none.
    pub(crate) fn add(&mut self, name: &str, value: Option<String>) {
        self.0.extend(
            value.map(|value| if value.is_empty() { format!("--{name}") } else { format!("--{name} {value}") }),
        );
    }

    pub(crate) fn text(&self) -> String {
        self.0.join(" ")
    }
}

fn flag(set: bool) -> Option<String> {
    set.then(String::new)
}

pub(crate) fn length(length: Duration) -> String {
    humantime::format_duration(length).to_string()
}

/// The options of every command that measures.
pub(crate) fn measure_options(measure: &MeasureArgs, taus: Option<&AveragingTimes>) -> MeasureOptions {
    let mut asked = MeasureOptions::default();
    asked.add("rate", measure.rate.map(|hz| hz.to_string()));
    asked.add("estimator", Some(format!("{:?}", measure.estimator).to_lowercase()));
    asked.add("taus", taus.map(ToString::to_string));
    asked.add("deviation", Some(format!("{:?}", measure.deviation).to_lowercase()));
    asked.add("skip", Some(length(measure.skip)).filter(|_| !measure.skip.is_zero()));
    asked.add("duration", measure.duration.map(length));
    for goal in &measure.until {
        asked.add("until", Some(format!("\"{goal}\"")));
    }
    asked.add("quantization", flag(measure.quantization));
    asked.add("confidence", measure.confidence.map(|level| level.to_string()));
    for figure in &measure.fail_on {
        asked.add("fail-on", Some(format!("\"{figure}\"")));
    }
    asked.add("typical-is-limit", flag(measure.typical_is_limit));
    // without its folder: a page says the same wherever the files lie
    let sheet = measure.datasheet.as_deref().and_then(Path::file_name);
    asked.add("datasheet", sheet.map(|name| name.to_string_lossy().into_owned()));
    asked.add("accept-unchecked", flag(measure.accept_unchecked));
    asked
}
