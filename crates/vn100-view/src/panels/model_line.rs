//! A line of a model in the plot.

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ModelLine {
    /// Its letter; `None` for the whole.
    pub(crate) term: Option<&'static str>,
    /// Averaging time in seconds and deviation.
    pub(crate) points: Vec<(f64, f64)>,
}
