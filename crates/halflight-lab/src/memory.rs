//! Memory: how much of it can be had, refusals of what would take more, and an orderly end where it runs out.

use std::alloc::{GlobalAlloc, Layout, System};
use std::fmt;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// More memory would be needed than can be had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what} takes about {} of memory, and {} can be had", Bytes(*.needed), Bytes(*.available))]
pub struct NotEnough {
    /// Subject of the message.
    pub what: String,
    /// Bytes needed, estimated.
    pub needed: u64,
    /// Bytes that can be had.
    pub available: u64,
}

/// Refuses what needs more bytes than the system can give.
///
/// # Errors
/// [`NotEnough`]; never where the system does not say.
pub fn check(what: impl Into<String>, needed: u64) -> Result<(), NotEnough> {
    match available() {
        Some(available) if needed > available => Err(NotEnough { what: what.into(), needed, available }),
        _ => Ok(()),
    }
}

/// Bytes that this process can still get: the least of what the machine, its control groups and the limits of the process
/// (`ulimit -v`, `ulimit -d`) leave. None where the system does not say.
pub fn available() -> Option<u64> {
    let limits =
        [machine(), control_groups(), limit("Max address space", "VmSize"), limit("Max data size", "VmData")];
    limits.into_iter().flatten().min()
}

/// Free memory, caches that can be dropped, and swap.
fn machine() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    Some(1024 * (number(&text, "MemAvailable:")? + number(&text, "SwapFree:").unwrap_or(0)))
}

/// A limit of the process without what it holds already, in kB under `held`.
fn limit(name: &str, held: &str) -> Option<u64> {
    let limit = number(&fs::read_to_string("/proc/self/limits").ok()?, name)?;
    let status = fs::read_to_string("/proc/self/status").ok()?;
    Some(limit.saturating_sub(1024 * number(&status, &format!("{held}:"))?))
}

/// The least that the control groups of this process leave, of version 2 or 1.
fn control_groups() -> Option<u64> {
    let text = fs::read_to_string("/proc/self/cgroup").ok()?;
    let left = text.lines().filter_map(|line| {
        let (_, line) = line.split_once(':')?;
        let (controllers, path) = line.split_once(':')?;
        let (root, names) = match controllers {
            "" => ("/sys/fs/cgroup", ["memory.max", "memory.current", "inactive_file"]),
            "memory" => {
                let names = ["memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"];
                ("/sys/fs/cgroup/memory", names)
            }
            _ => return None,
        };
        // Inside a container the path may be one outside of it, where only the root is to be seen.
        Path::new(path)
            .ancestors()
            .filter_map(|group| left_in(&Path::new(root).join(strip(group)), names))
            .min()
    });
    left.min()
}

/// Bytes that a control group leaves: its limit without what is in use and cannot be dropped.
fn left_in(folder: &Path, [limit, usage, cache]: [&str; 3]) -> Option<u64> {
    let read = |name: &str| fs::read_to_string(folder.join(name)).ok();
    let limit: u64 = read(limit)?.trim().parse().ok()?;
    let usage: u64 = read(usage)?.trim().parse().ok()?;
    let cache = read("memory.stat").and_then(|text| number(&text, cache)).unwrap_or(0);
    Some(limit.saturating_sub(usage.saturating_sub(cache)))
}

fn strip(path: &Path) -> &Path {
    path.strip_prefix("/").unwrap_or(path)
}

/// The number after `name` at the start of a line; none where there is another word.
fn number(text: &str, name: &str) -> Option<u64> {
    let mut lines = text.lines().filter_map(|line| line.strip_prefix(name));
    lines.find(|rest| rest.starts_with(char::is_whitespace))?.split_whitespace().next()?.parse().ok()
}

/// A number of bytes for people.
struct Bytes(u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mib = self.0 as f64 / f64::from(1 << 20);
        if mib < 1024.0 { write!(f, "{mib:.1} MiB") } else { write!(f, "{:.1} GiB", mib / 1024.0) }
    }
}

/// The system's allocator, which ends the program in words and with exit code 1 where no memory is left. Without it, Rust
/// programs abort.
#[derive(Clone, Copy, Debug, Default)]
pub struct Allocator;

// SAFETY: all calls are passed on to the system's allocator; where it has nothing, the program ends.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promises are those that `System` asks for; so below.
        had(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as in `alloc`.
        had(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as in `alloc`.
        had(unsafe { System.realloc(block, layout, size) }, size)
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: as in `alloc`.
        unsafe { System.dealloc(block, layout) }
    }
}

fn had(block: *mut u8, bytes: usize) -> *mut u8 {
    if block.is_null() {
        end(bytes);
    }
    block
}

/// Ends the program without asking for memory, and without running what other threads may still be in.
#[cold]
fn end(bytes: usize) -> ! {
    static SAID: AtomicBool = AtomicBool::new(false);
    if !SAID.swap(true, Ordering::Relaxed) {
        let mut text = [0; 200];
        let mut rest = &mut text[..];
        let _ = writeln!(
            rest,
            "error: out of memory: {bytes} bytes more cannot be had; a smaller image, fewer light samples or a smaller scene \
             take less"
        );
        let unused = rest.len();
        let _ = std::io::stderr().write_all(&text[..text.len() - unused]);
    }
    #[cfg(unix)]
    // SAFETY: it has no conditions.
    unsafe {
        libc::_exit(1)
    }
    #[cfg(not(unix))]
    std::process::exit(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_by_name() {
        let text = "MemTotal:  10 kB\nMemAvailable:   7 kB\nMax address space  unlimited  unlimited  bytes\n";
        assert_eq!(number(text, "MemAvailable:"), Some(7));
        assert_eq!(number(text, "Max address space"), None);
        assert_eq!(number(text, "SwapFree:"), None);
    }

    #[test]
    fn what_cannot_be_had_is_refused_in_words() {
        assert_eq!(check("little", 1), Ok(()));
        if available().is_some() {
            let message = check("an image of 9x9 pixels", u64::MAX).unwrap_err().to_string();
            assert!(message.starts_with("an image of 9x9 pixels takes about 17179869184.0 GiB"), "{message}");
        }
    }

    #[test]
    fn control_groups_leave_their_limit_without_what_cannot_be_dropped() {
        let folder = std::env::temp_dir().join(format!("halflight-group-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let names = ["memory.max", "memory.current", "inactive_file"];
        let left = |limit: &str| {
            fs::write(folder.join("memory.max"), limit).unwrap();
            fs::write(folder.join("memory.current"), "600\n").unwrap();
            fs::write(folder.join("memory.stat"), "anon 1\ninactive_file 200\n").unwrap();
            left_in(&folder, names)
        };
        assert_eq!((left("1000\n"), left("300\n"), left("max\n")), (Some(600), Some(0), None));
        fs::remove_dir_all(&folder).unwrap();
        assert_eq!(left_in(&folder, names), None);
    }
}
