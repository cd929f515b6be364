//! `vn100 sim`: writes a capture of the emulated sensor.

use std::{
    fs::File,
    io::{self, BufWriter, Write},
    path::Path,
};

use anyhow::{Context, Result, bail};
use vn100_driver::{Chunk, RecordingWriter};
use vn100_sim::{Generator, Profile, sentence::write_sentence, write_capture};

use crate::{args::SimArgs, exit::Exit};

pub(crate) fn sim(args: &SimArgs) -> Result<Exit> {
    let profile = Profile::named(&args.profile)?;
    let mut generator = Generator::new(&profile, args.rate, args.seed)?;
    let samples = (args.duration.as_secs_f64() * f64::from(args.rate)).round() as u64;
    if samples == 0 {
        bail!("a record of {:?} at {} Hz holds no sample: ask for a longer one", args.duration, args.rate);
    }
    if args.output == Path::new("-") {
        write(io::stdout().lock(), &mut generator, samples).context("cannot write to standard output")?;
        return Ok(Exit::Good);
    }
    let context = || format!("cannot write {}", args.output.display());
    let file = if args.force { File::create(&args.output) } else { File::create_new(&args.output) };
    let file = match file {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            bail!("{} exists; --force replaces it", args.output.display())
        }
        file => file.with_context(context)?,
    };
    if args.output.extension().is_some_and(|extension| extension == "mcap") {
        record(file, &mut generator, samples, args).with_context(context)?;
    } else {
        write(file, &mut generator, samples).with_context(context)?;
    }
    Ok(Exit::Good)
}

fn write(out: impl Write, generator: &mut Generator, samples: u64) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(64 * 1024, out);
    write_capture(&mut out, generator, samples)?;
    out.flush()
}

/// Writes each line as a read of its own, at the very time of its sample; the first is at 0.
fn record(file: File, generator: &mut Generator, samples: u64, args: &SimArgs) -> io::Result<()> {
    let recipe =
        [("profile", args.profile.clone()), ("rate_hz", args.rate.to_string()), ("seed", args.seed.to_string())];
    let recipe = recipe.map(|(name, value)| (format!("sim.{name}"), value)).into();
    let mut recording = RecordingWriter::new(file, &recipe)?;
    for sample in 0..samples {
        let mut line = Vec::new();
        write_sentence(&mut line, &generator.next_row());
        let at_ns = i64::try_from(u128::from(sample) * 1_000_000_000 / u128::from(args.rate)).ok();
        recording.write(&Chunk { bytes: line.into(), at_ns }.into())?;
    }
    recording.finish(Some("the record has its length"))?.sync_all()
}
