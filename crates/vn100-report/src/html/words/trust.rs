//! How far the numbers can be trusted.

use crate::{
    numbers::{digits, grouped, plain::counted, trimmed},
    units::pretty_unit,
};
use vn100_analysis::noise::{Parameter, Status};
use vn100_analysis::{MissingFrom, RateFrom, Timing, WarningKind};

use super::listed;
use crate::html::findings::{AxisFindings, Findings};

pub(super) fn trust(findings: &Findings) -> Vec<String> {
    let mut sentences = vec![moved(findings), time_base(findings), losses(findings)];
    // what follows is of the noise
    if findings.motion.is_none() {
        sentences.extend([fits(findings), vibration(findings), stationarity(findings), alone(findings)]);
    }
    sentences.into_iter().flatten().collect()
}

/// First of all: noise is measured at rest.
fn moved(findings: &Findings) -> Option<String> {
    let motion = findings.motion.as_ref()?;
    Some(format!("No: {}. All figures describe the motion, not the noise.", pretty_unit(&motion.to_string())))
}

fn time_base(findings: &Findings) -> Option<String> {
    Some(if findings.timing.rate_from == RateFrom::Assumed {
        format!(
            "The sample rate is assumed to be {} Hz; the capture does not contain it. If the true rate is 1 % higher, N is 0.5 % lower and all averaging times are 1 % shorter.",
            trimmed(findings.timing.rate_hz, 3)
        )
    } else if findings.warns(WarningKind::RateOffNominal) && findings.offset_ppm.is_none() {
        format!(
            "The sample rate of {} Hz is unsure, as many samples are missing by it (see the cautions): averaging times are wrong by as much, N by half of it.",
            trimmed(findings.timing.rate_hz, 3)
        )
    } else if findings.warns(WarningKind::RateOffNominal) {
        "The measured rate differs from the one used (see the cautions): averaging times are wrong by the same share, N by half of it.".into()
    } else {
        let from = match findings.timing.rate_from {
            RateFrom::Option => "as given by the user",
            RateFrom::DeviceTime => "by the sensor's own clock",
            RateFrom::Device => "as reported by the sensor",
            RateFrom::Arrival | RateFrom::Assumed => "from arrival times",
        };
        let off = findings
            .offset_ppm
            .map_or_else(String::new, |ppm| format!("; measured {} ppm from nominal (negligible)", trimmed(ppm, 0)));
        format!("The sample rate is {} Hz, {from}{off}.", trimmed(findings.timing.rate_hz, 3))
    })
}

fn losses(findings: &Findings) -> Option<String> {
    let Timing { samples, missing, missing_from, gaps, .. } = findings.timing;
    if samples < 2 {
        return None;
    }
    let text = match missing {
        0 if findings.outages.times > 0 => format!(
            "The link was {}: samples sent then are missing and not counted, and no averaging window spans that. Otherwise no sample was dropped among {}.",
            findings.outages,
            grouped(samples)
        ),
        0 if findings.has_stamps => {
            let by = match missing_from {
                MissingFrom::DeviceTime => "device time",
                MissingFrom::Counter => "the row counter",
                MissingFrom::Arrival | MissingFrom::RejectedRows => "arrival times",
            };
            format!("No sample was dropped among {}, judged by {by}.", grouped(samples))
        }
        0 => format!(
            "No line was rejected among {} samples; entirely missing lines cannot be detected without arrival times.",
            grouped(samples)
        ),
        _ => format!(
            "{} of {} samples were dropped, in {}. Clusters average the samples that are there; those that lack more than half are \
             excluded.",
            grouped(missing),
            grouped(samples + missing),
            counted(gaps, "gap")
        ),
    };
    Some(if missing > 0 && findings.outages.times > 0 {
        let counted = match missing_from {
            MissingFrom::DeviceTime => "among these where the clock of the sensor ran on, else not counted",
            _ => "not counted",
        };
        format!("{text} The link was {}: samples sent then are {counted}.", findings.outages)
    } else {
        text
    })
}

fn fits(findings: &Findings) -> Option<String> {
    let judged = |axis: &&AxisFindings| axis.white.is_some();
    let (fitted, unfitted): (Vec<&AxisFindings>, Vec<&AxisFindings>) =
        findings.axes().filter(judged).partition(|axis| axis.quality.is_some());
    let names = |axes: &[&AxisFindings]| listed(&axes.iter().map(|axis| axis.name.clone()).collect::<Vec<_>>());
    let least = fitted.iter().filter_map(|axis| Some(axis.quality?.p)).reduce(f64::min);
    // white noise may be bounded without a model
    let is_rejected = |white: Parameter| matches!(white.status, Status::ModelRejected | Status::Bounded);
    let rejected: Vec<&AxisFindings> =
        unfitted.into_iter().filter(|axis| axis.white.is_some_and(is_rejected)).collect();
    let fitted = least.map(|least| {
        format!("The noise model fits the curves of {} over the fitted range of averaging times (smallest p {}; rejected below 0.01).", names(&fitted), digits(least, 2))
    });
    let rejected = (!rejected.is_empty())
        .then(|| format!("Model rejected for {}: only an upper bound for N is given there.", names(&rejected)));
    let parts: Vec<String> = fitted.into_iter().chain(rejected).collect();
    (!parts.is_empty()).then(|| parts.join(" "))
}

fn vibration(findings: &Findings) -> Option<String> {
    let shaken: Vec<String> = (findings.axes())
        .filter_map(|axis| {
            let (hz, share) = axis.lines.first()?;
            let percent = if *share < 0.005 { "below 1".into() } else { format!("{:.0}", 100.0 * share) };
            Some(format!("{} {hz:.1} Hz ({percent} %)", axis.name))
        })
        .collect();
    let trimmed_fits = trimmed_fits(findings);
    if shaken.is_empty() && trimmed_fits.is_empty() {
        return None;
    }
    let mut text = match shaken.is_empty() {
        true => "No spectral peak was found.".to_owned(),
        false => format!(
            "Vibration detected (strongest peak of each axis, share of the short-term variance): {}.",
            listed(&shaken)
        ),
    };
    if !trimmed_fits.is_empty() {
        let why = match shaken.is_empty() {
            true => "averaging and low pass within the sensor make neighbouring samples alike",
            false => "N excludes the vibration",
        };
        text += &format!(" The shortest averaging times are excluded from the fit, {}: {why}.", listed(&trimmed_fits));
    }
    Some(text)
}

/// Averaging times that no fit includes, with the axes of each: `below 0.02 s on gyro_x`.
fn trimmed_fits(findings: &Findings) -> Vec<String> {
    let mut fits: Vec<(f64, Vec<String>)> = Vec::new();
    for axis in findings.axes() {
        let (Some(first_s), Some(quality)) = (axis.first_tau_s, axis.quality) else { continue };
        if quality.tau_min_s <= 1.5 * first_s {
            continue;
        }
        match fits.iter_mut().find(|(tau_s, _)| *tau_s == quality.tau_min_s) {
            Some((_, names)) => names.push(axis.name.clone()),
            None => fits.push((quality.tau_min_s, vec![axis.name.clone()])),
        }
    }
    fits.into_iter().map(|(tau_s, names)| format!("below {} s on {}", trimmed(tau_s, 3), listed(&names))).collect()
}

fn stationarity(findings: &Findings) -> Option<String> {
    let of = |happened: fn(&AxisFindings) -> bool| -> Vec<String> {
        findings.axes().filter(|axis| happened(axis)).map(|axis| axis.name.clone()).collect()
    };
    let disturbed = of(|axis| axis.disturbances > 0);
    let stepped = of(|axis| axis.steps);
    let cycling = of(|axis| axis.cycles);
    let changing = of(|axis| axis.noise_changes);
    let warming = of(|axis| axis.warm_up_s.is_some());
    let parts = [
        ("momentary disturbances", disturbed),
        ("changing noise level", changing),
        ("step of the level", stepped),
        ("cycle of the level", cycling),
        ("warm-up transient", warming),
    ];
    if parts.iter().all(|(_, names)| names.is_empty()) {
        // two samples have no pieces
        let long_enough = findings.axes().any(|axis| axis.known_to_s.is_some());
        let judged = long_enough && !findings.warns(WarningKind::NotStationary);
        let shown = findings.axes().filter_map(|axis| axis.detectable_factor).reduce(f64::max).map(|factor| {
            format!(" A noise increase of {factor:.2} times from the middle on would have been detected on any axis.")
        });
        let sentence = "No disturbance, step, cycle or warm-up was found: the record is stationary.";
        return judged.then(|| sentence.to_owned() + &shown.unwrap_or_default());
    }
    let changes: Vec<String> = (parts.into_iter())
        .filter(|(_, names)| !names.is_empty())
        .map(|(what, names)| format!("{what}: {}", listed(&names)))
        .collect();
    Some(format!(
        "The record is not stationary ({}); the cautions give the times. Deviations at averaging times longer than a disturbance contain it.",
        changes.join("; ")
    ))
}

fn alone(findings: &Findings) -> Option<String> {
    findings.axes().any(|axis| axis.known_to_s.is_some()).then(|| {
        "Intervals are pointwise, not simultaneous, since neighbouring points share samples. They cover sampling uncertainty only, not unit-to-unit, day-to-day or temperature variation.".into()
    })
}
