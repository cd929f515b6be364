//! What can be read off the figures, for the script of the page: the same numbers, to six digits.

use serde_json::{Value, json};

use crate::figure::{Axis, Figure, Scale, Series};

/// A JSON array that may stand in a script element.
pub(super) fn readings<'a>(figures: impl Iterator<Item = &'a Figure>) -> String {
    figures.map(reading).collect::<Value>().to_string().replace('<', "\\u003c")
}

fn reading(figure: &Figure) -> Value {
    let area = figure.area;
    json!({
        "id": figure.id,
        // of the plot
        "area": [short(area.left), short(area.top), short(area.width), short(area.height)],
        "x": side(&figure.x),
        "y": side(&figure.y),
        "series": figure.series.iter().map(curve).collect::<Value>(),
    })
}

fn side(axis: &Axis) -> Value {
    let (from, to) = axis.scale.ends();
    json!({
        "name": axis.name,
        "unit": axis.unit,
        "log": matches!(axis.scale, Scale::Log { .. }),
        "from": short(from),
        "to": short(to),
    })
}

fn curve(series: &Series) -> Value {
    let values = &series.values;
    let mut curve = json!({
        "name": series.name,
        "x": values.iter().map(|value| short(value.x)).collect::<Value>(),
        "y": values.iter().map(|value| short(value.y)).collect::<Value>(),
    });
    if values.iter().any(|value| value.reach.is_some()) {
        let reach = values.iter().map(|value| value.reach.map(|(lower, upper)| [short(lower), short(upper)]));
        curve["reach"] = json!(reach.collect::<Vec<_>>());
    }
    curve
}

/// Rounded in decimals, so that the shortest form of the number is short.
fn short(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(f64::NAN)
}
