//! Means and standard deviations of one sample, the axes of a sensor side by side.

use vn100_analysis::noise::STANDARD_GRAVITY_M_S2;
use vn100_analysis::protocol::{Channel, Quantity};
use vn100_analysis::{ChannelSnapshot, Snapshot};

use super::{AXES, StatisticsRow};
use crate::{
    measured::Record,
    names::{QUANTITIES, names_of},
    numbers::plain::signed,
    units::{ChannelValues, fitted},
};

/// Characters of a number.
const WIDTH: usize = 7;

pub(super) fn rows(record: &Record<'_>) -> Vec<StatisticsRow> {
    let mut rows = Vec::new();
    for quantity in QUANTITIES {
        for axes in record.of(quantity).chunks(AXES) {
            rows.extend(of_axes(quantity, axes, record));
        }
    }
    rows
}

fn of_axes(quantity: Quantity, axes: &[&ChannelValues], record: &Record<'_>) -> Vec<StatisticsRow> {
    let names = names_of(quantity);
    let (unit, factor, decimals) = match quantity {
        Quantity::AngularRate => ("deg/s", 180.0 / std::f64::consts::PI, 4),
        Quantity::Acceleration => ("m/s²", 1.0, 4),
        Quantity::MagneticField => ("gauss", 1.0, 4),
        Quantity::Angle => ("deg", 1.0, 4),
        Quantity::Temperature => ("°C", 1.0, 3),
        Quantity::Pressure => ("kPa", 1.0, 3),
        Quantity::Quaternion | Quantity::Value => ("", 1.0, 6),
    };
    let cells = |of: fn(&ChannelValues) -> Option<f64>| -> Vec<String> {
        let cell =
            |channel: &&ChannelValues| of(channel).map_or("-".into(), |value| fitted(value * factor, decimals, WIDTH));
        axes.iter().map(cell).collect()
    };
    let label = match axes {
        [only] if quantity == Quantity::Value => only.name.clone(),
        _ => names.short.to_owned(),
    };
    let row = |what: &str, cells, remark| StatisticsRow { label: format!("{label} {what}"), unit, cells, remark };
    let remark = remark(quantity, record);
    if matches!(quantity, Quantity::Temperature | Quantity::Pressure) {
        let both = [cells(|channel| channel.mean), cells(|channel| channel.std)].concat();
        return vec![row("mean, std", both, remark)];
    }
    // where an angle points says nothing of the sensor
    if matches!(quantity, Quantity::Angle | Quantity::Quaternion) {
        return vec![row("std", cells(|channel| channel.std), remark)];
    }
    vec![row("mean", cells(|channel| channel.mean), remark), row("std", cells(|channel| channel.std), String::new())]
}

/// The length of the mean vector, and how far gravity is from its standard value.
fn remark(quantity: Quantity, record: &Record<'_>) -> String {
    let length = record.norms.iter().find(|norm| norm.quantity == quantity).and_then(|norm| norm.of_mean);
    match (quantity, length) {
        (Quantity::Acceleration, Some(length)) => {
            let off_mg = 1e3 * (length / STANDARD_GRAVITY_M_S2 - 1.0);
            format!("norm {length:.4}, g {} mg", signed(off_mg, 1))
        }
        (Quantity::MagneticField, Some(length)) => format!("norm {length:.4}"),
        _ => String::new(),
    }
}

/// The mean temperature of the sensor as text, such as `24.3 °C`: of the samples, or else of what
/// was read from a register between them; `None` if neither has it.
#[must_use]
pub fn mean_temperature(snapshot: &Snapshot) -> Option<String> {
    let channels = snapshot.layout_channels();
    let streamed = channels.iter().zip(&snapshot.channels);
    let polled = snapshot.register_channels.iter().map(|polled| (&polled.channel, &polled.results));
    let mean = |(channel, results): (&Channel, &ChannelSnapshot)| {
        let mean = channel.in_unit(results.moments.mean_counts()?);
        (channel.quantity == Quantity::Temperature).then_some(mean)
    };
    streamed.chain(polled).find_map(mean).map(|mean_c| format!("{mean_c:.1} °C"))
}
