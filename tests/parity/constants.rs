//! Constants that exist in Rust and in WGSL are equal.

use std::fs;
use std::path::Path;

/// Constant in a shader, and its counterpart in Rust.
type Pair = ((&'static str, &'static str), (&'static str, &'static str));

const TARGET: &str = "halflight-cpu/src/refine/target.rs";
const TANGENT_PLANE: &str = "halflight-cpu/src/tangent_plane.rs";
const LATTICE: &str = "halflight-cpu/src/refine/lattice/mod.rs";
const SPLIT_TEST: &str = "halflight-cpu/src/refine/lattice/split_test.rs";
const DENOISE: &str = "halflight-cpu/src/refine/lattice/denoise.rs";
const SPECULAR: &str = "halflight-cpu/src/specular.rs";
const LOBE: &str = "halflight-cpu/src/specular/lobe.rs";
const LOBE_CELLS: &str = "halflight-cpu/src/specular/cells.rs";
const SEEN: &str = "halflight-cpu/src/textured/seen.rs";
const STATS: &str = "halflight-gpu/src/stats.rs";

const PAIRS: &[Pair] = &[
    (("shared/noise_estimate", "NOISE"), (TARGET, "NOISE")),
    (("shared/noise_estimate", "ALONE"), (TARGET, "ALONE")),
    (("refine/target_choose", "INDEPENDENT"), (TARGET, "INDEPENDENT")),
    (("refine/target_choose", "FIRST"), (TARGET, "FIRST")),
    (("refine/target_choose", "MOST"), (TARGET, "ONCE")),
    (("refine/target_choose", "LEAST"), (TARGET, "LEAST_SIDE")),
    (("refine/target_choose", "DEVIATION"), (TARGET, "DEVIATION")),
    (("refine/target_choose", "DECAY"), (TARGET, "DECAY")),
    (("refine/target_choose", "DEVIATIONS"), (TARGET, "DEVIATIONS")),
    (("refine/target_choose", "LEAST_ERROR"), (TARGET, "LEAST_ERROR")),
    (("refine/target_choose", "MOST_ERROR"), (TARGET, "MOST_ERROR")),
    (("refine/discontinuities", "FAR_STEP"), (TANGENT_PLANE, "FAR_STEP_PX")),
    (("refine/discontinuities", "NEAREST"), (TANGENT_PLANE, "NEAREST")),
    (("upsample/rbf", "MOST"), ("halflight-cpu/src/upsample/rbf.rs", "MAX_EDGE")),
    (("upsample/robust", "MOST"), ("halflight-cpu/src/upsample/nearby.rs", "MAX_SAMPLES")),
    (("upsample/trust", "MIXED"), ("halflight-cpu/src/upsample/nearby.rs", "MIXED")),
    (("visibility/raster4d", "MARGIN"), ("halflight-cpu/src/raster4d/project.rs", "MARGIN")),
    (("visibility/traversal", "STACK"), ("halflight-gpu/src/hierarchy.rs", "STACK")),
    (("visibility/voxel_space", "LIGHTS"), ("halflight-gpu/src/visibility/voxel.rs", "LIGHTS")),
    (("shared/sphere", "SPHERE"), ("halflight-gpu/src/light.rs", "SPHERE")),
    (("shared/sphere", "SPHERE_ROUNDING"), ("halflight-core/src/light/sphere.rs", "ROUNDING")),
    (("shared/arguments", "SIDE"), ("halflight-gpu/src/recorder.rs", "SIDE")),
    (("shared/visible_tolerance", "TOLERANCE_IN_VISIBLE_ERROR"), (LATTICE, "TOLERANCE_IN_VISIBLE_ERROR")),
    (("shared/visible_tolerance", "LEAST_DEVIATIONS"), (SPLIT_TEST, "DEVIATIONS")),
    (("shared/visible_tolerance", "FLOOR"), (TARGET, "FLOOR")),
    (("shared/smoothing", "FROM_ONE"), (DENOISE, "FROM_ONE")),
    (("shared/smoothing", "FROM_SEVERAL"), (DENOISE, "FROM_SEVERAL")),
    (("shared/smoothing", "AGREED"), ("halflight-cpu/src/refine/lattice/error_estimate.rs", "AGREED")),
    (("textured/strata", "FEWEST"), ("halflight-gpu/src/textured.rs", "FEWEST")),
    (("textured/strata", "FEWEST"), (TARGET, "LEAST_SIDE")),
    (("specular/lobe", "LEAST_ALPHA"), (LOBE, "LEAST_ALPHA")),
    (("specular/lobe", "LEAST_COSINE"), (LOBE, "LEAST_COSINE")),
    (("specular/cells", "WIDE_ELLIPSE"), (LOBE_CELLS, "WIDE_ELLIPSE")),
    (("specular/cells", "NARROW_ELLIPSE"), (LOBE_CELLS, "NARROW_ELLIPSE")),
    (("specular/cells", "NARROW"), (LOBE_CELLS, "NARROW")),
    (("specular/cells", "BY_DISTANCE"), (LOBE_CELLS, "BY_DISTANCE")),
    (("specular/cells", "BY_ANGLE"), (LOBE_CELLS, "BY_ANGLE")),
    (("specular/cells", "MOST_HALVINGS"), (LOBE_CELLS, "MOST_HALVINGS")),
    (("specular/cells", "MOST_CELLS"), (LOBE_CELLS, "MOST_CELLS")),
    (("specular/reflect", "LEAST_RAYS"), (SPECULAR, "LEAST_RAYS")),
    (("specular/reflect", "MOST_RAYS"), (SPECULAR, "MOST_RAYS")),
    (("specular/reflect", "LOBES"), (SPECULAR, "LOBES")),
    (("shared/counters", "LOBE_RAYS"), (STATS, "LOBE_RAYS")),
    (("textured/seen", "UNIFORM"), (SEEN, "UNIFORM")),
    (("textured/seen", "DISTANCE"), (SEEN, "DISTANCE")),
    (("resolve_smooth", "RISE"), ("halflight-core/src/smooth.rs", "RISE")),
    (("shared/counters", "TALLY"), (STATS, "TALLY")),
    (("shared/counters", "BUCKETS"), (STATS, "BUCKETS")),
    (("shared/counters", "SAMPLES_PER_LEVEL"), (STATS, "SAMPLES_PER_LEVEL")),
    (("shared/counters", "CELLS_PER_LEVEL"), (STATS, "CELLS_PER_LEVEL")),
    (("shared/counters", "EXPECTED"), (STATS, "EXPECTED")),
    (("shared/counters", "ENERGY"), (STATS, "ENERGY")),
];

/// Mean errors of classes of cells, in the order of `assumed` in the CPU's validation.
const ASSUMED: [&str; 4] = ["AGREED", "CURVATURE", "STEP_AGREED", "STEP_MIXED"];

fn text(path: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    fs::read_to_string(root.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Parses a number in the syntax of either language: `1_024u32`, `0.5`, `1.0 / 64.0`.
fn number(text: &str) -> Option<f64> {
    if let Some((above, below)) = text.split_once('/') {
        return Some(number(above)? / number(below)?);
    }
    let text = text.trim().replace('_', "");
    let suffixes = ["u32", "u16", "u8", "f32", "f64", "u"];
    let digits = suffixes.iter().find_map(|suffix| text.strip_suffix(suffix)).unwrap_or(&text);
    match digits.strip_prefix("0x") {
        Some(digits) => u32::from_str_radix(digits, 16).ok().map(f64::from),
        None => digits.parse().ok(),
    }
}

/// Value of `const NAME: type = value;` in a file.
fn constant(path: &str, name: &str) -> f64 {
    let text = text(path);
    let line = text
        .lines()
        .find_map(|line| line.trim_start_matches("pub(crate) ").strip_prefix(&format!("const {name}:")));
    let value = line.and_then(|line| line.split_once('=')?.1.trim().strip_suffix(';'));
    value.and_then(number).unwrap_or_else(|| panic!("{path} has no number const {name}"))
}

#[test]
fn shaders_have_the_constants_of_the_rust_code() {
    for &((shader, there), (file, here)) in PAIRS {
        let shader = format!("crates/halflight-gpu/shaders/{shader}.wgsl");
        let (found, expected) = (constant(&shader, there), constant(&format!("crates/{file}"), here));
        // Fractions are single precision in shaders; whole numbers have all their digits.
        let equal = found == expected || found.fract() != 0.0 && found as f32 == expected as f32;
        assert!(equal, "{there} in {shader} is {found}, {here} in {file} {expected}");
    }
}

#[test]
fn shaders_assume_the_errors_that_the_rust_code_does() {
    let rust = text("crates/halflight-cpu/src/refine/lattice/validate.rs");
    let body = rust.split_once("fn assumed(").unwrap().1.split_once("\n}\n").unwrap().0;
    let arms =
        body.lines().filter_map(|line| number(line.trim().split_once(" => ")?.1.trim_end_matches(',')));
    let found = ASSUMED.map(|name| constant("crates/halflight-gpu/shaders/refine/target_predict.wgsl", name));
    assert_eq!(found.to_vec(), arms.collect::<Vec<f64>>());
}

#[test]
fn the_reader_of_constants_tells_numbers_apart() {
    assert_eq!(number("65_535"), Some(65_535.0));
    assert_eq!(number("1.0 / 64.0"), number("0.015625"));
    assert_eq!(number("0xff_11u"), Some(65_297.0));
    assert_ne!(number("0.12"), number("0.13"));
    assert_eq!((number("SIDE * SIDE"), number("5.96e-8")), (None, Some(5.96e-8)));
}
