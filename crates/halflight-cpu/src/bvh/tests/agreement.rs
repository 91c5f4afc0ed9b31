//! Packets, single rays and brute force return identical masks.

use std::sync::Arc;

use glam::Vec3;
use halflight_core::scene::Scene;

use super::meshes::{Numbers, answer, ask, hall, lamp, patterns, scene, soup};
use crate::brute_force::BruteForce;
use crate::bvh::Bvh;
use crate::occluder::exact;
use crate::rays::BvhRays;
use crate::simd::Isa;

/// Index of the first word in which two lists of masks differ.
fn difference(a: &[u64], b: &[u64]) -> Option<usize> {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).position(|(a, b)| a != b)
}

/// Origins inside a box in clusters of 16, similar to the pixels of a tile.
fn origins(count: usize, low: Vec3, high: Vec3) -> Vec<Vec3> {
    let mut numbers = Numbers(77);
    let mut middle = low;
    (0..count)
        .map(|index| {
            if index % 16 == 0 {
                middle = low + (numbers.point() * 0.5 + 0.5) * (high - low);
            }
            (middle + numbers.point() * (high - low) * 0.01).clamp(low, high)
        })
        .collect()
}

/// Compares packets with single rays for all instruction sets; returns the numbers of traced and of visible
/// rays.
fn compare(scene: &Scene, origins: &[Vec3], brute: usize) -> (u64, u64) {
    let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
    let (mut rays, mut seen) = (0, 0);
    for pattern in patterns() {
        for sparse in [false, true] {
            let mut batch = ask(origins, pattern, sparse);
            let single = BvhRays::single_rays(bvh.clone());
            let expected = answer(&mut single.clone(), scene, &mut batch);
            for isa in Isa::available() {
                let found = answer(&mut BvhRays::new(bvh.clone()).with_isa(isa), scene, &mut batch);
                assert_eq!(difference(&found, &expected), None, "{isa:?} {pattern:?} packets");
            }
            let few = &origins[..brute.min(origins.len())];
            let mut batch = ask(few, pattern, sparse);
            let brute = answer(&mut BruteForce, scene, &mut batch);
            assert_eq!(difference(&brute, &expected[..brute.len()]), None, "{pattern:?} brute force");
            for isa in Isa::available() {
                let found = answer(&mut single.clone().with_isa(isa), scene, &mut batch);
                assert_eq!(difference(&found, &brute), None, "{isa:?} {pattern:?} single rays");
            }
            rays += (0..batch.len())
                .flat_map(|q| batch.wanted(q))
                .map(|w| u64::from(w.count_ones()))
                .sum::<u64>()
                * (origins.len() / few.len()) as u64;
            seen += expected.iter().map(|word| u64::from(word.count_ones())).sum::<u64>();
        }
    }
    (rays, seen)
}

#[test]
fn soup_of_large_and_of_small_triangles() {
    for (count, size) in [(300, 0.5), (4000, 0.05)] {
        let scene = scene(&soup(count, size), lamp(Vec3::new(0.1, 1.5, 0.0), 1.0));
        let (rays, seen) = compare(&scene, &origins(1024, Vec3::splat(-1.0), Vec3::splat(1.0)), 32);
        // Both outcomes must be common, or the comparison has no power.
        assert!(seen > rays / 50 && seen < rays - rays / 50, "{seen} of {rays}");
    }
}

#[test]
fn first_hits_are_those_of_an_exact_search() {
    let scene = scene(&soup(300, 0.5), lamp(Vec3::new(0.1, 1.5, 0.0), 1.0));
    let bvh = Bvh::build(&scene.mesh).unwrap();
    let mut numbers = Numbers(5);
    let (mut met, mut missed) = (0, 0);
    for _ in 0..20 {
        // More than one packet.
        let (origin, ends) = (numbers.point(), (0..70).map(|_| numbers.point() * 0.8).collect::<Vec<_>>());
        let mut parts = vec![0.0; ends.len()];
        bvh.first_hits(&scene.mesh, origin, &ends, &mut parts);
        for (&end, &part) in ends.iter().zip(&parts) {
            let ray = exact::Ray { origin, d: end - origin };
            let corners = (0..scene.mesh.triangle_count()).map(|index| scene.mesh.corners(index));
            let hits =
                corners.filter(|&corners| ray.meets(corners)).map(|corners| ray.parameter(corners) as f32);
            let expected = hits.fold(f32::INFINITY, f32::min);
            if expected < 1.0 {
                // Parameters of vectors are rounded to single precision, a few units in the last place.
                assert!((part / expected - 1.0).abs() < 1e-5, "{part} {expected}");
                met += 1;
            } else {
                assert_eq!(part, f32::INFINITY, "{expected}");
                missed += 1;
            }
        }
    }
    assert!(met > 200 && missed > 200, "{met} {missed}");
}

#[test]
fn hall_with_columns() {
    let scene = scene(&hall(), lamp(Vec3::new(4.0, 3.8, 8.0), 1.5));
    let (rays, seen) =
        compare(&scene, &origins(3072, Vec3::new(0.1, 0.01, 0.1), Vec3::new(7.9, 2.9, 15.9)), 32);
    assert!(rays > 1_000_000, "{rays}");
    assert!(seen > rays / 50 && seen < rays - rays / 50, "{seen} of {rays}");
}

#[test]
fn threads_do_not_matter() {
    let scene = scene(&soup(2000, 0.1), lamp(Vec3::Y * 1.5, 1.0));
    let mut rays = BvhRays::new(Arc::new(Bvh::build(&scene.mesh).unwrap()));
    let origins = origins(1000, Vec3::splat(-1.0), Vec3::splat(1.0));
    let mut on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut batch = ask(&origins, patterns().next().unwrap(), true);
        pool.install(|| answer(&mut rays, &scene, &mut batch))
    };
    let alone = on(1);
    assert_eq!(difference(&on(2), &alone), None);
    assert_eq!(difference(&on(8), &alone), None);
}

#[test]
fn a_wrong_bit_is_noticed() {
    let scene = scene(&soup(300, 0.5), lamp(Vec3::Y * 1.5, 1.0));
    let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
    let mut batch = ask(&origins(64, Vec3::splat(-1.0), Vec3::splat(1.0)), patterns().next().unwrap(), false);
    let right = answer(&mut BvhRays::new(bvh), &scene, &mut batch);
    let mut wrong = right.clone();
    wrong[37] ^= 1 << 11;
    assert_eq!(difference(&right, &wrong), Some(37));
}
