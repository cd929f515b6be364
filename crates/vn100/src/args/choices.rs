//! An option that takes one of several names, each with its help.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

pub(super) fn one_of<T: Copy + Send + Sync>(choices: &'static [(&str, &str, T)]) -> impl TypedValueParser<Value = T> {
    let described = choices.iter().map(|(name, help, _)| PossibleValue::new(*name).help(*help));
    PossibleValuesParser::new(described).try_map(|name| {
        choices.iter().find(|(known, ..)| *known == name).map(|(.., choice)| *choice).ok_or("unknown choice")
    })
}
