//! Plans as text.

use super::*;

#[test]
fn a_plan_reads_back_as_it_was_written() {
    for text in [
        "",
        "stale",
        "drop@12.5s drop@1s+2s drop@0.1%",
        "flip@3s flip@3s+1s:bit6 flip@1%:bit0",
        "splice@7s stall@10s+2s reboot@40s",
        "unplug@20s unplug@20s+3s unplug@20s+3s:other",
        "baud@5s:9600 badopen@20%",
    ] {
        assert_eq!(text.parse::<FaultPlan>().unwrap().to_string(), text);
    }
    let minutes: FaultPlan = "  drop@2min   stall@0.5h+20ms\n".parse().unwrap();
    assert_eq!(minutes.to_string(), "drop@120s stall@1800s+0.02s");
}

#[test]
fn a_malformed_plan_names_the_reason() {
    for (text, reason) in [
        ("melt@3s", "`melt@3s` is no fault: use drop, flip,"),
        ("stale@3s", "`stale@3s` is no fault"),
        ("drop", "`drop` has no time"),
        ("drop@", "`` in `drop@` is no time"),
        ("drop@12", "`12` in `drop@12` is no time: write a number and one of ms, s, min, h"),
        ("drop@-1s", "`-1s` in `drop@-1s` is no time"),
        ("drop@1e400s", "is no time"),
        ("drop@99999999999999999999999s", "is no time"),
        ("drop@.s", "`.s` in `drop@.s` is no time"),
        ("drop@101%", "`101%` in `drop@101%` is no chance"),
        ("drop@3s:bit6", "`bit6` after the colon does not fit `drop@3s:bit6`"),
        ("flip@3s:bit8", "`bit8` after the colon"),
        ("stall@3s", "`stall@3s` has no length"),
        ("unplug@3s:other", "`other` after the colon"),
        ("baud@3s", "baud needs one of 9600, 19200"),
        ("baud@3s:0", "`0` after the colon"),
        ("splice@5%", "`5%` in `splice@5%` is no time"),
        ("stale drop@x", "`x` in `drop@x` is no time"),
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
