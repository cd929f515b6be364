//! Columns of different rates.

use std::fmt::Write;

use proptest::prelude::*;

use super::*;

/// Every column of a table, in the order of its header.
const HEADER: &str = "t,mag_x,mag_y,accel_x,gyro_x,gyro_y";

/// A table of this many rows, spaced by 10 ms; `holds` tells which rows have a value of mag, accel
/// and gyro.
fn table(rows: u64, mut holds: impl FnMut(u64) -> [bool; 3]) -> String {
    let mut text = format!("{HEADER}\n");
    for row in 0..rows {
        let cell = |is_held: bool, column: u64| match is_held {
            true => format!("0.{:04}", (row * row * 31 + column * 577) % 9973),
            false => String::new(),
        };
        let [mag, accel, gyro] = holds(row);
        let cells = [(mag, 1), (mag, 2), (accel, 3), (gyro, 4), (gyro, 5)].map(|(held, column)| cell(held, column));
        writeln!(text, "{}.{:02},{}", row / 100, row % 100, cells.join(",")).unwrap();
    }
    text
}

fn names(text: &str) -> Vec<String> {
    planned(text, None).streams
}

#[test]
fn columns_of_one_rate_are_a_stream() {
    let shared = |row: u64| [row.is_multiple_of(4), true, true];
    assert_eq!(names(&table(2000, shared)), ["gyro accel", "mag"]);
    let interleaved = |row: u64| [row.is_multiple_of(3), row % 3 == 1, row % 3 == 2];
    assert_eq!(names(&table(2000, interleaved)), ["gyro", "accel", "mag"]);
    let never_shared = |row: u64| [row % 5 == 1, row % 5 != 1, row % 5 != 1];
    assert_eq!(names(&table(2000, never_shared)), ["gyro accel", "mag"]);
    // three of five rows, spaced as evenly as possible
    assert_eq!(names(&table(2000, |row| [row * 3 / 5 != (row + 1) * 3 / 5, true, true])), ["gyro accel", "mag"]);
    let late = |row: u64| [row > 1500 && row.is_multiple_of(4), true, true];
    assert_eq!(names(&table(2000, late)), Vec::<String>::new(), "left out, as the first rows have none");
}

#[test]
fn lost_values_make_no_stream() {
    let none = Vec::<String>::new();
    assert_eq!(names(&table(2000, |_| [true; 3])), none);
    assert_eq!(names(&table(2000, |row| [row % 10 != 3, row % 7 != 2, true])), none);
    assert_eq!(names(&table(2000, |row| [row > 1200, true, true])), none, "begins late");
    assert_eq!(names(&table(2000, |row| [row.is_multiple_of(400), true, true])), none, "five values");
    assert_eq!(names(&table(2000, |_| [false, true, true])), none);
    // a change after a thousand whole rows is no other rate
    assert_eq!(names(&table(3000, |row| [row < 1000 || row.is_multiple_of(4), true, true])), none);
}

#[test]
fn without_times_and_in_messages_of_the_sensor_all_columns_are_one_stream() {
    let text = table(2000, |row| [row.is_multiple_of(4), true, true]);
    assert!(names(&text.replace("t,", "n,")).is_empty());
    let rows: String =
        (0..100).map(|row| format!("{row}.5,1,2,3{}\n", if row % 4 == 0 { ",4" } else { "," }.repeat(9))).collect();
    let text = format!("{}\n{rows}", super::HEADER);
    assert_eq!(&*layout(&plan(&text, None).unwrap().unwrap()).message, "VNYMR");
    assert!(names(&text).is_empty());
}

/// The result for a stream of `text`, in a file of this map.
fn stream(text: &str, map: &str, stream: Option<&str>) -> Whole {
    let map = map.parse().unwrap();
    let plan = detect(text.as_bytes(), Said { map: Some(&map), stream, file: None }).unwrap().unwrap();
    read(plan, text.as_bytes())
}

/// The table without rows that are empty in the columns `from..to`, and without the other columns.
fn alone(text: &str, from: usize, to: usize) -> String {
    let mut alone = String::new();
    for line in text.lines() {
        let fields: Vec<_> = line.split(',').collect();
        if fields[from..to].iter().any(|field| !field.is_empty()) {
            writeln!(alone, "{},{}", fields[0], fields[from..to].join(",")).unwrap();
        }
    }
    alone
}

#[test]
fn columns_that_are_not_there_are_refused_with_those_that_are() {
    let text = table(100, |_| [true; 3]);
    for name in ["magg", "gyro temperature", " ", ""] {
        let error = detect(text.as_bytes(), Said { stream: Some(name), ..Said::default() }).unwrap_err();
        assert_eq!(error.to_string(), format!("no columns of {name:?}: name some of gyro, accel, mag"));
    }
}

const MAPS: [(&str, &str, usize, usize); 2] = [
    ("mag", "t=t:s,mag_x=mag_x:gauss,mag_y=mag_y:gauss", 1, 3),
    ("gyro accel", "t=t:s,accel_x=accel_x:g,gyro_x=gyro_x:deg/s,gyro_y=gyro_y:deg/s", 3, 6),
];
const ALL: &str = "t=t:s,mag_x=mag_x:gauss,mag_y=mag_y:gauss,accel_x=accel_x:g,gyro_x=gyro_x:deg/s,gyro_y=gyro_y:deg/s";

proptest! {
    /// The stream has rows of its own or shares them with others, and any of its values may be lost.
    #[test]
    fn a_stream_is_read_as_in_a_table_of_its_own(held in proptest::collection::vec(any::<[bool; 3]>(), 20..200)) {
        let text = table(held.len() as u64, |row| held[row as usize]);
        let mut rows = 0;
        for (name, map, from, to) in MAPS {
            let found = stream(&text, ALL, Some(name));
            let expected = stream(&alone(&text, from, to), map, None);
            prop_assert_eq!((&found.counts, &found.stamps_ns), (&expected.counts, &expected.stamps_ns));
            let report = &found.report;
            let empty = held.iter().filter(|held| **held == [false; 3]).count() as u64;
            prop_assert_eq!(found.rejected_rows(), empty);
            prop_assert_eq!(report.rows + report.other_stream_rows.unwrap() + empty, held.len() as u64);
            rows += report.rows;
        }
        prop_assert!(rows as usize >= held.iter().filter(|held| **held != [false; 3]).count());
    }

    /// One value in `every` rows, beginning at any row, together with columns that lose a few at random.
    #[test]
    fn rates_are_parted_and_losses_are_not(every in 2_u64..9, first in 0_u64..9, lost in 0.0_f64..0.2, seed: u64) {
        let mut state = seed | 1;
        let mut is_lost = |share: f64| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / 2_f64.powi(53) < share
        };
        let rare = table(2000, |row| [row % every == first % every, !is_lost(lost), !is_lost(lost)]);
        prop_assert_eq!(names(&rare), ["gyro accel", "mag"]);
        let random = table(2000, |_| [!is_lost(3.0 * lost), !is_lost(lost / 4.0), true]);
        prop_assert!(names(&random).is_empty());
    }
}
