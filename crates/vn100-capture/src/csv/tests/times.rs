//! Stamps by name and content, in all their forms, and sentences in columns of any name.

use super::*;

/// The stamps of these rows, and their form.
fn times(text: &str, map: Option<&str>) -> (Vec<i64>, Option<String>) {
    let whole = read_text(text, map);
    (whole.stamps_ns, whole.report.times)
}

/// Forty stamps a second, printed by `stamp` from nanoseconds since the first.
fn table(header: &str, stamp: impl Fn(u64) -> String) -> String {
    let rows = (0..80).map(|row| format!("{},0.{}\n", stamp(row * 25_000_000), row % 7));
    format!("{header},gyro_x\n{}", rows.collect::<String>())
}

#[test]
fn times_are_found_by_name_and_content_and_reported() {
    let epoch = 1_761_939_167_000_000_000_u64;
    let seconds = |ns: u64, digits: usize| format!("{:.digits$}", ns as f64 / 1e9);
    let of_day = |ns: u64| format!("02:25:{:02}.{:03}", ns / 1_000_000_000, ns / 1_000_000 % 1000);
    for (header, stamp, reported) in [
        ("stamp", &(|ns| seconds(ns, 3)) as &dyn Fn(u64) -> String, "stamp:s"),
        ("time_ms", &|ns| (ns / 1_000_000).to_string(), "time_ms:ms"),
        ("Timestamp", &|ns| (epoch + ns).to_string(), "Timestamp:ns"),
        ("header.stamp", &|ns| (epoch / 1000 + ns / 1000).to_string(), "header.stamp:us"),
        ("Time [ms]", &|ns| (ns / 1_000_000).to_string(), "Time [ms]:ms"),
        (
            "unix_time",
            &|ns| format!("{}.{:06}", (epoch + ns) / 1_000_000_000, (epoch + ns) / 1000 % 1_000_000),
            "unix_time:s",
        ),
        (
            "secs,nsecs",
            &|ns| format!("{},{}", (epoch + ns) / 1_000_000_000, (epoch + ns) % 1_000_000_000),
            "secs:s+nsecs:ns",
        ),
        (
            "stamp.nanosec,stamp.sec",
            &|ns| format!("{},{}", (epoch + ns) % 1_000_000_000, (epoch + ns) / 1_000_000_000),
            "stamp.sec:s+stamp.nanosec:ns",
        ),
        (
            "time [s],time [us]",
            &|ns| format!("{},{}", ns / 1_000_000_000, ns / 1000 % 1_000_000),
            "time [s]:s+time [us]:us",
        ),
        (
            "t_sec,t_nsec",
            &|ns| format!("{},{}", (epoch + ns) / 1_000_000_000, (epoch + ns) % 1_000_000_000),
            "t_sec:s+t_nsec:ns",
        ),
        ("when", &|ns| format!("2023-03-06T{}Z", of_day(ns)), "when:iso"),
        ("Time", &|ns| format!("2023-03-06 {}+01:00", of_day(ns)), "Time:iso"),
        ("host", &|ns| format!("2023/03/06/{}", of_day(ns)), "host:iso"),
        ("at", &|ns| format!("31/03/2023 {}", of_day(ns)), "at:dmy"),
        ("at", &|ns| format!("03/31/2023 {}", of_day(ns)), "at:mdy"),
        ("Zeit", &of_day, "Zeit:clock"),
        ("Time", &|ns| format!("25:{:02}.{:03}", ns / 1_000_000_000, ns / 1_000_000 % 1000), "Time:mmss"),
    ] {
        let (stamps, named) = times(&table(header, stamp), None);
        assert_eq!(named.as_deref(), Some(reported), "{header}");
        assert_eq!(stamps, (0..80).map(|row| row * 25_000_000).collect::<Vec<_>>(), "{header}");
        // the reported map gives the same stamps
        let (mapped, named) = times(&table(header, stamp), Some(&format!("t={reported}")));
        assert_eq!((mapped, named.as_deref()), (stamps, Some(reported)), "{header}");
    }
}

#[test]
fn a_fine_time_in_microseconds_is_none_in_ticks() {
    for (unit_ns, form) in [(1000, "SampleTimeFine:us"), (100_000, "SampleTimeFine:100us")] {
        for step_us in [5000_u64, 8300, 10_000, 16_700] {
            let rows: String = (0..80).map(|row| format!("{},0.1\n", (row * step_us * 1000) / unit_ns)).collect();
            assert_eq!(times(&format!("SampleTimeFine,gyro_x\n{rows}"), None).1.as_deref(), Some(form), "{step_us}");
        }
    }
}

#[test]
fn a_word_of_a_longer_name_means_times() {
    for (header, unit_ns) in [
        ("Shimmer_1_Timestamp_Unix_CAL [ms]", 1_000_000),
        ("Time.TimeStartup", 1),
        ("imu time startup [us]", 1000),
        ("local_time_of_host_us", 1000),
    ] {
        let (stamps, named) =
            times(&table(header, |ns| ((1_700_000_000_000_000_000 + ns) / unit_ns).to_string()), None);
        assert!(named.is_some_and(|named| named.starts_with(header)), "{header}");
        assert_eq!(stamps, (0..80).map(|row| row * 25_000_000).collect::<Vec<_>>(), "{header}");
    }
}

#[test]
fn a_stated_unit_is_not_replaced_by_a_likelier_one() {
    let rows = |name: &str, stamp: &dyn Fn(u32) -> String| {
        format!("{name},gyro_x\n{}", (0..800).map(|row| format!("{},0.1\n", stamp(row))).collect::<String>())
    };
    for (name, stamp, second_ns) in [
        ("time [s]", &(|row: u32| (10 * row).to_string()) as &dyn Fn(u32) -> String, 10_000_000_000),
        ("Time (s)", &|row| format!("{:.1}", 1.7e9 + f64::from(10 * row)), 10_000_000_000),
        ("time_us", &|row| (5_000_000 * row).to_string(), 5_000_000_000),
        ("time [ms]", &|row| format!("{:.3}", 0.05 * f64::from(row)), 50_000),
        ("Time (min)", &|row| format!("{:.9}", 0.0002 * f64::from(row)), 12_000_000),
        ("elapsed_minutes", &|row| format!("{:.6}", 0.01 * f64::from(row)), 600_000_000),
        ("t [hours]", &|row| format!("{:.9}", 0.00001 * f64::from(row)), 36_000_000),
        // a clock that ticks each 40 rows
        ("time_ms", &|row| format!("{:.3}", f64::from(row / 40 * 100)), 0),
    ] {
        let (stamps, _) = times(&rows(name, stamp), None);
        assert_eq!(stamps.get(1), Some(&second_ns), "{name}");
        assert!(name != "time_ms" || stamps[799] == 1_900_000_000);
    }
    // the unit that is advised is one that is possible, if there is any
    for (name, start, step, likely) in [
        ("t [s]", 0.0, 25_000.0, "us"),
        ("t [ms]", 0.0, 2.5e-6, "ms"),
        ("t", 0.0, 2.5e-6, "ms"),
        ("t [ms]", 1.7e9, 0.05, "s"),
        ("t [us]", 1.7e18, 25e6, "ns"),
    ] {
        let error = plan(rows(name, &|row| format!("{:.9}", start + step * f64::from(row))), None).unwrap_err();
        assert_eq!(error.hint(), Some(&OpenHint::StampUnit(format!("t={name}:{likely}"))), "{step}");
    }
}

#[test]
fn a_time_of_day_without_colons_is_no_number_of_seconds() {
    let of_day = |start_s: u64, ns: u64| {
        let time_s = start_s + ns / 1_000_000_000;
        format!("{}{:02}{:02}.{:03}", time_s / 3600, time_s / 60 % 60, time_s % 60, ns / 1_000_000 % 1000)
    };
    for (name, start_s) in [("time", 42_959), ("Time [s]", 32_399), ("utc", 35_999)] {
        let (stamps, form) = times(&table(name, |ns| of_day(start_s, ns)), None);
        assert_eq!(form, Some(format!("{name}:clock")), "{start_s}");
        assert_eq!(stamps, (0..80).map(|row| row * 25_000_000).collect::<Vec<_>>(), "{start_s}");
    }
    // a gap over the end of a minute, and a number of seconds that passes one
    for start_s in [57_u64, 99] {
        let seconds = |ns: u64| format!("{}.{:03}", start_s + 45 * (ns / 1_000_000_000), ns / 1_000_000 % 1000);
        assert_eq!(times(&table("time", seconds), None).1.as_deref(), Some("time:s"), "{start_s}");
    }
}

#[test]
fn other_columns_are_no_time() {
    for header in ["note", "count", "voltage"] {
        assert_eq!(times(&table(header, |ns| (ns / 25_000_000).to_string()), None), (vec![], None), "{header}");
    }
    let minutes = |row: u64| {
        format!("day,hour,min,gyro_x\n{}", (0..row).map(|row| format!("1,2,{},0.1\n", row / 60)).collect::<String>())
    };
    assert_eq!(times(&minutes(900), None), (vec![], None), "parts of a date");
    // a name of a time, with numbers that are no times
    assert_eq!(times(&table("exposure_time", |ns| (ns % 3).to_string()), None), (vec![], None));
}

#[test]
fn day_and_month_must_be_distinct() {
    let text = table("Date", |ns| format!("03/06/2023 02:25:{:02}", ns / 1_000_000_000));
    for name in ["t", "Date", "logged"] {
        let error = plan(text.replace("Date", name), None).unwrap_err();
        assert_eq!(error.hint(), Some(&OpenHint::DateOrder(format!("t={name}:dmy"))), "{name}");
    }
    assert!(!times(&text, Some("t=Date:mdy")).0.is_empty());
}

#[test]
fn a_time_of_day_continues_behind_midnight() {
    let (stamps, _) = times("clock,gyro_x\n23:59:59.950,1\n23:59:59.975,2\n00:00:00.000,3\n00:00:00.025,4\n", None);
    assert_eq!(stamps, [0, 25_000_000, 50_000_000, 75_000_000]);
}

#[test]
fn sentences_are_found_in_a_column_of_any_name() {
    for (header, row, map) in [
        ("t,Raw IMU Data String", "1.5,\"SENTENCE\"", None),
        ("Timestamp,vnymr_read", "1.5,SENTENCE", None),
        ("secs,nsecs,Original String,n", "1,500000000,\"b'SENTENCE\\r\\n'\",7", None),
        ("stamp,VNYMR", "2023-03-06T02:25:02.45,\"b'SENTENCE'\"", None),
        ("n,x", "7,SENTENCE", Some("t=1:ms,raw=x")),
    ] {
        let row = row.replace("SENTENCE", SENTENCE);
        let text = format!("{header}\n{row}\n{row}\n");
        let plan = plan(&text, map).unwrap().unwrap();
        assert!(plan.layout.is_none(), "{header}");
        let whole = read(plan, text.as_bytes());
        assert_eq!(whole.counts, [COUNTS, COUNTS].concat(), "{header}");
        assert_eq!(whole.stamps_ns, [0, 0], "{header}");
    }
    // a named column needs no times
    let text = format!("x\n{SENTENCE}\n");
    let whole = read_text(&text, Some("raw=1"));
    assert_eq!((whole.report.rows, whole.stamps_ns.len()), (1, 0));
    assert!("raw=x,gyro_x=wx:deg/s".parse::<ColumnMap>().is_err());
}

#[test]
fn rows_of_sentences_after_times_need_no_header() {
    let rows: String = (0..8).map(|row| format!("2023-03-06 02:25:02.{:03},{SENTENCE}\n", row * 25)).collect();
    let whole = read_text(&rows, None);
    assert_eq!((whole.report.rows, whole.stamps_ns[7], whole.report.times.as_deref()), (8, 175_000_000, Some("1:iso")));
    let epoch: String = (0..8).map(|row| format!("1710358267.{:03},{SENTENCE}\n", row * 25)).collect();
    assert_eq!(read_text(&epoch, None).stamps_ns[7], 175_000_000);
    // only a count precedes the sentences: the file can be read as text just as well
    let counted: String = (0..8).map(|row| format!("{row},{SENTENCE}\n")).collect();
    assert!(plan(&counted, None).unwrap().is_none());
}

#[test]
fn the_first_error_of_an_unknown_table_names_a_map_that_reads_it() {
    let rows: String =
        (0..20).map(|row| format!("{},0.1,0.2,9.8\n", 1_761_939_167_000_000_000_u64 + row * 25_000_000)).collect();
    let text = format!("Timestamp,omega x [deg/s],omega y [deg/s],a_z\n{rows}");
    let whole = read_text(&text, None);
    assert_eq!((whole.report.rows, whole.stamps_ns[19], whole.counts.len()), (20, 475_000_000, 40));
    // letters without units need a map, which the magnitudes suggest
    let rows: String =
        (0..60).map(|row| format!("{}.{:02},0.1,0.2,9.8,0.01,0.02,0.0{}\n", row / 100, row % 100, row % 7)).collect();
    let text = format!("s,tx,ty,tz,wx,wy,wz\n{rows}");
    let Some(OpenHint::Columns(Some(map))) = plan(&text, None).unwrap_err().hint().cloned() else { panic!("no map") };
    assert_eq!(
        map,
        "accel_x=tx:m/s^2,accel_y=ty:m/s^2,accel_z=tz:m/s^2,gyro_x=wx:rad/s,gyro_y=wy:rad/s,gyro_z=wz:rad/s,t=s:s"
    );
    assert_eq!((read_text(&text, Some(&map)).report.rows, read_text(&text, Some(&map)).rejected_rows()), (60, 0));
    for text in [text.replace("9.8", "3.3"), text.replace("wz", "speed"), text.replace("0.01,", "7.01,")] {
        assert_eq!(plan(&text, None).unwrap_err().hint(), Some(&OpenHint::Columns(None)), "{}", &text[..30]);
    }
}

#[test]
fn a_date_and_its_time_of_day_between_spaces_are_one_stamp() {
    let time = |row: u64| format!("12:{:02}:{:02}.{:03}", row / 2400, row / 40 % 60, row % 40 * 25);
    for (header, stamp, reported) in [
        ("time gyro_x accel_z", &(|row| format!("2024-05-01 {}", time(row))) as &dyn Fn(u64) -> String, "time:iso"),
        ("# time gyro_x accel_z", &|row| format!("2024/05/01 {}", time(row)), "time:iso"),
        ("Date Time gyro_x accel_z", &|row| format!("31.05.2024  {}", time(row)), "Date_Time:dmy"),
        ("when gyro_x accel_z", &|row| format!("\"2024-05-01 {}+00:00\"", time(row)), "when:iso"),
        ("t gyro_x accel_z", &|row| format!("2024-05-01T{}", time(row)), "t:iso"),
        ("t gyro_x accel_z", &|row| time(row), "t:clock"),
    ] {
        let rows = (0..80).map(|row| format!("{}  0.{} -9.8{}\n", stamp(row), row % 7, row % 3));
        let text = format!("{header}\n{}", rows.collect::<String>());
        let (stamps, named) = times(&text, None);
        assert_eq!(named.as_deref(), Some(reported), "{text}");
        assert_eq!(stamps, (0..80).map(|row| row * 25_000_000).collect::<Vec<_>>(), "{text}");
        // without a header, columns are named by numbers
        let (_, rows) = text.split_once('\n').unwrap();
        let form = reported.split_once(':').unwrap().1;
        let map = format!("t=1:{form},gyro_x=2:rad/s,accel_z=3:m/s^2");
        assert_eq!(times(rows, Some(&map)).0, stamps, "{rows}");
    }
    // commas separate the columns, even with a stamp of two words
    let rows = (0..80).map(|row| format!("2024-05-01 {}, 0.{}\n", time(row), row % 7));
    let text = format!("time, gyro_x\n{}", rows.collect::<String>());
    assert_eq!(times(&text, None).1.as_deref(), Some("time:iso"));
}

#[test]
fn stamps_that_hundreds_of_rows_share_are_none() {
    // an epoch in a float of 32 bits
    let rows = |steps: usize| {
        (0..1000).map(move |row| format!("{},0.{}\n", 1_714_600_064 + 128 * (row * steps / 1000), row % 7))
    };
    for steps in [1, 2] {
        let text = format!("t,gyro_x\n{}", rows(steps).collect::<String>());
        assert_eq!(times(&text, None).1, None);
        let error = plan(&text, Some("t=t:s")).unwrap_err().to_string();
        assert!(error.ends_with("too coarse to show a sample rate: they change once at most in 1000 rows"), "{error}");
    }
    // whole seconds
    let text = format!("t,gyro_x\n{}", rows(5).collect::<String>());
    assert_eq!(times(&text, None).1.as_deref(), Some("t:s"));
}

/// Rows as `--samples` writes them, four for each read, with these times of the sensor.
fn written(device_ns: impl IntoIterator<Item = u64>) -> String {
    let row =
        |(row, device_ns)| format!("{},{device_ns},0.{}\n", 1_795_695_256_000_000_000 + row / 4 * 20_000_000, row % 7);
    let rows: String = (0_u64..).zip(device_ns).map(row).collect();
    format!("time [ns],device time [ns],gyro_x\n{rows}")
}

#[test]
fn the_device_time_of_a_written_table_is_preferred_though_it_starts_again() {
    // after a restart the sensor counts from zero
    let device_ns: Vec<u64> = (100..200).chain(0..60).map(|row| row * 5_000_000).collect();
    let whole = read_text(written(device_ns.clone()), None);
    assert_eq!(whole.report.times.as_deref(), Some("device time [ns]:ns"));
    assert_eq!(whole.device_ns, device_ns);
    assert_eq!((whole.stamps_ns[3], whole.stamps_ns[4]), (0, 20_000_000));
    // the same holds without arrival times
    let alone: String =
        written(device_ns.clone()).lines().map(|row| row.split_once(',').unwrap().1.to_owned() + "\n").collect();
    let whole = read_text(alone, None);
    assert_eq!((whole.report.times.as_deref(), whole.stamps_ns), (Some("device time [ns]:ns"), vec![]));
    assert_eq!(whole.device_ns, device_ns);
}

#[test]
fn a_column_that_does_not_count_up_is_no_device_time() {
    for device_ns in [[7; 80], std::array::from_fn(|row| 5_000_000 * (80 - row as u64))] {
        let whole = read_text(written(device_ns), None);
        assert_eq!((whole.report.times.as_deref(), whole.device_ns), (Some("time [ns]:ns"), vec![]));
    }
    // in a table of another program, a decrease is no restart
    let device_ns = (100..200).chain(0..60).map(|row| row * 5_000_000);
    let whole = read_text(written(device_ns).replace("device time [ns]", "device_time_ns"), None);
    assert_eq!((whole.report.times.as_deref(), whole.device_ns), (Some("time [ns]:ns"), vec![]));
}

#[test]
fn the_time_of_the_measurement_is_preferred_to_that_of_its_recording() {
    let rows: String = (0..80)
        .map(|row| {
            format!(
                "{},{},0.1\n",
                1_575_033_823_462_017_210_u64 + row * 90_000_000,
                5_000_000_000_u64 + row * 25_000_000
            )
        })
        .collect();
    for (header, times) in [
        ("%time,field.header.stamp,gyro_x", "field.header.stamp:ns"),
        ("systemTimeStamp,TimeStartup,gyro_x", "TimeStartup:ns"),
        ("%time,field.header.seq,gyro_x", "%time:ns"),
    ] {
        // also with a last row whose stamp is none
        for last in ["", "1575033840000000000,0,0.1\n"] {
            let whole = read_text(format!("{header}\n{rows}{last}"), None);
            assert_eq!(whole.report.times.as_deref(), Some(times), "{header}");
        }
    }
}

#[test]
fn dates_of_matlab_days_of_a_spreadsheet_and_stamps_with_their_unit_are_read() {
    for (header, stamp, reported) in [
        (
            "Time",
            &(|ns: u64| format!("05-Apr-2019 11:00:{:02}.{:03}", ns / 1_000_000_000, ns / 1_000_000 % 1000))
                as &dyn Fn(u64) -> String,
            "Time:dmy",
        ),
        ("Time", &|ns| format!("12:00:{:02}:{:03}", ns / 1_000_000_000, ns / 1_000_000 % 1000), "Time:clock"),
        ("t", &|ns| format!("{:.3} sec", ns as f64 / 1e9), "t:s"),
        ("SampleTimeFine", &|ns| (70_000 + ns / 100_000).to_string(), "SampleTimeFine:100us"),
        ("SampleTimeFine", &|ns| (70_000_000 + ns / 1000).to_string(), "SampleTimeFine:us"),
    ] {
        let (stamps, named) = times(&table(header, stamp), None);
        assert_eq!(named.as_deref(), Some(reported));
        assert_eq!(stamps, (0..80).map(|row| row * 25_000_000).collect::<Vec<_>>(), "{reported}");
    }
    for start in [45_000.5, 737_000.25] {
        let text = table("time", |ns| format!("{:.12}", start + ns as f64 / 86_400e9));
        let (stamps, named) = times(&text, None);
        assert_eq!(named.as_deref(), Some("time:d"));
        let error = stamps.iter().zip(0..).map(|(stamp, row)| (stamp - row * 25_000_000_i64).abs()).max();
        assert!(error < Some(20_000), "{error:?}");
    }
}
