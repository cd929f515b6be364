//! The noise as filters ask for it, where the user asked for that.

use std::fmt::{self, Write};

use imu_noise::{GaussMarkovFit, OverBound, Parameter, Term};
use vn100_analysis::FilterModels;
use vn100_report::{
    names::sensor,
    numbers::plain::four_digits,
    units::{ChannelValues, si_unit},
};

use super::layout::row;

/// One table for each sensor, its axes side by side, in the units of the channels.
pub(super) fn write_filter_models(
    out: &mut String,
    channels: &[ChannelValues],
    models: &[Option<FilterModels>],
) -> fmt::Result {
    let axes: Vec<Axis<'_>> =
        channels.iter().zip(models).filter_map(|(channel, models)| Some((channel, models.as_ref()?))).collect();
    for group in axes.chunk_by(|(a, _), (b, _)| a.quantity == b.quantity) {
        let Some(noise) = group[0].0.noise.as_ref() else { continue };
        let unit = |term| si_unit(noise.sensor, term);
        writeln!(out, "\n{}, for filters", sensor(group[0].0.quantity))?;
        row(out, "", group, |(channel, _)| channel.name.clone())?;
        writeln!(out, "white + Gauss-Markov")?;
        write_fitted(out, &format!("  N {}", unit(Term::White)), group, |fit| fit.white)?;
        write_fitted(out, &format!("  sigma {}", group[0].0.unit), group, |fit| fit.sigma)?;
        write_fitted(out, "  correlation time s", group, |fit| fit.correlation_time_s)?;
        writeln!(out, "above all bounds")?;
        row(out, &format!("  N {}", unit(Term::White)), group, bound(|bound| bound.white))?;
        row(out, &format!("  K {}", unit(Term::RateRandomWalk)), group, bound(|bound| bound.rate_random_walk))?;
    }
    Ok(())
}

type Axis<'a> = (&'a ChannelValues, &'a FilterModels);

/// A parameter, and below it the interval where an axis has one.
fn write_fitted(
    out: &mut String,
    label: &str,
    group: &[Axis<'_>],
    of: fn(&GaussMarkovFit) -> Parameter,
) -> fmt::Result {
    let fitted = |(_, models): &Axis<'_>| models.gauss_markov.as_ref().map(of);
    row(out, label, group, |axis| told(fitted(axis)))?;
    let estimated = |axis: &Axis<'_>| fitted(axis).filter(|parameter| parameter.value.is_some());
    if group.iter().any(|axis| estimated(axis).is_some()) {
        let end = |value: Option<f64>| value.map_or("-".into(), four_digits);
        row(out, "    from", group, |axis| end(estimated(axis).and_then(|parameter| parameter.lower)))?;
        row(out, "    to", group, |axis| end(estimated(axis).and_then(|parameter| parameter.upper)))?;
    }
    Ok(())
}

fn told(parameter: Option<Parameter>) -> String {
    match parameter {
        Some(Parameter { value: Some(value), .. }) => four_digits(value),
        Some(Parameter { upper: Some(upper), .. }) => format!("<= {}", four_digits(upper)),
        Some(Parameter { lower: Some(lower), .. }) => format!(">= {}", four_digits(lower)),
        Some(_) => "not observable".into(),
        None => "-".into(),
    }
}

fn bound(of: fn(&OverBound) -> f64) -> impl Fn(&Axis<'_>) -> String {
    // one of the two alone may lie above all: the other is nothing, not a small number
    let told = |value: f64| if value == 0.0 { "0".into() } else { four_digits(value) };
    move |(_, models)| models.over_bound.as_ref().map(of).map_or("-".into(), told)
}

#[cfg(test)]
mod tests {
    use imu_noise::Status;

    use super::*;

    #[test]
    fn what_lies_at_an_end_is_a_bound() {
        let nothing = Parameter::without_value(Status::Bounded);
        assert_eq!(told(Some(Parameter { lower: Some(900.0), ..nothing })), ">= 900.0");
        assert_eq!(told(Some(Parameter { upper: Some(1.5), ..nothing })), "<= 1.500");
        assert_eq!(told(Some(Parameter::without_value(Status::NotObservable))), "not observable");
        assert_eq!(told(None), "-");
    }
}
