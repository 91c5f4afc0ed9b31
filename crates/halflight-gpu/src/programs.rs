//! All shaders: what they are put together from and what they bind.

pub(crate) mod refine;
pub(crate) mod upsample;
pub(crate) mod visibility;

use crate::bindings::{Access, Slot};
use Access::{Read, Write};

/// A shader with one entry point, or two for rasterization.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Program {
    /// What it is called in errors, captures and tests.
    pub(crate) name: &'static str,
    /// Its entry point; of two, the one that binds something.
    pub(crate) entry: &'static str,
    /// Files in `shaders/`, in the order in which they are put together. `shared/frame.wgsl` comes before them.
    pub(crate) modules: &'static [&'static str],
    /// What it binds besides the uniform.
    pub(crate) slots: &'static [(Slot, Access)],
}

pub(crate) const GBUFFER: Program = Program {
    name: "gbuffer",
    entry: "corner",
    modules: &["gbuffer.wgsl"],
    slots: &[(Slot::Triangles, Read)],
};

pub(crate) const RESOLVE: Program = Program {
    name: "resolve",
    entry: "resolve",
    modules: &["resolve.wgsl"],
    slots: &[
        (Slot::Triangles, Read),
        (Slot::Faces, Read),
        (Slot::Materials, Read),
        (Slot::Uvs, Read),
        (Slot::Textures, Read),
        (Slot::Ids, Read),
        (Slot::Position, Write),
        (Slot::Normal, Write),
        (Slot::Albedo, Write),
    ],
};

pub(crate) const IMPORT: Program = Program {
    name: "import",
    entry: "take",
    modules: &["import.wgsl"],
    slots: &[
        (Slot::GivenPoint, Read),
        (Slot::GivenNormal, Read),
        (Slot::Position, Write),
        (Slot::Normal, Write),
    ],
};

pub(crate) const PRESENT: Program =
    Program { name: "present", entry: "pixel", modules: &["present.wgsl"], slots: &[(Slot::Image, Read)] };

pub(crate) const DISPATCH: Program = Program {
    name: "dispatch",
    entry: "dispatch",
    modules: &["shared/counters.wgsl", "shared/arguments.wgsl", "dispatch.wgsl"],
    slots: &[(Slot::Counters, Write), (Slot::Arguments, Write)],
};

pub(crate) const IRRADIANCE: Program = Program {
    name: "irradiance",
    entry: "irradiance",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/hash.wgsl",
        "shared/light.wgsl",
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "shared/sums.wgsl",
        "irradiance.wgsl",
    ],
    slots: &[
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Queries, Read),
        (Slot::Wanted, Read),
        (Slot::Visible, Read),
        (Slot::Counters, Write),
        (Slot::Samples, Write),
    ],
};

pub(crate) const COMPOSE: Program = Program {
    name: "compose",
    entry: "compose",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/hash.wgsl",
        "shared/light.wgsl",
        "shared/unshadowed.wgsl",
        "compose.wgsl",
    ],
    slots: &[(Slot::Position, Read), (Slot::Normal, Read), (Slot::Plane, Read), (Slot::Image, Write)],
};

/// All of them, for tests.
#[cfg(test)]
pub(crate) const ALL: &[&[Program]] = &[
    &[GBUFFER, RESOLVE, IMPORT, PRESENT, DISPATCH, IRRADIANCE, COMPOSE],
    &[
        refine::PYRAMID,
        refine::FULL,
        refine::NICHOLS_CHOOSE,
        refine::NICHOLS_REUSE,
        refine::NICHOLS_MERGE,
        refine::NICHOLS_COMPARE,
        refine::NICHOLS_SETTLE,
        refine::SFVT_CLASSIFY,
        refine::SFVT_JUDGE,
        refine::SFVT_VALUE,
        refine::SFVT_FINALS,
        refine::BREAKS,
        refine::BREAKS_GATHER,
        refine::LATTICE_LOOK,
        refine::LATTICE_ASK,
        refine::LATTICE_VALUE,
        refine::LATTICE_JUDGE,
        refine::LATTICE_MEND,
        refine::OWNERS,
    ],
    &[
        upsample::COPY,
        upsample::BILINEAR,
        upsample::RBF,
        upsample::TRUST,
        upsample::ROBUST,
        upsample::LATTICE,
    ],
    &[visibility::BVH_MASKS, visibility::BEAM, visibility::SPILL, visibility::SPILLED_MASKS],
];
