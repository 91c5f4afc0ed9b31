//! Shader sources, put together.

use std::borrow::Cow;

use crate::GpuError;
use crate::programs::Program;

/// The source of a program: the uniform, its modules and the declarations of what it binds.
///
/// `visibility` takes the place of the module that walks the hierarchy.
///
/// # Errors
/// A file cannot be read, where shaders are read from disk.
pub(crate) fn source(program: &Program, visibility: Option<&str>) -> Result<String, GpuError> {
    let mut text = String::new();
    for name in std::iter::once("shared/frame.wgsl").chain(program.modules.iter().copied()) {
        match visibility {
            Some(_) if name == TRIANGLE => {}
            Some(other) if name == BVH => text.push_str(other),
            _ => text.push_str(&module(name)?),
        }
    }
    for &(slot, access) in program.slots {
        text.push_str(&slot.declaration(access));
    }
    Ok(text)
}

/// The module that walks the hierarchy.
const BVH: &str = "visibility/bvh.wgsl";

/// What it tests triangles by.
const TRIANGLE: &str = "visibility/triangle.wgsl";

/// Source of the module that decides on shadow rays, as a start for one's own: see
/// [`Renderer::with_visibility`](crate::Renderer::with_visibility).
///
/// # Errors
/// It cannot be read, where shaders are read from disk.
pub fn visibility_module() -> Result<String, GpuError> {
    Ok(format!("{}{}", module(TRIANGLE)?, module(BVH)?))
}

/// The files of `shaders/`, by name.
macro_rules! modules {
    ($($name:literal),+ $(,)?) => {
        /// Sources that are part of the program.
        #[cfg(not(feature = "hot-reload"))]
        const MODULES: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../../shaders/", $name)))),+];
    };
}

modules![
    "compose.wgsl",
    "dispatch.wgsl",
    "gbuffer.wgsl",
    "import.wgsl",
    "irradiance.wgsl",
    "owners.wgsl",
    "present.wgsl",
    "pyramid.wgsl",
    "refine/breaks.wgsl",
    "refine/breaks_gather.wgsl",
    "refine/full.wgsl",
    "refine/lattice_ask.wgsl",
    "refine/lattice_judge.wgsl",
    "refine/lattice_look.wgsl",
    "refine/lattice_mend.wgsl",
    "refine/lattice_value.wgsl",
    "refine/nichols_choose.wgsl",
    "refine/nichols_compare.wgsl",
    "refine/nichols_merge.wgsl",
    "refine/nichols_reuse.wgsl",
    "refine/nichols_settle.wgsl",
    "refine/sfvt_classify.wgsl",
    "refine/sfvt_finals.wgsl",
    "refine/sfvt_judge.wgsl",
    "refine/sfvt_value.wgsl",
    "resolve.wgsl",
    "shared/append.wgsl",
    "shared/arguments.wgsl",
    "shared/breaks.wgsl",
    "shared/cells.wgsl",
    "shared/children.wgsl",
    "shared/corners.wgsl",
    "shared/counters.wgsl",
    "shared/field.wgsl",
    "shared/fractions.wgsl",
    "shared/frame.wgsl",
    "shared/hash.wgsl",
    "shared/inside.wgsl",
    "shared/light.wgsl",
    "shared/place.wgsl",
    "shared/pyramid.wgsl",
    "shared/query.wgsl",
    "shared/query_mask.wgsl",
    "shared/receiver.wgsl",
    "shared/rise.wgsl",
    "shared/sums.wgsl",
    "shared/surface.wgsl",
    "shared/tangent.wgsl",
    "shared/unshadowed.wgsl",
    "shared/votes.wgsl",
    "upsample/bilinear.wgsl",
    "upsample/copy.wgsl",
    "upsample/lattice.wgsl",
    "upsample/rbf.wgsl",
    "upsample/robust.wgsl",
    "upsample/trust.wgsl",
    "visibility/at_hand.wgsl",
    "visibility/beam.wgsl",
    "visibility/bvh.wgsl",
    "visibility/horizon.wgsl",
    "visibility/masks.wgsl",
    "visibility/spill.wgsl",
    "visibility/spilled.wgsl",
    "visibility/triangle.wgsl",
];

#[cfg(not(feature = "hot-reload"))]
fn module(name: &str) -> Result<Cow<'static, str>, GpuError> {
    let found = MODULES.iter().find(|(known, _)| *known == name);
    found
        .map(|&(_, text)| Cow::Borrowed(text))
        .ok_or_else(|| GpuError::Shader { name: name.to_owned(), reason: "no such file".to_owned() })
}

#[cfg(feature = "hot-reload")]
fn module(name: &str) -> Result<Cow<'static, str>, GpuError> {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders")).join(name);
    std::fs::read_to_string(path)
        .map(Cow::Owned)
        .map_err(|error| GpuError::Shader { name: name.to_owned(), reason: error.to_string() })
}
