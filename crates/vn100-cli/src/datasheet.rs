//! Data sheets: the built-in one of the VN-100, and those that users write, as TOML.

use std::{fs, path::Path};

use anyhow::{Context, Result, bail};
use imu_noise::{Claim, Sensor, Sides, Term, conventions};
use serde::Deserialize;
use vn100_pipeline::{Datasheet, DatasheetFigure};

const BUILT_IN: &str = include_str!("../datasheets/vn-100.toml");

/// The VN-100's.
///
/// # Errors
/// None, unless this program was built with a damaged sheet.
pub(crate) fn vn100() -> Result<Datasheet> {
    parse(BUILT_IN).context("the built-in data sheet")
}

/// A user's.
///
/// # Errors
/// When the file cannot be read, is not TOML, or a figure makes no sense; with file, line and the choices there are.
pub(crate) fn open(path: &Path) -> Result<Datasheet> {
    let text = fs::read_to_string(path).with_context(|| format!("cannot read the data sheet {}", path.display()))?;
    parse(&text).with_context(|| format!("the data sheet {}", path.display()))
}

fn parse(text: &str) -> Result<Datasheet> {
    let sheet: Sheet = toml::from_str(text)?;
    if sheet.figure.is_empty() {
        bail!("holds no [[figure]]");
    }
    let figures = sheet.figure.into_iter().map(figure).collect::<Result<_>>()?;
    Ok(Datasheet { name: sheet.name, note: sheet.note, figures })
}

fn figure(printed: PrintedFigure) -> Result<DatasheetFigure> {
    let (sensor, term) = (printed.sensor.into(), printed.parameter.into());
    let all = conventions(sensor, term);
    // a density is taken for two-sided: makers print N
    let known = all.iter().find(|convention| convention.unit == printed.unit && convention.sides != Some(Sides::One));
    let Some(convention) = known else {
        let units: Vec<_> = all.iter().filter(|c| c.sides != Some(Sides::One)).map(|c| c.unit).collect();
        bail!("{:?} is no unit of this figure: use one of {}", printed.unit, units.join(", "));
    };
    let (claim, number) = match (printed.limit, printed.typical) {
        (Some(limit), None) => (Claim::Limit(limit), format!("at most {limit}")),
        (None, Some(Typical::One(value))) => (Claim::Typical { from: value, to: value }, format!("typically {value}")),
        (None, Some(Typical::Range([from, to]))) => (Claim::Typical { from, to }, format!("typically {from} to {to}")),
        _ => bail!("a figure in {} needs one of \"limit\" and \"typical\"", printed.unit),
    };
    let si = |value: f64| value / convention.factor;
    let (claim, low, high) = match claim {
        Claim::Limit(limit) => (Claim::Limit(si(limit)), si(limit), si(limit)),
        Claim::Typical { from, to } => (Claim::Typical { from: si(from), to: si(to) }, si(from), si(to)),
    };
    // in SI: a number can be within 64 bits in one unit and beyond them in the other
    if !(low > 0.0 && high >= low && high.is_finite()) {
        bail!("{number} {} is not positive, or not in order", printed.unit);
    }
    Ok(DatasheetFigure {
        sensor,
        term,
        claim,
        is_minimum: printed.convention != Some(BiasConvention::Flicker),
        printed: format!("{number} {}", printed.unit),
        source: printed.source,
    })
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sheet {
    name: String,
    note: Option<String>,
    #[serde(default)]
    figure: Vec<PrintedFigure>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PrintedFigure {
    sensor: SensorName,
    parameter: ParameterName,
    unit: String,
    limit: Option<f64>,
    typical: Option<Typical>,
    convention: Option<BiasConvention>,
    source: Option<String>,
}

/// What a sheet calls bias instability.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum BiasConvention {
    /// The minimum of the deviation, as most do.
    Minimum,
    /// That over 0.664.
    Flicker,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Typical {
    One(f64),
    Range([f64; 2]),
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum SensorName {
    Gyroscope,
    Accelerometer,
    Magnetometer,
}

impl From<SensorName> for Sensor {
    fn from(name: SensorName) -> Self {
        match name {
            SensorName::Gyroscope => Self::Gyroscope,
            SensorName::Accelerometer => Self::Accelerometer,
            SensorName::Magnetometer => Self::Magnetometer,
        }
    }
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum ParameterName {
    White,
    BiasInstability,
    RateRandomWalk,
    RateRamp,
    Quantization,
}

impl From<ParameterName> for Term {
    fn from(name: ParameterName) -> Self {
        match name {
            ParameterName::White => Self::White,
            ParameterName::BiasInstability => Self::BiasInstability,
            ParameterName::RateRandomWalk => Self::RateRandomWalk,
            ParameterName::RateRamp => Self::RateRamp,
            ParameterName::Quantization => Self::Quantization,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*, sample::Index};

    use super::*;

    fn claim(sheet: &Datasheet, sensor: Sensor, term: Term) -> Vec<Claim> {
        let figures = sheet.figures.iter().filter(|figure| (figure.sensor, figure.term) == (sensor, term));
        figures.map(|figure| figure.claim).collect()
    }

    fn close(found: f64, expected: f64) {
        assert!((found / expected - 1.0).abs() < 2e-3, "{found}, expected {expected}");
    }

    #[test]
    fn the_built_in_sheet_has_the_quoted_figures_in_si() {
        let sheet = vn100().unwrap();
        let [Claim::Typical { from: white, .. }] = claim(&sheet, Sensor::Gyroscope, Term::White)[..] else { panic!() };
        close(white, 6.11e-5);
        let bias = claim(&sheet, Sensor::Gyroscope, Term::BiasInstability);
        let [Claim::Limit(limit), Claim::Typical { from, to }] = bias[..] else { panic!("{bias:?}") };
        close(limit, 4.85e-5);
        close(from, 2.42e-5);
        close(to, 3.39e-5);
        let [Claim::Typical { from: white, .. }] = claim(&sheet, Sensor::Accelerometer, Term::White)[..] else {
            panic!()
        };
        close(white, 1.373e-3);
        let [Claim::Limit(limit)] = claim(&sheet, Sensor::Accelerometer, Term::BiasInstability)[..] else { panic!() };
        close(limit, 3.92e-4);
        assert!(sheet.figures.iter().all(|figure| figure.source.is_some()));
    }

    #[test]
    fn a_wrong_sheet_is_told_what_would_be_right() {
        let figure =
            |fields: &str| format!("name = \"x\"\n[[figure]]\nsensor = \"gyroscope\"\nparameter = \"white\"\n{fields}");
        for (text, expected) in [
            ("name = \"x\"".to_owned(), "[[figure]]"),
            (figure("unit = \"deg/h\"\nlimit = 1.0"), "deg/sqrt(h)"),
            (figure("unit = \"deg/sqrt(h)\""), "limit"),
            (figure("unit = \"deg/sqrt(h)\"\nlimit = 1.0\ntypical = 1.0"), "one of"),
            (figure("unit = \"deg/sqrt(h)\"\nlimit = -1.0"), "not positive"),
            (figure("unit = \"deg/sqrt(h)\"\nlimit = 1e-322"), "not positive"),
            (figure("unit = \"deg/sqrt(h)\"\ntypical = [2.0, 1.0]"), "in order"),
            (figure("unit = \"deg/sqrt(h)\"\nlimitt = 1.0"), "limitt"),
            ("name = \"x\"\n[[figure]]\nsensor = \"gyro\"".to_owned(), "gyroscope"),
        ] {
            let error = format!("{:#}", parse(&text).unwrap_err());
            assert!(error.contains(expected), "{error}");
        }
    }

    proptest! {
        #[test]
        fn any_sheet_is_refused_or_has_figures_to_judge_by(
            edits in vec((any::<Index>(), any::<bool>(), "[0-9a-z_=.,\"#\\[\\]\n -]{0,12}|[1-9]e-?3[0-2][0-9]|-0.0|inf|nan|\\[1.0, inf\\]|\\[1e-30, 1e300\\]"), 1..4),
        ) {
            let mut lines: Vec<String> = BUILT_IN.lines().map(str::to_owned).collect();
            for (at, value_alone, put) in edits {
                let line = at.get_mut(&mut lines);
                let kept = line.find('=').filter(|_| value_alone).map_or(0, |equals| equals + 1);
                line.replace_range(kept.., &put);
            }
            match parse(&lines.join("\n")) {
                Err(error) => prop_assert!(!error.to_string().is_empty()),
                Ok(sheet) => for figure in sheet.figures {
                    let (low, high) = match figure.claim {
                        Claim::Limit(limit) => (limit, limit),
                        Claim::Typical { from, to } => (from, to),
                    };
                    prop_assert!(low > 0.0 && low <= high && high.is_finite(), "{:?}", figure);
                },
            }
        }
    }
}
