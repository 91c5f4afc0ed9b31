//! Emissive faces of OBJ files as lights: their own triangles do not hide them, and they are those of a scene file.

use std::fs;
use std::path::{Path, PathBuf};

use halflight::glam::{DQuat, DVec3, EulerRot, Vec3};
use halflight::pipeline::Image;
use halflight_tests::Stage;

use crate::flush_lights::{methods, shares};

/// Floor, and a ceiling of 8 × 8 m that the lamp lies in; the lamp's faces follow.
const ROOM: &str = "mtllib room.mtl\nusemtl wall\n\
    v -4 0 -4\nv -4 0 4\nv 4 0 4\nv 4 0 -4\nf 1 2 3 4\nv -4 2.5 -4\nv 4 2.5 -4\nv 4 2.5 4\nv -4 2.5 4\nf 5 6 7 8\nusemtl lamp\n";

const LIBRARY: &str = "newmtl wall\nKd 0.5\nnewmtl lamp\nKd 0.8\nKe 10 10 10\n";

/// Two triangles of 1 × 1 m, which face down.
const SQUARE: &str = "v -0.5 2.5 -0.5\nv 0.5 2.5 -0.5\nv 0.5 2.5 0.5\nv -0.5 2.5 0.5\nf 9 10 11\nf 9 11 12\n";

/// Hexagon whose corners have three decimals.
const HEXAGON: &str = "v 0.6 2.5 0\nv 0.3 2.5 0.52\nv -0.3 2.5 0.52\nv -0.6 2.5 0\nv -0.3 2.5 -0.52\nv 0.3 2.5 -0.52\nf 9 10 11 12 13 14\n";

/// Folder of a test's own, with a room.
fn folder(name: &str, lamp: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("room.mtl"), LIBRARY).unwrap();
    fs::write(folder.join("room.obj"), format!("{ROOM}{lamp}")).unwrap();
    folder
}

/// Loads a scene with a camera at `eye` that looks at `target`.
fn stage(folder: &Path, [eye, target, up]: [DVec3; 3], keys: &str) -> Stage {
    let camera = format!("[camera]\neye = {eye}\ntarget = {target}\nup = {up}\nfov_y_deg = 40\n");
    let text = format!("{camera}[[mesh]]\nfile = \"room.obj\"\n{keys}");
    Stage::new(halflight::scene_file::parse(&text, "room.toml", folder).unwrap().scene).unwrap()
}

/// Camera in the room: eye, target, and the direction up.
const VIEW: [DVec3; 3] = [DVec3::new(0.0, 1.6, 3.6), DVec3::new(0.0, 0.0, 0.5), DVec3::Y];

#[test]
fn a_lamp_of_a_mesh_is_the_lamp_of_a_scene_file() {
    let folder = folder("emissive-by-hand", SQUARE);
    let light = "[[light]]\ncorner = [-0.5, 2.5, -0.5]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [10, 10, 10]\n";
    for (name, config) in methods() {
        let render = |keys: &str| -> Image { stage(&folder, VIEW, keys).render(&config).unwrap() };
        let found = render("emissive = \"lights\"\n");
        let written = render(&format!("emissive = \"ignore\"\n{light}"));
        assert_eq!(found.irradiance, written.irradiance, "{name}");
        assert!(found.irradiance.iter().filter(|e| e.x > 1.0).count() > 100, "{name}");
    }
}

#[test]
fn lamps_are_not_hidden_by_their_own_faces() {
    let places = [
        (DVec3::ZERO, 1.0, DVec3::ZERO),
        (DVec3::new(20.0, 40.0, -65.0), 0.37, DVec3::new(3.0, -1.0, 0.5)),
        (DVec3::new(100.0, -35.0, 10.0), 1.9, DVec3::new(-90.0, 30.0, 12.0)),
    ];
    for (name, lamp) in [("emissive-square", SQUARE), ("emissive-hexagon", HEXAGON)] {
        let folder = folder(name, lamp);
        for (degrees, scale, shift) in places {
            let [x, y, z] = degrees.to_array().map(f64::to_radians);
            let turn = DQuat::from_euler(EulerRot::ZYX, z, y, x);
            let view = [0, 1].map(|at| turn * VIEW[at] * scale + shift);
            let keys = format!(
                "emissive = \"lights\"\ntransform = {{ rotate_deg = {degrees}, scale = {scale}, translate = {shift} }}\n"
            );
            let stage = stage(&folder, [view[0], view[1], turn * DVec3::Y], &keys);
            assert_eq!(stage.scene.lights.len(), 1);
            for (method, config) in methods() {
                let (low, high) = shares(&stage, &config);
                // As for lamps in ceilings (`flush_lights`): single precision moves the light.
                assert!(low > 0.999 && high < 1.001, "{name}, {method}, {degrees}: {low} to {high}");
            }
        }
    }
}

#[test]
fn faces_that_are_flat_within_their_digits_do_not_hide_their_light() {
    // The middle of the lamp hangs 0.1 mm below its corners: 53 times the distance at which faces are flush.
    let bent = "v -0.5 2.5 -0.5\nv 0.5 2.5 -0.5\nv 0.5 2.5 0.5\nv -0.5 2.5 0.5\nv 0 2.4999 0\nf 9 10 13\nf 10 11 13\nf 11 12 13\nf 12 9 13\n";
    let stage = stage(&folder("emissive-bent", bent), VIEW, "emissive = \"lights\"\n");
    assert_eq!(stage.scene.lights[0].normal(), -Vec3::Y);
    for (name, config) in methods() {
        let (low, high) = shares(&stage, &config);
        // The bound of `lamps_are_not_hidden_by_their_own_faces`.
        assert!(low > 0.999 && high < 1.001, "{name}: {low} to {high}");
    }
}
