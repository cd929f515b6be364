//! What the user can do, in words for the command line, for Python and for a page: the one table of a
//! library that names options and commands.

use schemars::JsonSchema;
use serde::Serialize;
use vn100_analysis::protocol::PacketMessage;
use vn100_analysis::{Remedy, Setting};

/// A remedy: its code, what to do, and the option or argument for it.
struct Row {
    code: &'static str,
    what: String,
    command: String,
    python: Option<String>,
}

fn row(remedy: &Remedy) -> Row {
    let with = |code, what: String, command: String, python: Option<String>| Row { code, what, command, python };
    match remedy {
        Remedy::GiveRate(Some(hz)) => with(
            "rate",
            format!("give the sample rate, {hz:.4} Hz if the time stamps are right"),
            format!("--rate {hz:.4}"),
            Some(format!("rate={hz:.4}")),
        ),
        Remedy::Skip(Some(minutes)) => with(
            "skip",
            format!("exclude the first {minutes} min"),
            format!("--skip {minutes}min"),
            Some(format!("skip={}", 60.0 * minutes)),
        ),
        Remedy::MapColumns(Some(map)) => {
            with("columns", format!("read the columns as {map}"), map_option(map), Some(format!("columns={map:?}")))
        }
        Remedy::Configure(setting) => with(
            "configure",
            format!("set the sensor: {}", register(setting)),
            format!("vn100 configure PORT {}", option(setting)),
            None,
        ),
        Remedy::MeasureWith(setting) => with(
            "measure-with",
            format!("measure with {}", register(setting)),
            format!("vn100 attach PORT {}", option(setting)),
            None,
        ),
        Remedy::Restore { port, message, rate_hz } => {
            let options = (message.iter().map(|message| format!(" --set-message {message}")))
                .chain(rate_hz.map(|hz| format!(" --set-rate {hz}")));
            with(
                "restore",
                format!("set the sensor to {} again, and save its settings", restored(message, rate_hz)),
                format!("vn100 configure {port}{} --save", options.collect::<String>()),
                None,
            )
        }
        fixed => {
            let (code, what, command, python) = fixed_row(fixed);
            with(code, what.into(), command.into(), python.map(str::to_owned))
        }
    }
}

/// The row of a remedy without a number or text of its own.
const fn fixed_row(remedy: &Remedy) -> (&'static str, &'static str, &'static str, Option<&'static str>) {
    match remedy {
        Remedy::GiveRate(_) => ("rate", "give the sample rate", "--rate HZ", Some("rate=HZ")),
        Remedy::Skip(_) => ("skip", "exclude the beginning of the record", "--skip TIME", Some("skip=SECONDS")),
        Remedy::EndEarlier => {
            ("duration", "end before the end of the record", "--duration TIME", Some("duration=SECONDS"))
        }
        Remedy::AcceptUnchecked => (
            "accept-unchecked",
            "accept sentences without a checksum",
            "--accept-unchecked",
            Some("accept_unchecked=True"),
        ),
        Remedy::MapColumns(_) => (
            "columns",
            "name the columns and their units",
            "--columns gyro_x=NAME:rad/s,...",
            Some("columns=\"gyro_x=NAME:rad/s,...\""),
        ),
        Remedy::GiveTopic => ("topic", "name one topic", "--topic NAME", Some("topic=\"NAME\"")),
        Remedy::SayCompensated => (
            "compensated",
            "state whether the rates are compensated",
            "--compensated yes|no",
            Some("compensated=True|False"),
        ),
        Remedy::GiveDatasheet => ("datasheet", "use another data sheet", "--datasheet FILE.toml", None),
        Remedy::FillFromDatasheet => {
            ("fill-from-datasheet", "take it from the data sheet", "--fill-from-datasheet", None)
        }
        Remedy::GiveScaleFactor => {
            ("scale-factor", "give the error of the scale factor in ppm", "--scale-factor PPM", None)
        }
        Remedy::GiveWindow => (
            "window",
            "state the averaging window of a VN-100 (register 85)",
            "--window SAMPLES",
            Some("window=SAMPLES"),
        ),
        Remedy::MeasurePackets => ("packets", "measure the packets", "--measure packets", Some("measure=\"packets\"")),
        Remedy::TypicalIsLimit => ("typical-is-limit", "take typical figures for limits", "--typical-is-limit", None),
        Remedy::MeasureLive => ("measure-live", "measure live, with a short latency timer", "vn100 attach", None),
        Remedy::ReadTemperature => (
            "temperature",
            "read the temperature between the lines of a live sensor",
            "vn100 attach --temperature",
            None,
        ),
        Remedy::Record => (
            "record",
            "record the sensor with its registers, temperature and conditions",
            "vn100 attach PORT --record FILE.mcap --temperature --meta CONDITIONS.toml",
            None,
        ),
        Remedy::Plan | Remedy::Configure(_) | Remedy::MeasureWith(_) | Remedy::Restore { .. } => {
            ("plan", "plan how long a record must be", "vn100 plan", None)
        }
    }
}

/// What a sensor is set to again: `VNYMR at 40 Hz`.
fn restored(message: &Option<String>, rate_hz: &Option<f64>) -> String {
    let settings = message.iter().cloned().chain(rate_hz.map(|hz| format!("{hz} Hz")));
    settings.collect::<Vec<_>>().join(" at ")
}

fn register(setting: &Setting) -> String {
    match setting {
        Setting::Message(header) if PacketMessage::named(header).is_some() => {
            format!("message {header} of uncompensated fields (register 75)")
        }
        Setting::Message(header) => format!("message {header} (register 6)"),
        Setting::Window(refreshes) => format!("an averaging window of {refreshes} (register 85)"),
    }
}

fn option(setting: &Setting) -> String {
    match setting {
        Setting::Message(header) => format!("--set-message {header}"),
        Setting::Window(refreshes) => format!("--window {refreshes}"),
    }
}

/// The option with a map of columns, as a shell takes it. A line of text may end after a comma.
fn map_option(map: &str) -> String {
    let quoted = map.replace('\'', "'\\''").replace(',', ", ");
    format!("--columns '{quoted}'")
}

/// For a user at a command line: what to do, with the option or the command in quotes of code.
pub fn remedy_words(remedy: &Remedy) -> String {
    let Row { what, command, .. } = row(remedy);
    if command.starts_with("--columns '") { format!("set {command}") } else { format!("{what}: `{command}`") }
}

/// For a user of the Python package: what to do, with the argument if there is one.
pub fn python_words(remedy: &Remedy) -> String {
    match row(remedy) {
        Row { what, python: None, .. } => what,
        Row { what, python: Some(argument), .. } => format!("{what}: `{argument}`"),
    }
}

/// For a reader of a page, who may have no program: what to do.
pub fn page_words(remedy: &Remedy) -> String {
    row(remedy).what
}

/// The option or command alone, as a command line takes it.
pub fn command(remedy: &Remedy) -> String {
    row(remedy).command
}

/// The number or text of a remedy.
#[derive(Debug, JsonSchema, Serialize)]
#[serde(untagged)]
enum RemedyValue {
    /// A rate or minutes.
    Number(f64),
    /// An averaging window.
    Window(u32),
    /// A map of columns, a message, or what the sensor is set to again.
    Text(String),
}

/// A remedy as data of a document.
#[derive(Debug, JsonSchema, Serialize)]
pub(crate) struct RemedyDocument {
    /// Code of the remedy, such as rate, skip, columns or measure-with.
    code: &'static str,
    /// Rate in Hz, minutes, map of columns, message (with its rate, of a sensor to be set again) or averaging
    /// window; null without one.
    value: Option<RemedyValue>,
}

impl RemedyDocument {
    pub(crate) fn new(remedy: &Remedy) -> Self {
        let value = match remedy {
            Remedy::GiveRate(number) | Remedy::Skip(number) => number.map(RemedyValue::Number),
            Remedy::MapColumns(map) => map.clone().map(RemedyValue::Text),
            Remedy::Configure(setting) | Remedy::MeasureWith(setting) => Some(match setting {
                Setting::Message(header) => RemedyValue::Text((*header).into()),
                Setting::Window(refreshes) => RemedyValue::Window(*refreshes),
            }),
            Remedy::Restore { message, rate_hz, .. } => Some(RemedyValue::Text(restored(message, rate_hz))),
            _ => None,
        };
        Self { code: row(remedy).code, value }
    }
}
