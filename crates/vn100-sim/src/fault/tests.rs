//! Plans as text.

use super::*;

#[test]
fn a_plan_is_read() {
    let at = Duration::from_secs_f64;
    let plan: FaultPlan =
        "  drop@2min drop@0.1%   stall@0.5h+20ms\nflip@3s+1s:bit6 unplug@20s+3s:other".parse().unwrap();
    let expected = [
        Fault::Drop(Bytes::At(at(120.0))),
        Fault::Drop(Bytes::Chance(0.001)),
        Fault::Stall(at(1800.0), at(0.02)),
        Fault::Flip(Bytes::During(at(3.0), at(1.0)), Some(6)),
        Fault::Unplug { at: at(20.0), back_after: Some(at(3.0)), other_name: true },
    ];
    assert_eq!(plan.faults, expected);
    for text in ["", "stale", "splice@7s reboot@40s", "unplug@20s", "baud@5s:9600 badopen@20%"] {
        assert_eq!(text.parse::<FaultPlan>().unwrap().faults.len(), text.split_whitespace().count());
    }
}

#[test]
fn a_malformed_plan_names_the_reason() {
    for (text, reason) in [
        ("melt@3s", "`melt@3s` is no fault: use drop, flip,"),
        ("stale@3s", "`stale@3s` is no fault"),
        ("drop", "`drop` has no time"),
        ("drop@", "`drop@` has ``, which is no time"),
        ("drop@12", "`drop@12` has `12`, which is no time: write a number and one of ms, s, min, h"),
        ("drop@-1s", "`drop@-1s` has `-1s`, which is no time"),
        ("drop@1e400s", "is no time"),
        ("drop@99999999999999999999999s", "is no time"),
        ("drop@.s", "has `.s`, which is no time"),
        ("drop@101%", "`drop@101%` has `101%`, which is no chance"),
        ("drop@3s:bit6", "`drop@3s:bit6` has `bit6` after the colon"),
        ("flip@3s:bit8", "`bit8` after the colon"),
        ("stall@3s", "`stall@3s` has no length"),
        ("unplug@3s:other", "`other` after the colon"),
        ("baud@3s", "baud needs one of 9600, 19200"),
        ("baud@3s:0", "`0` after the colon"),
        ("splice@5%", "has `5%`, which is no time"),
        ("stale drop@x", "`drop@x` has `x`, which is no time"),
    ] {
        let error = text.parse::<FaultPlan>().unwrap_err().to_string();
        assert!(error.contains(reason), "{text}: {error}");
    }
}

#[test]
fn times_beyond_all_time_do_no_harm() {
    let plan: FaultPlan =
        "unplug@18000000000000000000s+18000000000000000000s stall@1s+18000000000000000000s".parse().unwrap();
    let mut injector = Injector::new(&plan, 1);
    assert!(injector.pass(Duration::from_secs(2), b'x').unwrap().0 > Duration::from_secs(1 << 60));
    assert_eq!(injector.take_event(Duration::from_secs(1 << 60)), None);
}
