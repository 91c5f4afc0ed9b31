//! Images and faces that a careless export leaves: each gets one message that names file and line, or the right picture.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail their test")]

mod common;

use common::{Folder, HEAD};
use glam::Vec3;
use image::{ImageBuffer, Luma, Rgb, RgbImage};

const OBJ: &str =
    "mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n";

/// A folder with a triangle and images that cannot be read: without texels, cut off, empty, of a kind that is not read, and no image.
fn images(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("a.obj", OBJ);
    folder.write("zero.tga", [0; 18]);
    folder.write("empty.png", "");
    folder.write("text.png", "no image");
    // Of an animation of 4 × 2 texels, its head.
    folder.write("moving.gif", [b"GIF89a".as_slice(), &[4, 0, 2, 0, 0x80, 0, 0], &[0; 6]].concat());
    RgbImage::from_pixel(4, 2, Rgb([128, 64, 0])).save(folder.0.join("whole.png")).unwrap();
    let whole = std::fs::read(folder.0.join("whole.png")).unwrap();
    folder.write("cut.png", &whole[..whole.len() / 2]);
    let mut zero = whole;
    // Width and height, and the check sum of the head.
    zero[16..24].fill(0);
    zero[29..33].copy_from_slice(&[0xb4, 0xe9, 0xeb, 0x45]);
    folder.write("zero.png", zero);
    folder
}

const UNREADABLE: [&str; 6] = ["zero.tga", "zero.png", "empty.png", "text.png", "moving.gif", "cut.png"];

#[test]
fn unreadable_images_of_materials_cost_themselves_and_name_the_line() {
    let folder = images("unreadable_materials");
    for (keyword, kind, end) in
        [("map_Kd", "texture", "its colour is used alone"), ("map_d", "alpha mask", "all is opaque")]
    {
        for image in UNREADABLE.into_iter().chain(["none.png"]) {
            folder.write("a.mtl", format!("newmtl a\nKd 0.5\n{keyword} {image}\n"));
            let loaded = folder.load("[[mesh]]\nfile = \"a.obj\"\n").unwrap();
            let [warning] = loaded.report.warnings.as_slice() else {
                panic!("{keyword} {image}: {:?}", loaded.report.warnings)
            };
            let right = warning.starts_with(&format!("a.mtl:3: {kind} ")) && warning.contains(image);
            assert!(right && warning.ends_with(end), "{keyword} {image}: {warning}");
            let material = &loaded.scene.mesh.materials[loaded.scene.mesh.material_ids[0] as usize];
            assert_eq!((material.texture, material.alpha_mask), (None, None));
            assert_eq!(material.albedo, Vec3::splat(0.5));
        }
    }
    let of = |image: &str| {
        folder.write("a.mtl", format!("newmtl a\nmap_Kd {image}\n"));
        folder.load("[[mesh]]\nfile = \"a.obj\"\n").unwrap().report.warnings[0].clone()
    };
    assert!(of("moving.gif").contains("it is no PNG, JPEG, TGA or BMP image"), "{}", of("moving.gif"));
    // Two materials that lack the same image: one message, of the first.
    folder.write("a.mtl", "newmtl a\nmap_Kd none.png\nnewmtl b\nmap_Kd none.png\n");
    folder.write("b.obj", format!("{OBJ}usemtl b\nf 3/3 2/2 1/1\n"));
    let warnings = folder.load("[[mesh]]\nfile = \"b.obj\"\n").unwrap().report.warnings;
    assert!(warnings.len() == 1 && warnings[0].starts_with("a.mtl:2: "), "{warnings:?}");
}

#[test]
fn unreadable_textures_of_lights_are_errors_that_name_the_line() {
    let folder = images("unreadable_lights");
    folder.write("a.mtl", "newmtl a\n");
    let load = |image: &str| {
        let head = HEAD.replace(
            "radiance = [1, 1, 1]\n",
            &format!("radiance = [1, 1, 1]\ntexture = \"{image}\"\ntexture_stretch = true\n"),
        );
        folder.load_text(&format!("{head}[[mesh]]\nfile = \"a.obj\"\n"))
    };
    for image in UNREADABLE.into_iter().chain(["none.png", "a.obj", "."]) {
        let fault = load(image).err().unwrap();
        let named = fault.starts_with("scene.toml:11: [[light]] texture `");
        assert!(named && fault.contains(image) && !fault.contains('\n'), "{image}: {fault}");
    }
    let fault = load("moving.gif").err().unwrap();
    assert!(fault.ends_with("it is no PNG, JPEG, TGA, BMP, Radiance HDR or OpenEXR image"), "{fault}");
    assert!(load("whole.png").is_ok());
}

#[test]
fn images_of_16_bits_and_of_one_texel_are_right() {
    let folder = Folder::new("wide_images");
    folder.write("a.obj", OBJ);
    let wide = ImageBuffer::<Rgb<u16>, _>::from_pixel(4, 2, Rgb([0x8080u16, 0x4040, 0x00ff]));
    wide.save(folder.0.join("wide.png")).unwrap();
    RgbImage::from_pixel(1, 1, Rgb([200, 100, 50])).save(folder.0.join("one.png")).unwrap();
    for (name, alpha) in [("solid.png", 0x8080u16), ("hole.png", 0x7f7f)] {
        let image = ImageBuffer::<Luma<u16>, _>::from_pixel(1, 1, Luma([alpha]));
        image.save(folder.0.join(name)).unwrap();
    }
    let load = |mtl: &str| {
        folder.write("a.mtl", format!("newmtl a\n{mtl}\n"));
        let loaded = folder.load("[[mesh]]\nfile = \"a.obj\"\n").unwrap();
        assert!(loaded.report.warnings.is_empty(), "{:?}", loaded.report.warnings);
        loaded.scene
    };
    // Rounded to 8 bits: 0x00ff is 255 / 257 of a step.
    assert_eq!(load("map_Kd wide.png").mesh.textures[0].texels, [[128, 64, 1, 255]; 8]);
    assert_eq!(load("map_Kd one.png").mesh.textures[0].texels, [[200, 100, 50, 255]]);
    // A mask without holes is dropped.
    assert!(load("map_d solid.png").mesh.alpha_masks.is_empty());
    assert_eq!(load("map_d hole.png").mesh.alpha_masks.len(), 1);
    // Lights keep all 16 bits.
    folder.write("a.mtl", "newmtl a\n");
    let light = |image: &str| {
        let head = HEAD.replace(
            "radiance = [1, 1, 1]\n",
            &format!("radiance = [1, 1, 1]\ntexture = \"{image}\"\ntexture_stretch = true\n"),
        );
        let scene = folder.load_text(&format!("{head}[[mesh]]\nfile = \"a.obj\"\n")).unwrap().scene;
        scene.light_texture(&scene.lights[0]).unwrap().mean()
    };
    // sRGB of 128 / 255, 64 / 255 and 255 / 65535, by IEC 61966-2-1.
    let expected = Vec3::new(0.215_860_5, 0.051_269_46, 255.0 / 65535.0 / 12.92);
    assert!(light("wide.png").abs_diff_eq(expected, 1e-6), "{}", light("wide.png"));
    assert!(light("one.png").abs_diff_eq(Vec3::new(0.577_580_4, 0.127_437_7, 0.031_896_03), 1e-6));
}

/// A face that is not flat becomes two triangles, which meet at a diagonal.
#[test]
fn faces_that_are_not_flat_are_divided() {
    let folder = Folder::new("bent_faces");
    let bent = folder.load_mesh("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nf 1 2 3 4\n").unwrap();
    assert_eq!((bent.scene.mesh.triangle_count(), bent.report.warnings.len()), (2, 0));
}
