//! The output of `-v`, and that it changes nothing else.

use crate::support::{document, replay, replay_log, run, vn100, with_stdin};

/// The lines of a log that contain `what`, after time and source.
fn entries<'a>(log: &'a str, what: &str) -> Vec<&'a str> {
    log.lines().filter(|line| line.contains(what)).collect()
}

#[test]
fn every_refused_line_is_in_the_log_and_the_result_is_the_same() {
    let capture = replay_log("corrupted.vnymr");
    let (without, _) = replay(&capture, &[]);
    let output = vn100().args(["replay", "--json", "-v"]).arg(&capture).output().unwrap();
    assert_eq!(document(&output), without);
    let log = String::from_utf8(output.stderr).unwrap();
    for (kind, count) in without["link"]["bad_frames"].as_object().unwrap() {
        let reason = format!(", {}:", kind.replace("too_long", "too long"));
        assert_eq!(entries(&log, &reason).len() as u64, count.as_u64().unwrap(), "{kind}");
    }
    assert!(entries(&log, "corrupted.vnymr: rejected at byte ").len() > 10, "{log}");
    assert!(log.trim_end().ends_with("corrupted.vnymr: ended"), "{log}");
}

#[test]
fn commands_and_replies_of_a_live_sensor_are_logged() {
    let measured = run(vn100().args(["attach", "sim", "--duration", "2s", "--json", "-v"]));
    assert_eq!(measured.status.code(), Some(0));
    let told = String::from_utf8_lossy(&measured.stderr);
    for what in ["connected: ", "sent $VNRRG,07*74", "reply $VNRRG,07,40*"] {
        // on a busy machine a question is asked again
        assert!(!entries(&told, &format!(" sim: {what}")).is_empty(), "{what}: {told}");
    }
    let replies = document(&measured)["link"]["replies"].as_u64().unwrap();
    // some come after the last sample that counts
    assert!(replies > 3 && entries(&told, "sim: reply $").len() as u64 >= replies, "{replies}: {told}");
    let asked = run(vn100().args(["info", "sim", "-v"]));
    let told = String::from_utf8(asked.stderr).unwrap();
    assert!(!entries(&told, "sim: sent $VNRRG,03").is_empty() && told.ends_with("sim: ended\n"), "{told}");
    let quiet = run(vn100().args(["info", "sim"]));
    assert!(quiet.stderr.is_empty() && quiet.stdout.starts_with(b"sim: "), "{quiet:?}");
}

#[test]
fn a_log_has_no_control_characters() {
    let hostile = "$VNRRG,01,\x1b[2J\u{9b}\u{202e}*00\r\n$VNYMR,\x07*00\r\nx".repeat(20);
    let output = with_stdin(vn100().args(["replay", "-", "-v"]), hostile.as_bytes());
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(entries(&told, r"$VNRRG,01,").len() == 20, "{told}");
    assert!(told.bytes().all(|byte| byte == b'\n' || (b' '..=b'~').contains(&byte)), "{told:?}");
}
