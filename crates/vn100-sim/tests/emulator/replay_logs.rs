//! The captures of the project equal the output of the example that writes them.

#[path = "../../examples/replay_logs/main.rs"]
#[allow(dead_code, reason = "the recipe's own main")]
mod recipe;

use std::{fs, path::Path};

#[test]
fn captures_equal_the_output_of_the_example() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../replay-logs");
    for recipe::Log { name, bytes } in recipe::logs().unwrap() {
        let shipped = fs::read(folder.join(name)).unwrap();
        assert!(shipped == bytes, "{name} differs: run the example replay_logs, or undo the change");
    }
}
