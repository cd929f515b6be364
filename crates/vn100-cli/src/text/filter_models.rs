//! The noise as filters ask for it, where the user asked for that.

use std::fmt::{self, Write};

use imu_noise::{GaussMarkovFit, OverBound, Parameter, Term, conventions};
use vn100_pipeline::FilterModels;

use super::{
    noise::{four_digits, row},
    sensor,
};
use crate::units::ChannelValues;

/// One table for each sensor, its axes side by side, in the units of the channels.
pub(super) fn write_filter_models(
    out: &mut String,
    channels: &[ChannelValues],
    models: &[Option<FilterModels>],
) -> fmt::Result {
    let axes: Vec<(&ChannelValues, &FilterModels)> =
        channels.iter().zip(models).filter_map(|(channel, models)| Some((channel, models.as_ref()?))).collect();
    for group in axes.chunk_by(|(a, _), (b, _)| a.quantity == b.quantity) {
        let Some(noise) = group[0].0.noise.as_ref() else { continue };
        let unit = |term| conventions(noise.sensor, term).first().map_or("", |si| si.unit);
        writeln!(out, "\n{}, for filters", sensor(group[0].0.quantity))?;
        row(out, "", group, |(channel, _)| channel.name.clone())?;
        writeln!(out, "white + Gauss-Markov")?;
        row(out, &format!("  N {}", unit(Term::White)), group, fitted(|fit| fit.white))?;
        row(out, &format!("  sigma {}", group[0].0.unit), group, fitted(|fit| fit.sigma))?;
        row(out, "  correlation time s", group, fitted(|fit| fit.correlation_time_s))?;
        writeln!(out, "above all bounds")?;
        row(out, &format!("  N {}", unit(Term::White)), group, bound(|bound| bound.white))?;
        row(out, &format!("  K {}", unit(Term::RateRandomWalk)), group, bound(|bound| bound.rate_random_walk))?;
    }
    Ok(())
}

fn fitted(of: fn(&GaussMarkovFit) -> Parameter) -> impl Fn(&(&ChannelValues, &FilterModels)) -> String {
    move |(_, models)| match models.gauss_markov.as_ref().map(of) {
        Some(Parameter { value: Some(value), .. }) => four_digits(value),
        Some(Parameter { upper: Some(upper), .. }) => format!("<= {}", four_digits(upper)),
        Some(_) => "not observable".into(),
        None => "-".into(),
    }
}

fn bound(of: fn(&OverBound) -> f64) -> impl Fn(&(&ChannelValues, &FilterModels)) -> String {
    move |(_, models)| models.over_bound.as_ref().map(of).map_or("-".into(), four_digits)
}
