//! Specular reflection of the lights: what lobes reflect, times the part of it that arrives.

use halflight_core::pattern::Pattern;
use halflight_core::scene::Mesh;
use halflight_core::specular::Specular;
use halflight_cpu::config::{PipelineConfig, RefinerConfig};
use halflight_cpu::irradiance::Shading;

use crate::bindings::Slot;
use crate::error::GpuError;
use crate::needs::{Needs, RECORD};
use crate::pass::{Compiler, Pass};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;

programs! {
    RESOLVE: "specular: resolve" = resolve_specular in "specular/resolve";
    LATTICE: "specular: lattice" = reflect_light in "specular/reflect", "specular/known_lattice", "visibility/bvh";
    CELLS: "specular: cells" = reflect_light in "specular/reflect", "specular/known_cells", "visibility/bvh";
    PIXELS: "specular: pixels" = reflect_light in "specular/reflect", "specular/known_pixels", "visibility/bvh";
    SAMPLED: "specular: sampled" = reflect_light in "specular/reflect", "specular/known_nothing", "visibility/bvh";
    LATTICE_MASKED: "specular: lattice, masked" = reflect_light in "specular/reflect", "specular/known_lattice", "specular/masked_rays";
    CELLS_MASKED: "specular: cells, masked" = reflect_light in "specular/reflect", "specular/known_cells", "specular/masked_rays";
    PIXELS_MASKED: "specular: pixels, masked" = reflect_light in "specular/reflect", "specular/known_pixels", "specular/masked_rays";
    SAMPLED_MASKED: "specular: sampled, masked" = reflect_light in "specular/reflect", "specular/known_nothing", "specular/masked_rays";
}

/// Passes of glossy surfaces.
#[derive(Debug)]
pub(crate) struct Reflect {
    resolve: Pass,
    reflect: Pass,
}

impl Reflect {
    /// Compiles the passes for light samples of a pattern; `masked` says that triangles have alpha masks.
    ///
    /// # Errors
    /// A shader cannot be read or compiled, or binds more than the device allows.
    pub(crate) fn new(
        compiler: &Compiler,
        config: &PipelineConfig,
        pattern: Pattern,
        masked: bool,
    ) -> Result<Self, GpuError> {
        let [plain, with_masks] = match config.refiner {
            _ if config.shading == Shading::Sampled => [SAMPLED, SAMPLED_MASKED],
            RefinerConfig::Lattice(_) => [LATTICE, LATTICE_MASKED],
            RefinerConfig::PerPixel => [PIXELS, PIXELS_MASKED],
            _ => [CELLS, CELLS_MASKED],
        };
        let program = if masked { with_masks } else { plain };
        let rays = ("RAYS", pattern.len() as f64);
        Ok(Self { resolve: compiler.pass(RESOLVE, &[])?, reflect: compiler.pass(program, &[rays])? })
    }

    /// Declares the surfaces and what they reflect.
    pub(crate) fn declare(needs: &mut Needs) {
        needs.declare(Slot::Gloss, RECORD * needs.pixels());
        needs.declare(Slot::Specular, RECORD * needs.pixels());
    }

    /// Records the surfaces of a scene that has been rasterized.
    pub(crate) fn resolve(&self, recorder: &mut Recorder) {
        recorder.run(&self.resolve, Timed::Gbuffer, 0, Groups::Tiles(0));
    }

    /// Records that no surface is glossy.
    pub(crate) fn forget(recorder: &mut Recorder) {
        recorder.clear(Slot::Gloss);
    }

    /// Records the addition of the light whose uniforms begin at `first`.
    pub(crate) fn record(&self, recorder: &mut Recorder, first: u32) {
        recorder.run(&self.reflect, Timed::Specular, first, Groups::Tiles(0));
    }
}

/// Returns the specular part of materials, two vectors each; nothing where no surface is glossy.
pub(crate) fn glosses(mesh: &Mesh) -> Vec<[[f32; 4]; 2]> {
    let matte = Specular { roughness: 1.0, metallic: 0.0, reflectance: glam::Vec3::ZERO };
    let gloss = |specular: Option<Specular>| {
        let Specular { roughness, metallic, reflectance } = specular.unwrap_or(matte);
        [reflectance.extend(roughness).to_array(), [metallic, 0.0, 0.0, 0.0]]
    };
    let materials = mesh.materials.iter().filter(|_| mesh.is_glossy());
    materials.map(|material| gloss(material.specular)).collect()
}
