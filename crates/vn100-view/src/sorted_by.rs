//! The order of the sensors in the overview.

use imu_noise::Term;
use vn100_analysis::Severity;
use vn100_protocol::Quantity;

use crate::source::{SourcePhase, SourceView};

/// What the rows are sorted by.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum SortedBy {
    /// As the sources were given.
    #[default]
    Place,
    /// What is broken first, then the most serious warning.
    Findings,
    /// The most samples that were lost first.
    Lost,
    /// The noisiest gyroscope first.
    Gyro,
}

impl SortedBy {
    pub(crate) fn next(self) -> Self {
        match self {
            Self::Place => Self::Findings,
            Self::Findings => Self::Lost,
            Self::Lost => Self::Gyro,
            Self::Gyro => Self::Place,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Place => "place",
            Self::Findings => "warnings",
            Self::Lost => "lost samples",
            Self::Gyro => "gyro N",
        }
    }

    /// The places of the sources in the order of the rows.
    pub(crate) fn order(self, sources: &[SourceView]) -> Vec<usize> {
        let mut order: Vec<usize> = (0..sources.len()).collect();
        match self {
            Self::Place => {}
            Self::Findings => order.sort_by_key(|place| gravity(&sources[*place])),
            Self::Lost => order.sort_by_key(|place| std::cmp::Reverse(lost(&sources[*place]))),
            Self::Gyro => {
                let noise = |place: &usize| worst_white(&sources[*place], Quantity::AngularRate).unwrap_or(-1.0);
                order.sort_by(|a, b| noise(b).total_cmp(&noise(a)));
            }
        }
        order
    }
}

/// The lower the graver: what is broken or has ended by a fault, problems, cautions, the rest.
fn gravity(source: &SourceView) -> u8 {
    let worst = source.warnings.first().map(|warning| warning.severity);
    match (&source.phase, worst) {
        (SourcePhase::Ended(Some(_)), _) => 0,
        _ if !source.faults.all().is_empty() => 0,
        (_, Some(Severity::Problem)) => 1,
        (_, Some(Severity::Caution)) => 2,
        _ => 3,
    }
}

pub(super) fn lost(source: &SourceView) -> u64 {
    let tally = &source.snapshot.link.tally;
    tally.rejected.total() + tally.damaged_packets + source.snapshot.timing.missing
}

/// N of the noisiest axis, in SI units.
pub(super) fn worst_white(source: &SourceView, quantity: Quantity) -> Option<f64> {
    let axes = source.values.iter().filter(|channel| channel.quantity == quantity);
    axes.filter_map(|channel| channel.noise.as_ref()?.parameter(Term::White)?.value).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use vn100_analysis::{Warning, WarningKind};

    use super::*;
    use crate::tests::fixture::{damaged, measured};

    #[test]
    fn what_is_broken_comes_before_what_is_warned_of() {
        let warned = |severity| {
            let warning = Warning { severity, ..Warning::new(WarningKind::WarmUp, Vec::new(), "", "") };
            SourceView { warnings: vec![warning], ..measured() }
        };
        let (problem, caution) = (warned(Severity::Problem), warned(Severity::Caution));
        let fine = SourceView { warnings: Vec::new(), ..measured() };
        let ended = SourceView { phase: SourcePhase::Ended(Some("unplugged".into())), ..fine.clone() };
        let order = SortedBy::Findings.order(&[fine, caution, problem, damaged(), ended]);
        assert_eq!(order, [3, 4, 2, 1, 0]);
    }
}
