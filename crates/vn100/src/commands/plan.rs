//! `vn100 plan`: how to set the sensor, and how long to measure, for what shall be known.

use std::fmt::{self, Write};

use anyhow::Result;
use imu_noise::{BoxcarWindow, Sensor};
use vn100_analysis::{
    Completion, Datasheet, DatasheetFigure, Given, Known, Onboard, Plan, PlannedMessage, SENSORS, TakenAt, TakenFrom,
    Want, axes_name, letter,
};
use vn100_protocol::BaudRate;
use vn100_report::{PlanCommands, numbers::plain::span, plan_document, printable, vn100_datasheet};

use crate::{
    args::{Fixed, PlanArgs, refused},
    exit::{print, print_json},
    text::{WIDTH, fill, text},
    user_files::open_datasheet,
};

/// What is usually wanted: the table if no goal is given.
const USUAL: [&str; 13] = [
    "gyro N ±10%",
    "gyro N ±5%",
    "gyro N ±1%",
    "gyro B",
    "gyro B ±20%",
    "gyro K >= 12 deg/h^1.5",
    "gyro K >= 2.5 deg/h^1.5",
    "accel N ±5%",
    "accel N ±1%",
    "accel B",
    "accel B ±20%",
    "accel K >= 0.12 mg/sqrt(h)",
    "mag N ±5%",
];

/// Those of them that the message, if one is given, carries, and of which the data sheet gives what their
/// length depends on; without any, those that it carries.
fn usual_wants(message: Option<PlannedMessage>, sheet: &Datasheet) -> Result<Vec<Want>> {
    let all = USUAL.iter().map(|want| want.parse()).collect::<Result<Vec<Want>, _>>()?;
    let is_carried = |want: &Want| message.is_none_or(|message| message.holds(want.figure.sensor));
    let carried: Vec<Want> = all.into_iter().filter(is_carried).collect();
    let known: Vec<Want> = carried.iter().filter(|want| want.missing_in(sheet).is_none()).cloned().collect();
    Ok(if known.is_empty() { carried } else { known })
}

pub(crate) fn plan(args: &PlanArgs) -> Result<Completion> {
    let Fixed { message, rate_hz, baud } = args.fixed;
    let given = Given { message, rate_hz, baud, confidence: args.confidence };
    let asked = !args.want.is_empty();
    let sheet = args.datasheet.as_deref().map_or_else(|| Ok(vn100_datasheet()?), open_datasheet)?;
    let wants = if asked { args.want.clone() } else { usual_wants(message, &sheet)? };
    let plan = Plan::new(&wants, given, &sheet).map_err(|error| refused("plan", &error.to_string()))?;
    if args.output.json {
        let commands = commands(&plan, given, asked);
        print_json(&plan_document(&plan, given, &sheet, asked, &commands))?;
    } else {
        print(&text(|out| write_plan(out, &plan, given, &sheet, asked)))?;
    }
    Ok(Completion::Complete)
}

/// The commands that do what was planned; with a length only if it was `asked` for something in
/// particular that is within reach.
fn commands(plan: &Plan, given: Given, asked: bool) -> PlanCommands {
    let (message, rate_hz, window) = (plan.message.name(), plan.rate_hz, plan.window);
    // a baud rate that is given is the one the port has
    let changes_baud = given.baud.is_none() && plan.baud != BaudRate::DEFAULT;
    let set_baud =
        |baud: BaudRate| if changes_baud { format!(" --set-baud {}", baud.bits_per_s()) } else { String::new() };
    let length = plan.record_s.filter(|_| asked);
    let duration = length.map_or_else(|| "T".into(), |record_s| span(plan.warm_up_s + record_s, ""));
    let set = format!("--set-message {message} --set-rate {rate_hz} --window {window}");
    let record = format!("--record rest.mcap --skip {} --duration {duration}", span(plan.warm_up_s, ""));
    match plan.message {
        // raises the baud rate itself where it must
        PlannedMessage::Packets(_) => {
            PlanCommands { configure: None, attach: format!("vn100 attach PORT {set} {record}"), undo: None }
        }
        PlannedMessage::Sentences => PlanCommands {
            configure: Some(format!("vn100 configure PORT {set}{} --count on", set_baud(plan.baud))),
            attach: format!("vn100 attach PORT {record}"),
            undo: Some(format!(
                "vn100 configure PORT --set-message VNYMR --set-rate 40 --window 4{} --count off",
                set_baud(BaudRate::DEFAULT)
            )),
        },
    }
}

const METHOD: &str = "Lengths at which 80 % of records meet the target on all its axes, K on each of them (simulated: N 85 to 100 %, B 79 to \
                      85 %, K 75 to 81 %), for a sensor at rest without vibration or gaps, from the covariance of the octaves in the fit; with --until a \
                      measurement stops as soon as the target is met. N ±P%: half the interval over the value; of gyro and accel as from a \
                      sixth of the rate, 10 independent samples a second at most, as the sensor's own low pass, which no manual describes, makes \
                      neighbours alike; of mag as from a third of the rate. B, K: estimated, K in the \
                      presence of the assumed B. <=: the limit is decided.";

const PLACE: &str = "at rest on a heavy base with soft feet, without motors, fans or people near by, at a constant temperature; a \
                     magnetometer also away from iron and mains";

const OUT_OF_REACH: &str = "more than 100 days";

fn write_plan(out: &mut String, plan: &Plan, given: Given, datasheet: &Datasheet, asked: bool) -> fmt::Result {
    write_wants(out, plan, given.confidence, asked)?;
    write_assumed(out, datasheet)?;
    write_settings(out, plan, given)?;
    let commands = commands(plan, given, asked);
    if let Some(configure) = &commands.configure {
        writeln!(out, "\nconfigure the sensor; the settings are lost at power-off")?;
        write_command(out, configure)?;
        writeln!(out, "measure, and record the raw bytes")?;
    } else {
        writeln!(out, "\nmeasure, and record the raw bytes; the sensor's settings are restored at the end")?;
    }
    write_command(out, &commands.attach)?;
    if !asked || plan.record_s.is_none() {
        writeln!(out, "  (T: {} of warm-up plus the length above)", span(plan.warm_up_s, " "))?;
    }
    if let Some(undo) = &commands.undo {
        writeln!(out, "undo: power-cycle the sensor, or set the factory defaults")?;
        write_command(out, undo)?;
    }
    Ok(())
}

/// With a backslash where the line continues, as shells read it.
fn write_command(out: &mut String, command: &str) -> fmt::Result {
    let mut line = String::new();
    for part in command.split_inclusive(' ').collect::<Vec<_>>().chunk_by(|_, next| !next.starts_with("--")) {
        let part = part.concat();
        if line.len() + part.len() + 4 > WIDTH {
            writeln!(out, "  {line}\\")?;
            line = "    ".into();
        }
        line.push_str(&part);
    }
    writeln!(out, "  {line}")
}

fn write_wants(out: &mut String, plan: &Plan, confidence: f64, asked: bool) -> fmt::Result {
    writeln!(out, "length after the warm-up, intervals at {confidence}")?;
    for planned in &plan.wants {
        let length = planned.record_s.map_or(OUT_OF_REACH.into(), coarse);
        writeln!(out, "  {:<34} {length}", planned.want.to_string())?;
        if let Some(taken) = planned.taken_at {
            writeln!(out, "{}", fill(&taken_words(&planned.want, taken), "    ", "    "))?;
        }
        if let Some(without_s) = planned.without_bias_instability_s {
            writeln!(out, "    without B {}", coarse(without_s))?;
        }
    }
    if asked {
        let all = plan.record_s.map_or(OUT_OF_REACH.into(), |record_s| format!("{}, rounded up", span(record_s, " ")));
        writeln!(out, "  {:<34} {all}", "all targets")?;
    }
    writeln!(out, "{}", fill(METHOD, "", ""))
}

/// The value of the sensor that the length for a limit is for.
fn taken_words(want: &Want, taken: TakenAt) -> String {
    let value = Want { known: Known::AtMost(taken.value), ..want.clone() }.to_string();
    let beside = format!("{} times the limit", TakenAt::BESIDE);
    let from = match taken.from {
        TakenFrom::Datasheet => "the data sheet's figure".into(),
        TakenFrom::Limit => format!("{beside}, because the data sheet's figure lies too near to the limit"),
        TakenFrom::LimitAlone => format!("{beside}, because the data sheet has no figure"),
    };
    let minimum = if taken.is_minimum {
        "; value and limit are the minimum of the deviation, 0.664 B, as in the verdict"
    } else {
        ""
    };
    format!("if it is {} ({from}); nearer to the limit it takes longer{minimum}", value.replacen("<= ", "", 1))
}

/// The noise behind every length.
fn write_assumed(out: &mut String, datasheet: &Datasheet) -> fmt::Result {
    let note = datasheet.note.as_ref().map_or(String::new(), |note| format!(" ({})", printable(note)));
    let figure = |sensor: &str, quoted: &DatasheetFigure| {
        format!("{sensor} {} {}", letter(quoted.term), printable(&quoted.printed))
    };
    let figures: Vec<String> = SENSORS
        .into_iter()
        .flat_map(|(_, sensor)| datasheet.typical_figures(sensor).map(move |quoted| figure(axes_name(sensor), quoted)))
        .collect();
    let text = format!(
        "Assumed from the data sheet {}{note}: {}; the lower end of a range, and of no parameter for which a target above has another value. A B printed as the minimum of the deviation is divided by 0.664; \
         a smaller B takes longer to detect.",
        printable(&datasheet.name),
        figures.join("; ")
    );
    writeln!(out, "{}", fill(&text, "", ""))
}

/// What becomes of the magnetic field, which is not averaged, where it is sent more slowly than it
/// is measured.
fn aliased_field(plan: &Plan) -> String {
    let (measured_hz, rate_hz) = (Onboard::MAG_REFRESH_HZ, f64::from(plan.rate_hz));
    if !plan.message.holds(Sensor::Magnetometer) || rate_hz > measured_hz {
        return String::new();
    }
    let field = BoxcarWindow { length: 1, decimation: measured_hz / rate_hz };
    format!(
        ". The magnetometer is not averaged: aliasing raises its N {:.2} times, sqrt({measured_hz}/{rate_hz})",
        field.white_factor()
    )
}

fn write_settings(out: &mut String, plan: &Plan, given: Given) -> fmt::Result {
    let (rate_hz, baud) = (plan.rate_hz, plan.baud.bits_per_s());
    let load = plan.frame_bytes * rate_hz;
    let are_packets = matches!(plan.message, PlannedMessage::Packets(_));
    let message = match are_packets {
        true => format!(
            "{}: uncompensated packets with the sensor's own time, which shows rate and dropped samples exactly. Sentences instead: \
             --message VNIMU",
            plan.message.name()
        ),
        false => "VNIMU: in VNYMR the attitude filter removes the gyro bias, so B, K and R are not measurable".into(),
    };
    let rows = [
        ("message", message),
        (
            "rate",
            match given.rate_hz {
                Some(_) => format!("{rate_hz} Hz, as given"),
                None => {
                    format!(
                        "{rate_hz} Hz: B and K are measured at long averaging times, where a higher rate adds nothing"
                    )
                }
            },
        ),
        (
            "window",
            format!(
                "{} = 800/{rate_hz} exactly, for gyro and accelerometer: no aliasing and no smoothing, so N is the sensor's own{}",
                plan.window,
                aliased_field(plan)
            ),
        ),
        (
            "line",
            format!(
                "{baud} baud carry {} bytes a second; {} bytes{}, {rate_hz} times a second are {load} ({:.0} %)",
                baud / 10,
                plan.frame_bytes,
                if are_packets { "" } else { ", with a counter that shows dropped samples exactly" },
                100.0 * f64::from(load) / (f64::from(baud) / 10.0)
            ),
        ),
        ("place", PLACE.into()),
        (
            "warm-up",
            format!(
                "{} excluded: published practice is 10 to 30 minutes, longer for B or K; VectorNav gives no figure. The recording \
                 contains the warm-up: check where the temperature settles, and replay with another --skip",
                span(plan.warm_up_s, " ")
            ),
        ),
    ];
    writeln!(out, "\nsettings")?;
    for (name, text) in rows {
        writeln!(out, "{}", fill(&format!("{name:<9}{text}"), "  ", "           "))?;
    }
    Ok(())
}

/// To two units of time.
fn coarse(seconds: f64) -> String {
    let step = match seconds {
        ..120.0 => 1.0,
        ..7200.0 => 60.0,
        ..172_800.0 => 600.0,
        _ => 3600.0,
    };
    span((seconds / step).ceil() * step, " ")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use vn100_report::DATASHEETS;

    use super::*;

    #[test]
    fn a_message_is_planned_with_what_it_carries() {
        for (name, excluded) in [("BINARY", 1), ("BINARY+MAG", 0), ("VNIMU", 0)] {
            let message = PlannedMessage::named(name);
            let sheet = vn100_datasheet().unwrap();
            let wants = usual_wants(message, &sheet).unwrap();
            assert_eq!(wants.len(), USUAL.len() - excluded, "{name}");
            for rate_hz in [None, Some(200)] {
                let given = Given { message, rate_hz, baud: None, confidence: 0.95 };
                let plan = Plan::new(&wants, given, &sheet).unwrap();
                let text = text(|out| write_plan(out, &plan, given, &sheet, false));
                assert_eq!(text.contains("Hz, as given"), rate_hz.is_some(), "{text}");
            }
        }
    }

    #[test]
    fn every_built_in_sheet_has_a_plan() {
        let given = Given { message: None, rate_hz: None, baud: None, confidence: 0.95 };
        for (name, _) in DATASHEETS {
            let sheet = open_datasheet(Path::new(name)).unwrap();
            let wants = usual_wants(None, &sheet).unwrap();
            assert!(Plan::new(&wants, given, &sheet).is_ok_and(|plan| !plan.wants.is_empty()), "{name}");
        }
    }

    #[test]
    fn a_limit_says_which_value_is_assumed() {
        let given = Given { message: None, rate_hz: None, baud: None, confidence: 0.95 };
        let sheet = vn100_datasheet().unwrap();
        for (want, expected) in [
            (
                "gyro N <= 0.21 deg/sqrt(h)",
                "(0.8 times the limit, because the data sheet's figure lies too near to the",
            ),
            ("gyro N <= 0.5 deg/sqrt(h)", "gyro N 0.2 deg/sqrt(h) (the data sheet's figure); nearer"),
            ("gyro K <= 1 deg/h^1.5", "(0.8 times the limit, because the data sheet has no figure)"),
            // 0.8 times 0.04 mg, not times 0.04 mg over 0.664
            ("accel B <= 0.04 mg", "if it is accel B 0.032 mg (0.8 times the limit"),
            ("accel B <= 0.04 mg", "value and limit are the minimum of the deviation, 0.664 B, as in the verdict"),
        ] {
            let plan = Plan::new(&[want.parse().unwrap()], given, &sheet).unwrap();
            let words = text(|out| write_plan(out, &plan, given, &sheet, true));
            let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(words.contains(expected), "{want}: {words}");
        }
    }
}
