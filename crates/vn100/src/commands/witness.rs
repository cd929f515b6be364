//! `vn100 witness`: what an owner of a sensor can record in twenty minutes to settle what is not
//! known of it. Each step is a recording like that of `vn100 record`, so that the sensor is left as
//! it was found after each; finished steps are kept, and the same command continues.

mod findings;
mod kit;

use std::{
    collections::BTreeMap,
    fs,
    io::{self, BufRead, IsTerminal},
    path::{Path, PathBuf},
    time::Duration,
};

use anyhow::{Context, Result, bail};
use clap::Parser;
use tokio::{runtime::Builder, task};
use tokio_util::sync::CancellationToken;
use vn100_analysis::Completion;

use self::kit::Kit;
use crate::{
    args::{Args, AttachArgs, OutputFormat, Subcommand, WitnessArgs},
    commands::attach::attach_all,
    exit::{HangUp, print, report, stop_on_interrupt},
    log::{Entries, run_logged},
    output::Output,
    result::FAULT,
    user_files::read_conditions,
};

/// A part of the measurement.
#[derive(Debug, PartialEq)]
struct Step {
    /// The name of its recording.
    name: &'static str,
    /// What is recorded, and what the owner does.
    ask: &'static str,
    /// How the sensor is set for it, in the words of the command line.
    settings: &'static str,
    minutes: u32,
}

const STEPS: [Step; 8] = [
    Step { name: "as-found", ask: "the sensor as it is set, its identity and its registers", settings: "", minutes: 1 },
    Step {
        name: "vnymr-40-20",
        ask: "$VNYMR at 40 Hz, averages of 20",
        settings: "--set-message VNYMR --set-rate 40 --window 20",
        minutes: 3,
    },
    Step {
        name: "vnimu-40-20",
        ask: "$VNIMU at 40 Hz, averages of 20",
        settings: "--set-message VNIMU --set-rate 40 --window 20",
        minutes: 3,
    },
    Step {
        name: "vnimu-40-4",
        ask: "$VNIMU at 40 Hz, averages of 4",
        settings: "--set-message VNIMU --set-rate 40 --window 4",
        minutes: 3,
    },
    Step {
        name: "packets-200-4",
        ask: "packets at 200 Hz, averages of 4",
        settings: "--set-message BINARY --set-rate 200 --window 4",
        minutes: 3,
    },
    Step {
        name: "packets-200-20",
        ask: "packets at 200 Hz, averages of 20",
        settings: "--set-message BINARY --set-rate 200 --window 20",
        minutes: 2,
    },
    Step {
        name: "packets-800-4",
        ask: "packets at 800 Hz, averages of 4",
        settings: "--set-message BINARY --set-rate 800 --window 4",
        minutes: 3,
    },
    Step {
        name: "unplug",
        ask: "once it is under way, unplug the sensor for five seconds, and plug it in again",
        settings: "",
        minutes: 2,
    },
];

/// The time of all steps together.
const MINUTES: u32 = 20;

pub(crate) fn witness(args: &WitnessArgs) -> Result<Completion> {
    if let Some(kit) = &args.check {
        return findings::check(kit);
    }
    let (Some(source), Some(kit)) = (&args.source, &args.output) else {
        bail!("give a port and -o KIT.zip, or --check KIT.zip")
    };
    if fs::symlink_metadata(kit).is_ok() {
        bail!("{} exists: give the kit another name", kit.display());
    }
    let output = Output::new(kit, false);
    output.check(kit, &[])?;
    let conditions = read_conditions(args.meta.as_deref())?;
    let folder = kit.with_extension("parts");
    fs::create_dir_all(&folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let all_steps = Steps { args, source: &source.to_string(), folder: &folder, conditions: &conditions };
    let is_complete = run_logged(Builder::new_multi_thread().worker_threads(1), &args.link.log, async |log| {
        let stop = stop_on_interrupt(HangUp::Stops)?;
        all_steps.record(&log, &stop).await
    })?;
    if !is_complete {
        return Ok(Completion::Failed);
    }
    let recordings = STEPS.each_ref().map(|step| step.recording(&folder));
    output.write(kit, |file| Kit::pack(file, &recordings, &conditions))?;
    fs::remove_dir_all(&folder).with_context(|| format!("cannot remove {}", folder.display()))?;
    print(&format!("wrote {}; vn100 witness --check {0} says what it settles\n", kit.display()))?;
    Ok(Completion::Complete)
}

impl Step {
    fn recording(&self, folder: &Path) -> PathBuf {
        folder.join(self.name).with_extension("mcap")
    }
}

struct Steps<'a> {
    args: &'a WitnessArgs,
    source: &'a str,
    folder: &'a Path,
    conditions: &'a BTreeMap<String, String>,
}

impl Steps<'_> {
    /// Records the steps that are not recorded yet; `false` if it was interrupted or a step lacks
    /// something.
    async fn record(&self, log: &Entries, stop: &CancellationToken) -> Result<bool> {
        for (number, step) in (1..).zip(&STEPS) {
            let recording = step.recording(self.folder);
            if recording.exists() {
                report(&format!("step {number} of {}, {}: is recorded", STEPS.len(), step.name));
                continue;
            }
            let seconds = self.args.duration.as_secs_f64() * f64::from(step.minutes) / f64::from(MINUTES);
            let length = Duration::from_secs_f64(seconds.max(1.0).round());
            let time = humantime::format_duration(length);
            print(&format!("step {number} of {}, {time}: {}\n", STEPS.len(), step.ask))?;
            if !agreed(stop).await? || !self.record_step(step, length, &recording, log, stop).await? {
                report(&format!("step {number} is not recorded; the same command continues with it"));
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Records a step; `false` if it lacks something.
    async fn record_step(
        &self,
        step: &Step,
        length: Duration,
        recording: &Path,
        log: &Entries,
        stop: &CancellationToken,
    ) -> Result<bool> {
        // an interrupted step begins again
        let part = recording.with_extension("part");
        if part.exists() {
            fs::remove_file(&part).with_context(|| format!("cannot remove {}", part.display()))?;
        }
        let duration = format!("{}s", length.as_secs());
        let line = ["vn100", "record", self.source, "--duration", &duration, "--output"];
        let line = line.map(Into::into).into_iter().chain([part.clone().into_os_string()]);
        let line = line.chain(step.settings.split_whitespace().map(Into::into));
        let Subcommand::Record(record) = Args::try_parse_from(line)?.command else { bail!(FAULT) };
        let mut attach = AttachArgs::from(record);
        attach.live.link = self.args.link.clone();
        let completion =
            attach_all(attach, OutputFormat::Counts, self.conditions.clone(), log.clone(), Some(stop)).await?;
        if completion == Completion::Complete {
            fs::rename(&part, recording).with_context(|| format!("cannot rename {}", part.display()))?;
        }
        Ok(completion == Completion::Complete)
    }
}

/// Waits until the owner is ready, if there is a terminal to say so; `false` if interrupted.
async fn agreed(stop: &CancellationToken) -> Result<bool> {
    if !io::stdin().is_terminal() {
        return Ok(true);
    }
    print("  at rest on something heavy? Enter begins; Ctrl-C ends, finished steps stay\n")?;
    let line = task::spawn_blocking(|| io::stdin().lock().read_line(&mut String::new()));
    let Some(line) = stop.run_until_cancelled(line).await else { return Ok(false) };
    Ok(line.context(FAULT)?? > 0)
}

#[cfg(test)]
mod tests {
    use vn100_capture::{RecordingReader, RecordingWriter};
    use vn100_protocol::stream::{LinkEvent, LinkEventKind, StreamInput};

    use super::*;

    fn args(line: &str) -> WitnessArgs {
        let Subcommand::Witness(args) = Args::try_parse_from(line.split(' ')).unwrap().command else {
            panic!("{line}")
        };
        args
    }

    /// All steps of an emulated sensor, on the paused clock, the first of them before; a kit of them
    /// settles every question, and does not tell the serial number.
    #[tokio::test(start_paused = true)]
    async fn a_kit_of_an_emulated_sensor_settles_what_is_asked() {
        let folder = tempfile::tempdir().unwrap();
        let conditions = BTreeMap::from([("place".to_owned(), "bench".to_owned())]);
        let args = args("vn100 witness sim -o kit.zip -d 5min --quiet");
        let steps = Steps { args: &args, source: "sim", folder: folder.path(), conditions: &conditions };
        let stop = CancellationToken::new();
        let log = Entries::default();
        // an interrupted step, of which a part is there
        fs::write(folder.path().join("vnimu-40-4.part"), "cut").unwrap();
        assert!(
            steps
                .record_step(&STEPS[0], Duration::from_secs(5), &STEPS[0].recording(folder.path()), &log, &stop)
                .await
                .unwrap()
        );
        assert!(steps.record(&log, &stop).await.unwrap());
        let kit = folder.path().join("kit.zip");
        let recordings = STEPS.each_ref().map(|step| step.recording(folder.path()));
        Kit::pack(fs::File::create(&kit).unwrap(), &recordings, &conditions).unwrap();
        let opened = Kit::open(&kit).unwrap();
        for step in &STEPS {
            let recording = fs::read(opened.recording(step.name).unwrap()).unwrap();
            assert!(!recording.windows(10).any(|bytes| bytes == b"0100000001"), "{}", step.name);
        }
        let (told, completion) = findings::of_kit(&opened).await.unwrap();
        assert_eq!((told.matches("\nsettled ").count(), completion), (5, Completion::Complete), "{told}");
        assert!(told.contains("\nopen    replug: nothing was unplugged in its step\n"), "{told}");
        // the last step again, unplugged before its last read
        let mut reader = RecordingReader::open(fs::File::open(&recordings[7]).unwrap()).unwrap();
        let mut inputs: Vec<StreamInput> = std::iter::from_fn(|| reader.next_input().unwrap()).collect();
        let at_ns = inputs
            .iter()
            .rev()
            .find_map(|input| if let StreamInput::Chunk(chunk) = input { chunk.at_ns } else { None });
        let link = |kind| StreamInput::Link(LinkEvent { at_ns: at_ns.unwrap(), kind });
        let up = link(LinkEventKind::Up { port: "sim".into(), baud: None });
        inputs.splice(inputs.len() - 3..inputs.len() - 3, [link(LinkEventKind::Down { cause: "gone".into() }), up]);
        let mut writer = RecordingWriter::new(fs::File::create(&recordings[7]).unwrap(), &BTreeMap::new()).unwrap();
        inputs.iter().for_each(|input| writer.write(input).unwrap());
        writer.finish(None).unwrap();
        Kit::pack(fs::File::create(&kit).unwrap(), &recordings, &conditions).unwrap();
        let (told, _) = findings::of_kit(&Kit::open(&kit).unwrap()).await.unwrap();
        assert!(told.contains("\nsettled replug: the sensor was measured again"), "{told}");
        // too short for N, and long enough for a standard deviation
        for step in STEPS.iter().filter(|step| step.name.starts_with("packets-200")) {
            let length = Duration::from_secs(17);
            assert!(steps.record_step(step, length, &step.recording(folder.path()), &log, &stop).await.unwrap());
        }
        Kit::pack(fs::File::create(&kit).unwrap(), &recordings, &conditions).unwrap();
        let (told, _) = findings::of_kit(&Kit::open(&kit).unwrap()).await.unwrap();
        assert!(told.contains("\nopen    aliasing") && told.contains("\nsettled window"), "{told}");
    }
}
