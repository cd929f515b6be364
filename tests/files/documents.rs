//! The documents: every shown command is run, every named option exists, and every shown output is
//! printed.

mod captures;
mod commands;
mod options;
mod printed;
mod shown;
