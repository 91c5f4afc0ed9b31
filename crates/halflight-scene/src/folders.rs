//! Case-insensitive lookup of files.

use std::collections::HashMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Listed folders and the names in them, each folder listed once.
#[derive(Default)]
pub(crate) struct Folders {
    listed: HashMap<PathBuf, HashMap<String, OsString>>,
}

impl Folders {
    /// Finds the file at `relative` in `folder`, component by component: the exact name, or else the first
    /// name, in order, that differs only in case.
    pub(crate) fn find(&mut self, folder: &Path, relative: &Path) -> Option<PathBuf> {
        let mut found = folder.to_path_buf();
        for part in relative.components() {
            let exact = found.join(part);
            let Component::Normal(name) = part else {
                found = exact;
                continue;
            };
            found = if exact.exists() {
                exact
            } else {
                found.join(self.names(&found).get(&name.to_string_lossy().to_lowercase())?)
            };
        }
        found.is_file().then_some(found)
    }

    /// Names in `folder` by their lower-case form.
    fn names(&mut self, folder: &Path) -> &HashMap<String, OsString> {
        self.listed.entry(folder.to_path_buf()).or_insert_with(|| {
            // An empty path means the current folder to `join`, but not to `read_dir`.
            let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            let mut names: HashMap<String, OsString> = HashMap::new();
            for entry in fs::read_dir(listed).into_iter().flatten().flatten() {
                let name = entry.file_name();
                let known =
                    names.entry(name.to_string_lossy().to_lowercase()).or_insert_with(|| name.clone());
                if name < *known {
                    *known = name;
                }
            }
            names
        })
    }
}

/// Path of a file name: exporters on Windows write backslashes.
pub(crate) fn path_of(name: &[u8]) -> PathBuf {
    String::from_utf8_lossy(name).replace('\\', "/").into()
}

/// Folder as shown in messages: the current one is not empty.
pub(crate) fn shown(folder: &Path) -> String {
    if folder.as_os_str().is_empty() { "./".to_string() } else { folder.display().to_string() }
}
