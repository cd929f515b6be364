//! What is made of a result once it is there: models for filters, verdicts against a data sheet,
//! and whether the figures that must pass do.

use imu_noise::Verdict;
use vn100_analysis::{Assessment, Datasheet, FigureVerdict, FilterModels, NoiseFigure, Snapshot, Verdicts, not_passed};

use crate::{
    datasheet::{DatasheetError, vn100_datasheet},
    measured::{Completion, Measured},
    verdict_words::{WHY_CONSISTENT, sentence, verdict_name},
};

/// What every result is completed with.
#[derive(Debug, Clone)]
pub struct Evaluation {
    filter_models: bool,
    /// The user's; applies to any sensor.
    datasheet: Option<Datasheet>,
    /// The VN-100's; applies to its messages.
    vn100: Datasheet,
    fail_on: Vec<NoiseFigure>,
}

impl Evaluation {
    /// Compares with `datasheet`, whatever the sensor, or with the VN-100's its own messages; the
    /// figures of `fail_on` must pass.
    ///
    /// # Errors
    /// None, unless this program was built with a damaged sheet.
    pub fn new(datasheet: Option<Datasheet>, fail_on: Vec<NoiseFigure>) -> Result<Self, DatasheetError> {
        Ok(Self { filter_models: false, datasheet, vn100: vn100_datasheet()?, fail_on })
    }

    /// With models for filters, if these are asked for.
    #[must_use]
    pub fn with_filter_models(self, filter_models: bool) -> Self {
        Self { filter_models, ..self }
    }

    /// Adds what was asked for; where a figure that must pass does not, the result is not what was
    /// to be met.
    #[must_use]
    pub fn complete(&self, mut measured: Measured) -> Measured {
        let (snapshot, assessment) = (&measured.snapshot, &measured.assessment);
        measured.verdicts = self.verdicts(snapshot, assessment);
        if self.filter_models {
            measured.filter_models = FilterModels::of(snapshot, &assessment.channels, assessment.confidence);
        }
        // a source that gave nothing has failed worse
        let gave_nothing = measured.completion == Completion::NoData;
        for figure in self.fail_on.iter().filter(|_| !gave_nothing) {
            let channels = measured.verdicts.as_ref().map_or(&[][..], |verdicts| &verdicts.channels);
            let reasons = not_passed(figure, &measured.snapshot, channels);
            if !reasons.is_empty() {
                let reasons: Vec<_> = match &measured.assessment.motion {
                    Some(motion) => vec![motion.to_string()],
                    None => reasons.iter().map(|(name, verdict)| reason(name, *verdict)).collect(),
                };
                let text = format!("{}: {figure} does not pass: {}", measured.facts.name, reasons.join(". "));
                measured.unmet.push(text);
                measured.completion = measured.completion.max(Completion::NotMet);
            }
        }
        measured
    }

    /// Verdicts on all channels; `None` without a data sheet for the sensor.
    #[must_use]
    pub fn verdicts(&self, snapshot: &Snapshot, assessment: &Assessment) -> Option<Verdicts> {
        let is_vn100 = snapshot.layout.as_ref().is_some_and(|layout| layout.message.starts_with("VN"));
        let sheet = self.datasheet.as_ref().or_else(|| is_vn100.then_some(&self.vn100));
        sheet.map(|sheet| sheet.verdicts(snapshot, assessment))
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
