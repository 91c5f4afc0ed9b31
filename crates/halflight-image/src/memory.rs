//! Bytes of memory that the process can still get, and refusals of what would take more.

use std::fmt;
use std::fs;
use std::path::Path;

/// Error of something that needs more memory than the process can get.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what} takes about {} of memory, and {} can be had", Bytes(*.needed), Bytes(*.available))]
pub struct NotEnough {
    /// Subject of the message, such as `an image of 640x480 pixels`.
    pub what: String,
    /// Bytes needed, estimated.
    pub needed: u64,
    /// Bytes that can be had.
    pub available: u64,
}

/// Refuses what needs more bytes than the process can get. `what` is the subject of the error's message.
///
/// # Errors
/// [`NotEnough`] where `needed` is above [`available`]; none where the system does not tell.
pub fn check(what: impl Into<String>, needed: u64) -> Result<(), NotEnough> {
    match available() {
        Some(available) if needed > available => Err(NotEnough { what: what.into(), needed, available }),
        _ => Ok(()),
    }
}

/// Returns the bytes that this process can still get: the least of what the machine, its control groups and the limits of
/// the process (`ulimit -v`, `ulimit -d`) leave. `None` where the system does not tell, as on all systems but Linux.
pub fn available() -> Option<u64> {
    let limits =
        [machine(), control_groups(), limit("Max address space", "VmSize"), limit("Max data size", "VmData")];
    limits.into_iter().flatten().min()
}

/// Returns free memory, caches that can be dropped, and swap.
fn machine() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    Some(1024 * (number(&text, "MemAvailable:")? + number(&text, "SwapFree:").unwrap_or(0)))
}

/// Returns a limit of the process less the bytes that it holds already, in kB under `held`.
fn limit(name: &str, held: &str) -> Option<u64> {
    let limit = number(&fs::read_to_string("/proc/self/limits").ok()?, name)?;
    let status = fs::read_to_string("/proc/self/status").ok()?;
    Some(limit.saturating_sub(1024 * number(&status, &format!("{held}:"))?))
}

/// Returns the least that the control groups of this process leave, of version 2 or 1.
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

/// Returns the bytes that a control group leaves: its limit less what is in use and cannot be dropped.
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

/// Returns the number after `name` at the start of a line; `None` where another word follows.
fn number(text: &str, name: &str) -> Option<u64> {
    let mut lines = text.lines().filter_map(|line| line.strip_prefix(name));
    lines.find(|rest| rest.starts_with(char::is_whitespace))?.split_whitespace().next()?.parse().ok()
}

/// Number of bytes, shown in MiB or GiB.
struct Bytes(u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mib = self.0 as f64 / f64::from(1 << 20);
        if mib < 1024.0 { write!(f, "{mib:.1} MiB") } else { write!(f, "{:.1} GiB", mib / 1024.0) }
    }
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
