//! `vn100 export`: the file of a filter from a data sheet alone.

use std::{io::Write, path::Path};

use anyhow::{Result, bail};
use imu_noise::BoxcarWindow;
use vn100_analysis::Completion;
use vn100_report::{FilterNoise, SheetStream};

use super::report::not_written;
use crate::{
    args::{ExportArgs, Window, refused},
    exit::print,
    output::Output,
    user_files::open_datasheet,
};

pub(crate) fn export(args: &ExportArgs) -> Result<Completion> {
    let ExportArgs { rate: rate_hz, window, .. } = *args;
    let sheet = open_datasheet(&args.datasheet)?;
    let refresh_hz = args.refresh.or(sheet.onboard.map(|onboard| onboard.refresh_hz));
    let aliasing = aliasing(rate_hz, window, refresh_hz, &sheet.name);
    let stream = SheetStream { rate_hz, aliasing: aliasing.map_err(|error| refused("export", &error.to_string()))? };
    let mut noise = FilterNoise::of_datasheet(&sheet, stream);
    noise.scale_factor_ppm = args.not_shown.scale_factor;
    let name = args.output.as_deref().unwrap_or_else(|| Path::new(args.to.title));
    let text = args.to.file(&noise).map_err(|error| not_written(name, &error))?;
    match &args.output {
        None => print(&text)?,
        Some(path) => {
            let output = Output::new(path, args.existing.force);
            output.check(path, std::slice::from_ref(&args.datasheet))?;
            output.write(path, |file| Ok(file.write_all(text.as_bytes())?))?;
            print(&format!("wrote {}\n", path.display()))?;
        }
    }
    Ok(Completion::Complete)
}

/// The density in the stream over that of the sensor.
fn aliasing(rate_hz: f64, window: Window, refresh_hz: Option<f64>, sensor: &str) -> Result<f64> {
    match (window, refresh_hz) {
        (Window::All, _) => Ok(1.0),
        (Window::Samples(_), None) => bail!(
            "the data sheet of {sensor} has no rate of internal samples: give --refresh HZ, or --window all if nothing aliases"
        ),
        (Window::Samples(_), Some(refresh_hz)) if refresh_hz < rate_hz => {
            bail!("a sensor of {refresh_hz} internal samples per second sends no {rate_hz} per second")
        }
        (Window::Samples(length), Some(refresh_hz)) => {
            Ok(BoxcarWindow { length, decimation: refresh_hz / rate_hz }.white_factor())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_averaged_aliases() {
        let factor = |rate, window, refresh| aliasing(rate, window, refresh, "x").unwrap();
        assert!((factor(40.0, Window::Samples(4), Some(800.0)) - 5.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(factor(40.0, Window::Samples(20), Some(800.0)), 1.0);
        assert_eq!(factor(40.0, Window::All, None), 1.0);
        for (refresh, cure) in [(None, "--refresh"), (Some(20.0), "no 40 per second")] {
            let error = aliasing(40.0, Window::Samples(4), refresh, "x").unwrap_err().to_string();
            assert!(error.contains(cure), "{error}");
        }
    }
}
