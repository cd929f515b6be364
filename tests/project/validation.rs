//! What `docs/validation.md` says of the self-test is what the program prints.

use std::{fs, path::Path, process::Command};

#[test]
fn the_table_of_the_document_is_that_of_the_program() {
    let document = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/validation.md");
    let document = fs::read_to_string(document).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_vn100")).arg("selftest").output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && printed.lines().count() > 40, "{printed}");
    let missing: Vec<&str> = printed.lines().filter(|line| !document.contains(line)).collect();
    assert!(document.contains(&printed), "docs/validation.md lacks what is printed, {missing:#?}");
}
