//! Data sheets as users write them, as TOML.

pub(crate) mod built_in;

use std::ops::Range;

use serde::Deserialize;
use thiserror::Error;
use toml::Spanned;
use vn100_analysis::noise::{Claim, Sensor, Sides, Term, conventions};
use vn100_analysis::{Datasheet, DatasheetFigure, SheetOnboard};

use crate::toml_text::{line, parse_toml};

/// Why a text is no data sheet: the line, and what would be valid there.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct DatasheetError(String);

/// Reads a data sheet that a user wrote, as TOML.
///
/// # Errors
/// [`DatasheetError`] if the text is not TOML, or a figure is not valid.
pub fn parse_datasheet(text: &str) -> Result<Datasheet, DatasheetError> {
    let sheet: Sheet = parse_toml(text).map_err(|error| DatasheetError(error.to_string()))?;
    if sheet.figure.is_empty() {
        return Err(DatasheetError("holds no [[figure]]".into()));
    }
    if let Some(onboard) = &sheet.onboard
        && !(onboard.get_ref().refresh_hz > 0.0 && onboard.get_ref().refresh_hz.is_finite())
    {
        let line = line(text, onboard.span().start);
        return Err(DatasheetError(format!("line {line}: refresh_hz is not above 0")));
    }
    let figure = |printed: Spanned<PrintedFigure>| {
        let line = line(text, printed.span().start);
        figure(printed.into_inner(), sheet.density, text)
            .map_err(|error| DatasheetError(format!("the figure in line {line}: {error}")))
    };
    let figures = sheet.figure.into_iter().map(figure).collect::<Result<_, _>>()?;
    let onboard = sheet.onboard.map(Spanned::into_inner);
    Ok(Datasheet { name: sheet.name, note: sheet.note, onboard, figures, typical_is_limit: false })
}

/// `density`: the convention of the whole sheet, unless a figure has its own.
fn figure(printed: PrintedFigure, density: Option<DensityName>, sheet: &str) -> Result<DatasheetFigure, String> {
    use ConventionName::{Flicker, Minimum, OneSided, TwoSided};
    let (sensor, term) = (printed.sensor, printed.parameter);
    let all = conventions(sensor, term);
    // a density of unknown sides is read as two-sided first
    let known = all.iter().find(|convention| convention.unit == printed.unit && convention.sides != Some(Sides::One));
    let Some(unit) = known else {
        let choices: Vec<&str> = all.iter().filter(|c| c.sides != Some(Sides::One)).map(|c| c.unit).collect();
        return Err(format!("unknown unit {:?} of this figure: use one of {}", printed.unit, choices.join(", ")));
    };
    let is_bias = term == Term::BiasInstability;
    let of_sheet = unit.sides.and(density).map(|density| match density {
        DensityName::TwoSided => TwoSided,
        DensityName::OneSided => OneSided,
    });
    let convention = printed.convention.or(of_sheet);
    let (unit, said) = match (convention, unit.sides) {
        (None, _) => (*unit, ""),
        (Some(TwoSided), Some(_)) => (*unit, ", two-sided"),
        (Some(OneSided), Some(_)) => (unit.one_sided(), ", one-sided"),
        (Some(Minimum | Flicker), _) if is_bias => (*unit, ""),
        (Some(_), sides) => {
            let choices = match sides {
                Some(_) => "the convention \"two-sided\" or \"one-sided\"",
                None if is_bias => "the convention \"minimum\" or \"flicker\"",
                None => "no convention",
            };
            return Err(format!("a figure in {} has {choices}", printed.unit));
        }
    };
    let is_limit = printed.limit.is_some();
    let (low, high, rounding, number) = claimed(&printed, sheet)?;
    // in SI: a number can be within 64 bits in one unit and beyond them in the other
    let (low, high, rounding) = (low / unit.factor, high / unit.factor, rounding / unit.factor);
    if !(low - rounding > 0.0 && high >= low && (high + rounding).is_finite()) {
        return Err(format!("{number} {} is not positive, or not in order", printed.unit));
    }
    Ok(DatasheetFigure {
        sensor,
        term,
        is_of_unknown_sides: unit.sides.is_some() && convention.is_none(),
        claim: if is_limit { Claim::Limit(low) } else { Claim::Typical { from: low, to: high, rounding } },
        is_minimum: is_bias && printed.convention != Some(Flicker),
        printed: format!("{} {number} {}{said}", if is_limit { "at most" } else { "typically" }, printed.unit),
        source: printed.source,
    })
}

/// Both ends of a claim, half the last place of a typical one, and the claim as it is written: a zero at
/// the end is known, and the number alone has lost it.
fn claimed(printed: &PrintedFigure, sheet: &str) -> Result<(f64, f64, f64, String), String> {
    let written = |span: Range<usize>| sheet.get(span).unwrap_or_default().trim().to_owned();
    let value = |value: &toml::Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    match (&printed.limit, &printed.typical) {
        (Some(limit), None) => Ok((*limit.get_ref(), *limit.get_ref(), 0.0, written(limit.span()))),
        (None, Some(typical)) => match typical.get_ref() {
            toml::Value::Array(ends) => match &ends.iter().map(value).collect::<Vec<_>>()[..] {
                [Some(from), Some(to)] => Ok((*from, *to, 0.0, format!("{from} to {to}"))),
                _ => Err("a typical figure is a number, or [from, to]".into()),
            },
            one => {
                let digits = written(typical.span());
                let value = value(one).ok_or("a typical figure is a number, or [from, to]")?;
                Ok((value, value, half_a_last_place(&digits), digits))
            }
        },
        _ => Err(format!("a figure in {} needs one of \"limit\" and \"typical\"", printed.unit)),
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sheet {
    name: String,
    note: Option<String>,
    density: Option<DensityName>,
    onboard: Option<Spanned<SheetOnboard>>,
    #[serde(default)]
    figure: Vec<Spanned<PrintedFigure>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PrintedFigure {
    sensor: Sensor,
    parameter: Term,
    unit: String,
    limit: Option<Spanned<f64>>,
    typical: Option<Spanned<toml::Value>>,
    convention: Option<ConventionName>,
    source: Option<String>,
}

/// Which frequencies the densities of a sheet count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum DensityName {
    /// N itself.
    TwoSided,
    /// That over positive frequencies only, √2 N.
    OneSided,
}

/// What the number is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum ConventionName {
    /// Of a bias instability: the minimum of the deviation, as most sheets have it.
    Minimum,
    /// Of a bias instability: that over 0.664.
    Flicker,
    /// Of a density: as [`DensityName::TwoSided`].
    TwoSided,
    /// Of a density: as [`DensityName::OneSided`].
    OneSided,
}

/// Half a unit of the last place of a number as TOML writes them; 0 for one that is not decimal.
fn half_a_last_place(digits: &str) -> f64 {
    let digits = digits.replace('_', "");
    let (mantissa, exponent) = digits.split_once(['e', 'E']).unwrap_or((&digits, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let is_decimal = mantissa.parse::<f64>().is_ok();
    let place = exponent.parse::<i64>().ok().filter(|_| is_decimal).map(|exponent| exponent - decimals as i64);
    // read, not multiplied: exact at both ends of the range
    place.and_then(|place| format!("0.5e{place}").parse().ok()).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_SQRT_2;

    use proptest::{collection::vec, prelude::*, sample::Index};

    use super::{built_in::vn100_datasheet, *};

    const BUILT_IN: &str = include_str!("../datasheets/vn-100.toml");

    fn claim(sheet: &Datasheet, sensor: Sensor, term: Term) -> Vec<Claim> {
        let figures = sheet.figures.iter().filter(|figure| (figure.sensor, figure.term) == (sensor, term));
        figures.map(|figure| figure.claim).collect()
    }

    fn close(found: f64, expected: f64) {
        assert!((found / expected - 1.0).abs() < 2e-3, "{found}, expected {expected}");
    }

    #[test]
    fn the_built_in_sheet_has_the_quoted_figures_in_si() {
        let sheet = vn100_datasheet().unwrap();
        let [Claim::Typical { from: white, .. }] = claim(&sheet, Sensor::Gyroscope, Term::White)[..] else { panic!() };
        close(white, 0.2 / 60.0 / 57.29578);
        let bias = claim(&sheet, Sensor::Gyroscope, Term::BiasInstability);
        let [Claim::Limit(limit), Claim::Typical { from, to, rounding: 0.0 }] = bias[..] else { panic!("{bias:?}") };
        close(limit, 4.85e-5);
        close(from, 2.42e-5);
        close(to, 3.39e-5);
        let [Claim::Typical { from: white, .. }] = claim(&sheet, Sensor::Accelerometer, Term::White)[..] else {
            panic!()
        };
        close(white, 0.1 / 60.0);
        let [Claim::Limit(limit)] = claim(&sheet, Sensor::Accelerometer, Term::BiasInstability)[..] else { panic!() };
        close(limit, 3.92e-4);
        assert!(sheet.figures.iter().all(|figure| figure.source.is_some()));
        // a random walk has one meaning
        let is_density = |figure: &DatasheetFigure| figure.sensor == Sensor::Magnetometer;
        assert!(sheet.figures.iter().all(|figure| figure.is_of_unknown_sides == is_density(figure)));
    }

    #[test]
    fn a_single_typical_figure_is_known_to_half_its_last_place() {
        let rounding = |typical: &str| {
            let text = format!(
                "name = \"x\"\n[[figure]]\nsensor = \"accelerometer\"\nparameter = \"white\"\nunit = \"m/s^2/sqrt(Hz)\"\ntypical = {typical}"
            );
            let figure = parse_datasheet(&text).unwrap().figures.remove(0);
            match figure.claim {
                Claim::Typical { rounding, .. } => (rounding, figure.printed),
                Claim::Limit(_) => panic!(),
            }
        };
        for (typical, expected) in [
            ("0.0035", 5e-5),
            ("0.30", 5e-3),
            ("0.3", 5e-2),
            ("140e-6", 5e-7),
            ("1.4e-4", 5e-6),
            ("300", 0.5),
            ("3_00.0", 0.05),
            ("7.0", 0.05),
            ("2.25", 5e-3),
        ] {
            let (rounding, printed) = rounding(typical);
            close(rounding, expected);
            assert_eq!(printed, format!("typically {typical} m/s^2/sqrt(Hz)"));
        }
        let range = (0.0, "typically 5 to 7 m/s^2/sqrt(Hz)".to_owned());
        assert_eq!(rounding("[ 5.0, # the lowest of ten\n7 ]"), range);
    }

    #[test]
    fn one_side_of_a_density_is_the_larger_number() {
        let limit = |unit: &str, convention: &str| {
            let text = format!(
                "name = \"x\"\n[[figure]]\nsensor = \"accelerometer\"\nparameter = \"white\"\nunit = \"{unit}\"\nlimit = 1\n{convention}"
            );
            match parse_datasheet(&text).unwrap().figures[0].claim {
                Claim::Limit(limit) => limit,
                Claim::Typical { .. } => panic!(),
            }
        };
        close(limit("m/s^2/sqrt(Hz)", "convention = \"one-sided\""), FRAC_1_SQRT_2);
        close(limit("m/s^2/sqrt(Hz)", "convention = \"two-sided\""), 1.0);
        close(limit("m/s^2/sqrt(Hz)", ""), 1.0);
        // in a unit that no table has with one side
        close(limit("mg/sqrt(Hz)", "convention = \"one-sided\""), 9.806_65e-3 * FRAC_1_SQRT_2);
    }

    #[test]
    fn the_sides_of_a_density_are_known_from_the_figure_or_the_sheet_or_not_at_all() {
        for (sheet, figure, unit, expected) in [
            ("", "", "deg/s/sqrt(Hz)", (true, 1.0)),
            ("density = \"two-sided\"\n", "", "deg/s/sqrt(Hz)", (false, 1.0)),
            ("density = \"one-sided\"\n", "", "deg/s/sqrt(Hz)", (false, FRAC_1_SQRT_2)),
            ("density = \"one-sided\"\n", "convention = \"two-sided\"", "deg/s/sqrt(Hz)", (false, 1.0)),
            ("", "convention = \"one-sided\"", "deg/s/sqrt(Hz)", (false, FRAC_1_SQRT_2)),
            // an angle random walk has one meaning
            ("density = \"one-sided\"\n", "", "deg/sqrt(h)", (false, 1.0 / 60.0)),
            ("", "", "deg/sqrt(h)", (false, 1.0 / 60.0)),
        ] {
            let text = format!(
                "name = \"x\"\n{sheet}[[figure]]\nsensor = \"gyroscope\"\nparameter = \"white\"\nunit = \"{unit}\"\nlimit = 1\n{figure}"
            );
            let figure = parse_datasheet(&text).unwrap().figures.remove(0);
            let Claim::Limit(limit) = figure.claim else { panic!() };
            assert_eq!(figure.is_of_unknown_sides, expected.0, "{text}");
            close(limit.to_degrees(), expected.1);
        }
        let bias = "name = \"x\"\ndensity = \"one-sided\"\n[[figure]]\nsensor = \"gyroscope\"\nparameter = \"bias_instability\"\nunit = \"deg/h\"\nlimit = 1";
        assert!(!parse_datasheet(bias).unwrap().figures[0].is_of_unknown_sides);
        let wrong = "name = \"x\"\ndensity = \"half\"";
        assert!(parse_datasheet(wrong).unwrap_err().to_string().contains("one-sided"));
    }

    #[test]
    fn the_error_of_a_wrong_sheet_names_the_right_choices() {
        let figure =
            |fields: &str| format!("name = \"x\"\n[[figure]]\nsensor = \"gyroscope\"\nparameter = \"white\"\n{fields}");
        for (text, expected) in [
            ("name = \"x\"".to_owned(), "[[figure]]"),
            (figure("unit = \"deg/h\"\nlimit = 1.0"), "deg/sqrt(h)"),
            (figure("unit = \"deg/sqrt(h)\""), "limit"),
            (figure("unit = \"deg/sqrt(h)\"\nlimit = 1.0\ntypical = 1.0"), "one of"),
            (figure("unit = \"deg/sqrt(h)\"\nlimit = -1.0"), "not positive"),
            (figure("unit = \"deg/sqrt(h)\"\nlimit = 1e-322"), "not positive"),
            (figure("unit = \"deg/sqrt(h)\"\nlimit = -1.0"), "line 2"),
            (figure("unit = \"deg/sqrt(h)\"\nlimit = nan"), "not positive"),
            (figure("unit = \"deg/sqrt(h)\"\ntypical = \"1\""), "[from, to]"),
            (figure("unit = \"deg/sqrt(h)\"\nlimit = 1.0\nconvention = \"one-sided\""), "no convention"),
            (figure("unit = \"deg/s/sqrt(Hz)\"\nlimit = 1.0\nconvention = \"minimum\""), "two-sided"),
            (figure("unit = \"deg/s/sqrt(Hz)\"\nlimit = 1.0\nconvention = \"both\""), "one-sided"),
            ("name = \"x\"\n\n[onboard]\nrefresh_hz = 0\nwindow = 1\n[[figure]]\nsensor = \"gyroscope\"\nparameter = \"white\"\nunit = \"deg/sqrt(h)\"\nlimit = 1".to_owned(), "line 3"),
            (figure("unit = \"deg/sqrt(h)\"\ntypical = [2.0, 1.0]"), "in order"),
            (figure("unit = \"deg/sqrt(h)\"\nlimitt = 1.0"), "limitt"),
            ("name = \"x\"\n[[figure]]\nsensor = \"gyro\"".to_owned(), "gyroscope"),
        ] {
            let error = parse_datasheet(&text).unwrap_err().to_string();
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
            match parse_datasheet(&lines.join("\n")) {
                Err(error) => prop_assert!(!error.to_string().is_empty()),
                Ok(sheet) => for figure in sheet.figures {
                    let (low, high) = match figure.claim {
                        Claim::Limit(limit) => (limit, limit),
                        Claim::Typical { from, to, rounding } => (from - rounding, to + rounding),
                    };
                    prop_assert!(low > 0.0 && low <= high && high.is_finite(), "{:?}", figure);
                },
            }
        }
    }
}
