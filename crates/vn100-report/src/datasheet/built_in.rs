//! The data sheets of sensors that people use, each figure with the document and the page it was read
//! from.

use vn100_analysis::Datasheet;

use super::{DatasheetError, parse_datasheet};

/// Name and text of each data sheet, by name.
pub const DATASHEETS: [(&str, &str); 18] = [
    ("adis16405", include_str!("../../datasheets/adis16405.toml")),
    ("adis16448", include_str!("../../datasheets/adis16448.toml")),
    ("adis16470", include_str!("../../datasheets/adis16470.toml")),
    ("adis16505-1", include_str!("../../datasheets/adis16505-1.toml")),
    ("bmi055", include_str!("../../datasheets/bmi055.toml")),
    ("bmi088", include_str!("../../datasheets/bmi088.toml")),
    ("icm-20602", include_str!("../../datasheets/icm-20602.toml")),
    ("icm-20948", include_str!("../../datasheets/icm-20948.toml")),
    ("icm-42688-p", include_str!("../../datasheets/icm-42688-p.toml")),
    ("lsm6dso32", include_str!("../../datasheets/lsm6dso32.toml")),
    ("mpu-6050", include_str!("../../datasheets/mpu-6050.toml")),
    ("mpu-9250", include_str!("../../datasheets/mpu-9250.toml")),
    ("mti-3", include_str!("../../datasheets/mti-3.toml")),
    ("mti-30", include_str!("../../datasheets/mti-30.toml")),
    ("mti-300", include_str!("../../datasheets/mti-300.toml")),
    ("stim300", include_str!("../../datasheets/stim300.toml")),
    ("vn-100", include_str!("../../datasheets/vn-100.toml")),
    ("vn-200", include_str!("../../datasheets/vn-200.toml")),
];

/// The built-in data sheet with this name, in any letter case; `None` if there is none.
///
/// # Errors
/// None, unless this program was built with an invalid sheet.
pub fn built_in_datasheet(name: &str) -> Option<Result<Datasheet, DatasheetError>> {
    let (_, text) = DATASHEETS.iter().find(|(known, _)| known.eq_ignore_ascii_case(name))?;
    Some(parse_datasheet(text))
}

/// The data sheet of the VN-100.
///
/// # Errors
/// None, unless this program was built with an invalid sheet.
pub fn vn100_datasheet() -> Result<Datasheet, DatasheetError> {
    parse_datasheet(include_str!("../../datasheets/vn-100.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sheet_is_valid_and_every_figure_has_its_source() {
        for (name, text) in DATASHEETS {
            let sheet = parse_datasheet(text).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert!(sheet.note.is_some() && sheet.figures.iter().all(|figure| figure.source.is_some()), "{name}");
        }
        assert!(DATASHEETS.is_sorted());
    }
}
