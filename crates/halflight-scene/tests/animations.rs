//! Animated objects, and their poses.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "helpers of tests")]

mod common;

use std::sync::Arc;

use common::Folder;
use glam::Vec3;
use halflight_core::scene::Scene;
use halflight_scene::{Loaded, bundled, load_bundled};

const SCENE: &str = "\
[camera]
eye = [0, 1, 5]
target = [0, 0, 0]
fov_y_deg = 40

[[light]]
corner = [0, 3, 0]
edge_u = [2, 0, 0]
edge_v = [0, 0, 2]
radiance = [1, 1, 1]

[[light]]
corner = [5, 3, 0]
edge_u = [2, 0, 0]
edge_v = [0, 0, 2]
radiance = [1, 1, 1]

[[mesh]]
generator = \"open-floor\"

[[mesh]]
file = \"post.obj\"

[animation.camera]
keys = [{ time = 2, eye = [4, 1, 5], fov_y_deg = 50 }, { time = 3, target = [0, 1, 0] }]

[[animation.light]]
light = 1
keys = [{ time = 1, rotate_deg = 90 }, { time = 2, translate = [0, 0, 8] }]

[[animation.mesh]]
mesh = 1
axis = [0, 0, -2]
pivot = [1, 0, 0]
keys = [{ time = 4, rotate_deg = 360, translate = [0, 4, 0] }]
";

/// A post 4 m high in the plane z = 0, of two quads.
const POST: &str = "\
v 1 0 0\nv 1.2 0 0\nv 1 4 0\nv 1.2 4 0\nv 1 2 0\nv 1.2 2 0\nvn 0 0 1\n\
f 1//1 2//1 6//1 5//1\nf 5//1 6//1 4//1 3//1\n";

fn load(test: &str, text: &str) -> Loaded {
    let folder = Folder::new(test);
    folder.write("post.obj", POST);
    folder.load_text(text).unwrap()
}

fn at(loaded: &Loaded, time: f32) -> Scene {
    loaded.animation.as_ref().unwrap().at(&loaded.scene, time)
}

/// State of everything that moves, bit for bit.
fn moving(scene: &Scene) -> (Vec<u32>, String) {
    let vectors = scene.mesh.positions.iter().chain(&scene.mesh.normals);
    let bits = vectors.flat_map(|v| v.to_array().map(f32::to_bits)).collect();
    (bits, format!("{:?} {:?}", scene.camera, scene.lights))
}

/// Coordinates of a few metres, rounded a few times.
const NEAR: f32 = 4e-6;

#[test]
fn cameras_go_from_key_to_key() {
    let loaded = load("animated_camera", SCENE);
    let camera = at(&loaded, 1.0).camera;
    assert_eq!((camera.eye, camera.target, camera.fov_y_deg), (Vec3::new(2.0, 1.0, 5.0), Vec3::ZERO, 45.0));
    // Values that a key omits are those of the key before.
    let camera = at(&loaded, 2.5).camera;
    assert_eq!(
        (camera.eye, camera.target, camera.fov_y_deg),
        (Vec3::new(4.0, 1.0, 5.0), Vec3::Y * 0.5, 50.0)
    );
    assert_eq!(at(&loaded, 99.0).camera, at(&loaded, 3.0).camera);
    assert_eq!(loaded.animation.as_ref().unwrap().last_key(), 4.0);
}

#[test]
fn lights_turn_about_their_middles() {
    let loaded = load("animated_light", SCENE);
    let light = at(&loaded, 1.0).lights[1].frame();
    // A quarter about y takes x to -z and z to x.
    for (found, expected) in [
        (light.u, Vec3::NEG_Z * 2.0),
        (light.v, Vec3::X * 2.0),
        (light.origin, Vec3::new(5.0, 3.0, 2.0)),
        (at(&loaded, 1.5).lights[1].frame().origin, Vec3::new(5.0, 3.0, 6.0)),
    ] {
        assert!(found.abs_diff_eq(expected, NEAR), "{found} {expected}");
    }
    assert_eq!(at(&loaded, 1.0).lights[0], loaded.scene.lights[0]);
}

#[test]
fn spheres_move_and_keep_their_radius() {
    let corner = "corner = [5, 3, 0]\nedge_u = [2, 0, 0]\nedge_v = [0, 0, 2]";
    let text = SCENE.replace(corner, "shape = \"sphere\"\ncentre = [5, 3, 0]\nradius = 0.5");
    let loaded = load("animated_sphere", &text);
    for (time, centre) in
        [(1.0, Vec3::new(5.0, 3.0, 0.0)), (1.5, Vec3::new(5.0, 3.0, 4.0)), (9.0, Vec3::new(5.0, 3.0, 8.0))]
    {
        let sphere = *at(&loaded, time).lights[1].as_sphere().unwrap();
        assert!(sphere.centre.abs_diff_eq(centre, NEAR), "{time} {sphere:?}");
        assert!((sphere.radius - 0.5).abs() < NEAR, "{time} {sphere:?}");
    }
}

#[test]
fn meshes_turn_about_their_axis_and_others_stay() {
    let loaded = load("animated_mesh", SCENE);
    let (still, moved) = (&loaded.scene.mesh, at(&loaded, 1.0).mesh);
    let floor = loaded.report.meshes[0].triangles;
    assert!((0..floor).all(|triangle| still.corners(triangle) == moved.corners(triangle)));
    // A quarter turn about -z through (1, 0, 0) maps up to +x; 1 m of it is translation.
    for triangle in floor..still.triangle_count() {
        for (from, to) in still.corners(triangle).into_iter().zip(moved.corners(triangle)) {
            let expected = Vec3::new(1.0 + from.y, 1.0 - (from.x - 1.0), 0.0);
            assert!(to.abs_diff_eq(expected, NEAR), "{from} {to} {expected}");
        }
    }
    assert_eq!((&still.triangles, &still.material_ids), (&moved.triangles, &moved.material_ids));
}

#[test]
fn swaying_bends_the_top_and_leaves_the_foot() {
    let sway = "[[animation.mesh]]\nmesh = 1\nsway = { amplitude = [0, 0, 0.5], period = 8, foot = 2 }\n";
    let text = format!("{}{sway}", SCENE.split("[animation.camera]").next().unwrap());
    let mut loaded = load("sway", &text);
    let flat = at(&loaded, 2.0).mesh;
    let still = Arc::make_mut(&mut loaded.scene.mesh);
    still.normals = vec![Vec3::Z; still.positions.len()];
    let moved = at(&loaded, 2.0).mesh;
    assert_eq!(flat.positions, moved.positions);
    let mut heights = 0;
    for (index, (from, to)) in loaded.scene.mesh.positions.iter().zip(&moved.positions).enumerate() {
        // A quarter of the period: the top is at full swing, 2 m above the foot.
        let share = ((from.y - 2.0) / 2.0).max(0.0);
        assert!(to.abs_diff_eq(*from + Vec3::Z * (0.5 * share * share), NEAR), "{from} {to}");
        if share > 0.0 {
            heights += 1;
            // The slope is 2 · 0.5 m over 2 m at the top: the wall leans by its arc tangent.
            let expected = Vec3::new(0.0, -0.5 * share, 1.0).normalize();
            assert!(moved.normals[index].abs_diff_eq(expected, NEAR), "{}", moved.normals[index]);
        } else {
            assert_eq!(moved.normals[index], loaded.scene.mesh.normals[index]);
        }
    }
    assert!(heights >= 2);
    // Half a period later it is on the other side, and then straight again.
    let side =
        |time: f32| at(&loaded, time).mesh.positions.iter().filter(|p| p.y > 0.0).map(|p| p.z).sum::<f32>();
    assert!(side(2.0) > 0.5 && side(6.0) < -0.5 && side(8.0).abs() < NEAR);
}

#[test]
fn at_time_0_a_scene_is_what_it_is_without_an_animation() {
    let loaded = load("still", SCENE);
    assert_eq!(moving(&at(&loaded, 0.0)), moving(&loaded.scene));
    assert_ne!(moving(&at(&loaded, 0.1)), moving(&loaded.scene));
    let mut moving_scenes = 0;
    for (name, text) in bundled() {
        let loaded = load_bundled(name).unwrap();
        let moves = text.contains("[animation") || text.contains("texture_frames");
        assert_eq!(loaded.animation.is_some(), moves, "{name}");
        if loaded.animation.is_some() {
            moving_scenes += 1;
            assert_eq!(moving(&at(&loaded, 0.0)), moving(&loaded.scene), "{name}");
            assert_ne!(moving(&at(&loaded, 1.0)), moving(&loaded.scene), "{name}");
        }
    }
    assert!(moving_scenes > 0);
}

#[test]
fn any_time_will_do() {
    let loaded = load("times", SCENE);
    let (first, last) = (moving(&at(&loaded, 0.0)), moving(&at(&loaded, 4.0)));
    // NaN counts as a time before the start.
    for (time, expected) in [
        (f32::NEG_INFINITY, &first),
        (-1.0, &first),
        (f32::NAN, &first),
        (f32::INFINITY, &last),
        (1e30, &last),
    ] {
        let scene = at(&loaded, time);
        scene.mesh.validate().unwrap();
        assert_eq!(moving(&scene), *expected, "{time}");
    }
}
