use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Returns the source files below a folder, by module path: `refine/lattice`, or `refine` for its `mod.rs`.
fn modules(folder: &Path, prefix: &str, found: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && stem != "tests" {
            modules(&path, &format!("{prefix}{stem}/"), found);
        } else if path.is_file() && stem != "lib" {
            let name =
                if stem == "mod" { prefix.trim_end_matches('/').into() } else { prefix.to_owned() + &stem };
            found.insert(name, fs::read_to_string(&path).unwrap());
        }
    }
}

/// Returns the modules of this crate that a module names, by `crate::` and `super::`, or by `mod` and `pub use` of children.
fn imports<'a>(name: &str, text: &str, known: &'a BTreeMap<String, String>) -> BTreeSet<&'a str> {
    let folder = name.rsplit_once('/').map_or("", |(folder, _)| folder);
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap();
    let starts =
        [("crate::", String::new()), ("super::", format!("{folder}/")), ("mod ", format!("{name}/"))];
    let mut found = BTreeSet::new();
    for (mark, prefix) in starts {
        for (at, _) in text.match_indices(mark) {
            let path = &text[at + mark.len()..];
            let end = path.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(path.len());
            let target = prefix.clone() + &path[..end];
            found.extend(known.get_key_value(&target).map(|(known, _)| known.as_str()));
        }
    }
    found.remove(name);
    found
}

/// Returns the modules that are left when those are removed that import none of the others, over and over.
fn circle(known: &BTreeMap<String, String>) -> BTreeMap<&str, BTreeSet<&str>> {
    let mut left: BTreeMap<&str, BTreeSet<&str>> =
        known.iter().map(|(name, text)| (name.as_str(), imports(name, text, known))).collect();
    loop {
        let names: BTreeSet<&str> = left.keys().copied().collect();
        let before = left.len();
        left.retain(|_, imports| imports.iter().any(|import| names.contains(import)));
        if left.len() == before {
            return left;
        }
    }
}

#[test]
fn modules_import_each_other_in_one_direction() {
    let mut known = BTreeMap::new();
    modules(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), "", &mut known);
    assert!(known.contains_key("refine/lattice") && known.contains_key("refine") && known.len() > 25);
    assert!(imports("stages", &known["stages"], &known).contains("refine"));
    assert!(imports("refine/lattice", &known["refine/lattice"], &known).contains("refine/tracer"));
    assert_eq!(circle(&known), BTreeMap::new());
    known.get_mut("bindings").unwrap().push_str("use crate::refine::Tracer;");
    assert!(circle(&known).contains_key("bindings"), "a circle is found");
}
