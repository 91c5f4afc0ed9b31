//! 4D rasterization against rays, with every combination of its switches.

use std::sync::Arc;

use glam::Vec3;
use halflight_core::frame::{Frame, Sharing};
use halflight_core::gbuffer::GBuffer;
use halflight_core::light::AreaLight;
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::pyramid::Pyramid;
use halflight_core::scene::Scene;

use super::*;
use crate::bvh::Bvh;
use crate::bvh::tests::meshes::{Numbers, answer, ask, clusters, cuboid, hall, lamp, scene, soup, sphere};
use crate::occluder::exact;
use crate::rays::BvhRays;

fn patterns() -> [Pattern; 4] {
    [
        (PatternKind::Grid, 64),
        (PatternKind::ShiftedRows, 15),
        (PatternKind::ShiftedRows, 1024),
        (PatternKind::Grid, 4096),
    ]
    .map(|(kind, count)| Pattern::with_count(kind, count).unwrap())
}

/// G-buffer with receivers at `origins`, from which the framebuffer's bounds are computed.
fn seen(origins: &[Vec3]) -> GBuffer {
    let mut gbuffer = GBuffer::default();
    gbuffer.reset(origins.len() as u32, 1);
    gbuffer.position.copy_from_slice(origins);
    gbuffer.normal.fill(Vec3::Y);
    gbuffer.primitive.fill(0);
    gbuffer
}

fn prepared(config: Raster4dConfig, scene: &Scene, origins: &[Vec3], isa: Isa) -> Raster4d {
    let mut raster = Raster4d::new(config).unwrap().with_isa(isa);
    let (gbuffer, pyramid) = (seen(origins), Pyramid::default());
    raster.prepare(&Frame {
        scene,
        gbuffer: &gbuffer,
        pyramid: &pyramid,
        pattern: patterns()[0],
        sharing: Sharing::Receiver,
        index: 0,
        seed: 0,
    });
    raster
}

fn configs() -> Vec<Raster4dConfig> {
    let all = Raster4dConfig::default();
    vec![
        all,
        Raster4dConfig { one_cell: false, ..all },
        Raster4dConfig { rejection: false, ..all },
        Raster4dConfig { rows: false, ..all },
        Raster4dConfig { coarser: false, ..all },
        Raster4dConfig { shafts: false, ..all },
        Raster4dConfig { framebuffer: 33, ..all },
        Raster4dConfig { framebuffer: 1, coarser: false, ..all },
    ]
}

fn first_difference(a: &[u64], b: &[u64]) -> Option<usize> {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).position(|(a, b)| a != b)
}

/// Compares masks of all kinds with those of single rays, bit for bit.
fn compare(scene: &Scene, origins: &[Vec3]) -> VisibilityStats {
    let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
    let mut counts = VisibilityStats::default();
    for pattern in patterns() {
        for sparse in [false, true] {
            let mut batch = ask(origins, pattern, sparse);
            let expected = answer(&mut BvhRays::new(bvh.clone()), scene, &mut batch);
            // Every combination at one size, every instruction set with one combination.
            let one = configs().into_iter().take(if pattern.len() <= 64 { configs().len() } else { 1 });
            let runs = one.map(|config| (config, Isa::best()));
            for (config, isa) in runs.chain(Isa::available().map(|isa| (Raster4dConfig::default(), isa))) {
                let mut raster = prepared(config, scene, origins, isa);
                let found = answer(&mut raster, scene, &mut batch);
                assert_eq!(
                    first_difference(&found, &expected),
                    None,
                    "{config:?} {isa:?} {pattern:?} {sparse}"
                );
                counts += raster.stats();
            }
        }
    }
    counts
}

fn origins(count: usize, low: Vec3, high: Vec3) -> Vec<Vec3> {
    let mut numbers = Numbers(31);
    (0..count).map(|_| low + (numbers.point() * 0.5 + 0.5) * (high - low)).collect()
}

#[test]
fn hall_and_soup() {
    let hall = scene(&hall(), lamp(Vec3::new(4.0, 3.8, 8.0), 1.5));
    let counts = compare(&hall, &origins(200, Vec3::new(0.1, 0.01, 0.1), Vec3::new(7.9, 2.9, 15.9)));
    assert!(counts.kept > 0 && counts.kept < counts.pairs / 2, "{counts:?}");
    let near = clusters(256, Vec3::new(0.1, 0.01, 0.1), Vec3::new(7.9, 2.9, 15.9));
    let counts = compare(&hall, &near);
    assert!(counts.listed > 0, "{counts:?}");
    compare(&scene(&soup(2000, 0.1), lamp(Vec3::Y * 1.5, 1.0)), &origins(200, Vec3::NEG_ONE, Vec3::ONE));
}

#[test]
fn lights_that_are_tilted_or_touch_cross_and_lie_behind_geometry() {
    let corner = lamp(Vec3::new(0.3, 1.2, -0.2), 0.8).corners()[0];
    let (u, v) = (Vec3::new(0.7, 0.3, 0.1), Vec3::new(-0.2, 0.5, 0.6));
    let tilted = AreaLight::parallelogram(corner, u, v, Vec3::ONE).two_sided();
    let mut corners = soup(300, 0.4);
    corners.extend(cuboid(Vec3::new(-0.2, 0.5, -0.2), Vec3::new(0.4, 0.7, 0.3)));
    // A ceiling in the light's plane.
    corners.push([Vec3::new(-2.0, 0.7, -2.0), Vec3::new(-2.0, 0.7, 2.0), Vec3::new(2.0, 0.7, 2.0)]);
    let origins = origins(200, Vec3::NEG_ONE, Vec3::ONE);
    for light in [tilted, lamp(Vec3::Y * 0.7, 0.5), lamp(Vec3::Y * 0.6, 1.0), lamp(Vec3::Y * -2.0, 1.0)] {
        compare(&scene(&corners, light), &origins);
    }
}

#[test]
fn receivers_near_the_light_s_plane() {
    let mut numbers = Numbers(3);
    let origins: Vec<_> = (0..200)
        .map(|_| {
            let height = 10f32.powf(-9.0 * numbers.next()) * if numbers.next() < 0.5 { -1.0 } else { 1.0 };
            numbers.point() * Vec3::new(1.0, 0.0, 1.0) + Vec3::Y * height
        })
        .collect();
    let counts = compare(&scene(&soup(500, 0.3), lamp(Vec3::ZERO, 0.5)), &origins);
    assert!(counts.unprojected > 0 && counts.pairs > 0, "{counts:?}");
}

#[test]
fn scales_places_and_triangles_without_area() {
    for (scale, offset) in [(1e-3, Vec3::ZERO), (1e4, Vec3::ZERO), (1.0, Vec3::new(1e5, -1e5, 1e5))] {
        let place = |p: Vec3| p * scale + offset;
        let mut corners: Vec<_> = sphere(6).iter().chain(&soup(200, 0.3)).map(|t| t.map(place)).collect();
        corners.push([place(Vec3::X); 3]);
        corners.push([Vec3::X, Vec3::X * 0.5, Vec3::ZERO].map(place));
        let light = lamp(place(Vec3::Y * 1.5), scale);
        let origins: Vec<_> =
            origins(100, Vec3::splat(-1.3), Vec3::splat(1.3)).into_iter().map(place).collect();
        compare(&scene(&corners, light), &origins);
    }
}

#[test]
fn what_cannot_be_done_is_said() {
    assert_eq!(
        Raster4d::new(Raster4dConfig { framebuffer: 0, ..Raster4dConfig::default() }).unwrap_err(),
        Raster4dError::Framebuffer(0)
    );
    let counting = Raster4dConfig { count_relevant: true, ..Raster4dConfig::default() };
    assert_eq!(Raster4d::new(counting).unwrap_err(), Raster4dError::Relevant);
    let raster = Raster4d::new(Raster4dConfig::default()).unwrap();
    let jittered = Pattern::with_count(PatternKind::Jittered, 64).unwrap();
    assert!(raster.supports(jittered).unwrap_err().to_string().contains("shifted-rows"));
    let long = Pattern { kind: PatternKind::Grid, columns: 100, rows: 1 };
    assert!(raster.supports(long).unwrap_err().to_string().contains("64 columns"));
    assert_eq!(raster.supports(patterns()[3]), Ok(()));
}

#[test]
fn relevant_pairs_are_those_that_hide_something() {
    let corners = soup(300, 0.4);
    let scene = scene(&corners, lamp(Vec3::Y * 1.5, 1.0));
    let origins = origins(40, Vec3::NEG_ONE, Vec3::ONE);
    let config = Raster4dConfig { shafts: false, count_relevant: true, ..Raster4dConfig::default() };
    let mut batch = ask(&origins, patterns()[0], true);
    let expected = answer(&mut BvhRays::new(Arc::new(Bvh::build(&scene.mesh).unwrap())), &scene, &mut batch);
    let mut raster = prepared(config, &scene, &origins, Isa::best());
    assert_eq!(answer(&mut raster, &scene, &mut batch), expected);
    let mut relevant = 0;
    for (number, query) in batch.queries().iter().enumerate() {
        for &corners in &corners {
            let hidden = |sample: usize| {
                let end = scene.lights[0].point(batch.pattern().position(sample, query.key));
                batch.wanted(number)[sample / 64] >> (sample % 64) & 1 == 1
                    && exact::meets(query.origin, end, corners)
            };
            relevant += u64::from((0..batch.pattern().len()).any(hidden));
        }
    }
    let stats = raster.stats();
    assert_eq!(stats.relevant, relevant);
    assert!(relevant > 0 && relevant <= stats.kept, "{stats:?}");
}

#[test]
fn a_wrong_bit_is_noticed() {
    let scene = scene(&soup(100, 0.5), lamp(Vec3::Y * 1.5, 1.0));
    let origins = origins(64, Vec3::NEG_ONE, Vec3::ONE);
    let mut raster = prepared(Raster4dConfig::default(), &scene, &origins, Isa::best());
    let right = answer(&mut raster, &scene, &mut ask(&origins, patterns()[0], false));
    let mut wrong = right.clone();
    wrong[37] ^= 1 << 11;
    assert_eq!(first_difference(&right, &wrong), Some(37));
}
