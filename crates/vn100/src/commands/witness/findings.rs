//! What the recordings of a kit settle about the sensor.

use std::{
    fmt::{self, Write},
    path::Path,
    sync::Arc,
};

use anyhow::{Context, Result};
use imu_noise::Term;
use tokio::runtime::Builder;
use vn100_analysis::{ChannelResult, Completion, SourceResult};
use vn100_session::{ReplaySpec, Session};

use super::{STEPS, Step, kit::Kit};
use crate::{
    args::MeasureArgs,
    exit::{print, unless_closed},
    result::{FAULT, evaluated_replay},
    text::{counts, fill, text},
    user_files::evaluation,
};

const GYRO: [&str; 3] = ["gyro_x", "gyro_y", "gyro_z"];

/// The noise density that the data sheet of the sensor gives for the gyroscope, in deg/s/sqrt(Hz).
const SHEET_DENSITY: f64 = 0.0035;

/// Measures the recordings of a kit, and says what they settle.
pub(super) fn check(path: &Path) -> Result<Completion> {
    let kit = Kit::open(path)?;
    let runtime = Builder::new_multi_thread().enable_all().build().context("cannot start the worker threads")?;
    let (told, completion) = runtime.block_on(of_kit(&kit))?;
    unless_closed(print(&told))?;
    Ok(completion)
}

/// The text, and whether all steps have samples.
pub(super) async fn of_kit(kit: &Kit) -> Result<(String, Completion)> {
    let evaluation = Arc::new(evaluation(&MeasureArgs::default())?);
    let mut measured = Vec::new();
    for Step { name, .. } in &STEPS {
        let result = match kit.recording(name) {
            Some(recording) => {
                let result = Session::replay(ReplaySpec::of(recording)).result.await.context(FAULT)?;
                Some(evaluated_replay(result, &evaluation, false).await?)
            }
            None => None,
        };
        measured.push((*name, result));
    }
    let told = text(|out| write_findings(out, kit, &measured));
    let is_whole = measured.iter().all(|(_, result)| result.as_ref().is_some_and(|result| result.timing.samples > 0));
    Ok((told, if is_whole { Completion::Complete } else { Completion::Failed }))
}

fn write_findings(out: &mut String, kit: &Kit, measured: &[(&str, Option<SourceResult>)]) -> fmt::Result {
    let of = |name: &str| measured.iter().find(|(step, _)| *step == name)?.1.as_ref();
    let sensor: Vec<String> = kit.manifest.sensor.iter().map(|(name, value)| format!("{name} {value}")).collect();
    writeln!(
        out,
        "{}",
        if sensor.is_empty() { "the sensor did not say what it is".into() } else { sensor.join(", ") }
    )?;
    for (step, result) in measured {
        let counts = result.as_ref().map_or("not in the kit".into(), counts);
        writeln!(out, "  {step:<16}{counts}")?;
    }
    for Finding { question, is_settled, answer } in [
        aliasing(of("vnimu-40-4"), of("packets-200-4")),
        averaging(of("packets-200-4"), of("packets-200-20")),
        density(of("vnimu-40-20")),
        bias_tracking(of("vnymr-40-20"), of("vnimu-40-20")),
        low_pass(of("packets-800-4")),
        reconnection(of("unplug")),
    ] {
        let verdict = if is_settled { "settled" } else { "open" };
        writeln!(out, "{}", fill(&format!("{verdict:<8}{question}: {answer}"), "", "        "))?;
    }
    Ok(())
}

struct Finding {
    question: &'static str,
    is_settled: bool,
    answer: String,
}

/// The finding whose answer is one of two, each with the number that it predicts; settled if all axes
/// are within a tenth of one prediction.
fn nearest(question: &'static str, what: &str, numbers: Option<[f64; 3]>, answers: &[(f64, &str)]) -> Finding {
    let Some(numbers) = numbers else {
        return Finding {
            question,
            is_settled: false,
            answer: format!("{what} is not known to a tenth on all three axes"),
        };
    };
    let fits = |predicted: f64| numbers.iter().all(|number| (number / predicted - 1.0).abs() < 0.1);
    let [x, y, z] = numbers;
    let found = answers.iter().find(|(predicted, _)| fits(*predicted));
    let predictions: Vec<String> =
        answers.iter().map(|(predicted, answer)| format!("{predicted:.2} if {answer}")).collect();
    let answer = found.map_or("neither".into(), |(_, answer)| (*answer).to_owned());
    let answer = format!("{answer}; {what} is {x:.2}, {y:.2}, {z:.2} ({})", predictions.join(", "));
    Finding { question, is_settled: found.is_some(), answer }
}

fn per_axis(of: impl Fn(&str) -> Option<f64>) -> Option<[f64; 3]> {
    let [x, y, z] = GYRO.map(of);
    Some([x?, y?, z?])
}

fn channel<'a>(result: Option<&'a SourceResult>, name: &str) -> Option<&'a ChannelResult> {
    result?.channels.iter().find(|channel| channel.name == name)
}

/// N, if it is known to a tenth.
fn white(result: Option<&SourceResult>, name: &str) -> Option<f64> {
    let white = channel(result, name)?.noise.as_ref()?.parameter(Term::White)?;
    let value = white.value?;
    (white.upper? - white.lower? < 0.2 * value).then_some(value)
}

/// The standard deviation, if as many averages as do not overlap, of 20 refreshes of 800 Hz, give a
/// deviation to a tenth: N, of longer ones, may not be known.
fn std(result: Option<&SourceResult>, name: &str) -> Option<f64> {
    let channel = channel(result, name)?;
    let apart = channel.allan.points.iter().find(|point| point.tau_s >= 20.0 / 800.0)?;
    let is_known = apart.upper? - apart.lower? < 0.2 * apart.deviation?;
    channel.statistics.std.filter(|_| is_known)
}

/// A slow stream of a short window has the noise of the samples that are left out, folded into it.
fn aliasing(slow: Option<&SourceResult>, fast: Option<&SourceResult>) -> Finding {
    let ratio = per_axis(|axis| Some(white(slow, axis)? / white(fast, axis)?));
    let answers = [(5_f64.sqrt(), "samples are left out, and N is aliased"), (1.0, "all samples are averaged")];
    nearest("aliasing at 40 Hz", "N at 40 Hz over N at 200 Hz, both with a window of 4,", ratio, &answers)
}

fn averaging(short: Option<&SourceResult>, long: Option<&SourceResult>) -> Finding {
    let ratio = per_axis(|axis| Some(std(short, axis)? / std(long, axis)?));
    let answers = [(5_f64.sqrt(), "the window averages white noise"), (1.0, "the window has no effect")];
    nearest("window", "the standard deviation with a window of 4 over that with 20, at 200 Hz,", ratio, &answers)
}

fn density(unaliased: Option<&SourceResult>) -> Finding {
    let ratio = per_axis(|axis| Some(white(unaliased, axis)?.to_degrees() / SHEET_DENSITY));
    let answers = [(1.0, "its density is N"), (0.5_f64.sqrt(), "its density is one-sided")];
    nearest("density of the data sheet", "N over the 0.0035 deg/s/sqrt(Hz) of the sheet", ratio, &answers)
}

/// A message that is compensated has no constant rate.
fn bias_tracking(tracked: Option<&SourceResult>, plain: Option<&SourceResult>) -> Finding {
    let question = "bias tracking in $VNYMR";
    let mean = |result, axis: &str| Some(channel(result, axis)?.statistics.mean?.to_degrees());
    let (Some(tracked), Some(plain)) = (per_axis(|axis| mean(tracked, axis)), per_axis(|axis| mean(plain, axis)))
    else {
        return Finding { question, is_settled: false, answer: "a mean is not known on all three axes".into() };
    };
    let largest = |means: [f64; 3]| means.into_iter().map(f64::abs).fold(0.0, f64::max);
    let (tracked, plain) = (largest(tracked), largest(plain));
    let (is_settled, answer) = match tracked / plain {
        ratio if ratio < 0.1 => (true, "its rates are compensated"),
        ratio if (0.8..1.25).contains(&ratio) => (true, "its rates are not compensated"),
        _ => (false, "neither"),
    };
    let answer = format!("{answer}; the largest mean rate is {tracked:.4} deg/s beside {plain:.4} of $VNIMU");
    Finding { question, is_settled, answer }
}

/// A step in which nothing was unplugged says nothing of it.
fn reconnection(unplugged: Option<&SourceResult>) -> Finding {
    let reconnects = unplugged.map_or(0, |result| result.link.reconnects);
    let answer = match reconnects {
        0 => "nothing was unplugged in its step".into(),
        1 => "the sensor was measured again after it was plugged in".into(),
        times => format!("the sensor was lost and measured again {times} times"),
    };
    Finding { question: "replug", is_settled: reconnects > 0, answer }
}

/// The share of the variance that a sample does not have in common with the next, which a window of
/// four white samples at the same rate makes 1/4.
fn low_pass(fast: Option<&SourceResult>) -> Finding {
    let share = per_axis(|axis| {
        let deviation = channel(fast, axis)?.allan.points.first().filter(|point| point.m == 1)?.deviation?;
        Some((deviation / std(fast, axis)?).powi(2))
    });
    let question = "low pass at 800 Hz";
    let Some([x, y, z]) = share else {
        return Finding {
            question,
            is_settled: false,
            answer: "the correlation is not known to a tenth on all three axes".into(),
        };
    };
    let all = |is_so: fn(f64) -> bool| [x, y, z].into_iter().all(is_so);
    let (is_settled, answer) = match () {
        () if all(|share| (share - 0.25).abs() < 0.025) => (true, "there is the window alone"),
        () if all(|share| share < 0.225) => (true, "a low pass is there beside the window"),
        () => (false, "neither the window alone nor a low pass beside it"),
    };
    let answer =
        format!("{answer}; 1 less the correlation of neighbours is {x:.2}, {y:.2}, {z:.2} (0.25 of the window)");
    Finding { question, is_settled, answer }
}
