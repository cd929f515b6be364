//! The compiled part of the Python package `vn100`. It takes paths, arrays and options, and gives
//! the documents of the command line; classes around these are in `python/vn100/`.

mod analyzer;
mod archive;
mod captures;
mod deviations;
mod measured;
mod options;
mod rows;
mod sessions;
mod simulated;

use pyo3::prelude::*;

/// The compiled part of the package.
#[pymodule]
mod _vn100 {
    #[pymodule_export]
    use super::analyzer::Sums;
    #[pymodule_export]
    use super::archive::archive_rows;
    #[pymodule_export]
    use super::captures::captures;
    #[pymodule_export]
    use super::deviations::deviations;
    #[pymodule_export]
    use super::measured::{CaptureError, Measured};
    #[pymodule_export]
    use super::rows::Rows;
    #[pymodule_export]
    use super::sessions::replay;
    #[pymodule_export]
    use super::simulated::simulated;
}
