//! Names and documents: retired words stay away, ARCHITECTURE.md is complete, and links lead to files.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

mod circles;
mod modules;

/// Names of files and folders that were replaced (see docs/glossary.md), without ending.
const RETIRED_FILES: &[&str] = &[
    "rise",
    "breaks",
    "breaks_gather",
    "foretell",
    "judge",
    "bundle",
    "nearest",
    "shadow",
    "dispatch",
    "at_hand",
    "further",
    "failure",
    "lattice_look",
    "proof",
    "prove",
    "seams",
    "lattice_ask",
    "lattice_judge",
    "lattice_mend",
    "nichols_settle",
    "sfvt_judge",
    "target_expect",
    "target_show",
    "full",
];

/// Words that were replaced in code and comments. Lines that read an old name as an alias may have them.
const RETIRED_WORDS: &[&str] = &[
    "Rise",
    "Proof",
    "Prover",
    "proofs",
    "prove",
    "proved",
    "prover",
    "ProofCounts",
    "RiseLimits",
    "Breaks",
    "Bundle",
    "bundle",
    "bundles",
    "foretell",
    "foretold",
    "torn",
    "Trial",
    "TRIAL",
    "FURTHER_SAMPLES",
    "RefinerConfig::Full",
    "refine::Full",
    "bvh.nearest",
    "fn ask(here",
    "fn expect",
    "fn judge",
    "fn look",
    "fn mend",
    "fn settle",
    "fn show",
    "LightSample",
    "at_hand",
    "graphics device",
    "graphics devices",
    "the processor",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// Files below a folder of the workspace with one of the endings.
fn files(folder: &str, endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut waiting = vec![root().join(folder)];
    while let Some(folder) = waiting.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                waiting.push(path);
            } else if path.extension().is_some_and(|ending| endings.iter().any(|&known| ending == known)) {
                found.push(path);
            }
        }
    }
    assert!(!found.is_empty(), "{folder} has no files");
    found
}

/// True if a text contains a word that is not part of a longer one.
fn has_word(text: &str, word: &str) -> bool {
    let part = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    text.match_indices(word)
        .any(|(at, _)| !part(text[..at].chars().next_back()) && !part(text[at + word.len()..].chars().next()))
}

#[test]
fn retired_names_do_not_come_back() {
    let code: Vec<PathBuf> = ["crates/halflight-cpu", "crates/halflight-gpu", "crates/halflight-core"]
        .iter()
        .flat_map(|folder| files(folder, &["rs", "wgsl"]))
        .collect();
    let mut faults = Vec::new();
    for path in code {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if RETIRED_FILES.contains(&name.as_str()) {
            faults.push(format!("{} has a retired name", path.display()));
        }
        let text = fs::read_to_string(&path).unwrap();
        let text: String = text.split_inclusive('\n').filter(|line| !line.contains("alias = \"")).collect();
        let words = RETIRED_WORDS.iter().filter(|word| has_word(&text, word));
        faults.extend(words.map(|word| format!("{}: {word}", path.display())));
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Names missing from ARCHITECTURE.md.
fn unnamed(text: &str) -> Vec<String> {
    let mut must = BTreeSet::new();
    for folder in ["crates", "crates/halflight-cpu/src"] {
        for entry in fs::read_dir(root().join(folder)).unwrap() {
            must.insert(entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned());
        }
    }
    for entry in fs::read_dir(root()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && !name.starts_with('.') && name != "target" {
            must.insert(name);
        }
    }
    must.remove("lib");
    must.into_iter().filter(|name| !has_word(text, name)).collect()
}

#[test]
fn the_architecture_names_every_crate_folder_and_stage() {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    assert_eq!(unnamed(&text), Vec::<String>::new());
    assert!(
        unnamed(&text.replace("gbuffer", "")).contains(&"gbuffer".to_owned()),
        "what is missing is noticed"
    );
}

/// Link targets of a text that are files.
fn links(text: &str) -> Vec<&str> {
    let parts = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    parts
        .map(|link| link.split('#').next().unwrap())
        .filter(|link| !link.is_empty() && !link.contains("://"))
        .collect()
}

#[test]
fn links_lead_to_files() {
    let mut documents = files("docs", &["md"]);
    documents.extend(
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(|name| root().join(name)),
    );
    for document in documents {
        let text = fs::read_to_string(&document).unwrap();
        for link in links(&text) {
            assert!(document.with_file_name(link).exists(), "{} links to {link}", document.display());
        }
    }
    assert_eq!(links("[a](b.md#c) ![d](e/f.png) [g](https://h) [i](#j)"), ["b.md", "e/f.png"]);
}

#[test]
fn the_readme_is_short() {
    let text = fs::read_to_string(root().join("README.md")).unwrap();
    assert!(text.lines().count() <= 150);
}

/// Files that a source file at `path` includes from outside of the package in `package`.
fn included_from_outside(package: &Path, path: &Path, text: &str) -> Vec<String> {
    let depth = path.strip_prefix(package).unwrap().components().count() - 1;
    let lines =
        text.lines().filter(|line| line.contains("include_str!(") || line.contains("include_bytes!("));
    lines.filter(|line| line.matches("../").count() > depth).map(str::to_owned).collect()
}

#[test]
fn packages_include_their_own_files_only() {
    for package in fs::read_dir(root().join("crates")).unwrap() {
        let package = package.unwrap().path();
        for path in files(&package.to_string_lossy(), &["rs"]) {
            let text = fs::read_to_string(&path).unwrap();
            let outside = included_from_outside(&package, &path, &text);
            assert_eq!(outside, Vec::<String>::new(), "{}", path.display());
        }
    }
    let outside = |text| !included_from_outside(Path::new("a"), Path::new("a/src/b.rs"), text).is_empty();
    assert!(!outside("include_str!(\"../c.toml\")") && outside("include_str!(\"../../c.toml\")"));
}
