//! What can be read off the figures, for the script of the page: the same numbers, to six digits.

use serde::{Serialize, Serializer};

use crate::figure::{Axis, Figure, Scale, Series};

#[derive(Serialize)]
struct Reading<'a> {
    id: &'a str,
    /// Left, top, width and height of the plot.
    area: [Short; 4],
    x: Side<'a>,
    y: Side<'a>,
    series: Vec<Curve<'a>>,
}

#[derive(Serialize)]
struct Side<'a> {
    name: &'a str,
    unit: &'a str,
    log: bool,
    from: Short,
    to: Short,
}

#[derive(Serialize)]
struct Curve<'a> {
    name: &'a str,
    x: Vec<Short>,
    y: Vec<Short>,
    /// Lower and upper ends, where the series has some.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    reach: Vec<Option<[Short; 2]>>,
}

struct Short(f64);

impl Serialize for Short {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // rounded in decimals, so that the shortest form of the number is short
        let rounded: f64 = format!("{:.5e}", self.0).parse().unwrap_or(f64::NAN);
        rounded.serialize(serializer)
    }
}

/// A JSON array that may stand in a script element.
pub(super) fn readings<'a>(figures: impl Iterator<Item = &'a Figure>) -> Result<String, serde_json::Error> {
    let readings: Vec<Reading<'_>> = figures.map(reading).collect();
    Ok(serde_json::to_string(&readings)?.replace('<', "\\u003c"))
}

fn reading(figure: &Figure) -> Reading<'_> {
    let area = figure.area;
    Reading {
        id: &figure.id,
        area: [area.left, area.top, area.width, area.height].map(Short),
        x: side(&figure.x),
        y: side(&figure.y),
        series: figure.series.iter().map(curve).collect(),
    }
}

fn side(axis: &Axis) -> Side<'_> {
    let (from, to) = axis.scale.ends();
    Side {
        name: &axis.name,
        unit: &axis.unit,
        log: matches!(axis.scale, Scale::Log { .. }),
        from: Short(from),
        to: Short(to),
    }
}

fn curve(series: &Series) -> Curve<'_> {
    let values = &series.values;
    let reach = || values.iter().map(|value| value.reach.map(|(lower, upper)| [Short(lower), Short(upper)])).collect();
    Curve {
        name: &series.name,
        x: values.iter().map(|value| Short(value.x)).collect(),
        y: values.iter().map(|value| Short(value.y)).collect(),
        reach: if values.iter().any(|value| value.reach.is_some()) { reach() } else { Vec::new() },
    }
}
