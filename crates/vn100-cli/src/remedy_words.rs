//! What a user can do, as it is called on the command line.

use vn100_analysis::{Remedy, Setting};

/// The option or the command.
pub(crate) fn remedy_words(remedy: &Remedy) -> String {
    let setting = |setting: &Setting| match setting {
        Setting::Message(header) => format!("PORT --set-message {header}"),
        Setting::Window(refreshes) => format!("PORT --window {refreshes}"),
    };
    match remedy {
        Remedy::GiveRate(None) => "--rate".into(),
        Remedy::GiveRate(Some(hz)) => format!("--rate {hz:.4}"),
        Remedy::Skip(None) => "--skip".into(),
        Remedy::Skip(Some(minutes)) => format!("--skip {minutes}min"),
        Remedy::EndEarlier => "--duration".into(),
        Remedy::AcceptUnchecked => "--accept-unchecked".into(),
        Remedy::MapColumns => "--columns".into(),
        Remedy::GiveDatasheet => "--datasheet".into(),
        Remedy::Configure(what) => format!("vn100 configure {}", setting(what)),
        Remedy::MeasureWith(what) => format!("vn100 attach {}", setting(what)),
        Remedy::MeasureLive => "`vn100 attach`".into(),
        Remedy::ReadTemperature => "vn100 attach --temperature".into(),
        Remedy::Record => "vn100 attach PORT --record FILE.mcap --temperature --meta CONDITIONS.toml".into(),
        Remedy::ExportKalibr => "--export kalibr".into(),
        Remedy::FilterModels => "--filter-models".into(),
        // one that is new there has no option here yet
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use vn100_analysis::{Remedy, Setting};

    use super::remedy_words;
    use crate::args::Args;

    #[test]
    fn every_option_that_is_named_is_one() {
        let window = Setting::Window(20);
        for (before, remedy, after) in [
            ("replay x", Remedy::GiveRate(Some(40.0)), ""),
            ("replay x", Remedy::GiveRate(None), " 40"),
            ("replay x", Remedy::Skip(Some(11.0)), ""),
            ("replay x", Remedy::Skip(None), " 1s"),
            ("replay x", Remedy::EndEarlier, " 1h"),
            ("replay x", Remedy::AcceptUnchecked, ""),
            ("replay x", Remedy::MapColumns, " gyro_x=wx:deg/s"),
            ("replay x", Remedy::GiveDatasheet, " y.toml"),
            ("", Remedy::Configure(Setting::Message("VNYMR")), ""),
            ("", Remedy::Configure(window), ""),
            ("", Remedy::MeasureWith(window), ""),
            ("", Remedy::MeasureLive, " PORT"),
            ("", Remedy::ReadTemperature, " PORT"),
            ("", Remedy::Record, ""),
            ("report x -o y", Remedy::ExportKalibr, ""),
            ("report x -o y", Remedy::FilterModels, ""),
        ] {
            let words = remedy_words(&remedy).replace('`', "");
            let line = format!("vn100 {before} {}{after}", words.trim_start_matches("vn100 "));
            let parsed = Args::try_parse_from(line.split_whitespace());
            assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
        }
    }
}
