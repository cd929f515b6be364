//! What was measured, with what, and how: everything needed to repeat it. As tables with a name and
//! a value in each row.

use crate::{
    Record, RecordingDocument,
    names::echoes,
    numbers::{
        duration, grouped,
        plain::{counted, time},
        trimmed,
    },
    printable,
};
use maud::{Markup, html};
use vn100_analysis::noise::{Deviation, Estimator};
use vn100_analysis::protocol::{
    AsyncRate, AsyncType, BaudRate, Calibration, ImuFilter, Quantity, ReferenceFrameRotation, Register,
    RegisterContents, RegisterFields, RegisterValue, StartupGyroBias, VpeControl,
};
use vn100_analysis::timebase::Arrivals;
use vn100_analysis::{MissingFrom, RateFrom, Snapshot};

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

/// The registers that decide what the noise looks like.
const REGISTERS: [Register; 10] = [
    Register::BAUD_RATE,
    Register::ASYNC_TYPE,
    Register::ASYNC_RATE,
    Register::MAG_CALIBRATION,
    Register::ACCEL_CALIBRATION,
    Register::ROTATION,
    Register::VPE_CONTROL,
    Register::STARTUP_GYRO_BIAS,
    Register::GYRO_CALIBRATION,
    Register::IMU_FILTER,
];

pub(crate) fn facts(record: &Record<'_>, options: PageOptions<'_>, captions: &Captions) -> Markup {
    let tables = [
        ("Capture", capture(record, options.program)),
        ("Sensor", sensor(record)),
        ("Conditions", conditions(record)),
        ("Marks", marks(&record.measured.snapshot)),
        ("Time base and losses", timing(record)),
        ("Method", method(record, options.asked)),
        ("Uncertainty and traceability", traceability(record, options)),
        ("Signatures", signatures(record)),
    ];
    html! {
        @for (name, rows) in tables.iter().filter(|(_, rows)| !rows.is_empty()) {
            (facts_table(name, rows, captions))
        }
    }
}

fn capture(record: &Record<'_>, program: Program<'_>) -> Vec<Row> {
    let (facts, snapshot) = (&record.measured.facts, &record.measured.snapshot);
    let file = facts.file.as_ref();
    let recorded = facts.recording.as_ref().map(RecordingDocument::new);
    let of = |part: fn(&RecordingDocument) -> Option<String>| recorded.as_ref().and_then(part);
    let mut rows = vec![
        fact("File", facts.name.clone()),
        fact("Form", facts.kind.unwrap_or("not recognised")),
        or_not_recorded("Size", file.map(|file| format!("{} bytes", grouped(file.bytes)))),
        or_not_recorded("SHA-256", file.map(|file| file.sha256.clone())),
        or_not_recorded("Start (UTC)", of(|recorded| recorded.started.clone())),
        or_not_recorded("End (UTC)", of(|recorded| recorded.ended.clone())),
        or_not_recorded("End reason", of(|recorded| recorded.end_reason.clone())),
        or_not_recorded("Recorded by", of(|recorded| recorded.program.clone())),
        fact("Report by", format!("{}, commit {}", program.name, program.commit.unwrap_or(NOT_RECORDED))),
        or_not_recorded("Message", snapshot.layout.as_ref().map(|layout| layout.message.to_string())),
        or_not_recorded(
            "Compensated by the sensor",
            snapshot
                .layout
                .as_ref()
                .and_then(|layout| layout.compensated)
                .map(|compensated| if compensated { "yes" } else { "no" }.into()),
        ),
    ];
    if let Some(bag) = &facts.bag {
        rows.extend([
            fact("Topic", bag.topic.clone()),
            fact("Messages", format!("{} of {}, {} used", grouped(bag.messages), bag.type_name, grouped(bag.used))),
            fact("Time stamps", bag.stamps.to_string()),
            fact("Out of order", format!("{} reordered, {} too late for that", bag.reordered, bag.late)),
        ]);
        rows.extend(bag.unread.iter().map(|unread| fact("Not read", unread.to_string())));
    }
    rows
}

fn sensor(record: &Record<'_>) -> Vec<Row> {
    let registers = &record.measured.snapshot.registers;
    let text = |register: Register| registers.get(&register.0).map(|text| text.trim().to_owned());
    let identity = [
        ("Model", Register::MODEL),
        ("Hardware revision", Register::HARDWARE_REVISION),
        ("Serial number", Register::SERIAL_NUMBER),
        ("Firmware", Register::FIRMWARE),
    ];
    let mut rows: Vec<Row> =
        identity.into_iter().map(|(name, register)| or_not_recorded(name, text(register))).collect();
    rows.extend(REGISTERS.into_iter().map(|register| {
        let name = format!("{} (register {})", register.name().unwrap_or("register"), register.0);
        or_not_recorded(&capitalised(&name), text(register).map(|text| in_words(register, &text)))
    }));
    rows
}

/// The register's contents with their meaning; as printed where they are not what they should be.
fn in_words(register: Register, text: &str) -> String {
    let known = match register {
        Register::BAUD_RATE => value::<BaudRate>(register, text).map(|speed| format!("{} baud", speed.bits_per_s())),
        Register::ASYNC_TYPE => {
            value::<AsyncType>(register, text).and_then(|message| message.header().map(str::to_owned))
        }
        Register::ASYNC_RATE => value::<AsyncRate>(register, text).map(|rate| format!("{rate} Hz")),
        Register::MAG_CALIBRATION | Register::ACCEL_CALIBRATION | Register::GYRO_CALIBRATION => {
            value::<Calibration>(register, text).map(|calibration| calibrated(&calibration))
        }
        Register::ROTATION => value::<ReferenceFrameRotation>(register, text).map(|rotation| {
            if rotation.matrix == IDENTITY {
                "none (identity)".into()
            } else {
                format!("matrix {}", list(rotation.matrix.as_flattened()))
            }
        }),
        Register::VPE_CONTROL => value::<VpeControl>(register, text).map(attitude_filter),
        Register::STARTUP_GYRO_BIAS => {
            value::<StartupGyroBias>(register, text).map(|bias| format!("{} rad/s", list(&bias.bias_rad_s)))
        }
        Register::IMU_FILTER => value::<ImuFilter>(register, text).map(averaging),
        _ => None,
    };
    known.map_or_else(|| format!("as printed: {text}"), |known| format!("{known} [{text}]"))
}

fn value<T: RegisterValue>(register: Register, text: &str) -> Option<T> {
    let fields = RegisterFields::new(text).ok()?;
    RegisterContents { register, fields }.value().ok()
}

const IDENTITY: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn calibrated(calibration: &Calibration) -> String {
    if calibration.matrix == IDENTITY && calibration.offset == [0.0; 3] {
        return "none by the user (identity, no offset)".into();
    }
    format!("matrix {}, offset {}", list(calibration.matrix.as_flattened()), list(&calibration.offset))
}

fn list(values: &[f32]) -> String {
    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

fn attitude_filter(control: VpeControl) -> String {
    let of = |index: u8, names: &[&str]| {
        names.get(usize::from(index)).map_or_else(|| format!("{index}"), |name| (*name).into())
    };
    format!(
        "{}, heading {}, filtering {}, tuning {}",
        of(control.enable, &["off", "on"]),
        of(control.heading_mode, &["absolute", "relative", "indoor"]),
        of(control.filtering_mode, &["none", "adaptive"]),
        of(control.tuning_mode, &["fixed", "adaptive"])
    )
}

fn averaging(filter: ImuFilter) -> String {
    let which = |mode: u8| match mode {
        0 => "none",
        1 => "uncompensated",
        2 => "compensated",
        _ => "both",
    };
    format!(
        "averages {} refreshes of the gyroscope ({}), {} of the accelerometer ({}), {} of the magnetometer ({})",
        filter.gyro_window,
        which(filter.gyro_mode),
        filter.accel_window,
        which(filter.accel_mode),
        filter.mag_window,
        which(filter.mag_mode)
    )
}

fn conditions(record: &Record<'_>) -> Vec<Row> {
    let meta = record.measured.facts.meta.as_ref();
    let of = |name: &str| meta.and_then(|meta| meta.get(name)).cloned();
    let mut rows: Vec<Row> = CONDITIONS.iter().map(|(name, shown)| or_not_recorded(shown, of(name))).collect();
    let temperature = record.of(Quantity::Temperature).first().and_then(|channel| channel.min.zip(channel.max));
    let temperature = temperature.map(|(min, max)| format!("{min:.1} to {max:.1} °C"));
    rows.push(or_not_recorded("Temperature of the sensor", temperature));
    let others = meta.into_iter().flatten().filter(|(name, _)| CONDITIONS.iter().all(|(known, _)| known != name));
    rows.extend(others.map(|(name, value)| fact(name, value.clone())));
    rows
}

/// What the user said of places in the record, by the data time.
pub(crate) fn marks(snapshot: &Snapshot) -> Vec<Row> {
    let marks = snapshot.marks.iter();
    marks.map(|mark| fact(&time(mark.at_s), printable(&mark.text))).collect()
}

fn timing(record: &Record<'_>) -> Vec<Row> {
    let snapshot = &record.measured.snapshot;
    let (timing, arrivals) = (&snapshot.timing, snapshot.arrivals);
    let from = match timing.rate_from {
        RateFrom::Option => "as given by the user",
        RateFrom::DeviceTime => "from the device time in each packet",
        RateFrom::Device => "reported by the sensor (register 7)",
        RateFrom::Arrival => "from arrival times",
        RateFrom::Assumed => "assumed; the capture does not contain it",
    };
    let by = match timing.missing_from {
        MissingFrom::DeviceTime => "by device time",
        MissingFrom::Counter => "by the row counter",
        MissingFrom::Arrival => "by arrival times",
        MissingFrom::RejectedRows => "by rejected lines; entirely missing lines cannot be detected",
    };
    let measured = arrivals.and_then(|arrivals| {
        let off = |offset| format!(", {} ppm from nominal", trimmed(offset, 1));
        Some(format!("{:.4} Hz{}", arrivals.measured_hz?, arrivals.offset_ppm.map_or_else(String::new, off)))
    });
    let steps = arrivals.and_then(|arrivals| arrivals.arrivals).map(|Arrivals { p50_us, p99_us, max_us, .. }| {
        format!("{p50_us} µs median, {p99_us} µs 99th percentile, {max_us} µs longest")
    });
    let (link, tally) = (&snapshot.link, &snapshot.link.tally);
    let rejected = &tally.rejected;
    vec![
        fact("Samples", format!("{} in {}", grouped(timing.samples), duration(timing.duration_s()))),
        fact("Sample rate", format!("{} Hz, {from}", trimmed(timing.rate_hz, 6))),
        or_not_recorded("Measured rate", measured),
        or_not_recorded("Interarrival times", steps),
        fact("Dropped samples", format!("{}, {by}", dropped(timing.missing, timing.gaps))),
        fact("Segments", timing.segments.to_string()),
        fact(
            "Excluded",
            match (timing.excluded, snapshot.skipped) {
                (0, _) => "nothing".into(),
                (count, skipped) if !skipped.is_zero() => format!(
                    "{} samples: the first {} as requested, or after the requested end",
                    grouped(count),
                    duration(skipped.as_secs_f64())
                ),
                (count, _) => {
                    format!("{} samples after the requested end, or after a change of rate", grouped(count))
                }
            },
        ),
        fact(
            "Rejected lines",
            format!(
                "{} (checksum {}, without checksum {}, grammar {}, range {}, truncated {}, too long {})",
                rejected.total(),
                rejected.checksum,
                rejected.unchecked,
                rejected.grammar,
                rejected.range,
                rejected.truncated,
                rejected.too_long
            ),
        ),
        fact("Damaged packets", grouped(tally.damaged_packets)),
        fact(
            "Valid sentences",
            format!(
                "{} ({} replies, {}{} other messages)",
                grouped(tally.valid_sentences()),
                link.answers(),
                echoes(link.echoes),
                link.other_messages()
            ),
        ),
        fact(
            "Bytes",
            format!(
                "{} ({} discarded, {} lost before this program)",
                grouped(link.bytes()),
                link.skipped_bytes(),
                link.overrun_bytes
            ),
        ),
        fact("Reconnections", link.connects.saturating_sub(1).to_string()),
    ]
}

fn dropped(missing: u64, gaps: u64) -> String {
    format!("{} in {}", grouped(missing), counted(gaps, "gap"))
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The text for what is absent.
pub(crate) const NOT_RECORDED: &str = "not recorded";

pub(crate) type Row = (String, String);

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

pub(crate) fn fact(name: &str, value: impl Into<String>) -> Row {
    (name.to_owned(), value.into())
}

pub(crate) fn or_not_recorded(name: &str, value: Option<String>) -> Row {
    fact(name, value.filter(|value| !value.trim().is_empty()).unwrap_or_else(|| NOT_RECORDED.into()))
}

/// What a signed report has to state; what a person fills in is left open.
fn traceability(record: &Record<'_>, options: PageOptions<'_>) -> Vec<Row> {
    let (facts, snapshot) = (&record.measured.facts, &record.measured.snapshot);
    let level = trimmed(100.0 * record.measured.assessment.confidence, 2);
    let offset_ppm = snapshot.arrivals.and_then(|arrivals| arrivals.offset_ppm);
    vec![
        fact("Time", clock(snapshot.timing.rate_from, offset_ppm)),
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
        fact("Method", "IEEE Std 952 and NIST SP 1065; the table above"),
        fact("Program", format!("{}, commit {}", options.program.name, options.program.commit.unwrap_or(NOT_RECORDED))),
        or_not_recorded("SHA-256 of the capture", facts.file.as_ref().map(|file| file.sha256.clone())),
    ]
}

/// What the rate and all averaging times rest on.
fn clock(rate_from: RateFrom, offset_ppm: Option<f64>) -> String {
    // the times of packets are the sensor's own
    let clock = if rate_from == RateFrom::DeviceTime { "sensor" } else { "host" };
    match offset_ppm {
        _ if rate_from == RateFrom::Assumed => "sample rate assumed, not traceable".into(),
        Some(ppm) => format!(
            "clock of the {clock}, {} ppm from the nominal rate; its own tolerance is not verified",
            trimmed(ppm, 1)
        ),
        None if rate_from == RateFrom::DeviceTime => "clock of the sensor; its own tolerance is not verified".into(),
        None => "nominal rate of the sensor, not verified without arrival times".into(),
    }
}

const OPEN: &str = "............................................";

/// Lines to be filled in by hand; the operator where the conditions name one.
fn signatures(record: &Record<'_>) -> Vec<Row> {
    let meta = record.measured.facts.meta.as_ref();
    let operator = meta.and_then(|meta| meta.get("operator")).cloned();
    vec![fact("Operator", operator.unwrap_or_else(|| OPEN.into())), fact("Date", OPEN), fact("Approved by", OPEN)]
}

pub(crate) fn method(record: &Record<'_>, asked: &str) -> Vec<Row> {
    let snapshot = &record.measured.snapshot;
    vec![
        fact(
            "Deviation",
            match snapshot.deviation {
                Deviation::Allan => "Allan, over octaves τ = 1, 2, 4, … sample intervals [1, 2]",
                Deviation::Hadamard => "Hadamard, over octaves τ = 1, 2, 4, … sample intervals [2]",
            },
        ),
        fact(
            "Averaging times shown",
            match snapshot.channels.iter().any(|channel| !channel.points.is_empty()) {
                true => "those requested; the model is fitted to the octaves",
                false => "the octaves",
            },
        ),
        fact(
            "Estimator",
            match snapshot.estimator {
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
                trimmed(100.0 * record.measured.assessment.confidence, 2)
            ),
        ),
        fact(
            "Model",
            "N²/τ + 0.4413·B² + K²τ/3 + R²τ²/2 [4], squared amplitudes not negative, all octaves weighed by their joint covariance; the shortest are excluded until p ≥ 0.01",
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
    fn the_clock_is_the_one_of_the_times_and_a_single_gap_is_one_gap() {
        let host = "clock of the host, 3 ppm from the nominal rate; its own tolerance is not verified";
        for (from, ppm, said) in [
            (RateFrom::Device, Some(3.0), host),
            (RateFrom::DeviceTime, Some(3.0), &host.replace("host", "sensor")),
            (RateFrom::DeviceTime, None, "clock of the sensor; its own tolerance is not verified"),
            (RateFrom::Assumed, Some(3.0), "sample rate assumed, not traceable"),
        ] {
            assert_eq!(clock(from, ppm), said);
        }
        assert_eq!([1, 2].map(|gaps| dropped(1234, gaps)), ["1\u{202f}234 in 1 gap", "1\u{202f}234 in 2 gaps"]);
    }

    #[test]
    fn registers_are_given_with_their_meaning_and_as_printed() {
        for (register, text, expected) in [
            (Register::BAUD_RATE, "115200", "115200 baud [115200]"),
            (Register::ASYNC_RATE, "40", "40 Hz [40]"),
            (Register::VPE_CONTROL, "1,0,1,1", "on, heading absolute, filtering adaptive, tuning adaptive [1,0,1,1]"),
            (Register::ROTATION, "1,0,0,0,1,0,0,0,1", "none (identity) [1,0,0,0,1,0,0,0,1]"),
            (Register::IMU_FILTER, "nonsense", "as printed: nonsense"),
        ] {
            assert_eq!(in_words(register, text), expected);
        }
        let filter = in_words(Register::IMU_FILTER, "0,20,20,4,0,0,3,3,3,0");
        assert!(filter.starts_with("averages 20 refreshes of the gyroscope (both)"), "{filter}");
    }
}
