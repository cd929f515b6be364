//! `vn100 plan`: how to set the sensor, and how long to measure, for what shall be known.

use anyhow::Result;
use imu_noise::Sensor;
use vn100_pipeline::{Given, Plan, Want};
use vn100_protocol::BaudRate;

use crate::{
    args::PlanArgs,
    datasheet,
    exit::{Exit, print, print_json},
    plan_document::PlanDocument,
    text,
};

/// What is usually wanted: the table for whoever asks for nothing in particular.
const USUAL: [&str; 13] = [
    "gyro N ±10%",
    "gyro N ±5%",
    "gyro N ±1%",
    "gyro B",
    "gyro B ±20%",
    "gyro K >= 1e-6",
    "gyro K >= 2e-7",
    "accel N ±5%",
    "accel N ±1%",
    "accel B",
    "accel B ±20%",
    "accel K >= 2e-5",
    "mag N ±5%",
];

pub(crate) fn plan(args: &PlanArgs) -> Result<Exit> {
    let given = Given { rate: args.rate, baud: args.baud, confidence: args.confidence };
    let asked = !args.want.is_empty();
    let wants = if asked {
        args.want.clone()
    } else {
        USUAL.iter().map(|want| want.parse()).collect::<Result<Vec<Want>, _>>()?
    };
    let sheet = args.datasheet.as_deref().map_or_else(datasheet::vn100, datasheet::open)?;
    let plan = Plan::new(&wants, given, &sheet)?;
    if args.json {
        print_json(&serde_json::to_string_pretty(&PlanDocument::new(&plan, given, &sheet, asked))?)?;
    } else {
        print(&text::plan(&plan, given, &sheet, asked))?;
    }
    Ok(Exit::Good)
}

/// By the names that wants have for them.
pub(crate) const SENSORS: [(&str, Sensor); 3] =
    [("gyro", Sensor::Gyroscope), ("accel", Sensor::Accelerometer), ("mag", Sensor::Magnetometer)];

/// The commands that do what was planned.
pub(crate) struct Steps {
    pub(crate) configure: String,
    pub(crate) attach: String,
    /// `attach` names a length; otherwise it says T.
    pub(crate) has_length: bool,
    /// Back to what a sensor is sold with.
    pub(crate) undo: String,
}

impl Steps {
    /// Of `plan`; with a length only if it was `asked` for something in particular that is within reach.
    pub(crate) fn new(plan: &Plan, given: Given, asked: bool) -> Self {
        let message = plan.message.header().unwrap_or_default();
        let (rate_hz, window) = (plan.rate.hz(), plan.window);
        // a speed that is given is the one the line has
        let changes_baud = given.baud.is_none() && plan.baud != BaudRate::DEFAULT;
        let set_baud =
            |baud: BaudRate| if changes_baud { format!(" --set-baud {}", baud.bits_per_s()) } else { String::new() };
        let length = plan.record_s.filter(|_| asked);
        let duration = length.map_or_else(|| "T".into(), |record_s| span(plan.warm_up_s + record_s, ""));
        Self {
            configure: format!(
                "vn100 configure PORT --set-message {message} --set-rate {rate_hz} --window {window}{} --count on",
                set_baud(plan.baud)
            ),
            attach: format!(
                "vn100 attach PORT --record rest.mcap --skip {} --duration {duration}",
                span(plan.warm_up_s, "")
            ),
            has_length: length.is_some(),
            undo: format!(
                "vn100 configure PORT --set-message VNYMR --set-rate 40 --window 4{} --count off",
                set_baud(BaudRate::DEFAULT)
            ),
        }
    }
}

/// A length of time in whole seconds, as "1 h 30 min" with `blank` as the blank; options take it without.
pub(crate) fn span(seconds: f64, blank: &str) -> String {
    let seconds = seconds.ceil().max(0.0) as u64;
    let parts = [(seconds / 86_400, "d"), (seconds / 3600 % 24, "h"), (seconds / 60 % 60, "min"), (seconds % 60, "s")];
    let parts: Vec<String> =
        parts.iter().filter(|(count, _)| *count > 0).map(|(count, unit)| format!("{count}{blank}{unit}")).collect();
    if parts.is_empty() { format!("0{blank}s") } else { parts.join(blank) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_are_said_and_read_back() {
        for (seconds, said) in [
            (0.0, "0 s"),
            (59.2, "1 min"),
            (1800.0, "30 min"),
            (5400.0, "1 h 30 min"),
            (354_601.0, "4 d 2 h 30 min 1 s"),
        ] {
            assert_eq!(span(seconds, " "), said);
            let option = humantime::parse_duration(&span(seconds, ""));
            assert_eq!(option.map(|duration| duration.as_secs_f64()), Ok(seconds.ceil()), "{said}");
        }
    }
}
