//! The live view in a real terminal: started, controlled, ended in every way, and the state that it
//! leaves.

use std::{
    fs::{self, File},
    path::Path,
};

use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    process::Signal,
    termios::{Action, tcflow},
};

use crate::session::{ALTERNATE_SCREEN, Modes, NORMAL_SCREEN, Session, set_size, wait_until};
use crate::support::{replay, replay_log};

/// The samples of a document, as counted in the summary.
fn counted(document: &serde_json::Value) -> String {
    let count = document["timing"]["samples"].as_u64().unwrap();
    match (count / 1000, count % 1000) {
        (0, rest) => format!("{rest} samples"),
        (thousands, rest) => format!("{thousands} {rest:03} samples"),
    }
}

#[test]
fn keys_lead_through_the_view_and_the_result_follows() {
    let mut session = Session::start("attach sim");
    session.wait_for(ALTERNATE_SCREEN);
    session.wait_for_samples("");
    assert_ne!(Modes::of(&session.line), session.before, "keys are read one by one");
    session.press("?");
    session.wait_to_see("this help: arrows turn pages, esc closes it");
    session.press("x");
    session.wait_to_see("Allan deviation");
    session.press("\t");
    session.wait_to_see("Noise of the gyro");
    session.press("r");
    session.wait_to_see("Discard everything");
    session.press("y");
    session.wait_to_see("started over after");
    let samples = session.wait_for_samples("");
    session.wait_for_samples(&samples);
    session.press("q");
    session.assert_left_well();
}

#[test]
fn every_way_to_end_restores_the_terminal() {
    let mut sessions: Vec<(Session, &str)> =
        ["q", "\x03", "TERM", "INT"].map(|way| (Session::start("attach sim"), way)).into();
    for (session, way) in &mut sessions {
        session.wait_for_samples("");
        match *way {
            "TERM" => session.signal(Signal::TERM),
            "INT" => session.signal(Signal::INT),
            keys => session.press(keys),
        }
        session.assert_left_well();
    }
    // it ends by itself
    Session::start("attach sim --duration 1s").assert_left_well();
}

#[test]
fn a_signal_that_aborts_leaves_the_terminal_as_it_was() {
    for (signal, code) in [(Signal::QUIT, 131), (Signal::ABORT, 134)] {
        let mut session = Session::start("attach sim");
        session.wait_for_samples("");
        session.signal(signal);
        assert_eq!(session.wait().code(), Some(code));
        assert_eq!(Modes::of(&session.line), session.before, "{signal:?}");
        session.wait_for(NORMAL_SCREEN);
        let output = session.output();
        assert_eq!(output.matches(ALTERNATE_SCREEN).count(), output.matches(NORMAL_SCREEN).count());
    }
}

#[test]
fn another_size_is_drawn_at_once() {
    let mut session = Session::start("attach sim");
    session.wait_for_samples("");
    set_size(session.keyboard.as_ref().unwrap(), 40, 10);
    session.wait_to_see("40x10 is too small");
    set_size(session.keyboard.as_ref().unwrap(), 150, 50);
    session.wait_to_see("Statistics");
    // a key that comes with another size is not lost: help appears and disappears
    for (columns, (key, shown)) in (80..90).zip([("?", "suspend;"), ("\r", "Stats")].into_iter().cycle()) {
        let before = session.output().len();
        set_size(session.keyboard.as_ref().unwrap(), columns, 30);
        session.press(key);
        session.wait_for_after(before, shown);
    }
    session.press("q");
    session.assert_left_well();
}

#[test]
fn suspended_and_back() {
    let mut session = Session::shell("\"$VN100\" attach sim; echo the shell again; fg >/dev/null");
    session.wait_for_samples("");
    session.press("\x1a");
    let shell = session.wait_for("the shell again");
    let again = session.wait_for_after(shell, ALTERNATE_SCREEN);
    session.wait_for_after(again, "Allan deviation");
    session.press("q");
    session.assert_left_well();
}

#[test]
fn without_its_terminal_only_a_recording_continues() {
    let mut session = Session::start("attach sim");
    session.wait_for_samples("");
    let pid = session.vn100();
    session.hang_up();
    let _ = session.wait();
    assert!(!Path::new(&format!("/proc/{}", pid.as_raw_nonzero())).exists());

    let folder = tempfile::tempdir().unwrap();
    let [told, gone, ended] = ["told", "gone", "ended"].map(|name| folder.path().join(format!("{name}.mcap")));
    let record = |recording: &Path, options: &str| {
        let session = Session::start(&format!("attach sim --record {} {options}", recording.display()));
        session.wait_for_samples("");
        session
    };
    // each at once, because on a busy machine one may end before the other has begun
    let mut session = record(&told, "--duration 6s");
    session.signal(Signal::HUP);
    let mut other = record(&gone, "--duration 6s");
    other.hang_up();
    let mut stopped = record(&ended, "--hangup stop");
    let stopped_pid = stopped.vn100();
    stopped.hang_up();
    session.wait_for(NORMAL_SCREEN);
    let _ = (session.wait(), other.wait(), stopped.wait());
    let process = format!("/proc/{}", stopped_pid.as_raw_nonzero());
    wait_until("it has ended", || !Path::new(&process).exists());
    assert!(fs::read(&ended).unwrap().ends_with(END_OF_RECORDING), "it was ended as by Ctrl-C");
    for recording in [told, gone] {
        let (document, _) = replay(&recording, &[]);
        // on a machine that is too busy, the emulator drops lines
        let timing = |name: &str| document["timing"][name].as_u64().unwrap();
        assert_eq!(timing("samples") + timing("missing"), 240, "all of it was recorded");
    }
}

#[test]
fn a_terminal_that_is_not_read_delays_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("kept.mcap");
    let bytes = || fs::read(&recording).unwrap();
    let mut session = Session::start(&format!("attach sim --record {}", recording.display()));
    session.wait_for_samples("");
    tcflow(&session.line, Action::OOff).unwrap();
    let takes = |line: &File| poll(&mut [PollFd::new(line, PollFlags::OUT)], Some(&Timespec::default())).unwrap() > 0;
    let before = bytes().len();
    wait_until("measured on", || bytes().len() > before + 10_000);
    session.signal(Signal::INT);
    wait_until("the recording is whole", || bytes().ends_with(END_OF_RECORDING));
    assert!(!takes(&session.line), "the terminal is stopped all the time");
    assert!(!session.output().contains(NORMAL_SCREEN), "the result has no room to be printed either");
    assert!(session.child.try_wait().unwrap().is_none(), "it waits for the terminal");
    tcflow(&session.line, Action::OOn).unwrap();
    session.assert_left_well();
    let (document, _) = replay(&recording, &[]);
    let output = session.output();
    let result = &output[output.rfind(NORMAL_SCREEN).unwrap()..];
    let samples = counted(&document);
    assert!(result.contains(&samples), "all that was recorded was measured, {samples}: {result}");
}

#[test]
fn a_terminal_stopped_before_the_first_byte_delays_no_measurement() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("kept.mcap");
    let mut session = Session::shell(&format!("read; exec \"$VN100\" attach sim --record {}", recording.display()));
    tcflow(&session.line, Action::OOff).unwrap();
    session.press("\n");
    wait_until("measured on", || fs::metadata(&recording).is_ok_and(|file| file.len() > 10_000));
    assert_eq!(session.output(), "", "nothing can be drawn");
    tcflow(&session.line, Action::OOn).unwrap();
    session.wait_for_samples("");
    session.press("q");
    session.assert_left_well();
}

/// The last bytes of every MCAP file; the first ones are equal.
const END_OF_RECORDING: &[u8] = b"\x89MCAP0\r\n";

#[test]
fn a_name_on_the_screen_commands_no_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let hostile = folder.path().join("n\u{1b}]0;title\u{7}\u{9b}31m\u{202e}ight.vnymr");
    fs::copy(replay_log("clean-minute.vnymr"), &hostile).unwrap();
    // the shell finds it by its first letter
    let mut session = Session::shell(&format!("exec \"$VN100\" replay {}/n* --speed max", folder.path().display()));
    session.wait_to_see("100 %");
    session.press("q");
    session.assert_left_well();
    let output = session.output();
    assert!(output.contains("]0;title"), "the rest of the name is shown: {output:?}");
    for command in ["\u{1b}]0;", "\u{9b}", "\u{202e}", "\u{7}"] {
        assert!(!output.contains(command), "{command:?} in {output:?}");
    }
}
