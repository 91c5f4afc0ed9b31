//! Properties of files that operating systems know by different names.

use std::fs::{File, Metadata, OpenOptions};
use std::io;
use std::path::Path;

/// Creates a file that is readable only by those who may read the file `old`, which it is to replace.
#[cfg(unix)]
pub(super) fn new_file(path: &Path, old: Option<&Metadata>) -> io::Result<File> {
    use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
    let mode = old.map_or(0o666, |old| old.mode() & 0o777);
    OpenOptions::new().write(true).create_new(true).mode(mode).open(path)
}

#[cfg(not(unix))]
pub(super) fn new_file(path: &Path, _: Option<&Metadata>) -> io::Result<File> {
    OpenOptions::new().write(true).create_new(true).open(path)
}

/// True if a new file can replace the file at `path` and keep its owner, hard links and attributes.
#[cfg(unix)]
pub(super) fn may_replace(new: &Metadata, path: &Path, old: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (new.uid(), new.gid(), 1) == (old.uid(), old.gid(), old.nlink()) && !has_attributes(path)
}

/// True if access control lists or other attributes are attached to a file: their names do not fit into one
/// byte.
#[cfg(target_os = "linux")]
fn has_attributes(path: &Path) -> bool {
    rustix::fs::listxattr(path, &mut [0]) == Err(rustix::io::Errno::RANGE)
}

#[cfg(all(unix, not(target_os = "linux")))]
fn has_attributes(_: &Path) -> bool {
    false
}

#[cfg(not(unix))]
pub(super) fn may_replace(_: &Metadata, _: &Path, _: &Metadata) -> bool {
    true
}

/// True if two paths lead to one file or pipe. Devices keep no content that could be lost and are never
/// equal.
#[cfg(unix)]
pub(super) fn is_same_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::{FileTypeExt, MetadataExt};
    let identity = |path: &Path| {
        let found = std::fs::metadata(path).ok().filter(|found| !found.file_type().is_char_device())?;
        Some((found.dev(), found.ino()))
    };
    identity(a).is_some() && identity(a) == identity(b)
}

#[cfg(not(unix))]
pub(super) fn is_same_file(a: &Path, b: &Path) -> bool {
    a == b
}
