//! What is made of a result once it is there: models for filters, verdicts against a data sheet,
//! and whether the command has failed by them.

use anyhow::Result;
use imu_noise::Verdict;
use vn100_analysis::{Assessment, Datasheet, Figure, FigureVerdict, FilterModels, Snapshot, not_passed};

use crate::{
    args::MeasureArgs,
    datasheet,
    exit::Exit,
    measured::{Measured, Verdicts},
    text::verdict_words::{WHY_CONSISTENT, sentence, verdict_name},
};

/// What the user asked for.
pub(crate) struct Judging {
    filter_models: bool,
    /// The user's; applies to any sensor.
    datasheet: Option<Datasheet>,
    /// The VN-100's; applies to its messages.
    vn100: Datasheet,
    fail_on: Vec<Figure>,
}

impl Judging {
    /// # Errors
    /// When the data sheet cannot be read.
    pub(crate) fn new(args: &MeasureArgs) -> Result<Self> {
        Ok(Self {
            filter_models: false,
            datasheet: args.datasheet.as_deref().map(datasheet::open).transpose()?,
            vn100: datasheet::vn100()?,
            fail_on: args.fail_on.clone(),
        })
    }

    /// With models for filters, if these are asked for.
    pub(crate) fn with_filter_models(self, filter_models: bool) -> Self {
        Self { filter_models, ..self }
    }

    /// Adds what was asked for, and fails the command where a figure that must pass does not.
    pub(crate) fn complete(&self, mut measured: Measured) -> Measured {
        let (snapshot, assessment) = (&measured.snapshot, &measured.assessment);
        measured.verdicts = self.verdicts(snapshot, assessment);
        if self.filter_models {
            measured.filter_models = FilterModels::of(snapshot, &assessment.channels, assessment.confidence);
        }
        // a source that gave nothing has failed worse
        let gave_nothing = measured.exit == Exit::NoData;
        for figure in self.fail_on.iter().filter(|_| !gave_nothing) {
            let channels = measured.verdicts.as_ref().map_or(&[][..], |verdicts| &verdicts.channels);
            let reasons = not_passed(figure, &measured.snapshot, channels);
            if !reasons.is_empty() {
                let told: Vec<_> = match &measured.assessment.motion {
                    Some(motion) => vec![motion.to_string()],
                    None => reasons.iter().map(|(name, verdict)| reason(name, *verdict)).collect(),
                };
                measured.unmet.push(format!("{}: {figure} does not pass: {}", measured.origin.name, told.join(". ")));
                measured.exit = measured.exit.max(Exit::NotMet);
            }
        }
        measured
    }

    /// Verdicts on all channels; `None` without a data sheet for the sensor.
    pub(crate) fn verdicts(&self, snapshot: &Snapshot, assessment: &Assessment) -> Option<Verdicts> {
        let is_vn100 = snapshot.layout.as_ref().is_some_and(|layout| layout.message.starts_with("VN"));
        let sheet = self.datasheet.as_ref().or_else(|| is_vn100.then_some(&self.vn100));
        sheet.map(|sheet| Verdicts {
            datasheet: sheet.name.clone(),
            note: sheet.note.clone(),
            channels: sheet.judge(snapshot, assessment),
        })
    }
}

fn reason(name: &str, verdict: Option<&FigureVerdict>) -> String {
    match verdict {
        Some(judged) => {
            let why = if judged.verdict == Verdict::Consistent { format!(": {WHY_CONSISTENT}") } else { String::new() };
            format!("{name} is {}, {}{why}", verdict_name(judged.verdict), sentence(judged.figure.sensor, judged))
        }
        None => format!("{name} has no such figure in the data sheet, or is not in the stream"),
    }
}
