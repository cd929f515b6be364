//! Recordings of one sensor as one: the curve of all, the parameters with what one more recording
//! would read, and which one is an outlier.

use std::fmt::{self, Write};

use imu_noise::{Sensor, Term};
use vn100_analysis::{Pool, PooledChannel, PooledParameter, sensor_of};
use vn100_report::{
    names::{TERMS, names_of, parameter_names},
    numbers::plain::{counted, four_digits, short},
    printable,
    units::si_unit,
};

use super::{COLUMN, fill, parameter_name, row};

/// Name, short name, symbol and slope: `Angle Random Walk (ARW) N, slope -1/2`.
fn title(sensor: Sensor, term: Term) -> String {
    format!("{}, slope {}", parameter_name(sensor, term), parameter_names(sensor, term).slope)
}

pub(crate) fn write_pool(out: &mut String, pool: &Pool) -> fmt::Result {
    let used: Vec<&str> = pool.parts.iter().filter(|part| part.refused.is_none()).map(|part| &*part.name).collect();
    let head = format!("pool of {}: {}", counted(used.len() as u64, "recording"), used.join(", "));
    writeln!(out, "{}", fill(&printable(&head), "", "  "))?;
    for part in &pool.parts {
        if let Some(reason) = &part.refused {
            writeln!(out, "{}", fill(&printable(&format!("{} is excluded: {reason}", part.name)), "! ", "  "))?;
        }
    }
    for note in &pool.notes {
        writeln!(out, "{}", fill(&printable(note), "! ", "  "))?;
    }
    if pool.channels.is_empty() {
        return writeln!(out);
    }
    let legend = format!(
        "\nThe deviations pool the squared differences of all recordings; their limits (in percent, {} % confidence) cover sampling alone. The \
         parameters are the medians over recordings; \"next\" is the prediction interval of one more recording as long. The spread is the \
         variation between recordings beyond their own intervals.",
        short(100.0 * pool.confidence)
    );
    writeln!(out, "{}", fill(&legend, "", ""))?;
    for group in pool.channels.chunk_by(|a, b| a.quantity() == b.quantity()) {
        write_curve(out, group)?;
        write_parameters(out, pool, group)?;
    }
    writeln!(out)
}

fn write_curve(out: &mut String, group: &[PooledChannel]) -> fmt::Result {
    writeln!(out, "\n{}, {}", names_of(group[0].quantity()).title, group[0].channel.unit)?;
    write!(out, "{:>8} {:>7} {:>7}", "tau (s)", "m", "terms")?;
    for pooled in group {
        write!(out, " {:>COLUMN$}", pooled.channel.name)?;
    }
    writeln!(out)?;
    let octaves = group.iter().map(|pooled| pooled.octaves.len()).max().unwrap_or(0);
    for index in 0..octaves {
        let Some(first) = group.iter().find_map(|pooled| pooled.octaves.get(index)) else { continue };
        write!(out, "{:>8} {:>7} {:>7}", short(first.tau_s), first.m, first.terms)?;
        for pooled in group {
            let cell = pooled.octaves.get(index).and_then(|octave| {
                let deviation = octave.deviation?;
                let bounds = octave.relative.map_or("n/a".into(), |relative| {
                    let [above, below] = [relative.upper, relative.lower].map(|bound| 100.0 * (bound - 1.0));
                    let decimals = usize::from(above < 9.95);
                    format!("{above:+.decimals$}{below:+.decimals$}")
                });
                Some(format!("{deviation:.3e} {bounds:>7}"))
            });
            write!(out, " {:>COLUMN$}", cell.unwrap_or_else(|| "-".into()))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn write_parameters(out: &mut String, pool: &Pool, group: &[PooledChannel]) -> fmt::Result {
    let Some(sensor) = sensor_of(group[0].quantity()) else { return Ok(()) };
    let of = |term| -> Vec<Option<&PooledParameter>> {
        let found = |pooled: &PooledChannel| pooled.parameters.iter().position(|parameter| parameter.term == term);
        group.iter().map(|pooled| Some(&pooled.parameters[found(pooled)?])).collect()
    };
    for term in TERMS {
        let axes = of(term);
        if axes.iter().all(Option::is_none) {
            continue;
        }
        row(out, &format!("{}, {}", title(sensor, term), si_unit(sensor, term)), &[(); 0], |()| String::new())?;
        let pooled: Vec<_> = axes.iter().map(|axis| axis.and_then(|parameter| parameter.pooled)).collect();
        if pooled.iter().any(Option::is_some) {
            type CellText = fn(&vn100_analysis::comparisons::RandomEffects) -> String;
            let cells: [(&str, CellText); 6] = [
                ("  median", |found| four_digits(found.value)),
                ("    lower", |found| four_digits(found.lower)),
                ("    upper", |found| four_digits(found.upper)),
                ("  spread, %", |found| format!("{:.1}", 100.0 * found.spread)),
                ("  next, lower", |found| four_digits(found.next_lower)),
                ("    upper", |found| four_digits(found.next_upper)),
            ];
            for (label, cell) in cells {
                row(out, label, &pooled, |found| found.as_ref().map_or("-".into(), cell))?;
            }
        }
        // with too few estimates each stands for itself
        if pooled.iter().any(Option::is_none) {
            for (number, part) in pool.parts.iter().enumerate().filter(|(_, part)| part.refused.is_none()) {
                let label: String = format!("  {}", printable(&part.name)).chars().take(23).collect();
                row(out, &label, &axes, |axis| {
                    let found = axis.and_then(|parameter| parameter.parts[number]);
                    match found.map(|found| (found.value, found.upper)) {
                        Some((Some(value), _)) => four_digits(value),
                        Some((None, Some(upper))) => format!("<= {}", four_digits(upper)),
                        _ => "-".into(),
                    }
                })?;
            }
        }
        let common: Vec<Option<f64>> =
            axes.iter().map(|axis| axis.and_then(|parameter| parameter.common_bound)).collect();
        if common.iter().any(Option::is_some) {
            row(out, "  common bound", &common, |bound| {
                bound.map_or("-".into(), |bound| format!("<= {}", four_digits(bound)))
            })?;
        }
        for (pooled, parameter) in group.iter().zip(&axes).filter_map(|(pooled, axis)| Some((pooled, (*axis)?))) {
            let farthest = parameter.pooled.and_then(|found| found.farthest);
            if let Some((part, farthest)) = parameter.outlier().zip(farthest) {
                let text = format!(
                    "{}: {} is an outlier, {:.2} times the prediction from the others (p = {:.1e}; {:.1e} corrected for all parameters)",
                    pooled.channel.name,
                    printable(&pool.parts[part].name),
                    farthest.ratio,
                    farthest.p,
                    parameter.corrected.unwrap_or(1.0)
                );
                writeln!(out, "{}", fill(&text, "! ", "  "))?;
            }
        }
    }
    Ok(())
}
