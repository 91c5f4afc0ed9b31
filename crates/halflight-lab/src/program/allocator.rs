//! Allocator of programs, with an orderly end where memory runs out.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

/// Allocator of the system that ends the program with a message and exit code 1 where no memory is left. Rust programs
/// abort without it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Allocator;

// SAFETY: all calls are passed on to the system's allocator; where it has nothing, the program ends.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promises are those that `System` asks for; so below.
        had(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: see `alloc`.
        had(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: see `alloc`.
        had(unsafe { System.realloc(block, layout, size) }, size)
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: see `alloc`.
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
