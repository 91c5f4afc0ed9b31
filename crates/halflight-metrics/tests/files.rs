//! Files are written as `cp` writes them.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

use std::fs::{self, File, Permissions};
use std::io::Read;
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use halflight_metrics::{check_output, is_same_file, is_stream, write_file};

/// Creates an empty folder for one test.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("files-{name}"));
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

#[test]
fn links_lead_to_the_file_that_is_written() {
    let folder = folder("links");
    fs::create_dir(folder.join("store")).unwrap();
    fs::write(folder.join("store/a"), "before").unwrap();
    symlink("store/a", folder.join("one")).unwrap();
    symlink("one", folder.join("two")).unwrap();
    // Leads to a file that is not there yet.
    symlink("store/new", folder.join("dangling")).unwrap();
    symlink("none/new", folder.join("lost")).unwrap();
    symlink("loop", folder.join("loop")).unwrap();
    write_file(&folder.join("two"), b"through two links").unwrap();
    write_file(&folder.join("dangling"), b"created").unwrap();
    assert_eq!(fs::read(folder.join("store/a")).unwrap(), b"through two links");
    assert_eq!(fs::read(folder.join("store/new")).unwrap(), b"created");
    for (name, words) in [("lost", "there is no folder"), ("loop", "symbolic links")] {
        for error in [check_output(&folder.join(name)), write_file(&folder.join(name), b"")] {
            let error = error.unwrap_err();
            assert!(error.source.to_string().contains(words), "{name}: {}", error.source);
        }
    }
    for name in ["one", "two", "dangling", "lost", "loop"] {
        assert!(fs::symlink_metadata(folder.join(name)).unwrap().is_symlink(), "{name}");
    }
    assert_eq!(names(&folder.join("store")), ["a", "new"]);
}

#[test]
fn modes_and_hard_links_stay_for_longer_and_shorter_content() {
    let folder = folder("modes");
    let (single, hard, twin) = (folder.join("single"), folder.join("hard"), folder.join("twin"));
    for content in ["before", "before, and much longer than what is written"] {
        for path in [&single, &hard] {
            let _ = fs::remove_file(path);
            fs::write(path, content).unwrap();
            fs::set_permissions(path, Permissions::from_mode(0o640)).unwrap();
        }
        let _ = fs::remove_file(&twin);
        fs::hard_link(&hard, &twin).unwrap();
        for path in [&single, &hard] {
            write_file(path, b"written after it").unwrap();
            assert_eq!(fs::metadata(path).unwrap().permissions().mode() & 0o7777, 0o640);
        }
        assert_eq!(fs::read(&single).unwrap(), b"written after it");
        assert_eq!(fs::read(&twin).unwrap(), b"written after it");
        assert_eq!(fs::metadata(&twin).unwrap().nlink(), 2);
    }
    assert_eq!(names(&folder), ["hard", "single", "twin"]);
}

#[cfg(target_os = "linux")]
#[test]
fn attributes_stay_with_their_file() {
    use rustix::fs::{XattrFlags, getxattr, setxattr};
    let path = folder("attributes").join("a");
    fs::write(&path, "before").unwrap();
    // Extended attributes are not available on all file systems.
    if setxattr(&path, "user.note", b"kept", XattrFlags::empty()).is_ok() {
        write_file(&path, b"after").unwrap();
        let mut note = [0; 4];
        assert_eq!((getxattr(&path, "user.note", &mut note), &note), (Ok(4), b"kept"));
    }
}

#[test]
fn pipes_and_devices_are_written_to() {
    let folder = folder("pipes");
    let path = folder.join("pipe");
    pipe(&path);
    check_output(&path).unwrap();
    assert!(is_stream(&path) && is_stream(Path::new("/dev/null")) && is_stream(Path::new("-")));
    assert!(!is_stream(&folder.join("none")));
    let from = path.clone();
    let reader = thread::spawn(move || {
        let mut read = Vec::new();
        File::open(from).unwrap().read_to_end(&mut read).unwrap();
        read
    });
    write_file(&path, &[7; 100_000]).unwrap();
    assert_eq!(reader.join().unwrap(), [7; 100_000]);
    assert!(fs::metadata(&path).unwrap().file_type().is_fifo());
    write_file(Path::new("/dev/null"), b"nothing").unwrap();
    assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    if cfg!(target_os = "linux") {
        let full = write_file(Path::new("/dev/full"), b"something").unwrap_err();
        assert_eq!(full.source.kind(), std::io::ErrorKind::StorageFull);
    }
}

#[test]
fn what_cannot_be_written_is_known_beforehand() {
    let folder = folder("refused");
    fs::write(folder.join("plain"), "before").unwrap();
    for (path, words) in [
        (folder.clone(), "it is a folder"),
        (folder.join("none/a"), "there is no folder"),
        (folder.join("plain/a"), "Not a directory"),
        (folder.join("none/"), "the name is a folder's"),
        (PathBuf::new(), "the path names no file"),
    ] {
        for error in [check_output(&path), write_file(&path, b"")] {
            let error = error.unwrap_err();
            assert!(error.source.to_string().contains(words), "{}: {}", path.display(), error.source);
        }
    }
    check_output(&folder.join("plain")).unwrap();
    check_output(&folder.join("new")).unwrap();
    assert_eq!(names(&folder), ["plain"]);
    assert_eq!(fs::read(folder.join("plain")).unwrap(), b"before");
}

#[test]
fn files_in_folders_that_are_closed_are_written_and_closed_files_are_not() {
    let folder = folder("closed");
    let (open, closed) = (folder.join("open"), folder.join("closed"));
    for path in [&open, &closed] {
        fs::write(path, "before").unwrap();
    }
    fs::set_permissions(&closed, Permissions::from_mode(0o444)).unwrap();
    fs::set_permissions(&folder, Permissions::from_mode(0o555)).unwrap();
    // Root may write everywhere.
    let root = File::create(folder.join("new")).is_ok();
    write_file(&open, b"after").unwrap();
    if !root {
        assert!(check_output(&closed).is_err() && write_file(&closed, b"after").is_err());
        assert!(check_output(&folder.join("new")).is_err());
        assert_eq!(fs::read(&closed).unwrap(), b"before");
    }
    fs::set_permissions(&folder, Permissions::from_mode(0o755)).unwrap();
    assert_eq!(fs::read(&open).unwrap(), b"after");
}

#[test]
fn names_of_one_file_are_told_from_names_of_two() {
    let folder = folder("same");
    fs::create_dir(folder.join("sub")).unwrap();
    fs::write(folder.join("a"), "").unwrap();
    fs::write(folder.join("b"), "").unwrap();
    fs::hard_link(folder.join("a"), folder.join("hard")).unwrap();
    symlink("a", folder.join("link")).unwrap();
    symlink("../new", folder.join("sub/dangling")).unwrap();
    pipe(&folder.join("pipe"));
    let same = |a: &str, b: &str| is_same_file(&folder.join(a), &folder.join(b));
    for (a, b) in [
        ("a", "a"),
        ("a", "sub/../a"),
        ("a", "hard"),
        ("link", "hard"),
        ("new", "sub/dangling"),
        ("pipe", "pipe"),
    ] {
        assert!(same(a, b) && same(b, a), "{a} {b}");
    }
    for (a, b) in [("a", "b"), ("a", "new"), ("new", "sub/new"), ("a", "pipe"), ("sub", "sub")] {
        assert!(!same(a, b) && !same(b, a), "{a} {b}");
    }
    assert!(is_same_file(Path::new("-"), Path::new("/dev/stdout")));
    // Devices keep no content.
    assert!(!is_same_file(Path::new("/dev/null"), Path::new("/dev/null")));
}
