//! Files of any sensor, through a column map.

use super::{channels::by_name, *};

#[test]
fn numbers_keep_the_files_unit_and_decimals() {
    let text = "time,ax,wy,wx\n1000,0.99987,-0.0125,12.5\n1025,1.00012,0.0375,-12.5\n";
    let plan = plan(text, Some("gyro_x=wx:deg/s,gyro_y=wy:deg/h,accel_x=2:mg,t=time:us")).unwrap().unwrap();
    let layout = layout(&plan);
    let scale: Vec<_> = layout.channels.iter().map(|channel| channel.scale).collect();
    assert_eq!((&*layout.message, layout.compensated), ("CSV", None));
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
        assert_eq!((whole.report.skipped_lines, whole.report.rows), (skipped, 2));
    }
}

#[test]
fn certain_stamps_are_found_with_mapped_columns() {
    let map = Some("gyro_x=w:deg/s");
    let sure = read_text("t,w\n0.000,1\n0.025,2\n0.050,3\n", map);
    assert_eq!(sure.stamps_ns, [0, 25_000_000, 50_000_000]);
    // no time at all, an uncertain unit, a word, and a temperature that the user mapped
    for (text, map) in [
        ("t,w\n21.5,1\n21.5,2\n21.5,3\n", map),
        ("t,w\n1,1\n2,2\n3,3\n", map),
        ("t,w\ncold,1\ncold,2\nwarm,3\n", map),
        ("t,w\n0.000,1\n0.025,2\n0.050,3\n", Some("gyro_x=w:deg/s,temperature=t:degC")),
    ] {
        let read = read_text(text, map);
        assert!(read.stamps_ns.is_empty() && read.report.rows == 3, "{text}");
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
fn the_names_of_mapped_columns_tell_their_compensation() {
    for (name, compensated) in [("w", None), ("UncompGyroZ", Some(false)), ("CompGyroZ", Some(true))] {
        let plan = plan(format!("# of VNYMR\nh,{name}\n1,2\n"), Some(&format!("yaw=h:rad,gyro_z={name}:rad/s")));
        assert_eq!(layout(&plan.unwrap().unwrap()).compensated, compensated, "{name}");
    }
}

#[test]
fn floats_are_rounded_to_a_power_of_two_and_larger_ones_later_have_room() {
    let numbers = (0..HEAD_ROWS).map(|row| (row as f64).sin() * 100.0);
    let numbers: Vec<_> = numbers.chain([0.000_123_456_789_012_34, 6300.0, 1e12, 1.5]).collect();
    let text = format!(
        "w
{}",
        numbers
            .iter()
            .map(|number| format!(
                "{number}
"
            ))
            .collect::<String>()
    );
    let plan = planned(&text, Some("gyro_x=w:deg/s"));
    let channel = layout(&plan).channels[0].clone();
    assert_eq!((rounded(&plan), channel.decimals), (vec!["gyro_x".to_owned()], 0));
    let degree = std::f64::consts::PI / 180.0;
    assert!(channel.scale < 1e-5 * degree && (channel.scale / degree).log2().fract() == 0.0, "{}", channel.scale);
    let whole = read(plan, text.as_bytes());
    assert_eq!(whole.report.rounded, ["gyro_x"]);
    let is_held =
        |(count, number): (&i32, &f64)| (channel.value(*count) - number * degree).abs() <= 0.5 * channel.scale;
    let held = numbers.iter().take(1002).chain(&numbers[1003..]);
    assert!(whole.counts.iter().zip(held).all(is_held));
    // a number that does not fit is no sample, and is counted
    assert_eq!((whole.counts.len(), whole.rejected), (1003, vec![1002]));
}

#[test]
fn digits_beyond_those_of_the_head_are_rounded_and_reported() {
    let text = format!("w\n{}0.25\n0.26\n", "1.5\n".repeat(HEAD_ROWS));
    let plan = plan(&text, Some("gyro_x=w:deg/s")).unwrap().unwrap();
    assert!(rounded(&plan).is_empty());
    let whole = read(plan, text.as_bytes());
    assert_eq!(whole.counts[HEAD_ROWS - 1..], [15, 2, 3]);
    assert_eq!((whole.report.rounded, whole.report.rejected), (vec!["gyro_x".to_owned()], vec![]));
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

#[test]
fn a_stamp_alone_leaves_the_other_columns_to_their_names() {
    let text = format!("n,us,raw\n1,1000,{SENTENCE}\n2,2000,{SENTENCE}\n");
    let whole = read_text(text, Some("t=us:us"));
    assert_eq!((whole.report.rows, &*whole.stamps_ns), (2, &[0, 1_000_000][..]));
    for (text, map, message) in [
        ("t,gyro_x\n1,2\n", "t=n:ms", "no column \"n\" for t: the file has t, gyro_x"),
        ("t,gyro_x\n1,2\n", "t=2:ms", "column \"2\" is mapped to both gyro_x and t: give each its own"),
    ] {
        assert_eq!(plan(text, Some(map)).unwrap_err().to_string(), message);
    }
}

#[test]
fn every_unit_leads_to_the_channels_own() {
    use std::f64::consts::PI;
    // calculated by hand: a half turn in a second, or in an hour; free fall; a field of 50 microtesla; 2 rad; a room
    // at sea level
    let table = [
        ("gyro_y", "rad/s", "3.5", 3.5),
        ("gyro_y", "deg/s", "180", PI),
        ("gyro_y", "deg/h", "648000", PI),
        ("gyro_y", "mdeg/s", "180000", PI),
        ("gyro_y", "mrad/s", "3500", 3.5),
        ("gyro_y", "rpm", "30", PI),
        ("accel_z", "m/s^2", "-9.81", -9.81),
        ("accel_z", "g", "1", 9.80665),
        ("accel_z", "mg", "1000", 9.80665),
        ("accel_z", "ug", "1000000", 9.80665),
        ("accel_z", "cm/s^2", "981", 9.81),
        ("accel_z", "ft/s^2", "32", 9.7536),
        ("mag_x", "gauss", "0.5", 0.5),
        ("mag_x", "mgauss", "500", 0.5),
        ("mag_x", "T", "0.00005", 0.5),
        ("mag_x", "uT", "50", 0.5),
        ("mag_x", "mT", "0.05", 0.5),
        ("mag_x", "nT", "50000", 0.5),
        ("yaw", "deg", "-90", -90.0),
        ("yaw", "rad", "2", 114.591_559_026_164_65),
        ("temperature", "degC", "20.5", 20.5),
        ("temperature", "K", "293.65", 20.5),
        ("pressure", "kPa", "101.325", 101.325),
        ("pressure", "hPa", "1013.25", 101.325),
        ("pressure", "Pa", "101325", 101.325),
    ];
    for (name, unit, field, expected) in table {
        let text = format!("c\n{field}\n");
        let plan = plan(&text, Some(&format!("{name}=c:{unit}"))).unwrap().unwrap();
        let channel = layout(&plan).channels[0].clone();
        let value = channel.value(read(plan, text.as_bytes()).counts[0]);
        assert!((value - expected).abs() <= 1e-14 * expected.abs(), "{field} {unit} is {value} {}", channel.unit);
    }
    let tested: Vec<_> = table.iter().map(|&(_, unit, _, _)| unit).collect();
    let quantities = ["gyro_y", "accel_z", "mag_x", "yaw", "temperature", "pressure"].map(by_name);
    let all = quantities.map(|index| known(index.unwrap()).quantity).into_iter().flat_map(units);
    assert_eq!(tested, all.map(|unit| &*unit.name).collect::<Vec<_>>());
}

#[test]
fn every_unit_of_a_stamp_leads_to_nanoseconds() {
    let table = [
        ("s", "0.025"),
        ("ms", "25"),
        ("us", "25000"),
        ("ns", "25000000"),
        ("100us", "250"),
        ("d", "0.00000028935185185"),
        ("min", "0.000416666666667"),
        ("h", "0.00000694444444444"),
    ];
    for (unit, stamp) in table {
        let whole = read_text(format!("t,w\n0,1\n{stamp},1\n"), Some(&format!("t=t:{unit},gyro_x=w:deg/s")));
        assert_eq!(whole.stamps_ns, [0, 25_000_000], "{unit}");
    }
}
