//! The live view in a real terminal: started, steered, ended in every way, and what it leaves behind.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test fails by panicking and says so when it skips")]

mod support;

use std::{
    fs::{self, File, OpenOptions},
    io::{Read, Write},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::{Arc, Mutex},
    thread,
    time::{Duration, Instant},
};

use rustix::{
    process::{Pid, Signal, kill_process},
    pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt},
    termios::{Termios, Winsize, tcgetattr, tcsetwinsize},
};
use support::{replay, replay_log};

/// Nothing here takes longer; what does is a failure.
const PATIENCE: Duration = Duration::from_secs(20);

const ALTERNATE_SCREEN: &str = "\x1b[?1049h";
const NORMAL_SCREEN: &str = "\x1b[?1049l";
const SHOW_CURSOR: &str = "\x1b[?25h";
const NO_MOUSE: &str = "\x1b[?1000l";

/// A terminal with a program on it.
struct Session {
    child: Child,
    /// The side of whoever sits before it; `None` once hung up.
    keyboard: Option<File>,
    /// Kept open, to look at its modes.
    line: File,
    before: Modes,
    output: Arc<Mutex<Vec<u8>>>,
}

/// The modes of a line.
#[derive(Debug, PartialEq)]
struct Modes(String);

impl Modes {
    fn of(line: &File) -> Self {
        let Termios { input_modes, output_modes, control_modes, local_modes, .. } = tcgetattr(line).unwrap();
        Self(format!("{input_modes:?} {output_modes:?} {control_modes:?} {local_modes:?}"))
    }
}

impl Session {
    /// Runs a shell command as the leader of a session on a terminal of its own.
    fn shell(command: &str, reads_output: bool) -> Self {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        let name = PathBuf::from(ptsname(&master, Vec::new()).unwrap().into_string().unwrap());
        let line = OpenOptions::new().read(true).write(true).open(&name).unwrap();
        let before = Modes::of(&line);
        let keyboard = File::from(master);
        set_size(&keyboard, 100, 30);
        let end = || Stdio::from(line.try_clone().unwrap());
        let child = Command::new("setsid")
            .args(["--ctty", "--wait", "bash", "-mc", command])
            .env("VN100", env!("CARGO_BIN_EXE_vn100"))
            .env("TERM", "xterm-256color")
            .env("LC_ALL", "C.UTF-8")
            .env_remove("RUST_BACKTRACE")
            .env_remove("NO_COLOR")
            .stdin(end())
            .stdout(end())
            .stderr(end())
            .spawn()
            .unwrap();
        let session = Self { child, keyboard: Some(keyboard), line, before, output: Arc::default() };
        if reads_output {
            session.read();
        }
        session
    }

    /// Runs the program with these arguments.
    fn start(arguments: &str) -> Self {
        Self::shell(&format!("exec \"$VN100\" {arguments}"), true)
    }

    /// Reads what is printed, from now on.
    fn read(&self) {
        let mut screen = self.keyboard.as_ref().unwrap().try_clone().unwrap();
        let output = Arc::clone(&self.output);
        thread::spawn(move || {
            let mut buffer = [0; 4096];
            // the terminal is gone: that is the end
            while let Ok(n @ 1..) = screen.read(&mut buffer) {
                output.lock().unwrap().extend_from_slice(&buffer[..n]);
            }
        });
    }

    fn output(&self) -> String {
        String::from_utf8_lossy(&self.output.lock().unwrap()).into_owned()
    }

    /// Waits until something was printed, behind the first `from` bytes.
    fn wait_for_after(&self, from: usize, text: &str) -> usize {
        let begin = Instant::now();
        loop {
            let output = self.output();
            if let Some(place) = output.get(from..).and_then(|output| output.find(text)) {
                return from + place + text.len();
            }
            assert!(begin.elapsed() < PATIENCE, "no {text:?} behind {from} in {output:?}");
            thread::sleep(Duration::from_millis(20));
        }
    }

    fn wait_for(&self, text: &str) -> usize {
        self.wait_for_after(0, text)
    }

    /// Waits until something stands on the screen.
    fn wait_to_see(&self, text: &str) {
        let begin = Instant::now();
        loop {
            let screen = screen(&self.output());
            if screen.contains(text) {
                return;
            }
            assert!(begin.elapsed() < PATIENCE, "no {text:?} on\n{screen}");
            thread::sleep(Duration::from_millis(20));
        }
    }

    fn press(&mut self, keys: &str) {
        self.keyboard.as_mut().unwrap().write_all(keys.as_bytes()).unwrap();
    }

    /// The process that shows the view.
    fn vn100(&self) -> Pid {
        let begin = Instant::now();
        loop {
            let found = descendants(self.child.id()).into_iter().find(|pid| {
                fs::read_link(format!("/proc/{pid}/exe")).is_ok_and(|exe| exe == Path::new(env!("CARGO_BIN_EXE_vn100")))
            });
            if let Some(pid) = found {
                return Pid::from_raw(pid as i32).unwrap();
            }
            assert!(begin.elapsed() < PATIENCE, "it does not run");
            thread::sleep(Duration::from_millis(20));
        }
    }

    fn signal(&self, signal: Signal) {
        kill_process(self.vn100(), signal).unwrap();
    }

    fn wait(&mut self) -> ExitStatus {
        let begin = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status;
            }
            assert!(begin.elapsed() < PATIENCE, "it does not end: {:?}", self.output());
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// It has ended well: the screen is back, the line is as it was, and the result follows.
    fn assert_left_well(&mut self) {
        let status = self.wait();
        let result = self.wait_for("bytes      ");
        let output = self.output();
        assert_eq!(status.code(), Some(0), "{output:?}");
        let left = output.rfind(NORMAL_SCREEN).unwrap();
        assert!(left < result, "the result is on the normal screen");
        assert!(output.matches(ALTERNATE_SCREEN).count() == output.matches(NORMAL_SCREEN).count());
        assert!(output.contains(NO_MOUSE));
        assert!(output.rfind(SHOW_CURSOR) > output.rfind("\x1b[?25l"));
        assert_eq!(Modes::of(&self.line), self.before);
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        for pid in descendants(self.child.id()) {
            let _ = kill_process(Pid::from_raw(pid as i32).unwrap(), Signal::KILL);
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What a terminal shows after this output: where the cursor goes and what is written there, without looks. What was written in another
/// size than the last may still stand.
fn screen(output: &str) -> String {
    let mut lines = vec![vec![' '; 200]; 60];
    let (mut row, mut column) = (0, 0);
    let mut signs = output.chars();
    while let Some(sign) = signs.next() {
        if sign != '\x1b' {
            if let Some(cell) = lines.get_mut(row).and_then(|line: &mut Vec<char>| line.get_mut(column)) {
                *cell = sign;
            }
            column += 1;
            continue;
        }
        let _bracket = signs.next();
        let mut numbers = String::new();
        let command = loop {
            match signs.next() {
                Some(sign @ ('0'..='9' | ';' | '?')) => numbers.push(sign),
                Some(command) => break command,
                None => break ' ',
            }
        };
        match command {
            'H' => {
                let mut at = numbers.split(';').map(|number| number.parse().unwrap_or(1_usize) - 1);
                (row, column) = (at.next().unwrap_or(0), at.next().unwrap_or(0));
            }
            'J' => lines.iter_mut().for_each(|line| line.fill(' ')),
            _ => {}
        }
    }
    let lines: Vec<String> = lines.into_iter().map(|line| line.into_iter().collect()).collect();
    lines.iter().map(|line| line.trim_end()).collect::<Vec<_>>().join("\n")
}

fn set_size(terminal: &File, columns: u16, rows: u16) {
    let size = Winsize { ws_row: rows, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
    tcsetwinsize(terminal, size).unwrap();
}

/// A process and all that it began.
fn descendants(pid: u32) -> Vec<u32> {
    let children = fs::read_to_string(format!("/proc/{pid}/task/{pid}/children")).unwrap_or_default();
    let mut all = vec![pid];
    all.extend(children.split_whitespace().flat_map(|child| descendants(child.parse().unwrap())));
    all
}

#[test]
fn keys_lead_through_the_view_and_the_result_follows() {
    let mut session = Session::start("attach sim");
    session.wait_for(ALTERNATE_SCREEN);
    session.wait_for("Allan deviation");
    assert_ne!(Modes::of(&session.line), session.before, "keys are read one by one");
    session.press("?");
    let help = session.wait_for("this help; any key closes it");
    session.press("x");
    session.wait_for_after(help, "Allan deviation");
    session.press("\t");
    session.wait_to_see("white noise");
    session.press("r");
    session.wait_to_see("Forget everything");
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
    session.assert_left_well();
    let output = session.output();
    assert!(output[output.rfind(NORMAL_SCREEN).unwrap()..].contains("Allan deviation σ(τ) of the gyro"));
}

#[test]
fn a_measurement_that_ends_by_itself_ends_the_view() {
    let mut session = Session::start("attach sim --duration 2s");
    session.assert_left_well();
    assert!(session.output().contains("80 samples of VNYMR in 2 s"));
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
    let mut session = Session::shell("\"$VN100\" attach sim; echo the shell again; fg >/dev/null", true);
    session.wait_for("Allan deviation");
    session.press("\x1a");
    let shell = session.wait_for("the shell again");
    let again = session.wait_for_after(shell, ALTERNATE_SCREEN);
    session.wait_for_after(again, "Allan deviation");
    session.press("q");
    session.assert_left_well();
}

#[test]
fn without_its_terminal_only_a_recording_goes_on() {
    let mut session = Session::start("attach sim");
    session.wait_for("Allan deviation");
    session.keyboard = None;
    let pid = session.vn100();
    session.line = File::open("/dev/null").unwrap();
    session.signal(Signal::HUP);
    let _ = session.wait();
    assert!(!Path::new(&format!("/proc/{}", pid.as_raw_nonzero())).exists());

    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("kept.mcap");
    let mut session = Session::start(&format!("attach sim --duration 4s --record {}", recording.display()));
    session.wait_for("Allan deviation");
    session.signal(Signal::HUP);
    session.wait_for(NORMAL_SCREEN);
    let _ = session.wait();
    let (document, _) = replay(&recording, &[]);
    assert_eq!(document["timing"]["samples"], 160, "all of it was recorded");
}

#[test]
fn a_terminal_that_nobody_reads_holds_nothing_up() {
    let mut session = Session::shell("exec \"$VN100\" attach sim --duration 6s", false);
    // the result has no room to be printed either
    let begin = Instant::now();
    let pid = session.vn100();
    while begin.elapsed() < Duration::from_secs(8) {
        assert!(session.child.try_wait().unwrap().is_none());
        thread::sleep(Duration::from_millis(100));
    }
    assert!(Path::new(&format!("/proc/{}", pid.as_raw_nonzero())).exists(), "it waits to be read");
    session.read();
    session.wait();
    let output = session.output();
    assert!(output.contains("240 samples of VNYMR in 6 s"), "{output:?}");
    assert!(output.contains("missing    0 samples"), "{output:?}");
    assert_eq!(Modes::of(&session.line), session.before);
}

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
    assert!(output.contains("2400 samples of VNYMR in 60 s"), "the whole of it is the result");
    assert!(!output.contains("interrupted"));
}

#[test]
fn what_is_shown_is_saved_beside_other_files() {
    let folder = tempfile::tempdir().unwrap();
    let log = fs::canonicalize(replay_log("clean-minute.vnymr")).unwrap();
    let command = format!("cd {}; exec \"$VN100\" replay {} --speed max", folder.path().display(), log.display());
    let mut session = Session::shell(&command, true);
    session.wait_to_see("100 %");
    session.press("s");
    session.wait_to_see("saved ");
    session.press("xs");
    session.wait_to_see("-2.svg");
    session.press("q");
    session.assert_left_well();
    let file = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let saved: serde_json::Value = serde_json::from_str(&file("vn100-clean-minute-vnymr-2400.json")).unwrap();
    assert_eq!((&saved["schema"], &saved["timing"]["samples"]), (&"vn100.analysis/1".into(), &2400.into()));
    let svg = file("vn100-clean-minute-vnymr-2400-2.svg");
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>") && svg.contains("gyro_x"));
}
