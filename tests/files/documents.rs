//! The documents: every command that they show is run, every option that they name exists, and
//! what they show as printed is.

mod captures;
mod commands;
mod options;
mod printed;
mod shown;
