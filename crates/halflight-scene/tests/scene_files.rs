//! Good scene files: cameras, lights, transforms, several meshes, bundled scenes.

mod common;

use common::{Folder, HEAD};
use glam::Vec3;
use halflight_core::light::AreaLight;
use halflight_core::scene::Camera;
use halflight_scene::{bundled, load_bundled, parse, resolve};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n";

#[test]
fn camera_and_lights_are_what_the_file_says() {
    let folder = Folder::new("camera");
    folder.write("sub/a.obj", TRIANGLE);
    let text = "description = \"x\"\n[camera]\neye = [1, 2.5, 3]\ntarget = [0, 0, -1e1]\nup = [0, 0, 1]\nfov_y_deg = 30.5\n\
                [[light]]\ncorner = [1, 2, 3]\nedge_u = [4, 0, 0]\nedge_v = [0, 5, 0]\nradiance = [0, 6, 7]\ntwo_sided = true\n\
                [[light]]\ncorner = [0, 0, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [1, 1, 1]\n\
                [[mesh]]\nfile = \"sub/a.obj\"\n";
    let scene = folder.load_text(text).unwrap().scene;
    let camera = Camera {
        eye: Vec3::new(1.0, 2.5, 3.0),
        target: Vec3::new(0.0, 0.0, -10.0),
        up: Vec3::Z,
        fov_y_deg: 30.5,
        ..Camera::default()
    };
    assert_eq!(scene.camera, camera);
    let (corner, radiance) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.0, 6.0, 7.0));
    let first = AreaLight::parallelogram(corner, Vec3::X * 4.0, Vec3::Y * 5.0, radiance).two_sided();
    assert_eq!((scene.lights.len(), scene.lights[0], scene.lights[1].two_sided), (2, first, false));
    // Loading by path, and from text with a folder.
    let path = folder.0.join("scene.toml");
    assert_eq!(resolve(path.to_str().unwrap()).unwrap().scene.camera, camera);
    assert_eq!(parse(text, "x", &folder.0).unwrap().scene.mesh.triangles, scene.mesh.triangles);
}

#[test]
fn transforms_scale_then_rotate_about_x_y_z_then_move() {
    let folder = Folder::new("transforms");
    folder.write("a.obj", TRIANGLE);
    // Images of the points (1, 0, 0) and (0, 1, 0) and of the normal (0, 0, 1).
    let cases = [
        ("translate = [1, 2, 3]", [2.0, 2.0, 3.0], [1.0, 3.0, 3.0], [0.0, 0.0, 1.0]),
        ("scale = 2", [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]),
        ("rotate_deg = [90, 0, 0]", [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]),
        ("rotate_deg = [0, 90, 0]", [0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]),
        ("rotate_deg = [0, 0, 90]", [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ("rotate_deg = [90, 90, 0]", [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]),
        ("rotate_deg = [90, 0, 90]", [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
        (
            "translate = [0, 0, 1], rotate_deg = [0, 90, 0], scale = [2, 3, 4]",
            [0.0, 0.0, -1.0],
            [0.0, 3.0, 1.0],
            [1.0, 0.0, 0.0],
        ),
    ];
    for (transform, x, y, normal) in cases {
        let mesh = format!("[[mesh]]\nfile = \"a.obj\"\ntransform = {{ {transform} }}\n");
        let mesh = folder.load(&mesh).unwrap().scene.mesh;
        let [a, b, c] = mesh.corners(0);
        let found = [b, c, (b - a).cross(c - a).normalize()];
        for (found, expected) in found.into_iter().zip([x, y, normal]) {
            // The sine and cosine of a right angle in double precision are off by 1e-16 only.
            assert!(found.abs_diff_eq(Vec3::from_array(expected), 1e-6), "{transform}: {found} {expected:?}");
        }
    }
}

#[test]
fn normals_stay_upright_under_uneven_scales_and_mirrors() {
    let folder = Folder::new("normal_matrix");
    // A slope in the direction (1, 1, 1), with a normal of nearly this direction.
    folder.write("a.obj", "v 1 0 0\nv 0 1 0\nv 0 0 1\nvn 1 1 1.01\nf 1//1 2//1 3//1\n");
    for scale in ["[1, 2, 5]", "[-1, 2, 5]", "[-1, -2, 5]", "[-1, -2, -5]", "-3"] {
        let mesh = format!(
            "[[mesh]]\nfile = \"a.obj\"\ntransform = {{ rotate_deg = [10, 20, 30], scale = {scale} }}\n"
        );
        let mesh = folder.load(&mesh).unwrap().scene.mesh;
        let [a, b, c] = mesh.corners(0);
        let face = (b - a).cross(c - a).normalize();
        // The triangle still faces where its normal does, but for what the normal is off.
        assert!(
            mesh.normals.iter().all(|normal| normal.abs_diff_eq(face, 0.03)),
            "{scale}: {face} {:?}",
            mesh.normals
        );
    }
    // The outside stays outside: away from the origin, which a mirror at the origin does not move.
    let mesh =
        folder.load("[[mesh]]\nfile = \"a.obj\"\ntransform = { scale = [-1, 1, 1] }\n").unwrap().scene.mesh;
    assert!(mesh.normals[0].dot(mesh.positions[0]) > 0.0);
}

#[test]
fn several_meshes_become_one() {
    let folder = Folder::new("merge");
    folder.write("a.obj", TRIANGLE);
    let text = "[[mesh]]\nfile = \"a.obj\"\nalbedo = [1, 0, 0]\n\
                [[mesh]]\ngenerator = \"open-floor\"\nalbedo = [0, 1, 0]\n\
                [[mesh]]\nfile = \"a.obj\"\nalbedo = [0, 0, 1]\ntransform = { translate = [0, 7, 0] }\n";
    let loaded = folder.load(text).unwrap();
    let mesh = &loaded.scene.mesh;
    mesh.validate().unwrap();
    let counts: Vec<usize> = loaded.report.meshes.iter().map(|mesh| mesh.triangles).collect();
    let sources: Vec<&str> = loaded.report.meshes.iter().map(|mesh| mesh.source.as_str()).collect();
    assert_eq!(sources, ["a.obj", "open-floor", "a.obj"]);
    assert_eq!((counts[0], counts[2], counts.iter().sum::<usize>()), (1, 1, mesh.triangle_count()));
    assert!(counts[1] > 0);
    let last = mesh.triangle_count() - 1;
    assert_eq!(mesh.corners(0)[0], Vec3::ZERO);
    assert_eq!(mesh.corners(last)[0], Vec3::Y * 7.0);
    let albedo = |triangle: usize| mesh.materials[mesh.material_ids[triangle] as usize].albedo;
    assert_eq!([albedo(0), albedo(1), albedo(last)], [Vec3::X, Vec3::Y, Vec3::Z]);
}

#[test]
fn every_bundled_scene_loads_cleanly() {
    for (name, _) in bundled() {
        let loaded = load_bundled(name).unwrap_or_else(|fault| panic!("{fault}"));
        assert!(loaded.report.warnings.is_empty(), "{name}: {:?}", loaded.report.warnings);
        assert_eq!(loaded.report.zero_area_dropped(), 0, "{name}");
    }
}

#[test]
fn windows_line_ends_and_comments_do_no_harm() {
    let folder = Folder::new("crlf");
    folder.write("a.obj", TRIANGLE.replace('\n', "\r\n"));
    let text = format!("# a scene\n{HEAD}[[mesh]]\nfile = \"a.obj\" # the mesh\n").replace('\n', "\r\n");
    assert_eq!(folder.load_text(&text).unwrap().report.triangles(), 1);
}
