//! The text after the options in each help and manual page: examples and exit status.

/// The statuses of an exit, from 0 on.
const STATUSES: [&str; 5] = [
    "success",
    "failed",
    "wrong usage",
    "source not opened, or without a valid sample",
    "--until or --fail-on not met",
];

/// The program and its commands, each with the highest status of its exit, and an example in each line
/// after it: what it does, and the words after `vn100`.
const COMMANDS: &str = "\
vn100: 4
  an emulated sensor, for one minute | attach sim -d 60
  the sensor on a serial port, in the live view | attach /dev/ttyUSB0
  the noise of a recorded capture | replay capture.mcap
  what a code of the results means | explain vibration-line
attach: 4
  the only likely port, until stopped with q or Ctrl-C | attach
  uncompensated and without aliasing, for an hour, recorded | attach /dev/ttyUSB0 --set-message VNIMU --window 20 -d 1h --record imu.mcap
  until N of all gyroscope axes is known to 5 % | attach /dev/ttyUSB0 --until 'gyro N ±5%'
  a sensor behind a serial server, as JSON | attach tcp://bench:2000 -d 10min --json
  watched in a browser, and by Prometheus | attach /dev/ttyUSB0 --serve
  short lines for a script, until it is lost | attach /dev/ttyUSB0 --ndjson=thin --give-up 1min
record: 3
  five hours, with conditions | record /dev/ttyUSB0 -o imu.mcap -d 5h --meta bench.toml
  first start and restart alike | record /dev/ttyUSB0 -o imu.mcap --resume --give-up 10min
  a file for each hour, joined again by a replay | record /dev/ttyUSB0 -o imu.mcap --rotate 1h
info: 3
  model, serial number, firmware, output | info /dev/ttyUSB0
  as JSON | info /dev/ttyUSB0 --json
configure: 3
  uncompensated at 100 Hz without aliasing, saved | configure /dev/ttyUSB0 --set-message VNIMU --set-rate 100 --window 8 --save
  a counter in each line | configure /dev/ttyUSB0 --count on
replay: 4
  the summary of a capture | replay capture.mcap
  without the warm-up | replay capture.mcap --skip 10min
  the samples as a table | replay capture.mcap --samples capture.csv
  a night in minutes, in the live view and on a page | replay night.mcap --speed 600x --serve
  another sensor's table | replay imu.csv --columns t=stamp:ns,gyro_x=wx:deg/s
  incoming inspection | replay unit.mcap --fail-on 'gyro N' --typical-is-limit -q
archive: 4
  every capture below a folder as lines of JSON | archive captures/ -o rows.jsonl
  as a table; the same command later reads only what is new | archive captures/ -o rows.csv
compare: 4
  which of three runs to use | compare run1.mcap run2.mcap run3.mcap
  what the next of these units will have | compare unit*.mcap --sensor 1 --sensor 2 --sensor 3
  as JSON | compare run1.mcap run2.mcap --json
plan: 2
  the usual targets | plan
  how long N to 2 % and B take at 40 Hz | plan --want 'gyro N ±2%' --want 'gyro B' -r 40
report: 4
  one page with figures and tables | report capture.mcap -o report.html
  with tables and figures for other programs | report capture.mcap -o report.html --export csv,kalibr,svg
export: 2
  a VN-100 of 40 Hz for Kalibr | export --datasheet vn-100 --to kalibr -r 40 -w 4
  an ADIS16470 for a robot | export --datasheet adis16470 --to vins -r 200 -w all
sim: 2
  an emulated sensor on a port with a fixed name | sim --link /tmp/vn100
  five hours of known noise at once | sim -o lab.mcap -d 5h --message VNIMU --like lab3
  a twin of a measured sensor | sim -o twin.mcap -d 5h --message VNIMU --like night.mcap
explain: 2
  all codes, by group | explain
  a kind of warning | explain vibration-line
  a parameter | explain ARW
witness: 2
  twenty minutes of a sensor, step by step | witness /dev/ttyUSB0 -o kit.zip
  what a kit settles | witness --check kit.zip
selftest: 3
  compare with published values | selftest
  with public records as well: which there are, and where | selftest --published
ports: 2
  the ports, likely ones first | ports
schema: 2
  the fields of the result of a measurement | schema analysis
completions: 2
  the script for bash | completions bash
man: 2
  the page of the program | man
  a page for each command | man -o man1
";

/// The examples of the command of this name, and the number of its exit statuses; those of the program,
/// if no command has the name.
pub(crate) fn help_of(command: &str) -> (Vec<(&'static str, &'static str)>, usize) {
    let head = |line: &'static str| line.split_once(": ").filter(|_| !line.starts_with(' '));
    let is_other = |line: &&'static str| head(line).is_none_or(|(name, _)| name != command);
    let mut lines = COMMANDS.lines().skip_while(is_other).chain(COMMANDS.lines());
    let (_, highest) = lines.next().and_then(head).unwrap_or_default();
    let examples = lines.map_while(|line| line.strip_prefix("  ")?.split_once(" | ")).collect();
    (examples, highest.parse::<usize>().map_or(0, |highest| highest + 1))
}

pub(crate) fn after(command: &str) -> String {
    let (examples, statuses) = help_of(command);
    let example = |(what, words): &(&str, &str)| format!("  vn100 {words}\n      {what}\n");
    let examples: String = examples.iter().map(example).collect();
    let statuses = STATUSES.iter().take(statuses).enumerate();
    let statuses: Vec<_> = statuses.map(|(status, meaning)| format!("  {status}  {meaning}")).collect();
    format!("Examples:\n{examples}\nExit status:\n{}", statuses.join("\n"))
}
