//! `vn100 sim`: the emulated sensor on a serial port or at a TCP address, or a capture of it.

#[cfg(target_os = "linux")]
mod pseudo_terminal;
mod tcp;

use std::{
    collections::BTreeMap,
    io::{self, BufWriter, Write},
    path::Path,
    time::Duration,
};

use anyhow::{Context, Result, bail};
use vn100_analysis::Completion;
use vn100_capture::RecordingWriter;
use vn100_protocol::stream::Chunk;
use vn100_sim::{Generator, PacketStream, capture::write_next};

#[cfg(target_os = "linux")]
use self::pseudo_terminal::emulate;
use self::tcp::emulate_at;
use crate::{
    args::{CaptureMessage, SimArgs, refused},
    output::Output,
    twin::profile,
};

/// The length of a capture, unless asked for.
const CAPTURE_DURATION: Duration = Duration::from_secs(60);

pub(crate) fn sim(args: &SimArgs) -> Result<Completion> {
    match (&args.output, args.tcp_address()) {
        (Some(output), _) => capture(args, output),
        (None, Some(address)) => emulate_at(address, args),
        (None, None) => emulate(args),
    }
}

#[cfg(not(target_os = "linux"))]
fn emulate(_: &SimArgs) -> Result<Completion> {
    bail!("--link needs a pseudo-terminal of Linux: --tcp serves the sensor at a TCP address")
}

fn times(openings: u64) -> String {
    if openings == 1 { "once".to_owned() } else { format!("{openings} times") }
}

fn capture(args: &SimArgs, output: &Path) -> Result<Completion> {
    let (truth, seed) = (profile(&args.sensor)?, args.sensor.seed);
    let (duration, rate_hz) = (args.duration.unwrap_or(CAPTURE_DURATION), args.rate.map_or(truth.rate_hz, f64::from));
    if rate_hz.fract() != 0.0 {
        bail!("it was measured at {rate_hz} Hz, which the emulated sensor does not have: give --rate HZ");
    }
    let rate_hz = rate_hz as u32;
    let mut write_frame: Box<WriteFrame> = match args.message {
        CaptureMessage::Sentence(message) => {
            let mut generator = Generator::for_message(&truth, message, rate_hz, seed)?;
            Box::new(move |bytes| write_next(bytes, message, &mut generator))
        }
        CaptureMessage::Packets(packets) => {
            let mut stream = PacketStream::new(&truth, packets, rate_hz, seed)?;
            Box::new(move |bytes| stream.write_next(bytes))
        }
    };
    let samples = (duration.as_secs_f64() * f64::from(rate_hz)).round() as u64;
    if samples == 0 {
        let refusal = format!("a record of {duration:?} at {rate_hz} Hz contains no sample: give a longer duration");
        bail!(refused("sim", &refusal));
    }
    if output == Path::new("-") {
        let mut out = BufWriter::with_capacity(64 * 1024, io::stdout().lock());
        let written = write(&mut out, &mut *write_frame, samples).and_then(|()| out.flush());
        written.context("cannot write to standard output")?;
        return Ok(Completion::Complete);
    }
    let file = Output::new(output, args.existing.force);
    file.check(output, &[])?;
    let thermal = args.sensor.thermal.map(|thermal| ("thermal", format!("{thermal:?}")));
    let recipe = [("profile", truth.name.clone()), ("rate_hz", rate_hz.to_string()), ("seed", seed.to_string())];
    let recipe = recipe.into_iter().chain(thermal).map(|(name, value)| (format!("sim.{name}"), value)).collect();
    let is_recording = output.extension().is_some_and(|extension| extension == "mcap");
    file.write(output, |out| {
        let written = match is_recording {
            true => record(out, &mut *write_frame, samples, rate_hz, &recipe),
            false => write(out, &mut *write_frame, samples),
        };
        Ok(written?)
    })?;
    Ok(Completion::Complete)
}

/// Appends the next sentence or packet.
type WriteFrame = dyn FnMut(&mut Vec<u8>);

fn write(out: &mut impl Write, write_frame: &mut WriteFrame, samples: u64) -> io::Result<()> {
    let mut frame = Vec::new();
    for _ in 0..samples {
        frame.clear();
        write_frame(&mut frame);
        out.write_all(&frame)?;
    }
    Ok(())
}

/// Writes each frame as a read of its own, at the very time of its sample; the first is at 0.
fn record(
    out: &mut impl Write,
    write_frame: &mut WriteFrame,
    samples: u64,
    rate_hz: u32,
    recipe: &BTreeMap<String, String>,
) -> io::Result<()> {
    let mut recording = RecordingWriter::new(out, recipe)?;
    for sample in 0..samples {
        let mut frame = Vec::new();
        write_frame(&mut frame);
        let at_ns = i64::try_from(u128::from(sample) * 1_000_000_000 / u128::from(rate_hz)).ok();
        recording.write(&Chunk { bytes: frame.into(), at_ns }.into())?;
    }
    recording.finish(Some("the record has its length")).map(drop)
}
