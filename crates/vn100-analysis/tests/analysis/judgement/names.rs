//! The names that results have for kinds: as in the code, in lower case, with hyphens.

use std::fmt::Debug;

use vn100_analysis::WarningKind;

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
fn warnings_are_named() {
    let kinds = WarningKind::ALL.into_iter().filter(|kind| *kind != WarningKind::RejectedLines);
    assert_named(&kinds.collect::<Vec<_>>(), WarningKind::name);
    // as scripts know it
    assert_eq!(WarningKind::RejectedLines.name(), "bad-lines");
}
