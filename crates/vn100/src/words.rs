//! What happens in a session, why it ended, and what can be done, in the terms of the command line.

use std::time::Duration;

use vn100_analysis::RateChange;
use vn100_capture::with_causes;
use vn100_driver::{Configured, OutputLeft};
use vn100_report::{numbers::plain::time, printable};
use vn100_session::{CommandRefusal, RateEvent, SessionEvent, SetupError};

const RESTORED: &str = "settings restored";

/// An event of the session of that source; `None` if there is nothing to say.
pub(crate) fn event(name: &str, event: SessionEvent) -> Option<String> {
    let text = match event {
        SessionEvent::SensorConfigured(configured) => describe(&configured),
        SessionEvent::SettingsRestored { output_paused: false } => RESTORED.into(),
        SessionEvent::SettingsRestored { output_paused: true } => format!("{RESTORED}, with its output paused"),
        // its own text names the settings that remain
        SessionEvent::SettingsNotRestored { error: error @ SetupError::Configure(_), .. } => {
            format!("settings not restored: {}", with_causes(&error))
        }
        SessionEvent::SettingsNotRestored { error, changes, output } => {
            let output = output.map(|output| match output {
                OutputLeft::On => "its output is on".to_owned(),
                OutputLeft::MaybePaused => "its output may be paused".to_owned(),
            });
            let changes: Vec<_> = changes.iter().map(ToString::to_string).chain(output).collect();
            let (changes, error) = (changes.join(", "), with_causes(&error));
            format!("settings not restored, and may stay changed: {changes}: {error}")
        }
        SessionEvent::OutputPausedAgain => "its output is paused again, as before the measurement".into(),
        SessionEvent::OutputNotPausedAgain => {
            "its output was paused before, and could not be paused again: $VNASY,0*4F pauses it".into()
        }
        SessionEvent::PortShared { program } => {
            format!("{program} has the port open too, and receives a part of the bytes: end that program")
        }
        SessionEvent::OtherMessage(other) => other.to_string(),
        SessionEvent::Rate(RateEvent::Changed(RateChange { from_hz, to_hz, .. })) => {
            format!("the rate changed from {from_hz} to {to_hz} Hz: samples at that rate are excluded")
        }
        SessionEvent::Rate(RateEvent::Restored(hz)) => format!("the rate is {hz} Hz again"),
        SessionEvent::WarmUpEnded { excluded: Duration::ZERO, .. } => return None,
        SessionEvent::WarmUpEnded { warm_up, excluded } => {
            // the option by which a replay excludes the same beginning
            let (warm_up, skip_s) = (time(warm_up.as_secs_f64()), excluded.as_secs_f64());
            format!("the first {warm_up} are excluded, as by --skip {skip_s:.3}s")
        }
        SessionEvent::StartedOver { after } => format!("started over after {}", time(after.as_secs_f64())),
        SessionEvent::Refused(CommandRefusal::AtEnd) => "the capture was replayed to its end".into(),
        SessionEvent::Refused(CommandRefusal::NoMark) => "not marked: only the stream of an open link is".into(),
        SessionEvent::Refused(CommandRefusal::Over) => return Some("the capture has ended".into()),
    };
    Some(format!("{name}: {text}"))
}

/// What was changed, and whether the sensor does what it is set to.
pub(crate) fn describe(configured: &Configured) -> String {
    let changes: Vec<_> = configured.changes.iter().map(ToString::to_string).collect();
    let changed = if changes.is_empty() { "no change needed".into() } else { changes.join(", ") };
    let (measured_hz, rate_hz) = (configured.measured_hz, configured.rate_hz);
    let verdict = if configured.rate_is_kept() { "" } else { ": NOT as configured; check the cable and the baud rate" };
    let found = if configured.was_paused { "; its output was paused and is on now" } else { "" };
    printable(&format!("{changed}{found}; {measured_hz:.1} Hz measured, {rate_hz} Hz set{verdict}"))
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use vn100_analysis::{Remedy, Setting};

    use vn100_report::remedies::command;

    use crate::args::Args;

    #[test]
    fn every_option_that_is_named_is_one() {
        let window = Setting::Window(20);
        for (before, remedy, after) in [
            ("replay x", Remedy::GiveRate(Some(40.0)), ""),
            ("replay x", Remedy::GiveRate(None), " 40"),
            ("replay x", Remedy::Skip(Some(11.0)), ""),
            ("replay x", Remedy::Skip(None), " 1s"),
            ("replay x", Remedy::EndEarlier, " 1h"),
            ("replay x", Remedy::AcceptUnchecked, ""),
            ("replay x", Remedy::MapColumns(None), " gyro_x=wx:deg/s"),
            ("replay x", Remedy::MapColumns(Some("gyro_x=wx:deg/s".into())), ""),
            ("replay x", Remedy::SayCompensated, " no"),
            ("replay x", Remedy::GiveDatasheet, " y.toml"),
            ("replay x", Remedy::GiveWindow, " 20"),
            ("replay x", Remedy::MeasurePackets, ""),
            ("replay x", Remedy::TypicalIsLimit, ""),
            ("", Remedy::Configure(Setting::Message("VNYMR")), ""),
            ("", Remedy::Configure(window), ""),
            ("", Remedy::MeasureWith(window), ""),
            ("", Remedy::Restore { port: "x".into(), message: Some("VNYMR".into()), rate_hz: Some(40.0) }, ""),
            ("", Remedy::MeasureLive, " PORT"),
            ("", Remedy::ReadTemperature, " PORT"),
            ("", Remedy::Record, ""),
            ("", Remedy::Plan, ""),
            ("replay x", Remedy::GiveTopic, " /imu"),
        ] {
            // as a shell hands it on
            let words = command(&remedy).replace('\'', "");
            let words = ["HZ", "TIME", "SAMPLES", "NAME", "FILE.toml", "gyro_x=NAME:rad/s,...", "yes|no"]
                .into_iter()
                .fold(words, |words, place| words.trim_end_matches(place).to_owned());
            let line = format!("vn100 {before} {}{after}", words.trim_start_matches("vn100 "));
            let parsed = Args::try_parse_from(line.split_whitespace());
            assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
        }
    }
}
