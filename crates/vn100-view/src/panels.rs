//! What is drawn: a file for each panel, and what several of them share.

pub(crate) mod allan;
pub(crate) mod channels;
pub(crate) mod health;
pub(crate) mod overview;
pub(crate) mod parameters;
pub(crate) mod plot;
pub(crate) mod spectrum;
pub(crate) mod waiting;
pub(crate) mod warnings;
