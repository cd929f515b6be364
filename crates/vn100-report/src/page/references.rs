//! What the text refers to by number.

use maud::{Markup, html};

const REFERENCES: [&str; 8] = [
    "D. W. Allan, \"Statistics of atomic frequency standards\", Proc. IEEE 54 (1966), 221-230.",
    "W. J. Riley, \"Handbook of Frequency Stability Analysis\", NIST Special Publication 1065 (2008).",
    "C. A. Greenhall and W. J. Riley, \"Uncertainty of stability variances based on finite differences\", 35th PTTI Meeting (2003).",
    "IEEE Std 952-1997, \"IEEE Standard Specification Format Guide and Test Procedure for Single-Axis Interferometric Fiber Optic Gyros\", annex C; IEEE Std 1293 for accelerometers.",
    "P. D. Welch, \"The use of fast Fourier transform for the estimation of power spectra\", IEEE Trans. Audio Electroacoust. 15 (1967), 70-73.",
    "A. C. Harvey, \"Forecasting, Structural Time Series Models and the Kalman Filter\" (1989): steps and warm-up.",
    "Z. A. Lomnicki, \"Tests for departure from normality in the case of linear stochastic processes\", Metrika 4 (1961), 37-62.",
    "Kalibr, \"IMU noise model\", the page of that name in the project's documentation: continuous-time densities and their units.",
];

pub(super) fn references() -> Markup {
    html! {
        ol.references { @for reference in REFERENCES { li { (reference) } } }
    }
}
