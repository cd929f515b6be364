//! How the values of each channel are distributed, and how their deviation went along the record.

use std::fmt::{self, Write};

use super::layout::fill;
use vn100_report::{
    numbers::plain::short,
    units::{BlockValues, ChannelValues},
};

/// Parts into which the record is divided.
const PARTS: usize = 8;

/// Skewness and excess kurtosis, and whether the values may be normal.
pub(super) fn write_distribution(out: &mut String, channels: &[ChannelValues]) -> fmt::Result {
    writeln!(out, "\n{:<13}{:>8}{:>9}  normally distributed?", "distribution", "skew", "kurtosis")?;
    for channel in channels {
        let shape =
            |value: Option<f64>, decimals: usize| value.map_or("-".into(), |value| format!("{value:+.decimals$}"));
        let normal = match channel.signal.as_ref().and_then(|signal| signal.normality) {
            Some(Ok(normality)) if normality.is_consistent() => "may be".into(),
            Some(Ok(normality)) => format!(
                "no: {:.0} and {:.0} standard errors off",
                (normality.skewness / normality.skewness_error).abs(),
                (normality.excess_kurtosis / normality.excess_kurtosis_error).abs()
            ),
            Some(Err(reason)) => format!("? {reason}"),
            None => "-".into(),
        };
        let row = format!(
            "{:<13}{:>8}{:>9}  {normal}",
            channel.name,
            shape(channel.skewness, 3),
            shape(channel.excess_kurtosis, 3)
        );
        writeln!(out, "{}", fill(&row, "", "                                  "))?;
    }
    Ok(())
}

/// The standard deviation of each part of the record, in percent of that of the whole; `skipped_s`
/// lie before the first.
pub(super) fn write_parts(out: &mut String, channels: &[ChannelValues], skipped_s: f64) -> fmt::Result {
    let blocks = |channel: &ChannelValues| channel.signal.as_ref().map(|signal| parts(&signal.blocks));
    let Some(first) = channels.iter().find_map(blocks).filter(|parts| parts.len() == PARTS) else { return Ok(()) };
    writeln!(out, "\nstandard deviation along the record, in percent of the whole; parts begin at (s)")?;
    write!(out, "{:<13}", "")?;
    for part in &first {
        write!(out, "{:>8}", short(((skipped_s + part.start_s) * 10.0).round() / 10.0))?;
    }
    writeln!(out)?;
    for channel in channels {
        let (Some(parts), Some(whole)) = (blocks(channel), channel.std.filter(|std| *std > 0.0)) else { continue };
        write!(out, "{:<13}", channel.name)?;
        for part in parts {
            write!(out, "{:>8}", part.std.map_or("-".into(), |std| format!("{:.0}", 100.0 * std / whole)))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// So many blocks of equal length, of those of a record in time order; fewer where it has fewer.
fn parts(blocks: &[BlockValues]) -> Vec<BlockValues> {
    let (Some(first), Some(last)) = (blocks.first(), blocks.last()) else { return Vec::new() };
    let span_s = last.start_s + last.duration_s - first.start_s;
    let part = |block: &BlockValues| {
        let middle_s = block.start_s + block.duration_s / 2.0 - first.start_s;
        ((middle_s / span_s * PARTS as f64) as usize).min(PARTS - 1)
    };
    blocks.chunk_by(|a, b| part(a) == part(b)).filter_map(joined).collect()
}

/// The statistics of neighbours together: squares within and between them add up.
fn joined(blocks: &[BlockValues]) -> Option<BlockValues> {
    let (first, last) = (blocks.first()?, blocks.last()?);
    let count: u64 = blocks.iter().map(|block| block.count).sum();
    let n = count as f64;
    let mean = blocks.iter().map(|block| block.count as f64 * block.mean).sum::<f64>() / n;
    let squares: f64 = blocks
        .iter()
        .map(|block| {
            let of = block.count as f64;
            (of - 1.0) * block.std.unwrap_or(0.0).powi(2) + of * (block.mean - mean).powi(2)
        })
        .sum();
    Some(BlockValues {
        start_s: first.start_s,
        duration_s: last.start_s + last.duration_s - first.start_s,
        count,
        mean,
        std: (count > 1).then(|| (squares / (n - 1.0)).sqrt()),
        min: blocks.iter().map(|block| block.min).fold(f64::INFINITY, f64::min),
        max: blocks.iter().map(|block| block.max).fold(f64::NEG_INFINITY, f64::max),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_together_have_the_statistics_of_their_samples() {
        let block = |start_s: f64, values: &[f64]| {
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
            BlockValues {
                start_s,
                duration_s: 1.0,
                count: values.len() as u64,
                mean,
                std: (n > 1.0).then(|| (squares / (n - 1.0)).sqrt()),
                min: values.iter().copied().fold(f64::INFINITY, f64::min),
                max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            }
        };
        let whole = block(0.0, &[1.0, 4.0, 2.5, 7.0, -3.0]);
        let found = joined(&[block(0.0, &[1.0, 4.0]), block(1.0, &[2.5]), block(2.0, &[7.0, -3.0])]).unwrap();
        assert_eq!((found.count, found.min, found.max, found.duration_s), (5, -3.0, 7.0, 3.0));
        assert!((found.mean - whole.mean).abs() < 1e-12 && (found.std.unwrap() - whole.std.unwrap()).abs() < 1e-12);
        assert_eq!(joined(&[]), None);
        assert_eq!(parts(&[]), []);
        let many: Vec<_> = (0..20).map(|i| block(f64::from(i), &[1.0, 2.0])).collect();
        assert_eq!(parts(&many).len(), PARTS);
        assert_eq!(parts(&many).iter().map(|part| part.count).sum::<u64>(), 40);
    }
}
