//! Textured lights and videos, and their faults.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "helpers of tests")]

mod common;

use common::{Folder, HEAD};
use glam::{Vec2, Vec3};
use image::{ImageBuffer, Luma, Rgb, Rgb32FImage, RgbImage};

const FLOOR: &str = "[[mesh]]\ngenerator = \"open-floor\"\n";

/// Scene whose light has these keys as well.
fn scene(keys: &str) -> String {
    format!("{}{keys}\n\n{FLOOR}", HEAD.trim_end().to_owned() + "\n")
}

/// A texture of 2 × 2 texels, dark on the left, with a given red on the right.
fn texture(red: u8) -> RgbImage {
    RgbImage::from_fn(2, 2, |x, y| if x == 0 { Rgb([0, 0, 0]) } else { Rgb([red, 188, y as u8 * 255]) })
}

#[test]
fn srgb_is_decoded_and_the_lower_left_is_the_corner() {
    let folder = Folder::new("texture-srgb");
    texture(255).save(folder.0.join("screen.png")).unwrap();
    let loaded = folder.load_text(&scene("texture = \"screen.png\"")).unwrap();
    assert!(loaded.animation.is_none());
    let light = loaded.scene.lights[0];
    let texture = loaded.scene.light_texture(&light).unwrap();
    assert_eq!(texture.at(Vec2::new(0.25, 0.25)), Vec3::ZERO);
    let (low, high) = (texture.at(Vec2::new(0.75, 0.25)), texture.at(Vec2::new(0.75, 0.75)));
    assert!((low - Vec3::new(1.0, 0.502_886, 1.0)).length() < 1e-4, "{low}");
    assert_eq!((high.x, high.z), (1.0, 0.0));
    let linear = folder.load_text(&scene("texture = \"screen.png\"\ntexture_encoding = \"linear\"")).unwrap();
    let low = linear.scene.light_texture(&linear.scene.lights[0]).unwrap().at(Vec2::new(0.75, 0.25));
    assert!((low.y - 188.0 / 255.0).abs() < 1e-5, "{low}");
}

#[test]
fn floats_are_linear_and_may_exceed_1() {
    let folder = Folder::new("texture-floats");
    let image = Rgb32FImage::from_fn(2, 2, |x, _| Rgb([0.5, 8.0, x as f32]));
    for name in ["screen.exr", "screen.hdr"] {
        image::DynamicImage::from(image.clone()).save(folder.0.join(name)).unwrap();
        let loaded = folder.load_text(&scene(&format!("texture = \"{name}\""))).unwrap();
        let found = loaded.scene.light_texture(&loaded.scene.lights[0]).unwrap().at(Vec2::new(0.9, 0.1));
        assert!((found - Vec3::new(0.5, 8.0, 1.0)).abs().max_element() < 0.04, "{name}: {found}");
    }
    let deep = ImageBuffer::from_fn(2, 2, |_, _| Luma([65535u16]));
    image::DynamicImage::from(deep).save(folder.0.join("deep.png")).unwrap();
    let loaded = folder.load_text(&scene("texture = \"deep.png\"")).unwrap();
    assert_eq!(loaded.scene.light_textures[0].uniform(), Some(Vec3::ONE));
}

#[test]
fn frames_of_a_video_follow_each_other() {
    let folder = Folder::new("texture-video");
    for (number, red) in [(7, 10), (8, 100), (9, 255)] {
        texture(red).save(folder.0.join(format!("screen-{number:03}.png"))).unwrap();
    }
    folder.write("screen-12345.txt", "").write("screen-1.png", "");
    let loaded = folder.load_text(&scene("texture = \"screen-###.png\"\ntexture_fps = 10")).unwrap();
    let animation = loaded.animation.unwrap();
    assert_eq!(animation.to_string(), "1 video");
    let shown = |time| animation.at(&loaded.scene, time).lights[0].texture.unwrap().index;
    assert_eq!([0.0, 0.05, 0.1, 0.2, 0.3, 0.7].map(shown), [0, 0, 1, 2, 0, 1]);
    let every: Vec<u32> = (0..9u32).map(|frame| shown(frame as f32 / 10.0)).collect();
    assert_eq!(every, [0, 1, 2, 0, 1, 2, 0, 1, 2]);
}

#[test]
fn textures_are_generated_as_stills_and_films() {
    let folder = Folder::new("texture-generated");
    let still =
        folder.load_text(&scene("texture_generator = \"checkerboard\"\ntexture_stretch = true")).unwrap();
    assert!(still.animation.is_none());
    let texture = still.scene.light_texture(&still.scene.lights[0]).unwrap();
    // Sixteen squares by nine; the lower left one is white.
    let at = |x: f32, y: f32| texture.at(Vec2::new((x + 0.5) / 16.0, (y + 0.5) / 9.0));
    assert_eq!(
        [at(0.0, 0.0), at(1.0, 0.0), at(15.0, 8.0), at(0.0, 3.0)],
        [Vec3::ONE, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO]
    );
    let keys =
        "texture_generator = \"checkerboard\"\ntexture_frames = 4\ntexture_fps = 2\ntexture_stretch = true";
    let film = folder.load_text(&scene(keys)).unwrap();
    assert_eq!(film.scene.light_textures.len(), 4);
    assert_eq!(film.scene.light_textures[0].texels(), still.scene.light_textures[0].texels());
    let animation = film.animation.unwrap();
    let shown = |time| animation.at(&film.scene, time).lights[0].texture.unwrap().index;
    assert_eq!([0.0, 0.5, 1.5, 2.0].map(shown), [0, 1, 3, 0]);
    // By half a square a frame: the lower left corner is black after two frames.
    assert_eq!(film.scene.light_textures[2].at(Vec2::new(0.5 / 16.0, 0.5 / 9.0)), Vec3::ZERO);
}

#[test]
fn faults_name_file_and_line() {
    let folder = Folder::new("texture-faults");
    texture(255).save(folder.0.join("screen.png")).unwrap();
    RgbImage::new(4, 2).save(folder.0.join("wide.png")).unwrap();
    let dark = Rgb32FImage::from_pixel(2, 2, Rgb([0.5, -1.0, 0.0]));
    image::DynamicImage::from(dark).save(folder.0.join("negative.exr")).unwrap();
    for (name, side) in [("a-01.png", 2), ("a-02.png", 4), ("b-01.png", 2), ("b-03.png", 2)] {
        RgbImage::new(side, side).save(folder.0.join(name)).unwrap();
    }
    folder.write("text.png", "no texture");
    for (keys, expected) in [
        ("texture = \"none.png\"", "none.png` is missing; paths are relative to the scene file"),
        ("texture = \"text.png\"", "text.png` cannot be read"),
        ("texture = \"negative.exr\"", "texel 0, 0 from the top left is negative"),
        (
            "texture = \"wide.png\"",
            "2.000 times as wide as high, but edge_u is 1.000 times as long as edge_v",
        ),
        ("texture = \"none-##.png\"", "there is no such file for any number"),
        ("texture = \"##/screen.png\"", "# in the name of a folder"),
        ("texture = \"a-##.png\"", "a-02.png` has 4x4 texels, expected 2x2 as in the first frame"),
        ("texture = \"b-##.png\"", "lacks frame 2"),
        ("texture = 3", "texture is 3, expected a text in quotes"),
        ("texture_fps = 10", "has no `texture`"),
        ("texture = \"screen.png\"\ntexture_fps = 0", "texture_fps is 0, expected frames a second above 0"),
        ("texture = \"screen.png\"\ntexture_encoding = \"gamma\"", "expected auto, srgb or linear"),
        (
            "texture_generator = \"meadow\"",
            "1.778 times as wide as high, but edge_u is 1.000 times as long as edge_v",
        ),
        ("texture_generator = \"snow\"", "texture_generator is `snow`, expected one of checkerboard, meadow"),
        (
            "texture = \"screen.png\"\ntexture_generator = \"meadow\"",
            "has both a texture and a texture_generator",
        ),
        ("texture = \"screen.png\"\ntexture_frames = 2", "texture_frames is of a texture_generator"),
        ("texture_generator = \"meadow\"\ntexture_encoding = \"srgb\"", "texture_encoding is of a file"),
        (
            "texture_generator = \"meadow\"\ntexture_frames = 0",
            "texture_frames is 0, expected a whole number from 1 to 1000",
        ),
        (
            "texture_generator = \"meadow\"\ntexture_frames = 1.5",
            "texture_frames is 1.5, expected a whole number",
        ),
        ("texture_frames = 2", "has no `texture`"),
    ] {
        let error = folder.load_text(&scene(keys)).map(|_| ()).unwrap_err();
        assert!(error.contains(expected), "{keys}: {error}");
        let line = 10 + keys.lines().count();
        assert!((11..=line).any(|line| error.contains(&format!(":{line}: "))), "{keys}: {error}");
    }
    folder.load_text(&scene("texture = \"wide.png\"\ntexture_stretch = true")).unwrap();
}
