//! The commands that do what was planned.

use vn100_analysis::{Given, Plan};
use vn100_protocol::BaudRate;
use vn100_report::numbers::plain::span;

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
    /// Of `plan`; with a length only if it was `asked` for something in particular that is within
    /// reach.
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
