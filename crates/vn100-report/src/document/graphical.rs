//! The results of the graphical slope method, as in the JSON document.

use serde::Serialize;
use vn100_analysis::ChannelNoise;
use vn100_analysis::noise::{Sensor, SlopeLine, Term};

use crate::{
    codes::term_name,
    graphical::{GRAPHICAL, laboratory_unit, not_read_code},
    units::si_unit,
};

/// N, B and K; `null` if they are not read.
#[derive(Debug, Serialize)]
pub(super) struct ClassicalDocument {
    white: Option<f64>,
    white_unit: &'static str,
    bias_instability: Option<f64>,
    bias_instability_unit: &'static str,
    rate_random_walk: Option<f64>,
    rate_random_walk_unit: &'static str,
    /// The same with where and why.
    readings: [ReadingDocument; 3],
}

#[derive(Debug, Serialize)]
struct ReadingDocument {
    parameter: &'static str,
    value: Option<f64>,
    unit: &'static str,
    /// In the unit of laboratory reports, which a magnetometer has not.
    laboratory_value: Option<f64>,
    laboratory_unit: Option<&'static str>,
    /// Where the line touches the curve.
    tau_s: Option<f64>,
    /// Why there is no value.
    not_read: Option<&'static str>,
}

impl ClassicalDocument {
    pub(super) fn new(noise: &ChannelNoise) -> Self {
        let value = |term| noise.classical.of(term).ok().map(|line| line.value);
        let unit = |term| si_unit(noise.sensor, term);
        Self {
            white: value(Term::White),
            white_unit: unit(Term::White),
            bias_instability: value(Term::BiasInstability),
            bias_instability_unit: unit(Term::BiasInstability),
            rate_random_walk: value(Term::RateRandomWalk),
            rate_random_walk_unit: unit(Term::RateRandomWalk),
            readings: GRAPHICAL.map(|(term, _)| ReadingDocument::new(noise, noise.sensor, term)),
        }
    }
}

impl ReadingDocument {
    fn new(noise: &ChannelNoise, sensor: Sensor, term: Term) -> Self {
        let read = noise.classical.of(term);
        let line: Option<SlopeLine> = read.ok();
        let laboratory = laboratory_unit(sensor, term);
        Self {
            parameter: term_name(term),
            value: line.map(|line| line.value),
            unit: si_unit(sensor, term),
            laboratory_value: line.zip(laboratory).map(|(line, (_, factor))| line.value * factor),
            laboratory_unit: laboratory.map(|(unit, _)| unit),
            tau_s: line.map(|line| line.tau_s),
            not_read: read.err().map(not_read_code),
        }
    }
}
