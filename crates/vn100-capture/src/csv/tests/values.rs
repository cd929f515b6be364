//! Files with the fields of the sensor's lines in columns.

use std::io;

use vn100_protocol::VNIMU;

use super::*;

const IMU_HEADER: &str = "mag_x,mag_y,mag_z,accel_x,accel_y,accel_z,gyro_x,gyro_y,gyro_z,temperature,pressure";

#[test]
fn the_sensors_own_decimals_and_a_scripts_floats_are_the_same() {
    let floats = "-85.469,74.972,63.752,-0.5551,0.4403,0.9048,8.971,-2.145,-1.093,4e-05,-0.000301,-0.000391";
    let saved = "-8.546899999999999409e+01,7.497199999999999420e+01,6.375200000000000244e+01,-5.551000000000000378e-01,4.403000000000000247e-01,\
                 9.048000000000000487e-01,8.971000000000000085e+00,-2.145000000000000018e+00,-1.092999999999999972e+00,\
                 4.000000000000000327e-05,-3.009999999999999980e-04,-3.910000000000000172e-04";
    for values in [VALUES, floats] {
        let whole = read_text(format!("{HEADER}\n0.5,{values}\n0.525,{values}\n"), None);
        assert_eq!(whole.counts, [COUNTS, COUNTS].concat());
        assert_eq!(whole.stamps_ns, [0, 25_000_000]);
        assert_eq!(whole.report.skipped_lines, 1);
    }
    // floats printed in full are the same numbers
    let text = format!("# {HEADER}\n1.761939167192566e+09,{saved}\n");
    let plan = planned(&text, None);
    assert_eq!((layout(&plan).channels, rounded(&plan).len()), (VNYMR.channels.clone(), 0));
    assert_eq!(read(plan, text.as_bytes()).counts, COUNTS);
}

#[test]
fn columns_come_in_any_order_and_the_others_are_named() {
    let text = "GYR_Z;note; Acc_X ;\"t\";gyr_x\n0.000003;\"a;b\";\" +01.000\" ;0.1;+00.000001\n";
    let plan = plan(text, None).unwrap().unwrap();
    let names: Vec<_> = layout(&plan).channels.iter().map(|channel| channel.name.clone()).collect();
    assert_eq!(names, ["accel_x", "gyro_x", "gyro_z"]);
    assert_eq!(layout(&plan).message, "CSV");
    assert_eq!(plan.report.ignored_columns, ["note"]);
    assert_eq!(plan.columns[3], ColumnUse::Stamp(StampForm::Unit(1_000_000_000)));
    assert_eq!(read(plan, text.as_bytes()).counts, [1000, 1, 3]);
}

#[test]
fn line_ends_marks_and_separators_are_the_files_own() {
    let text = format!("{HEADER}\n1.0,{VALUES}\n2.0,{VALUES}");
    let expected = read_text(&text, None);
    assert_eq!(expected.counts, [COUNTS, COUNTS].concat());
    for variant in [
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        text.replace(',', ";"),
        text.replace(',', "\t"),
        text.replace(',', ", "),
        format!("\u{feff}{text}"),
        format!("\n# made by hand\n#\n{text}\n\n"),
        format!("# {text}"),
        format!("# acc_x, acc_y in m/s^2\n{text}"),
    ] {
        let whole = read_text(&variant, None);
        assert_eq!((&whole.counts, &whole.stamps_ns), (&expected.counts, &expected.stamps_ns), "{variant:?}");
        assert_eq!(whole.rejected_rows(), 0);
    }
}

#[test]
fn compensation_belongs_to_the_column_and_to_no_comment() {
    let row = "+00.0443,+00.2479,-00.3381,-00.222,-00.035,-09.851,-00.005406,-00.000484,+00.000833,+24.5,+101.325";
    let read_layout = |text: String| layout(&plan(text, None).unwrap().unwrap());
    for above in ["", "# $VNIMU at 40 Hz\n", "# uncompensated\n", "# recorded after VNYMR was off\n"] {
        let unsaid = read_layout(format!("{above}{IMU_HEADER}\n{row}\n"));
        assert_eq!((&*unsaid.message, unsaid.compensated), ("CSV", None), "{above}");
        assert_eq!(unsaid.channels, VNIMU.channels);
    }
    let header =
        "UncompMagX,UncompMagY,UncompMagZ,UncompAccX,UncompAccY,UncompAccZ,UncompGyroX,UncompGyroY,UncompGyroZ";
    assert_eq!(read_layout(format!("{header},Temperature,Pressure\n{row}\n")), VNIMU);
    // if both kinds exist, the uncompensated columns are read, in any order
    let text = "GyroX,UncompGyroX,AccelX,UncompAccX\n1,2,3,4\n5,6,7,8\n";
    let whole_plan = planned(text, None);
    assert_eq!(layout(&whole_plan).compensated, Some(false));
    let left_out: Vec<_> = whole_plan.report.left_out.iter().map(|column| (&*column.name, &*column.reason)).collect();
    let reason = "compensated, an uncompensated column is read";
    assert_eq!(left_out, [("GyroX", reason), ("AccelX", reason)]);
    assert_eq!(read(whole_plan, text.as_bytes()).counts, [4000, 2_000_000, 8000, 6_000_000]);
}

#[test]
fn columns_that_are_left_out_are_named_with_the_reason() {
    let text = "t,acc_l_x[mg],acc_h_x[mg],gyro_x [furlong],gyro_x,gyro_x,Linear Acceleration x (m/s^2),mag_x\n\
                0.00,1,2,3,4,5,6,\n0.01,1,2,3,4,5,6,\n";
    let plan = planned(text, None);
    let left_out: Vec<_> = plan.report.left_out.iter().map(|column| (&*column.name, &*column.reason)).collect();
    assert_eq!(
        left_out,
        [
            ("acc_h_x[mg]", "another accel column is read"),
            ("gyro_x [furlong]", "the unit \"furlong\" is not known for it"),
            ("gyro_x", "another gyro column is read"),
            ("Linear Acceleration x (m/s^2)", "without gravity, a column with gravity is read"),
            ("mag_x", "empty in the first rows"),
        ]
    );
    assert_eq!(plan.report.ignored_columns, Vec::<String>::new());
    assert_eq!(read(plan, text.as_bytes()).counts, [1, 4_000_000, 1, 4_000_000]);
}

#[test]
fn an_attitude_makes_the_channels_those_of_a_message() {
    let header = "mag_x,mag_y,mag_z,accel_x,accel_y,accel_z,gyro_x,gyro_y,gyro_z";
    let row = "+00.0443,+00.2479,-00.3381,-00.222,-00.035,-09.851,-00.005406,-00.000484,+00.000833";
    let read_layout = |text: String| layout(&plan(text, None).unwrap().unwrap());
    assert_eq!(read_layout(format!("{header}\n{row}\n")).message, "CSV");
    let quaternion = "quat_x,quat_y,quat_z,quat_w";
    assert_eq!(read_layout(format!("{header},{quaternion}\n{row},+0.6,-0.0,+0.0,-0.8\n")).message, "VNQMR");
}

#[test]
fn more_decimals_than_the_sensor_prints_are_kept() {
    let text = "gyro_x,gyro_y\n0.12345678,0.000001\n0.1234567,0.000002\n";
    let plan = planned(text, None);
    let channels = layout(&plan).channels;
    assert_eq!((channels[0].decimals, channels[0].limit_counts), (8, i32::MAX));
    assert_eq!((channels[1].decimals, channels[1].limit_counts), (6, 40_000_000));
    assert_eq!(read(plan, text.as_bytes()).counts, [12_345_678, 1, 12_345_670, 2]);
}

#[test]
fn each_rejected_row_is_counted_with_its_reason() {
    let mut text = "t,gyro_x,accel_x\n".to_owned();
    for row in 0..HEAD_ROWS {
        text.push_str(&format!("{row}.0,0.000001,9.81\n"));
    }
    for row in [
        "1000,0.000001",
        "1001,0.000001,9.81,7",
        "1002,nan,9.81,1",
        "1003,,9.81",
        "1004,1e-7,9.81",
        "1005,1.0000000,9.81",
        "1006,40.000001,9.81",
        "1006.5, NaN,-inf",
        "1007,0.0001x,9.81",
        "soon,0.000001,9.81",
        "1e30,0.000001,9.81",
        "1009,0.000001,9.81",
    ] {
        text.push_str(row);
        text.push('\n');
    }
    let whole = read_text(&text, None);
    assert_eq!(whole.rejected, [1000, 1000, 1000, 1004, 1004, 1004, 1004]);
    let kinds: Vec<_> = whole.report.rejected.iter().map(|rows| (rows.reason, rows.count)).collect();
    assert_eq!(kinds, [(RejectedRow::Fields, 3), (RejectedRow::Number, 2), (RejectedRow::Stamp, 2)]);
    assert_eq!(
        whole.report.rejected[0],
        RejectedRows { reason: RejectedRow::Fields, count: 3, first_line: 1002, first_text: "1000,0.000001".into() }
    );
    let second = &whole.report.rejected[1];
    assert_eq!((second.reason, second.first_line), (RejectedRow::Number, 1009));
    assert_eq!(whole.stamps_ns[1000..], [1003, 1004, 1005, 1006, 1009].map(|second| second * 1_000_000_000));
    // six decimals; of a value beyond the counts and of an absent value only the other channel remains
    assert_eq!(whole.counts[2000..], [9810, 0, 9810, 0, 9810, 1_000_000, 9810, 0, 9810, 1]);
    assert_eq!(whole.report.rounded, ["gyro_x"]);
    let absent = AbsentValues {
        channel: "gyro_x".into(),
        empty: 1,
        out_of_range: 1,
        first_line: 1005,
        ..AbsentValues::default()
    };
    assert_eq!(whole.report.absent, [absent]);
}

#[test]
fn a_line_without_end_is_one_rejected_row() {
    let mut bytes = b"t,gyro_x\n0.0,0.5\n".to_vec();
    for length in [lines::LONGEST_LINE, 5 * lines::LONGEST_LINE + 7] {
        bytes.extend(std::iter::repeat_n(b'7', length));
        bytes.extend_from_slice(b"\n1,0.25\n");
    }
    let whole = read_text(&bytes, None);
    assert_eq!(whole.counts, [500_000, 250_000, 250_000]);
    assert_eq!(whole.rejected, [1, 2]);
    assert_eq!(whole.report.lines, 6);
    let row_bytes = "0.0,0.5\n".len() + 2 * "1,0.25\n".len();
    assert_eq!(whole.bytes, [row_bytes as u64, (6 * lines::LONGEST_LINE + 9) as u64, 9]);
}

#[test]
fn stamps_may_go_backwards() {
    let whole = read_text("t,gyro_x\n1761939167192566000,1\n1761939167192565999,1\n", None);
    assert_eq!(whole.stamps_ns, [0, -1]);
    let whole = read_text("gyro_x\n1\n", None);
    assert_eq!((&whole.stamps_ns[..], &whole.counts[..]), (&[][..], &[1_000_000][..]));
}

#[test]
fn a_reader_that_fails_loses_nothing() {
    struct Faulty(u8);
    impl Read for Faulty {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            self.0 += 1;
            match self.0 {
                1 => (&b"gyro_x\n1\n0.00"[..]).read(buffer),
                2 => Err(io::ErrorKind::Interrupted.into()),
                3 => Err(io::Error::other("unplugged")),
                4 => (&b"0002\n"[..]).read(buffer),
                _ => Ok(0),
            }
        }
    }
    let plan = plan("gyro_x\n1\n", None).unwrap().unwrap();
    let mut reader = CsvReader::new(plan, Faulty(0), ReadOptions::default());
    assert_eq!(next_counts(&mut reader).unwrap(), Some(vec![1_000_000]));
    assert_eq!(next_counts(&mut reader).unwrap_err().to_string(), "unplugged");
    assert_eq!(next_counts(&mut reader).unwrap(), Some(vec![2]));
    assert_eq!(next_counts(&mut reader).unwrap(), None);
}

/// The counts of the next batch; `None` at the end.
fn next_counts(reader: &mut CsvReader<impl Read + Send + 'static>) -> io::Result<Option<Vec<i32>>> {
    let events = reader.next_events()?;
    Ok(events.map(|events| match &events[..] {
        [Event::Batch(batch)] => batch.counts.clone(),
        other => panic!("{other:?}"),
    }))
}

#[test]
fn a_batch_holds_512_rows_at_most() {
    let text = format!("gyro_x\n{}", "1\n,\n".repeat(600));
    let plan = plan(&text, None).unwrap().unwrap();
    let mut reader = CsvReader::new(plan, Cursor::new(text), ReadOptions::default());
    let rows = std::iter::from_fn(|| next_counts(&mut reader).unwrap().map(|counts| counts.len()));
    assert_eq!(rows.collect::<Vec<_>>(), [256, 256, 88]);
}

#[test]
fn other_files_are_no_csv_of_a_sensor() {
    for text in [
        "",
        "\n\n",
        "# only\n# comments\n",
        &format!("{SENTENCE}\r\n{SENTENCE}\r\n"),
        "Dear all,\nplease find the data, raw, attached.\n",
        "1,2,3\n4,5,6\n",
        "\0\u{1}\u{2},\n",
    ] {
        assert!(plan(text, None).unwrap().is_none(), "{text:?}");
    }
}

#[test]
fn missing_columns_are_an_error() {
    let error = plan("date,humidity,temperature\n1,40.5,20.1\n", None).unwrap_err();
    assert_eq!(error.hint(), Some(&OpenHint::Columns(None)), "a temperature alone is no map");
    let error = error.to_string();
    assert!(error.starts_with("no known column in this CSV file: expected gyro_x gyro_y"), "{error}");
    assert!(error.ends_with("; found date, humidity, temperature"), "{error}");
    // a data frame numbers its rows in a column without a name
    let error = plan(",t_ms,wx\n0,1000,0.1\n1,1010,0.2\n", None).unwrap_err();
    assert_eq!(error.hint(), Some(&OpenHint::Columns(None)), "no unit is sure");
    assert!(error.to_string().ends_with("; found t_ms, wx"), "{error}");
    let error = plan("t,gyro_x\nten past two,0.1\n", None).unwrap_err().to_string();
    assert!(error.starts_with("the time stamps in column \"t\" are neither numbers nor dates"), "{error}");
    assert!(error.contains("the first is \"ten past two\""), "{error}");
}

#[test]
fn stamps_of_an_unsure_unit_are_refused_with_the_remedy() {
    let rows = |step: u64| (0..50).map(move |row| format!("{},0.1\n", step * row)).collect::<String>();
    for header in ["t,gyro_x\n", "# t,gyro_x\n"] {
        let error = plan(format!("{header}{}", rows(1)), None).unwrap_err();
        assert_eq!(error.hint(), Some(&OpenHint::StampUnit("t=t:ms".into())));
        assert_eq!(
            error.to_string(),
            "the unit of the time stamps in column \"t\" is ambiguous: they step by 1 from row to row, which may be s or ms"
        );
    }
    let error = plan(format!("\"%time\",gyro_x\n{}", rows(7_000_000_000)), None).unwrap_err();
    assert_eq!(error.hint(), Some(&OpenHint::StampUnit("t=%time:ms".into())));
    let error = error.to_string();
    assert!(
        error.contains("step by 7000000000 from row to row, which is not between 1 ms and 1 s in any unit"),
        "{error}"
    );
    // the remedy
    for (map, step_ns) in [("t=t:s", 1_000_000_000), ("t=1:ms", 1_000_000), ("t=T:us", 1000), ("t=t:ns", 1)] {
        let whole = read_text(format!("t,gyro_x\n{}", rows(1)), Some(map));
        assert_eq!((whole.stamps_ns[1], &*whole.counts), (step_ns, &[100_000; 50][..]), "{map}");
    }
}

#[test]
fn stamps_since_a_start_are_read_in_their_own_unit() {
    for step in [25, 25_000, 25_000_000_i64] {
        let rows = (0..50).map(|row| format!("{},0.1\n", step * row));
        let whole = read_text("t,gyro_x\n".to_owned() + &rows.collect::<String>(), None);
        assert_eq!(whole.stamps_ns[1], 25_000_000, "{step}");
    }
}

#[test]
fn a_surplus_separator_at_the_end_is_no_field() {
    let rows = |end: &str| format!("0.000,0.5,9.81{end}\n0.025,0.25,9.82{end}\n");
    for (header, end, ignored) in [
        ("t,gyro_x,accel_x,", ",", 0),
        ("t,gyro_x,accel_x", ",", 0),
        ("t,gyro_x,accel_x", ", ", 0),
        ("t,gyro_x,accel_x,", "", 0),
        ("# t,gyro_x,accel_x", ",", 0),
        // columns without a name
        ("t,gyro_x,accel_x,", ",7", 0),
        ("t,gyro_x,accel_x,,", ",,", 0),
        ("t,gyro_x,accel_x", ",,", 0),
        ("t,gyro_x,accel_x,,,", ",,", 0),
    ] {
        let text = format!("{header}\n{}", rows(end));
        let plan = plan(&text, None).unwrap().unwrap();
        assert_eq!(plan.report.ignored_columns.len(), ignored, "{header:?} {end:?}");
        let whole = read(plan, text.as_bytes());
        assert_eq!(
            (&*whole.counts, whole.rejected.len()),
            (&[9810, 500_000, 9820, 250_000][..], 0),
            "{header:?} {end:?}"
        );
    }
    let error = plan("date,humidity,\n1,40.5,\n", None).unwrap_err().to_string();
    assert!(error.ends_with("; found date, humidity"), "{error}");
}

#[test]
fn a_row_cut_in_its_last_number_is_no_sample() {
    let text = format!("{HEADER}\n1.0,{VALUES}\n1.025,{VALUES}\n1.050,{VALUES}");
    assert_eq!(read_text(&text, None).report.rows, 3);
    assert_eq!(read_text(format!("{text}\r"), None).report.rows, 3);
    let last_row = text.rfind('\n').unwrap() + 1;
    for end in last_row + 1..text.len() {
        let whole = read_text(&text[..end], None);
        assert_eq!((whole.report.rows, &*whole.rejected), (2, &[2][..]), "{}", &text[..end]);
    }
}

#[test]
fn a_comment_needs_no_line_end() {
    let whole = read_text("gyro_x\n0.5\n# done", None);
    assert_eq!((whole.report.rows, whole.rejected_rows(), whole.report.skipped_lines), (1, 0, 2));
}

#[test]
fn the_unit_of_one_axis_is_that_of_its_triple() {
    for (names, read) in [
        ("gyro_x [deg/s],gyro_y,gyro_z", "deg/s deg/s deg/s"),
        ("gyro_x,gyro_y,gyro_z_dps", "deg/s deg/s deg/s"),
        ("wx (deg/s),wy,wz", "deg/s deg/s deg/s"),
        ("gyro_x [deg/s],gyro_y [rad/s],gyro_z", "deg/s rad/s"),
        ("gyro_x,gyro_x_dps,gyro_y", "rad/s rad/s"),
    ] {
        let plan = planned(format!("t,{names}\n0,1,2,3\n0.01,2,3,4\n0.02,1,3,4\n"), None);
        let layout = plan.layout.unwrap();
        let units: Vec<&str> =
            layout.columns.iter().flat_map(|read| &read.columns).map(|column| &*column.unit).collect();
        assert_eq!(units.join(" "), read, "{names}");
    }
    assert!(plan("t,gyro_x [rad],gyro_y,gyro_z\n0,1,2,3\n0.01,2,3,4\n", None).is_err());
}
