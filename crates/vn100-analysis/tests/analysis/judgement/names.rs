//! The names that results have for kinds and reasons: as in the code, in lower case, with hyphens.

use std::fmt::Debug;

use vn100_analysis::{CaveatKind, Untested, WarningKind, WhyNone, WhyUse};

fn assert_named<K: Copy + Debug>(kinds: &[K], name: fn(K) -> &'static str) {
    for kind in kinds {
        let mut expected = String::new();
        for letter in format!("{kind:?}").chars() {
            if letter.is_uppercase() && !expected.is_empty() {
                expected.push('-');
            }
            expected.extend(letter.to_lowercase());
        }
        assert_eq!(name(*kind), expected);
    }
}

#[test]
fn caveats_are_named() {
    use CaveatKind::*;
    assert_named(&[NoSamples, RateAssumed, Channels, NoCommonTau, Sampling, Compensation], CaveatKind::name);
    assert_named(&[SeveralSensors, Moved, SameSamples, StartUnknown, MayHaveBeenOff], CaveatKind::name);
}

#[test]
fn reasons_are_named() {
    use Untested::*;
    assert_named(&[SeveralSensors, SameSamples, StartUnknown, MayHaveBeenOff, SameTime, NoiseUnknown], Untested::name);
    use WhyUse::*;
    assert_named(&[OnlyUndisturbed, Quietest, LongestOfQuiet, SmallestOfQuiet], WhyUse::name);
    assert_named(&[WhyNone::SeveralSensors, WhyNone::AllDisturbed, WhyNone::NotRanked], WhyNone::name);
}

#[test]
fn warnings_are_named() {
    let kinds = WarningKind::ALL.into_iter().filter(|kind| *kind != WarningKind::RejectedLines);
    assert_named(&kinds.collect::<Vec<_>>(), WarningKind::name);
    // as scripts know it
    assert_eq!(WarningKind::RejectedLines.name(), "bad-lines");
}
