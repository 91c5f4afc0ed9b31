//! Specular reflection: statements of material libraries and keys of meshes.

mod common;

use common::Folder;
use glam::Vec3;
use halflight_core::scene::{Scene, Specular};
use halflight_scene::{Loaded, SceneError};

const OBJ: &str =
    "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl physical\nf 1 2 3\nusemtl phong\nf 3 2 1\n";

const MTL: &str =
    "newmtl physical\nKd 0.5\nPr 0.3\nPm 1\n\nnewmtl phong\nKd 0.4\nKs 0.2 0.1 0.3\nNs 30\nillum 2\n";

fn load(name: &str, mtl: &str, keys: &str) -> Result<Loaded, SceneError> {
    let folder = Folder::new(name);
    folder.write("a.mtl", mtl);
    folder.write("a.obj", OBJ);
    let text = format!(
        "[camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\nfov_y_deg = 45\n\
         [[light]]\ncorner = [0, 2, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [1, 1, 1]\n\
         [[mesh]]\nfile = \"a.obj\"\n{keys}\n"
    );
    folder.write("scene.toml", text);
    halflight_scene::load(&folder.0.join("scene.toml"))
}

fn of(scene: &Scene, triangle: usize) -> Option<Specular> {
    scene.mesh.materials[scene.mesh.material_ids[triangle] as usize].specular
}

#[test]
fn libraries_give_roughness_and_metallicity() {
    let loaded = load("physical", MTL, "").unwrap();
    let metal = Specular { roughness: 0.3, metallic: 1.0, ..Specular::default() };
    assert_eq!((of(&loaded.scene, 0), of(&loaded.scene, 1)), (Some(metal), None));
    assert!(loaded.report.warnings.is_empty(), "{:?}", loaded.report.warnings);
}

#[test]
fn exponents_are_read_where_asked() {
    let loaded = load("phong", MTL, "specular = \"phong\"").unwrap();
    let phong = of(&loaded.scene, 1).unwrap();
    // α² = 2 / 32 = 1/16, whose fourth root is the roughness.
    assert!((phong.roughness - 0.5).abs() < 1e-6, "{phong:?}");
    assert_eq!((phong.metallic, phong.reflectance), (0.0, Vec3::new(0.2, 0.1, 0.3)));
    assert!(of(&loaded.scene, 0).is_some());
    // Without a highlight there is none.
    for (from, to) in [("illum 2", "illum 1"), ("Ks 0.2 0.1 0.3", "Ks 0 0 0")] {
        let loaded = load("matte", &MTL.replace(from, to), "specular = \"phong\"").unwrap();
        assert_eq!(of(&loaded.scene, 1), None, "{to}");
    }
}

#[test]
fn keys_replace_what_the_library_gives() {
    let off = load("off", MTL, "specular = \"off\"").unwrap();
    assert!(!off.scene.mesh.is_glossy());
    let keys = load("keys", MTL, "roughness = 0.7\nreflectance = [0.1, 0.2, 0.3]").unwrap();
    let expected = Specular { roughness: 0.7, metallic: 1.0, reflectance: Vec3::new(0.1, 0.2, 0.3) };
    assert_eq!(of(&keys.scene, 0), Some(expected));
    assert_eq!(of(&keys.scene, 1), Some(Specular { metallic: 0.0, ..expected }));
    let plain = load("plain", MTL, "albedo = [0.5, 0.5, 0.5]").unwrap();
    assert!(!plain.scene.mesh.is_glossy());
}

#[test]
fn bad_values_name_their_line() {
    for (keys, message) in [
        ("roughness = -0.1", "roughness is -0.1, expected a number from 0 to 1"),
        ("metallic = 1.5", "metallic is 1.5, expected a number from 0 to 1"),
        ("reflectance = [0, 2, 0]", "reflectance is [0, 2, 0], expected numbers from 0 to 1"),
        ("specular = \"on\"", "specular is \"on\", expected \"auto\", \"phong\" or \"off\""),
        ("specular = \"off\"\nroughness = 0.5", "keep one of them"),
    ] {
        let error = load("bad", MTL, keys).unwrap_err().to_string();
        let line = if keys.contains('\n') { "scene.toml:10:" } else { "scene.toml:12:" };
        assert!(error.contains(message) && error.contains(line), "{error}");
    }
    let clamped = load("clamped", &MTL.replace("Pr 0.3", "Pr 1.3"), "").unwrap();
    assert_eq!(of(&clamped.scene, 0).unwrap().roughness, 1.0);
    let expected = "a.mtl:3: `Pr 1.3`, expected a number from 0 to 1; 1 is used";
    assert!(clamped.report.warnings[0].ends_with(expected), "{:?}", clamped.report.warnings);
    let faulty = load("faulty", &MTL.replace("Pr 0.3", "Pr rough"), "").unwrap();
    assert!(faulty.report.warnings[0].contains("a.mtl:3: `pr rough`"), "{:?}", faulty.report.warnings);
}

#[test]
fn unfit_values_of_libraries_name_their_line() {
    // Change of the library, keys, and the end of the only warning; none where the value is not used.
    for (from, to, keys, expected) in [
        ("Pm 1", "Pm -0.5", "", "a.mtl:4: `Pm -0.5`, expected a number from 0 to 1; 0 is used"),
        ("Pm 1", "Pm nan", "", "a.mtl:4: `pm nan`, expected a finite number; the line is left out"),
        (
            "Pr 0.3",
            "Ks 2 0.5 -1\nPr 0.3",
            "",
            "a.mtl:3: `Ks 2 0.5 -1`, expected numbers from 0 to 1; 1 0.5 0 is used",
        ),
        (
            "Pr 0.3",
            "Ks shiny\nPr 0.3",
            "",
            "a.mtl:3: `Ks shiny`, expected one or three finite numbers; the line is left out",
        ),
        ("Ns 30", "Ns -3", "", ""),
        ("Ns 30", "Ns -3", "specular = \"phong\"", "a.mtl:9: `Ns -3`, expected a number from 0; 0 is used"),
        ("Ns 30", "Ns inf", "", ""),
        (
            "Ns 30",
            "Ns inf",
            "specular = \"phong\"",
            "a.mtl:9: `Ns inf`, expected a finite number; the line is left out",
        ),
        ("Ks 0.2 0.1 0.3", "Ks 0.2 1.5 0.3", "", ""),
        (
            "Ks 0.2 0.1 0.3",
            "Ks 0.2 1.5 0.3",
            "specular = \"phong\"",
            "a.mtl:8: `Ks 0.2 1.5 0.3`, expected numbers from 0 to 1; 0.2 1 0.3 is used",
        ),
        (
            "Ks 0.2 0.1 0.3",
            "Ks",
            "specular = \"phong\"",
            "a.mtl:8: `Ks `, expected one or three finite numbers; the line is left out",
        ),
        ("illum 2", "illum 1\nNs -3", "specular = \"phong\"", ""),
    ] {
        let warnings = load("unfit", &MTL.replace(from, to), keys).unwrap().report.warnings;
        let right = match warnings.as_slice() {
            [] => expected.is_empty(),
            [warning] => !expected.is_empty() && warning.ends_with(expected),
            _ => false,
        };
        assert!(right, "{to} {keys}: {warnings:?}");
    }
}
