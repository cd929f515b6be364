//! Files of other programs: separators, decimals, lines above the header, units in the header.

use super::*;

/// Counts and stamps of two rows, of a rate and an acceleration.
fn expected() -> (Vec<f64>, Vec<i64>) {
    (vec![9.81, 0.5, 9.8, -0.25], vec![0, 25_000_000])
}

fn values(text: &str, map: Option<&str>) -> (Vec<f64>, Vec<i64>) {
    let plan = planned(text, map);
    let channels = layout(&plan).channels;
    let whole = read(plan, text.as_bytes());
    assert_eq!(whole.rejected_rows(), 0, "{text}");
    let width = channels.len();
    let values = whole.counts.iter().enumerate().map(|(place, count)| channels[place % width].value(*count));
    (values.collect(), whole.stamps_ns)
}

#[test]
fn every_form_of_a_table_is_the_same_numbers() {
    // the second and the third as numpy.savetxt writes them, the fourth as a German spreadsheet does
    for text in [
        "t,gyro_x,accel_x\n0.000,0.5,9.81\n0.025,-0.25,9.8\n",
        "# t gyro_x accel_x\n0.000000000000000000e+00 5.000000000000000000e-01 9.810000000000000497e+00\n\
         2.500000000000000139e-02 -2.500000000000000000e-01 9.800000000000000711e+00\n",
        "# t,gyro_x,accel_x\n0.000 0.5 9.81\n0.025 -0.25 9.8\n",
        "t;gyro_x;accel_x\n0,000;0,5;9,81\n0,025;-0,25;9,8\n",
        "t\tgyro_x\taccel_x\n0,000\t0,5\t9,81\n0,025\t-0,25\t9,8\n",
        "t gyro_x accel_x\n0,000 0,5 9,81\n0,025 -0,25 9,8\n",
        "  t   gyro_x  accel_x\r\n  0.000   0.5   9.81\r\n  0.025 -0.25 \t 9.8  \r\n",
        "Device: IMU 7\nStart, 2024\n\nt,gyro_x,accel_x\n0.000,0.5,9.81\n0.025,-0.25,9.8\n",
        "// made by, hand\nRate;40 Hz\nt;gyro_x;accel_x\n0,000;0,5;9,81\n0,025;-0,25;9,8\n",
        "t,Gyro X [rad/s],Acc_X (m/s^2)\n0.000,0.5,9.81\n0.025,-0.25,9.8\n",
        "t,\"gyro_x\",accel_x_m_s2\n0.000,\"0.5\",9.81\n0.025,\"-0.25\",9.8\n",
        "t,field.angular_velocity.x,field.linear_acceleration.x\r0.000,0.5,9.81\r0.025,-0.25,9.8\r",
    ] {
        assert_eq!(values(text, None), expected(), "{text}");
    }
    for text in [
        "0.000 0.5 9.81\n0.025 -0.25 9.8\n",
        "0,000;0,5;9,81\n0,025;-0,25;9,8\n",
        "three\ncolumns\n0.000,0.5,9.81\n0.025,-0.25,9.8\n",
    ] {
        assert_eq!(values(text, Some("t=1:s,gyro_x=2:rad/s,accel_x=3:m/s^2")), expected(), "{text}");
    }
}

#[test]
fn units_in_the_header_are_converted() {
    let (values, _) = values("t,gyro_x_deg_s,AccX [g],Temp (K)\n0.0,180,1,293.15\n0.025,90,0,293.15\n", None);
    let half_turn = std::f64::consts::PI;
    assert_eq!(values, [9.80665, half_turn, 20.0, 0.0, half_turn / 2.0, 20.0]);
    // a column with an unknown unit is no channel
    assert!(plan("t,gyro_x [furlong]\n0.0,1\n", None).is_err());
}

#[test]
fn a_table_that_is_none_of_a_sensor_is_none_below_a_preamble_either() {
    assert!(plan("Dear all,\n\nplease find, attached,\nthe gyro_x, as agreed\n", None).unwrap().is_none());
    assert!(plan("a,b\n1,2\n3,4\n", None).is_err());
}

proptest::proptest! {
    /// Spaces and decimal commas lose no digit in columns of any length.
    #[test]
    fn spaces_and_commas_are_as_points_and_commas(
        rows in proptest::collection::vec((-999_999_i32..999_999, -999_999_i32..999_999), 1..60),
        gap in "[ \t]{0,3} ",
    ) {
        let print = |number: i32| format!("{:.6}", f64::from(number) / 1e6);
        let form = |separator: &str, comma: bool| {
            let rows = rows.iter().map(|&(a, b)| {
                let row = format!("{}\u{1}{}", print(a), print(b));
                (if comma { row.replace('.', ",") } else { row }).replace('\u{1}', separator) + "\n"
            });
            format!("gyro_x{separator}gyro_y\n{}", rows.collect::<String>())
        };
        let expected = read_text(form(",", false), None).counts;
        for text in [form(&gap, false), form(";", true), form("\t", true), form(&gap, true)] {
            proptest::prop_assert_eq!(&read_text(&text, None).counts, &expected, "{}", text);
        }
    }
}

#[test]
fn a_row_of_units_below_the_names_is_used() {
    let rows = "0.00;90.0;1.0\n0.01;-90.0;1.0\n";
    for units in ["s;deg/s;g", "[s];[°/s];[g]", "(s);(deg/s);(g)", "s;dps;g;"] {
        let plan = planned(format!("time;gyro_x;accel_z\n{units}\n{rows}"), None);
        let scales: Vec<f64> = layout(&plan).channels.iter().map(|channel| channel.in_unit(1.0)).collect();
        // both rows are a tenth
        let expected = [0.1 * 9.80665, 0.1 * std::f64::consts::PI / 180.0];
        assert!(
            scales.iter().zip(expected).all(|(scale, expected)| (scale / expected - 1.0).abs() < 1e-12),
            "{units}: {scales:?}"
        );
        let whole = read(plan, format!("time;gyro_x;accel_z\n{units}\n{rows}").as_bytes());
        assert_eq!((&*whole.counts, whole.rejected.len()), (&[10, 900, 10, -900][..], 0), "{units}");
        assert_eq!(whole.stamps_ns, [0, 10_000_000], "{units}");
    }
    // the same by a map of the bare names
    let text = format!("time;wx;az\ns;deg/s;g\n{rows}");
    let whole = read_text(&text, Some("gyro_x=wx:deg/s,t=time:s"));
    assert_eq!((&*whole.counts, whole.rejected.len()), (&[900, -900][..], 0));
    // the same by letters, which the units make certain
    let whole = read_text(&text, None);
    assert_eq!((&*whole.counts, whole.rejected.len()), (&[10, 900, 10, -900][..], 0));
    // words are no units
    let text = format!("time;gyro_x;accel_z\nstart;of;data\n{rows}");
    assert_eq!(read_text(text, None).rejected, [0]);
}

#[test]
fn thousands_may_be_separated_in_values_and_stamps() {
    let english = "time_ms,gyro_x,pressure\n\"1,000\",0.5,\"101,325.25\"\n\"1,010\",0.25,\"99,325.50\"\n";
    let german = "time_ms;gyro_x;pressure\n1000;0,5;101.325,25\n1010;0,25;99.325,50\n";
    for text in [english, german] {
        let map = "gyro_x=gyro_x:rad/s,pressure=pressure:Pa,t=time_ms:ms";
        let whole = read_text(text, Some(map));
        assert_eq!(whole.counts, [50, 10_132_525, 25, 9_932_550], "{text}");
        assert_eq!(whole.stamps_ns, [0, 10_000_000], "{text}");
    }
}

#[test]
fn names_in_latin_1_are_read() {
    let text = b"Zeit [s];gyro_x [\xb0/s]\n0,00;1,5\n0,01;-1,5\n";
    let plan = planned(text, None);
    assert_eq!(plan.report.times.as_deref(), Some("Zeit [s]:s"));
    let degree = layout(&plan).channels[0].in_unit(10.0);
    assert!((degree * 180.0 / std::f64::consts::PI - 1.0).abs() < 1e-12, "{degree}");
}

#[test]
fn rows_of_several_sensors_are_refused_with_the_remedy() {
    let rows = (0..100).map(|row| format!("{}.{:02},{},0.1\n", row / 100, row / 2 % 100, ["left", "right"][row % 2]));
    let text = format!("t,sensor,gyro_x\n{}", rows.collect::<String>());
    for map in [None, Some("gyro_x=gyro_x:rad/s,t=t:s")] {
        let error = plan(&text, map).unwrap_err().to_string();
        assert_eq!(
            error,
            "the rows are of several sensors, by column \"sensor\": left, right; keep those of one, as \
             awk -F, 'NR==1 || $2==\"left\"' does"
        );
    }
}

#[test]
fn a_table_without_names_is_refused_with_the_means_of_its_columns() {
    let rows =
        (0..60).map(|row| format!("{}.{:02} 0.0{} 0.01 0.02 0.1 0.2 -9.8{}\n", row / 100, row % 100, row % 7, row % 3));
    let text: String = rows.collect();
    let error = plan(&text, None).unwrap_err();
    assert_eq!(error.hint(), Some(&OpenHint::Columns(None)));
    assert!(error.to_string().contains("3 (mean 0.0100), 4 (mean 0.0200), 5 (mean 0.1000)"), "{error}");
    let map = "gyro_x=2:rad/s,gyro_y=3:rad/s,gyro_z=4:rad/s,accel_x=5:m/s^2,accel_y=6:m/s^2,accel_z=7:m/s^2,t=1:s";
    let whole = read_text(&text, Some(map));
    assert_eq!((whole.report.rows, whole.stamps_ns[59]), (60, 590_000_000));
    // too few rows are treated as any text
    assert!(plan(text.lines().take(10).collect::<Vec<_>>().join("\n"), None).unwrap().is_none());
}

#[test]
fn texts_of_spreadsheets_for_no_number_affect_only_their_channel() {
    for none in ["#N/A", "#NUM!", "#VALUE!", "<NA>", "-nan(ind)", "1.#QNAN", "-1.#IND", "1.#INF"] {
        let whole = read_text(format!("t,gyro_x,accel_z\n0.00,{none},9.8\n0.01,0.1,9.8\n"), None);
        assert_eq!((whole.report.rows, whole.report.absent[0].not_a_number), (2, 1), "{none}");
    }
}

#[test]
fn bars_part_columns() {
    let whole = read_text("t|gyro_x|accel_z\n0.00|0.5|9.8\n0.01|-0.5|9.9\n", None);
    assert_eq!((&*whole.counts, whole.rejected.len()), (&[9800, 500_000, 9900, -500_000][..], 0));
    let whole = read_text("t | gyro_x\n0,00 | 0,5\n0,01 | 0,25\n", None);
    assert_eq!(whole.counts, [500_000, 250_000]);
}

#[test]
fn a_column_that_is_missed_below_a_preamble_is_named() {
    let text = "Device: a logger\nSerial: 7, Firmware: 2\nn,gyro_x,accel_z\n1,0.5,9.8\n2,0.25,9.8\n";
    for map in ["t=when:s", "gyro_x=wx:deg/s"] {
        let error = plan(text, Some(map)).unwrap_err().to_string();
        assert!(error.ends_with("the file has n, gyro_x, accel_z"), "{error}");
    }
}

#[test]
fn lines_of_two_cells_above_a_table_are_no_header() {
    let rows: String = (0..60).map(|row| format!("{row},{},0.5,9.8\n", row * 10_000)).collect();
    let text = format!("DeviceTag:,A1\nFirmwareVersion:,2.0.0\nStatus:,1\n\nn,t_us,gyro_x,accel_z\n{rows}");
    assert_eq!(read_text(&text, None).report.rows, 60);
}

#[test]
fn cells_that_begin_with_their_names_are_columns() {
    let row = |row: u32| format!("ax:0.0{},ay: -0.1,az:9.8,gx:0.01,gy:0.02,gz:-0.0{}\n", row % 7, row % 3);
    let text: String = (0..60).map(row).collect();
    let Some(OpenHint::Columns(Some(map))) = plan(&text, None).unwrap_err().hint().cloned() else { panic!("no map") };
    let whole = read_text(&text, Some(&map));
    assert_eq!((whole.report.rows, whole.rejected_rows(), &whole.counts[..6]), (60, 0, &[0, -1, 98, 1, 2, 0][..]));
}

#[test]
fn a_row_of_ros2_topic_echo_is_known_by_its_form() {
    let zeros = |count: usize| vec!["0.0"; count].join(",");
    let row = |row: u32| {
        format!(
            "1700000000,{},imu,0.0,0.0,0.0,1.0,{},0.1,0.2,0.3,{},1.1,1.2,9.{row:02},{}\n",
            row * 10_000_000,
            zeros(9),
            zeros(9),
            zeros(9)
        )
    };
    let whole = read_text((0..60).map(row).collect::<String>(), None);
    assert_eq!((whole.report.rows, whole.stamps_ns[59]), (60, 590_000_000));
    assert_eq!(whole.counts[..6], [1100, 1200, 9000, 100_000, 200_000, 300_000]);
}

#[test]
fn a_second_header_orders_its_rows_or_ends_the_table() {
    let first = "t,gyro_x,accel_x\n0.00,0.5,9.8\n0.01,0.5,9.8\n";
    let whole = read_text(format!("{first}accel_x,t,gyro_x\n9.8,0.02,0.5\nt,gyro_x,accel_x\n0.03,0.5,9.8\n"), None);
    assert_eq!(whole.counts, [9800, 500_000].repeat(4));
    assert_eq!((whole.report.skipped_lines, whole.rejected.len()), (3, 0));
    assert_eq!(whole.stamps_ns, [0, 10_000_000, 20_000_000, 30_000_000]);
    let commented =
        read_text(format!("#{first}# accel_x,t,gyro_x\n9.8,0.02,0.5\n# gyro_x,accel_x\n9.8,0.03,0.5\n"), None);
    assert_eq!((&commented.counts, &commented.stamps_ns), (&whole.counts, &whole.stamps_ns));
    let finer = read_text(format!("{first}t,gyro_x,accel_x\n0.02,0.512345678,9.8\n"), None);
    assert_eq!(finer.counts[5], 512_345_678, "a header in the same order ends no rows");
    let text = format!("{first}t,gyro_y,accel_z\n0.03,0.5,9.8\n");
    let mut reader = CsvReader::new(planned(&text, None), Cursor::new(text), ReadOptions::default());
    assert!(reader.next_events().unwrap().is_some());
    let error = reader.next_events().unwrap_err().to_string();
    assert!(error.starts_with("line 4 begins a table with other columns"), "{error}");
}

#[test]
fn a_header_that_runs_into_the_first_row_names_its_columns() {
    let text =
        "time[ms],accX[mg],gyroX[mdps],temp[C],hum[0,10,1000,7000,25,3,\n10,1000,7000,25,3,\n20,1001,7001,25,3,\n";
    let whole = read_text(text, None);
    assert_eq!((&*whole.counts, &*whole.stamps_ns), (&[1000, 7000, 250, 1001, 7001, 250][..], &[0, 10_000_000][..]));
}
