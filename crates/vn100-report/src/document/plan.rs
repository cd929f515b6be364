//! The JSON document of a plan, schema `vn100.plan/1`: a contract with scripts.
//!
//! SI units (magnetic field in gauss); what is out of reach within 100 days is `null`.

use serde::Serialize;
use serde_json::{Value, json};
use vn100_analysis::noise::Term;
use vn100_analysis::{Datasheet, Given, Known, Plan, PlannedWant, SENSORS, axes_name};

/// The commands for what was planned, as a user types them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PlanCommands {
    /// The command that sets the sensor; `None` if the measuring command does that.
    pub configure: Option<String>,
    /// The command that measures.
    pub attach: String,
    /// The command that restores the settings; `None` if the measuring command does.
    pub undo: Option<String>,
}

/// The JSON document of `plan`; it has a length only if the plan was `asked` for a want.
pub fn plan_document(plan: &Plan, given: Given, datasheet: &Datasheet, asked: bool, commands: &PlanCommands) -> Value {
    let assumed = SENSORS.into_iter().map(|(_, sensor)| {
        let noise = datasheet.typical_noise(sensor);
        let of = |term| noise.iter().find(|(named, _)| *named == term).map(|(_, value)| *value);
        let (white, bias) = (of(Term::White), of(Term::BiasInstability));
        json!({ "sensor": axes_name(sensor), "white": white, "bias_instability": bias })
    });
    json!({
        "schema": "vn100.plan/1",
        "confidence": given.confidence,
        "met_in": Plan::MET_IN,
        "settings": {
            "message": plan.message.name(),
            "rate_hz": plan.rate_hz,
            "window": plan.window,
            "baud": plan.baud.bits_per_s(),
            "line_bytes": plan.frame_bytes,
        },
        "warm_up_s": plan.warm_up_s,
        "record_s": plan.record_s.filter(|_| asked),
        "wants": plan.wants.iter().map(want).collect::<Vec<_>>(),
        "datasheet": datasheet.name,
        "assumed": assumed.collect::<Vec<_>>(),
        "commands": commands,
    })
}

fn want(planned: &PlannedWant) -> Value {
    let (within, at_least, at_most) = match planned.want.known {
        Known::Seen => (None, None, None),
        Known::Within(half_width) => (Some(half_width), None, None),
        Known::AtLeast(value) => (None, Some(value), None),
        Known::AtMost(value) => (None, None, Some(value)),
    };
    json!({
        "want": planned.want.to_string(),
        "relative_half_width": within,
        "at_least": at_least,
        "at_most": at_most,
        "taken_at": planned.taken_at.map(|taken| taken.value),
        "record_s": planned.record_s,
        "without_bias_instability_s": planned.without_bias_instability_s,
    })
}
