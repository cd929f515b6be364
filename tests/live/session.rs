//! The program in a terminal of its own, with a user.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, PipeWriter, Read, Write},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::{Arc, Condvar, Mutex},
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    process::{Pid, PidfdFlags, Signal, kill_process, pidfd_open},
    pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt},
    termios::{Termios, Winsize, tcgetattr, tcsetwinsize},
};

/// The timeout of each step; a longer step is a failure.
const PATIENCE: Duration = Duration::from_secs(600);

pub(crate) const ALTERNATE_SCREEN: &str = "\x1b[?1049h";
pub(crate) const NORMAL_SCREEN: &str = "\x1b[?1049l";
const SHOW_CURSOR: &str = "\x1b[?25h";

/// A terminal with a program on it.
pub(crate) struct Session {
    pub(crate) child: Child,
    /// The side of the user; `None` after a hang-up.
    pub(crate) keyboard: Option<File>,
    /// Kept open, in order to read its modes.
    pub(crate) line: File,
    pub(crate) before: Modes,
    printed: Arc<Printed>,
    /// Reads what is printed until the pipe is dropped.
    reader: Option<(JoinHandle<()>, PipeWriter)>,
}

/// The output so far, and the notification of more.
#[derive(Default)]
struct Printed {
    output: Mutex<Vec<u8>>,
    more: Condvar,
}

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
    pub(crate) fn shell(command: &str) -> Self {
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
        let printed = Arc::default();
        let mut session = Self { child, keyboard: Some(keyboard), line, before, printed, reader: None };
        session.read();
        session
    }

    /// Runs the program with these arguments.
    pub(crate) fn start(arguments: &str) -> Self {
        Self::shell(&format!("exec \"$VN100\" {arguments}"))
    }

    /// Reads what is printed, from now on.
    fn read(&mut self) {
        let mut screen = self.keyboard.as_ref().unwrap().try_clone().unwrap();
        let printed = Arc::clone(&self.printed);
        let (leave, stay) = io::pipe().unwrap();
        let reader = thread::spawn(move || {
            let mut buffer = [0; 4096];
            loop {
                let mut ready = [PollFd::new(&screen, PollFlags::IN), PollFd::new(&leave, PollFlags::IN)];
                poll(&mut ready, None).unwrap();
                if !ready[1].revents().is_empty() {
                    return;
                }
                // the terminal is closed: this is the end
                let Ok(n @ 1..) = screen.read(&mut buffer) else { return };
                printed.output.lock().unwrap().extend_from_slice(&buffer[..n]);
                printed.more.notify_all();
            }
        });
        self.reader = Some((reader, stay));
    }

    /// Closes the terminal, like its window: no handle remains open.
    pub(crate) fn hang_up(&mut self) {
        let (reader, stay) = self.reader.take().unwrap();
        drop(stay);
        reader.join().unwrap();
        self.line = File::open("/dev/null").unwrap();
        self.keyboard = None;
    }

    pub(crate) fn output(&self) -> String {
        String::from_utf8_lossy(&self.printed.output.lock().unwrap()).into_owned()
    }

    /// Searches the output, now and whenever there is more, until `find` returns a value.
    fn wait_until<T>(&self, wanted: &str, find: impl Fn(&str) -> Option<T>) -> T {
        let end = Instant::now() + PATIENCE;
        let mut output = self.printed.output.lock().unwrap();
        loop {
            let text = String::from_utf8_lossy(&output).into_owned();
            if let Some(found) = find(&text) {
                return found;
            }
            let left = end.saturating_duration_since(Instant::now());
            let last = String::from_utf8_lossy(&output[output.len().saturating_sub(3000)..]);
            assert!(!left.is_zero(), "no {wanted:?} on\n{}\nafter {last:?}", screen(&text));
            output = self.printed.more.wait_timeout(output, left).unwrap().0;
        }
    }

    /// Waits until a text was printed, after the first `from` bytes.
    pub(crate) fn wait_for_after(&self, from: usize, text: &str) -> usize {
        let place = |output: &str| Some(from + output.get(from..)?.find(text)? + text.len());
        self.wait_until(text, place)
    }

    pub(crate) fn wait_for(&self, text: &str) -> usize {
        self.wait_for_after(0, text)
    }

    /// Waits until a text is on the screen.
    pub(crate) fn wait_to_see(&self, text: &str) {
        self.wait_until(text, |output| screen(output).contains(text).then_some(()));
    }

    /// Waits until the view shows another number of samples than `before`, and returns it: a measurement
    /// without samples would end without a result.
    pub(crate) fn wait_for_samples(&self, before: &str) -> String {
        self.wait_until("samples", |output| {
            let screen = screen(output);
            let count = screen.split_once(" samples in ")?.0.rsplit('\n').next()?.trim().to_owned();
            (count != "0" && count != before).then_some(count)
        })
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
            // a process does not report that it has begun
            thread::sleep(Duration::from_millis(20));
        }
    }

    pub(crate) fn signal(&self, signal: Signal) {
        kill_process(self.vn100(), signal).unwrap();
    }

    pub(crate) fn wait(&mut self) -> ExitStatus {
        let process = pidfd_open(Pid::from_child(&self.child), PidfdFlags::empty()).unwrap();
        let patience = Timespec::try_from(PATIENCE).unwrap();
        let ended = poll(&mut [PollFd::new(&process, PollFlags::IN)], Some(&patience)).unwrap();
        assert!(ended == 1, "it does not end:\n{}", screen(&self.output()));
        self.child.wait().unwrap()
    }

    /// Checks that it has ended correctly: the screen and the line are restored, and the result follows.
    pub(crate) fn assert_left_well(&mut self) {
        let status = self.wait();
        // the result is on the normal screen
        let is_result = |text: &str| text.contains(" samples") && !text.contains(ALTERNATE_SCREEN);
        self.wait_until("a result", |output| is_result(output.rsplit_once(NORMAL_SCREEN)?.1).then_some(()));
        let output = self.output();
        assert_eq!(status.code(), Some(0), "{output:?}");
        assert!(output.matches(ALTERNATE_SCREEN).count() == output.matches(NORMAL_SCREEN).count());
        assert!(output.rfind(SHOW_CURSOR) > output.rfind("\x1b[?25l"));
        assert_eq!(Modes::of(&self.line), self.before);
    }
}

/// Waits until a condition is true.
pub(crate) fn wait_until(what: &str, so: impl Fn() -> bool) {
    let begin = Instant::now();
    while !so() {
        assert!(begin.elapsed() < PATIENCE, "never so: {what}");
        // the system does not report changes of the state of a process
        thread::sleep(Duration::from_millis(20));
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        // the number of a process that was waited for may belong to another one
        let left = if matches!(self.child.try_wait(), Ok(None)) { descendants(self.child.id()) } else { Vec::new() };
        for pid in left {
            let _ = kill_process(Pid::from_raw(pid as i32).unwrap(), Signal::KILL);
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The content of a terminal after this output: the text at the places of the cursor, without
/// attributes. Text written at a size other than the last may remain.
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

fn descendants(pid: u32) -> Vec<u32> {
    let children = fs::read_to_string(format!("/proc/{pid}/task/{pid}/children")).unwrap_or_default();
    let mut all = vec![pid];
    all.extend(children.split_whitespace().flat_map(|child| descendants(child.parse().unwrap())));
    all
}
