//! Each variant of a type whose values are written as codes has a code of its own, with its word.

use std::{collections::BTreeMap, fs, path::Path};

use vn100_report::{Code, all_codes};

/// Where the variants of each key are, and the name of their type; of a type that embeds another
/// one, that as well.
const TYPES: [(&str, &[(&str, &str)]); 10] = [
    ("verdict", &[("imu-noise/src/infer/verdict.rs", "Verdict")]),
    ("decided_by", &[("vn100-analysis/src/datasheet.rs", "DecidedBy")]),
    ("status", &[("imu-noise/src/infer/noise_model/parameter.rs", "Status")]),
    ("grade", &[("imu-noise/src/infer/verdict.rs", "Grade")]),
    ("rate_from", &[("vn100-analysis/src/snapshot.rs", "RateFrom")]),
    ("missing_from", &[("vn100-analysis/src/snapshot.rs", "MissingFrom")]),
    ("window_from", &[("vn100-analysis/src/assessment/onboard.rs", "WindowFrom")]),
    ("end_reason", &[("vn100-analysis/src/source_facts.rs", "EndKind")]),
    ("withheld", &[("vn100-analysis/src/assessment/noise.rs", "Withheld")]),
    (
        "temperature.reason",
        &[
            ("vn100-analysis/src/assessment/axis_temperature.rs", "WhyNoCoefficient"),
            ("imu-noise/src/infer/temperature.rs", "NoCoefficient"),
        ],
    ),
];

fn crates() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// The number of variants of an enumeration in that source; an embedded type is one.
fn variants(source: &str, name: &str) -> usize {
    let (_, body) = source.split_once(&format!("pub enum {name} {{\n")).unwrap_or_else(|| panic!("no enum {name}"));
    let (body, _) = body.split_once("\n}").unwrap();
    let ends_variant =
        |line: &&str| line.starts_with("    ") && !line[4..].starts_with([' ', '/']) && line.ends_with(',');
    body.lines().filter(ends_variant).count()
}

#[test]
fn every_variant_has_a_code_of_its_own() {
    let codes = all_codes();
    let mut of_key: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for Code { key, code, word, meaning } in &codes {
        assert!(!word.is_empty() && !meaning.is_empty() && !meaning.ends_with('.'), "{key} {code}");
        of_key.entry(key).or_default().push(code);
    }
    assert_eq!(of_key.len(), TYPES.len());
    for (key, types) in TYPES {
        let of_type = |(file, name): &(&str, &str)| variants(&fs::read_to_string(crates().join(file)).unwrap(), name);
        let expected = types.iter().map(of_type).sum::<usize>() + 1 - types.len();
        let mut found = of_key[key].clone();
        assert_eq!(found.len(), expected, "{types:?} have other variants than the codes of {key}");
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), of_key[key].len(), "two variants of {types:?} have one code");
    }
}

#[test]
fn variants_are_counted() {
    let source = "/// X,\npub enum X {\n    /// One, or\n    A,\n    /// two,\n    #[x]\n    B {\n        b: u8,\n    },\n}\npub enum Y {\n    C,\n}\n";
    assert_eq!((variants(source, "X"), variants(source, "Y")), (2, 1));
}
