//! Masks of a refitted BVH equal those of a new one.

use crate::prepared::PreparedScene;
use std::sync::Arc;

use glam::{Mat3, Vec3};
use halflight_core::scene::{Camera, Mesh, MeshError, Scene};

use super::meshes::{Numbers, answer, ask, clusters, hall, lamp, mesh, patterns, scene, soup};
use crate::bvh::{Bvh, BvhError};
use crate::pipeline::{Pipeline, PipelineError};
use crate::rays::BvhRays;

/// BVH over `from`, refitted to `to`.
fn refitted(from: &Mesh, to: &Mesh) -> Bvh {
    let mut bvh = Bvh::build(from).unwrap();
    bvh.refit(to).unwrap();
    bvh
}

/// Visible bits of the samples that are wanted.
fn answers(bvh: &Arc<Bvh>, scene: &Scene, origins: &[Vec3]) -> Vec<u64> {
    let pattern = patterns().next().unwrap();
    let visible =
        |sparse| answer(&mut BvhRays::new(Arc::clone(bvh)), scene, &mut ask(origins, pattern, sparse));
    [false, true].into_iter().flat_map(visible).collect()
}

/// Name of a motion, and the function that moves a vertex.
type Motion = (&'static str, Box<dyn FnMut(Vec3) -> Vec3>);

/// Rigid motion, bending, pulling apart, random offsets, projection onto a plane, and a large translation.
fn motions() -> Vec<Motion> {
    let mut numbers = Numbers(9);
    let mut others = Numbers(10);
    let turn = Mat3::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 0.7);
    vec![
        ("stay", Box::new(|p| p)),
        ("turn", Box::new(move |p| turn * p)),
        ("bend", Box::new(|p| p + Vec3::X * (0.3 * p.y * p.y))),
        ("swell", Box::new(|p| p * (1.0 + p.length()))),
        ("shake", Box::new(move |p| p + numbers.point() * 0.05)),
        ("scatter", Box::new(move |_| others.point())),
        ("flatten", Box::new(|p| Vec3::new(p.x, 0.25, p.z))),
        ("carry off", Box::new(|p| p + Vec3::new(3e4, -2e4, 1e4))),
    ]
}

#[test]
fn answers_are_those_of_a_fresh_build() {
    for (from, low, high, middle) in [
        (soup(600, 0.2), Vec3::splat(-1.0), Vec3::splat(1.0), Vec3::Y * 1.2),
        (hall(), Vec3::splat(0.1), Vec3::new(7.9, 2.9, 15.9), Vec3::new(4.0, 3.8, 8.0)),
    ] {
        let still = mesh(&from);
        let mut mixed = 0;
        for (name, mut motion) in motions() {
            let corners: Vec<[Vec3; 3]> = from.iter().map(|corners| corners.map(&mut motion)).collect();
            let light = lamp(motion(middle), 1.0);
            let origins: Vec<Vec3> = clusters(96, low, high).into_iter().map(&mut motion).collect();
            let scene = scene(&corners, light);
            let fresh = Arc::new(Bvh::build(&scene.mesh).unwrap());
            let moved = Arc::new(refitted(&still, &scene.mesh));
            assert_eq!((moved.diagonal(), moved.largest()), (fresh.diagonal(), fresh.largest()), "{name}");
            let expected = answers(&fresh, &scene, &origins);
            assert!(answers(&moved, &scene, &origins) == expected, "{name}");
            let visible: u32 = expected.iter().map(|bits| bits.count_ones()).sum();
            mixed += usize::from(visible > 1000);
            // Without the refit the masks must differ, or the comparison has no power.
            if name == "turn" {
                assert!(answers(&Arc::new(Bvh::build(&still).unwrap()), &scene, &origins) != expected);
            }
        }
        assert!(mixed >= 4, "{mixed}");
    }
}

#[test]
fn fitted_to_where_it_was_it_is_what_it_was() {
    let still = mesh(&soup(2000, 0.1));
    let built = Bvh::build(&still).unwrap();
    let mut moved = refitted(&still, &mesh(&soup(2000, 0.7)));
    assert!(moved.cost() > 2.0 * built.cost());
    moved.refit(&still).unwrap();
    assert_eq!(format!("{:?}", moved.nodes), format!("{:?}", built.nodes));
    assert_eq!(format!("{:?}", moved.blocks), format!("{:?}", built.blocks));
    assert_eq!(moved.cost(), built.cost());
}

#[test]
fn cost_is_the_surface_of_all_boxes_over_that_of_the_root() {
    // Two flat blocks of eight triangles, far apart: each box is 1 × 0 × 1, the root's 11 × 0 × 1.
    let triangle = |x: f32| [Vec3::X * x, Vec3::new(x + 1.0, 0.0, 0.0), Vec3::new(x, 0.0, 1.0)];
    let corners: Vec<[Vec3; 3]> = (0..16).map(|index| triangle(if index < 8 { 0.0 } else { 10.0 })).collect();
    let cost = Bvh::build(&mesh(&corners)).unwrap().cost();
    // Boxes are padded by a hundred-thousandth of the diagonal on all sides.
    assert!((cost - 2.0 / 11.0).abs() < 1e-3, "{cost}");
    assert_eq!(Bvh::build(&mesh(&[])).unwrap().cost(), 0.0);
}

#[test]
fn other_meshes_are_refused_and_change_nothing() {
    let still = mesh(&soup(100, 0.1));
    let mut bvh = Bvh::build(&still).unwrap();
    let before = format!("{bvh:?}");
    let error = bvh.refit(&mesh(&soup(99, 0.1))).unwrap_err();
    assert_eq!(error, BvhError::TriangleCount { found: 99, expected: 100 });
    let mut far = still.clone();
    far.positions[7].x = 2e12;
    assert_eq!(bvh.refit(&far).unwrap_err(), BvhError::Mesh(MeshError::TooFar { vertex: 7 }));
    far.positions[7].x = f32::NAN;
    assert!(matches!(bvh.refit(&far), Err(BvhError::Mesh(_))));
    assert_eq!(format!("{bvh:?}"), before);
    let mut empty = Bvh::build(&mesh(&[])).unwrap();
    empty.refit(&mesh(&[])).unwrap();
}

#[test]
fn a_pipeline_goes_on_with_what_has_moved() {
    let corners = hall();
    let at = |shift: f32| {
        let corners: Vec<[Vec3; 3]> =
            corners.iter().map(|corners| corners.map(|p| p + Vec3::X * (shift * p.y))).collect();
        let camera =
            Camera { eye: Vec3::new(4.0, 2.0, 15.0), target: Vec3::new(4.0, 1.0, 0.0), ..Camera::default() };
        Arc::new(Scene { camera, ..scene(&corners, lamp(Vec3::new(4.0 + 3.8 * shift, 3.8, 8.0), 1.5)) })
    };
    let pipeline = |scene: &Arc<Scene>| {
        let prepared = PreparedScene::new(Scene::clone(scene)).unwrap();
        (Pipeline::builder(&prepared).size(48, 36).build().unwrap(), prepared)
    };
    let (still, moved) = (at(0.0), at(0.3));
    let (mut going, prepared) = pipeline(&still);
    let before = going.render().unwrap().irradiance.clone();
    let follow = prepared.moved(Scene::clone(&moved)).unwrap();
    let backend = Box::new(BvhRays::new(Arc::clone(follow.bvh())));
    // A scene that cannot be rendered is refused, and the pipeline is unchanged.
    let dark = follow.moved(Scene { lights: Vec::new(), ..Scene::clone(&moved) }).unwrap();
    let fault = going.set_scene(&dark, backend.clone());
    assert!(matches!(fault, Err(PipelineError::NoLight)));
    going.set_frame_index(0);
    assert_eq!(going.render().unwrap().irradiance, before);
    going.set_scene(&follow, backend).unwrap();
    going.set_frame_index(0);
    let after = going.render().unwrap().irradiance.clone();
    assert_eq!(after, pipeline(&moved).0.render().unwrap().irradiance);
    assert_ne!(after, before);
}
