//! Foreign text never controls the terminal, files are never overwritten without a request, and the
//! files of the program are complete.

use std::{
    fs,
    io::{BufRead, BufReader, Write},
    net::TcpListener,
    os::unix::fs::symlink,
    process::Command,
    thread,
};

use crate::support::{replay_log, run, vn100, with_stdin};

/// Clears the screen, in ASCII and as a character beyond it; rings the bell; changes the direction
/// of text; imitates a line.
const HOSTILE: &str = "x\x1b[2J\u{9b}2J\x07\u{202e}fdp\u{2066}\u{200f}\u{2028}\x7fy";

/// Checks that the output contains no character that controls a terminal, and returns it as text.
#[track_caller]
fn assert_harmless(bytes: &[u8]) -> String {
    let text = String::from_utf8(bytes.to_vec()).unwrap();
    let harmful = |c: &char| {
        (c.is_control() && *c != '\n')
            || ('\u{2028}'..='\u{202e}').contains(c)
            || ('\u{2066}'..='\u{2069}').contains(c)
            || ['\u{61c}', '\u{200e}', '\u{200f}'].contains(c)
    };
    if let Some(place) = text.chars().position(|c| harmful(&c)) {
        let around: String = text.chars().skip(place.saturating_sub(60)).take(120).collect();
        panic!("{around:?}");
    }
    text
}

#[test]
fn names_of_captures_control_nothing_and_are_complete_in_documents() {
    let folder = tempfile::tempdir().unwrap();
    let good = folder.path().join(format!("good{HOSTILE}"));
    let other = folder.path().join(format!("other{HOSTILE}"));
    let none = folder.path().join(format!("none{HOSTILE}"));
    fs::copy(replay_log("corrupted.vnymr"), &good).unwrap();
    fs::copy(replay_log("clean-minute.vnymr"), &other).unwrap();
    for form in [&[][..], &["--json"], &["--ndjson"]] {
        let output = vn100().arg("replay").args([&good, &none]).args(form).output().unwrap();
        assert!(assert_harmless(&output.stdout).contains("good"), "{form:?}");
        assert!(assert_harmless(&output.stderr).contains("none"), "{form:?}");
    }
    for form in [&[][..], &["--json"]] {
        let output = vn100().arg("compare").args([&good, &other]).args(form).output().unwrap();
        assert!(assert_harmless(&output.stdout).contains("other"), "{form:?}");
    }
    let output = vn100().arg("replay").arg(&good).arg("--json").output().unwrap();
    assert_eq!(crate::support::document(&output)["source"]["name"], format!("good{HOSTILE}"));
}

#[test]
fn the_content_of_captures_controls_nothing() {
    let header = format!("t,gyr_x,gyr_y,gyr_z,{HOSTILE}\n");
    let rows: String = (0..200).map(|row| format!("{:.3},0.1,0.2,0.3,{HOSTILE}\n", f64::from(row) * 0.025)).collect();
    let odd = format!("1,{HOSTILE},2,3,4\n");
    let raw = format!("$VN{HOSTILE},1,2,3*00\r\n").repeat(50);
    for content in [format!("{header}{rows}"), format!("{header}{rows}{odd}"), odd, raw, HOSTILE.to_owned()] {
        for form in [&[][..], &["--json"]] {
            let output = with_stdin(vn100().args(["replay", "-"]).args(form), content.as_bytes());
            assert_harmless(&output.stdout);
            assert_harmless(&output.stderr);
            assert!(!output.stdout.is_empty() || !output.stderr.is_empty());
        }
    }
}

/// Markup that would run in a page.
const MARKUP: &str = "</script><script>alert(1)</script><img src=x onerror=alert(1)>";

/// The sentence with its checksum and line end.
fn sentence(body: &str) -> String {
    let check = body.bytes().fold(0, |xor, byte| xor ^ byte);
    format!("${body}*{check:02X}\r\n")
}

/// A sensor on a serial server that reports hostile names, and sends a minute of lines when it was
/// asked for its name.
fn hostile_sensor() -> String {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let source = format!("tcp://{}", server.local_addr().unwrap());
    let log = fs::read(replay_log("clean-minute.vnymr")).unwrap();
    thread::spawn(move || {
        let (mut stream, _) = server.accept().unwrap();
        let mut lines = 0;
        let commands = BufReader::new(stream.try_clone().unwrap());
        // the program ends when it has received enough, and then there is no further command or reader
        for command in commands.lines().map_while(Result::ok) {
            let body = command.trim_start_matches('$').split('*').next().unwrap_or_default();
            let answer = match body {
                "VNRRG,01" => sentence(&format!("VNRRG,01,{MARKUP}%1b[2J")),
                // not a line of the protocol, but the program processes its bytes
                "VNRRG,02" => sentence(&format!("VNRRG,02,{HOSTILE}\0\n")) + &sentence("VNRRG,02,7"),
                "VNRRG,03" => sentence("VNRRG,03,<b>&amp;\"'`"),
                "VNRRG,04" => format!("$VNRRG,04,{HOSTILE}") + &sentence("VNRRG,04,3.1.0.0"),
                _ if body.starts_with("VNRRG") => sentence("VNERR,08"),
                _ => sentence(body),
            };
            // a second until its name is known, then the rest
            let until = if body == "VNRRG,02" || lines > 40 { 2400 } else { 40 };
            let more = &log[lines * 122..until * 122];
            lines = until;
            if stream.write_all(answer.as_bytes()).and_then(|()| stream.write_all(more)).is_err() {
                return;
            }
        }
    });
    source
}

#[test]
fn text_of_a_sensor_controls_nothing_and_is_no_markup() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("sensor.mcap");
    for form in [&[][..], &["--json"]] {
        let output = run(vn100().args(["info", &hostile_sensor()]).args(form));
        assert_eq!(output.status.code(), Some(0), "{}", assert_harmless(&output.stderr));
        let text = assert_harmless(&output.stdout);
        assert!(text.contains("<script>") && text.contains("3.1.0.0"), "the name as it is: {text}");
        let measured = run(vn100().args(["attach", &hostile_sensor(), "--rate", "40", "--duration", "50s"]).args(form));
        assert_eq!(measured.status.code(), Some(0), "{}", assert_harmless(&measured.stderr));
        assert!(assert_harmless(&measured.stdout).contains("VNYMR"));
    }
    let conditions = folder.path().join("conditions.toml");
    let escaped: String = HOSTILE.chars().map(|c| format!("\\u{:04x}", u32::from(c))).collect();
    fs::write(&conditions, format!("place = \"{escaped}{MARKUP}\"\n\"{escaped}\" = \"\\u0000\\n<i>\"\n")).unwrap();
    let recorded = run(vn100()
        .args(["record", &hostile_sensor(), "--duration", "50s", "--meta"])
        .arg(&conditions)
        .arg("-o")
        .arg(&recording));
    assert_harmless(&recorded.stdout);
    assert_harmless(&recorded.stderr);

    let sheet = folder.path().join("sheet.toml");
    let built_in = crate::support::workspace().join("crates/vn100-report/datasheets/vn-100.toml");
    let figures =
        fs::read_to_string(built_in).unwrap().replace("source = \"", &format!("source = \"{escaped}{MARKUP}"));
    let (_, figures) = figures.split_at(figures.find("[[figure]]").unwrap());
    fs::write(&sheet, format!("name = \"{escaped}{MARKUP}\"\nnote = \"{escaped}\"\n{figures}")).unwrap();
    let read = |command: &str, options: &[&str]| {
        let output =
            vn100().arg(command).arg(&recording).arg("--datasheet").arg(&sheet).args(options).output().unwrap();
        assert_harmless(&output.stderr);
        assert!(output.status.success(), "{command} {options:?}: {}", String::from_utf8_lossy(&output.stderr));
        assert_harmless(&output.stdout)
    };
    assert!(read("replay", &["--json"]).contains("<script>"), "the conditions as they are");
    read("replay", &[]);
    let page = folder.path().join("page.html");
    read("report", &["-o", page.to_str().unwrap(), "--export", "json,csv,svg"]);
    let html = assert_harmless(&fs::read(&page).unwrap());
    for told in ["&lt;/script&gt;&lt;script&gt;alert(1)", "&lt;b&gt;&amp;amp;"] {
        assert!(html.contains(told), "no {told}");
    }
    for markup in ["<script>alert", "<img", "<b>&", "<i>"] {
        assert!(!html.contains(markup), "{markup}");
    }
    assert_harmless(&fs::read(folder.path().join("page.json")).unwrap());
    for figure in fs::read_dir(folder.path().join("page.svg-figures")).unwrap() {
        assert_harmless(&fs::read(figure.unwrap().path()).unwrap());
    }
}

#[test]
fn a_command_line_controls_nothing() {
    let hostile = format!("--{HOSTILE}");
    let tcp = format!("tcp://{HOSTILE}");
    for arguments in [
        &["replay", &hostile][..],
        &[HOSTILE],
        &["replay", "x", "--rate", HOSTILE],
        &["replay", "x", "--columns", HOSTILE],
        &["replay", "x", "--datasheet", HOSTILE],
        &["plan", "--want", HOSTILE],
        &["sim", "--faults", HOSTILE],
        &["sim", "-o", "-", "--like", HOSTILE],
        &["info", &tcp],
        &["info", HOSTILE],
        &["completions", HOSTILE],
    ] {
        let output = vn100().args(arguments).output().unwrap();
        assert_ne!(output.status.code(), Some(0), "{arguments:?}");
        assert_harmless(&output.stdout);
        assert!(!assert_harmless(&output.stderr).is_empty(), "{arguments:?}");
    }
}

#[test]
fn nothing_is_written_through_a_link_or_over_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let precious = folder.path().join("precious");
    fs::write(&precious, "precious").unwrap();
    let run = |arguments: &[&str]| {
        vn100().current_dir(folder.path()).args(arguments).output().unwrap().status.code().unwrap()
    };
    for name in ["link.vnymr", "link.mcap", "vn100.1"] {
        symlink(&precious, folder.path().join(name)).unwrap();
    }
    symlink(folder.path().join("made"), folder.path().join("dangling")).unwrap();
    for name in ["precious", "link.vnymr", "link.mcap", "dangling"] {
        assert_eq!(run(&["sim", "--duration", "1s", "-o", name]), 1, "sim -o {name}");
        assert_ne!(run(&["record", "sim", "--duration", "1s", "-o", name]), 0, "record -o {name}");
        assert_ne!(run(&["attach", "sim", "--duration", "1s", "--json", "--record", name]), 0, "--record {name}");
        if name != "precious" {
            assert_ne!(run(&["record", "sim", "--duration", "1s", "--resume", "-o", name]), 0, "--resume {name}");
            // the link is replaced, what it leads to is not
            assert_eq!(run(&["sim", "--duration", "1s", "--force", "-o", name]), 0, "sim --force -o {name}");
            assert!(!folder.path().join(name).is_symlink(), "{name}");
        }
    }
    assert_eq!(run(&["man", "-o", "."]), 1);
    assert_eq!(fs::read_to_string(&precious).unwrap(), "precious");
    assert!(!folder.path().join("made").exists());
}

#[test]
fn completions_are_scripts() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = vn100().args(["completions", shell]).output().unwrap();
        assert_eq!(script.status.code(), Some(0), "{shell}");
        let text = String::from_utf8(script.stdout.clone()).unwrap();
        assert!(text.contains("listen-only") && !text.contains('\u{fffd}') && script.stderr.is_empty(), "{shell}");
        if shell == "bash" {
            match Command::new("bash").arg("--version").output() {
                Ok(_) => assert!(with_stdin(Command::new("bash").arg("-n"), &script.stdout).status.success()),
                Err(_) => eprintln!("skipped: there is no bash to parse the completions"),
            }
        }
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let written = vn100().args(["man", "-o"]).arg(folder.path()).output().unwrap();
    assert_eq!((written.status.code(), written.stdout.len(), written.stderr.len()), (Some(0), 0, 0));
    let pages: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|page| page.unwrap().path()).collect();
    let help = String::from_utf8(vn100().arg("--help").output().unwrap().stdout).unwrap();
    let commands = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    // descriptions continue in lines with a deeper indentation
    let commands = commands.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    let commands: Vec<_> = commands.filter(|command| !["", "help"].contains(command)).collect();
    assert!(commands.contains(&"attach") && commands.contains(&"man"), "{help}");
    for command in &commands {
        assert!(pages.iter().any(|page| page.ends_with(format!("vn100-{command}.1"))), "{command}");
    }
    let main = vn100().arg("man").output().unwrap().stdout;
    assert!(main == fs::read(folder.path().join("vn100.1")).unwrap());
    if Command::new("man").arg("--version").output().is_err() {
        return eprintln!("skipped: there is no man to render the pages");
    }
    for page in &pages {
        let rendered =
            Command::new("man").args(["--warnings", "-E", "UTF-8", "-l", "-Tutf8"]).arg(page).output().unwrap();
        assert!(rendered.status.success() && rendered.stderr.is_empty(), "{page:?}: {rendered:?}");
        assert!(!rendered.stdout.is_empty(), "{page:?}");
    }
}
