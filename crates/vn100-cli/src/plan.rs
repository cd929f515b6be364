//! `vn100 plan`: how to set the sensor, and how long to measure, for what shall be known.

use anyhow::Result;
use vn100_analysis::{Given, Plan, Want};
use vn100_protocol::BaudRate;
use vn100_report::{PlanCommands, PlanDocument, numbers::plain::span, vn100_datasheet};

use crate::{
    args::PlanArgs,
    datasheet,
    exit::{Exit, print, print_json},
    text,
};

/// What is usually wanted: the table where no goal is given.
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
    let sheet = args.datasheet.as_deref().map_or_else(|| Ok(vn100_datasheet()?), datasheet::open)?;
    let plan = Plan::new(&wants, given, &sheet)?;
    if args.json {
        let commands = commands(&plan, given, asked);
        print_json(&serde_json::to_string_pretty(&PlanDocument::new(&plan, given, &sheet, asked, commands))?)?;
    } else {
        print(&text::plan(&plan, given, &sheet, asked))?;
    }
    Ok(Exit::Good)
}

/// The commands that do what was planned; with a length only if it was `asked` for something in
/// particular that is within reach.
pub(crate) fn commands(plan: &Plan, given: Given, asked: bool) -> PlanCommands {
    let message = plan.message.header().unwrap_or_default();
    let (rate_hz, window) = (plan.rate.hz(), plan.window);
    // a baud rate that is given is the one the port has
    let changes_baud = given.baud.is_none() && plan.baud != BaudRate::DEFAULT;
    let set_baud =
        |baud: BaudRate| if changes_baud { format!(" --set-baud {}", baud.bits_per_s()) } else { String::new() };
    let length = plan.record_s.filter(|_| asked);
    let duration = length.map_or_else(|| "T".into(), |record_s| span(plan.warm_up_s + record_s, ""));
    PlanCommands {
        configure: format!(
            "vn100 configure PORT --set-message {message} --set-rate {rate_hz} --window {window}{} --count on",
            set_baud(plan.baud)
        ),
        attach: format!(
            "vn100 attach PORT --record rest.mcap --skip {} --duration {duration}",
            span(plan.warm_up_s, "")
        ),
        undo: format!(
            "vn100 configure PORT --set-message VNYMR --set-rate 40 --window 4{} --count off",
            set_baud(BaudRate::DEFAULT)
        ),
    }
}
