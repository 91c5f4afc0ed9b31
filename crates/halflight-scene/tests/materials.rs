//! Materials and textures.

mod common;

use common::Folder;
use glam::Vec3;
use halflight_core::scene::Material;
use image::{Rgb, RgbImage};

const TRIANGLE: &str =
    "mtllib Lib.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl first one\nf 1 2 3\nusemtl second\nf 3 2 1\n";

#[allow(clippy::unwrap_used, reason = "a helper of tests")]
fn png(folder: &Folder, name: &str, pixels: [[u8; 3]; 2]) {
    folder.write(name, []);
    let mut image = RgbImage::new(1, 2);
    pixels.iter().zip(0..).for_each(|(&pixel, y)| image.put_pixel(0, y, Rgb(pixel)));
    image.save(folder.0.join(name)).unwrap();
}

#[test]
fn colours_and_textures_arrive_linear() {
    let folder = Folder::new("colours");
    png(&folder, "Wall.png", [[0, 128, 255], [10, 11, 188]]);
    folder.write(
        "Lib.mtl",
        "newmtl first one\nKd 0.1 0.2 0.3\nKs 1 1\nmap_Kd Wall.png\n\nnewmtl second\n  Kd 0.5\n",
    );
    let loaded = folder.load_mesh("a.obj", TRIANGLE).unwrap();
    let mesh = loaded.scene.mesh;
    let of = |triangle: usize| &mesh.materials[mesh.material_ids[triangle] as usize];
    assert_eq!(
        *of(0),
        Material { albedo: Vec3::new(0.1, 0.2, 0.3), texture: Some(0), ..Material::default() }
    );
    assert_eq!(*of(1), Material { albedo: Vec3::splat(0.5), ..Material::default() });
    let texture = &mesh.textures[0];
    assert_eq!((texture.width, texture.height), (1, 2));
    // IEC 61966-2-1 by hand, to seven digits; 10 lies on the linear foot of the curve, 11 just above it.
    let expected = [[0.0, 0.215_860_5, 1.0], [0.003_035_27, 0.003_346_54, 0.502_886_5]];
    for (texel, expected) in (0..2).map(|index| texture.linear(index)).zip(expected) {
        assert!(texel.abs_diff_eq(Vec3::from_array(expected), 1e-6), "{texel} {expected:?}");
    }
    assert!(loaded.report.warnings.is_empty(), "{:?}", loaded.report.warnings);
}

#[test]
fn textures_are_found_whatever_their_case_and_folder() {
    for (place, name) in [
        ("wall.png", "WALL.PNG"),
        ("Maps/wall.PNG", "maps/Wall.png"),
        ("Maps/wall.png", "maps\\WALL.png"),
        ("textures/wall.png", "C:\\old machine\\Wall.png"),
        ("Textures/wall.png", "Wall.png"),
        ("two words.png", "-s 1 1 1 -bm 0.5 Two Words.png"),
    ] {
        let folder = Folder::new("case");
        png(&folder, place, [[255; 3]; 2]);
        folder.write("LIB.MTL", format!("newmtl first one\nmap_Kd {name}\nnewmtl second\nmap_Kd {name}\n"));
        let loaded = folder.load_mesh("a.obj", TRIANGLE).unwrap();
        assert!(loaded.report.warnings.is_empty(), "{place}: {:?}", loaded.report.warnings);
        // One file, one texture; without a Kd it is shown as it is.
        assert_eq!(loaded.scene.mesh.textures.len(), 1, "{place}");
        let white = Material { albedo: Vec3::ONE, texture: Some(0), ..Material::default() };
        assert_eq!(loaded.scene.mesh.materials[..2], [white.clone(), white], "{place}");
    }
}

#[test]
fn missing_and_broken_textures_fall_back_to_the_colour_and_are_said_once() {
    let folder = Folder::new("no_texture");
    folder.write("broken.png", "not a picture");
    folder.write(
        "Lib.mtl",
        "newmtl first one\nKd 0.1 0.2 0.3\nmap_Kd gone.png\nnewmtl second\nKd 1 0 0\nmap_Kd broken.png\n",
    );
    folder.write("a.obj", TRIANGLE);
    let loaded = folder.load(&"[[mesh]]\nfile = \"a.obj\"\n".repeat(2)).unwrap();
    let mesh = &loaded.scene.mesh;
    let expected =
        [Vec3::new(0.1, 0.2, 0.3), Vec3::X].map(|albedo| Material { albedo, ..Material::default() });
    let used: Vec<&Material> = mesh.material_ids.iter().map(|&id| &mesh.materials[id as usize]).collect();
    assert_eq!(used, [&expected[0], &expected[1], &expected[0], &expected[1]]);
    let [missing, broken] = loaded.report.warnings.as_slice() else { panic!("{:?}", loaded.report.warnings) };
    assert!(missing.starts_with("Lib.mtl:3: texture `gone.png` is missing in "), "{missing}");
    assert!(broken.starts_with("Lib.mtl:6: texture broken.png cannot be read ("), "{broken}");
}

#[test]
fn textures_of_several_meshes_are_shared_and_an_albedo_replaces_them() {
    let folder = Folder::new("albedo");
    png(&folder, "a.png", [[255; 3]; 2]);
    png(&folder, "b.png", [[0; 3]; 2]);
    folder.write(
        "Lib.mtl",
        "newmtl first one\nKd 1 1 1\nmap_Kd a.png\nnewmtl second\nKd 1 1 1\nmap_Kd b.png\n",
    );
    folder.write("a.obj", TRIANGLE);
    let mesh = "[[mesh]]\nfile = \"a.obj\"\n";
    let loaded = folder.load(&format!("{mesh}{mesh}albedo = [0.25, 0.5, 1]\n{mesh}")).unwrap();
    let mesh = loaded.scene.mesh;
    assert_eq!(mesh.textures.len(), 2);
    let textures = mesh.material_ids.iter().map(|&id| mesh.materials[id as usize].texture);
    assert_eq!(textures.collect::<Vec<_>>(), [Some(0), Some(1), None, None, Some(0), Some(1)]);
    let replaced = &mesh.materials[mesh.material_ids[2] as usize];
    assert_eq!(replaced.albedo, Vec3::new(0.25, 0.5, 1.0));
}
