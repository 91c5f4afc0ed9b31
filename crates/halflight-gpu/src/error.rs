//! Errors of devices, renderers and frames.

use halflight_cpu::pipeline::PipelineError;

/// Reason that there is no renderer, or that it cannot do what it was asked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter was found.
    #[error(
        "no graphics adapter: install a Vulkan, Direct3D 12 or Metal driver; a software one does as well (on Debian: \
         mesa-vulkan-drivers and libvulkan1)"
    )]
    NoAdapter,
    /// The adapter gave no device.
    #[error("the adapter {adapter} cannot be used: {reason}")]
    Device {
        /// Name of the adapter.
        adapter: String,
        /// Message of the adapter.
        reason: String,
    },
    /// Scene, size or light samples cannot be rendered on any device.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// A stage has no twin here.
    #[error("{stage} does not exist on the GPU: {reason}")]
    Unsupported {
        /// Name of the stage.
        stage: &'static str,
        /// Reason, and what would work.
        reason: &'static str,
    },
    /// A buffer or texture would be larger than the device allows.
    #[error("{what} would take {needed} {unit}, but the device allows {limit}: {advice}")]
    TooLarge {
        /// Contents of the buffer.
        what: &'static str,
        /// Amount that would be taken.
        needed: u64,
        /// Unit of the amounts.
        unit: &'static str,
        /// Amount that the device allows.
        limit: u64,
        /// Changes after which it would fit.
        advice: &'static str,
    },
    /// The BVH cannot be traversed.
    #[error("the BVH is {depth} levels deep, more than the {limit} that shaders can traverse")]
    TooDeep {
        /// Levels of the BVH.
        depth: usize,
        /// Levels that are allowed.
        limit: usize,
    },
    /// Moved vertices are more or fewer than the mesh has.
    #[error(
        "the mesh has {expected} vertices, but {found} positions were given: give one a vertex, in the mesh's order"
    )]
    Vertices {
        /// Number of positions that were given.
        found: usize,
        /// Number of vertices of the mesh.
        expected: usize,
    },
    /// A shader could not be read or compiled.
    #[error("shader {name}: {reason}")]
    Shader {
        /// File in `shaders/`, or the program.
        name: String,
        /// Message of the compiler or the system.
        reason: String,
    },
    /// The device gave no memory, or is lost.
    #[error("the device gives no memory: {0}; it is full or lost")]
    Memory(String),
    /// A buffer could not be read back.
    #[error("nothing came back from the device: {0}")]
    Readback(String),
}

/// Runs `make`; the first error that the device reports meanwhile is returned instead of what it made.
///
/// # Errors
/// Errors that the device reports, by `say`; or that `make` returns.
pub(crate) fn caught<T>(
    device: &wgpu::Device,
    say: impl FnOnce(String) -> GpuError,
    make: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
    let scopes = [OutOfMemory, Validation, Internal].map(|filter| device.push_error_scope(filter));
    let made = make();
    // Ready at once: what is created and compiled is so on this thread.
    let errors = scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop()));
    match errors.last() {
        Some(error @ wgpu::Error::OutOfMemory { .. }) => Err(GpuError::Memory(error.to_string())),
        Some(error) => Err(say(error.to_string())),
        None => made,
    }
}
