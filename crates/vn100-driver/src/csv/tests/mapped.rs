//! Files of any sensor, through a column map.

use super::*;

#[test]
fn numbers_keep_the_files_unit_and_decimals() {
    let text = "time,ax,wy,wx\n1000,0.99987,-0.0125,12.5\n1025,1.00012,0.0375,-12.5\n";
    let plan = plan(text, Some("gyro_x=wx:deg/s,gyro_y=wy:deg/h,accel_x=2:mg,t=time:us")).unwrap().unwrap();
    let layout = layout(&plan).clone();
    let scale: Vec<_> = layout.channels.iter().map(|channel| channel.scale).collect();
    assert_eq!((&*layout.message, layout.compensated), ("CSV", false));
    let channels: Vec<_> =
        layout.channels.iter().map(|channel| (&*channel.name, &*channel.unit, channel.decimals)).collect();
    assert_eq!(channels, [("accel_x", "m/s^2", 5), ("gyro_x", "rad/s", 1), ("gyro_y", "rad/s", 4)]);
    let degree = std::f64::consts::PI / 180.0;
    for (scale, expected) in scale.iter().zip([0.00980665, degree, degree / 3600.0]) {
        assert!((scale / expected - 1.0).abs() < 1e-15, "{scale} {expected}");
    }
    let whole = read(plan, text.as_bytes());
    assert_eq!(whole.counts, [99_987, 125, -125, 100_012, -125, 375]);
    assert_eq!(whole.stamps_ns, [0, 25_000]);
}

#[test]
fn a_file_without_names_is_read_from_its_first_line() {
    let map = Some("gyro_x=2:deg/s,t=1:s");
    let rows = "1,0.5\n2,0.25\n";
    for (above, skipped) in [("", 0), ("\u{feff}", 0), ("# t, w\n", 1), ("# w, x, y of may\n", 1), ("t,w\n", 1)] {
        let whole = read_text(format!("{above}{rows}"), map);
        assert_eq!(whole.counts, [50, 25], "{above:?}");
        assert_eq!((whole.tally.skipped_lines, whole.tally.rows), (skipped, 2));
    }
}

#[test]
fn kelvin_become_degrees_exactly() {
    let text = "T,w\n300.5,1\n273.15,2\n0,3\n";
    let plan = plan(text, Some("gyro_x=w:rad/s,temperature=T:K")).unwrap().unwrap();
    assert_eq!(layout(&plan).channels[1].decimals, 2);
    assert_eq!(read(plan, text.as_bytes()).counts, [1, 2735, 2, 0, 3, -27_315]);
}

#[test]
fn an_attitude_makes_a_recording_compensated() {
    let plan = plan("h,w\n1,2\n", Some("yaw=h:rad,gyro_z=w:rad/s")).unwrap().unwrap();
    assert!(layout(&plan).compensated);
}

#[test]
fn what_does_not_fit_takes_fewer_decimals_and_says_so() {
    let mut text = "w\n".to_owned();
    for row in 0..survey::ROWS {
        text.push_str(&format!("{}\n", (row as f64).sin() * 100.0));
    }
    text.push_str("0.00012345678901234\n21474\n300000\n");
    let plan = plan(&text, Some("gyro_x=w:deg/s")).unwrap().unwrap();
    let [rounded] = &plan.rounded[..] else { panic!("{:?}", plan.rounded) };
    // 64 * 100 with five decimals fits 32 bits
    assert_eq!((rounded.channel, rounded.kept_decimals), ("gyro_x", 5));
    assert!(rounded.printed_decimals > 12);
    let whole = read(plan, text.as_bytes());
    assert_eq!(whole.counts[1], 8_414_710);
    assert_eq!(whole.counts[survey::ROWS..], [12, 2_147_400_000]);
    assert_eq!(whole.odd, [(survey::ROWS + 2, OddRow::Range)]);
}

#[test]
fn a_column_that_is_not_there_is_missed_before_anything_is_read() {
    for (text, map, message) in [
        ("a,b\n1,2\n", "gyro_x=c:deg/s", "no column \"c\" for gyro_x: the file has a, b"),
        ("a,b\n1,2\n", "gyro_x=3:deg/s", "no column \"3\" for gyro_x: the file has a, b"),
        ("a,b\n1,2\n", "gyro_x=a:deg/s,t=1:s", "column \"1\" is mapped to both gyro_x and t: give each its own"),
    ] {
        assert_eq!(plan(text, Some(map)).unwrap_err().to_string(), message);
    }
    assert!(plan("", Some("gyro_x=c:deg/s")).unwrap().is_none());
}
