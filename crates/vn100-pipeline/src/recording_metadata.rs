//! What a recording keeps beside the bytes: the conditions of the measurement, and when it was to
//! end. A replay ends there too: a line more may have come by the time that was over.

use std::collections::BTreeMap;

use vn100_analysis::{Goal, Settings};
use vn100_capture::Recorded;

/// The data time that the measurement was to last.
const DURATION: &str = "measured.duration";

/// The goals that were to end it, with semicolons between them.
const UNTIL: &str = "measured.until";

/// Whether a name is the program's own, and not one of the user's conditions.
#[must_use]
pub fn is_reserved(name: &str) -> bool {
    [DURATION, UNTIL].contains(&name)
}

pub(crate) fn metadata(conditions: &BTreeMap<String, String>, settings: &Settings) -> BTreeMap<String, String> {
    let mut all = conditions.clone();
    let duration = settings.duration.map(|duration| humantime::format_duration(duration).to_string());
    all.extend(duration.map(|duration| (DURATION.to_owned(), duration)));
    if !settings.until.is_empty() {
        let goals: Vec<_> = settings.until.iter().map(Goal::to_string).collect();
        all.insert(UNTIL.to_owned(), goals.join("; "));
    }
    all
}

pub(crate) fn conditions(recorded: &Recorded) -> Option<BTreeMap<String, String>> {
    let users = recorded.metadata.iter().filter(|(name, _)| !is_reserved(name));
    let users: BTreeMap<_, _> = users.map(|(name, value)| (name.clone(), value.clone())).collect();
    (!users.is_empty()).then_some(users)
}

/// The settings with the end of the recorded measurement, where they name none.
pub(crate) fn with_recorded_end(mut settings: Settings, recorded: &Recorded) -> Settings {
    // of a resumed recording it is the end of the first part alone
    if !recorded.resumed {
        let duration = || humantime::parse_duration(recorded.metadata.get(DURATION)?).ok();
        settings.duration = settings.duration.or_else(duration);
        if settings.until.is_empty() {
            let goals = recorded.metadata.get(UNTIL).map_or("", String::as_str);
            settings.until = goals.split(';').filter_map(|goal| goal.parse().ok()).collect();
        }
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
        let metadata = metadata(&BTreeMap::new(), &ended());
        let recorded = Recorded { metadata, ..Recorded::default() };
        assert_eq!(with_recorded_end(Settings::default(), &recorded), ended());
        assert_eq!(conditions(&recorded), None);
        let asked = Settings {
            duration: Some(Duration::from_secs(7)),
            until: vec!["gyro B ±20%".parse().unwrap()],
            ..Settings::default()
        };
        assert_eq!(with_recorded_end(asked.clone(), &recorded), asked);
        let resumed = Recorded { resumed: true, ..recorded };
        assert_eq!(with_recorded_end(Settings::default(), &resumed), Settings::default());
    }

    #[test]
    fn conditions_are_kept_and_names_of_the_program_reserved() {
        let users = BTreeMap::from([("place".to_owned(), "bench 3".to_owned())]);
        assert_eq!(metadata(&users, &Settings::default()), users);
        let recorded = Recorded { metadata: metadata(&users, &ended()), ..Recorded::default() };
        assert_eq!(recorded.metadata.len(), 3);
        assert_eq!(conditions(&recorded), Some(users));
        assert!(recorded.metadata.keys().filter(|name| is_reserved(name)).count() == 2 && !is_reserved("place"));
    }
}
