//! `vn100 selftest`: published values beside those that this program computes.

mod published;

use std::{
    fmt::{self, Write},
    path::PathBuf,
};

use anyhow::Result;
use vn100_analysis::{Completion, SelfTestCheck, SelfTestSuite, self_test};

use crate::{
    exit::{print, unless_closed},
    text::text,
};

/// Without a folder, `published` lists the records.
pub(crate) fn selftest(published: Option<Option<PathBuf>>) -> Result<Completion> {
    if let Some(None) = published {
        return published::list();
    }
    let suites = self_test();
    let completion = if failures(&suites) == 0 { Completion::Complete } else { Completion::Failed };
    unless_closed(print(&text(|out| write_suites(out, &suites))))?;
    match published {
        Some(Some(folder)) => Ok(completion.max(published::compare(&folder)?)),
        _ => Ok(completion),
    }
}

fn failures(suites: &[SelfTestSuite]) -> usize {
    suites.iter().flat_map(|suite| &suite.checks).filter(|check| !check.passes()).count()
}

fn write_suites(out: &mut String, suites: &[SelfTestSuite]) -> fmt::Result {
    for suite in suites {
        let row = |cells: [&str; 5]| {
            let [statistic, m, reference, ours, difference] = cells;
            format!("  {statistic:<45}{m:>4} {reference:>14} {ours:>14} {difference:>12}")
        };
        writeln!(out, "{}", suite.source)?;
        writeln!(out, "{}", row(["", "m", "reference", "ours", "difference"]))?;
        for check in &suite.checks {
            let m = check.m.map_or(String::new(), |m| m.to_string());
            let digits = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.6e}"));
            let [reference, ours] = [check.reference.parse().ok(), check.ours].map(digits);
            let verdict = if check.passes() { "" } else { "  FAILS" };
            writeln!(out, "{}{verdict}", row([&check.statistic, &m, &reference, &ours, &difference(check)]))?;
        }
        writeln!(out)?;
    }
    let all = suites.iter().map(|suite| suite.checks.len()).sum::<usize>();
    match failures(suites) {
        0 => writeln!(
            out,
            "all {all} agree: deviations to the last digit published, degrees of freedom to 1e-6, bounds to 1e-10"
        ),
        failed => writeln!(out, "{failed} of {all} differ: do not trust the results of this program on this machine"),
    }
}

/// Relative; what rounding makes of it is the same everywhere only down to here.
fn difference(check: &SelfTestCheck) -> String {
    match check.relative_difference() {
        Some(difference) if difference.abs() < 1e-9 => "< 1e-9".into(),
        Some(difference) => format!("{difference:+.0e}"),
        None => "-".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_that_differs_is_marked_and_counted() {
        let mut suites = self_test();
        suites[1].checks[3].ours = Some(85.952_98);
        suites[0].checks[0].ours = None;
        let text = text(|out| write_suites(out, &suites));
        let marked: Vec<&str> = text.lines().filter(|line| line.ends_with("FAILS")).collect();
        assert_eq!(marked.len(), 2, "{text}");
        assert!(marked[1].contains("+1e-6") && text.contains("2 of 38 differ"), "{text}");
    }
}
