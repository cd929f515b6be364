//! Any words in place of a command line: taken or refused, and refused with a reason.

use clap::CommandFactory;
use proptest::{collection::vec, prelude::*, sample::select};

use super::*;

/// Every name that a command line has, and values of every kind, good and bad.
fn word() -> impl Strategy<Value = String> {
    let program = Args::command();
    let names: Vec<String> = program
        .get_subcommands()
        .flat_map(|command| {
            let options = command.get_arguments().filter_map(|option| option.get_long());
            options.map(|name| format!("--{name}")).chain([command.get_name().to_owned()]).collect::<Vec<_>>()
        })
        .collect();
    let values = [
        "sim",
        "-",
        "--",
        "tcp://host:1",
        "/dev/ttyUSB0",
        "a.mcap",
        "5h",
        "18446744073709551615s",
        "99999999999y",
        "-1s",
        "40",
        "0",
        "-0",
        "nan",
        "inf",
        "1e400",
        "115200",
        "4294967296",
        "gyro N",
        "gyro N ±5%",
        "accel B >= 0.02 mg",
        "gyro_x=wx:deg/s,t=0:ns",
        "VNYMR",
        "flip@100%:bit7",
        "unplug@20s+3s",
        "10x",
        "max",
        "0x",
        "key=value",
        "",
        "\u{1b}[2J",
        "\u{202e}",
    ];
    prop_oneof![3 => select(names), 3 => select(values.map(str::to_owned).to_vec()), 1 => any::<String>()]
}

proptest! {
    #[test]
    fn any_words_are_a_command_line_or_refused_with_a_reason(words in vec(word(), 0..10)) {
        if let Err(error) = Args::try_parse_from(std::iter::once("vn100".to_owned()).chain(words)) {
            prop_assert!(!error.to_string().is_empty());
        }
    }
}
