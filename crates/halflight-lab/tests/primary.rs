//! Primary hits against brute force in double precision.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail their test")]

use glam::{Vec2, Vec3};
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};
use halflight_core::hash;
use halflight_core::scene::{Camera, Material, Mesh, Scene};
use halflight_cpu::bvh::Bvh;
use halflight_cpu::gbuffer;
use halflight_lab::exactness::SCENES;
use halflight_lab::exactness::primary::check;
use std::sync::Arc;

fn trace(scene: &Scene, width: u32, height: u32) -> GBuffer {
    let mut seen = GBuffer::default();
    gbuffer::trace(&Bvh::build(&scene.mesh).unwrap(), scene, width, height, &mut seen);
    seen
}

/// A mesh of separate triangles.
fn mesh(corners: &[[Vec3; 3]]) -> Mesh {
    let count = corners.len() as u32;
    Mesh {
        positions: corners.iter().flatten().copied().collect(),
        normals: vec![Vec3::Y; corners.len() * 3],
        uvs: vec![Vec2::ZERO; corners.len() * 3],
        triangles: (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        material_ids: vec![0; corners.len()],
        materials: vec![Material::default()],
        ..Mesh::default()
    }
}

/// Triangles of 1 to 2 m, 5,000 times as long as wide, nearly in the plane y = 0 that the camera looks along.
fn slivers(shift: Vec3) -> Scene {
    let unit = |index: u32, word: u32| hash::unit_pair(hash::sample_bits(index, word)).0;
    let sliver = |index: u32| {
        let at = Vec3::new(unit(index, 0) - 0.5, 0.02 * (unit(index, 1) - 0.5), unit(index, 2) - 0.5) * 4.0;
        let turn = std::f32::consts::TAU * unit(index, 3);
        let along = Vec3::new(turn.cos(), 0.05 * (unit(index, 4) - 0.5), turn.sin()) * (1.0 + unit(index, 5));
        let across = along.cross(Vec3::new(0.1 * unit(index, 6), 1.0, 0.0)).normalize();
        let corners = [at, at + along, at + along * unit(index, 7) + across * along.length() / 5000.0];
        corners.map(|corner| corner + shift)
    };
    let corners: Vec<[Vec3; 3]> = (0..40_000).map(sliver).collect();
    let camera = Camera {
        eye: Vec3::new(0.3, 0.12, 4.0) + shift,
        target: Vec3::new(0.0, 0.0, 0.0) + shift,
        up: Vec3::Y,
        fov_y_deg: 30.0,
        ..Camera::default()
    };
    Scene { mesh: Arc::new(mesh(&corners)), camera, ..Scene::default() }
}

#[test]
fn pixels_of_bundled_scenes_see_what_brute_force_finds() {
    for name in SCENES {
        let scene = halflight_scene::load_bundled(name).unwrap().scene;
        let found = check(&scene, &trace(&scene, 320, 240));
        assert_eq!((found.pixels, found.different), (320 * 240, 0), "{name}: {found:?}");
        assert!(found.open < 100, "{name}: {found:?}");
    }
}

#[test]
fn pixels_see_through_the_holes_of_alpha_masks() {
    let scene = halflight_scene::load_bundled("garden").unwrap().scene;
    let seen = trace(&scene, 200, 150);
    let found = check(&scene, &seen);
    assert_eq!((found.pixels, found.different), (200 * 150, 0), "{found:?}");
    assert!(found.open < 100, "{found:?}");
    let leaves = |seen: &GBuffer| {
        seen.primitive
            .iter()
            .filter(|&&t| t != NO_PRIMITIVE && scene.mesh.alpha_mask(t as usize).is_some())
            .count()
    };
    // Solid leaves hide more, and brute force tells the two apart.
    let mut solid = scene.clone();
    Arc::make_mut(&mut solid.mesh).alpha_masks.clear();
    Arc::make_mut(&mut solid.mesh).materials.iter_mut().for_each(|material| material.alpha_mask = None);
    let counts = [&seen, &trace(&solid, 200, 150)].map(leaves);
    assert!(counts[0] > 500 && counts[1] > counts[0] + 500, "{counts:?}");
    assert!(check(&solid, &seen).different > 500);
}

#[test]
fn slivers_at_glancing_angles_are_where_brute_force_finds_them() {
    for shift in [Vec3::ZERO, Vec3::new(300.0, 20.0, -500.0)] {
        let scene = slivers(shift);
        let seen = trace(&scene, 480, 160);
        let (hits, found) =
            (seen.primitive.iter().filter(|&&t| t != NO_PRIMITIVE).count(), check(&scene, &seen));
        assert!(hits > 1000 && hits < 480 * 160 / 2, "{hits}");
        assert_eq!(found.different, 0, "{shift}: {found:?}");
        assert!(found.open < 1000, "{shift}: {found:?}");
    }
}

#[test]
fn coplanar_triangles_give_way_to_the_first() {
    // One rectangle by other triangles, in both orders, and a third just behind it.
    let [a, b, c, d] =
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| Vec3::new(x, 0.3 * x, z));
    let behind = Vec3::NEG_Y * 1e-6;
    let list = [[a, b, c], [a, c, d], [b, c, d], [d, a, b], [a + behind, b + behind, c + behind]];
    let camera = Camera {
        eye: Vec3::new(0.2, 3.0, 0.1),
        target: Vec3::ZERO,
        up: Vec3::X,
        fov_y_deg: 30.0,
        ..Camera::default()
    };
    let view = |corners: &[[Vec3; 3]]| {
        trace(&Scene { mesh: Arc::new(mesh(corners)), camera, ..Scene::default() }, 64, 64)
    };
    assert!(view(&list).primitive.iter().all(|&triangle| triangle < 2));
    let turned = [list[4], list[2], list[3], list[1], list[0]];
    assert!(view(&turned).primitive.iter().all(|&triangle| triangle == 1 || triangle == 2));
}

#[test]
fn wrong_pixels_are_found() {
    let scene = slivers(Vec3::ZERO);
    let right = trace(&scene, 120, 40);
    let hit = right.primitive.iter().position(|&triangle| triangle != NO_PRIMITIVE).unwrap();
    for wrong in [
        |seen: &mut GBuffer, hit: usize| seen.primitive[hit] ^= 1,
        |seen: &mut GBuffer, hit: usize| seen.depth[hit] *= 1.00001,
        |seen: &mut GBuffer, hit: usize| {
            (seen.primitive[hit], seen.depth[hit]) = (NO_PRIMITIVE, f32::INFINITY);
        },
    ] {
        let mut seen = right.clone();
        wrong(&mut seen, hit);
        assert_eq!(check(&scene, &seen).different, 1);
    }
}
