//! Alpha masks of materials: which image, which texels, and what is said of bad ones.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

mod common;

use common::Folder;
use glam::{DVec2, Vec2};
use halflight_core::scene::Mesh;
use image::{GrayImage, Luma, Rgba, RgbaImage};

const TRIANGLE: &str =
    "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl leaf\nf 1/1 2/2 3/3\n";

/// Images of 4 x 1 texels: grey, opaque colour with alpha, and an alpha of 255 everywhere.
fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("a.obj", TRIANGLE);
    let steps = [0, 127, 128, 255];
    let grey = GrayImage::from_fn(4, 1, |x, _| Luma([steps[x as usize]]));
    grey.save(folder.0.join("grey.png")).unwrap();
    let leaf = RgbaImage::from_fn(4, 1, |x, _| Rgba([200, 90, 20, steps[3 - x as usize]]));
    leaf.save(folder.0.join("leaf.png")).unwrap();
    // Luminance of pure green is 182, that of pure blue 18.
    let colours = [[0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255], [0, 0, 0, 255]];
    let opaque = RgbaImage::from_fn(4, 1, |x, _| Rgba(colours[x as usize]));
    opaque.save(folder.0.join("opaque.png")).unwrap();
    folder
}

/// Solid texels of the material's mask, from left to right; none without a mask.
fn solid(mesh: &Mesh, triangle: usize) -> Option<[bool; 4]> {
    let mask = mesh.alpha_mask(triangle)?;
    Some([0.0, 1.0, 2.0, 3.0].map(|column| mask.is_solid(DVec2::new((column + 0.5) / 4.0, 0.5))))
}

/// Mask of the material `library` under the keys of a `[[mesh]]`, and the warnings.
fn load(folder: &Folder, library: &str, keys: &str) -> (Option<[bool; 4]>, Vec<String>) {
    folder.write("a.mtl", format!("newmtl leaf\n{library}"));
    let loaded = folder.load(&format!("[[mesh]]\nfile = \"a.obj\"\n{keys}")).unwrap();
    (solid(&loaded.scene.mesh, 0), loaded.report.warnings)
}

#[test]
fn masks_come_from_alpha_or_luminance() {
    let folder = folder("alpha_images");
    let cases = [
        ("map_d grey.png\n", "", Some([false, false, true, true])),
        ("map_d grey.png\n", "alpha_cutoff = 0.498\n", Some([false, true, true, true])),
        ("map_d grey.png\n", "alpha = \"map_d\"\nalpha_cutoff = 1\n", Some([false, false, false, true])),
        // A mask without a hole is none.
        ("map_d grey.png\n", "alpha_cutoff = 0\n", None),
        ("map_d grey.png\n", "alpha = \"none\"\n", None),
        ("map_d leaf.png\n", "", Some([true, true, false, false])),
        ("map_Kd leaf.png\nmap_d leaf.png\n", "", Some([true, true, false, false])),
        ("map_d opaque.png\n", "", Some([true, false, true, false])),
        ("map_Kd leaf.png\n", "alpha = \"albedo\"\n", Some([true, true, false, false])),
        ("map_Kd leaf.png\n", "alpha = \"albedo\"\nalpha_cutoff = 0.9\n", Some([true, false, false, false])),
        ("map_Kd leaf.png\nmap_d grey.png\n", "alpha = \"albedo\"\n", Some([false, false, true, true])),
        // The alpha of an opaque texture is no mask.
        ("map_Kd opaque.png\n", "alpha = \"albedo\"\n", None),
        ("map_d grey.png\n", "albedo = [1, 1, 1]\n", None),
        ("Kd 1 1 1\n", "", None),
    ];
    for (library, keys, expected) in cases {
        let found = load(&folder, library, keys);
        assert_eq!(found, (expected, vec![]), "{library} {keys}");
    }
    // A texture with holes that are not asked for is reported, unless alpha is refused.
    let (mask, warnings) = load(&folder, "map_Kd leaf.png\n", "");
    let warning = "texture leaf.png is transparent in places; it is taken as opaque: alpha = \"albedo\" makes it a mask";
    assert_eq!((mask, warnings), (None, vec![warning.to_string()]));
    assert_eq!(load(&folder, "map_Kd leaf.png\n", "alpha = \"none\"\n"), (None, vec![]));
}

#[test]
fn meshes_of_one_file_choose_for_themselves() {
    let folder = folder("alpha_choices");
    folder.write("a.mtl", "newmtl leaf\nmap_d grey.png\n");
    let mesh = "[[mesh]]\nfile = \"a.obj\"\n";
    let loaded =
        folder.load(&format!("{mesh}{mesh}alpha_cutoff = 0.9\n{mesh}alpha = \"none\"\n{mesh}")).unwrap();
    let mesh = &loaded.scene.mesh;
    let found: Vec<_> = (0..4).map(|triangle| solid(mesh, triangle)).collect();
    let (half, high) = ([false, false, true, true], [false, false, false, true]);
    assert_eq!(found, [Some(half), Some(high), None, Some(half)]);
    assert_eq!(mesh.alpha_masks.len(), 2);
    mesh.validate().unwrap();
}

#[test]
fn options_place_masks_and_bad_images_leave_all_opaque() {
    let folder = folder("alpha_faults");
    folder.write("broken.png", "not a picture");
    let cases = [
        ("map_d gone.png\n", "a.mtl:2: alpha mask `gone.png` is missing in .; all is opaque"),
        ("map_d\n", "a.mtl:2: map_d without a file; expected: map_d FILE; the line is left out"),
        ("map_Tr grey.png\n", "a.mtl: map_Tr is not supported, only alpha masks by map_d"),
    ];
    for (library, warning) in cases {
        assert_eq!(load(&folder, library, ""), (None, vec![warning.to_string()]), "{library}");
    }
    let (mask, warnings) = load(&folder, "map_d broken.png\n", "");
    assert!(mask.is_none() && warnings.len() == 1, "{warnings:?}");
    assert!(warnings[0].starts_with("a.mtl:2: alpha mask broken.png cannot be read ("), "{warnings:?}");

    let uv = |library: &str| {
        folder.write("a.mtl", format!("newmtl leaf\n{library}"));
        let loaded = folder.load("[[mesh]]\nfile = \"a.obj\"\n").unwrap();
        let mesh = &loaded.scene.mesh;
        assert!(mesh.alpha_mask(0).is_some());
        (mesh.uvs[mesh.triangles[0][1] as usize], loaded.report.warnings)
    };
    assert_eq!(uv("map_d -s 2 2 -o 0.5 0.25 grey.png\n"), (Vec2::new(2.5, 0.25), vec![]));
    let both = "map_Kd -s 3 3 opaque.png\nmap_d -s 3 3 grey.png\n";
    assert_eq!(uv(both), (Vec2::new(3.0, 0.0), vec![]));
    let warning = "a.mtl: map_d is placed as map_Kd is, not by its own -s and -o, first in material `leaf`";
    let differ = "map_Kd -s 3 3 opaque.png\nmap_d grey.png\n";
    assert_eq!(uv(differ), (Vec2::new(3.0, 0.0), vec![warning.to_string()]));
    let warning = "a.mtl: option -imfchan of map_d is not supported";
    assert_eq!(uv("map_d -imfchan l grey.png\n"), (Vec2::X, vec![warning.to_string()]));
}
