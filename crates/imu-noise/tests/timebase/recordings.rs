//! The results for the stamps of recordings by others.

use imu_noise::timebase::{NominalRate, Refusal};

use crate::link::place;

/// The results by file, read from the folder in the variable.
#[test]
fn recordings_of_real_sensors() {
    let folder = std::env::var_os("VN100_CAPTURES").filter(|folder| std::path::Path::new(folder).is_dir());
    let Some(folder) = folder else {
        eprintln!("skipped: no captures, VN100_CAPTURES names no folder of them");
        return;
    };
    let expected = [
        ("vn100-circles-qian-95s-GAPS", 40.0, 119..=123),
        ("vn100-walk-circle-sazgar-CORRUPT", 40.0, 1238..=1242),
        ("vn100-circles-rohx17-NOCHECKSUM", 40.0, 24..=24),
        ("vn100-donut-huang-155s", 40.0, 0..=0),
        ("vn100-shake-iwale-153s", 40.0, 0..=0),
        ("vn100-static-kiran-330s", 40.0, 0..=0),
        ("vn100-static1hz-ramirez-run2-623s", 1.0, 0..=0),
        ("emulator-loop-pattala-449s", 1.0, 0..=0),
    ];
    let stamps_s = |name: &str| -> Vec<f64> {
        let path = std::path::Path::new(&folder).join(name).with_extension("csv");
        let rows = std::fs::read_to_string(path).unwrap();
        let stamps_s = rows.lines().skip(1).map(|row| row.split(',').next().unwrap().parse());
        stamps_s.map(Result::unwrap).collect()
    };
    for (name, rate_hz, missing) in expected {
        let (_, summary) = place(stamps_s(name));
        assert_eq!(summary.nominal, Some(NominalRate::Snapped(rate_hz)), "{name}");
        assert!(missing.contains(&summary.missing), "{name}: {summary:?}");
    }
    let (_, summary) = place(stamps_s("vn100-hand-thumatti-BADSTAMPS"));
    assert!(matches!(summary.refusal, Some(Refusal::TooFast { .. })), "{summary:?}");
}
