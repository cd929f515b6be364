//! The results of a measurement as pages of HTML: the report, and the live page of a measurement under
//! way, which has the parts of the report.
//!
//! [`report_page`] is the report of captures: one file with its figures, tables, style sheet and script.
//! [`state_part`] and [`result_parts`] draw the [`PagePart`]s of the live page, and [`live_page`] puts
//! them together. Pure: no file is opened and no clock is read.

mod caption;
mod elements;
mod facts;
mod figures;
mod filters;
mod glance;
mod lab;
mod live;
mod options;
mod page;
mod parameters;
mod parts;
mod report;
mod several;
mod statistics;
#[cfg(test)]
mod tests;

pub use live::{PageSource, ShownPage, live_page, result_parts, sources_part, state_part};
pub use options::{PageOptions, Program};
pub use parts::PagePart;
pub use report::report_page;

/// The icon of the live page in a browser, as SVG.
pub const LIVE_ICON: &str = include_str!("../assets/icon.svg");
