//! `vn100 plan`: how to set the sensor, and how long to measure, for what shall be known.

use anyhow::Result;
use vn100_analysis::{Given, Plan, Want};
use vn100_report::{PlanCommands, PlanDocument, vn100_datasheet};

use crate::{
    args::PlanArgs,
    datasheet,
    exit::{Exit, print, print_json},
    plan_steps::Steps,
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
        let Steps { configure, attach, undo, .. } = Steps::new(&plan, given, asked);
        let commands = PlanCommands { configure, attach, undo };
        print_json(&serde_json::to_string_pretty(&PlanDocument::new(&plan, given, &sheet, asked, commands))?)?;
    } else {
        print(&text::plan(&plan, given, &sheet, asked))?;
    }
    Ok(Exit::Good)
}
