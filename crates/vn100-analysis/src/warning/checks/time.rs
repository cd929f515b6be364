//! Warnings about the rate, the times of the samples, and their number.

use imu_noise::timebase::{Arrivals, NominalRate, Refusal, TimebaseSummary, Unevenness};
use vn100_protocol::{BinaryOutput, MEASUREMENTS_PER_S, Register, RegisterValue};

use crate::{
    accumulate::sensor_rates::rates_hz,
    remedy::Remedy,
    sensor::sensor_of,
    snapshot::{MissingFrom, RateFrom, Snapshot, Timing},
    warning::{Finding, Severity, Warning},
};

/// The least number of samples: three terms need four octaves, the last of which then has ten degrees
/// of freedom in white noise, enough for intervals with their stated coverage.
const LEAST_SAMPLES: u64 = 66;

pub(super) fn warnings(snapshot: &Snapshot) -> Vec<Warning> {
    let timing = &snapshot.timing;
    let mut warnings = changes(snapshot);
    warnings.extend(snapshot.false_report.clone().map(Warning::new));
    warnings.extend(refused_stamps(snapshot));
    if let Some(arrivals) = &snapshot.arrivals {
        warnings.extend(on_arrivals(arrivals, rates_hz(snapshot.layout.as_deref()), timing));
    }
    let counted = |count: u64, finding: fn(u64) -> Finding| (count > 0).then(|| Warning::new(finding(count)));
    warnings.extend(counted(snapshot.moved_rows, Finding::Reordered));
    warnings.extend(counted(snapshot.restarts, Finding::Restarts));
    warnings.extend(counted(snapshot.time_steps, Finding::TimeSteps));
    warnings.extend(packet_rate(snapshot));
    if timing.missing > 0 {
        let found = Finding::Dropped { missing: timing.missing, gaps: timing.gaps, samples: timing.samples };
        warnings.push(Warning::new(found));
    }
    warnings.extend(too_short(snapshot));
    if timing.rate_from == RateFrom::Assumed && timing.samples > 0 {
        let found = Warning::new(Finding::RateAssumed(timing.rate_hz));
        warnings.push(found.cured_by(Remedy::GiveRate(None)));
    }
    warnings
}

/// Changes of the rate within the record, and what they exclude.
fn changes(snapshot: &Snapshot) -> Vec<Warning> {
    let changed = |change| Warning::new(Finding::RateChanged(change, snapshot.timing.excluded));
    let mut warnings = Vec::new();
    warnings.extend(snapshot.rate_change.map(|change| changed(change).cured_by(Remedy::Skip(None))));
    warnings.extend(snapshot.parted.map(changed));
    warnings.extend(snapshot.false_rate.clone().map(Warning::new));
    let burst = snapshot.other_rate_samples;
    warnings.extend((burst > 0).then(|| Warning::new(Finding::BurstExcluded(burst))));
    warnings
}

fn refused_stamps(snapshot: &Snapshot) -> Option<Warning> {
    let refusal = snapshot.arrivals.and_then(|arrivals| arrivals.refusal);
    let is_over = refusal.is_none();
    let refusal = refusal.or(snapshot.refused_before)?;
    let found = Warning::new(Finding::StampsRefused(refusal, is_over));
    let is_other_rate = matches!(refusal, Refusal::OtherRate { .. });
    // averaging times by a given rate that the stamps contradict are wrong
    let is_wrong = is_other_rate && snapshot.timing.rate_from == RateFrom::Option;
    let found = if is_wrong { found.as_severe_as(Severity::Problem) } else { found };
    // the stamps of a link are those of its reads; there and with another rate, one is known
    let is_cured = snapshot.link.connects == 0 && !is_other_rate;
    Some(if is_cured { found.cured_by(Remedy::GiveRate(None)) } else { found })
}

fn too_short(snapshot: &Snapshot) -> Option<Warning> {
    let samples = snapshot.timing.samples;
    let has_sensor = || snapshot.layout_channels().iter().any(|channel| sensor_of(channel.quantity).is_some());
    let is_short = match samples {
        // it becomes longer by itself, or the result says that all is excluded
        0 if snapshot.timing.excluded > 0 && !snapshot.skipped.is_zero() => false,
        0..2 => true,
        // no noise model is fitted to a series without a sensor
        2..LEAST_SAMPLES => has_sensor(),
        LEAST_SAMPLES.. => false,
    };
    let is_short = is_short && snapshot.layout.is_some();
    is_short.then(|| Warning::new(Finding::TooShort(samples)).cured_by(Remedy::Plan))
}

/// Whether packets arrive at the rate of a VN-100, and at the one that its registers set.
fn packet_rate(snapshot: &Snapshot) -> Option<Warning> {
    const SAME_RATE: f64 = 1e-6;
    let timing = &snapshot.timing;
    if timing.rate_from != RateFrom::DeviceTime || timing.samples == 0 {
        return None;
    }
    let (rate_hz, divisor) = (timing.rate_hz, f64::from(MEASUREMENTS_PER_S) / timing.rate_hz);
    if divisor < 1.0 - SAME_RATE || (divisor / divisor.round() - 1.0).abs() > SAME_RATE {
        return Some(Warning::new(Finding::PacketRate(rate_hz)));
    }
    let output = |register: &Register| {
        let output: BinaryOutput = snapshot.register(*register)?;
        Some((register.0, output.rate_hz())).filter(|(_, hz)| *hz > 0.0)
    };
    let set: Vec<(u8, f64)> = BinaryOutput::REGISTERS.iter().filter_map(output).collect();
    let is_other = set.iter().all(|(_, hz)| (hz / rate_hz - 1.0).abs() > SAME_RATE);
    let (register, set_hz) = *set.first().filter(|_| is_other)?;
    Some(Warning::new(Finding::RegisterRate(register, set_hz, rate_hz)))
}

pub(super) fn on_arrivals(summary: &TimebaseSummary, rates_hz: &[f64], timing: &Timing) -> Vec<Warning> {
    // a latency timer delivers nearly every other sentence together with the one before it
    const BUNCHED_SHARE: f64 = 0.2;
    let stamps = |finding, severity| Warning::new(finding).as_severe_as(severity);
    let mut warnings = Vec::new();
    let has_stamps = timing.missing_from != MissingFrom::DeviceTime;
    if has_stamps && summary.refusal.is_none() && summary.backwards > 0 {
        warnings.push(stamps(Finding::Backwards(summary.backwards), Severity::Caution));
    }
    warnings.extend(off_rate(summary, rates_hz, timing.rate_from));
    if summary.flushed > 0 {
        warnings.push(stamps(Finding::Flushed(summary.flushed), Severity::Note));
    }
    if let Some(unevenness) = summary.unevenness {
        let is_irregular = unevenness == Unevenness::Irregular;
        let severity = if is_irregular { Severity::Caution } else { Severity::Note };
        warnings.push(stamps(Finding::Uneven(unevenness), severity));
    }
    // with device times no gap depends on when its packets arrive
    let is_bunched = |arrivals: &Arrivals| has_stamps && arrivals.share_together > BUNCHED_SHARE;
    if let Some(arrivals) = summary.arrivals.filter(is_bunched) {
        let found = Finding::Together(arrivals.share_together, arrivals.samples_together);
        warnings.push(stamps(found, Severity::Note).cured_by(Remedy::MeasureLive));
    }
    warnings
}

fn off_rate(summary: &TimebaseSummary, rates_hz: &[f64], from: RateFrom) -> Option<Warning> {
    // a rate of the user that is off by more makes every averaging time wrong
    const WRONG_PPM: f64 = 10_000.0;
    // no quartz is off by that much
    const CLOCK_PPM: f64 = 1000.0;
    // the error that bursts make in a short record
    const BUNCHING_S: f64 = 0.1;
    // with this share of dropped samples in many gaps another rate, with more or fewer of them,
    // fits the same times
    const UNSURE_SHARE: f64 = 0.1;
    const MANY_GAPS: u64 = 10;
    let nominal = summary.nominal?;
    let missing = summary.missing as f64 / (summary.samples + summary.missing).max(1) as f64;
    let is_unsure = missing > UNSURE_SHARE && summary.gaps >= MANY_GAPS && summary.offset_ppm.is_none();
    let warning = |finding, rate_hz| Some(Warning::new(finding).cured_by(Remedy::GiveRate(rate_hz)));
    match (nominal, summary.measured_hz, summary.offset_ppm) {
        (NominalRate::Measured(_), Some(hz), _) if is_unsure => warning(Finding::RateUnsure(hz, missing), None),
        (NominalRate::Measured(hz), ..) if !rates_hz.is_empty() => warning(Finding::RateNotListed(hz), None),
        (_, Some(hz), Some(ppm)) => {
            let drift_s = ppm.abs() * 1e-6 * summary.samples as f64 / nominal.hz();
            let is_wrong = ppm.abs() > WRONG_PPM && from == RateFrom::Option;
            let found = warning(Finding::RateOff(hz, nominal.hz()), Some(hz))
                .filter(|_| ppm.abs() > CLOCK_PPM && drift_s > BUNCHING_S);
            found.map(|found| if is_wrong { found.as_severe_as(Severity::Problem) } else { found })
        }
        _ => None,
    }
}
