//! The figures, each with what it shows in words.

use imu_noise::Deviation;
use maud::{Markup, PreEscaped, html};

use super::points::points;
use crate::{figure::Figure, figures::Figures, numbers::trimmed, record::Record};

pub(super) fn allan(record: &Record<'_>, figures: &Figures) -> Markup {
    let level = trimmed(100.0 * record.assessment().confidence, 2);
    html! {
        p {
            "Bars are " (level) " % intervals, each alone at that level; points with fewer than two degrees of freedom have none. "
            @if record.snapshot().deviation == Deviation::Allan {
                "The thick line is the fitted model over the averaging times it was fitted to; the thin ones are its white noise (dashed), flat part (dotted) and random walk (dash-dotted), each only where it is \
                 estimated, with a mark where its letter is read: N at 1 s, K at 3 s. Hollow marks are what the graphical rules read: a ring for N, a square for the minimum, a triangle for K."
            } @else {
                "The lines of N, B and K are of the Allan deviation and are not drawn here."
            }
        }
        (grid(&figures.allan_sensors))
        (grid(&figures.allan_axes))
        (points(record))
    }
}

pub(super) fn time(figures: &Figures) -> Markup {
    html! {
        p { "The record in at most 96 blocks of equal length: the range of the samples in each, one standard deviation on either side of their mean, and the mean. Gaps are left open. Angles are continuous over ±180°." }
        (grid(&figures.times))
    }
}

pub(super) fn histograms(figures: &Figures) -> Markup {
    html! {
        p { "The normal curve has the same mean, standard deviation and area as the bars. Whether the values are normally distributed is judged from skewness and kurtosis, with the errors that correlated and rounded samples have [7]." }
        (grid(&figures.histograms))
    }
}

pub(super) fn spectrum(figures: &Figures) -> Markup {
    html! {
        p { "Amplitude density by Welch's method with a Hann window [5], one-sided: white noise lies at √2 N. Marks are lines that a clean record shows with a probability below 10⁻⁴; a line may be the alias of one above half the sample rate." }
        (grid(&figures.spectra))
        p { "The standard deviation of the samples within each segment of the record: level where the record is as quiet all the time." }
        (grid(&figures.segments))
    }
}

pub(super) fn grid(figures: &[Figure]) -> Markup {
    html! {
        @if figures.is_empty() { p.absent { "Too short a record for such a figure." } }
        div.grid {
            @for figure in figures {
                figure id={ "figure-" (figure.id) } { (PreEscaped(figure.svg_element())) }
            }
        }
    }
}
