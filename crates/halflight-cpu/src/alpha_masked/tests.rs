//! Leaves with holes against brute force, against quadrilaterals in the place of their solid texels, and against meshes
//! without masks.

use std::sync::Arc;

use glam::{Vec2, Vec3};
use halflight_core::alpha::AlphaMask;
use halflight_core::certificate::{Certificate, Region};
use halflight_core::frame::{Frame, Sharing};
use halflight_core::gbuffer::GBuffer;
use halflight_core::hash;
use halflight_core::light::AreaLight;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::pyramid::Pyramid;
use halflight_core::scene::{Camera, Material, Scene};
use halflight_core::stages::Visibility;

use crate::beam::Beam;
use crate::brute_force::BruteForce;
use crate::bvh::Bvh;
use crate::bvh::tests::meshes::{Numbers, ask, clusters, lamp, patterns, scene};
use crate::config::{Named as _, PipelineConfig, RefinerConfig, VisibilityConfig};
use crate::gbuffer;
use crate::pipeline::{Image, Pipeline};
use crate::prepared::PreparedScene;
use crate::raster4d::{Raster4d, Raster4dConfig};
use crate::rays::BvhRays;
use crate::requests::Requests;

/// Texels along the side of the leaves' masks.
const SIDE: u32 = 8;

/// Material of the leaves; the floor has material 0.
const LEAF: u32 = 1;

/// Leaf: a corner and two edges.
type Leaf = [Vec3; 3];

fn leaves(count: usize) -> Vec<Leaf> {
    let mut numbers = Numbers(77);
    (0..count)
        .map(|_| {
            let corner = Vec3::new(0.0, 1.3, 0.0) + numbers.point() * Vec3::new(1.2, 0.5, 1.2);
            [corner, numbers.point() * 0.7, numbers.point() * 0.7]
        })
        .collect()
}

/// Floor and leaves under a lamp. Of the leaves, the rectangles `parts` of their unit squares are kept; texture coordinates are
/// those of the unit square, scaled and shifted.
fn garden(leaves: &[Leaf], parts: &[[Vec2; 2]], scale: f32, shift: Vec2) -> Scene {
    let floor = [Vec3::new(-4.0, 0.0, -4.0), Vec3::X * 8.0, Vec3::Z * 8.0];
    let unit = [[Vec2::ZERO, Vec2::ONE]];
    let mut uvs = Vec::new();
    let mut quads = |[corner, u, v]: Leaf, parts: &[[Vec2; 2]]| {
        let mut triangles = Vec::new();
        for &[low, high] in parts {
            let square = [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)];
            for corners in [[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|at: usize| square[at])) {
                triangles.push(corners.map(|at| corner + u * at.x + v * at.y));
                uvs.extend(corners.map(|at| at * scale + shift));
            }
        }
        triangles
    };
    let mut corners = quads(floor, &unit);
    corners.extend(leaves.iter().flat_map(|&leaf| quads(leaf, parts)));
    let mut scene = scene(&corners, lamp(Vec3::Y * 3.0, 1.5));
    let mesh = Arc::make_mut(&mut scene.mesh);
    mesh.uvs = uvs;
    mesh.material_ids[2..].fill(LEAF);
    mesh.materials = vec![Material::default(), Material { albedo: Vec3::Y, ..Material::default() }];
    scene.camera = Camera {
        eye: Vec3::new(2.5, 2.2, 3.0),
        target: Vec3::Y * 0.7,
        up: Vec3::Y,
        fov_y_deg: 55.0,
        ..Camera::default()
    };
    scene
}

/// Alpha of a texel, at random on both sides of the cutoff.
fn alpha(texel: u32) -> u8 {
    if hash::mix(texel ^ 0xa1fa).is_multiple_of(2) { 127 } else { 128 }
}

/// The scene with a mask on its leaves.
fn masked(mut scene: Scene, alpha: impl Fn(u32) -> u8) -> Scene {
    let mesh = Arc::make_mut(&mut scene.mesh);
    let texels = (0..(SIDE * SIDE) as usize).map(|texel| alpha(texel as u32));
    mesh.alpha_masks = vec![AlphaMask::new(SIDE, SIDE, texels, 0.5).unwrap()];
    mesh.materials[LEAF as usize].alpha_mask = Some(0);
    scene
}

fn whole(leaves: &[Leaf]) -> Scene {
    garden(leaves, &[[Vec2::ZERO, Vec2::ONE]], 1.0, Vec2::ZERO)
}

fn receivers(count: usize) -> Vec<Vec3> {
    clusters(count, Vec3::new(-2.0, 0.001, -2.0), Vec3::new(2.0, 0.9, 2.0))
}

/// Visible bits that were wanted, as requests to a backend answer them.
fn answers(visibility: &mut dyn Visibility, scene: &Scene, bvh: &Bvh, batch: &MaskBatch) -> Vec<u64> {
    let mut gbuffer = GBuffer::default();
    gbuffer.reset(batch.len() as u32, 1);
    gbuffer.primitive.fill(0);
    gbuffer.normal.fill(Vec3::Y);
    for (position, query) in gbuffer.position.iter_mut().zip(batch.queries()) {
        *position = query.origin;
    }
    let (pattern, pyramid) = (batch.pattern(), Pyramid::default());
    let (sharing, index, seed) = (Sharing::Receiver, 0, 0);
    let frame = Frame { scene, gbuffer: &gbuffer, pyramid: &pyramid, pattern, sharing, index, seed };
    visibility.prepare(&frame);
    let mut batch = batch.clone();
    Requests::new(visibility, bvh).masks(&frame, &mut batch);
    let masks = |query| batch.visible(query).iter().zip(batch.wanted(query));
    (0..batch.len()).flat_map(|query| masks(query).map(|(v, w)| v & w).collect::<Vec<_>>()).collect()
}

fn backends(bvh: &Arc<Bvh>) -> Vec<Box<dyn Visibility>> {
    vec![
        Box::new(BvhRays::new(bvh.clone())),
        Box::new(BvhRays::single_rays(bvh.clone())),
        Box::new(Beam::new(bvh.clone())),
        Box::new(Beam::or_rays(bvh.clone())),
        Box::new(Raster4d::new(Raster4dConfig::default()).unwrap()),
    ]
}

/// Compares all exact backends with brute force, and returns the number of bits that leaves hide.
fn compare(scene: &Scene, bvh: &Arc<Bvh>, count: usize) -> u32 {
    let mut hidden = 0;
    for (pattern, sparse) in patterns().flat_map(|pattern| [(pattern, false), (pattern, true)]) {
        let batch = ask(&receivers(count), pattern, sparse);
        let expected = answers(&mut BruteForce, scene, bvh, &batch);
        for (number, backend) in backends(bvh).iter_mut().enumerate() {
            if backend.supports(pattern).is_ok() && backend.supports_light(&scene.lights[0]).is_ok() {
                let found = answers(backend.as_mut(), scene, bvh, &batch);
                assert!(found == expected, "backend {number}, {pattern:?}, {sparse}");
            }
        }
        let wanted: u32 =
            (0..batch.len()).flat_map(|query| batch.wanted(query)).map(|w| w.count_ones()).sum();
        hidden += wanted - expected.iter().map(|word| word.count_ones()).sum::<u32>();
    }
    hidden
}

#[test]
fn exact_backends_agree_with_brute_force() {
    // Coordinates inside the unit square, repeated beyond it, and below zero.
    for (scale, shift) in [(1.0, Vec2::ZERO), (2.7, Vec2::new(0.3, 5.0)), (1.9, Vec2::new(-3.2, -1.1))] {
        let scene = masked(garden(&leaves(30), &[[Vec2::ZERO, Vec2::ONE]], scale, shift), alpha);
        let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
        assert!(bvh.masked().is_some() && bvh.is_over(&scene.mesh));
        assert!(compare(&scene, &bvh, 130) > 1000);
    }
    // Nothing but leaves.
    let mut scene = masked(whole(&leaves(30)), alpha);
    Arc::make_mut(&mut scene.mesh).material_ids.fill(LEAF);
    compare(&scene, &Arc::new(Bvh::build(&scene.mesh).unwrap()), 70);
}

#[test]
fn exact_backends_agree_under_spheres() {
    // Above the leaves; among them, with receivers inside and leaves that end in it; and touching the floor.
    for (centre, radius) in [(Vec3::Y * 3.0, 0.7), (Vec3::new(0.2, 0.9, 0.1), 0.6), (Vec3::Y * 0.5, 0.5)] {
        let mut scene = masked(whole(&leaves(30)), alpha);
        scene.lights = vec![AreaLight::sphere(centre, radius, Vec3::ONE)];
        let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
        assert!(compare(&scene, &bvh, 130) > 500);
        // Without masks, and with nothing but leaves.
        let mesh = Arc::make_mut(&mut scene.mesh);
        mesh.material_ids.fill(LEAF);
        let leaves_only = Arc::new(Bvh::build(mesh).unwrap());
        compare(&scene, &leaves_only, 70);
        let mesh = Arc::make_mut(&mut scene.mesh);
        mesh.material_ids.fill(0);
        let solid = Arc::new(Bvh::build(mesh).unwrap());
        assert!(solid.masked().is_none() && compare(&scene, &solid, 70) > 500);
    }
}

#[test]
fn masks_hide_what_their_solid_texels_would() {
    let leaves = leaves(12);
    // Texels are rows from the top; their corners are exact.
    let at = |column: u32, row: u32| Vec2::new(column as f32, row as f32) / SIDE as f32;
    let solid = (0..SIDE * SIDE).filter(|&texel| alpha(texel) == 128);
    let parts: Vec<[Vec2; 2]> = solid
        .map(|texel| (texel % SIDE, SIDE - 1 - texel / SIDE))
        .map(|(column, row)| [at(column, row), at(column + 1, row + 1)])
        .collect();
    let texels = garden(&leaves, &parts, 1.0, Vec2::ZERO);
    let pattern = Pattern::with_count(PatternKind::Jittered, 64).unwrap();
    let mut numbers = Numbers(9);
    let spread: Vec<Vec3> = (0..300).map(|_| numbers.point() * Vec3::new(2.0, 0.0, 2.0)).collect();
    let batch = ask(&spread, pattern, false);
    let of = |scene: &Scene| {
        let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
        let masks = answers(&mut BvhRays::new(bvh.clone()), scene, &bvh, &batch);
        let mut seen = GBuffer::default();
        gbuffer::trace(&bvh, scene, 50, 40, &mut seen);
        let materials: Vec<Option<u32>> = seen
            .primitive
            .iter()
            .map(|&triangle| scene.mesh.material_ids.get(triangle as usize).copied())
            .collect();
        (masks, materials)
    };
    let (expected, expected_seen) = of(&texels);
    let (found, seen) = of(&masked(whole(&leaves), alpha));
    // No ray of these passes within rounding of a texel's border.
    assert!(found == expected && seen == expected_seen);
    let count = |material: u32| seen.iter().filter(|&&seen| seen == Some(material)).count();
    assert!(count(LEAF) > 50 && count(0) > 100, "{} {}", count(LEAF), count(0));
    assert!(of(&whole(&leaves)).1 != expected_seen);
    // Another texel, a flipped image and no mask at all are found out.
    let wrong = [
        masked(whole(&leaves), |texel| if texel == 27 { 255 - alpha(texel) } else { alpha(texel) }),
        masked(whole(&leaves), |texel| alpha(SIDE * (SIDE - 1 - texel / SIDE) + texel % SIDE)),
        whole(&leaves),
    ];
    for scene in wrong {
        assert!(of(&scene).0 != expected);
    }
}

/// Images of the default configuration and of every pixel by every exact backend.
fn images(scene: &Scene) -> Vec<Image> {
    let prepared = PreparedScene::new(scene.clone()).unwrap();
    let size = PipelineConfig { width: 48, height: 36, antialias: 4, ..PipelineConfig::default() };
    let refiner = RefinerConfig::PerPixel;
    let mut configs = vec![size];
    for visibility in VisibilityConfig::NAMES.iter().filter_map(|name| VisibilityConfig::named(name)) {
        if visibility.is_exact() {
            let sampling = visibility.fit(size.sampling);
            let upsampler = refiner.upsampler();
            configs.push(PipelineConfig { refiner, upsampler, visibility, sampling, ..size });
        }
    }
    let render = |config: &PipelineConfig| {
        let mut pipeline: Pipeline = config.builder(&prepared).build().unwrap();
        pipeline.render().unwrap().clone()
    };
    configs.iter().map(render).collect()
}

#[test]
fn masks_of_one_kind_of_texel_change_nothing() {
    let leaves = leaves(20);
    let (plain, bare) = (images(&whole(&leaves)), images(&whole(&[])));
    for (alpha, expected) in [(255, &plain), (0, &bare)] {
        let found = images(&masked(whole(&leaves), |_| alpha));
        for (number, (found, expected)) in found.iter().zip(expected).enumerate() {
            assert!(found.irradiance == expected.irradiance, "{alpha} {number}");
            assert!(found.radiance == expected.radiance, "{alpha} {number}");
        }
    }
    assert!(plain.iter().zip(&bare).all(|(plain, bare)| plain.irradiance != bare.irradiance));
}

#[test]
fn moved_leaves_keep_their_masks() {
    let still = masked(whole(&leaves(20)), alpha);
    let mut moved = still.clone();
    let mesh = Arc::make_mut(&mut moved.mesh);
    mesh.positions[6..].iter_mut().for_each(|p| *p = *p * Vec3::new(0.9, 1.0, 1.1) + Vec3::X * 0.2);
    let refitted = PreparedScene::new(still.clone()).unwrap().moved(moved.clone()).unwrap();
    assert!(compare(&moved, refitted.bvh(), 70) > 500);
    // Other triangles with masks: the tree is built anew, and cannot be refitted.
    let without = whole(&leaves(20));
    assert!(!refitted.bvh().is_over(&without.mesh));
    assert!(Bvh::clone(refitted.bvh()).refit(&without.mesh).is_err());
    let rebuilt = refitted.moved(without.clone()).unwrap();
    assert!(rebuilt.bvh().masked().is_none() && rebuilt.bvh().is_over(&without.mesh));
    assert!(PreparedScene::with_bvh(without, refitted.bvh().clone()).is_err());
}

#[test]
fn certificates_know_of_masked_triangles() {
    let scene = masked(whole(&leaves(6)), alpha);
    let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
    let origins = receivers(400);
    let region = |&low: &Vec3| Region { low, high: low + Vec3::new(0.02, 0.001, 0.02) };
    let regions: Vec<Region> = origins.iter().map(region).collect();
    let pattern = Pattern { kind: PatternKind::Grid, columns: 8, rows: 8 };
    let (gbuffer, pyramid) = (GBuffer::default(), Pyramid::default());
    let (sharing, index, seed) = (Sharing::Receiver, 0, 0);
    let frame = Frame { scene: &scene, gbuffer: &gbuffer, pyramid: &pyramid, pattern, sharing, index, seed };
    let mut batch = MaskBatch::default();
    batch.reset(0, pattern, Purpose::Final);
    origins.iter().for_each(|&origin| batch.push(origin, Vec3::Y, 0, 0, None));
    let masks = answers(&mut BruteForce, &scene, &bvh, &batch);
    for mut backend in
        [Box::new(BvhRays::new(bvh.clone())) as Box<dyn Visibility>, Box::new(Beam::new(bvh.clone()))]
    {
        let (mut certificates, mut alone) = (Vec::new(), Vec::new());
        backend.certify(&frame, 0, &regions, &mut alone);
        Requests::new(backend.as_mut(), &bvh).certify(&frame, 0, &regions, &mut certificates);
        let lit = |certificates: &[Certificate]| {
            let pairs = certificates.iter().zip(&masks).filter(|(of, _)| **of == Certificate::Lit);
            let (all, wrong): (Vec<_>, Vec<_>) =
                (pairs.clone().collect(), pairs.filter(|(_, m)| **m != !0).collect());
            (all.len(), wrong.len())
        };
        // Without the masked triangles, regions in their shadow are taken for lit.
        assert!(lit(&alone).1 > 20, "{:?}", lit(&alone));
        let (all, wrong) = lit(&certificates);
        assert!(all > 20 && wrong == 0, "{all} {wrong}");
    }
}
