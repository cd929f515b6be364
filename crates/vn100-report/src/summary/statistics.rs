//! Means and standard deviations of one sample, the axes of a sensor side by side.

use crate::numbers::plain::fitted;
use vn100_analysis::protocol::Quantity;
use vn100_analysis::{ChannelResult, SourceResult};

use super::{AXES, StatisticsRow};
use crate::names::{QUANTITIES, names_of};

/// Characters of a number.
const WIDTH: usize = 7;

pub(super) fn rows(result: &SourceResult) -> Vec<StatisticsRow> {
    let of_quantity = |quantity| {
        // what is read from registers beside a stream that has it would be the same sensor twice
        let streamed: Vec<_> = result.streamed().filter(|channel| channel.quantity == quantity).collect();
        let axes = if streamed.is_empty() { result.of(quantity) } else { streamed };
        axes.chunks(AXES).map(|axes| of_axes(quantity, axes, result)).collect::<Vec<_>>()
    };
    QUANTITIES.into_iter().flat_map(of_quantity).collect()
}

fn of_axes(quantity: Quantity, axes: &[&ChannelResult], result: &SourceResult) -> StatisticsRow {
    let (unit, factor, decimals) = match quantity {
        Quantity::AngularRate => ("deg/s", 180.0 / std::f64::consts::PI, 4),
        Quantity::Acceleration => ("m/s²", 1.0, 4),
        Quantity::MagneticField => ("gauss", 1.0, 4),
        Quantity::Angle => ("deg", 1.0, 4),
        Quantity::Temperature => ("°C", 1.0, 3),
        Quantity::Pressure => ("kPa", 1.0, 3),
        Quantity::Quaternion | Quantity::Value => ("", 1.0, 6),
    };
    let cell = |value: Option<f64>| value.map_or("-".into(), |value| fitted(value * factor, decimals, WIDTH));
    // the direction of an angle says nothing of the sensor
    let has_mean = !matches!(quantity, Quantity::Angle | Quantity::Quaternion);
    let mean = |axis: &&ChannelResult| if has_mean { cell(axis.statistics.mean) } else { String::new() };
    let length = result.norms.iter().find(|norm| norm.quantity == quantity).and_then(|norm| norm.of_mean);
    StatisticsRow {
        label: match axes {
            [only] if quantity == Quantity::Value => only.name.clone(),
            _ => names_of(quantity).short.to_owned(),
        },
        unit,
        means: axes.iter().map(mean).collect(),
        stds: axes.iter().map(|axis| cell(axis.statistics.std)).collect(),
        remark: match (quantity, length) {
            (Quantity::Acceleration | Quantity::MagneticField, Some(length)) => format!("norm {length:.4}"),
            _ => String::new(),
        },
    }
}

/// The mean temperature of the sensor as text, such as `24.3 °C`: of the samples, or else of the
/// readings of a register between them; `None` if neither has it.
pub fn mean_temperature(result: &SourceResult) -> Option<String> {
    let mean = |channel: &&ChannelResult| channel.statistics.mean;
    result.of(Quantity::Temperature).iter().find_map(mean).map(|mean_c| format!("{mean_c:.1} °C"))
}
