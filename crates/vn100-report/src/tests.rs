//! What is drawn and written of one record, from its samples to the text.

mod drawn;
mod faces;
pub(crate) mod fixture;
mod written;
