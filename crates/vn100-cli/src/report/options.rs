//! The options of a report, as on a command line.

use std::{path::Path, time::Duration};

use crate::args::ReportArgs;

/// The options that repeat the measurement.
pub(super) fn option_text(args: &ReportArgs) -> String {
    let measure = &args.files.measure;
    let mut words: Vec<String> = Vec::new();
    let mut option = |name: &str, value: Option<String>| {
        words.extend(
            value.map(|value| if value.is_empty() { format!("--{name}") } else { format!("--{name} {value}") }),
        );
    };
    let flag = |set: bool| set.then(String::new);
    let length = |length: Duration| humantime::format_duration(length).to_string();
    option("rate", measure.rate.map(|hz| hz.to_string()));
    option("estimator", Some(format!("{:?}", measure.estimator).to_lowercase()));
    option("deviation", Some(format!("{:?}", measure.deviation).to_lowercase()));
    option("skip", Some(length(measure.skip)).filter(|_| !measure.skip.is_zero()));
    option("duration", measure.duration.map(length));
    for goal in &measure.until {
        option("until", Some(format!("\"{goal}\"")));
    }
    option("detrend", measure.detrend.map(|_| "linear".into()));
    option("quantization", flag(measure.quantization));
    option("confidence", measure.confidence.map(|level| level.to_string()));
    for figure in &measure.fail_on {
        option("fail-on", Some(format!("\"{figure}\"")));
    }
    // without its folder: the page says the same wherever the files lie
    let sheet = measure.datasheet.as_deref().and_then(Path::file_name);
    option("datasheet", sheet.map(|name| name.to_string_lossy().into_owned()));
    option("filter-models", flag(args.filter_models));
    option("accept-unchecked", flag(measure.accept_unchecked));
    words.join(" ")
}
