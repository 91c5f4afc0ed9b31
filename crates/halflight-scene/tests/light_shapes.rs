//! Shapes of lights, and their faults.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "helpers of tests")]

mod common;

use common::Folder;
use glam::Vec3;
use halflight_core::light::Shape;

/// Scene with a light of these keys, from line 6 on.
fn scene(keys: &str) -> String {
    let camera = "[camera]\neye = [0, 1, 5]\ntarget = [0, 0, 0]\nfov_y_deg = 45\n[[light]]\n";
    format!("{camera}{keys}\nradiance = [1, 1, 1]\n\n[[mesh]]\ngenerator = \"open-floor\"\n")
}

#[test]
fn shapes_are_read() {
    let folder = Folder::new("light-shapes");
    let light = |keys: &str| folder.load_text(&scene(keys)).unwrap().scene.lights[0];
    let disk = light("shape = \"disk\"\ncentre = [0, 3, 0]\nnormal = [0, -2, 0]\nradius = 0.5");
    assert!(matches!(disk.shape, Shape::Ellipse(_)) && disk.normal().abs_diff_eq(-Vec3::Y, 1e-6));
    assert!((disk.area() - std::f32::consts::FRAC_PI_4).abs() < 1e-6);
    let ellipse = light("shape = \"ellipse\"\ncentre = [0, 3, 0]\naxis_u = [0.5, 0, 0]\naxis_v = [0, 0, 2]");
    assert!((ellipse.area() - std::f32::consts::PI).abs() < 1e-5 && ellipse.normal() == -Vec3::Y);
    let triangle = light("shape = \"polygon\"\npoints = [[0, 3, 0], [1, 3, 0], [0, 3, 1]]\ntwo_sided = true");
    assert!((triangle.area() - 0.5).abs() < 1e-6 && triangle.normal().abs_diff_eq(-Vec3::Y, 1e-6));
    let sphere = light("shape = \"sphere\"\ncentre = [0, 3, 0]\nradius = 0.25\nvisible = true");
    assert_eq!(sphere.as_sphere().map(|sphere| (sphere.centre, sphere.radius)), Some((Vec3::Y * 3.0, 0.25)));
    assert!(sphere.visible);
    let plain = "corner = [0, 3, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]";
    assert_eq!(light(plain), light(&format!("shape = \"parallelogram\"\n{plain}")));
}

#[test]
fn faults_name_file_and_line() {
    let folder = Folder::new("light-shape-faults");
    for (keys, line, expected) in [
        ("shape = \"cube\"", 6, "shape is `cube`, expected parallelogram, disk, ellipse, polygon or sphere"),
        ("shape = \"sphere\"\ncentre = [0, 3, 0]", 5, "has no `radius`"),
        ("shape = \"sphere\"\nradius = 1", 5, "has no `centre`"),
        ("shape = \"sphere\"\ncentre = [0, 3, 0]\nradius = 0", 8, "radius is 0, expected metres above 0"),
        ("shape = \"sphere\"\ncentre = [0, 3, 0]\nradius = -1", 8, "radius is -1, expected metres above 0"),
        ("shape = \"sphere\"\ncentre = [0, 3, 0]\nradius = nan", 8, "radius"),
        ("shape = \"sphere\"\ncentre = [0, 3, 0]\nradius = inf", 8, "expected a finite number"),
        ("shape = \"sphere\"\ncentre = [0, 3, 0]\nradius = 2e8", 5, "from the origin"),
        ("shape = \"sphere\"\ncentre = [0, 3, 0]\nradius = 1\nnormal = [0, 1, 0]", 9, "unknown key `normal`"),
        ("shape = \"sphere\"\ntexture = \"screen.png\"", 7, "unknown key `texture`"),
        (
            "shape = \"sphere\"\ncentre = [0, 3, 0]\nradius = 1\ntwo_sided = true",
            9,
            "two_sided has no meaning for a sphere",
        ),
        ("shape = \"disk\"\ncorner = [0, 3, 0]", 7, "unknown key `corner`"),
        ("shape = \"disk\"\nnormal = [0, -1, 0]\nradius = 1", 5, "has no `centre`"),
        ("shape = \"disk\"\ncentre = [0, 3, 0]\nnormal = [0, 0, 0]\nradius = 1", 8, "normal is zero"),
        (
            "shape = \"disk\"\ncentre = [0, 3, 0]\nnormal = [0, -1, 0]\nradius = -1",
            9,
            "expected metres above 0",
        ),
        ("shape = \"ellipse\"\ncentre = [0, 3, 0]\naxis_u = [1, 0, 0]\naxis_v = [2, 0, 0]", 5, "has no area"),
        ("shape = \"polygon\"\npoints = [[0, 3, 0], [1, 3, 0]]", 7, "points: 2 corners, expected 3 to 12"),
        ("shape = \"polygon\"\npoints = [0, 3, 0]", 7, "expected a list of triples of finite numbers"),
        (
            "shape = \"polygon\"\npoints = [[0, 3, 0], [1, 3, 0], [2, 3, 0]]",
            7,
            "points: corners span no area",
        ),
        (
            "shape = \"polygon\"\npoints = [[0, 3, 0], [1, 3, 0], [1, 3, 1], [0, 3.2, 1]]",
            7,
            "lies off the plane of the others",
        ),
        (
            "shape = \"polygon\"\npoints = [[0, 3, 0], [2, 3, 0], [0.5, 3, 0.5], [0, 3, 2]]",
            7,
            "points: not convex at corner 2; divide it into convex lights",
        ),
        ("shape = \"disk\"\ntexture = \"screen.png\"", 7, "unknown key `texture`"),
    ] {
        let error = folder.load_text(&scene(keys)).map(|_| ()).unwrap_err();
        assert!(error.contains(expected) && error.contains(&format!(":{line}: ")), "{keys}: {error}");
    }
}
