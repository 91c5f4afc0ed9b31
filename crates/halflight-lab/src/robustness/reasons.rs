//! Reasons why methods fail: known faults by their nature, beside the switch that was measured to mend them.

/// Choice of reasons that no switch mends.
const ALL: &str = "all";

/// Choice of a stage, the cases in which it fails (all that have no entry of their own where none are named), and why.
type Reason = (&'static str, &'static [&'static str], &'static str);

/// All reasons, of which the first that fits counts.
const REASONS: &[Reason] = &[
    (
        "voxel",
        &["out-of-view", "behind-the-eye"],
        "the grid holds what lies in the view frustum; occluders outside it cast no shadow (Nichols10, §3.3)",
    ),
    (
        "voxel",
        &["wires", "railing", "blinds", "slit", "strips", "line"],
        "a voxel is either full or empty: what is thinner casts the shadow of a whole one, or none where 16 steps jump over it",
    ),
    (
        "voxel",
        &["thin-wall", "leaks", "inside"],
        "16 steps between receiver and light jump over thin walls: light leaks",
    ),
    (
        "voxel",
        &["contact", "crease", "stairs"],
        "rays start a voxel above their surface, beyond the occluder that touches it: contact shadows are lost",
    ),
    (
        "voxel",
        &[
            "acne",
            "glancing",
            "low-sun",
            "flat-field",
            "in-plane",
            "touching",
            "crossing",
            "standing",
            "edge-on",
        ],
        "the surface fills the voxels that its own rays cross at a slant: it shadows itself",
    ),
    (
        "voxel",
        &[],
        "16 steps jump over what is thinner than the distance between them, and shadow edges are as coarse as the voxels",
    ),
    (
        "bilinear",
        &[],
        "coarse values dominate in multi-pass upsampling: holes and spikes at shadow edges, and it knows no planes",
    ),
    (
        "rbf-fixed",
        &[],
        "Gaussians do not reproduce constants and overshoot; values mix across edges; fragments up to 4 × 4 are copied as blocks",
    ),
    (
        "rbf-adaptive",
        &[],
        "Gaussians do not reproduce constants and overshoot; values mix across edges; fragments up to 4 × 4 are copied as blocks",
    ),
    (
        "lattice upsampler",
        &[],
        "it reads a cell's corners; fragments of other refiners have samples in their middles",
    ),
    ("rbf-robust", &[], "a weighted mean over fragments blurs what changes within one"),
    ("delaunay", &[], "long triangles between far samples miss what changes between them"),
    (
        "nichols",
        &[],
        "a fragment is refined where half of its samples change between neighbours: narrow and faint shadows change fewer",
    ),
    ("sfvt-gass", &[], "16 rays at four points decide on a fragment: what lies between them is missed"),
    ("lattice", &[], "a cell whose corners agree is not looked into: it may hide a wire or a slit"),
    (
        ALL,
        &["large"],
        "64 samples are far apart on a light that is wider than it is far: all methods want more of them",
    ),
    (
        "sampled",
        &["touching", "crossing", "inside", "standing", "edge-on", "in-plane"],
        "the irradiance grows without bound towards the light: few samples and wide fragments cannot follow it",
    ),
    (
        "sampled",
        &[],
        "irradiance itself is interpolated: refinement looks at shadows and not at how the light falls off, and its noise is not divided out",
    ),
];

/// Returns why no method passes in a case.
pub(super) fn why_all(case: &str) -> &'static str {
    why(case, "", ALL)
}

/// Returns why a choice of a stage fails in a case.
pub(super) fn why(case: &str, stage: &str, choice: &str) -> &'static str {
    // A refiner and an upsampler share a name.
    let choice = if (stage, choice) == ("upsampler", "lattice") { "lattice upsampler" } else { choice };
    let mut fitting = REASONS
        .iter()
        .filter(|(name, cases, _)| *name == choice && (cases.is_empty() || cases.contains(&case)));
    fitting.next().map_or("", |(_, _, why)| why)
}

#[cfg(test)]
mod tests {
    use halflight_cpu::config::{Named, RefinerConfig, UpsamplerConfig, VisibilityConfig};

    use super::super::cases;
    use super::*;

    #[test]
    fn reasons_speak_of_what_there_is() {
        let cases: Vec<&str> = cases::all().iter().map(|case| case.name).collect();
        for (name, mentioned, _) in REASONS {
            let known = RefinerConfig::NAMES.contains(name)
                || VisibilityConfig::NAMES.contains(name)
                || UpsamplerConfig::NAMES.contains(name)
                || ["sampled", "lattice upsampler", ALL].contains(name);
            assert!(known, "{name}");
            assert!(mentioned.iter().all(|case| cases.contains(case)), "{name}: {mentioned:?}");
        }
    }

    #[test]
    fn cases_of_their_own_come_before_the_rest() {
        assert!(why("out-of-view", "visibility", "voxel").contains("frustum"));
        assert!(why("easy", "visibility", "voxel").contains("coarse"));
        assert_ne!(why("easy", "refiner", "lattice"), why("easy", "upsampler", "lattice"));
        assert_eq!((why("easy", "visibility", "bvh"), why_all("easy")), ("", ""));
    }
}
