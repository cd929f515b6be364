//! The JSON document of several recordings of one sensor as one, schema `vn100.pool/1`: a contract
//! with scripts.
//!
//! SI units (magnetic field in gauss); what is not known is `null`. `part` is a place in
//! `source.parts`, from 0.

use serde::Serialize;
use vn100_analysis::noise::{Deviation, Estimator, Parameter, Sensor};
use vn100_analysis::{NotPooled, Pool, PoolPart, PooledChannel, PooledOctave, PooledParameter, Unpooled, sensor_of};

use super::{deviation_name, estimator_name};
use crate::{
    codes::{code_of_status, term_name},
    units::si_unit,
};

/// The JSON document of a pool.
#[derive(Debug, Serialize)]
pub struct PoolDocument {
    schema: &'static str,
    source: PooledSource,
    confidence: f64,
    deviation: &'static str,
    estimator: &'static str,
    channels: Vec<PooledChannelDocument>,
    notes: Vec<String>,
    /// What is not in the pool: it is with each recording.
    not_pooled: Vec<NotPooledDocument>,
}

#[derive(Debug, Serialize)]
struct NotPooledDocument {
    what: &'static str,
    part: Option<usize>,
    channel: Option<String>,
    parameter: Option<&'static str>,
    reason: String,
}

#[derive(Debug, Serialize)]
struct PooledSource {
    kind: &'static str,
    parts: Vec<PartDocument>,
}

#[derive(Debug, Serialize)]
struct PartDocument {
    name: String,
    serial: Option<String>,
    samples: u64,
    duration_s: f64,
    pooled: bool,
    /// Why it is excluded.
    reason: Option<String>,
}

#[derive(Debug, Serialize)]
struct PooledChannelDocument {
    name: String,
    unit: String,
    /// All recordings in one curve; the intervals are those of sampling alone.
    points: Vec<PointDocument>,
    noise: Vec<PooledParameterDocument>,
}

#[derive(Debug, Serialize)]
struct PointDocument {
    m: u64,
    tau_s: f64,
    deviation: Option<f64>,
    terms: u64,
    edf: Option<f64>,
    lower: Option<f64>,
    upper: Option<f64>,
    parts: usize,
}

#[derive(Debug, Serialize)]
struct PooledParameterDocument {
    parameter: &'static str,
    unit: &'static str,
    /// `null` below three estimates: see the parts.
    pooled: Option<PooledDocument>,
    /// Where all of three parts or more are bounded: the bound of all, if they share one value.
    common_upper: Option<f64>,
    parts: Vec<PartParameter>,
}

#[derive(Debug, Serialize)]
struct PooledDocument {
    value: f64,
    lower: f64,
    upper: f64,
    /// Standard deviation of the logarithm between recordings.
    spread: f64,
    /// Where the value of one more recording will lie.
    next_lower: f64,
    next_upper: f64,
    estimates: usize,
    farthest: Option<Farthest>,
}

#[derive(Debug, Serialize)]
struct Farthest {
    part: usize,
    /// Over what the others foretell.
    ratio: f64,
    /// Corrected for the number of recordings.
    p: f64,
    /// For all parameters of all channels too.
    corrected: Option<f64>,
    outlier: bool,
}

#[derive(Debug, Serialize)]
struct PartParameter {
    part: usize,
    status: &'static str,
    value: Option<f64>,
    lower: Option<f64>,
    upper: Option<f64>,
}

impl PoolDocument {
    /// The document of a pool of recordings that were all measured with this deviation and these
    /// windows.
    #[must_use]
    pub fn new(pool: &Pool, (deviation, estimator): (Deviation, Estimator)) -> Self {
        Self {
            schema: "vn100.pool/1",
            source: PooledSource { kind: "pool", parts: pool.parts.iter().map(PartDocument::new).collect() },
            confidence: pool.confidence,
            deviation: deviation_name(deviation),
            estimator: estimator_name(estimator),
            channels: pool.channels.iter().map(PooledChannelDocument::new).collect(),
            notes: pool.notes.clone(),
            not_pooled: pool.not_pooled().into_iter().map(|left| NotPooledDocument::new(pool, left)).collect(),
        }
    }
}

impl NotPooledDocument {
    fn new(pool: &Pool, NotPooled { what, reason }: NotPooled) -> Self {
        let (name, part, of) = match what {
            Unpooled::Recording(part) => ("recording", Some(part), None),
            Unpooled::Parameter { channel, term } => ("parameter", None, Some((channel, term))),
            Unpooled::RateRamp => ("rate-ramp", None, None),
            Unpooled::Statistics => ("statistics", None, None),
            Unpooled::Spectrum => ("spectrum", None, None),
            Unpooled::Changes => ("changes", None, None),
            Unpooled::Warnings => ("warnings", None, None),
        };
        Self {
            what: name,
            part,
            channel: of.map(|(channel, _)| pool.channels[channel].channel.name.to_string()),
            parameter: of.map(|(_, term)| term_name(term)),
            reason,
        }
    }
}

impl PartDocument {
    fn new(part: &PoolPart) -> Self {
        Self {
            name: part.name.clone(),
            serial: part.serial.clone(),
            samples: part.samples,
            duration_s: part.duration_s,
            pooled: part.refused.is_none(),
            reason: part.refused.clone(),
        }
    }
}

impl PooledChannelDocument {
    fn new(pooled: &PooledChannel) -> Self {
        let sensor = sensor_of(pooled.quantity());
        let parameters = sensor.into_iter().flat_map(|sensor| {
            pooled.parameters.iter().map(move |parameter| PooledParameterDocument::new(parameter, sensor))
        });
        Self {
            name: pooled.channel.name.to_string(),
            unit: pooled.channel.unit.to_string(),
            points: pooled.octaves.iter().map(PointDocument::new).collect(),
            noise: parameters.collect(),
        }
    }
}

impl PointDocument {
    fn new(octave: &PooledOctave) -> Self {
        let PooledOctave { m, tau_s, deviation, terms, relative, parts } = *octave;
        Self {
            m,
            tau_s,
            deviation,
            terms,
            edf: relative.map(|relative| relative.edf),
            lower: deviation.zip(relative).map(|(deviation, relative)| deviation * relative.lower),
            upper: deviation.zip(relative).map(|(deviation, relative)| deviation * relative.upper),
            parts,
        }
    }
}

impl PooledParameterDocument {
    fn new(parameter: &PooledParameter, sensor: Sensor) -> Self {
        let part = |(part, found): (usize, &Option<Parameter>)| {
            let Parameter { status: known, value, lower, upper, .. } = (*found)?;
            Some(PartParameter { part, status: code_of_status(known).code, value, lower, upper })
        };
        let pooled = parameter.pooled.map(|pooled| PooledDocument {
            value: pooled.value,
            lower: pooled.lower,
            upper: pooled.upper,
            spread: pooled.spread,
            next_lower: pooled.next_lower,
            next_upper: pooled.next_upper,
            estimates: pooled.estimates,
            farthest: pooled.farthest.map(|farthest| Farthest {
                part: farthest.record,
                ratio: farthest.ratio,
                p: farthest.p,
                corrected: parameter.corrected,
                outlier: parameter.outlier().is_some(),
            }),
        });
        Self {
            parameter: term_name(parameter.term),
            unit: si_unit(sensor, parameter.term),
            pooled,
            common_upper: parameter.common_bound,
            parts: parameter.parts.iter().enumerate().filter_map(part).collect(),
        }
    }
}
