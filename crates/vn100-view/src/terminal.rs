//! The terminal while the view has it: taken, given back whatever happens, and listened to.

use std::{
    io::{self, IsTerminal, Stdout, Write},
    mem::ManuallyDrop,
    panic,
    sync::{Mutex, MutexGuard, PoisonError, atomic::AtomicBool, mpsc},
    thread,
    time::Duration,
};

#[cfg(unix)]
use std::{sync::atomic::Ordering, time::Instant};

use ratatui::{
    Terminal,
    backend::Backend as _,
    backend::CrosstermBackend,
    crossterm::{
        cursor, event, execute,
        terminal::{
            BeginSynchronizedUpdate, EndSynchronizedUpdate, EnterAlternateScreen, LeaveAlternateScreen,
            disable_raw_mode, enable_raw_mode, is_raw_mode_enabled,
        },
    },
    layout::Rect,
};

/// How long to wait for a terminal that takes no output.
const STALLED_AFTER: Duration = Duration::from_secs(2);

/// How long to wait for the system to stop this program.
#[cfg(unix)]
const STOPPED_WITHIN: Duration = Duration::from_secs(1);

/// What the terminal shows; locked while that changes, which may take as long as the terminal likes.
static SCREEN: Mutex<ShownScreen> = Mutex::new(ShownScreen { entries: 0, is_of_view: false });

struct ShownScreen {
    /// How often the view has entered its screen.
    entries: u64,
    is_of_view: bool,
}

impl ShownScreen {
    fn enter(&mut self, out: &mut impl Write) -> io::Result<()> {
        self.entries += 1;
        self.is_of_view = true;
        execute!(out, EnterAlternateScreen, cursor::Hide)
    }

    /// Shows the screen before the view, if it has not been shown since this entry.
    fn leave(&mut self, entries: u64, out: &mut impl Write) {
        if self.is_of_view && self.entries == entries {
            let _ = execute!(out, EndSynchronizedUpdate, LeaveAlternateScreen, cursor::Show);
            self.is_of_view = false;
        }
    }
}

fn shown_screen() -> MutexGuard<'static, ShownScreen> {
    SCREEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The terminal, as long as the view has it.
pub(crate) struct Screen {
    /// Never dropped: that would write to a terminal that may be gone, and report the error by a
    /// macro that panics where standard error is gone too.
    terminal: ManuallyDrop<Terminal<CrosstermBackend<Stdout>>>,
}

/// Whether standard input and output are a terminal that can be drawn on.
pub fn is_there() -> bool {
    let dumb = std::env::var_os("TERM").is_some_and(|terminal| terminal == "dumb");
    io::stdin().is_terminal() && io::stdout().is_terminal() && !dumb
}

impl Screen {
    /// Takes the terminal. It is given back when this is dropped, and before a panic is reported.
    pub(crate) fn take() -> io::Result<Self> {
        let report = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            give_back();
            report(panic);
        }));
        let terminal = enter().and_then(|()| Terminal::new(CrosstermBackend::new(io::stdout())));
        if terminal.is_err() {
            give_back();
        }
        Ok(Self { terminal: ManuallyDrop::new(terminal?) })
    }

    /// Whether no panic and no signal that ends the program has given the terminal back.
    pub(crate) fn is_ours(&self) -> bool {
        is_raw_mode_enabled().unwrap_or(false)
    }

    /// Clears the screen, and has the next picture drawn whole. `Terminal::clear` would ask for the
    /// cursor, which not every terminal answers.
    fn draw_anew(&mut self) -> io::Result<()> {
        self.terminal.backend_mut().clear()?;
        self.terminal.swap_buffers();
        Ok(())
    }

    pub(crate) fn draw(&mut self, draw: impl FnOnce(&mut ratatui::Frame<'_>)) -> io::Result<Rect> {
        execute!(self.terminal.backend_mut(), BeginSynchronizedUpdate)?;
        let drawn = self.terminal.draw(draw).map(|drawn| drawn.area);
        execute!(self.terminal.backend_mut(), EndSynchronizedUpdate)?;
        drawn
    }

    /// Leaves the terminal to the shell until this program has been `continued`.
    #[cfg(unix)]
    pub(crate) fn suspend(&mut self, continued: &AtomicBool) -> io::Result<()> {
        leave();
        rustix::process::kill_current_process_group(rustix::process::Signal::TSTP)?;
        // Another thread takes the signal, on a busy machine late. Before that the line must not be changed: a shell
        // would take its modes for those before the program. If stopping is refused, as without a shell, nothing follows.
        let asked = Instant::now();
        while !continued.swap(false, Ordering::Relaxed) && asked.elapsed() < STOPPED_WITHIN {
            thread::sleep(Duration::from_millis(10));
        }
        enter()?;
        self.draw_anew()
    }

    #[cfg(not(unix))]
    pub(crate) fn suspend(&mut self, _: &AtomicBool) -> io::Result<()> {
        Ok(())
    }

    /// Takes the terminal once more, after another program had it.
    pub(crate) fn take_again(&mut self) -> io::Result<()> {
        leave();
        enter()?;
        self.draw_anew()
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        give_back();
        // the hook before it reports panics again
        if !thread::panicking() {
            drop(panic::take_hook());
        }
    }
}

fn enter() -> io::Result<()> {
    enable_raw_mode()?;
    shown_screen().enter(&mut io::stdout())
}

/// Gives the terminal back as it was, if the view has it, and returns whether the screen before the view
/// is shown. A terminal that does not take that soon, as if its other end is not read, or if the machine
/// stands still, is left to `leave_screen`: the modes of its line are restored in any case.
pub fn give_back() -> bool {
    if is_raw_mode_enabled().unwrap_or(false) {
        let (done, finished) = mpsc::sync_channel(1);
        let entries = SCREEN.try_lock().ok().map(|shown| shown.entries);
        let restore = move || {
            // it may begin late, when the view has entered its screen again
            entries.into_iter().for_each(|entries| shown_screen().leave(entries, &mut io::stdout()));
            let _ = done.send(());
        };
        let _ = thread::Builder::new().name("vn100-restore".into()).spawn(restore);
        let _ = finished.recv_timeout(STALLED_AFTER);
        give_back_line();
    }
    SCREEN.try_lock().is_ok_and(|shown| !shown.is_of_view)
}

/// Gives the terminal back, and waits until it has taken that.
fn leave() {
    if !give_back() {
        leave_screen();
    }
}

/// Sets the modes of the line back. The view sees it and ends, without leaving the screen.
pub(crate) fn give_back_line() {
    let _ = disable_raw_mode();
}

/// Shows the screen as it was before; waits until the terminal takes that.
pub(crate) fn leave_screen() {
    let mut shown = shown_screen();
    let entries = shown.entries;
    shown.leave(entries, &mut io::stdout());
}

/// Waits for a key or another size. `None` when nothing came in time.
pub(crate) fn next_event(wait: Duration) -> io::Result<Option<event::Event>> {
    // a terminal that is gone must not be read
    something_came(Duration::ZERO)?;
    if event::poll(Duration::ZERO)? {
        return event::read().map(Some);
    }
    if !something_came(wait)? {
        return Ok(None);
    }
    match event::poll(Duration::ZERO)? {
        true => event::read().map(Some),
        false => {
            // half of a key, whose rest is on its way; or a key that came with another size: crossterm gets both at once, returns the
            // size and forgets the key
            notify_again()?;
            thread::sleep(Duration::from_millis(10));
            Ok(None)
        }
    }
}

/// A terminal that was hung up gives end after end to its reader: it must not be read.
#[cfg(unix)]
fn something_came(wait: Duration) -> io::Result<bool> {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let stdin = io::stdin();
    let mut terminal = [PollFd::new(&stdin, PollFlags::IN)];
    let wait = Timespec { tv_sec: wait.as_secs() as i64, tv_nsec: i64::from(wait.subsec_nanos()) };
    match poll(&mut terminal, Some(&wait)) {
        Ok(_) => {}
        // another size, or continued
        Err(rustix::io::Errno::INTR) => return Ok(false),
        Err(error) => return Err(error.into()),
    }
    let came = terminal[0].revents();
    if came.intersects(PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL) {
        return Err(io::Error::new(io::ErrorKind::NotConnected, "the terminal was closed"));
    }
    Ok(came.contains(PollFlags::IN))
}

/// Replaces standard input by one on which nothing ever comes, as long as the returned writer is
/// kept: crossterm would read the end of a terminal that was hung up for ever.
#[cfg(unix)]
pub(crate) fn quiet_input() -> io::Result<io::PipeWriter> {
    let (input, writer) = io::pipe()?;
    rustix::io::ioctl_fionbio(&input, true)?;
    rustix::stdio::dup2_stdin(&input)?;
    Ok(writer)
}

/// Makes the system signal pending input anew, as it does whenever the modes of the line are set.
#[cfg(unix)]
fn notify_again() -> io::Result<()> {
    use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
    let stdin = io::stdin();
    Ok(tcsetattr(&stdin, OptionalActions::Now, &tcgetattr(&stdin)?)?)
}

#[cfg(not(unix))]
fn notify_again() -> io::Result<()> {
    Ok(())
}

#[cfg(not(unix))]
fn something_came(wait: Duration) -> io::Result<bool> {
    event::poll(wait)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_entry_of_the_screen_is_left_once_however_late() {
        let mut shown = ShownScreen { entries: 0, is_of_view: false };
        let written = |change: &mut dyn FnMut(&mut Vec<u8>)| {
            let mut out = Vec::new();
            change(&mut out);
            String::from_utf8(out).unwrap()
        };
        assert!(written(&mut |out| shown.enter(out).unwrap()).contains("\x1b[?1049h"));
        assert!(written(&mut |out| shown.leave(1, out)).contains("\x1b[?1049l"));
        assert_eq!(written(&mut |out| shown.leave(1, out)), "");
        assert!(written(&mut |out| shown.enter(out).unwrap()).contains("\x1b[?1049h"));
        assert_eq!(written(&mut |out| shown.leave(1, out)), "", "that was the entry before");
        assert!(written(&mut |out| shown.leave(2, out)).contains("\x1b[?1049l"));
    }
}
