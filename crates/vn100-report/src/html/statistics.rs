//! Means and standard deviations, one table for each sensor, each with its meaning for this record.

use crate::html::glance;
use crate::{
    evaluation::is_of_vn100,
    figure::{Figure, Figures, id_of},
    names::{NEUTRAL_SERIES, QUANTITIES, names_of},
    numbers::{NOTHING, digits, grouped, signed},
    units::pretty_unit,
};
use maud::{Markup, html};
use vn100_analysis::noise::STANDARD_GRAVITY_M_S2;
use vn100_analysis::protocol::Quantity;
use vn100_analysis::{ChannelResult, Norm, Remedy, RemedyWords, SourceResult};

use crate::html::{
    caption::Captions,
    elements::{row, table},
    figures::grid,
};

/// The rotation rate of the Earth, in rad/s (IERS Conventions, 2010).
const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;

/// A table for each sensor, and below it each channel over time and as a histogram.
pub(crate) fn statistics(record: &SourceResult, figures: &Figures, words: RemedyWords, captions: &Captions) -> Markup {
    let of_channel = |channel: &ChannelResult| {
        let ends = |figure: &&Figure, kind: &str| figure.id.ends_with(&format!("{kind}-{}", id_of(&channel.name)));
        let time = figures.times.iter().find(|figure| ends(figure, "time"));
        time.into_iter().chain(figures.histograms.iter().find(|figure| ends(figure, "histogram"))).collect::<Vec<_>>()
    };
    html! {
        p { "Time plots: the range of the samples in each of at most 96 blocks, one standard deviation on either side of their mean, and the mean; gaps are open. Histograms: the normal curve has the same mean, standard deviation and area." }
        @for quantity in QUANTITIES {
            @let name = names_of(quantity).title;
            @let channels = record.of(quantity);
            @if !channels.is_empty() {
                @let norm = record.norms.iter().find(|norm| norm.quantity == quantity);
                h3 { (name) ", " (pretty_unit(&channels[0].unit)) }
                (values(&channels, norm, &captions.table(&format!("{name}: descriptive statistics"))))
                @if let Some(sentence) = sentence(quantity, &channels, norm) { p { (sentence) } }
                @let drawn: Vec<&Figure> = channels.iter().flat_map(|channel| of_channel(channel)).collect();
                @if !drawn.is_empty() { (grid(drawn, captions)) }
            } @else if quantity == Quantity::Temperature {
                h3 { (name) }
                p { "Not recorded: this message carries no temperature, and none was read between its lines. " @if is_of_vn100(record) { (glance::with_code(&words(&Remedy::ReadTemperature))) "; the message VNIMU carries it." } }
            }
        }
    }
}

fn values(channels: &[&ChannelResult], norm: Option<&Norm>, caption: &Markup) -> Markup {
    let columns = ["channel", "samples", "mean", "std", "min", "max", "skewness", "excess kurtosis"];
    let rows = html! {
        @for channel in channels {
            @let decimals = channel.decimals;
            (row(&channel.name, [
                grouped(channel.statistics.count),
                fixed(channel.statistics.mean, decimals + 3),
                fixed(channel.statistics.std, decimals + 3),
                fixed(channel.statistics.min, decimals),
                fixed(channel.statistics.max, decimals),
                fixed(channel.statistics.skewness, 3),
                fixed(channel.statistics.excess_kurtosis, 3),
            ]))
        }
        @if let Some(norm) = norm {
            @let decimals = norm.decimals.saturating_sub(2);
            @let [mean, std] = [norm.mean, norm.std].map(|value| fixed(value, norm.decimals + 1));
            @let [min, max] = [norm.min, norm.max].map(|value| fixed(value, decimals));
            @let [skewness, kurtosis] = [NOTHING; 2].map(String::from);
            (row(&norm.name, [grouped(norm.count), mean, std, min, max, skewness, kurtosis]))
        }
    };
    table(caption, Some("statistics"), &columns, &rows)
}

fn fixed(value: Option<f64>, decimals: usize) -> String {
    value.map_or(NOTHING.into(), |value| format!("{value:.decimals$}").replace('-', "−"))
}

fn sentence(quantity: Quantity, channels: &[&ChannelResult], norm: Option<&Norm>) -> Option<String> {
    let of_mean = norm.and_then(|norm| norm.of_mean);
    match quantity {
        Quantity::AngularRate => of_mean.map(|rate| {
            format!(
                "Magnitude of the mean rate: {} rad/s ({} °/h); Earth rate: 7.292·10⁻⁵ rad/s (15.04 °/h). The mean of a resting gyroscope is its bias plus the \
                 Earth rate{}.",
                digits(rate, 4),
                digits(rate.to_degrees() * 3600.0, 3),
                if rate < EARTH_RATE_RAD_S { ": here it is below the Earth rate, so that the bias or a filter has removed part of it" } else { "" }
            )
        }),
        Quantity::Acceleration => of_mean.map(|length| {
            format!(
                "Mean specific force: |a| = {length:.4} m/s², {} m/s² from standard gravity ({} %): bias and scale factor error if the sensor was at rest; \
                 local gravity is between 9.764 and 9.834 m/s².",
                signed(length - STANDARD_GRAVITY_M_S2, 4),
                signed(100.0 * (length / STANDARD_GRAVITY_M_S2 - 1.0), 2)
            )
        }),
        Quantity::MagneticField => of_mean.map(|length| {
            let verdict = if (0.22..=0.67).contains(&length) { "within the range of the Earth's field (0.22 to 0.67 gauss)" } else { "outside the range of the Earth's field (0.22 to 0.67 gauss): iron or currents are near, or the calibration is off" };
            format!("Mean field: {length:.4} gauss, {verdict}.")
        }),
        Quantity::Angle => Some("The attitude is the output of the sensor's own filter: its deviations are no sensor noise.".into()),
        Quantity::Temperature => channels[0].statistics.min.zip(channels[0].statistics.max).map(|(min, max)| {
            format!("The sensor's temperature went from {min:.1} to {max:.1} °C. Bias depends on temperature: a range of more than a few degrees raises the deviation at long averaging times.")
        }),
        Quantity::Value => Some(NEUTRAL_SERIES.into()),
        Quantity::Quaternion | Quantity::Pressure => None,
    }
}
