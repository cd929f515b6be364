//! The files that a tab has measured.

use std::io::{self, Read};

use serde::Serialize;
use sha2::{Digest, Sha256};
use vn100_analysis::{FileFacts, SourceResult};
use vn100_capture::{Capture, CaptureOptions, StoredFile};
use vn100_report::{Evaluation, built_in_datasheet};

use crate::{
    measure::{Cure, Measured, Stream, measure},
    request::Request,
    sample,
};

/// A longer file is not read once more for its checksum.
const MOST_HASHED_BYTES: u64 = 256 << 20;

/// Bytes that are hashed at once.
const PIECE_BYTES: usize = 256 << 10;

/// The files that were measured, each stream with its result.
#[derive(Debug, Default)]
pub struct Tab {
    /// The results, in the order of the files.
    pub records: Vec<SourceResult>,
    /// Whether files for filters take from the data sheet what a record does not show.
    pub fills_from_datasheet: bool,
    pub(crate) evaluation: Option<Evaluation>,
    pub(crate) asked: String,
    /// What the names of saved files begin with.
    pub(crate) stem: String,
}

/// What the page says of a stream besides its report.
#[derive(Debug, Clone, Serialize)]
pub struct Answer {
    /// Name of the source.
    pub name: String,
    /// Number of samples.
    pub samples: u64,
    /// Why there is no result, or no complete one; `None` if there is.
    pub error: Option<String>,
    /// What the user can say so that the file can be read; `None` if nothing helps.
    pub cure: Option<Cure>,
}

impl Tab {
    /// Measures every stream of a file, and keeps the results; `progress` gets the number of stored
    /// bytes that were read.
    ///
    /// # Errors
    /// In words, if what the user says of the file cannot be used.
    pub fn measure<F: StoredFile + Clone + 'static>(
        &mut self,
        file: &F,
        request: &Request,
        progress: &mut dyn FnMut(u64),
    ) -> Result<Vec<Answer>, String> {
        let (settings, options) = (request.settings()?, request.capture_options()?);
        let evaluation = evaluation(request.datasheet.as_deref())?;
        let topics = Capture::streams_of_file(Box::new(file.clone()), &request.name, &options);
        let is_one_of_several = topics.len() > 1;
        let hashed = digest(file).ok().flatten();
        let mut answers = Vec::new();
        for topic in topics {
            let stream = Stream {
                file: Box::new(file.clone()),
                name: request.name.clone(),
                is_one_of_several,
                options: CaptureOptions { topic, ..options.clone() },
                settings: settings.clone(),
                accept_unchecked: request.accept_unchecked,
            };
            let Measured { result, cure } = measure(stream, progress);
            let mut result = evaluation.complete(result);
            result.source.file.clone_from(&hashed);
            answers.push(Answer {
                name: result.source.name.clone(),
                samples: result.timing.samples,
                error: result.source.error.clone(),
                cure,
            });
            self.records.push(result);
        }
        self.asked = request.asked();
        if self.stem.is_empty() {
            self.stem = request.name.split('.').next().unwrap_or_default().to_owned();
        }
        self.evaluation = Some(evaluation);
        Ok(answers)
    }

    /// Measures the sample that is built in.
    ///
    /// # Errors
    /// In words; none unless this library lacks its sample.
    pub fn measure_sample(&mut self) -> Result<Vec<Answer>, String> {
        let file = sample::sample().ok_or("This page has no sample.")?;
        self.measure(&file, &Request { name: sample::NAME.into(), ..Request::default() }, &mut |_| {})
    }
}

fn evaluation(datasheet: Option<&str>) -> Result<Evaluation, String> {
    let sheet = match datasheet {
        None => None,
        Some(name) => Some(built_in_datasheet(name).ok_or_else(|| format!("There is no data sheet {name}."))?),
    };
    let sheet = sheet.transpose().map_err(|error| error.to_string())?;
    Evaluation::new(sheet, Vec::new(), false).map_err(|error| error.to_string())
}

/// The checksum of a file that is not too long for it.
fn digest(file: &dyn StoredFile) -> io::Result<Option<FileFacts>> {
    let Some(bytes) = file.bytes().filter(|bytes| *bytes <= MOST_HASHED_BYTES) else { return Ok(None) };
    let (mut digest, mut opened, mut piece) = (Sha256::new(), file.open()?, vec![0; PIECE_BYTES]);
    loop {
        let read = opened.read(&mut piece)?;
        if read == 0 {
            break;
        }
        digest.update(&piece[..read]);
    }
    let sha256 = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(Some(FileFacts { bytes, sha256 }))
}
