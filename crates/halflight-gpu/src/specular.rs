//! Specular reflection of the lights: what lobes reflect, times the part of it that arrives.

use halflight_core::pattern::Pattern;
use halflight_core::scene::Mesh;
use halflight_core::specular::Specular;
use halflight_cpu::config::{PipelineConfig, RefinerConfig};
use halflight_cpu::irradiance::Shading;

use crate::bindings::Slot;
use crate::error::GpuError;
use crate::needs::{Needs, RECORD};
use crate::pass::{ByLight, Compiler, Pass, flag};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;

programs! {
    RESOLVE: "specular: resolve" = resolve_specular in "specular/resolve";
    LATTICE: "specular: lattice" = reflect_light in "specular/reflect", "specular/known_lattice", "specular/known_value", "specular/uniform_light", "visibility/bvh";
    CELLS: "specular: cells" = reflect_light in "specular/reflect", "specular/known_cells", "specular/known_value", "specular/uniform_light", "visibility/bvh";
    PIXELS: "specular: pixels" = reflect_light in "specular/reflect", "specular/known_pixels", "specular/known_value", "specular/uniform_light", "visibility/bvh";
    SAMPLED: "specular: sampled" = reflect_light in "specular/reflect", "specular/known_nothing", "specular/uniform_light", "visibility/bvh";
    LATTICE_MASKED: "specular: lattice, masked" = reflect_light in "specular/reflect", "specular/known_lattice", "specular/known_value", "specular/uniform_light", "specular/masked_rays";
    CELLS_MASKED: "specular: cells, masked" = reflect_light in "specular/reflect", "specular/known_cells", "specular/known_value", "specular/uniform_light", "specular/masked_rays";
    PIXELS_MASKED: "specular: pixels, masked" = reflect_light in "specular/reflect", "specular/known_pixels", "specular/known_value", "specular/uniform_light", "specular/masked_rays";
    SAMPLED_MASKED: "specular: sampled, masked" = reflect_light in "specular/reflect", "specular/known_nothing", "specular/uniform_light", "specular/masked_rays";
    LATTICE_TEXTURED: "specular: lattice, textured" = reflect_light in "specular/reflect", "specular/known_lattice", "textured/known_value", "textured/lobe_light", "visibility/bvh";
    CELLS_TEXTURED: "specular: cells, textured" = reflect_light in "specular/reflect", "specular/known_cells", "textured/known_value", "textured/lobe_light", "visibility/bvh";
    PIXELS_TEXTURED: "specular: pixels, textured" = reflect_light in "specular/reflect", "specular/known_pixels", "textured/known_value", "textured/lobe_light", "visibility/bvh";
    SAMPLED_TEXTURED: "specular: sampled, textured" = reflect_light in "specular/reflect", "specular/known_nothing", "textured/lobe_light", "visibility/bvh";
    LATTICE_MASKED_TEXTURED: "specular: lattice, masked, textured" = reflect_light in "specular/reflect", "specular/known_lattice", "textured/known_value", "textured/lobe_light", "specular/masked_rays";
    CELLS_MASKED_TEXTURED: "specular: cells, masked, textured" = reflect_light in "specular/reflect", "specular/known_cells", "textured/known_value", "textured/lobe_light", "specular/masked_rays";
    PIXELS_MASKED_TEXTURED: "specular: pixels, masked, textured" = reflect_light in "specular/reflect", "specular/known_pixels", "textured/known_value", "textured/lobe_light", "specular/masked_rays";
    SAMPLED_MASKED_TEXTURED: "specular: sampled, masked, textured" = reflect_light in "specular/reflect", "specular/known_nothing", "textured/lobe_light", "specular/masked_rays";
}

/// Passes of glossy surfaces.
#[derive(Debug)]
pub(crate) struct Reflect {
    resolve: Pass,
    reflect: ByLight,
}

impl Reflect {
    /// Compiles the passes for light samples of a pattern; `masked` says that triangles have alpha masks, `smoothed` that the refiner smooths
    /// values.
    ///
    /// # Errors
    /// A shader cannot be read or compiled, or binds more than the device allows.
    pub(crate) fn new(
        compiler: &Compiler,
        config: &PipelineConfig,
        pattern: Pattern,
        masked: bool,
        smoothed: bool,
    ) -> Result<Self, GpuError> {
        let sampled = config.shading == Shading::Sampled;
        let (uniform, textured) = match (config.refiner, masked) {
            (_, false) if sampled => (SAMPLED, SAMPLED_TEXTURED),
            (_, true) if sampled => (SAMPLED_MASKED, SAMPLED_MASKED_TEXTURED),
            (RefinerConfig::Lattice(_), false) => (LATTICE, LATTICE_TEXTURED),
            (RefinerConfig::Lattice(_), true) => (LATTICE_MASKED, LATTICE_MASKED_TEXTURED),
            (RefinerConfig::PerPixel, false) => (PIXELS, PIXELS_TEXTURED),
            (RefinerConfig::PerPixel, true) => (PIXELS_MASKED, PIXELS_MASKED_TEXTURED),
            (_, false) => (CELLS, CELLS_TEXTURED),
            (_, true) => (CELLS_MASKED, CELLS_MASKED_TEXTURED),
        };
        let rays = ("RAYS", pattern.len() as f64);
        let values = [rays, ("SMOOTHED", flag(smoothed))];
        let of_textures = if sampled { &values[..1] } else { &values };
        let reflect = compiler.by_light((uniform, &[rays]), (textured, of_textures))?;
        Ok(Self { resolve: compiler.pass(RESOLVE, &[])?, reflect })
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
        let reflect = self.reflect.of(recorder.textured);
        recorder.run(reflect, Timed::Specular, first, Groups::Tiles(0));
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
