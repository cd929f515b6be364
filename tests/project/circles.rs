//! No file of a crate depends on another in a circle. A module depends on the files of its folder
//! that it uses or re-exports. A file that takes a name from a module depends on that module and on
//! the file that defines the name. Names that a file takes from the module above it are not counted.

use std::collections::{BTreeMap, BTreeSet};

use crate::source::{source_files, without_strings};

/// A module by its path from the root of its crate, or the path of an item.
type Module = Vec<String>;

/// A file: the paths that it names, resolved to its crate, and the names that it imports.
#[derive(Default)]
struct Uses {
    paths: Vec<Module>,
    imports: BTreeMap<String, Module>,
}

/// The modules of a crate with the text of each, without strings, comments and tests.
fn modules(of_crate: &str, files: &[(String, String)]) -> BTreeMap<Module, String> {
    let source = format!("{of_crate}/src/");
    let inside = files.iter().filter_map(|(name, text)| Some((name.strip_prefix(&source)?.strip_suffix(".rs")?, text)));
    let module = |name: &str| -> Module {
        let parts = name.split('/').filter(|part| !["lib", "main", "mod"].contains(part));
        parts.map(str::to_owned).collect()
    };
    let code = |text: &str| {
        let text = without_strings(text);
        let (mut kept, mut lines) = (String::new(), text.lines());
        while let Some(line) = lines.next() {
            // tests are a file of their own, or are at the end
            if line.trim().starts_with("#[cfg(test)]") {
                match lines.next() {
                    Some(item) if item.trim_end().ends_with(';') => continue,
                    _ => break,
                }
            }
            kept += line.split("//").next().unwrap_or_default();
            kept.push('\n');
        }
        kept
    };
    inside.map(|(name, text)| (module(name), code(text))).collect()
}

/// Words, `::` and single signs.
fn tokens(code: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = code.trim_start();
    while !rest.is_empty() {
        let word = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let sign = rest.chars().next().map_or(0, char::len_utf8);
        let length = if word > 0 {
            word
        } else if rest.starts_with("::") {
            2
        } else {
            sign
        };
        tokens.push(&rest[..length]);
        rest = rest[length..].trim_start();
    }
    tokens
}

fn is_word(token: Option<&&str>) -> bool {
    token.is_some_and(|token| token.starts_with(|c: char| c.is_alphabetic() || c == '_'))
}

/// Every path of the tree that begins at a token, with the name under which it is imported; returns
/// the token after it.
fn path_tree(tokens: &[&str], mut at: usize, prefix: &[String], found: &mut Vec<(Module, String)>) -> usize {
    let mut path = prefix.to_vec();
    loop {
        if tokens.get(at) == Some(&"{") {
            at += 1;
            while at < tokens.len() && tokens[at] != "}" {
                at = path_tree(tokens, at, &path, found).max(at + 1);
                at += usize::from(tokens.get(at) == Some(&","));
            }
            return at + 1;
        }
        if !is_word(tokens.get(at)) {
            found.push((path, String::new()));
            return at;
        }
        if tokens[at] != "self" || path.is_empty() {
            path.push(tokens[at].to_owned());
        }
        at += 1;
        if tokens.get(at) == Some(&"::") {
            at += 1;
            continue;
        }
        let renamed = tokens.get(at) == Some(&"as");
        let name = if renamed { tokens[at + 1].to_owned() } else { path.last().cloned().unwrap_or_default() };
        found.push((path, name));
        return at + if renamed { 2 } else { 0 };
    }
}

/// A path as written in a module, from the root of the crate; nothing if it leads to another crate.
fn resolved(path: &[String], module: &Module, all: &BTreeMap<Module, String>) -> Option<Module> {
    let mut base = match path.first()?.as_str() {
        "crate" => Vec::new(),
        "self" | "super" => module.clone(),
        child => {
            let below: Module = module.iter().cloned().chain([child.to_owned()]).collect();
            return all.contains_key(&below).then(|| module.iter().chain(path).cloned().collect());
        }
    };
    let rest = path.iter().skip_while(|word| ["crate", "self", "super"].contains(&word.as_str()));
    let up = path.iter().filter(|word| *word == "super").count();
    base.truncate(base.len().checked_sub(up)?);
    Some(base.into_iter().chain(rest.cloned()).collect())
}

fn uses(module: &Module, code: &str, all: &BTreeMap<Module, String>) -> Uses {
    let (tokens, mut uses) = (tokens(code), Uses::default());
    let mut at = 0;
    while at < tokens.len() {
        let imports = at > 0 && tokens[at - 1] == "use";
        let begins = is_word(tokens.get(at)) && (imports || tokens.get(at + 1) == Some(&"::"));
        if !begins || at > 0 && tokens[at - 1] == "::" {
            at += 1;
            continue;
        }
        let mut found = Vec::new();
        at = path_tree(&tokens, at, &[], &mut found);
        for (path, name) in found {
            let Some(path) = resolved(&path, module, all) else { continue };
            if imports {
                uses.imports.insert(name, path.clone());
            }
            uses.paths.push(path);
        }
    }
    uses
}

/// The module that defines the item of a path, and before it the modules that re-export it.
fn through(mut path: Module, all: &BTreeMap<Module, Uses>) -> Vec<Module> {
    let mut modules = Vec::new();
    for _ in 0..8 {
        let length = (0..=path.len()).rev().find(|length| all.contains_key(&path[..*length])).unwrap_or_default();
        let module = path[..length].to_vec();
        let handed_on = path.get(length).and_then(|name| all.get(&module)?.imports.get(name));
        modules.push(module);
        match handed_on {
            Some(import) if *import != path => path = import.iter().chain(&path[length + 1..]).cloned().collect(),
            _ => break,
        }
    }
    modules
}

/// Each use of a module by another on which it depends itself, directly or indirectly.
fn circles(of_crate: &str, files: &[(String, String)]) -> Vec<String> {
    let code = modules(of_crate, files);
    let all: BTreeMap<Module, Uses> =
        code.iter().map(|(module, text)| (module.clone(), uses(module, text, &code))).collect();
    let direct = |(module, uses): (&Module, &Uses)| -> BTreeSet<Module> {
        let used = uses.paths.iter().flat_map(|path| through(path.clone(), &all));
        used.filter(|other| !module.starts_with(other)).collect()
    };
    let direct: BTreeMap<&Module, BTreeSet<Module>> = all.iter().map(|each| (each.0, direct(each))).collect();
    let reaches = |from: &Module, to: &Module| {
        let (mut reached, mut next) = (BTreeSet::new(), vec![from]);
        while let Some(module) = next.pop() {
            next.extend(direct[module].iter().filter(|other| reached.insert((*other).clone())));
        }
        reached.contains(to)
    };
    let uses = direct.iter().flat_map(|(from, others)| others.iter().map(|to| (*from, to)));
    let in_circle = uses.filter(|(from, to)| reaches(to, from));
    in_circle.map(|(from, to)| format!("{of_crate}: {} uses {}", from.join("::"), to.join("::"))).collect()
}

#[test]
fn no_file_depends_on_another_in_a_circle() {
    let files = source_files();
    let crates: BTreeSet<&str> = files.iter().filter_map(|(name, _)| name.split('/').next()).collect();
    let found: Vec<String> = crates.iter().flat_map(|of_crate| circles(of_crate, &files)).collect();
    assert!(found.is_empty(), "in circles:\n{}", found.join("\n"));
}

#[test]
fn a_circle_is_found_through_a_name_that_is_handed_on() {
    let file = |name: &str, text: &str| (format!("x/src/{name}.rs"), text.to_owned());
    let lib = file("lib", "mod a; mod b; mod c;\npub use b::{self, Second as Other};");
    let a = file("a", "use crate::{Other, c::Third};\npub struct First(Other);");
    let c = file("c", "pub struct Third; // crate::a::First\n#[cfg(test)]\nuse crate::a::First;");
    let b = |text: &str| [lib.clone(), a.clone(), c.clone(), file("b", text)];
    assert_eq!(circles("x", &b("pub struct Second(super::a::First);")), ["x: a uses b", "x: b uses a"]);
    assert_eq!(circles("x", &b("pub struct Second(super::c::Third);")), [""; 0]);
}

#[test]
fn a_circle_is_found_through_a_module_and_a_file_of_its_folder() {
    let file = |name: &str, text: &str| (format!("x/src/{name}.rs"), text.to_owned());
    let of = |first: &str, other: &str| {
        let lib = file("lib", "mod a; mod b;");
        let a = file(
            "a",
            "#[cfg(test)]\nmod tests;\nmod first; mod second;\npub use first::First; pub use second::Second;",
        );
        let second = file("a/second", "use super::First;\npub struct Second(First);");
        circles("x", &[lib, a, file("a/first", first), second, file("b", other)])
    };
    let uses_b = "pub struct First(crate::b::Other);";
    let found = of(uses_b, "pub struct Other(crate::a::Second);");
    assert!(
        ["x: a uses a::first", "x: a::first uses b", "x: b uses a"].iter().all(|use_| found.contains(&(*use_).into())),
        "{found:?}"
    );
    assert_eq!(of(uses_b, "pub struct Other;"), [""; 0]);
    assert_eq!(of("pub struct First;", "pub struct Other(crate::a::Second);"), [""; 0]);
}
