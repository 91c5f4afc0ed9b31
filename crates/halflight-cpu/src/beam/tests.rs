//! Beams against rays, and attempts to refute the certificates of shafts.

use std::sync::Arc;

use glam::Vec3;
use halflight_core::gbuffer::receiver_origin;
use halflight_core::light::AreaLight;
use halflight_core::mask::{MaskBatch, Query};
use halflight_core::scene::Scene;
use halflight_core::stages::Visibility;
use halflight_core::stats::VisibilityStats;

use super::Beam;
use crate::bvh::Bvh;
use crate::bvh::tests::meshes::{
    Numbers, answer, ask, clusters, cuboid, hall, lamp, patterns, scene, soup, sphere,
};
use crate::rays::BvhRays;
use crate::simd::Isa;

/// Compares the masks of beams, for every instruction set, with those of single rays bit for bit; returns the
/// beams' statistics.
fn compare(scene: &Scene, origins: &[Vec3]) -> VisibilityStats {
    let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
    let mut counts = VisibilityStats::default();
    for pattern in patterns() {
        for sparse in [false, true] {
            let mut batch = ask(origins, pattern, sparse);
            let expected = answer(&mut BvhRays::single_rays(bvh.clone()), scene, &mut batch);
            for isa in Isa::available() {
                let mut beam = Beam::new(bvh.clone()).with_isa(isa);
                let found = answer(&mut beam, scene, &mut batch);
                assert_eq!(first_difference(&found, &expected), None, "{isa:?} {pattern:?} sparse {sparse}");
                let found = beam.stats();
                let mut either = Beam::or_rays(bvh.clone()).with_isa(isa);
                let found_either = answer(&mut either, scene, &mut batch);
                assert_eq!(first_difference(&found_either, &expected), None, "{isa:?} {pattern:?} either");
                assert_eq!(found.receivers(), either.stats().receivers());
                let asked =
                    (0..batch.len()).filter(|&q| batch.wanted(q).iter().any(|&word| word != 0)).count();
                assert_eq!(found.receivers(), asked as u64);
                counts += found;
            }
        }
    }
    counts
}

fn first_difference(a: &[u64], b: &[u64]) -> Option<usize> {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).position(|(a, b)| a != b)
}

#[test]
fn hall_by_every_way_there_is() {
    let scene = scene(&hall(), lamp(Vec3::new(4.0, 3.8, 8.0), 1.5));
    let mut origins = clusters(640, Vec3::new(0.1, 0.01, 0.1), Vec3::new(7.9, 2.9, 15.9));
    // Between two beams, under the light.
    origins.extend(clusters(128, Vec3::new(3.0, 3.1, 7.5), Vec3::new(5.0, 3.4, 8.5)));
    let counts = compare(&scene, &origins);
    assert!(counts.lit > 0 && counts.umbra > 0 && counts.listed > 0, "{counts:?}");
}

#[test]
fn open_floors_are_certified_to_be_lit() {
    for (height, side) in [(0.0, 4.0), (5.3, 4.0), (-700.1, 40.0)] {
        let corner = |x: f32, z: f32| Vec3::new(x * side, height, z * side);
        let [a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, z)| corner(x, z));
        let scene = scene(&[[a, b, c], [a, c, d]], lamp(Vec3::new(2.0, height + 3.0, 2.0), 1.0));
        let points = clusters(512, corner(0.1, 0.1), corner(0.9, 0.9)).into_iter();
        let origins: Vec<Vec3> =
            points.map(|point| receiver_origin(point.as_dvec3(), Vec3::Y, side)).collect();
        let counts = compare(&scene, &origins);
        assert!(counts.lit > 0, "{height}: {counts:?}");
        assert_eq!((counts.listed, counts.left_to_rays), (0, 0), "{height}");
    }
}

#[test]
fn dense_soup_is_left_to_rays() {
    let scene = scene(&soup(4000, 0.2), lamp(Vec3::new(0.1, 1.5, 0.0), 1.0));
    let counts = compare(&scene, &clusters(512, Vec3::splat(-1.0), Vec3::splat(1.0)));
    assert!(counts.left_to_rays > 100 && counts.walked > 100, "{counts:?}");
}

#[test]
fn groups_with_many_triangles_are_left_to_rays_as_a_whole() {
    let origins = clusters(512, Vec3::splat(-1.0), Vec3::splat(1.0));
    let asked = |triangles: usize, pattern, rays: bool| {
        let scene = scene(&soup(triangles, 0.2), lamp(Vec3::new(0.1, 1.5, 0.0), 1.0));
        let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
        let mut beam = if rays { Beam::or_rays(bvh) } else { Beam::new(bvh) };
        answer(&mut beam, &scene, &mut ask(&origins, pattern, false));
        beam.stats()
    };
    let [of_64, of_16, .., of_256] = patterns().collect::<Vec<_>>()[..] else { panic!("patterns") };
    for pattern in [of_64, of_16] {
        let few = asked(3, pattern, true);
        assert!(few.left_to_rays == 0 && few.lit > 0 && few.listed > 0, "{few:?}");
        let many = asked(4000, pattern, true);
        assert!(many.left_to_rays > 256 && many.walked == 0, "{many:?}");
    }
    // For any number of samples that form one packet.
    let left =
        |pattern| [400, 800, 1600].map(|count| asked(count, pattern, true).left_to_rays).iter().sum::<u64>();
    assert_eq!(left(of_16), left(of_64));
    // With more than one packet of rays, `auto` uses beams as `beam` does.
    assert_eq!(asked(4000, of_256, true), asked(4000, of_256, false));
}

#[test]
fn lights_that_are_tilted_or_touch_cross_and_lie_behind_geometry() {
    let corner = lamp(Vec3::new(0.3, 1.2, -0.2), 0.8).corners()[0];
    let (u, v) = (Vec3::new(0.7, 0.3, 0.1), Vec3::new(-0.2, 0.5, 0.6));
    let tilted = AreaLight::parallelogram(corner, u, v, Vec3::ONE).two_sided();
    let mut corners = soup(300, 0.4);
    corners.extend(cuboid(Vec3::new(-0.2, 0.5, -0.2), Vec3::new(0.4, 0.7, 0.3)));
    let origins = clusters(512, Vec3::splat(-1.0), Vec3::splat(1.0));
    // In the box's upper face, through its middle, below everything.
    for light in [tilted, lamp(Vec3::Y * 0.7, 0.5), lamp(Vec3::Y * 0.6, 1.0), lamp(Vec3::Y * -2.0, 1.0)] {
        compare(&scene(&corners, light), &origins);
    }
}

#[test]
fn scales_and_places() {
    for (scale, offset) in [(1e-3, Vec3::ZERO), (1e4, Vec3::ZERO), (1.0, Vec3::new(1e5, -1e5, 1e5))] {
        let place = |p: Vec3| p * scale + offset;
        let corners: Vec<_> = sphere(8).iter().chain(&soup(200, 0.3)).map(|t| t.map(place)).collect();
        let mut light = lamp(place(Vec3::Y * 1.5), scale);
        light.two_sided = true;
        let origins: Vec<_> =
            clusters(512, Vec3::splat(-1.3), Vec3::splat(1.3)).into_iter().map(place).collect();
        compare(&scene(&corners, light), &origins);
    }
}

#[test]
fn receivers_in_the_planes_of_triangles() {
    // Origins in the floor and on edges of the grid that it is made of.
    let mut corners = Vec::new();
    for cell in 0..64 {
        let at = Vec3::new((cell % 8) as f32, 0.0, (cell / 8) as f32) * 0.25 - Vec3::new(1.0, 0.0, 1.0);
        let (u, v) = (Vec3::X * 0.25, Vec3::Z * 0.25);
        corners.extend([[at, at + u, at + u + v], [at, at + u + v, at + v]]);
    }
    corners.extend(cuboid(Vec3::new(-0.25, 0.25, -0.25), Vec3::new(0.25, 0.5, 0.25)));
    let origins: Vec<_> = (0..512)
        .map(|index| Vec3::new((index % 32) as f32 / 16.0 - 1.0, 0.0, (index / 32) as f32 / 8.0 - 1.0))
        .collect();
    let stats = compare(&scene(&corners, lamp(Vec3::Y, 0.5)), &origins);
    // The floor touches every shaft, so no certificate holds here.
    assert!(stats.listed > 0, "{stats:?}");
}

/// Batch of the receivers of each cluster, with 64 samples each.
fn ask_clusters(origins: &[Vec3]) -> MaskBatch {
    ask(origins, patterns().next().unwrap(), false)
}

#[test]
fn thin_and_tiny_triangles_do_not_break_a_certificate() {
    let mut numbers = Numbers(9);
    let mut certified = VisibilityStats::default();
    for round in 0..60 {
        // Wires and specks between a light and its receivers, and plates that nearly cover it.
        let mut corners = Vec::new();
        for _ in 0..round % 12 {
            let at = numbers.point() * Vec3::new(1.5, 0.4, 1.5) + Vec3::Y;
            let long = numbers.point() * 3.0;
            let thin = numbers.point() * 10f32.powf(-7.0 * numbers.next());
            let short = if numbers.next() < 0.5 { long } else { thin * 2.0 };
            corners.push([at, at + short, at + thin]);
        }
        if round % 3 == 0 {
            let edge = 0.5 + 0.6 * numbers.next();
            let (u, v) = (Vec3::X * edge * 2.0, Vec3::Z * edge * 2.0);
            let at = Vec3::new(-edge, 1.9, -edge);
            corners.extend([[at - u, at + u * 2.0, at + v * 3.0], [at, at + u, at + v]]);
        }
        let scene = scene(&corners, lamp(Vec3::Y * 2.0, 1.0));
        let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
        let origins = clusters(640, Vec3::new(-1.0, -0.2, -1.0), Vec3::new(1.0, 0.2, 1.0));
        let mut batch = ask_clusters(&origins);
        let expected = answer(&mut BvhRays::single_rays(bvh.clone()), &scene, &mut batch);
        let mut beam = Beam::new(bvh);
        let found = answer(&mut beam, &scene, &mut batch);
        assert_eq!(first_difference(&found, &expected), None, "round {round}");
        certified += beam.stats();
    }
    assert!(certified.lit > 1000 && certified.umbra > 1000, "{certified:?}");
    assert_eq!(certified.spared, 64 * (certified.lit + certified.umbra));
}

#[test]
fn order_and_threads_do_not_matter() {
    let scene = scene(&hall(), lamp(Vec3::new(4.0, 3.8, 8.0), 1.5));
    let origins = clusters(700, Vec3::new(0.1, 0.01, 0.1), Vec3::new(7.9, 2.9, 15.9));
    let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
    for rays in [false, true] {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut batch = ask(&origins, patterns().next().unwrap(), true);
            let mut beam = if rays { Beam::or_rays(bvh.clone()) } else { Beam::new(bvh.clone()) };
            (pool.install(|| answer(&mut beam, &scene, &mut batch)), beam.stats())
        };
        let alone = on(1);
        assert_eq!(on(2), alone);
        assert_eq!(on(8), alone);
    }
}

#[test]
fn the_order_of_tiles_is_known() {
    let blank = Query { origin: Vec3::ZERO, normal: Vec3::Y, key: 0, pixel: 0, asked: 0 };
    let follow = |pixels: &[u32]| {
        let queries: Vec<Query> = pixels.iter().map(|&pixel| Query { pixel, ..blank }).collect();
        super::follow_tiles(20, &queries)
    };
    // Rows of a tile in any order, the tile to its right, and one in the row of tiles below.
    assert!(follow(&[0, 1, 21, 3, 147, 8, 15, 28, 16, 160, 7 + 160, 8 + 160]));
    assert!(!follow(&[0, 8, 20]) && !follow(&[160, 19]) && !follow(&[1, 161, 2]));
    assert!(follow(&[]) && follow(&[399]));
}

#[test]
fn a_wrong_bit_is_noticed() {
    let scene = scene(&soup(100, 0.5), lamp(Vec3::Y * 1.5, 1.0));
    let mut beam = Beam::new(Arc::new(Bvh::build(&scene.mesh).unwrap()));
    let right =
        answer(&mut beam, &scene, &mut ask_clusters(&clusters(64, Vec3::splat(-1.0), Vec3::splat(1.0))));
    let mut wrong = right.clone();
    wrong[37] ^= 1 << 11;
    assert_eq!(first_difference(&right, &wrong), Some(37));
}
