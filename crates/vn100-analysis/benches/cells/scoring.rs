//! Which intervals hold the truth.

use imu_noise::{Parameter, Status, Term};
use statrs::distribution::{Beta, ContinuousCDF};

use super::{
    families::{Cell, Truth},
    generators::Flicker,
    random::Random,
    record::{self, Record, Took},
};

/// In the order in which they are scored.
pub(crate) const TERMS: [Term; 4] = [Term::White, Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp];

impl Truth {
    pub(crate) fn of(&self, term: Term) -> f64 {
        match term {
            Term::White => self.white,
            Term::BiasInstability => self.bias_instability,
            Term::RateRandomWalk => self.walk,
            Term::RateRamp => self.ramp,
            Term::Quantization => 0.0,
        }
    }
}

/// What is said of one record.
pub(crate) struct RecordScore {
    /// Per scored channel, in the order of [`TERMS`].
    pub(crate) channels: Vec<[Statement; TERMS.len()]>,
    /// Samples that arrived.
    pub(crate) samples: u64,
    pub(crate) took: Took,
}

/// What is said of one parameter.
#[derive(Clone, Copy)]
pub(crate) struct Statement {
    /// `None` where nothing at all is.
    status: Option<Status>,
    holds: bool,
    /// Relative error of an estimated value of a parameter that is there.
    error: Option<f64>,
    /// Half the interval over the value.
    half_width: Option<f64>,
}

impl RecordScore {
    pub(crate) fn of(cell: &Cell, flicker: &Flicker, random: &mut Random) -> Self {
        let assessed = Record::of(cell, flicker, random).assess(cell, random);
        let truth = cell.truth();
        let unit = 1.0 / (cell.step * record::counts_per_unit());
        let channels = record::scored().map(|(place, _)| {
            let noise = assessed.assessment.channels[place].noise.as_ref();
            TERMS.map(|term| {
                let parameter = noise.and_then(|noise| noise.parameter(term));
                Statement::new(parameter, truth.of(term) * unit)
            })
        });
        Self { channels: channels.collect(), samples: assessed.snapshot.timing.samples, took: assessed.took }
    }

    /// Whether any channel has the term at `place` of [`TERMS`].
    pub(crate) fn estimates(&self, place: usize) -> bool {
        self.channels.iter().any(|statements| statements[place].status == Some(Status::Estimated))
    }
}

impl Statement {
    fn new(parameter: Option<Parameter>, truth: f64) -> Self {
        let holds = parameter.is_some_and(|parameter| match (parameter.status, parameter.lower, parameter.upper) {
            (Status::Estimated, Some(lower), Some(upper)) => (lower..=upper).contains(&truth),
            (Status::Bounded, _, Some(upper)) => truth <= upper,
            _ => false,
        });
        let estimated = parameter.filter(|parameter| parameter.status == Status::Estimated);
        let value = estimated.and_then(|parameter| parameter.value).filter(|_| truth != 0.0);
        Self {
            status: parameter.map(|parameter| parameter.status),
            holds,
            error: value.map(|value| value / truth - 1.0),
            half_width: estimated.and_then(|parameter| parameter.relative_half_width()),
        }
    }
}

/// The statements on one parameter in all channels of a cell.
#[derive(Default)]
pub(crate) struct Tally {
    pub(crate) of: usize,
    pub(crate) held: usize,
    pub(crate) estimated: usize,
    pub(crate) bounded: usize,
    pub(crate) not_observable: usize,
    pub(crate) rejected: usize,
    errors: Vec<f64>,
    half_widths: Vec<f64>,
}

impl Tally {
    pub(crate) fn new(statements: impl Iterator<Item = Statement>) -> Self {
        let mut tally = Self::default();
        for statement in statements {
            tally.of += 1;
            tally.held += usize::from(statement.holds);
            match statement.status {
                Some(Status::Estimated) => tally.estimated += 1,
                Some(Status::Bounded) => tally.bounded += 1,
                Some(Status::NotObservable) => tally.not_observable += 1,
                Some(Status::ModelRejected) => tally.rejected += 1,
                Some(Status::NotMeasurable | Status::Moved) | None => {}
            }
            tally.errors.extend(statement.error);
            tally.half_widths.extend(statement.half_width);
        }
        tally
    }

    /// Nothing is said of these.
    pub(crate) fn missed(&self) -> usize {
        self.of - self.estimated - self.bounded
    }

    pub(crate) fn rms_error(&self) -> Option<f64> {
        mean(self.errors.iter().map(|error| error * error)).map(f64::sqrt)
    }

    pub(crate) fn bias(&self) -> Option<f64> {
        mean(self.errors.iter().copied())
    }

    pub(crate) fn half_width(&self) -> Option<f64> {
        mean(self.half_widths.iter().copied())
    }

    /// Of the share that holds.
    pub(crate) fn held_limits(&self) -> (f64, f64) {
        limits(self.held, self.of)
    }
}

/// Of the probability of what happened `count` times of `all`, at 95 % (Clopper and Pearson, 1934).
pub(crate) fn limits(count: usize, all: usize) -> (f64, f64) {
    let (count, others) = (count as f64, (all - count) as f64);
    let quantile = |a: f64, b: f64, p: f64| Beta::new(a, b).unwrap().inverse_cdf(p);
    let lower = if count == 0.0 { 0.0 } else { quantile(count, others + 1.0, 0.025) };
    let upper = if others == 0.0 { 1.0 } else { quantile(count + 1.0, others, 0.975) };
    (lower, upper)
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> Option<f64> {
    let count = values.len();
    (count > 0).then(|| values.sum::<f64>() / count as f64)
}
