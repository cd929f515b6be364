//! The live view in a real terminal: started, steered, ended in every way, and what it leaves
//! behind.

use std::{
    fs::{self, File},
    path::Path,
};

use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    process::Signal,
    pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt},
    termios::{Action, tcflow},
};

use crate::session::{ALTERNATE_SCREEN, Modes, NORMAL_SCREEN, Session, set_size, wait_until};
use crate::support::{replay, replay_log, vn100};

/// The samples of a document, as the summary counts them.
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
    session.wait_for("Allan deviation");
    assert_ne!(Modes::of(&session.line), session.before, "keys are read one by one");
    session.press("?");
    session.wait_to_see("this help: arrows turn pages, esc closes it");
    session.press("x");
    session.wait_to_see("Allan deviation");
    session.press("\t");
    session.wait_to_see("Angle Random Walk");
    session.press("r");
    session.wait_to_see("Discard everything");
    session.press("y");
    session.wait_to_see("started over after");
    session.press("q");
    session.assert_left_well();
}

#[test]
fn every_way_to_end_gives_the_terminal_back() {
    let mut sessions: Vec<(Session, &str)> =
        ["q", "\x03", "TERM", "INT"].map(|way| (Session::start("attach sim"), way)).into();
    for (session, way) in &mut sessions {
        session.wait_for("Allan deviation");
        match *way {
            "TERM" => session.signal(Signal::TERM),
            "INT" => session.signal(Signal::INT),
            keys => session.press(keys),
        }
        session.assert_left_well();
    }
}

#[test]
fn the_last_screen_stays_where_that_is_asked_for() {
    let mut session = Session::start("attach sim");
    session.wait_for("Allan deviation");
    session.press("Q");
    assert_eq!(session.wait().code(), Some(0));
    let left = session.wait_for(NORMAL_SCREEN);
    session.wait_for_after(left, "Allan deviation σ(τ) of the gyro");
    let output = session.output();
    let left = &output[left..];
    assert!(!left.contains("--full: everything as tables"), "it stands for the summary: {left}");
    assert_eq!(Modes::of(&session.line), session.before);
}

#[test]
fn the_summary_after_the_view_is_short() {
    let mut session = Session::start("attach sim");
    session.wait_for("Allan deviation");
    session.press("q");
    session.assert_left_well();
    let output = session.output();
    // behind what a busy machine says of the link
    let begin = output.rfind("sim  VN").unwrap_or_else(|| panic!("no summary: {output}"));
    let lines = output[begin..].lines().count();
    assert!(lines <= 45, "{lines} lines: {output}");
}

#[test]
fn a_signal_that_aborts_leaves_the_terminal_as_it_was() {
    for (signal, code) in [(Signal::QUIT, 131), (Signal::ABORT, 134)] {
        let mut session = Session::start("attach sim");
        session.wait_for("Allan deviation");
        session.signal(signal);
        assert_eq!(session.wait().code(), Some(code));
        assert_eq!(Modes::of(&session.line), session.before, "{signal:?}");
        session.wait_for(NORMAL_SCREEN);
        let output = session.output();
        assert_eq!(output.matches(ALTERNATE_SCREEN).count(), output.matches(NORMAL_SCREEN).count());
    }
}

#[test]
fn the_theme_is_that_of_the_background_the_terminal_names() {
    let light = "38;2;170;75;0";
    let mut session = Session::shell("COLORTERM=truecolor exec \"$VN100\" attach sim");
    session.wait_for("\x1b]11;?");
    let before = session.wait_for("Allan deviation");
    assert!(!session.output().contains(light), "dark until the terminal answers");
    session.press("\x1b]11;rgb:ffff/ffff/ffff\x1b\\");
    session.wait_for_after(before, light);
    // none of the answer was a key
    session.press("?");
    session.wait_to_see("this help: arrows turn pages, esc closes it");
    session.press("q");
    session.assert_left_well();
    let mut session = Session::shell("COLORTERM=truecolor exec \"$VN100\" attach sim --theme light");
    session.wait_for(light);
    assert!(!session.output().contains("\x1b]11;?"));
    session.press("q");
    session.assert_left_well();
}

#[test]
fn the_settings_of_the_user_are_those_of_the_view() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("vn100").join("vn100.toml");
    fs::create_dir_all(file.parent().unwrap()).unwrap();
    fs::write(&file, "theme = \"light\"\nunits = \"si\"\nport = \"sim\"\n").unwrap();
    let home = format!("XDG_CONFIG_HOME={}", folder.path().display());
    let mut session = Session::shell(&format!("{home} exec \"$VN100\" attach"));
    session.wait_for("38;2;170;75;0");
    session.wait_to_see("of the gyro, rad/s");
    session.press("q");
    session.assert_left_well();
    // what is chosen on the command line is stronger
    let mut session = Session::shell(&format!("{home} exec \"$VN100\" attach sim --theme dark"));
    session.wait_for("38;2;230;159;0");
    session.press("q");
    session.assert_left_well();
    fs::write(&file, "theme = \"light\"\ncolour = 1\n").unwrap();
    let mut session = Session::shell(&format!("{home} exec \"$VN100\" attach sim"));
    session.wait_for("line 2");
    session.wait_for("Allan deviation");
    session.press("q");
    session.assert_left_well();
    // one that is named is refused
    let mut session = Session::start(&format!("attach sim --config {}", file.display()));
    assert_eq!(session.wait().code(), Some(2));
    session.wait_for("line 2");
    assert_eq!(Modes::of(&session.line), session.before);
}

#[test]
fn two_emulated_sensors_have_names_of_their_own() {
    let mut session = Session::start("attach sim sim");
    session.wait_to_see("sim-1");
    session.wait_to_see("sim-2");
    session.press("1");
    session.wait_to_see("Allan deviation");
    session.press("n");
    session.wait_to_see("2/2");
    session.wait_to_see("Allan deviation");
    session.press("q");
    session.assert_left_well();
}

#[test]
fn a_measurement_that_ends_by_itself_ends_the_view() {
    let mut session = Session::start("attach sim --duration 2s");
    session.assert_left_well();
    assert!(session.output().contains("2 s  80 samples"));
}

#[test]
fn another_size_is_drawn_at_once() {
    let mut session = Session::start("attach sim");
    session.wait_for("Allan deviation");
    set_size(session.keyboard.as_ref().unwrap(), 40, 10);
    session.wait_to_see("40x10 is too small");
    set_size(session.keyboard.as_ref().unwrap(), 150, 50);
    session.wait_to_see("Statistics");
    session.press("q");
    session.assert_left_well();
}

#[test]
fn a_key_that_comes_with_another_size_is_not_lost() {
    let mut session = Session::start(&format!("replay {} --speed 1x", replay_log("clean-minute.vnymr").display()));
    session.wait_for("Allan deviation");
    // help comes, and goes
    for (columns, (key, shown)) in (80..100).zip([("?", "suspend;"), ("\r", "Stats")].into_iter().cycle()) {
        let before = session.output().len();
        set_size(session.keyboard.as_ref().unwrap(), columns, 30);
        session.press(key);
        session.wait_for_after(before, shown);
    }
    session.press("q");
    session.assert_left_well();
}

#[test]
fn the_first_screen_says_what_is_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    // a line on which nobody sends
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let name = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
    let mut session = Session::start(&format!("attach {name}"));
    session.wait_to_see("No measurement yet");
    session.wait_to_see("Listening on");
    session.press("q");
    assert_eq!(session.wait().code(), Some(3), "{:?}", session.output());
    assert_eq!(Modes::of(&session.line), session.before);
    drop(folder);
}

#[test]
fn suspended_and_back() {
    let mut session = Session::shell("\"$VN100\" attach sim; echo the shell again; fg >/dev/null");
    session.wait_for("Allan deviation");
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
    session.wait_for("Allan deviation");
    let pid = session.vn100();
    session.hang_up();
    let _ = session.wait();
    assert!(!Path::new(&format!("/proc/{}", pid.as_raw_nonzero())).exists());

    let folder = tempfile::tempdir().unwrap();
    let [told, gone] = ["told", "gone"].map(|name| folder.path().join(format!("{name}.mcap")));
    let record = |recording: &Path| {
        let session = Session::start(&format!("attach sim --duration 6s --record {}", recording.display()));
        session.wait_for("Allan deviation");
        session
    };
    // each at once: on a busy machine the one may be over before the other has begun
    let mut session = record(&told);
    session.signal(Signal::HUP);
    let mut other = record(&gone);
    other.hang_up();
    session.wait_for(NORMAL_SCREEN);
    let _ = (session.wait(), other.wait());
    for recording in [told, gone] {
        let (document, _) = replay(&recording, &[]);
        // a machine that is too busy makes the emulator drop lines
        let timing = |name: &str| document["timing"][name].as_u64().unwrap();
        assert_eq!(timing("samples") + timing("missing"), 240, "all of it was recorded");
    }
}

#[test]
fn a_recording_says_what_was_left_out_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("left-out.mcap");
    let mut session = Session::start(&format!("attach sim --record {}", recording.display()));
    session.wait_for("Allan deviation");
    for (key, told) in [("w", "are excluded, as by --skip"), ("r", "started over after"), ("w", "as by --skip")] {
        session.press(key);
        session.wait_to_see("y / n");
        session.press("y");
        session.wait_to_see(told);
    }
    session.wait_to_see("next: ");
    session.press("q");
    session.assert_left_well();
    let (whole, _) = replay(&recording, &[]);
    let reason = whole["source"]["recorded"]["end_reason"].as_str().unwrap();
    let skip = reason.strip_prefix("stopped; excluded by command, as by --skip ").unwrap_or_else(|| panic!("{reason}"));
    let (document, _) = replay(&recording, &["--skip", skip]);
    assert!(document["timing"]["samples"].as_u64() < whole["timing"]["samples"].as_u64());
    let output = session.output();
    let result = &output[output.rfind(NORMAL_SCREEN).unwrap()..];
    let samples = counted(&document);
    assert!(result.contains(&samples), "{samples}: {result}");
    // to the last digit printed
    let std = document["channels"][9]["statistics"]["std"].as_f64().unwrap().to_degrees();
    assert!(result.contains(&format!("{std:.4}")), "{std}: {result}");
}

#[test]
fn a_mark_is_kept_in_the_recording_and_shown_in_the_report() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("marked.mcap");
    let mut session = Session::start(&format!("attach sim --record {}", recording.display()));
    session.wait_for("Allan deviation");
    session.press("mfan <b>on</b>\r");
    session.wait_to_see("marked: fan <b>on</b>");
    session.wait_to_see("next: ");
    session.press("q");
    session.assert_left_well();
    let (document, _) = replay(&recording, &[]);
    let [mark] = &document["source"]["marks"].as_array().unwrap()[..] else { panic!("{}", document["source"]) };
    assert_eq!(mark["text"], "fan <b>on</b>");
    let (at_s, duration_s) = (mark["at_s"].as_f64().unwrap(), document["timing"]["duration_s"].as_f64().unwrap());
    assert!((0.5..=duration_s).contains(&at_s), "{at_s} of {duration_s}");
    let page = folder.path().join("marked.html");
    let report = vn100().args(["report", "-o"]).args([&page, &recording]).output().unwrap();
    assert!(report.status.success(), "{report:?}");
    assert!(fs::read_to_string(page).unwrap().contains("fan &lt;b&gt;on&lt;/b&gt;"));
}

#[test]
fn a_terminal_that_is_not_read_delays_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("kept.mcap");
    let bytes = || fs::read(&recording).unwrap();
    let mut session = Session::start(&format!("attach sim --record {}", recording.display()));
    session.wait_for("Allan deviation");
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
fn a_terminal_stopped_before_the_first_byte_holds_no_measurement_up() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("kept.mcap");
    let mut session = Session::shell(&format!("read; exec \"$VN100\" attach sim --record {}", recording.display()));
    tcflow(&session.line, Action::OOff).unwrap();
    session.press("\n");
    wait_until("measured on", || fs::metadata(&recording).is_ok_and(|file| file.len() > 10_000));
    assert_eq!(session.output(), "", "nothing can be drawn");
    tcflow(&session.line, Action::OOn).unwrap();
    session.wait_for("Allan deviation");
    session.press("q");
    session.assert_left_well();
}

/// The last bytes of every MCAP file; its first are the same.
const END_OF_RECORDING: &[u8] = b"\x89MCAP0\r\n";

#[test]
fn a_capture_is_replayed_paused_and_led_about() {
    let log = replay_log("clean-minute.vnymr");
    let mut session = Session::start(&format!("replay {} --speed 1x", log.display()));
    session.wait_for("Allan deviation");
    session.press(" ");
    session.wait_to_see("paused");
    session.press("g50\r");
    session.wait_to_see("50 %");
    session.press("g10\r");
    session.wait_to_see("10 %");
    session.press(" g100\r");
    session.wait_to_see("100 %");
    session.press("q");
    session.assert_left_well();
    let output = session.output();
    assert!(output.contains("1 min  2 400 samples"), "the whole of it is the result");
    assert!(!output.contains("interrupted"));
}

#[test]
fn the_end_of_a_capture_is_looked_back_from() {
    let mut session = Session::start(&format!("replay {} --speed max", replay_log("clean-minute.vnymr").display()));
    session.wait_to_see("end, max");
    session.press(" ");
    session.wait_to_see("end of the capture");
    session.press("<");
    session.wait_to_see("end, 1000x");
    session.press("g30\r");
    session.wait_to_see("|| paused, 1000x 30 %");
    session.press(" ");
    session.wait_to_see("end, 1000x");
    session.press("q");
    session.assert_left_well();
    assert!(session.output().contains("1 min  2 400 samples"));
}

#[test]
fn a_part_of_a_capture_ends_as_the_whole_does() {
    let log = replay_log("clean-minute.vnymr");
    let mut session = Session::start(&format!("replay {} --speed max --duration 10s", log.display()));
    session.wait_to_see("duration reached");
    session.press("<");
    session.wait_to_see("end, 1000x");
    session.press("q");
    session.assert_left_well();
    let output = session.output();
    assert!(output.contains("10 s  400 samples") && !output.contains("interrupted"), "{output}");
}

#[test]
fn a_warm_up_that_is_over_stays_so_when_one_looks_back() {
    let log = replay_log("clean-minute.vnymr");
    let mut session = Session::start(&format!("replay {} --speed 1x", log.display()));
    session.wait_for("Allan deviation");
    session.press(" g50\r");
    session.wait_to_see("|| paused, 1x 50 %");
    session.press("wy");
    session.wait_to_see("the first 30 s are excluded");
    session.press("g75\r");
    session.wait_to_see("|| paused, 1x 75 %");
    session.press("g60\r");
    session.wait_to_see("the first 30 s are still excluded");
    session.wait_to_see("240 samples in 6 s");
    session.press("r");
    session.press("y");
    session.wait_to_see("started over after 36 s");
    session.press("g75\r");
    session.wait_to_see("360 samples in 9 s");
    session.press("g70\r");
    session.wait_to_see("240 samples in 6 s");
    session.press("g10\r");
    session.wait_to_see("nothing is excluded any more");
    session.press("q");
    session.assert_left_well();
    assert!(session.output().contains("6 s  240 samples"));
}

#[test]
fn what_is_shown_is_saved_beside_other_files() {
    let folder = tempfile::tempdir().unwrap();
    let log = fs::canonicalize(replay_log("clean-minute.vnymr")).unwrap();
    let command = format!("cd {}; exec \"$VN100\" replay {} --speed max", folder.path().display(), log.display());
    let mut session = Session::shell(&command);
    session.wait_to_see("100 %");
    session.press("s");
    session.wait_to_see("saved ");
    session.press("xs");
    session.wait_to_see("-2.svg");
    session.press("q");
    session.assert_left_well();
    let file = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let saved: serde_json::Value = serde_json::from_str(&file("vn100-clean-minute-vnymr-2400.json")).unwrap();
    // at the end of the capture the replay in the view has not ended
    let (mut replayed, _) = replay(&log, &[]);
    replayed["end_reason"] = serde_json::Value::Null;
    assert_eq!(saved, replayed, "nothing of the result is left out");
    let svg = file("vn100-clean-minute-vnymr-2400-2.svg");
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>") && svg.contains("gyro_x"));
}

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
