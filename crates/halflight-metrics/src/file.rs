//! Output files, written as `cp` writes them: pipes, devices and links keep their kind.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{MAIN_SEPARATOR, Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};

use thiserror::Error;

mod system;

/// Error of writing a file. The previous content is kept, and no temporary file is left behind.
#[derive(Debug, Error)]
#[error("cannot write {}", shown(path))]
pub struct WriteError {
    /// Path as given.
    pub path: PathBuf,
    /// Error of the operating system.
    pub source: io::Error,
}

/// Names of standard output: that of the command line, and those of the system.
const STANDARD_OUTPUT: [&str; 4] = ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];

/// Folders in which the system keeps names of open files. A file reached through one is not replaced, since
/// processes that have it open would not see the new one.
const OPEN_FILES: [&str; 3] = ["/dev/fd", "/dev/stderr", "/proc"];

/// Most symbolic links that are followed, as in Linux.
const MAX_LINKS: usize = 40;

/// Path as shown in messages.
fn shown(path: &Path) -> String {
    if is_standard_output(path) { "to standard output".to_owned() } else { path.display().to_string() }
}

/// Destination of a path.
enum Target {
    StandardOutput,
    /// Pipe, device or open file.
    Stream(PathBuf),
    /// Plain file, links followed.
    Plain(PathBuf),
    /// Unused name, links followed.
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

/// Final name of a chain of symbolic links whose target does not exist, in a folder that does.
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

/// Writes `content` to the target of `path`, as `cp` does. Plain files are written completely or not at all.
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
/// [`WriteError`] if the path leads to a folder or into a missing one, permissions are missing or the disk is
/// full.
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

/// Checks an output path before its content is computed: its folder must exist, and the file must be
/// writable. Pipes and devices are not opened.
///
/// # Errors
/// [`WriteError`], as [`write_file`] would return it.
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

/// True if a path is a name of standard output.
pub fn is_standard_output(path: &Path) -> bool {
    STANDARD_OUTPUT.iter().any(|name| path == Path::new(name))
}

/// True if a path leads to standard output, a pipe or a device, which accept one content after another.
pub fn is_stream(path: &Path) -> bool {
    matches!(Target::of(path), Ok(Target::StandardOutput | Target::Stream(_)))
}

/// True if two paths lead to one file, pipe or standard output, by any names. Devices keep no content that
/// could be lost and are never equal.
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

/// Writes a temporary file in the folder of `path`, which is then renamed to it. If an existing file, `old`,
/// differs from the new one in more than its content, that is an error.
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
    // Closed before it is renamed, as some systems require.
    drop(file);
    written.and_then(|()| fs::rename(&temporary, path)).inspect_err(|_| {
        // The first error is the one to report.
        let _ = fs::remove_file(&temporary);
    })
}

/// Overwrites the content of a file of `old` bytes in place. The end of the content is written first, if it
/// makes the file longer, so that a full disk or a limit is detected while the old content is still intact.
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

/// Name in the folder of `path` that no other thread or running process uses.
fn temporary_name(path: &Path) -> PathBuf {
    static COUNTER: AtomicU32 = AtomicU32::new(0);
    let count = COUNTER.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".halflight-{}-{count}.tmp", process::id()))
}
