//! Shader sources, put together.
//!
//! A module begins with what it needs and binds: `//@ needs` names files in `shaders/` without their ending, `//@ reads` and
//! `//@ writes` name slots.

use std::borrow::Cow;

use crate::bindings::{Access, Slot};
use crate::error::GpuError;
use crate::program::Program;

/// Texts that take the place of modules, by name.
pub(crate) type Replaced<'a> = [(&'a str, &'a str)];

/// Text and bindings of a program.
#[derive(Debug, Default)]
pub(crate) struct Shader {
    pub(crate) text: String,
    /// Bindings besides the uniform, in their order.
    pub(crate) slots: Vec<(Slot, Access)>,
}

impl Shader {
    /// Joins the uniform, the program's modules with all that these need, and declarations of what they bind. The order does
    /// not matter in WGSL.
    ///
    /// # Errors
    /// A file cannot be read, or names a module or a slot that does not exist.
    pub(crate) fn new(program: &Program, replaced: &Replaced) -> Result<Self, GpuError> {
        let mut shader = Self::default();
        // Comes last, so that what is open at its end is not closed by others: messages then point at it.
        let mut outside = String::new();
        let mut names = vec!["shared/frame".to_owned()];
        names.extend(program.modules.iter().map(|&name| name.to_owned()));
        let mut next = 0;
        while let Some(name) = names.get(next).cloned() {
            next += 1;
            let (text, place) = match replaced.iter().find(|(known, _)| *known == name) {
                Some(&(_, text)) => (Cow::Borrowed(text), &mut outside),
                None => (shader_module(&name)?, &mut shader.text),
            };
            place.push_str(&text);
            place.push('\n');
            for line in text.lines().filter_map(|line| line.strip_prefix("//@ ")) {
                let (verb, rest) = line.split_once(' ').unwrap_or((line, ""));
                for word in rest.split_whitespace() {
                    let slot = Slot::named(word);
                    match (verb, slot) {
                        ("needs", _) if names.iter().any(|known| known == word) => {}
                        ("needs", _) => names.push(word.to_owned()),
                        ("reads", Some(slot)) => shader.bind(slot, Access::Read),
                        ("writes", Some(slot)) => shader.bind(slot, Access::Write),
                        _ => {
                            let reason = format!("there is nothing that it {verb} called `{word}`");
                            return Err(GpuError::Shader { name, reason });
                        }
                    }
                }
            }
        }
        shader.slots.sort_by_key(|&(slot, _)| slot);
        for &(slot, access) in &shader.slots {
            shader.text.push_str(&slot.declaration(access));
        }
        shader.text.push_str(&outside);
        Ok(shader)
    }

    fn bind(&mut self, slot: Slot, access: Access) {
        match self.slots.iter_mut().find(|(known, _)| *known == slot) {
            Some((_, known)) if access == Access::Write => *known = access,
            Some(_) => {}
            None => self.slots.push((slot, access)),
        }
    }
}

/// Lists the files of `shaders/`, by name without ending.
macro_rules! modules {
    ($($name:literal),+ $(,)?) => {
        /// Sources that are part of the program.
        #[cfg(not(feature = "hot-reload"))]
        const MODULES: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../shaders/", $name, ".wgsl")))),+];

        /// Returns the names of all modules.
        #[cfg(test)]
        pub(crate) fn module_names() -> impl Iterator<Item = &'static str> {
            [$($name),+].into_iter()
        }
    };
}

modules![
    "compose",
    "indirect_arguments",
    "emission",
    "gbuffer",
    "gbuffer_masked",
    "import",
    "irradiance",
    "owners",
    "present",
    "present/glossy",
    "present/lamps",
    "present/matte",
    "present/no_lamps",
    "pyramid",
    "refine/discontinuities",
    "refine/discontinuities_gather",
    "refine/per_pixel",
    "refine/lattice_request",
    "refine/lattice_smooth",
    "refine/lattice_split_test",
    "refine/lattice_classify",
    "refine/lattice_close_cracks",
    "refine/lattice_value",
    "refine/nichols_choose",
    "refine/nichols_compare",
    "refine/nichols_merge",
    "refine/nichols_reuse",
    "refine/nichols_commit",
    "refine/sfvt_classify",
    "refine/sfvt_finals",
    "refine/sfvt_split_test",
    "refine/target_choose",
    "refine/target_count",
    "refine/target_decide",
    "refine/target_energy",
    "refine/target_evaluate",
    "refine/target_predict",
    "refine/target_sum",
    "resolve",
    "resolve_smooth",
    "shared/append",
    "shared/arguments",
    "shared/query_batch",
    "shared/discontinuities",
    "shared/emission",
    "shared/cells",
    "shared/children",
    "shared/choice",
    "shared/corner_weights",
    "shared/corners",
    "shared/counters",
    "shared/field",
    "shared/fractions",
    "shared/frame",
    "shared/additional",
    "shared/hash",
    "shared/inside",
    "shared/light",
    "shared/masked",
    "shared/noise",
    "shared/noise_estimate",
    "shared/offset",
    "shared/representative",
    "shared/pyramid",
    "shared/query",
    "shared/query_kinds",
    "shared/query_mask",
    "shared/ray_lanes",
    "shared/receiver",
    "shared/tangent_plane",
    "shared/smoothing",
    "shared/solid",
    "shared/sortable",
    "shared/sphere",
    "shared/sums",
    "shared/surface",
    "shared/tally",
    "shared/tangent",
    "shared/tiles",
    "shared/unshadowed",
    "shared/value",
    "shared/values",
    "shared/visible_tolerance",
    "shared/votes",
    "specular/cells",
    "specular/known_cells",
    "specular/known_lattice",
    "specular/known_nothing",
    "specular/known_pixels",
    "specular/known_value",
    "specular/lobe",
    "specular/masked_rays",
    "specular/reflect",
    "specular/resolve",
    "specular/uniform_light",
    "textured/channel",
    "textured/emission",
    "textured/known_value",
    "textured/lattice_smooth",
    "textured/lobe_light",
    "textured/noise",
    "textured/seen",
    "textured/strata",
    "textured/sums",
    "textured/texel",
    "textured/value",
    "textured/values",
    "upsample/bilinear",
    "upsample/copy",
    "upsample/lattice",
    "upsample/pixels",
    "upsample/rbf",
    "upsample/robust",
    "upsample/trust",
    "visibility/beam",
    "visibility/bvh",
    "visibility/hide",
    "visibility/horizon",
    "visibility/masks",
    "visibility/raster4d",
    "visibility/raster4d_bounds",
    "visibility/raster4d_cells",
    "visibility/raster4d_fill",
    "visibility/raster4d_frame",
    "visibility/raster4d_lengths",
    "visibility/raster4d_masks",
    "visibility/raster4d_receivers",
    "visibility/raster4d_scan",
    "visibility/raster4d_triangles",
    "visibility/ray",
    "visibility/spill",
    "visibility/solid_hits",
    "visibility/spilled",
    "visibility/traversal",
    "visibility/triangle",
    "visibility/voxel",
    "visibility/voxel_clearance",
    "visibility/voxel_dispatch",
    "visibility/voxel_fill",
    "visibility/voxel_range",
    "visibility/voxel_size",
    "visibility/voxel_space",
];

/// Returns the text of a module: a file in `shaders/`, named without its ending. Modules from outside are made of it.
///
/// # Errors
/// No module has this name; or it cannot be read, where shaders are read from disk.
pub fn shader_module(name: &str) -> Result<Cow<'static, str>, GpuError> {
    #[cfg(not(feature = "hot-reload"))]
    let found =
        MODULES.iter().find(|(known, _)| *known == name).map(|&(_, text)| text).ok_or("no such module");
    #[cfg(feature = "hot-reload")]
    let found =
        std::fs::read_to_string(format!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/{}.wgsl"), name));
    found
        .map(Cow::from)
        .map_err(|error| GpuError::Shader { name: name.to_owned(), reason: error.to_string() })
}
