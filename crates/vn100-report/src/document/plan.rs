//! The JSON document of a plan, schema `vn100.plan/1`: a contract with scripts.
//!
//! SI units (magnetic field in gauss); what is out of reach within 100 days is `null`.

use serde::Serialize;
use vn100_analysis::noise::Term;
use vn100_analysis::{Datasheet, Given, Known, Plan, PlannedWant, SENSORS, axes_name};

/// The JSON document of a plan.
#[derive(Debug, Serialize)]
pub struct PlanDocument {
    schema: &'static str,
    confidence: f64,
    /// The share of records of the planned length that meet a want.
    met_in: f64,
    settings: SettingsDocument,
    /// Excluded at the beginning.
    warm_up_s: f64,
    /// Length behind it for all that was asked for.
    record_s: Option<f64>,
    wants: Vec<WantDocument>,
    /// The data sheet that gives the assumed noise of the sensor.
    datasheet: String,
    /// That noise, with B as the model has it.
    assumed: Vec<AssumedDocument>,
    commands: PlanCommands,
}

#[derive(Debug, Serialize)]
struct SettingsDocument {
    message: &'static str,
    rate_hz: u32,
    window: u32,
    baud: u32,
    line_bytes: u32,
}

#[derive(Debug, Serialize)]
struct WantDocument {
    want: String,
    relative_half_width: Option<f64>,
    at_least: Option<f64>,
    /// The limit that the verdict is on; of B, as the figure of the data sheet has it.
    at_most: Option<f64>,
    /// The assumed value of the sensor in the sense of the limit, if the want is one.
    taken_at: Option<f64>,
    record_s: Option<f64>,
    /// Of a random walk: without bias instability.
    without_bias_instability_s: Option<f64>,
    /// Of a random walk: 20 sqrt(3) N/K.
    by_rule_s: Option<f64>,
}

#[derive(Debug, Serialize)]
struct AssumedDocument {
    sensor: &'static str,
    white: Option<f64>,
    bias_instability: Option<f64>,
}

/// The commands for what was planned, as a user types them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PlanCommands {
    /// The command that sets the sensor; `None` if the measuring command does that.
    pub configure: Option<String>,
    /// The command that measures.
    pub attach: String,
    /// The command that restores the factory default; `None` if the measuring command restores
    /// the settings.
    pub undo: Option<String>,
}

impl PlanDocument {
    /// The document of `plan`; it has a length only if the plan was `asked` for a want.
    #[must_use]
    pub fn new(plan: &Plan, given: Given, datasheet: &Datasheet, asked: bool, commands: PlanCommands) -> Self {
        let assumed = SENSORS.into_iter().map(|(_, sensor)| {
            let noise = datasheet.typical_noise(sensor);
            let of = |term| noise.iter().find(|(named, _)| *named == term).map(|(_, value)| *value);
            AssumedDocument {
                sensor: axes_name(sensor),
                white: of(Term::White),
                bias_instability: of(Term::BiasInstability),
            }
        });
        Self {
            schema: "vn100.plan/1",
            confidence: given.confidence,
            met_in: Plan::MET_IN,
            settings: SettingsDocument {
                message: plan.message.name(),
                rate_hz: plan.rate_hz,
                window: plan.window,
                baud: plan.baud.bits_per_s(),
                line_bytes: plan.frame_bytes,
            },
            warm_up_s: plan.warm_up_s,
            record_s: plan.record_s.filter(|_| asked),
            wants: plan.wants.iter().map(want).collect(),
            datasheet: datasheet.name.clone(),
            assumed: assumed.collect(),
            commands,
        }
    }
}

fn want(planned: &PlannedWant) -> WantDocument {
    let (relative_half_width, at_least, at_most) = match planned.want.known {
        Known::Seen => (None, None, None),
        Known::Within(half_width) => (Some(half_width), None, None),
        Known::AtLeast(value) => (None, Some(value), None),
        Known::AtMost(value) => (None, None, Some(value)),
    };
    WantDocument {
        want: planned.want.to_string(),
        relative_half_width,
        at_least,
        at_most,
        taken_at: planned.taken_at.map(|taken| taken.value),
        record_s: planned.record_s,
        without_bias_instability_s: planned.without_bias_instability_s,
        by_rule_s: planned.by_rule_s,
    }
}
