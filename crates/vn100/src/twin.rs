//! The profile of an emulated sensor: a built-in one, or that of the twin of a measured sensor, by the document of the
//! measurement or by its capture.

use std::{
    fs::File,
    io::Read,
    path::{Path, PathBuf},
    thread,
};

use anyhow::{Context, Result, bail};
use vn100_report::{Document, remedies::remedy_words};
use vn100_sim::Profile;

use crate::{
    args::{FileArgs, SimSensorArgs},
    commands::replay::{Outputs, measure_files},
    exit::report,
    inputs::inputs,
    user_files::evaluation,
};

/// A document of a long record with all its figures has some megabytes.
const MOST_BYTES: u64 = 1 << 28;

/// The profile that the options describe; channels of a measured sensor without noise are reported.
pub(crate) fn profile(args: &SimSensorArgs) -> Result<Profile> {
    let built_in = args.like.to_str().and_then(Profile::named);
    let profile = built_in.map_or_else(|| twin_of(&args.like), Ok)?;
    let thermal = args.thermal.unwrap_or(profile.thermal);
    Ok(Profile { thermal, ..profile })
}

fn twin_of(path: &Path) -> Result<Profile> {
    let context = || format!("no twin of {} ({} are built in)", path.display(), Profile::NAMES.join(" and "));
    let mut text = String::new();
    let is_text = File::open(path).with_context(context)?.take(MOST_BYTES).read_to_string(&mut text).is_ok();
    let document = match is_text && text.trim_start().starts_with('{') {
        true => text,
        false => document_of(path).with_context(context)?,
    };
    let profile = Profile::like(&document).with_context(context)?;
    if !profile.changing.is_empty() {
        let axes = profile.changing.join(", ");
        report(&format!("the level of {axes} changes or follows the temperature: the twin has no slow noise there"));
    }
    let absent: Vec<&str> = profile.absent().collect();
    if !absent.is_empty() {
        report(&format!("{} lacks {}: the twin has no noise there", path.display(), absent.join(", ")));
    }
    Ok(profile)
}

/// The document of a capture, measured as `replay` does: on a thread of its own, since a live command that asks for it
/// may run in a runtime already.
fn document_of(path: &Path) -> Result<String> {
    let measured = thread::scope(|scope| scope.spawn(|| measured(path)).join());
    measured.unwrap_or_else(|_| bail!("internal error: the measurement stopped"))
}

fn measured(path: &Path) -> Result<String> {
    let files = FileArgs { files: vec![PathBuf::from(path)], ..FileArgs::default() };
    let mut documents = Vec::new();
    measure_files(&files, &inputs(&files), evaluation(&files.measure)?, Outputs::default(), |measured| {
        if let Some(error) = &measured.source.error {
            bail!("{error}. Otherwise give its document: `vn100 replay {} --json`, with options", path.display());
        }
        documents.push(serde_json::to_string(&Document::new(&measured, remedy_words))?);
        Ok(())
    })?;
    match documents.len() {
        1 => Ok(documents.remove(0)),
        streams => bail!("{} has {streams} streams, and a twin is of one: give its document", path.display()),
    }
}

#[cfg(test)]
mod tests {
    use vn100_sim::{Generator, Message, capture::write_next};

    use super::*;

    #[tokio::test]
    async fn a_capture_is_measured_within_the_runtime_of_a_live_command() {
        let capture = tempfile::NamedTempFile::new().unwrap();
        let (message, mut bytes) = (Message::named("VNIMU").unwrap(), Vec::new());
        let mut generator = Generator::for_message(&Profile::lab3(), message, 40, 1).unwrap();
        (0..400).for_each(|_| write_next(&mut bytes, message, &mut generator));
        std::fs::write(capture.path(), bytes).unwrap();
        let document = document_of(capture.path()).unwrap();
        assert!(document.contains("\"message\":\"VNIMU\""), "{document}");
    }
}
