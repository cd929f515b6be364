//! What records of simulated sensors say: verdicts, comparisons, warnings, plans.

mod comparisons;
mod parameters;
mod plans;
mod sheets;
mod simulated;
mod warnings;
