//! What a recording says of the measurement that it was made in, among the conditions of the user: a
//! replay measures the same frames, although the recording may contain one more line.

use std::collections::BTreeMap;

use vn100_protocol::stream::MeasuredFrames;

use crate::{goal::Goal, settings::Settings};

/// The requested data time.
const DURATION: &str = "measured.duration";

/// The goals for the measurement, separated by semicolons.
const UNTIL: &str = "measured.until";

/// Whether sentences or packets were measured, if one of them was chosen.
const MEASURED: &str = "measured.frames";
const SENTENCES: &str = "sentences";
const PACKETS: &str = "packets";

/// Whether a name is the program's own, rather than one of the user's conditions.
pub fn is_reserved(name: &str) -> bool {
    [DURATION, UNTIL, MEASURED].contains(&name)
}

/// The metadata of a recording: the conditions of the user, and the measurement.
pub fn metadata(
    conditions: &BTreeMap<String, String>,
    settings: &Settings,
    measured: MeasuredFrames,
) -> BTreeMap<String, String> {
    let mut all = conditions.clone();
    let frames = match measured {
        MeasuredFrames::First => None,
        MeasuredFrames::Sentences => Some(SENTENCES),
        MeasuredFrames::Packets => Some(PACKETS),
    };
    all.extend(frames.map(|frames| (MEASURED.to_owned(), frames.to_owned())));
    let duration = settings.duration.map(|duration| humantime::format_duration(duration).to_string());
    all.extend(duration.map(|duration| (DURATION.to_owned(), duration)));
    if !settings.until.is_empty() {
        let goals: Vec<_> = settings.until.iter().map(Goal::to_string).collect();
        all.insert(UNTIL.to_owned(), goals.join("; "));
    }
    all
}

/// The conditions of the user in the metadata of a recording; `None` if there are none.
pub fn conditions(metadata: &BTreeMap<String, String>) -> Option<BTreeMap<String, String>> {
    let users = metadata.iter().filter(|(name, _)| !is_reserved(name));
    let users: BTreeMap<_, _> = users.map(|(name, value)| (name.clone(), value.clone())).collect();
    (!users.is_empty()).then_some(users)
}

/// What of a recording is measured: as chosen now, else as in the recorded measurement.
pub fn frames(asked: MeasuredFrames, metadata: &BTreeMap<String, String>) -> MeasuredFrames {
    match (asked, metadata.get(MEASURED).map(String::as_str)) {
        (MeasuredFrames::First, Some(SENTENCES)) => MeasuredFrames::Sentences,
        (MeasuredFrames::First, Some(PACKETS)) => MeasuredFrames::Packets,
        (asked, _) => asked,
    }
}

/// The settings with the end of the recorded measurement, if they name none.
pub fn with_end(mut settings: Settings, metadata: &BTreeMap<String, String>) -> Settings {
    let duration = || humantime::parse_duration(metadata.get(DURATION)?).ok();
    settings.duration = settings.duration.or_else(duration);
    if settings.until.is_empty() {
        let goals = metadata.get(UNTIL).map_or("", String::as_str);
        settings.until = goals.split(';').filter_map(|goal| goal.parse().ok()).collect();
    }
    settings
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn ended() -> Settings {
        let until = ["gyro N ±5%", "accel_z K ±12.5 %"].map(|goal| goal.parse().unwrap()).to_vec();
        Settings { duration: Some(Duration::from_millis(90_500)), until, ..Settings::default() }
    }

    #[test]
    fn the_end_of_a_measurement_is_read_from_its_recording_and_is_no_condition() {
        let recorded = metadata(&BTreeMap::new(), &ended(), MeasuredFrames::First);
        assert_eq!(with_end(Settings::default(), &recorded), ended());
        assert_eq!(conditions(&recorded), None);
        let asked = Settings {
            duration: Some(Duration::from_secs(7)),
            until: vec!["gyro B ±20%".parse().unwrap()],
            ..Settings::default()
        };
        assert_eq!(with_end(asked.clone(), &recorded), asked);
    }

    #[test]
    fn a_replay_measures_the_recorded_frames_by_default() {
        for measured in [MeasuredFrames::First, MeasuredFrames::Sentences, MeasuredFrames::Packets] {
            let recorded = metadata(&BTreeMap::new(), &Settings::default(), measured);
            assert_eq!(frames(MeasuredFrames::First, &recorded), measured);
            assert_eq!(frames(MeasuredFrames::Packets, &recorded), MeasuredFrames::Packets);
            assert_eq!(conditions(&recorded), None);
        }
    }

    #[test]
    fn conditions_are_kept_and_names_of_the_program_reserved() {
        let users = BTreeMap::from([("place".to_owned(), "bench 3".to_owned())]);
        assert_eq!(metadata(&users, &Settings::default(), MeasuredFrames::First), users);
        let recorded = metadata(&users, &ended(), MeasuredFrames::First);
        assert_eq!(recorded.len(), 3);
        assert_eq!(conditions(&recorded), Some(users));
        assert!(recorded.keys().filter(|name| is_reserved(name)).count() == 2 && !is_reserved("place"));
    }
}
