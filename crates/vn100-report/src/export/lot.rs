//! The table for incoming inspection: a row for each sensor and capture.

use vn100_analysis::noise::{Parameter, Sensor, Term, Verdict};

use super::tables::{Table, identity, number};
use crate::{
    codes::{code_of_status, code_of_verdict},
    measured::Record,
    names::in_unit,
    units::ChannelValues,
};

/// The beginning of the header: columns of the identity.
pub(super) const FIRST_COLUMNS: &str = "capture,stream,sha256,model,serial_number,firmware,started_utc,";

/// The sensor by its short name, and of each parameter the letter and the unit.
type SensorColumns = (&'static str, Sensor, &'static [(&'static str, Term, &'static str)]);

/// The parameters, each with its letter and the unit of data sheets.
const PARAMETERS: [SensorColumns; 3] = [
    (
        "gyro",
        Sensor::Gyroscope,
        &[
            ("N", Term::White, "deg/sqrt(h)"),
            ("B", Term::BiasInstability, "deg/h"),
            ("K", Term::RateRandomWalk, "deg/h^1.5"),
        ],
    ),
    (
        "accel",
        Sensor::Accelerometer,
        &[
            ("N", Term::White, "mg/sqrt(Hz)"),
            ("B", Term::BiasInstability, "mg"),
            ("K", Term::RateRandomWalk, "mg/sqrt(h)"),
        ],
    ),
    ("mag", Sensor::Magnetometer, &[("N", Term::White, "gauss/sqrt(Hz)")]),
];

/// The table as CSV: identity, the verdict on all figures of the data sheet together, the warnings,
/// and N, B and K of each axis with status, interval and verdict. Units are in the header. The row
/// of a record without samples has only its error.
#[must_use]
pub fn lot_table(records: &[Record<'_>]) -> String {
    let mut header: Vec<String> = records
        .first()
        .map_or_else(Vec::new, |record| identity(record).iter().map(|(name, _)| (*name).into()).collect());
    header.extend(["error", "verdict", "warnings"].map(String::from));
    for (name, _, unit) in axes() {
        header.extend([format!("{name} status"), format!("{name} [{unit}]")]);
        header.extend(["lower", "upper"].map(|end| format!("{name} {end} [{unit}]")));
        header.push(format!("{name} verdict"));
    }
    let mut table = Table(String::new());
    table.row(&header.iter().map(String::as_str).collect::<Vec<_>>());
    for record in records {
        let cells = cells(record);
        table.row(&cells.iter().map(String::as_str).collect::<Vec<_>>());
    }
    table.0
}

/// Each parameter of each axis: its name, what it is, and its unit.
fn axes() -> impl Iterator<Item = (String, (String, Sensor, Term), &'static str)> {
    PARAMETERS.into_iter().flat_map(|(prefix, sensor, parameters)| {
        ["x", "y", "z"].into_iter().flat_map(move |axis| {
            parameters.iter().map(move |(letter, term, unit)| {
                let channel = format!("{prefix}_{axis}");
                (format!("{channel} {letter}"), (channel, sensor, *term), *unit)
            })
        })
    })
}

fn cells(record: &Record<'_>) -> Vec<String> {
    let measured = record.measured;
    let mut cells: Vec<String> = identity(record).into_iter().map(|(_, value)| value).collect();
    let all = record.channels.iter().flat_map(|channel| record.verdicts(channel)).map(|verdict| verdict.verdict);
    // of several warnings of a kind, which differ in their channels, the kind once
    let mut warnings: Vec<String> = Vec::new();
    for warning in measured.warnings() {
        let warning = format!("{}:{}", warning.severity.name(), warning.kind.name());
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }
    cells.push(measured.facts.error.clone().unwrap_or_default());
    // a sensor that was moved is compared with nothing
    let moved = measured.assessment.motion.as_ref().map(|_| Verdict::NotComparable);
    cells.push(worst(all.chain(moved)));
    cells.push(warnings.join(" "));
    for (_, (channel, sensor, term), unit) in axes() {
        let channel = record.channels.iter().find(|found| found.name == channel);
        cells.extend(parameter(record, channel, (sensor, term), unit));
    }
    cells
}

fn parameter(
    record: &Record<'_>,
    channel: Option<&ChannelValues>,
    (sensor, term): (Sensor, Term),
    unit: &str,
) -> [String; 5] {
    let found = channel.and_then(|channel| Some((channel, channel.noise.as_ref()?.parameter(term)?)));
    let Some((channel, Parameter { status, value, lower, upper, .. })) = found else { return Default::default() };
    let (_, factor) = in_unit(sensor, term, unit);
    let [value, lower, upper] = [value, lower, upper].map(|si| number(si.map(|si| si * factor)));
    let of_term = record.verdicts(channel).iter().filter(|verdict| verdict.figure.term == term);
    [code_of_status(status).code.into(), value, lower, upper, worst(of_term.map(|verdict| verdict.verdict))]
}

/// The worst for the sensor; what the stream does not carry decides nothing where there is another.
fn worst(verdicts: impl Iterator<Item = Verdict>) -> String {
    let rank = |verdict: &Verdict| match verdict {
        Verdict::NotComparable => usize::MAX,
        verdict => Verdict::ALL.iter().position(|other| other == verdict).unwrap_or(usize::MAX),
    };
    verdicts.min_by_key(rank).map_or_else(String::new, |verdict| code_of_verdict(verdict).code.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_verdict_is_that_of_the_sensor_and_not_of_the_stream() {
        let of = |verdicts: &[Verdict]| worst(verdicts.iter().copied());
        assert_eq!(of(&[Verdict::NotComparable, Verdict::Pass]), "pass");
        assert_eq!(of(&[Verdict::Pass, Verdict::Fail, Verdict::Inconclusive]), "fail");
        assert_eq!((of(&[Verdict::NotComparable]).as_str(), of(&[]).as_str()), ("not-comparable", ""));
    }

    #[test]
    fn every_unit_is_one_of_its_parameter() {
        for (name, (_, sensor, term), unit) in axes() {
            assert_eq!(in_unit(sensor, term, unit).0, unit, "{name}");
        }
    }
}
