//! Lights of emissive faces.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "helpers of tests")]

mod common;

use common::{Folder, HEAD};
use glam::Vec3;
use halflight_core::light::{AreaLight, Shape};
use halflight_scene::Loaded;

/// Library of a lamp and a wall.
const LIBRARY: &str = "newmtl wall\nKd 0.5\nnewmtl lamp\nKd 0.8\nKe 3 2 1\n";

/// Radiance of the lamp.
const KE: Vec3 = Vec3::new(3.0, 2.0, 1.0);

/// Two triangles of a wall, which every mesh has.
const WALL: &str = "mtllib a.mtl\nv 0 0 9\nv 1 0 9\nv 1 1 9\nusemtl wall\nf 1 2 3\nusemtl lamp\n";

/// Loads a mesh of the wall and `faces`, whose vertices count from 4, with these keys.
fn load(name: &str, faces: &str, keys: &str) -> Result<Loaded, String> {
    let folder = Folder::new(&format!("emissive-{name}"));
    folder.write("a.mtl", LIBRARY).write("a.obj", format!("{WALL}{faces}"));
    folder.load(&format!("[[mesh]]\nfile = \"a.obj\"\n{keys}\n"))
}

/// Lights of emissive faces and warnings of a mesh that asks for them.
fn lights(name: &str, faces: &str) -> (Vec<AreaLight>, Vec<String>) {
    let loaded = load(name, faces, "emissive = \"lights\"").expect(name);
    let lights = loaded.scene.lights[1..].to_vec();
    assert_eq!(loaded.report.meshes[0].lights, lights.len(), "{name}");
    (lights, loaded.report.warnings)
}

/// Vertices of a polygon in the plane of height 2; its front is below where they run clockwise in x and z as seen from above.
fn vertices(points: &[[f32; 2]]) -> String {
    points.iter().map(|[x, z]| format!("v {x} 2 {z}\n")).collect()
}

const QUAD: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.0, 0.5]];

fn quad() -> AreaLight {
    AreaLight::parallelogram(Vec3::new(0.0, 2.0, 0.0), Vec3::X, Vec3::Z * 0.5, KE).visible()
}

#[test]
fn quads_are_parallelograms_however_they_are_divided() {
    let vertices = vertices(&QUAD);
    for (name, faces) in
        [("face", "f 4 5 6 7\n"), ("triangles", "f 4 5 6\nf 4 6 7\n"), ("far", "f 4 5 6\nf 6 7 4\n")]
    {
        let (lights, warnings) = lights(name, &format!("{vertices}{faces}"));
        assert_eq!((lights, warnings), (vec![quad()], vec![]), "{name}");
    }
    assert_eq!(quad().normal(), -Vec3::Y);
    // The other winding emits upwards.
    let (lights, _) = lights("back", &format!("{vertices}f 7 6 5 4\n"));
    assert_eq!(lights[0].normal(), Vec3::Y);
    assert_eq!(lights[0].area(), 0.5);
}

#[test]
fn a_grid_of_faces_is_one_light() {
    let mut text = String::new();
    for row in 0..=3 {
        for column in 0..=4 {
            text += &format!("v {} 2 {}\n", column as f32 * 0.25, row as f32 * 0.25);
        }
    }
    for row in 0..3 {
        for column in 0..4 {
            let first = 4 + row * 5 + column;
            text += &format!("f {} {} {} {}\n", first, first + 1, first + 6, first + 5);
        }
    }
    let (lights, _) = lights("grid", &text);
    let expected = AreaLight::parallelogram(Vec3::new(0.0, 2.0, 0.0), Vec3::X, Vec3::Z * 0.75, KE).visible();
    assert_eq!(lights, [expected]);
}

#[test]
fn emitters_are_connected_faces() {
    // Two quads apart, one that touches the first in a corner alone, and the five other sides of a box.
    let text = "v 0 2 0\nv 1 2 0\nv 1 2 1\nv 0 2 1\nv 3 2 0\nv 4 2 0\nv 4 2 1\nv 3 2 1\nv 2 2 1\nv 2 2 2\nv 1 2 2\n\
                f 4 5 6 7\nf 8 9 10 11\nf 6 12 13 14\n";
    let (found, warnings) = lights("apart", text);
    assert_eq!(warnings, [""; 0]);
    let corners: Vec<Vec3> = found.iter().map(|light| light.frame().origin).collect();
    assert_eq!(corners, [Vec3::new(0.0, 2.0, 0.0), Vec3::new(3.0, 2.0, 0.0), Vec3::new(1.0, 2.0, 1.0)]);
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                f 4 7 6 5\nf 8 9 10 11\nf 4 5 9 8\nf 6 7 11 10\nf 4 8 11 7\nf 5 6 10 9\n";
    let (found, _) = lights("box", text);
    assert_eq!(found.len(), 6);
    for light in found {
        // The front is outside.
        assert!(light.normal().dot(light.centre() - Vec3::splat(0.5)) > 0.4, "{light:?}");
    }
}

#[test]
fn convex_faces_are_polygons() {
    let hexagon: Vec<[f32; 2]> = (0..6)
        .map(|corner| (corner as f32 * std::f32::consts::FRAC_PI_3).sin_cos())
        .map(|(sine, cosine)| [cosine, sine])
        .collect();
    let (found, warnings) = lights("hexagon", &format!("{}f 4 5 6 7 8 9\n", vertices(&hexagon)));
    assert_eq!(warnings, [""; 0]);
    let corners: Vec<Vec3> = hexagon.iter().map(|&[x, z]| Vec3::new(x, 2.0, z)).collect();
    assert_eq!(found, [AreaLight::polygon(&corners, KE).unwrap().visible()]);
    assert_eq!(found[0].normal(), -Vec3::Y);
    // A fan around the middle has the same outline.
    let fan = "v 0 2 0\nf 10 4 5\nf 10 5 6\nf 10 6 7\nf 10 7 8\nf 10 8 9\nf 10 9 4\n";
    assert_eq!(lights("fan", &format!("{}{fan}", vertices(&hexagon))).0, found);
    let (triangle, _) = lights("triangle", &format!("{}f 4 5 6\n", vertices(&QUAD)));
    assert!(matches!(triangle[0].shape, Shape::Polygon(_)) && triangle[0].area() == 0.25);
}

#[test]
fn lights_follow_the_transform_of_their_mesh() {
    let faces = format!("{}f 4 5 6 7\n", vertices(&QUAD));
    let place = |name: &str, transform: &str| {
        let keys = format!("emissive = \"lights\"\ntransform = {{ {transform} }}");
        load(name, &faces, &keys).unwrap().scene.lights[1]
    };
    let scaled = place("scaled", "scale = [2, 1, 4], translate = [0, 1, 0]");
    assert_eq!(scaled, AreaLight::parallelogram(Vec3::Y * 3.0, Vec3::X * 2.0, Vec3::Z * 2.0, KE).visible());
    let turned = place("turned", "rotate_deg = [90, 0, 0]");
    // A quarter turn about x takes y to z and z to -y; cosines of 90 degrees are 6e-17.
    assert!(
        turned.normal().abs_diff_eq(-Vec3::Z, 1e-6)
            && turned.centre().abs_diff_eq(Vec3::new(0.5, -0.25, 2.0), 1e-6)
    );
    let mirrored = place("mirrored", "scale = [-1, 1, 1]");
    assert_eq!(mirrored.normal(), -Vec3::Y);
    assert!(mirrored.centre().abs_diff_eq(Vec3::new(-0.5, 2.0, 0.25), 1e-6));
    // Upside down: the front is above.
    assert_eq!(place("upturned", "scale = [1, -1, 1]").normal(), Vec3::Y);
}

#[test]
fn other_emitters_are_refused_by_name() {
    let l_shape = vertices(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]);
    let l_faces = "f 4 5 6 7\nf 4 7 8 9\n";
    let strip: String = (0..5)
        .map(|at| (at as f32 * 0.2).sin_cos())
        .map(|(s, c)| format!("v {s} {c} 0\nv {s} {c} 1\n"))
        .collect();
    let many: Vec<[f32; 2]> = (0..16)
        .map(|corner| (corner as f32 * std::f32::consts::TAU / 16.0).sin_cos())
        .map(|(sine, cosine)| [cosine, sine])
        .collect();
    let ring = vertices(&[
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [0.0, 3.0],
        [1.0, 1.0],
        [2.0, 1.0],
        [2.0, 2.0],
        [1.0, 2.0],
    ]);
    let ring_faces = "f 4 5 9 8\nf 5 6 10 9\nf 6 7 11 10\nf 7 4 8 11\n";
    let cases = [
        (
            "l-shape",
            format!("{l_shape}{l_faces}"),
            "the first, at [0, 2, 0], has an unfit outline (not convex at corner 3;",
        ),
        (
            "strip",
            format!("{strip}f 5 7 6 4\nf 7 9 8 6\nf 9 11 10 8\n"),
            "is not flat; give its flat parts materials of their own",
        ),
        (
            "16",
            format!("{}f 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19\n", vertices(&many)),
            "(16 corners, expected 3 to 12)",
        ),
        ("ring", format!("{ring}{ring_faces}"), "has a hole or touches itself"),
        (
            "twice",
            format!("{}f 4 5 6 7\nf 4 5 6 7\n", vertices(&QUAD)),
            "has faces that overlap; remove one of them",
        ),
    ];
    for (name, faces, expected) in cases {
        let error = load(name, &faces, "emissive = \"lights\"").map(|_| ()).unwrap_err();
        let start = "scene.toml:14: [[mesh]] emissive makes no light: a.mtl:5: 1 of 1 emitters of material `lamp` in `a.obj` cannot be lights: the first, at ";
        assert!(error.starts_with(start) && error.contains(expected), "{name}: {error}");
        // With another emitter that can be a light, it is a warning.
        let with = format!("{faces}v 0 5 0\nv 1 5 0\nv 1 5 1\nf -3 -2 -1\n");
        let (found, warnings) = lights(&format!("{name}-with"), &with);
        assert_eq!(found.len(), 1, "{name}");
        assert!(
            matches!(&warnings[..], [one] if one.starts_with("a.mtl:5: 1 of 2 emitters") && one.contains(expected)),
            "{warnings:?}"
        );
    }
}

#[test]
fn faults_name_file_and_line() {
    let faces = format!("{}f 4 5 6 7\n", vertices(&QUAD));
    let folder = Folder::new("emissive-faults");
    folder.write("a.obj", format!("{WALL}{faces}"));
    let error = |library: &str, keys: &str| {
        folder.write("a.mtl", library);
        folder.load(&format!("[[mesh]]\n{keys}\n")).map(|_| ()).unwrap_err()
    };
    let ask = "file = \"a.obj\"\nemissive = \"lights\"";
    let textured = LIBRARY.replace("Ke 3 2 1", "Ke 3 2 1\nmap_Ke a.png");
    for (library, keys, expected) in [
        (
            LIBRARY,
            "file = \"a.obj\"\nemissive = true",
            "scene.toml:14: [[mesh]] emissive is true, expected a text in quotes",
        ),
        (
            LIBRARY,
            "file = \"a.obj\"\nemissive = \"on\"",
            "scene.toml:14: [[mesh]] emissive is \"on\", expected \"lights\" or \"ignore\"",
        ),
        (
            LIBRARY,
            "generator = \"contact\"\nemissive = \"lights\"",
            "scene.toml:14: [[mesh]] emissive is for the materials of a file",
        ),
        (
            &LIBRARY.replace("Ke 3 2 1", "Ke 0 0 0"),
            ask,
            "scene.toml:14: [[mesh]] emissive makes no light: no face of `a.obj` has a material with Ke above 0",
        ),
        (
            &textured,
            ask,
            "a.mtl:6: 1 of 1 emitters of material `lamp` in `a.obj` cannot be lights: the first, at [0, 2, 0], emits a texture (map_Ke)",
        ),
    ] {
        let error = error(library, keys);
        assert!(error.contains(expected), "{keys}: {error}");
    }
    // One quad more than there may be lights.
    let mut many = String::from(WALL);
    for quad in 0..65 {
        many += &format!("v {quad} 0 0\nv {quad}.5 0 0\nv {quad}.5 0 1\nv {quad} 0 1\nf -4 -3 -2 -1\n");
    }
    folder.write("a.obj", many);
    let error = error(LIBRARY, ask);
    assert!(
        error.starts_with(
            "scene.toml:14: [[mesh]] emissive makes 65 lights so far, expected at most 64; write"
        ),
        "{error}"
    );
    // Bad statements cost themselves.
    folder.write("a.obj", format!("{WALL}{faces}"));
    folder.write("a.mtl", LIBRARY.replace("Ke 3 2 1", "Ke 3 2 1\nKe -1 0 0"));
    let loaded = folder.load(&format!("[[mesh]]\n{ask}\n")).unwrap();
    let warning = "a.mtl:6: `Ke -1 0 0`, expected one or three finite numbers from 0; the line is left out";
    assert_eq!((loaded.scene.lights[1], loaded.report.warnings), (quad(), vec![warning.to_string()]));
}

#[test]
fn scenes_that_do_not_ask_are_as_before() {
    let faces = format!("{}f 4 5 6 7\n", vertices(&QUAD));
    let unsaid = load("unsaid", &faces, "").unwrap();
    let warning = "a.mtl: emission (Ke) is not used; write emissive = \"lights\" or \"ignore\" in the [[mesh]], or add a [[light]]";
    assert_eq!((unsaid.scene.lights.len(), unsaid.report.warnings), (1, vec![warning.to_string()]));
    let ignored = load("ignored", &faces, "emissive = \"ignore\"").unwrap();
    assert_eq!((ignored.scene.lights.len(), ignored.report.warnings.len()), (1, 0));
    // The mesh of a scene that asks is the same, under a colour of the scene file as well.
    for keys in ["emissive = \"lights\"", "emissive = \"lights\"\nalbedo = [0.1, 0.2, 0.3]"] {
        let asked = load("asked", &faces, keys).unwrap();
        assert_eq!(asked.scene.lights.len(), 2);
        assert_eq!(asked.scene.mesh.positions, ignored.scene.mesh.positions);
        assert_eq!(asked.scene.mesh.triangles, ignored.scene.mesh.triangles);
    }
}

#[test]
fn scenes_may_have_emissive_faces_alone() {
    let folder = Folder::new("emissive-alone");
    let camera = &HEAD[..HEAD.find("[[light]]").unwrap()];
    folder.write("a.mtl", LIBRARY).write("a.obj", format!("{WALL}{}f 4 5 6 7\n", vertices(&QUAD)));
    let mesh = "[[mesh]]\nfile = \"a.obj\"\nemissive = \"lights\"\n";
    assert_eq!(folder.load_text(&format!("{camera}{mesh}")).unwrap().scene.lights, [quad()]);
    let error =
        folder.load_text(&format!("{camera}{}", mesh.replace("lights", "ignore"))).map(|_| ()).unwrap_err();
    assert!(error.contains("has no [[light]]"), "{error}");
}

#[test]
fn lights_move_with_their_mesh() {
    let faces = format!("{}f 4 5 6 7\n", vertices(&QUAD));
    let keys = "emissive = \"lights\"\n[[animation.mesh]]\nkeys = [{ time = 1, translate = [0, 0, 2] }]";
    let loaded = load("moves", &faces, keys).unwrap();
    let moved = loaded.animation.unwrap().at(&loaded.scene, 1.0);
    assert_eq!(moved.lights, [loaded.scene.lights[0], quad().moved(Vec3::Z * 2.0)]);
    assert_eq!(moved.mesh.positions[3], loaded.scene.mesh.positions[3] + Vec3::Z * 2.0);
    let sways = "emissive = \"lights\"\n[[animation.mesh]]\nsway = { amplitude = [0.5, 0, 0], period = 4 }";
    let error = load("sways", &faces, sways).map(|_| ()).unwrap_err();
    assert!(error.contains("scene.toml:16: sway bends a mesh with emissive"), "{error}");
}

#[test]
fn lights_lie_before_faces_that_are_flat_within_their_digits() {
    // A tilted panel of 9 points of 4 m, its middle 3e-4 m before the plane of the others.
    let mut text = String::new();
    for row in 0..3 {
        for column in 0..3 {
            let (x, y, z) = (column as f32 * 2.0, 0.3 * column as f32 + 0.7 * row as f32, row as f32 * 2.0);
            let off = if (row, column) == (1, 1) { 3e-4 } else { 0.0 };
            text += &format!("v {x} {} {z}\n", y - off);
        }
    }
    for row in 0..2 {
        for column in 0..2 {
            let first = 4 + row * 3 + column;
            text += &format!("f {} {} {} {}\n", first, first + 1, first + 4, first + 3);
        }
    }
    let loaded = load("digits", &text, "emissive = \"lights\"").unwrap();
    let light = loaded.scene.lights[1];
    assert!(matches!(light.shape, Shape::Parallelogram(_)));
    let heights: Vec<f32> = (3..12)
        .map(|vertex| (loaded.scene.mesh.positions[vertex] - light.frame().origin).dot(light.normal()))
        .collect();
    // Rounding of coordinates of 4 m is 2.4e-7.
    assert!(heights.iter().all(|&height| height < 1e-6), "{heights:?}");
    assert!(heights.iter().any(|&height| height > -4e-4 && height < -2e-4), "{heights:?}");
}
