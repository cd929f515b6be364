//! A column that names the sensor of each row, in tables whose rows alternate between sensors.

use super::{CsvError, HeadRows, header::Header, shown};

/// Words in the name of such a column.
const WORDS: [&str; 11] =
    ["sensor", "device", "imu", "id", "name", "serial", "source", "node", "mac", "topic", "frame"];

/// The smallest fraction of the rows that belongs to a sensor.
const SMALLEST_SHARE: f64 = 0.05;

/// The most sensors of one table: a column with more values is a count.
const MOST_SENSORS: usize = 16;

/// The smallest fraction of the rows that are followed by a row of another sensor.
const ALTERNATING: f64 = 0.05;

/// Checks that all rows are of one sensor, by a column that is not `taken`.
///
/// # Errors
/// [`CsvError`] with the sensors in the order of their first rows, and the command that keeps one.
pub(super) fn check_one_sensor(
    header: &Header,
    rows: &HeadRows,
    taken: impl Fn(usize) -> bool,
) -> Result<(), CsvError> {
    let mut named = (0..header.names.len()).filter(|&place| !taken(place) && is_named(&header.names[place]));
    let Some((place, sensors)) = named.find_map(|place| Some((place, sensors(rows, place)?))) else { return Ok(()) };
    let (column, number, first) = (&header.names[place], place + 1, &sensors[0]);
    Err(CsvError::certain(format!(
        "the rows are of several sensors, by column {column:?}: {}; keep those of one, as awk -F, 'NR==1 || ${number}==\"{first}\"' does",
        sensors.join(", ")
    )))
}

fn is_named(name: &str) -> bool {
    let name = name.to_lowercase();
    let mut words = name.split(|c: char| !c.is_alphabetic());
    words.any(|word| WORDS.iter().any(|known| word.strip_suffix("id").unwrap_or(word) == *known || word == *known))
}

fn sensors(rows: &HeadRows, place: usize) -> Option<Vec<String>> {
    let mut sensors: Vec<(&[u8], u32)> = Vec::new();
    let mut changes = 0;
    let mut last: Option<&[u8]> = None;
    for cell in rows.iter().filter_map(|row| row.get(place)) {
        changes += u32::from(last.replace(cell).is_some_and(|last| last != cell));
        match sensors.iter().position(|(sensor, _)| *sensor == cell) {
            Some(at) => sensors[at].1 += 1,
            None if sensors.len() < MOST_SENSORS => sensors.push((cell, 1)),
            None => return None,
        }
    }
    let rows = rows.len() as f64;
    let is_one = |(sensor, count): &(&[u8], u32)| !sensor.is_empty() && f64::from(*count) >= SMALLEST_SHARE * rows;
    let are_several = sensors.len() > 1 && sensors.iter().all(is_one) && f64::from(changes) >= ALTERNATING * rows;
    are_several.then(|| sensors.into_iter().map(|(sensor, _)| shown(sensor)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(header: &str, rows: impl Iterator<Item = String>) -> Option<String> {
        let rows: Vec<Vec<Vec<u8>>> =
            rows.map(|row| row.split(',').map(|cell| cell.as_bytes().to_vec()).collect()).collect();
        let checked = check_one_sensor(&Header::read(header.as_bytes(), b','), &rows, |place| place == 0);
        checked.err().map(|error| error.to_string())
    }

    #[test]
    fn rows_that_alternate_between_sensors_are_of_several() {
        for header in ["t,sensor", "t,Device ID", "t,imu_id", "t,sensorId", "t,frame_id"] {
            let refusal = found(header, (0..100).map(|row| format!("{row},{}", ["B", "A"][row % 2])));
            assert!(refusal.is_some_and(|refusal| refusal.contains(": B, A; keep")), "{header}");
        }
        // one name, a name for every row, one sensor after the other, a glitch, another column, the column
        // that is read
        assert_eq!(found("t,sensor", (0..100).map(|row| format!("{row},A"))), None);
        assert_eq!(found("t,id", (0..100).map(|row| format!("{row},{row}"))), None);
        assert_eq!(found("t,sensor", (0..100).map(|row| format!("{row},{}", row / 50))), None);
        assert_eq!(found("t,sensor", (0..100).map(|row| format!("{row},{}", u8::from(row == 9)))), None);
        assert_eq!(found("t,status", (0..100).map(|row| format!("{row},{}", row % 2))), None);
        assert_eq!(found("sensor,t", (0..100).map(|row| format!("{},0", row % 2))), None);
        assert_eq!(found("t,sensor", std::iter::empty()), None);
    }

    #[test]
    fn a_rig_has_sixteen_sensors_at_most() {
        for (sensors, are_several) in [(16, true), (17, false)] {
            let found = found("t,sensor", (0..10 * sensors).map(|row| format!("{row},{}", row % sensors)));
            assert_eq!(found.is_some(), are_several);
        }
    }
}
