//! All shaders, by their topmost modules. What modules need and bind they say themselves (`shader.rs`).

/// A shader with one entry point, or two for rasterization.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Program {
    /// What it is called in errors, captures and tests.
    pub(crate) name: &'static str,
    /// Its entry point; of two, the one that binds something.
    pub(crate) entry: &'static str,
    /// Files in `shaders/`, without their ending, that nothing else in it needs.
    pub(crate) modules: &'static [&'static str],
}

macro_rules! programs {
    ($($program:ident: $name:literal = $entry:ident in $($module:literal),+;)+) => {
        $(pub(crate) const $program: Program =
            Program { name: $name, entry: stringify!($entry), modules: &[$($module),+] };)+

        /// All of them, for tests.
        #[cfg(test)]
        pub(crate) const ALL: &[Program] = &[$($program),+];
    };
}

programs! {
    GBUFFER: "gbuffer" = corner in "gbuffer";
    RESOLVE: "resolve" = resolve in "resolve";
    IMPORT: "import" = take in "import";
    PRESENT: "present" = pixel in "present";
    DISPATCH: "indirect arguments" = dispatch in "indirect_arguments";
    IRRADIANCE: "irradiance" = irradiance in "irradiance";
    COMPOSE: "compose" = compose in "compose";

    PYRAMID: "pyramid" = level in "pyramid";
    FULL: "full" = full in "refine/full";
    NICHOLS_CHOOSE: "nichols: choose" = choose in "refine/nichols_choose";
    NICHOLS_REUSE: "nichols: reuse" = reuse in "refine/nichols_reuse";
    NICHOLS_MERGE: "nichols: merge" = merge in "refine/nichols_merge";
    NICHOLS_COMPARE: "nichols: compare" = compare in "refine/nichols_compare";
    NICHOLS_COMMIT: "nichols: commit" = settle in "refine/nichols_commit";
    SFVT_CLASSIFY: "sfvt-gass: classify" = classify in "refine/sfvt_classify";
    SFVT_SPLIT_TEST: "sfvt-gass: split test" = judge in "refine/sfvt_split_test";
    SFVT_VALUE: "sfvt-gass: value" = value in "refine/sfvt_value";
    SFVT_FINALS: "sfvt-gass: finals" = finals in "refine/sfvt_finals";
    DISCONTINUITIES: "discontinuities" = find in "refine/discontinuities";
    DISCONTINUITIES_GATHER: "discontinuities: gather" = gather in "refine/discontinuities_gather";
    LATTICE_CLASSIFY: "lattice: classify" = look in "refine/lattice_classify";
    LATTICE_REQUEST: "lattice: request" = ask in "refine/lattice_request";
    LATTICE_VALUE: "lattice: value" = value in "refine/lattice_value";
    LATTICE_SPLIT_TEST: "lattice: split test" = judge in "refine/lattice_split_test";
    LATTICE_CLOSE_CRACKS: "lattice: close cracks" = mend in "refine/lattice_close_cracks";
    TARGET_SHOW: "error target: show" = show in "refine/target_show";
    TARGET_CHOOSE: "error target: choose" = choose in "refine/target_choose";
    TARGET_COUNT: "error target: count" = count in "refine/target_count";
    TARGET_DECIDE: "error target: decide" = decide in "refine/target_decide";
    TARGET_PREDICT: "error target: predict" = expect in "refine/target_predict";
    TARGET_ENERGY: "error target: measure" = measure in "refine/target_energy";
    TARGET_SUM: "error target: sum" = sum in "refine/target_sum";
    OWNERS: "owners" = own in "owners";

    COPY: "copy" = copy in "upsample/copy";
    BILINEAR: "bilinear" = bilinear in "upsample/bilinear";
    RBF: "rbf" = pixels in "upsample/rbf";
    TRUST: "trust" = trust in "upsample/trust";
    ROBUST: "rbf-robust" = pixels in "upsample/robust";
    LATTICE: "lattice" = pixels in "upsample/lattice";

    MASKS: "masks" = masks in "visibility/masks", "visibility/ray", "shared/query_batch";
    BEAM: "beam" = beam in "visibility/beam", "shared/query_batch";
    SPILL: "spill" = spill in "visibility/spill";
    SPILLED_MASKS: "spilled masks" = masks in "visibility/masks", "visibility/ray", "visibility/spilled";

    RASTER4D_FRAME: "raster4d: frame" = lay_out in "visibility/raster4d_frame";
    RASTER4D_TRIANGLES: "raster4d: triangles" = count_triangles in "visibility/raster4d_triangles";
    RASTER4D_RECEIVERS: "raster4d: receivers" = count_receivers in "visibility/raster4d_receivers";
    RASTER4D_SCAN: "raster4d: scan" = scan in "visibility/raster4d_scan";
    RASTER4D_FILL: "raster4d: fill" = fill in "visibility/raster4d_fill";
    RASTER4D_LENGTHS: "raster4d: lengths" = measure in "visibility/raster4d_lengths";
    RASTER4D_MASKS: "raster4d: masks" = take_hidden in "visibility/raster4d_masks";

    VOXEL_RANGE: "voxel: range" = find_range in "visibility/voxel_range";
    VOXEL_CLEARANCE: "voxel: clearance" = find_clearance in "visibility/voxel_clearance";
    VOXEL_DISPATCH: "voxel: dispatch" = size_large in "visibility/voxel_dispatch";
    VOXEL_FILL: "voxel: fill" = fill in "visibility/voxel_fill";
    VOXEL_MASKS: "voxel: masks" = masks in "visibility/masks", "visibility/voxel", "shared/query_batch";
}
