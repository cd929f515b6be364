//! What limits the record, and how to improve it.

use crate::{
    names::{in_unit, verdict_name},
    numbers::{digits, duration, trimmed, with_powers},
    units::pretty_unit,
};
use vn100_analysis::noise::{Sensor, Status, Term, Verdict};
use vn100_analysis::{
    LongTauValidity, MissingFrom, Onboard, RateFrom, Remedy, RemedyWords, Setting, WarningKind, WindowFrom, letter,
    uncompensated_message,
};

use super::listed;
use crate::html::findings::{AxisFindings, Findings, SensorFindings};

pub(super) fn against_data_sheet(findings: &Findings, words: RemedyWords) -> Vec<String> {
    let Some(sheet) = &findings.datasheet else {
        return vec![format!(
            "No data sheet was compared: the record is not known to be of a VN-100. Set {} to compare with another.",
            words(&Remedy::GiveDatasheet)
        )];
    };
    if findings.motion.is_some() {
        return vec![format!("The sensor was moved: nothing is compared with {sheet}.")];
    }
    let mut sentences = verdicts(findings, sheet);
    sentences.extend(findings.sensors.iter().filter_map(decimation));
    if findings.sensor(Sensor::Gyroscope).is_some_and(|gyro| gyro.long_taus == LongTauValidity::Compensated) {
        sentences.push(
            "In-run bias stability of the gyroscope cannot be compared: the message carries bias-compensated rates. The minimum of such a curve is often ten times lower than the data \
             sheet, and is meaningless."
                .into(),
        );
    }
    sentences.push(
        "Data sheets quote the in-run bias as the minimum of the Allan deviation, given here beside B (the flicker floor over 0.664). N is two-sided here; a one-sided density is √2 times as large, and some makers print that.".into(),
    );
    sentences
}

fn verdicts(findings: &Findings, sheet: &str) -> Vec<String> {
    let terms = [Term::White, Term::BiasInstability, Term::RateRandomWalk];
    let statements = Verdict::ALL.into_iter().flat_map(|verdict| {
        terms.into_iter().filter_map(move |term| {
            let judged =
                |axis: &&AxisFindings| axis.verdicts.iter().any(|(of, found, _)| (*of, *found) == (term, verdict));
            let axes: Vec<String> = findings.axes().filter(judged).map(|axis| axis.name.clone()).collect();
            (!axes.is_empty()).then(|| format!("{} of {}: {}", letter(term), listed(&axes), verdict_name(verdict)))
        })
    });
    let statements: Vec<String> = statements.collect();
    let mut sentences = Vec::new();
    if !statements.is_empty() {
        sentences.push(format!("Compared with {sheet}: {}.", statements.join("; ")));
    }
    sentences.extend(findings.sensors.iter().filter_map(|sensor| {
        let worst = sensor.worst(|axis| axis.white)?;
        let (.., text) = worst.axis.verdicts.iter().find(|(term, ..)| *term == Term::White)?;
        Some(format!("{} of the {}: {}.", worst.named(), sensor.name, with_powers(&pretty_unit(text))))
    }));
    sentences
}

fn decimation(sensor: &SensorFindings) -> Option<String> {
    let onboard = sensor.onboard?;
    let factor = onboard.window.white_factor();
    if (factor - 1.0).abs() < 0.02 && !onboard.window.overlaps() {
        return None;
    }
    let known = match onboard.window_from {
        WindowFrom::Register => "register 85",
        WindowFrom::Given => "as given",
        WindowFrom::Integrated => "integrals",
        WindowFrom::Default => "factory default, not in this record",
    };
    let averages = match onboard.window.length {
        0 | 1 => "averages none".to_owned(),
        length => format!("averages {length} samples"),
    };
    let effect = if onboard.window.overlaps() {
        "neighbouring samples share values, so deviations at short averaging times are too low".to_owned()
    } else {
        format!(
            "white noise above half the output rate aliases into the band, so the measured density is {} ± {} times the sensor's own",
            digits(factor, 3),
            digits(factor * Onboard::UNCERTAINTY, 2)
        )
    };
    let (unit, in_unit) = sheet_unit(sensor.sensor);
    let own: Vec<String> = (sensor.axes.iter())
        .filter_map(|axis| Some(format!("{} {}", axis.name, digits(axis.white_value()? * in_unit / factor, 2))))
        .collect();
    let own = if own.is_empty() || onboard.window.overlaps() {
        String::new()
    } else {
        format!(
            " The sensor's own densities, to compare with a data sheet: about {} {} (±10 %). A filter that uses this stream needs the densities as measured.",
            listed(&own),
            pretty_unit(unit)
        )
    };
    Some(format!(
        "The {} samples at {} Hz, {averages} ({known}) and outputs {} Hz: {effect}.{own}",
        sensor.name,
        trimmed(onboard.refresh_hz, 1),
        trimmed(onboard.rate_hz, 3),
    ))
}

/// The unit of white noise in data sheets, and its value for a density of 1 in SI units.
fn sheet_unit(sensor: Sensor) -> (&'static str, f64) {
    let printed = match sensor {
        Sensor::Gyroscope => "deg/s/sqrt(Hz)",
        Sensor::Accelerometer => "mg/sqrt(Hz)",
        Sensor::Magnetometer => "gauss/sqrt(Hz)",
    };
    in_unit(sensor, Term::White, printed)
}

pub(super) fn limits(findings: &Findings) -> Vec<String> {
    let mut limits = Vec::new();
    let known_to = findings.axes().filter_map(|axis| axis.known_to_s).reduce(f64::max);
    limits.push(match known_to {
        Some(tau_s) => format!(
            "Length: {} of data. The longest averaging time with a usable interval is {}; slower noise is not observable.",
            duration(findings.timing.duration_s()),
            duration(tau_s)
        ),
        None => {
            let are = if findings.timing.samples == 1 { "sample is" } else { "samples are" };
            format!("Length: {} {are} too few for any deviation with an interval.", findings.timing.samples)
        }
    });
    if findings.compensated == Some(true) {
        limits.push("Message: bias-compensated values; the gyroscope's bias and its noise are removed.".into());
    }
    if findings.warns(WarningKind::CompensationUnknown) {
        limits.push("Origin: it is unknown whether a filter has removed the gyroscope bias; if one has, its B, K and R are not the sensor's.".into());
    }
    if findings.sensors.iter().any(|sensor| sensor.onboard.is_some_and(|onboard| onboard.window.white_factor() > 1.02))
    {
        limits.push("Rate and averaging window: white noise is aliased into the band, see above.".into());
    }
    if findings.warns(WarningKind::VibrationLine) {
        limits.push("Mounting: vibration covers the shortest averaging times.".into());
    }
    if findings.motion.is_some() {
        limits.push("Motion: it covers the noise at all averaging times.".into());
    } else if findings.warns(WarningKind::NotStationary) || findings.warns(WarningKind::WarmUp) {
        limits.push("Environment: disturbances or warm-up cover the longest averaging times.".into());
    }
    if !findings.has_stamps {
        limits.push(match findings.timing.missing_from {
            MissingFrom::DeviceTime => "Format: without arrival times the sensor's clock is not verified.".into(),
            MissingFrom::Counter => "Format: without arrival times the true rate is not known.".into(),
            MissingFrom::Arrival | MissingFrom::RejectedRows => {
                "Format: without arrival times neither the true rate nor entirely missing lines can be detected.".into()
            }
        });
    }
    limits
}

pub(super) fn not_tested(findings: &Findings) -> Vec<String> {
    let mut biased = findings.sensors.iter().filter(|sensor| sensor.sensor != Sensor::Magnetometer).peekable();
    let is_temperature_tested =
        biased.peek().is_some() && biased.flat_map(|sensor| &sensor.axes).all(|axis| axis.has_temperature_coefficient);
    let temperature = if is_temperature_tested { "" } else { "temperature, " };
    let mut texts = vec![
        format!(
            "Turn-on to turn-on bias, scale factor, misalignment, sensitivity to {temperature}supply and acceleration: not observable in one record at rest."
        ),
        "Whether the sensor was truly at rest: slow motion that looks like noise is not detected.".into(),
    ];
    if !findings.has_registers {
        texts.push("The sensor's settings: the record does not contain its registers, so averaging window, calibration and filter modes are unknown.".into());
    }
    if !findings.has_conditions {
        texts.push("The conditions: place, mounting, ambient temperature and supply were not recorded.".into());
    }
    texts
}

pub(super) fn advice(findings: &Findings, words: RemedyWords) -> Vec<String> {
    let mut advice = Vec::new();
    if findings.motion.is_some() {
        advice.push("Record the sensor at rest.".into());
    }
    let is_ours = findings.message.is_some();
    let is_compensated =
        findings.sensor(Sensor::Gyroscope).is_some_and(|gyro| gyro.long_taus == LongTauValidity::Compensated);
    if let (Some(message), true) = (&findings.message, is_compensated) {
        let uncompensated = uncompensated_message(message);
        advice.push(format!(
            "Use the uncompensated message {uncompensated} (`{}`): only it shows B and K of the gyroscope; it also carries the temperature.",
            words(&Remedy::MeasureWith(Setting::Message(uncompensated)))
        ));
    }
    let window = findings.sensors.iter().filter_map(|sensor| sensor.onboard).find(|onboard| {
        onboard.refresh_hz > 400.0 && (onboard.window.length != onboard.unaliased_window() || !onboard.window_known())
    });
    if let Some(onboard) = window.filter(|onboard| onboard.unaliased_window() == 1) {
        advice.push(format!(
            "Set the averaging window to 1 at {} Hz, so that neighbouring samples share no values and short averaging times are not too low (`{}`).",
            trimmed(onboard.rate_hz, 3),
            words(&Remedy::MeasureWith(Setting::Window(1)))
        ));
    } else if let Some(onboard) = window {
        advice.push(format!(
            "Set the averaging window to 800/rate ({} at {} Hz) to avoid aliasing, so that N compares with the data sheet (`{}`).",
            onboard.unaliased_window(),
            trimmed(findings.timing.rate_hz, 3),
            words(&Remedy::MeasureWith(Setting::Window(onboard.unaliased_window())))
        ));
    }
    if findings.warns(WarningKind::VibrationLine) {
        let strongest_hz = |is_field: bool| {
            let sensors = findings.sensors.iter().filter(|found| (found.sensor == Sensor::Magnetometer) == is_field);
            let lines = sensors.flat_map(|found| &found.axes).filter_map(|axis| axis.lines.first().copied());
            lines.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(hz, _)| hz)
        };
        match (strongest_hz(false), strongest_hz(true)) {
            (Some(hz), _) => advice.push(format!("Remove the {hz:.1} Hz vibration source (or its alias), or isolate the sensor on a heavy base with soft feet, without a hanging cable.")),
            (None, Some(hz)) => advice.push(format!("Remove the source of the {hz:.1} Hz field (or its alias): mains cables, power supplies, motors.")),
            (None, None) => {}
        }
    }
    if findings.warns(WarningKind::NotStationary) && findings.motion.is_none() {
        advice.push("Measure without footsteps, doors and machines nearby; at night if necessary.".into());
    }
    let warm_up = findings.axes().filter_map(|axis| axis.warm_up_s).reduce(f64::max);
    if let Some(skip_s) = warm_up {
        advice.push(format!(
            "Let the sensor warm up first, or exclude the first {} ({}).",
            duration((skip_s / 60.0).ceil() * 60.0),
            words(&Remedy::Skip(None))
        ));
    }
    let unseen = findings
        .sensors
        .iter()
        .filter(|sensor| sensor.sensor != Sensor::Magnetometer)
        .flat_map(|sensor| &sensor.axes)
        .any(|axis| {
            [axis.bias_instability, axis.random_walk]
                .iter()
                .flatten()
                .any(|parameter| matches!(parameter.status, Status::Bounded | Status::NotObservable))
        });
    if unseen || findings.timing.duration_s() < 3.0 * 3600.0 {
        advice.push(format!("Record longer, at a constant temperature: N is known to a few percent after minutes; bias instability needs ten minutes to hours, the longer the lower it is, rate random walk hours to days. `{}` says how long.", words(&Remedy::Plan)));
    }
    if is_ours && (!findings.has_stamps || !findings.has_registers || !findings.has_conditions) {
        advice.push(format!("Record with `{}`: it stores arrival times, registers, temperature and conditions, which this record lacks in part.", words(&Remedy::Record)));
    }
    if findings.timing.rate_from == RateFrom::Assumed {
        advice.push(format!("Set {} if the sensor did not run at the assumed rate.", words(&Remedy::GiveRate(None))));
    }
    if advice.is_empty() {
        advice.push(
            "Nothing in this record needs improvement; repeat it over power cycles and days to see the repeatability."
                .into(),
        );
    }
    advice
}
