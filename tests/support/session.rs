//! The program in a terminal of its own, with somebody before it.

use std::{
    fs::{self, File, OpenOptions},
    io::{Read, Write},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    process::{Pid, Signal, kill_process},
    pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt},
    termios::{Termios, Winsize, tcgetattr, tcsetwinsize},
};

/// Nothing here takes longer; what does is a failure.
const PATIENCE: Duration = Duration::from_secs(20);

pub(crate) const ALTERNATE_SCREEN: &str = "\x1b[?1049h";
pub(crate) const NORMAL_SCREEN: &str = "\x1b[?1049l";
const SHOW_CURSOR: &str = "\x1b[?25h";
const NO_MOUSE: &str = "\x1b[?1000l";

/// A terminal with a program on it.
pub(crate) struct Session {
    pub(crate) child: Child,
    /// The side of whoever sits before it; `None` once hung up.
    pub(crate) keyboard: Option<File>,
    /// Kept open, to look at its modes.
    pub(crate) line: File,
    pub(crate) before: Modes,
    pub(crate) output: Arc<Mutex<Vec<u8>>>,
    /// Reads what is printed, until it is told to leave.
    reader: Option<JoinHandle<()>>,
    leave: Arc<AtomicBool>,
}

/// The modes of a line.
#[derive(Debug, PartialEq)]
pub(crate) struct Modes(String);

impl Modes {
    pub(crate) fn of(line: &File) -> Self {
        let Termios { input_modes, output_modes, control_modes, local_modes, .. } = tcgetattr(line).unwrap();
        Self(format!("{input_modes:?} {output_modes:?} {control_modes:?} {local_modes:?}"))
    }
}

impl Session {
    /// Runs a shell command as the leader of a session on a terminal of its own.
    pub(crate) fn shell(command: &str, reads_output: bool) -> Self {
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
        let (output, leave) = (Arc::default(), Arc::default());
        let mut session = Self { child, keyboard: Some(keyboard), line, before, output, reader: None, leave };
        if reads_output {
            session.read();
        }
        session
    }

    /// Runs the program with these arguments.
    pub(crate) fn start(arguments: &str) -> Self {
        Self::shell(&format!("exec \"$VN100\" {arguments}"), true)
    }

    /// Reads what is printed, from now on.
    fn read(&mut self) {
        let mut screen = self.keyboard.as_ref().unwrap().try_clone().unwrap();
        let (output, leave) = (Arc::clone(&self.output), Arc::clone(&self.leave));
        self.reader = Some(thread::spawn(move || {
            let mut buffer = [0; 4096];
            let soon = Timespec { tv_sec: 0, tv_nsec: 20_000_000 };
            while !leave.load(Ordering::Relaxed) {
                if poll(&mut [PollFd::new(&screen, PollFlags::IN)], Some(&soon)) == Ok(0) {
                    continue;
                }
                // the terminal is gone: that is the end
                let Ok(n @ 1..) = screen.read(&mut buffer) else { return };
                output.lock().unwrap().extend_from_slice(&buffer[..n]);
            }
        }));
    }

    /// Takes the terminal away, as when its window is closed: nobody holds it any more.
    pub(crate) fn hang_up(&mut self) {
        self.leave.store(true, Ordering::Relaxed);
        self.reader.take().unwrap().join().unwrap();
        self.line = File::open("/dev/null").unwrap();
        self.keyboard = None;
    }

    pub(crate) fn output(&self) -> String {
        String::from_utf8_lossy(&self.output.lock().unwrap()).into_owned()
    }

    /// Waits until something was printed, behind the first `from` bytes.
    pub(crate) fn wait_for_after(&self, from: usize, text: &str) -> usize {
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

    pub(crate) fn wait_for(&self, text: &str) -> usize {
        self.wait_for_after(0, text)
    }

    /// Waits until something stands on the screen.
    pub(crate) fn wait_to_see(&self, text: &str) {
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

    pub(crate) fn press(&mut self, keys: &str) {
        self.keyboard.as_mut().unwrap().write_all(keys.as_bytes()).unwrap();
    }

    /// The process that shows the view.
    pub(crate) fn vn100(&self) -> Pid {
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

    pub(crate) fn signal(&self, signal: Signal) {
        kill_process(self.vn100(), signal).unwrap();
    }

    pub(crate) fn wait(&mut self) -> ExitStatus {
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
    pub(crate) fn assert_left_well(&mut self) {
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

/// Waits until something is so.
pub(crate) fn wait_until(what: &str, so: impl Fn() -> bool) {
    let begin = Instant::now();
    while !so() {
        assert!(begin.elapsed() < PATIENCE, "never so: {what}");
        thread::sleep(Duration::from_millis(20));
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        // one that was waited for may have left its number to another
        let left = if matches!(self.child.try_wait(), Ok(None)) { descendants(self.child.id()) } else { Vec::new() };
        for pid in left {
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

pub(crate) fn set_size(terminal: &File, columns: u16, rows: u16) {
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
