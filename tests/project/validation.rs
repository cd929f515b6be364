//! `docs/validation.md` lists each reference of the self-test, with its conclusion.

use std::{fs, path::Path, process::Command};

#[test]
fn each_reference_and_the_conclusion_of_the_self_test_are_in_the_document() {
    let document = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/validation.md");
    let document = fs::read_to_string(document).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_vn100")).arg("selftest").output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    // values are indented
    let lines: Vec<&str> = printed.lines().filter(|line| !line.is_empty() && !line.starts_with(' ')).collect();
    assert!(output.status.success() && lines.len() >= 5, "{printed}");
    let missing: Vec<&&str> = lines.iter().filter(|line| !document.contains(**line)).collect();
    assert!(missing.is_empty(), "docs/validation.md lacks {missing:?}");
}
