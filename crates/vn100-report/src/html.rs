//! The results of a measurement as pages of HTML: the report, and the live page of a measurement under
//! way, which has the parts of the report.
//!
//! [`report_page`] is the report of one capture or of several: one file with its figures,
//! tables, style sheet and script. [`state_part`] and [`result_parts`] draw the [`PagePart`]s of the
//! live page, and [`live_page`] puts them together. Numbers, names, figures and summaries are those of
//! [this crate](crate). Pure: no file is opened and no clock is read.
//!
//! | file | is |
//! |---|---|
//! | `report.rs` | the report |
//! | `live.rs` | the live page, and the state of a source |
//! | `parts.rs` | the sections of one record, and their order |
//! | `page.rs` | the frame of every page: head, style sheet, script |
//! | `glance.rs` | identity, trust, a table of each sensor |
//! | `figures.rs` | the figures, and the numbers that can be read off them |
//! | `parameters.rs`, `lab.rs` | noise parameters in all units, verdicts; what laboratories report |
//! | `statistics.rs` | means and standard deviations |
//! | `several.rs` | the comparison of several records |
//! | `facts.rs` | the capture, the sensor's settings and the method |
//! | `caption.rs`, `elements.rs` | captions with their numbers; what all pages are made of |

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
