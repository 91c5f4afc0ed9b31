//! Meshes over which a BVH can and cannot be built.

use std::sync::Arc;

use glam::Vec3;
use halflight_core::scene::{Mesh, MeshError};

use super::meshes::{answer, ask, lamp, mesh, patterns, scene, soup};
use crate::bvh::{Bvh, BvhError};
use crate::occluder::Block;
use crate::rays::BvhRays;

#[test]
fn an_empty_mesh_shadows_nothing() {
    let scene = scene(&[], lamp(Vec3::Y, 1.0));
    let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
    for pattern in patterns() {
        let mut batch = ask(&[Vec3::ZERO, Vec3::ONE], pattern, true);
        let wanted: Vec<u64> = (0..2).flat_map(|query| batch.wanted(query).to_vec()).collect();
        for mut visibility in [BvhRays::new(bvh.clone()), BvhRays::single_rays(bvh.clone())] {
            assert_eq!(answer(&mut visibility, &scene, &mut batch), wanted);
        }
    }
}

#[test]
fn every_triangle_is_somewhere_and_sizes_are_told() {
    for count in [1, 2, 8, 9, 1000] {
        let bvh = Bvh::build(&mesh(&soup(count, 0.1))).unwrap();
        let lanes = bvh.blocks.iter().flat_map(|block| (0..8).map(|lane| block.triangle(lane)));
        let mut found: Vec<u32> = lanes.filter(|&triangle| triangle != u32::MAX).collect();
        found.sort_unstable();
        assert_eq!(found, (0..count as u32).collect::<Vec<_>>());
        assert_eq!(bvh.triangle_count(), count);
        assert!(bvh.bytes() >= count * 36);
    }
}

#[test]
fn any_number_of_threads_builds_the_same() {
    // Enough triangles for ranges that several threads share.
    let mesh = mesh(&soup(50_000, 0.02));
    let built = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let bvh = pool.install(|| Bvh::build(&mesh).unwrap());
        let triangles: Vec<u32> = bvh.blocks.iter().flat_map(Block::triangles).collect();
        (triangles, format!("{:?}", bvh.nodes))
    };
    let one = built(1);
    assert!(built(4) == one);
    assert_eq!(one.0.len(), 50_000);
}

#[test]
fn a_thousand_copies_of_one_triangle_are_no_trouble() {
    let scene = scene(&vec![[Vec3::ZERO, Vec3::X, Vec3::Z]; 1000], lamp(Vec3::new(0.2, 1.0, 0.2), 0.1));
    let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
    let mut batch =
        ask(&[Vec3::new(0.2, -1.0, 0.2), Vec3::new(0.2, 0.5, 0.2)], patterns().next().unwrap(), false);
    assert_eq!(answer(&mut BvhRays::new(bvh), &scene, &mut batch), [0, u64::MAX]);
}

#[test]
fn contradictions_and_overflow_are_errors() {
    let good = mesh(&soup(3, 0.1));
    let bad = Mesh { triangles: vec![[0, 1, 99]; 3], ..good.clone() };
    assert!(matches!(Bvh::build(&bad), Err(BvhError::Mesh(MeshError::Index { index: 99, .. }))));
    let mut bad = good.clone();
    bad.positions[4].y = f32::NAN;
    assert_eq!(Bvh::build(&bad).unwrap_err(), BvhError::Mesh(MeshError::NotFinite { vertex: 4 }));
    let tiny = Mesh { positions: good.positions.iter().map(|&p| p * 1e-12).collect(), ..good.clone() };
    assert_eq!(Bvh::build(&tiny).unwrap_err(), BvhError::Mesh(MeshError::TooSmall));
    let mut bad = good;
    bad.positions[5].z = -2e12;
    let error = Bvh::build(&bad).unwrap_err();
    assert_eq!(error, BvhError::Mesh(MeshError::TooFar { vertex: 5 }));
    assert!(error.to_string().contains("vertex 5"));
}
