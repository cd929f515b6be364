//! What was measured, with what, and how: everything needed to repeat it. As tables with a name and
//! a value in each row.

use crate::{
    facts::{NOT_RECORDED, Row, fact, or_not_recorded, timing},
    numbers::{grouped, plain::time, trimmed},
    printable,
    warnings::capitalised,
};
use maud::{Markup, html};
use vn100_analysis::noise::{Deviation, Estimator};
use vn100_analysis::protocol::{ImuFilter, Quantity, Register, RegisterContents, RegisterFields};
use vn100_analysis::{ChannelResult, RateFrom, SourceResult};

use crate::html::{
    caption::Captions,
    options::{PageOptions, Program},
};

/// What a user can write down in a file of conditions, by the names there.
const CONDITIONS: [(&str, &str); 8] = [
    ("place", "Place"),
    ("mounting", "Mounting"),
    ("axis_up", "Axis up"),
    ("temperature", "Ambient temperature"),
    ("supply", "Supply"),
    ("operator", "Operator"),
    ("purpose", "Purpose"),
    ("note", "Note"),
];

pub(crate) fn facts(record: &SourceResult, options: PageOptions<'_>, captions: &Captions) -> Markup {
    let tables = [
        ("Capture", capture(record, options.program)),
        ("Sensor", sensor(record)),
        ("Conditions", conditions(record)),
        ("Marks", marks(record)),
        ("Time base and losses", timing(record)),
        ("Method", method(record, options.asked)),
        ("Uncertainty and traceability", traceability(record)),
        ("Signatures", signatures(record)),
    ];
    html! {
        @for (name, rows) in tables.iter().filter(|(_, rows)| !rows.is_empty()) {
            (facts_table(name, rows, captions))
        }
    }
}

fn capture(record: &SourceResult, program: Program<'_>) -> Vec<Row> {
    let source = &record.source;
    let (file, recorded) = (source.file.as_ref(), source.recording.as_ref());
    let end = recorded.and_then(|recorded| recorded.end.as_ref());
    let reason = end.and_then(|end| match (&end.reason, end.complete) {
        (reason, true) => reason.clone(),
        (_, false) => Some("cut: its end or a part is missing".into()),
    });
    let mut rows = vec![
        fact("File", source.name.clone()),
        fact("Form", source.kind.unwrap_or("not recognised")),
        or_not_recorded("Size", file.map(|file| format!("{} bytes", grouped(file.bytes)))),
        or_not_recorded("SHA-256", file.map(|file| file.sha256.clone())),
        or_not_recorded("Start (UTC)", recorded.and_then(|recorded| recorded.started())),
        or_not_recorded("End (UTC)", recorded.and_then(|recorded| recorded.ended())),
        or_not_recorded("End reason", reason),
        or_not_recorded("Recorded by", recorded.and_then(|recorded| recorded.program.clone())),
        fact("Report by", format!("{}, commit {}", program.name, program.commit.unwrap_or(NOT_RECORDED))),
        or_not_recorded("Message", source.message.clone()),
        or_not_recorded(
            "Compensated by the sensor",
            source.compensated.map(|compensated| if compensated { "yes" } else { "no" }.into()),
        ),
    ];
    if let Some(csv) = &source.csv {
        let rejected = csv.rejected.iter().map(|rows| format!("{} ({})", grouped(rows.count), rows.reason));
        let absent = csv.absent.iter().map(|absent| format!("{} in {} rows", absent.channel, grouped(absent.total())));
        let left_out = csv.left_out.iter().map(|column| format!("{}: {}", column.name, column.reason));
        let counts = [
            fact("Lines", format!("{}, {} rows used", grouped(csv.lines), grouped(csv.rows))),
            fact("Rejected rows", listed(rejected)),
            fact("Missing values", listed(absent)),
        ];
        // they are counted at the end of the file
        rows.extend(counts.into_iter().filter(|_| csv.lines > 0));
        rows.extend([
            or_not_recorded("Times of column", csv.times.clone()),
            fact("Columns not used", listed(csv.ignored_columns.iter().cloned().chain(left_out))),
        ]);
    }
    if let Some(bag) = &source.bag {
        rows.extend([
            fact("Topic", bag.topic.clone()),
            fact("Messages", format!("{} of {}, {} used", grouped(bag.messages), bag.type_name, grouped(bag.used))),
            fact("Time stamps", bag.stamps.to_string()),
        ]);
    }
    rows
}

/// All of them in one line, or that there are none.
fn listed(texts: impl Iterator<Item = String>) -> String {
    let texts: Vec<String> = texts.collect();
    if texts.is_empty() { "none".into() } else { texts.join("; ") }
}

/// The identity of the sensor, and every other register that was read, as printed.
fn sensor(record: &SourceResult) -> Vec<Row> {
    const IDENTITY: [(&str, Register); 4] = [
        ("Model", Register::MODEL),
        ("Hardware revision", Register::HARDWARE_REVISION),
        ("Serial number", Register::SERIAL_NUMBER),
        ("Firmware", Register::FIRMWARE),
    ];
    let registers = record.source.device.iter().flat_map(|device| &device.registers);
    let text = |register: Register| {
        registers.clone().find(|(number, _)| **number == register.0).map(|(_, text)| text.trim().to_owned())
    };
    let identity = IDENTITY.map(|(name, register)| or_not_recorded(name, text(register)));
    let others = registers.clone().filter(|(number, _)| IDENTITY.iter().all(|(_, register)| register.0 != **number));
    let others = others.map(|(number, text)| {
        let name = Register(*number).name().unwrap_or("register");
        let averaging = averaging(Register(*number), text).map(|words| format!("{words} [{}]", text.trim()));
        fact(&capitalised(&format!("{name} (register {number})")), averaging.unwrap_or_else(|| text.trim().to_owned()))
    });
    identity.into_iter().chain(others).collect()
}

/// Register 85 in words; `None` for any other, and for one that is not what it should be.
fn averaging(register: Register, text: &str) -> Option<String> {
    let fields = RegisterFields::new(text).filter(|_| register == Register::IMU_FILTER)?;
    let filter: ImuFilter = RegisterContents { register, fields }.value().ok()?;
    let ImuFilter { gyro_window, accel_window, mag_window, .. } = filter;
    Some(format!(
        "averages {gyro_window} refreshes of the gyroscope, {accel_window} of the accelerometer, {mag_window} of the magnetometer"
    ))
}

fn conditions(record: &SourceResult) -> Vec<Row> {
    let meta = record.source.meta.as_ref();
    let of = |name: &str| meta.and_then(|meta| meta.get(name)).cloned();
    let mut rows: Vec<Row> = CONDITIONS.iter().map(|(name, shown)| or_not_recorded(shown, of(name))).collect();
    let temperature =
        record.of(Quantity::Temperature).first().and_then(|channel| channel.statistics.min.zip(channel.statistics.max));
    let temperature = temperature.map(|(min, max)| format!("{min:.1} to {max:.1} °C"));
    rows.push(or_not_recorded("Temperature of the sensor", temperature));
    let others = meta.into_iter().flatten().filter(|(name, _)| CONDITIONS.iter().all(|(known, _)| known != name));
    rows.extend(others.map(|(name, value)| fact(name, value.clone())));
    rows
}

/// What the user said of places in the record, by the data time.
pub(crate) fn marks(record: &SourceResult) -> Vec<Row> {
    record.source.marks.iter().map(|mark| fact(&time(mark.at_s), printable(&mark.text))).collect()
}

/// What is not recorded stands in one line below the table.
pub(crate) fn facts_table(name: &str, rows: &[Row], captions: &Captions) -> Markup {
    let (absent, known): (Vec<&Row>, Vec<&Row>) = rows.iter().partition(|(_, value)| value == NOT_RECORDED);
    let absent: Vec<&str> = absent.iter().map(|(name, _)| name.as_str()).collect();
    html! {
        @if !known.is_empty() {
            div.scroll {
                table.facts {
                    (captions.table(name))
                    tbody { @for (name, value) in &known { tr { th scope="row" { (name) } td { (value) } } } }
                }
            }
        }
        @if !absent.is_empty() { p.absent { @if known.is_empty() { (name) ", not" } @else { "Not" } " recorded: " (absent.join(", ")) "." } }
    }
}

/// What a signed report has to state; what a person fills in is left open.
fn traceability(record: &SourceResult) -> Vec<Row> {
    let level = trimmed(100.0 * record.confidence, 2);
    vec![
        fact("Time", clock(record.timing.rate_from, record.timing.offset_ppm, record.timing.measured_hz)),
        fact("Scale factor", "not verified: a record at rest does not show it"),
        fact(
            "Coverage",
            format!(
                "{level} % pointwise confidence intervals of the sampling uncertainty; not unit-to-unit, day-to-day or temperature variation"
            ),
        ),
        fact(
            "Decision rule",
            "pass if the whole interval lies below the limit, fail if it lies above, else undecided (guard band as ILAC-G8: the half-width of the interval)",
        ),
        fact(
            "Not tested",
            "turn-on to turn-on bias, misalignment, sensitivity to supply and acceleration; slow motion that looks like noise",
        ),
        fact("Method", "IEEE Std 952 and NIST SP 1065; the tables above have program and checksum of the capture"),
    ]
}

/// What the rate and all averaging times rest on.
fn clock(rate_from: Option<RateFrom>, offset_ppm: Option<f64>, measured_hz: Option<f64>) -> String {
    // the times of packets are the sensor's own
    let is_of_sensor = rate_from == Some(RateFrom::DeviceTime);
    let clock = if is_of_sensor { "sensor" } else { "host" };
    match offset_ppm {
        _ if matches!(rate_from, None | Some(RateFrom::Assumed)) => "sample rate assumed, not traceable".into(),
        Some(ppm) => format!(
            "clock of the {clock}, {} ppm from the nominal rate; its own tolerance is not verified",
            trimmed(ppm, 1)
        ),
        None if is_of_sensor => "clock of the sensor; its own tolerance is not verified".into(),
        None if measured_hz.is_some() => "clock of the host, not compared with a nominal rate".into(),
        None => "nominal rate of the sensor, not verified without arrival times".into(),
    }
}

const OPEN: &str = "............................................";

/// Lines to be filled in by hand; the operator where the conditions name one.
fn signatures(record: &SourceResult) -> Vec<Row> {
    let meta = record.source.meta.as_ref();
    let operator = meta.and_then(|meta| meta.get("operator")).cloned();
    vec![fact("Operator", operator.unwrap_or_else(|| OPEN.into())), fact("Date", OPEN), fact("Approved by", OPEN)]
}

pub(crate) fn method(record: &SourceResult, asked: &str) -> Vec<Row> {
    vec![
        fact(
            "Deviation",
            match record.settings().deviation {
                Deviation::Allan => "Allan, over octaves τ = 1, 2, 4, … sample intervals [1, 2]",
                Deviation::Hadamard => "Hadamard, over octaves τ = 1, 2, 4, … sample intervals [2]",
            },
        ),
        fact(
            "Averaging times shown",
            match record.channels.iter().any(ChannelResult::has_other_times) {
                true => "those requested; the model is fitted to the octaves",
                false => "the octaves",
            },
        ),
        fact(
            "Estimator",
            match record.settings().estimator {
                Estimator::Strided => {
                    "windows at stride τ/16: all overlaps up to τ = 16 samples, within 1 % of the information of all overlaps beyond"
                }
                Estimator::Full => "all overlaps (OADEV)",
                Estimator::Plain => "no overlap (ADEV)",
            },
        ),
        fact(
            "Confidence",
            format!(
                "{} % two-sided, chi-squared with the degrees of freedom of the fitted noise mixture [3]; intervals are pointwise",
                trimmed(100.0 * record.confidence, 2)
            ),
        ),
        fact(
            "Model",
            "N²/τ + 0.4413·B² + K²τ/3 + R²τ²/2 [4], squared amplitudes not negative: one penalised likelihood of the spectral density, of the level by blocks and of the octaves that neither holds",
        ),
        fact(
            "Conventions",
            "N is two-sided, as Kalibr takes it; data sheets print two-sided or one-sided densities, and one-sided N is √2 times as large. B is the flat part of the curve over 0.664",
        ),
        fact("Options", asked),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_is_the_one_of_the_times() {
        let host = "clock of the host, 3 ppm from the nominal rate; its own tolerance is not verified";
        for (from, ppm, measured_hz, said) in [
            (RateFrom::Device, Some(3.0), Some(40.0), host),
            (RateFrom::Device, None, Some(40.0), "clock of the host, not compared with a nominal rate"),
            (RateFrom::Device, None, None, "nominal rate of the sensor, not verified without arrival times"),
            (RateFrom::DeviceTime, Some(3.0), Some(40.0), &host.replace("host", "sensor")),
            (RateFrom::DeviceTime, None, None, "clock of the sensor; its own tolerance is not verified"),
            (RateFrom::Assumed, Some(3.0), Some(40.0), "sample rate assumed, not traceable"),
        ] {
            assert_eq!(clock(Some(from), ppm, measured_hz), said);
        }
    }
}
