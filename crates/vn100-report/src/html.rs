//! The results of a measurement as pages of HTML: the report, and the page of a measurement under
//! way.
//!
//! [`write_page`] writes the report of one capture or of several: one file with its figures,
//! tables, style sheet and scripts. The live page is made of [`PagePart`]s, which [`now_part`],
//! [`result_parts`], [`signal_part`] and [`sources_part`] draw; [`live_page`] puts them together.
//! Numbers, names, figures and summaries are those of [this crate](crate). Pure: no file is opened and
//! no clock is read; what is written goes into a writer of the caller's.
//!
//! | file | is |
//! |---|---|
//! | `report.rs` | the report, and the order of its sections |
//! | `options.rs` | what a report says besides its results |
//! | `live.rs` | the live page and its parts |
//! | `glance.rs` | the beginning of a report: identity, trust, verdicts, a table of each sensor |
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
mod parameters;
mod report;
mod several;
mod statistics;
#[cfg(test)]
mod tests;

pub use live::{
    LiveStage, PagePart, PageSource, live_icon, live_page, live_script, live_style, now_part, result_parts,
    signal_part, sources_part,
};
pub use options::{PageOptions, Program};
pub use report::write_page;
