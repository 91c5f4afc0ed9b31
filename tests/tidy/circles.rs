//! Circles of modules: none may use another that uses it, directly or through others, at any level of folders.

use std::fs;

use crate::modules::Modules;
use crate::root;

/// Crates that have circles still. Those that have none any more must leave the list.
const ALLOWED: &[&str] = &[];

/// Returns the circles of a crate made of these modules, each with the names from the crate's root.
fn circles(sources: &[(&str, &str)]) -> Vec<String> {
    let names = |path: &str| path.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect();
    Modules::parse(sources.iter().map(|(path, text)| (names(path), *text))).circles()
}

#[test]
fn no_module_uses_itself_through_others() {
    let mut faults = Vec::new();
    for entry in fs::read_dir(root().join("crates")).unwrap() {
        let folder = entry.unwrap().path();
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        let found = Modules::read(&folder.join("src")).circles();
        match (ALLOWED.contains(&name.as_str()), found.is_empty()) {
            (false, _) => faults.extend(found.iter().map(|circle| format!("{name}: {circle}"))),
            (true, true) => faults.push(format!("{name} has no circle any more: take it off the list")),
            (true, false) => {}
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn a_circle_is_found_whatever_way_it_is_written() {
    let found = circles(&[
        ("", "mod a; mod b; mod c; mod d;"),
        ("a", "use crate::{b::{self, One}, d};"),
        ("b", "fn two() { super::c::three::<u32>() }"),
        ("c", "fn three() { println!(\"{}\", crate::a::one()) }"),
        ("d", "use std::fmt; fn four() {}"),
    ]);
    assert_eq!(found, ["a → b → c → a"]);
}

#[test]
fn siblings_in_a_folder_are_told_from_their_parent() {
    let found = circles(&[
        ("", "mod a; mod b;"),
        ("a", "mod one; mod two; pub use one::One; use two::Two; pub struct Own;"),
        ("a::one", "use super::Own; use crate::b::B; use super::two::Two;"),
        ("a::two", "use super::Own;"),
        ("b", "fn b() {}"),
    ]);
    assert_eq!(found, Vec::<String>::new());
    let found = circles(&[
        ("a", "mod one; mod two; pub use one::One;"),
        ("a::one", "use super::two::Two;"),
        ("a::two", "use super::One;"),
    ]);
    assert_eq!(found, ["a: one → two → one"], "a name is followed through its re-export");
}

#[test]
fn code_of_tests_takes_no_part() {
    let found = circles(&[
        ("a", "use crate::b::B; #[cfg(test)] mod tests { use crate::c::C; }"),
        ("b", "#[cfg(test)] use crate::a::A; #[cfg(all(test, unix))] fn f() { crate::a::g() }"),
        ("c", "use super::a::A; #[cfg(test)] mod more;"),
        ("c::more", "use crate::d::D;"),
        ("d", "use crate::c::C;"),
    ]);
    assert_eq!(found, Vec::<String>::new());
    assert_eq!(circles(&[("a", "#[cfg(not(test))] use crate::b::B;"), ("b", "use crate::a::A;")]).len(), 1);
}
