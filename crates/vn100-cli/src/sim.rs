//! `vn100 sim`: writes a capture of the emulated sensor.

use std::{
    fs::File,
    io::{self, BufWriter, Write},
    path::Path,
};

use anyhow::{Context, Result, bail};
use vn100_sim::{Generator, Profile, write_capture};

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
    write(file, &mut generator, samples).with_context(context)?;
    Ok(Exit::Good)
}

fn write(out: impl Write, generator: &mut Generator, samples: u64) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(64 * 1024, out);
    write_capture(&mut out, generator, samples)?;
    out.flush()
}
