//! The data sheet and the requirements that a result is judged by.

use vn100_analysis::noise::Claim;
use vn100_analysis::protocol::{BINARY, Quantity};
use vn100_analysis::{Completion, Datasheet, DatasheetFigure, FigureVerdict, NoiseFigure, SourceResult};

use crate::{
    FilterNoise,
    datasheet::{DatasheetError, built_in::vn100_datasheet},
    names::{motion_text, sentence, verdict_name},
};

/// The data sheet and requirements that every result is completed with.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// The user's; applies to any sensor.
    datasheet: Option<Datasheet>,
    /// The VN-100's; applies to its messages.
    vn100: Datasheet,
    fail_on: Vec<NoiseFigure>,
    has_verdicts_only: bool,
}

impl Evaluation {
    /// Compares with `datasheet`, whatever the sensor is; without one, compares VectorNav sentences
    /// and packets with the data sheet of the VN-100, except those of a sensor that reports another
    /// model. The parameters `fail_on` must pass. If `typical_is_limit`, typical figures pass and fail, too.
    ///
    /// # Errors
    /// None, unless this program was built with an invalid data sheet.
    pub fn new(
        datasheet: Option<Datasheet>,
        fail_on: Vec<NoiseFigure>,
        typical_is_limit: bool,
    ) -> Result<Self, DatasheetError> {
        let judged = |sheet| Datasheet { typical_is_limit, ..sheet };
        let vn100 = judged(vn100_datasheet()?);
        Ok(Self { datasheet: datasheet.map(judged), vn100, fail_on, has_verdicts_only: false })
    }

    /// The same for results of which nobody reads what record would decide a verdict: that takes most of the
    /// time of a short record.
    pub fn verdicts_only(self) -> Self {
        Self { has_verdicts_only: true, ..self }
    }

    /// The parameters that must pass and have no limit in the sheet, each with the name of the sheet.
    pub fn not_deciding(&self) -> impl Iterator<Item = (&NoiseFigure, &str)> {
        let sheet = self.datasheet.as_ref().unwrap_or(&self.vn100);
        let without_limit = self.fail_on.iter().filter(move |asked| {
            let concerns = |figure: &&DatasheetFigure| (figure.sensor, figure.term) == (asked.sensor, asked.term);
            let mut figures = sheet.figures.iter().filter(concerns).peekable();
            let has_some = figures.peek().is_some();
            has_some && !sheet.typical_is_limit && figures.all(|figure| matches!(figure.claim, Claim::Typical { .. }))
        });
        without_limit.map(|asked| (asked, sheet.name.as_str()))
    }

    /// Adds verdicts, and to `unmet` each parameter that must pass and does not; one whose channel is
    /// in another stream of the file must pass there.
    pub fn complete(&self, mut result: SourceResult) -> SourceResult {
        self.judge(&mut result);
        // a source that gave nothing has failed worse
        let gave_nothing = result.completion == Completion::NoData;
        let is_asked = |figure: &&NoiseFigure| !gave_nothing && !result.is_elsewhere(figure);
        for figure in self.fail_on.iter().filter(is_asked).collect::<Vec<_>>() {
            let failed = result.not_passed(figure);
            if !failed.is_empty() {
                let reasons: Vec<_> = match &result.motion {
                    Some(motion) => vec![motion_text(motion)],
                    None => {
                        let absent = why_absent(figure, &result);
                        failed.iter().map(|(name, verdict)| reason(name, *verdict, absent)).collect()
                    }
                };
                let text = format!("{}: {figure} does not pass: {}", result.source.name, reasons.join(". "));
                result.unmet.push(text);
                result.completion = result.completion.max(Completion::NotMet);
            }
        }
        result
    }

    /// Adds the verdicts on all channels; none without a data sheet for the sensor.
    pub fn judge(&self, result: &mut SourceResult) {
        if let Some(sheet) = self.sheet_of(result) {
            result.judge(sheet);
            if !self.has_verdicts_only {
                result.find_deciding_records();
            }
        }
    }

    /// Takes from the data sheet of a source what its record does not show of the values for a filter;
    /// white noise with the most aliasing that is known of the stream.
    pub fn fill(&self, noise: &mut FilterNoise, result: &SourceResult) {
        let Some(sheet) = self.sheet_of(result) else { return noise.lacks_datasheet() };
        let onboard = result.of(Quantity::AngularRate).first().and_then(|axis| axis.onboard);
        noise.fill(sheet, onboard.map_or(1.0, |onboard| onboard.window.white_factor().max(1.0)));
    }

    fn sheet_of(&self, result: &SourceResult) -> Option<&Datasheet> {
        self.datasheet.as_ref().or_else(|| is_of_vn100(result).then_some(&self.vn100))
    }
}

/// Whether the samples are those of a VN-100, by its own word or by its messages.
pub(crate) fn is_of_vn100(result: &SourceResult) -> bool {
    let model = result.source.device.as_ref().and_then(|device| device.model.as_ref());
    let message = result.source.message.as_deref().unwrap_or_default();
    match model {
        Some(model) => model.starts_with("VN-100"),
        None => (message.starts_with("VN") || message == BINARY) && result.link.other_model.is_none(),
    }
}

fn reason(name: &str, verdict: Option<&FigureVerdict>, absent: &str) -> String {
    match verdict {
        Some(judged) => format!("{name} is {}, {}", verdict_name(judged), sentence(judged.figure.sensor, judged)),
        None => format!("{name} {absent}"),
    }
}

/// Why nothing is decided on a figure.
fn why_absent(figure: &NoiseFigure, result: &SourceResult) -> &'static str {
    if !result.has_channel_of(figure) {
        "is not in the stream"
    } else if result.datasheet.is_none() {
        "cannot be compared: the sensor is not known to be a VN-100, and no other data sheet is given"
    } else {
        "has no limit in the data sheet"
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vn100_analysis::protocol::{PACKET_MESSAGES, Register, VNIMU, stream::MessageName};

    use super::*;
    use crate::tests::fixture::{facts, nothing, result};

    #[test]
    fn packets_are_compared_unless_the_sensor_says_it_is_another() {
        let evaluation = Evaluation::new(None, Vec::new(), false).unwrap();
        let by_model = [(None, true), (Some("VN-100S-CR"), true), (Some("VN-200T-CR"), false)];
        let layouts = [PACKET_MESSAGES[0].layout(), Some(Arc::new(VNIMU.clone()))];
        for (layout, (model, is_compared)) in layouts.iter().flat_map(|layout| by_model.map(|model| (layout, model))) {
            let mut snapshot = nothing();
            snapshot.layout.clone_from(layout);
            snapshot.registers.extend(model.map(|model| (Register::MODEL.0, model.into())));
            let is_judged = |snapshot| {
                let mut result = result(facts("a"), snapshot);
                evaluation.judge(&mut result);
                result.datasheet.is_some()
            };
            assert_eq!(is_judged(snapshot.clone()), is_compared, "{model:?}");
            // sentences that no VN-100 sends
            snapshot.link.other_model = Some(MessageName::new(b"VNINS"));
            assert_eq!(is_judged(snapshot), model == Some("VN-100S-CR"), "{model:?}");
        }
    }

    #[test]
    fn what_is_not_decided_on_has_one_reason() {
        let figure = "mag N".parse().unwrap();
        assert_eq!(why_absent(&figure, &result(facts("a"), nothing())), "is not in the stream");
        let mut snapshot = nothing();
        snapshot.layout = Some(Arc::new(VNIMU.clone()));
        let mut result = result(facts("a"), snapshot);
        assert!(why_absent(&figure, &result).starts_with("cannot be compared"));
        Evaluation::new(None, Vec::new(), false).unwrap().judge(&mut result);
        assert_eq!(why_absent(&figure, &result), "has no limit in the data sheet");
    }
}
