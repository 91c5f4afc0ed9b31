//! Stored results carry their origin: every row names its commit and its machine.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

fn tables(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            tables(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "csv") {
            found.push(path);
        }
    }
}

/// Returns the first fault of a table's rows, if any.
fn fault(text: &str) -> Option<String> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().ok()?.clone();
    let column = |name: &str| header.iter().position(|found| found == name);
    let (Some(commit), Some(machine)) = (column("commit"), column("machine")) else {
        return Some("no column commit or machine".into());
    };
    let mut rows = 0;
    for (number, row) in (2..).zip(reader.records()) {
        let Ok(row) = row else { return Some(format!("line {number} cannot be read")) };
        let hash = row[commit].len() >= 7 && row[commit].bytes().all(|byte| byte.is_ascii_hexdigit());
        if !hash || row[machine].is_empty() {
            return Some(format!(
                "line {number} is of commit {:?} and machine {:?}",
                &row[commit], &row[machine]
            ));
        }
        rows += 1;
    }
    (rows == 0).then(|| "no rows".into())
}

#[test]
fn every_stored_row_names_a_clean_commit_and_a_machine() {
    let mut found = Vec::new();
    tables(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../results"), &mut found);
    assert!(found.len() > 20, "{found:?}");
    for path in found {
        assert_eq!(fault(&fs::read_to_string(&path).unwrap()), None, "{}", path.display());
    }
}

#[test]
fn rows_without_origin_are_noticed() {
    assert_eq!(fault("a,commit,machine\n1,26aa678,m\n"), None);
    for wrong in [
        "a,commit,machine\n1,26aa678-dirty,m\n",
        "a,commit,machine\n1,26aa678,\n",
        "a,commit,machine\n1,,m\n",
        "a,commit,machine\n",
        "a,commit\n1,26aa678\n",
    ] {
        assert!(fault(wrong).is_some(), "{wrong}");
    }
}
