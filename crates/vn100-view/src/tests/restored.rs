//! A panic while the view has the terminal: the terminal is given back first, and the panic is read
//! on the normal screen.
#![cfg(target_os = "linux")]

use std::{
    env,
    fs::{File, OpenOptions},
    io::Read,
    process::{Command, Stdio},
    thread,
};

use rustix::{
    pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt},
    termios::{Termios, tcgetattr},
};

use crate::terminal::Screen;

fn modes(line: &File) -> String {
    let Termios { input_modes, output_modes, control_modes, local_modes, .. } = tcgetattr(line).unwrap();
    format!("{input_modes:?} {output_modes:?} {control_modes:?} {local_modes:?}")
}

/// Runs on the terminal of the test below, in a process of its own.
#[test]
#[ignore = "panics; it is run by another test"]
fn panics_with_the_terminal_in_hand() {
    let mut screen = Screen::take().unwrap();
    screen.draw(|frame| frame.render_widget("a view", frame.area())).unwrap();
    let other_thread = thread::spawn(|| panic!("a fault elsewhere"));
    assert!(other_thread.join().is_err());
    assert!(!screen.is_ours(), "it was given back, so that nothing is drawn any more");
    panic!("a fault of the view");
}

#[test]
fn a_panic_is_reported_on_a_terminal_as_it_was_before() {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let name = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
    let line = OpenOptions::new().read(true).write(true).open(name).unwrap();
    let before = modes(&line);
    let end = || Stdio::from(line.try_clone().unwrap());
    let test = "tests::restored::panics_with_the_terminal_in_hand";
    let mut child = Command::new(env::current_exe().unwrap())
        .args(["--exact", test, "--ignored", "--nocapture"])
        .env("RUST_BACKTRACE", "0")
        .stdin(end())
        .stdout(end())
        .stderr(end())
        .spawn()
        .unwrap();
    let mut screen = File::from(master);
    let reader = thread::spawn(move || {
        let (mut output, mut buffer) = (Vec::new(), [0; 4096]);
        // the test's own last line marks the end
        while !String::from_utf8_lossy(&output).contains("test result: FAILED") {
            let n = screen.read(&mut buffer).unwrap();
            output.extend_from_slice(&buffer[..n]);
        }
        // without it the line would be gone
        (String::from_utf8_lossy(&output).into_owned(), screen)
    });
    assert!(!child.wait().unwrap().success());
    let (output, _screen) = reader.join().unwrap();
    assert_eq!(modes(&line), before);
    let left = output.rfind("\x1b[?1049l").unwrap();
    assert_eq!(output.matches("\x1b[?1049l").count(), 1, "{output:?}");
    for shown in ["a fault elsewhere", "a fault of the view"] {
        assert!(output.find(shown).unwrap() > left, "{output:?}");
    }
}
