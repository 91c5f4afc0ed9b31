//! Emission of materials.

use std::path::PathBuf;

use glam::Vec3;

use crate::context::Context;

/// Emission of a material of a library.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Emission {
    /// `Ke`, W/m²/sr; no negative numbers.
    pub(crate) radiance: Vec3,
    /// True if a texture (`map_Ke`) multiplies it.
    pub(crate) textured: bool,
    /// Path of the library.
    pub(crate) file: PathBuf,
    /// Line of the statement in the library.
    pub(crate) line: usize,
    /// Name of the material, as shown in messages.
    pub(crate) material: String,
}

/// Warns of emission that a scene file neither uses nor ignores, once a library.
pub(crate) fn warn_of_unused(emission: &[Option<Emission>], context: &mut Context) {
    for emission in emission.iter().flatten() {
        context.warn(format!(
            "{}: emission (Ke) is not used; write emissive = \"lights\" or \"ignore\" in the [[mesh]], or add a [[light]]",
            emission.file.display()
        ));
    }
}
