//! What the noise costs while a sensor coasts, and what a filter is given.

use maud::{Markup, html};
use vn100_analysis::noise::{Status, Term};
use vn100_analysis::{ChannelResult, SourceResult, WALK_OF_FLICKER};

use crate::{
    Consumer, FilterNoise, NotWritten,
    codes::{name_of, word_of},
    drift::{ASSUMPTIONS, coast},
    export::filter_noise::TERMS,
    figure::Figures,
    html::{caption::Captions, figures},
    numbers::{NOTHING, digits},
    units::pretty_unit,
};

/// How far angle, velocity and position drift.
pub(super) fn drift(record: &SourceResult, figures: &Figures, captions: &Captions) -> Markup {
    if record.motion.is_some() || record.drift.is_empty() {
        return html! { p { "Not given: " (if record.motion.is_some() { "the sensor was moved." } else { "the record has no gyroscope and no accelerometer, or no Allan deviation." }) } };
    }
    let number = |value: Option<f64>| value.map_or_else(|| NOTHING.into(), |value| digits(value, 3));
    html! {
        p { (ASSUMPTIONS) " One drift lies within the given limit with the probability of the confidence level, the uncertainty of the standard deviation included; apart from it stands the interval of the standard deviation." }
        @if !figures.drifts.is_empty() { (figures::grid(&figures.drifts, captions)) }
        div.scroll { table aria-label="Drift while coasting" {
            thead { tr { th scope="col" { "axis" } th scope="col" { "drift of the" } th scope="col" { "coast" } th scope="col" { "within" } th scope="col" { "standard deviation" } th scope="col" { "its interval" } th scope="col" { "accelerometer alone" } th scope="col" { "unit" } } }
            tbody { @for found in &record.drift {
                tr {
                    th scope="row" { (found.axis) } td { (name_of(found.of)) } td { (coast(found)) }
                    @if found.status == Status::Estimated {
                        td { (number(found.within)) } td { (number(found.std)) } td { (number(found.lower)) " to " (number(found.upper)) }
                        td { @if found.of_accelerometer.is_some() { (number(found.of_accelerometer)) } } td { (pretty_unit(found.unit)) }
                    } @else { td colspan="5" { (word_of("status", found.status)) } }
                }
            } }
        } }
    }
}

/// The smallest N and K whose density lies above the fitted one.
fn inflation(record: &SourceResult) -> Markup {
    let axes: Vec<_> = record.channels.iter().filter_map(|axis| Some((axis, axis.inflation?))).collect();
    let factor = |value: Option<f64>| value.map_or_else(|| NOTHING.into(), |value| format!("{value:.2}"));
    // without an estimate of B or K nothing of the record needs a walk
    let least = |axis: &ChannelResult, term, value: f64| {
        let parameter = axis.noise.as_ref().and_then(|noise| noise.parameter_in_units(term)).filter(|_| value > 0.0);
        parameter
            .map_or_else(|| NOTHING.into(), |parameter| format!("{} {}", digits(value, 3), pretty_unit(parameter.unit)))
    };
    html! {
        @if let Some((_, first)) = axes.first() {
            p {
                "Inflation: the smallest N and K whose density lies above the fitted one at all frequencies from "
                (format!("{:.3}", 1.0 / first.use_s)) " Hz on, K no less than the walk that drifts as B does (" (WALK_OF_FLICKER) " B/√time). A record at rest knows nothing of scale factor, vibration in motion, timing and linearisation, for which filters are inflated further."
            }
            div.scroll { table aria-label="Inflation" {
                thead { tr { th scope="col" { "axis" } th scope="col" { "N at least" } th scope="col" { "over N" } th scope="col" { "K at least" } th scope="col" { "over K" } } }
                tbody { @for (axis, found) in &axes {
                    tr { th scope="row" { (axis.name) } td { (least(axis, Term::White, found.white)) } td { (factor(found.white_factor)) } td { (least(axis, Term::RateRandomWalk, found.walk)) } td { (factor(found.walk_factor)) } }
                } }
            } }
        }
    }
}

/// What to type into each program.
pub(super) fn filters(record: &SourceResult, span_s: f64) -> Markup {
    let noise = FilterNoise::of(record, span_s);
    if let Err(NotWritten::Moved) = Consumer::ALL[0].file(&noise) {
        return html! { p { "Not given: the sensor was moved." } };
    }
    let cell = |value: Option<f64>| value.map_or_else(|| "–".into(), |value| format!("{value:.3e}"));
    html! {
        p {
            "Use N as measured in the stream that the filter consumes; without the aliased noise the filter would trust the stream too much. \
             Programs type N and K differently, since their recursions do: continuous densities [7], variances of a sample, rates of change. \
             None has a place for the bias instability: K stands for it."
        }
        ul { @for label in noise.labels(&TERMS) { li { (label) } } }
        div.scroll { table aria-label="Values by program" {
            thead { tr { th scope="col" { "program" } th scope="col" { "N as" } th scope="col" { "gyroscope" } th scope="col" { "accelerometer" } th scope="col" { "K as" } th scope="col" { "gyroscope" } th scope="col" { "accelerometer" } } }
            tbody { @for consumer in &Consumer::ALL {
                @let [gyro_white, accel_white, gyro_walk, accel_walk] = consumer.typed_values(&noise).map(cell);
                tr {
                    th scope="row" { (consumer.title) } td { (consumer.white.text) } td { (gyro_white) } td { (accel_white) }
                    td { (consumer.walk.map_or("–", |walk| walk.text)) } td { (gyro_walk) } td { (accel_walk) }
                }
            } }
        } }
        (inflation(record))
    }
}
