//! Files as other programs write them: separators, decimals, lines above the header, units in it.

use super::*;

/// Counts and stamps of two rows, of a rate and an acceleration.
fn expected() -> (Vec<f64>, Vec<i64>) {
    (vec![9.81, 0.5, 9.8, -0.25], vec![0, 25_000_000])
}

fn values(text: &str, map: Option<&str>) -> (Vec<f64>, Vec<i64>) {
    let plan = whole_plan(text, map);
    let channels = layout(&plan).channels;
    let whole = read(plan, text.as_bytes());
    assert_eq!(whole.rejected_rows(), 0, "{text}");
    let width = channels.len();
    let values = whole.counts.iter().enumerate().map(|(place, count)| channels[place % width].value(*count));
    (values.collect(), whole.stamps_ns)
}

#[test]
fn every_form_of_a_table_is_the_same_numbers() {
    // the second and the third as numpy.savetxt writes them, the fourth as a spreadsheet of a German does
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
    // a unit that is not known makes no channel of the column
    assert!(plan("t,gyro_x [furlong]\n0.0,1\n", None).is_err());
}

#[test]
fn a_table_that_is_none_of_a_sensor_is_none_below_a_preamble_either() {
    assert!(plan("Dear all,\n\nplease find, attached,\nthe gyro_x, as agreed\n", None).unwrap().is_none());
    assert!(plan("a,b\n1,2\n3,4\n", None).is_err());
}

proptest::proptest! {
    /// Spaces and decimal commas lose no digit, however long the columns are.
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
