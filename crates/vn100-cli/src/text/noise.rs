//! The noise parameters as tables: one for each sensor, its axes side by side, every unit in use
//! below the interval; and what the measurement says of
//! the data sheet.

use std::fmt::{self, Write};

use imu_noise::{
    Claim, Convention, Deviation, FitQuality, Parameter, Sensor, Sides, Term, Verdict, conventions,
    temperature_conventions,
};
use vn100_analysis::{
    Assessment, AxisTemperature, ChannelNoise, DetectableRrw, FigureVerdict, LongTauValidity, Motion, Remedy,
    StreamUnknown, Verdicts, letter,
};
use vn100_report::{
    names::{
        ParameterNames, TERMS, WHY_UNDECIDABLE, budget_rows, grade_scheme, grade_text, in_words, names_of,
        parameter_names, sentence, shown_in, verdict_name,
    },
    numbers::plain::{digits, four_digits, p_value, short},
    temperature::{coefficient_parameter, lag_text, share_text},
    units::{ChannelValues, si_unit},
};

use super::{fill, row};
use vn100_words::remedy_words;

/// Name, short name and symbol: `Angle Random Walk (ARW) N`.
pub(crate) fn parameter_name(sensor: Sensor, term: Term) -> String {
    let ParameterNames { name, short, symbol, .. } = parameter_names(sensor, term);
    let short = if short.is_empty() { String::new() } else { format!(" ({short})") };
    format!("{name}{short} {symbol}")
}

/// The same with its slope: `Angle Random Walk (ARW) N, slope -1/2`.
pub(super) fn title(sensor: Sensor, term: Term) -> String {
    format!("{}, slope {}", parameter_name(sensor, term), parameter_names(sensor, term).slope)
}

/// Everything known of the noise of all axes; nothing for a stream without one.
pub(super) fn write_noise(
    out: &mut String,
    channels: &[ChannelValues],
    assessment: &Assessment,
    (deviation, rate_hz): (Deviation, f64),
) -> fmt::Result {
    let axes: Vec<(&ChannelValues, &ChannelNoise)> =
        channels.iter().filter_map(|channel| Some((channel, channel.noise.as_ref()?))).collect();
    if assessment.motion.is_some() && !axes.is_empty() {
        writeln!(out, "\n{}", fill(Motion::MEANING, "", ""))?;
    }
    for group in axes.chunk_by(|(a, _), (b, _)| a.quantity == b.quantity) {
        let level = short(100.0 * assessment.confidence);
        writeln!(
            out,
            "\n{}: noise parameters, {level} % confidence intervals; * one-sided",
            names_of(group[0].0.quantity).title
        )?;
        row(out, "", group, |(channel, _)| channel.name.clone())?;
        for term in TERMS {
            if group.iter().any(|(_, noise)| noise.parameter(term).is_some()) {
                writeln!(out, "{}", title(group[0].1.sensor, term))?;
                write_parameter(out, group, term)?;
            }
            match term {
                Term::White => write_budget(out, group, rate_hz)?,
                Term::BiasInstability | Term::RateRandomWalk | Term::RateRamp => write_p(out, group, term)?,
                Term::Quantization => {}
            }
            if term == Term::BiasInstability {
                write_minimum(out, group)?;
            }
            if term == Term::RateRandomWalk {
                write_visible(out, group)?;
            }
        }
        write_temperature(out, group)?;
        write_quality(out, group)?;
        write_classical(out, group, deviation)?;
        if let Some(reason) = reason(group[0].1.long_taus) {
            writeln!(out, "{}", fill(reason, "  ", "  "))?;
        }
    }
    Ok(())
}

type AxisNoise<'a> = (&'a ChannelValues, &'a ChannelNoise);

fn write_parameter(out: &mut String, group: &[AxisNoise<'_>], term: Term) -> fmt::Result {
    let parameters: Vec<Option<Parameter>> = group.iter().map(|(_, noise)| noise.parameter(term)).collect();
    write_in_units(out, &parameters, conventions(group[0].1.sensor, term), "  status")
}

fn write_in_units(out: &mut String, parameters: &[Option<Parameter>], units: &[Convention], name: &str) -> fmt::Result {
    let says = |of: fn(&Parameter) -> Option<f64>| parameters.iter().flatten().any(|parameter| of(parameter).is_some());
    row(out, name, parameters, |parameter| {
        parameter.map_or("-".into(), |parameter| in_words(parameter.status).into())
    })?;
    if says(|parameter| parameter.value.or(parameter.upper)) {
        for (index, convention) in units.iter().enumerate() {
            let label = match convention.sides {
                Some(Sides::One) => format!("  {} *", convention.unit),
                _ => format!("  {}", convention.unit),
            };
            row(out, &label, parameters, |parameter| {
                parameter.map_or("-".into(), |parameter| match (parameter.value, parameter.upper) {
                    (Some(value), _) => four_digits(value * convention.factor),
                    (None, Some(upper)) => format!("<= {}", four_digits(upper * convention.factor)),
                    (None, None) => "-".into(),
                })
            })?;
            if index == 0 {
                write_interval(out, parameters)?;
            }
        }
    }
    Ok(())
}

/// How probable as much of a slow term is without it, beside each estimate.
fn write_p(out: &mut String, group: &[AxisNoise<'_>], term: Term) -> fmt::Result {
    let p = |(_, noise): &AxisNoise<'_>| noise.parameter(term).filter(|found| found.value.is_some())?.p;
    if group.iter().all(|axis| p(axis).is_none()) {
        return Ok(());
    }
    row(out, "  p without it", group, |axis| p(axis).map_or("-".into(), p_value))
}

fn write_budget(out: &mut String, group: &[AxisNoise<'_>], rate_hz: f64) -> fmt::Result {
    if group.iter().all(|(_, noise)| noise.white_budget.sampling.is_none()) {
        return Ok(());
    }
    row(out, "  uncertainty of N, %", group, |_| String::new())?;
    row(out, "    sampling", group, |(_, noise)| {
        noise
            .white_budget
            .sampling
            .map_or("-".into(), |(below, above)| format!("-{} +{}", digits(100.0 * below, 2), digits(100.0 * above, 2)))
    })?;
    for (what, amount) in budget_rows(&group[0].1.white_budget, rate_hz) {
        writeln!(out, "{}", fill(&format!("{what}: {amount}"), "    ", "      "))?;
    }
    Ok(())
}

/// The ends of the intervals, where an axis has an estimate.
fn write_interval(out: &mut String, parameters: &[Option<Parameter>]) -> fmt::Result {
    let estimates = parameters.iter().map(|parameter| parameter.filter(|parameter| parameter.value.is_some()));
    let estimates: Vec<Option<Parameter>> = estimates.collect();
    if estimates.iter().all(Option::is_none) {
        return Ok(());
    }
    let end = |value: Option<f64>| value.map_or("-".into(), four_digits);
    row(out, "    lower", &estimates, |estimate| end(estimate.and_then(|estimate| estimate.lower)))?;
    row(out, "    upper", &estimates, |estimate| end(estimate.and_then(|estimate| estimate.upper)))
}

/// In-run bias stability, as data sheets have it.
fn write_minimum(out: &mut String, group: &[AxisNoise<'_>]) -> fmt::Result {
    let minima: Vec<Option<Parameter>> = group.iter().map(|(_, noise)| noise.curve_minimum()).collect();
    if minima.iter().flatten().all(|minimum| minimum.value.or(minimum.upper).is_none()) {
        return Ok(());
    }
    write_in_units(out, &minima, conventions(group[0].1.sensor, Term::BiasInstability), "minimum of the curve")
}

fn write_visible(out: &mut String, group: &[AxisNoise<'_>]) -> fmt::Result {
    if group.iter().all(|(_, noise)| noise.detectable_rrw.is_none()) {
        return Ok(());
    }
    let label = format!("  detectable, +{} h", short(DetectableRrw::MORE_S / 3600.0));
    row(out, &label, group, |(_, noise)| {
        noise.detectable_rrw.map_or("-".into(), |later| format!(">= {}", four_digits(later.at_least)))
    })
}

/// How the bias follows the temperature, where the record has it.
fn write_temperature(out: &mut String, group: &[AxisNoise<'_>]) -> fmt::Result {
    let known = |(_, noise): &AxisNoise<'_>| noise.temperature.clone();
    let all: Vec<Option<AxisTemperature>> = group.iter().map(known).collect();
    if all.iter().all(Option::is_none) {
        return Ok(());
    }
    let parameters: Vec<Option<Parameter>> = all.iter().map(|axis| axis.as_ref().map(coefficient_parameter)).collect();
    write_in_units(out, &parameters, temperature_conventions(group[0].1.sensor), "temperature coefficient")?;
    let found = |axis: &Option<AxisTemperature>| axis.as_ref()?.coefficient.ok();
    if all.iter().any(|axis| found(axis).is_some()) {
        let cell = |text: Option<String>| text.unwrap_or_else(|| "-".into());
        row(out, "  lag (s)", &all, |axis| cell(axis.as_ref().and_then(lag_text)))?;
        row(out, "  p without it", &all, |axis| cell(found(axis).map(|found| p_value(found.p))))?;
        row(out, "  largest share, %", &all, |axis| cell(axis.as_ref().and_then(share_text)))?;
    }
    match all.iter().find_map(|axis| axis.as_ref()?.coefficient.err()) {
        Some(why) => writeln!(out, "{}", fill(&format!("no temperature coefficient: {why}"), "  ", "  ")),
        None => Ok(()),
    }
}

fn write_quality(out: &mut String, group: &[AxisNoise<'_>]) -> fmt::Result {
    type CellText = fn(&FitQuality) -> String;
    let cells: [(&str, CellText); 4] = [
        ("fitted from tau (s)", |quality| short(quality.tau_min_s)),
        ("  to tau (s)", |quality| short(quality.tau_max_s)),
        ("  chi2 / dof", |quality| format!("{:.1} / {}", quality.chi2, quality.dof)),
        ("  goodness of fit, p", |quality| format!("{:.2}", quality.p)),
    ];
    cells.into_iter().try_for_each(|(label, cell)| {
        row(out, label, group, |(_, noise)| noise.fit.quality.as_ref().map_or("-".into(), cell))
    })
}

/// For comparison with older reports.
fn write_classical(out: &mut String, group: &[AxisNoise<'_>], deviation: Deviation) -> fmt::Result {
    let sensor = group[0].1.sensor;
    if sensor == Sensor::Magnetometer {
        return Ok(());
    }
    if deviation == Deviation::Hadamard {
        let text = "No values by the graphical method: it is one of the Allan deviation.";
        return writeln!(out, "{}", fill(text, "  ", "  "));
    }
    row(out, "graphical method", group, |_| String::new())?;
    let rules = [
        (Term::White, "  N, slope -1/2 at 1 s"),
        (Term::BiasInstability, "  B, minimum / 0.664"),
        (Term::RateRandomWalk, "  K, slope +1/2 at 3 s"),
    ];
    for (term, name) in rules {
        row(out, name, group, |_| String::new())?;
        let si = (si_unit(sensor, term), 1.0);
        let usual = Some(shown_in(sensor, term)).filter(|_| term == Term::BiasInstability);
        for (unit, factor) in [si].into_iter().chain(usual) {
            row(out, &format!("    {unit}"), group, |(_, noise)| {
                noise.classical.of(term).map_or("-".into(), |line| four_digits(line.value * factor))
            })?;
        }
    }
    Ok(())
}

fn reason(long_taus: LongTauValidity) -> Option<&'static str> {
    match long_taus {
        LongTauValidity::Sensor => None,
        LongTauValidity::Compensated => Some(
            "B, K and R are not measurable in this message: the attitude filter removes the bias. The minimum of the curve and the shoulder \
             before it are the filter's. VNIMU is not compensated.",
        ),
        LongTauValidity::LooksCompensated => Some(
            "B, K and R are not measurable: at long tau the curve falls below its own white noise, because a filter removes the bias.",
        ),
        LongTauValidity::Surroundings => {
            Some("Only N is the sensor's: at long tau the ambient magnetic field dominates the curve.")
        }
        LongTauValidity::Motion => Some("The sensor was moved: N, B, K and R are not given."),
    }
}

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
    let any = |of: fn(&FigureVerdict) -> bool| verdicts.channels.iter().flatten().any(of);
    if any(|figure| figure.verdict == Verdict::Consistent) {
        writeln!(out, "{}", fill(&format!("undecidable: {WHY_UNDECIDABLE}"), "", "  "))?;
    }
    if any(|figure| figure.unknown == Some(StreamUnknown::Window) && figure.figure.sensor != Sensor::Magnetometer) {
        let option = remedy_words(&Remedy::GiveWindow);
        let text = format!("Set {option} N to what register 85 was: noise densities are decidable then");
        writeln!(out, "{}", fill(&text, "", "  "))?;
    }
    if any(|figure| matches!(figure.figure.claim, Claim::Typical { .. })) {
        let text = "typically: typical values are not guaranteed, and nothing passes or fails by them; 0.14 means 0.135 to 0.145";
        writeln!(out, "{}", fill(text, "", "  "))?;
    }
    write_grades(out, channels)
}

fn write_grades(out: &mut String, channels: &[ChannelValues]) -> fmt::Result {
    let graded = channels.iter().filter_map(|channel| Some((&*channel.name, grade_text(channel.noise.as_ref()?)?)));
    let mut merged: Vec<(Vec<&str>, String)> = Vec::new();
    for (name, text) in graded {
        match merged.iter_mut().find(|(_, same)| *same == text) {
            Some((names, _)) => names.push(name),
            None => merged.push((vec![name], text)),
        }
    }
    if merged.is_empty() {
        return Ok(());
    }
    let graded: Vec<String> = merged.iter().map(|(names, text)| format!("{}: {text}", names.join(" "))).collect();
    let text = format!("{}: {}", grade_scheme(), graded.join("; "));
    writeln!(out, "{}", fill(&text, "", "  "))
}
