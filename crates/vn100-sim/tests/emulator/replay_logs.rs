//! The captures that ship with the project are what their recipe writes.

#[path = "../../examples/replay_logs/main.rs"]
#[allow(dead_code, reason = "the recipe's own main")]
mod recipe;

use std::{fs, path::Path};

#[test]
fn captures_are_what_the_recipe_writes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../replay-logs");
    for recipe::Log { name, bytes } in recipe::logs().unwrap() {
        let shipped = fs::read(folder.join(name)).unwrap();
        assert!(shipped == bytes, "{name} differs: run the example replay_logs, or undo the change");
    }
}
