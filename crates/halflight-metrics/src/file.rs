//! Files written the way `cp` writes them: whatever a path leads to stays what it is.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{MAIN_SEPARATOR, Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};

use thiserror::Error;

mod system;

/// A file that could not be written. What was there before is still there, and no other file is left behind.
#[derive(Debug, Error)]
#[error("cannot write {}", shown(path))]
pub struct WriteError {
    /// The path as it was given.
    pub path: PathBuf,
    /// Reason.
    pub source: io::Error,
}

/// Names that the system gives to standard output, and the one that programs give to it.
const STANDARD_OUTPUT: [&str; 4] = ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];

/// Folders in which the system keeps names of open files. A file that is reached by one is not replaced, since whoever holds it open
/// would not see the new one.
const OPEN_FILES: [&str; 3] = ["/dev/fd", "/dev/stderr", "/proc"];

/// The most symbolic links that are followed, as in Linux.
const MAX_LINKS: usize = 40;

/// A path in messages.
fn shown(path: &Path) -> String {
    if is_standard_output(path) { "to standard output".to_owned() } else { path.display().to_string() }
}

/// Destination of a path.
enum Target {
    StandardOutput,
    /// A pipe, a device or an open file.
    Stream(PathBuf),
    /// A plain file, links followed.
    Plain(PathBuf),
    /// A name that is not taken, links followed.
    New(PathBuf),
}

impl Target {
    fn of(path: &Path) -> io::Result<Self> {
        if is_standard_output(path) {
            return Ok(Self::StandardOutput);
        }
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => Err(invalid("it is a folder")),
            Ok(found) if found.is_file() && !OPEN_FILES.iter().any(|folder| path.starts_with(folder)) => {
                fs::canonicalize(path).map(Self::Plain)
            }
            Ok(_) => Ok(Self::Stream(path.to_owned())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => new_name(path).map(Self::New),
            Err(error) => Err(error),
        }
    }
}

/// The name at the end of a chain of symbolic links that leads to nothing, in a folder that is there.
fn new_name(path: &Path) -> io::Result<PathBuf> {
    let mut name = path.to_owned();
    for _ in 0..MAX_LINKS {
        let folder = name.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Ok(to) = fs::read_link(&name) {
            name = folder.map_or_else(|| to.clone(), |folder| folder.join(&to));
            continue;
        }
        if name.as_os_str().to_string_lossy().ends_with(['/', MAIN_SEPARATOR]) {
            return Err(invalid("the name is a folder's"));
        }
        if name.file_name().is_none() {
            return Err(invalid("the path names no file"));
        }
        return match folder {
            Some(folder) if !folder.is_dir() => {
                let message = format!("there is no folder {}", folder.display());
                Err(io::Error::new(io::ErrorKind::NotFound, message))
            }
            _ => Ok(name),
        };
    }
    Err(invalid("too many symbolic links"))
}

fn invalid(message: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, message)
}

/// Writes `content` to what `path` leads to, the way `cp` does. Plain files are written whole or not at all.
///
/// | the path is | result |
/// | --- | --- |
/// | `-`, `/dev/stdout` | the content goes to standard output; a reader that has gone away is no error |
/// | a named pipe or a device | the content goes into it |
/// | a symbolic link | its target is written, or created where it leads to nothing; the link stays |
/// | a plain file | replaced in one step where owner, mode, hard links and attributes stay, otherwise rewritten in place |
/// | not there | created in one step |
/// | a folder, or in a missing folder | an error |
///
/// # Errors
/// [`WriteError`] where the path leads to a folder or into a missing one, permissions are missing or the disk is full.
pub fn write_file(path: &Path, content: &[u8]) -> Result<(), WriteError> {
    let written = Target::of(path).and_then(|target| match target {
        Target::StandardOutput => standard_output(content),
        Target::Stream(path) => OpenOptions::new().write(true).truncate(true).open(path)?.write_all(content),
        Target::New(path) => create(&path, None, content),
        Target::Plain(path) => {
            // As with `cp`, the file itself has to be writable, not only its folder.
            let file = OpenOptions::new().write(true).open(&path)?;
            let old = file.metadata()?;
            let replaced = create(&path, Some(&old), content);
            replaced.or_else(|_| rewrite(file, old.len(), content))
        }
    });
    written.map_err(|source| WriteError { path: path.to_owned(), source })
}

/// Checks what can be known about an output before the work is done that it is made by: its folder is there, and the file
/// may be written. Pipes and devices are not opened.
///
/// # Errors
/// [`WriteError`] as [`write_file`] would have it.
pub fn check_output(path: &Path) -> Result<(), WriteError> {
    let checked = Target::of(path).and_then(|target| match target {
        Target::StandardOutput | Target::Stream(_) => Ok(()),
        Target::Plain(path) => OpenOptions::new().write(true).open(path).map(drop),
        Target::New(path) => {
            let temporary = temporary_name(&path);
            File::create_new(&temporary).and_then(|_| fs::remove_file(&temporary))
        }
    });
    checked.map_err(|source| WriteError { path: path.to_owned(), source })
}

/// Tells whether a path is a name of standard output.
pub fn is_standard_output(path: &Path) -> bool {
    STANDARD_OUTPUT.iter().any(|name| path == Path::new(name))
}

/// Tells whether a path leads to standard output, a pipe or a device, which take one content after another.
pub fn is_stream(path: &Path) -> bool {
    matches!(Target::of(path), Ok(Target::StandardOutput | Target::Stream(_)))
}

/// Tells whether two paths lead to one file, pipe or standard output, by whatever names. Devices keep nothing that could be
/// lost and are never the same.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    match (Target::of(a), Target::of(b)) {
        (Ok(Target::StandardOutput), Ok(Target::StandardOutput)) => true,
        (Ok(Target::New(a)), Ok(Target::New(b))) => {
            let folder = |path: &Path| match path.parent() {
                Some(folder) if !folder.as_os_str().is_empty() => fs::canonicalize(folder).ok(),
                _ => fs::canonicalize(".").ok(),
            };
            a.file_name() == b.file_name() && folder(&a) == folder(&b)
        }
        (Ok(Target::Plain(a) | Target::Stream(a)), Ok(Target::Plain(b) | Target::Stream(b))) => {
            system::is_same_file(&a, &b)
        }
        _ => false,
    }
}

fn standard_output(content: &[u8]) -> io::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(content).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error),
        _ => Ok(()),
    }
}

/// Writes a temporary file in the same folder, which then takes the name `path`. Where a file was there, `old`, and the new
/// one would differ from it in more than its content, that is an error.
fn create(path: &Path, old: Option<&Metadata>, content: &[u8]) -> io::Result<()> {
    let temporary = temporary_name(path);
    let mut file = system::new_file(&temporary, old)?;
    let written = (|| {
        if let Some(old) = old {
            if !system::may_replace(&file.metadata()?, path, old) {
                return Err(io::Error::other("a new file would differ in more than its content"));
            }
            file.set_permissions(old.permissions())?;
        }
        file.write_all(content)
    })();
    // Closed before it is renamed, which some systems insist on.
    drop(file);
    written.and_then(|()| fs::rename(&temporary, path)).inspect_err(|_| {
        // The first error is the one to report.
        let _ = fs::remove_file(&temporary);
    })
}

/// Replaces the content of a file of `old` bytes where it lies. The end of the content is written first, from where it
/// makes the file longer, so that a full disk or a limit is met while the old content is still there.
fn rewrite(mut file: File, old: u64, content: &[u8]) -> io::Result<()> {
    let kept = usize::try_from(old).unwrap_or(usize::MAX).min(content.len().saturating_sub(1));
    let (head, end) = content.split_at(kept);
    let ended = file.seek(SeekFrom::Start(kept as u64)).and_then(|_| file.write_all(end));
    ended.inspect_err(|_| {
        // The first error is the one to report.
        let _ = file.set_len(old);
    })?;
    file.rewind()?;
    file.write_all(head)?;
    file.set_len(content.len() as u64)
}

/// A name in the folder of `path` that no other thread or running process uses.
fn temporary_name(path: &Path) -> PathBuf {
    static COUNTER: AtomicU32 = AtomicU32::new(0);
    let count = COUNTER.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".halflight-{}-{count}.tmp", process::id()))
}
