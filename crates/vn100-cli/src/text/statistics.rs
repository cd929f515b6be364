//! Means and standard deviations, and what they say of a sensor at rest.

use std::fmt::{self, Write};

use imu_noise::STANDARD_GRAVITY_M_S2;
use vn100_analysis::Snapshot;
use vn100_protocol::Quantity;
use vn100_report::EARTH_RATE_RAD_S;
use vn100_report::units::{ChannelValues, fitted, norm_values};

use super::layout::fill;

/// Every channel, and the length of each vector.
pub(super) fn write_statistics(out: &mut String, snapshot: &Snapshot, channels: &[ChannelValues]) -> fmt::Result {
    writeln!(out)?;
    let width = channels.iter().map(|channel| channel.name.len() + 1).max().unwrap_or(0).max(12);
    writeln!(out, "{:<width$}{:<7}{:>15}{:>15}{:>15}{:>15}", "channel", "unit", "mean", "std", "min", "max")?;
    let mut row = |name: &str, unit: &str, averages: [Option<f64>; 2], samples: [Option<f64>; 2], decimals: usize| {
        // three digits more than the sensor prints: averages resolve more than one sample
        let [mean, std] = averages.map(|value| number(value, decimals + 3));
        let [min, max] = samples.map(|value| number(value, decimals));
        writeln!(out, "{name:<width$}{unit:<7}{mean:>15}{std:>15}{min:>15}{max:>15}")
    };
    for channel in channels {
        let averages = [channel.mean, channel.std];
        row(&channel.name, &channel.unit, averages, [channel.min, channel.max], channel.decimals)?;
    }
    let norms = norm_values(snapshot);
    for norm in &norms {
        // two of its digits are more than the sensor prints already
        let decimals = norm.decimals.saturating_sub(2);
        row(norm.name, &norm.unit, [norm.mean, norm.std], [norm.min, norm.max], decimals)?;
    }
    for norm in &norms {
        if let Some(text) = norm.of_mean.and_then(|of_mean| at_rest(norm.quantity, of_mean)) {
            writeln!(out, "{}", fill(&text, "", "  "))?;
        }
    }
    Ok(())
}

/// What the length of the mean vector, in SI units or gauss, says if the sensor rested.
fn at_rest(quantity: Quantity, of_mean: f64) -> Option<String> {
    match quantity {
        Quantity::MagneticField => Some(format!("mean field {of_mean:.4} gauss; the Earth's is 0.22 to 0.67")),
        Quantity::Acceleration => Some(format!(
            "mean acceleration {of_mean:.4} m/s^2, {:+.4} from standard gravity: bias and scale, if the sensor rested",
            of_mean - STANDARD_GRAVITY_M_S2
        )),
        Quantity::AngularRate => Some(format!(
            "mean rate {of_mean:.2e} rad/s; the Earth turns at {EARTH_RATE_RAD_S:.2e} rad/s: the mean of a resting gyroscope is not its bias \
             alone"
        )),
        Quantity::Angle | Quantity::Quaternion | Quantity::Temperature | Quantity::Pressure => None,
    }
}

fn number(value: Option<f64>, decimals: usize) -> String {
    // a column, and a blank before it
    value.map_or("-".into(), |value| fitted(value, decimals, 14))
}
