//! Whether the white noise of one sensor folds alike in two records.

use vn100_protocol::Quantity;

use super::Record;
use crate::Onboard;

/// What the sensor does to the channels of `quantity`; `None` where unknown.
pub(super) fn onboard(quantity: Quantity, record: &Record<'_>) -> Option<Onboard> {
    let layout = record.snapshot.layout.as_ref()?;
    let channel = layout.channels.iter().position(|channel| channel.quantity == quantity)?;
    record.assessment.channels.get(channel)?.onboard
}

/// Whether averaging and decimation make the same of its white noise in both. Where that
/// is unknown, they do at the same rate.
pub(super) fn fold_alike(quantity: Quantity, a: &Record<'_>, b: &Record<'_>) -> bool {
    match (onboard(quantity, a), onboard(quantity, b)) {
        (Some(a), Some(b)) => (a.white_factor() / b.white_factor() - 1.0).abs() < 0.01,
        _ => (a.snapshot.timing.rate_hz / b.snapshot.timing.rate_hz - 1.0).abs() < 1e-3,
    }
}
