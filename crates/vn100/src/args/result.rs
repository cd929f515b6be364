//! What a result contains, and how it is written.

use std::path::{Path, PathBuf};

use clap::{ColorChoice, ValueEnum};

/// What the result of one source contains, and in which form.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct ResultArgs {
    /// Colours of the summary
    #[arg(long, value_name = "WHEN", value_enum, default_value_t)]
    pub(crate) color: ColorChoice,

    /// Print one JSON document at the end, and nothing else, on standard output
    #[arg(long, conflicts_with = "ndjson")]
    pub(crate) json: bool,

    /// Print one JSON document per line, for every second of data time and at the end; "thin"
    /// for short ones. A live source without data gives a heartbeat every second by the clock
    #[arg(long, value_name = "FORM", value_enum, num_args = 0..=1, require_equals = true,
        default_missing_value = "whole")]
    pub(crate) ndjson: Option<Ndjson>,

    /// Write the samples as CSV, with the time of each, those skipped too; "-" for standard output,
    /// instead of the result. An existing file is never replaced
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) samples: Option<PathBuf>,
}

impl ResultArgs {
    pub(crate) fn format(&self) -> OutputFormat {
        match (self.json, self.ndjson) {
            (true, _) => OutputFormat::Json,
            (_, Some(form)) => OutputFormat::Ndjson(form),
            _ if self.samples.as_deref() == Some(Path::new("-")) => OutputFormat::Samples,
            _ => OutputFormat::Summary(self.color),
        }
    }

    /// Why these outputs cannot be given together.
    pub(super) fn refused(&self, sources: usize) -> Option<String> {
        let samples = self.samples.as_ref()?;
        if sources > 1 {
            return Some("--samples takes the samples of one source: give one".into());
        }
        let has_other = self.json || self.ndjson.is_some();
        let refusal = "--samples - writes to standard output, where the result would be: name a file";
        (samples == Path::new("-") && has_other).then(|| refusal.into())
    }
}

/// What the lines of a measurement under way hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Ndjson {
    /// All of vn100.analysis/2 that is known so far
    Whole,
    /// vn100.progress/2, less than 2 KB: samples, standard deviations, N, warnings, targets
    Thin,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum OutputFormat {
    /// As the summary, each when it is there.
    Summary(ColorChoice),
    /// As one JSON document at the end.
    Json,
    /// As text: the source, and its warnings.
    Head,
    /// As one line: what a recording has.
    Counts,
    /// Not at all: standard output has the samples.
    Samples,
    /// As JSON documents in lines, written during the measurement.
    Ndjson(Ndjson),
}

impl OutputFormat {
    /// Whether results are text, so that a view may be shown before.
    pub(crate) const fn is_text(&self) -> bool {
        matches!(self, Self::Summary(_))
    }

    /// Whether the sensor is recorded and not measured.
    pub(crate) const fn records_alone(&self) -> bool {
        matches!(self, Self::Head | Self::Counts)
    }

    /// The lines written during the measurement; `None` if there are none.
    pub(crate) const fn lines(&self) -> Option<Ndjson> {
        if let Self::Ndjson(form) = self { Some(*form) } else { None }
    }
}
