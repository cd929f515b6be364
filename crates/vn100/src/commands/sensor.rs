//! `vn100 info` and `vn100 configure`: what a sensor is, what it sends, what its line can carry,
//! and changes of what it sends.

use std::{collections::BTreeMap, fmt::Write};

use anyhow::{Result, bail};
use serde::Serialize;
use tokio::runtime::Builder;
use tokio_util::sync::CancellationToken;
use vn100_analysis::Completion;
use vn100_driver::{CommandError, LinkHandle, OutputSettings};
use vn100_protocol::{
    AsyncRate, AsyncType, BaudRate, BinaryOutput, Check, ImuFilter, LinkLoad, MEASUREMENTS_PER_S, MESSAGES,
    PACKET_MESSAGES, ProtocolControl, Register, RegisterContents, RegisterFields, RegisterValue, RequestFailure,
    stream::ReadOptions,
};
use vn100_report::printable;

use crate::{
    args::{ConfigureArgs, InfoArgs, LinkArgs, SourceName},
    exit::{HangUp, print, print_json, report, stop_on_interrupt, unless_closed},
    live_source::live_source,
    log::run_logged,
    text::{fill, text},
    words::describe,
};

/// What is asked: identity, output, processing.
const REGISTERS: [u8; 15] = [0, 1, 2, 3, 4, 5, 6, 7, 30, 35, 75, 76, 77, 82, 85];

pub(crate) fn info(args: InfoArgs) -> Result<Completion> {
    if args.link.listen_only {
        report("--listen-only sends nothing, so the sensor cannot be identified");
        return Ok(Completion::NotGiven);
    }
    let name = args.source.to_string();
    let info = with_sensor(&args.source, &args.link, async |link, stop| {
        stop.run_until_cancelled(ask(&link, name)).await.unwrap_or_else(|| bail!("interrupted"))
    })?;
    if args.output.json {
        print_json(&info)?
    } else {
        print(&info.text())?
    }
    Ok(Completion::Complete)
}

/// Connects to that sensor and does `work` with it, which the token ends early.
fn with_sensor<T>(
    name: &SourceName,
    args: &LinkArgs,
    work: impl AsyncFnOnce(LinkHandle, CancellationToken) -> Result<T>,
) -> Result<T> {
    run_logged(&mut Builder::new_multi_thread(), &args.log, async |log| {
        let stop = stop_on_interrupt(HangUp::Stops)?;
        let source = live_source(name, args, ReadOptions::default(), &log)?;
        source.with_link(None, &stop, |link| work(link, stop.clone())).await
    })
}

#[derive(Debug, Serialize)]
struct Info {
    schema: &'static str,
    source: String,
    model: Option<String>,
    hardware_revision: Option<String>,
    serial_number: Option<String>,
    firmware: Option<String>,
    /// Baud rate; null where the link has none.
    baud: Option<u32>,
    /// The sentences, or the packets where it sends no sentences. Null where it sends neither, or
    /// what is not known here; `registers` has it.
    message: Option<&'static str>,
    /// All messages in words.
    #[serde(skip)]
    sends: String,
    /// How often the message comes.
    rate_hz: Option<u32>,
    /// Refreshes averaged for a sample of magnetometer, accelerometer, gyroscope.
    window: Option<[u16; 3]>,
    checksum_bits: Option<u8>,
    /// Whether each line carries a count.
    count: Option<bool>,
    line: Option<LineLoad>,
    /// Every register asked, by number, as printed.
    registers: BTreeMap<u8, String>,
}

#[derive(Debug, Serialize)]
struct LineLoad {
    bytes_per_s: f64,
    bytes_per_s_at_most: u32,
    /// The highest rate of each message that is analysed, were it the only one.
    highest_rate_hz: BTreeMap<&'static str, Option<u32>>,
}

async fn ask(link: &LinkHandle, source: String) -> Result<Info> {
    let mut registers = BTreeMap::new();
    for register in REGISTERS {
        match link.read(Register(register)).await {
            Ok(contents) => registers.extend(contents.map(|contents| (register, contents.fields.to_string()))),
            // another model or firmware does not let all be read
            Err(CommandError::Failed(RequestFailure::Device { .. })) => {}
            Err(error) => return Err(error.into()),
        }
    }
    let baud = link.state().borrow().up().and_then(|up| up.baud);
    Ok(Info::new(source, baud, registers))
}

impl Info {
    fn new(source: String, baud: Option<u32>, registers: BTreeMap<u8, String>) -> Self {
        let text = |register: u8| registers.get(&register).filter(|text| !text.is_empty()).cloned();
        let message = register_value::<AsyncType>(&registers, 6);
        let rate = register_value::<AsyncRate>(&registers, 7);
        let control = register_value::<ProtocolControl>(&registers, 30);
        let filter = register_value::<ImuFilter>(&registers, 85);
        let packets: Vec<BinaryOutput> = (75..=77)
            .filter_map(|register| register_value::<BinaryOutput>(&registers, register))
            .filter(|output| output.rate_hz() > 0.0)
            .collect();
        let speed = baud.and_then(BaudRate::new).or_else(|| register_value(&registers, 5));
        let line = speed.and_then(|speed| {
            let control = control.as_ref()?;
            let packets: Option<LinkLoad> = packets.iter().map(LinkLoad::of_packets).sum();
            let lines = LinkLoad::of_lines(message?.line_length(control)?, rate?);
            let highest = MESSAGES.iter().filter_map(|layout| {
                let length = AsyncType::from_header(layout.message.as_bytes())?.line_length(control)?;
                Some((&*layout.message, LinkLoad::NONE.highest_rate_beside(length, speed).map(AsyncRate::hz)))
            });
            let highest_of_packets =
                PACKET_MESSAGES.iter().map(|packets| (packets.name, packets.highest_rate_hz(speed)));
            Some(LineLoad {
                bytes_per_s: (packets? + lines).bytes_per_s,
                bytes_per_s_at_most: speed.bytes_per_s(),
                highest_rate_hz: highest.chain(highest_of_packets).collect(),
            })
        });
        let alone = packets.first().filter(|_| message == Some(AsyncType::OFF));
        Self {
            schema: "vn100.info/1",
            source,
            model: text(1),
            hardware_revision: text(2),
            serial_number: text(3),
            firmware: text(4),
            baud,
            message: alone.map_or_else(|| message.and_then(AsyncType::header), packet_name),
            sends: sends(message.zip(rate), control.as_ref(), &packets),
            rate_hz: match alone {
                Some(packets) => MEASUREMENTS_PER_S.checked_div(packets.rate_divisor.into()),
                None => rate.map(AsyncRate::hz),
            },
            window: filter.map(|filter| [filter.mag_window, filter.accel_window, filter.gyro_window]),
            checksum_bits: control.as_ref().and_then(|control| match control.check()? {
                Check::Xor8 => Some(8),
                Check::Crc16 => Some(16),
                Check::None => None,
            }),
            count: control.map(|control| control.serial_count != 0),
            line,
            registers,
        }
    }

    fn text(&self) -> String {
        text(|out| self.write(out))
    }

    fn write(&self, out: &mut String) -> std::fmt::Result {
        let known = |text: &Option<String>| text.as_deref().map_or("unknown".to_owned(), printable);
        writeln!(out, "{}: {}", printable(&self.source), known(&self.model))?;
        writeln!(
            out,
            "  serial no. {}, firmware {}, hardware {}",
            known(&self.serial_number),
            known(&self.firmware),
            known(&self.hardware_revision)
        )?;
        writeln!(out, "{}", fill(&self.sends, "  sends      ", "             "))?;
        if let Some(line) = &self.line {
            let speed = self.baud.map_or("serial server".into(), |baud| format!("{baud} baud"));
            let share = 100.0 * line.bytes_per_s / f64::from(line.bytes_per_s_at_most);
            writeln!(
                out,
                "  line       {speed}, {:.0} of {} bytes/s in use ({share:.0} %)",
                line.bytes_per_s, line.bytes_per_s_at_most
            )?;
            let highest: Vec<_> = (line.highest_rate_hz.iter())
                .map(|(message, hz)| {
                    let rate = hz.map_or("not even 1 Hz".into(), |hz| format!("{hz} Hz"));
                    // a line ends behind a rate
                    format!("{message} {rate}").replace(' ', "\u{a0}")
                })
                .collect();
            let highest = format!("{} at this baud rate", highest.join(", "));
            writeln!(out, "{}", fill(&highest, "  at most    ", "             ").replace('\u{a0}', " "))?;
        }
        if self.line.is_none() && self.rate_hz.is_some() {
            writeln!(out, "  line       load unknown")?;
        }
        if let Some([mag, accel, gyro]) = self.window {
            let mag = match mag {
                0 | 1 => "; the magnetometer is not averaged".into(),
                _ => format!("; {mag} of the magnetometer's"),
            };
            let mut averages = format!("{gyro} gyroscope, {accel} accelerometer samples of 800 a second{mag}");
            if let Some(rate_hz) = self.rate_hz.filter(|hz| *hz > 0 && MEASUREMENTS_PER_S.is_multiple_of(*hz))
                && u32::from(gyro.min(accel)).max(1) * rate_hz < MEASUREMENTS_PER_S
            {
                let unaliased = MEASUREMENTS_PER_S / rate_hz;
                averages += &format!(". Noise aliases at {rate_hz} Hz: --window {unaliased} avoids it");
            }
            writeln!(out, "{}", fill(&averages, "  averages   ", "             "))?;
        }
        Ok(())
    }
}

/// The sentences and packets that a sensor sends, in words.
fn sends(
    sentences: Option<(AsyncType, AsyncRate)>,
    control: Option<&ProtocolControl>,
    packets: &[BinaryOutput],
) -> String {
    let check = match control.and_then(ProtocolControl::check) {
        Some(Check::Xor8) => ", 8-bit checksum",
        Some(Check::Crc16) => ", 16-bit checksum",
        _ => "",
    };
    let count = if control.is_some_and(|control| control.serial_count != 0) { ", counted" } else { "" };
    let sentences = match sentences {
        Some((AsyncType::OFF, _)) => None,
        Some((message, rate)) => {
            let name = message.header().map_or_else(|| format!("unsupported message {message}"), Into::into);
            Some(format!("{name} at {rate} Hz{check}{count}"))
        }
        None => Some(format!("unknown{check}{count}")),
    };
    let packets = packets.iter().map(|output| {
        let fields = || format!("packets of {}", output.field_names().collect::<Vec<_>>().join(" "));
        let name = packet_name(output).map_or_else(fields, str::to_owned);
        format!("{name} at {} Hz", (output.rate_hz() * 10.0).round() / 10.0)
    });
    let all: Vec<String> = sentences.into_iter().chain(packets).collect();
    if all.is_empty() { "no message; --set-message VNYMR makes it send one".into() } else { all.join(" and ") }
}

/// The name of the message that these packets are of, if it is one of ours.
fn packet_name(output: &BinaryOutput) -> Option<&'static str> {
    PACKET_MESSAGES.iter().find(|packets| packets.is_of(output)).map(|packets| packets.name)
}

fn register_value<T: RegisterValue>(registers: &BTreeMap<u8, String>, register: u8) -> Option<T> {
    let fields = RegisterFields::new(registers.get(&register)?)?;
    RegisterContents { register: Register(register), fields }.value().ok()
}

pub(crate) fn configure(args: ConfigureArgs) -> Result<Completion> {
    let settings = OutputSettings {
        baud: args.set_baud,
        count: args.count,
        save: args.save,
        ..args.change.settings().unwrap_or_default()
    };
    if settings == OutputSettings::default() {
        report("nothing to change: give --set-rate, --set-message, --set-baud, --window, --count or --save");
        return Ok(Completion::NotGiven);
    }
    if args.link.listen_only {
        report("--listen-only sends nothing, so the sensor cannot be configured");
        return Ok(Completion::NotGiven);
    }
    if settings.baud.is_some() && args.source.kind() == "tcp" {
        report("the serial server would lose the sensor at another baud rate: --set-baud needs a serial port");
        return Ok(Completion::NotGiven);
    }
    let configured = with_sensor(&args.source, &args.link, async |link, stop| {
        Ok(vn100_driver::configure(&link, &settings, &stop).await?)
    })?;
    let kept = match (settings.save, configured.changes.is_empty()) {
        (true, _) => "; saved, kept at power-off",
        (false, false) => "; lost at power-off unless --save is given",
        (false, true) => "",
    };
    let done = format!("{}: {}{kept}\n", printable(&args.source.to_string()), describe(&configured));
    unless_closed(print(&done))?;
    Ok(if configured.rate_is_kept() { Completion::Complete } else { Completion::Failed })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factory_registers() -> BTreeMap<u8, String> {
        [
            (1, "VN-100S-CR"),
            (2, "7"),
            (3, "0100130608"),
            (4, "3.1.0.0"),
            (5, "115200"),
            (6, "14"),
            (7, "40"),
            (30, "0,0,0,0,1,0,1"),
            (75, "0,0,01,0001"),
            (85, "0,4,4,4,0,0,3,3,3,0"),
        ]
        .map(|(register, fields)| (register, fields.to_owned()))
        .into()
    }

    #[test]
    fn a_sensor_at_its_factory_defaults() {
        let text = Info::new("/dev/ttyUSB0".into(), Some(115_200), factory_registers()).text();
        assert_eq!(
            text,
            "/dev/ttyUSB0: VN-100S-CR\n  serial no. 0100130608, firmware 3.1.0.0, hardware 7\n  \
             sends      VNYMR at 40 Hz, 8-bit checksum\n  line       115200 baud, 4880 of 11520 bytes/s in use (42 %)\n  \
             at most    BINARY 200 Hz, BINARY+MAG 160 Hz, VNDTV 100 Hz, VNIMU 100 Hz,\n             VNMAR 100 Hz, VNQMR 50 Hz, VNYMR 50 Hz at this baud rate\n  averages   4 gyroscope, 4 accelerometer samples of 800 a second; the\n             \
             magnetometer is not averaged. Noise aliases at 40 Hz: --window 20\n             \
             avoids it\n"
        );
    }

    #[test]
    fn a_message_that_is_not_known_is_not_called_none() {
        for (register, sends) in [
            (Some("252"), "unsupported message 252 at 40 Hz"),
            (Some("0"), "no message; --set-message VNYMR makes it send one"),
            (Some("x"), "unknown"),
            (None, "unknown"),
        ] {
            let mut registers = factory_registers();
            registers.remove(&6);
            registers.extend(register.map(|text| (6, text.to_owned())));
            let text = Info::new("/dev/ttyUSB0".into(), Some(115_200), registers).text();
            let check = if register == Some("0") { "" } else { ", 8-bit checksum" };
            assert!(text.contains(&format!("  sends      {sends}{check}\n")), "{text}");
            assert_eq!(text.contains("load unknown"), register != Some("0"), "{text}");
        }
    }

    #[test]
    fn packets_are_sent_with_and_without_sentences() {
        for (sentences, packets, sends, at_40_hz) in [
            ("0", "1,8,05,0001,001C", "BINARY at 100 Hz", false),
            ("0", "1,20,05,0001,003E", "BINARY+MAG at 40 Hz", true),
            ("14", "2,1,05,0001,001C", "VNYMR at 40 Hz, 8-bit checksum and BINARY at 800 Hz", true),
            ("0", "1,3,01,0008", "packets of YawPitchRoll at 266.7 Hz", false),
            ("0", "0,8,05,0001,001C", "no message; --set-message VNYMR makes it send one", true),
        ] {
            let mut registers = factory_registers();
            registers.extend([(6, sentences.to_owned()), (75, packets.to_owned())]);
            let text = Info::new("/dev/ttyUSB0".into(), Some(115_200), registers).text();
            assert!(text.contains(&format!("  sends      {sends}\n")), "{text}");
            assert_eq!(text.contains("aliases at 40 Hz"), at_40_hz, "{text}");
        }
    }

    #[test]
    fn nothing_is_made_up_for_a_sensor_without_registers() {
        let info = Info::new("tcp://a:1".into(), None, BTreeMap::new());
        assert!(info.line.is_none() && info.message.is_none() && info.rate_hz.is_none());
        assert!(info.text().contains("unknown"));
    }
}
