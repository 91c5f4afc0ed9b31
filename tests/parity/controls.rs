//! Negative controls of the parity tests: each must notice shaders that are wrong, one module at a time.

use halflight::config::{PipelineConfig, RefinerConfig, UpsamplerConfig};
use halflight::irradiance::Shading;
use halflight::refine::{LatticeConfig, NicholsConfig, SfvtGassConfig};

use crate::device::Bench;
use crate::scenes::{Twins, per_pixel};
use crate::upsamplers::with_defaults;
use crate::whole::nmse2;
use crate::{gbuffers, masks, refiners, upsamplers};

/// Checks that the original shaders pass, that a change without effect passes too, and that wrong shaders
/// fail.
fn notices(
    bench: &Bench,
    scene: &'static str,
    config: &PipelineConfig,
    check: impl Fn(&Twins) -> Result<(), String>,
    wrong: &[[&str; 3]],
) {
    notices_in(bench, Twins::render(bench, scene, config, true), config, check, wrong);
}

fn notices_in(
    bench: &Bench,
    mut twins: Twins,
    config: &PipelineConfig,
    check: impl Fn(&Twins) -> Result<(), String>,
    wrong: &[[&str; 3]],
) {
    check(&twins).unwrap();
    twins.alter(bench, config, ["shared/frame", "var<uniform> frame: Frame;", "var<uniform> frame : Frame;"]);
    check(&twins).unwrap();
    let mut is_missed = |altered: &&[&str; 3]| {
        twins.alter(bench, config, **altered);
        check(&twins).is_ok()
    };
    let missed: Vec<_> = wrong.iter().filter(&mut is_missed).collect();
    assert!(missed.is_empty(), "{missed:?}");
}

#[test]
fn surfaces() {
    let Some(bench) = Bench::open() else { return };
    let config = per_pixel(160, 120, Shading::Ratio);
    let twins = Twins::render(&bench, "few toys", &config, false);
    let check = |twins: &Twins| match gbuffers::compare(&bench, twins)? {
        others if others * 200 >= 160 * 120 => Err(others.to_string()),
        _ => Ok(()),
    };
    let wrong = [
        ["gbuffer", "vertex / 3u", "vertex / 3u ^ 1u"],
        ["resolve", "weights.x + (c.xyz", "weights.y + (c.xyz"],
        ["resolve", "faces[triangle].x);", "triangle);"],
    ];
    notices_in(&bench, twins, &config, check, &wrong);
    // Leaves are visible from behind.
    let twins = Twins::render(&bench, "tree", &config, false);
    notices_in(&bench, twins, &config, check, &[["resolve", "up = -up;", ""]]);
}

#[test]
fn light_samples() {
    let Some(bench) = Bench::open() else { return };
    let check = |twins: &Twins| match masks::compare(&bench, twins)? {
        (flips, rays) if flips * 100_000 > rays => Err(flips.to_string()),
        _ => Ok(()),
    };
    let wrong = [
        ["shared/hash", "x ^= x >> 15u;", "x ^= x >> 14u;"],
        ["shared/light", "* (1.0 / 65536.0)", "* (1.0 / 65600.0)"],
        ["shared/receiver", "position[pixel].xyz, s", "position[pixel].xyz * 1.01, s"],
        ["visibility/horizon", "return above == 4u;", "return true;"],
        ["visibility/masks", "if adds_light(receiver, place, end)", "if true"],
    ];
    notices(&bench, "atrium", &per_pixel(80, 60, Shading::Ratio), check, &wrong);
}

#[test]
fn shading() {
    let Some(bench) = Bench::open() else { return };
    let check = |twins: &Twins| {
        let off = nmse2(&bench.read::<[f32; 4]>(twins.gpu.image()), twins.cpu.image());
        // Threshold as for whole frames.
        if off < 1e-8 { Ok(()) } else { Err(off.to_string()) }
    };
    let ratio = [
        ["compose", "frame.radiance * value", "frame.radiance * value * 1.001"],
        ["compose", "value *= unshadowed(receiver.origin, receiver.normal) * seen_at(receiver);", ""],
        ["shared/unshadowed", "let z = t * t;", "let z = 1.1 * t * t;"],
        ["shared/unshadowed", "visible_polygon(origin, up);", "visible_polygon(origin + up * 1e-2, up);"],
        ["shared/sums", "lit += term;", "lit += 1.001 * term;"],
    ];
    notices(&bench, "few toys", &per_pixel(96, 72, Shading::Ratio), check, &ratio);
    let sampled = [
        ["shared/light", "receiver * emitter / (squared * squared)", "receiver * emitter / squared"],
        ["shared/sums", "f32(sums.count)", "f32(sums.count + 1u)"],
        ["shared/value", "sums_sampled(sums_of_queries(first, count))", "query_fraction(first)"],
    ];
    notices(&bench, "few toys", &per_pixel(96, 72, Shading::Sampled), check, &sampled);
}

#[test]
fn refiners() {
    let Some(bench) = Bench::open() else { return };
    let check = |twins: &Twins| refiners::check(&bench, twins, Shading::Ratio);
    let shared = [
        [
            "pyramid",
            "let turn = normal_at(a) - normal_at(b);",
            "let turn = 0.5 * (normal_at(a) - normal_at(b));",
        ],
        ["pyramid", "return vec2(step * step,", "return vec2(step,"],
        ["shared/representative", "corner + size / 2u", "corner + size / 4u"],
        ["owners", "if kept == 0u {", "if kept != KEPT_MORE && level == 2u {"],
    ];
    let nichols = [
        ["refine/nichols_choose", "state != FORCED {", "state == FORCED {"],
        ["refine/nichols_compare", ">= frame.enough", "> frame.enough + 2.0"],
        ["refine/nichols_reuse", "votes.lit & agreed", "votes.unlit & agreed"],
        ["refine/nichols_merge", "| reused[at].y", ""],
        ["refine/nichols_commit", "if flagged || broken {", "if broken {"],
        ["shared/votes", "select(1u, 2u, INTERLEAVED)", "select(0u, 1u, INTERLEAVED)"],
    ];
    let config = |refiner| PipelineConfig { refiner, ..per_pixel(110, 83, Shading::Ratio) };
    let refiner = RefinerConfig::Nichols(NicholsConfig::default());
    notices(&bench, "few toys", &config(refiner), check, &[&shared[..], &nichols].concat());
    let sfvt = [
        ["refine/sfvt_classify", "if curved || (", "if curved && ("],
        ["refine/sfvt_split_test", "differing <= frame.split_above", "differing <= 2u * frame.split_above"],
        ["refine/sfvt_split_test", "deep |=", "deep &="],
        ["shared/value", "all.visible + sums.visible", "sums.visible"],
        ["refine/sfvt_finals", "asks = !faces_away(pixel);", "asks = false;"],
    ];
    let refiner = RefinerConfig::SfvtGass(SfvtGassConfig::default());
    notices(&bench, "few toys", &config(refiner), check, &sfvt);
}

#[test]
fn the_lattice() {
    let Some(bench) = Bench::open() else { return };
    let refiner = RefinerConfig::Lattice(LatticeConfig::default());
    let upsampler = UpsamplerConfig::Lattice(Default::default());
    let config = PipelineConfig { refiner, upsampler, ..per_pixel(140, 100, Shading::Ratio) };
    let wrong = [
        [
            "refine/discontinuities",
            "if elevations.above_a <= elevations.limit &&",
            "if elevations.above_a <= 2.0 * elevations.limit ||",
        ],
        ["refine/discontinuities_gather", "|= discontinuities[", "= discontinuities["],
        ["refine/lattice_classify", "strongest == STEP &&", "strongest == SHADES &&"],
        ["refine/lattice_request", "|| waits(corner);", ";"],
        ["refine/lattice_value", "var colours = query_colours(query);", "var colours = vec4(0.5);"],
        ["refine/lattice_split_test", "high - low <= tolerance", "high - low <= 2.0 * frame.error"],
        ["refine/lattice_close_cracks", "> 0u && !agrees", "> 9999u && !agrees"],
    ];
    let check = |twins: &Twins| refiners::check_lattice(&bench, twins, Shading::Ratio);
    notices(&bench, "few toys", &config, check, &wrong);
    // Cells that are kept although their corners differ.
    let refiner = RefinerConfig::Lattice(LatticeConfig { error: 0.3, ..LatticeConfig::default() });
    let config = PipelineConfig { refiner, ..config };
    let wrong = [
        ["upsample/lattice", "weights.y * values.y", "weights.y * values.z"],
        ["upsample/lattice", "clamp(found.value, low, high)", "low"],
        ["upsample/pixels", "owner.level <= COPIED_LEVEL", "owner.level <= COPIED_LEVEL + 1u"],
    ];
    let check = |twins: &Twins| upsamplers::check(&bench, twins, &config, 1e-4);
    notices(&bench, "few toys", &config, check, &wrong);
}

#[test]
fn upsamplers() {
    let Some(bench) = Bench::open() else { return };
    let refiner = RefinerConfig::SfvtGass(SfvtGassConfig::default());
    let wrong: [&[[&str; 3]]; 4] = [
        &[
            ["upsample/bilinear", "vec4(9.0, 3.0, 3.0, 1.0)", "vec4(9.0, 3.0, 2.0, 1.0)"],
            ["upsample/bilinear", "parent - min(parent, vec2(1u))", "parent - min(parent, vec2(2u))"],
        ],
        &[
            ["upsample/rbf", "return VARIANCE;", "return 1.5 * VARIANCE;"],
            ["shared/additional", "+ half * vec2", "+ (half - 1u) * vec2"],
        ],
        &[["upsample/rbf", "return VARIANCE * (", "return 0.25 * VARIANCE * ("]],
        &[
            ["upsample/robust", "STIFFNESS * max", "4.0 * STIFFNESS * max"],
            ["upsample/robust", "walk_around(rect, 1u, AROUND)", "walk_around(rect, 2u, AROUND)"],
            ["upsample/trust", "0.25 * f32", "0.75 * f32"],
            ["upsample/pixels", "owner.level <= COPIED_LEVEL", "owner.level <= COPIED_LEVEL + 1u"],
        ],
    ];
    for ((upsampler, tolerance), wrong) in with_defaults().into_iter().zip(wrong) {
        let config = PipelineConfig { refiner, upsampler, ..per_pixel(110, 83, Shading::Ratio) };
        let check = |twins: &Twins| upsamplers::check(&bench, twins, &config, tolerance);
        notices(&bench, "few toys", &config, check, wrong);
    }
}
