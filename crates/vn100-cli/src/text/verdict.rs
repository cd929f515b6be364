//! What the measurement says of the data sheet, axis by axis.

use std::fmt::{self, Write};

use imu_noise::{Claim, Verdict};
use vn100_analysis::{FigureVerdict, Motion, Verdicts, letter};
use vn100_report::{
    names::{WHY_CONSISTENT, grade_text, sentence, verdict_name},
    units::ChannelValues,
};

use super::fill;

/// Every figure of the data sheet beside each axis, or why there is none; nothing without a sheet.
pub(super) fn write_verdicts(
    out: &mut String,
    channels: &[ChannelValues],
    verdicts: Option<&Verdicts>,
    motion: Option<&Motion>,
) -> fmt::Result {
    if let Some((verdicts, motion)) = verdicts.zip(motion) {
        let text = format!("data sheet: {}: nothing is compared, {motion}", verdicts.datasheet);
        return writeln!(out, "\n{}", fill(&text, "", "  "));
    }
    let Some(verdicts) = verdicts.filter(|verdicts| verdicts.channels.iter().any(|figures| !figures.is_empty())) else {
        return Ok(());
    };
    let note = verdicts.note.as_ref().map_or(String::new(), |note| format!(" ({note})"));
    writeln!(out, "\n{}", fill(&format!("data sheet: {}{note}", verdicts.datasheet), "", "  "))?;
    for (channel, figures) in channels.iter().zip(&verdicts.channels) {
        let Some(noise) = &channel.noise else { continue };
        for figure in figures {
            let letter = letter(figure.figure.term);
            let text = format!(
                "{:<8} {letter}  {:<14} {}",
                channel.name,
                verdict_name(figure.verdict),
                sentence(noise.sensor, figure)
            );
            writeln!(out, "{}", fill(&text, "", "                           "))?;
        }
    }
    if verdicts.channels.iter().flatten().any(|figure| figure.verdict == Verdict::Consistent) {
        writeln!(out, "{}", fill(&format!("consistent: {WHY_CONSISTENT}"), "", "  "))?;
    }
    let is_single =
        |figure: &FigureVerdict| matches!(figure.figure.claim, Claim::Typical { rounding, .. } if rounding > 0.0);
    if verdicts.channels.iter().flatten().any(is_single) {
        let text = "typically: what many sensors read, and no guarantee. A single figure stands for all that round to it, half a unit of its \
                    last place either way; a sensor beyond fails it";
        writeln!(out, "{}", fill(text, "", "  "))?;
    }
    write_grades(out, channels)
}

fn write_grades(out: &mut String, channels: &[ChannelValues]) -> fmt::Result {
    let graded = channels.iter().filter_map(|channel| Some((&*channel.name, grade_text(channel.noise.as_ref()?)?)));
    let mut told: Vec<(Vec<&str>, String)> = Vec::new();
    for (name, text) in graded {
        match told.iter_mut().find(|(_, same)| *same == text) {
            Some((names, _)) => names.push(name),
            None => told.push((vec![name], text)),
        }
    }
    if told.is_empty() {
        return Ok(());
    }
    let text = format!(
        "grade by bias instability (El-Sheimy and Youssef, 2020: navigation below 0.01 deg/h, tactical to 10, commercial above): {}",
        told.iter().map(|(names, text)| format!("{}: {text}", names.join(" "))).collect::<Vec<_>>().join("; ")
    );
    writeln!(out, "{}", fill(&text, "", "  "))
}
