//! Image files: what is written is read back, and what is no image is refused with a reason.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail their test")]

use std::fs;
use std::path::PathBuf;

use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_image::{DEFAULT_LAYER, ExrFile, RGB, ReadError, Window, XYZ};
use serde_json::json;

/// A folder of this test alone, empty.
fn folder(test: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("exr-{test}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// An image of odd size with every layer, infinite depths and a tiny value among its pixels.
fn sample() -> ExrFile {
    let (width, height) = (37, 21);
    let mut gbuffer = GBuffer::default();
    gbuffer.reset(width, height);
    for pixel in 0..gbuffer.pixels() {
        let value = pixel as f32;
        gbuffer.albedo[pixel] = Vec3::new(0.1, 0.5, value / 1000.0);
        gbuffer.normal[pixel] = Vec3::new(0.0, 1.0, -value);
        gbuffer.position[pixel] = Vec3::new(value, -1e-30, 1e30);
        if pixel % 5 != 0 {
            gbuffer.depth[pixel] = value + 0.25;
        }
    }
    let irradiance: Vec<Vec3> = (0..777).map(|pixel| Vec3::new(pixel as f32, 0.5, 3.0)).collect();
    let metadata =
        json!({ "scene": "Größe 漢字 \u{1f600} \"quoted\"", "config": { "width": 37 }, "commit": null });
    let mut file = ExrFile::new(width, height, metadata);
    file.add_light(&irradiance, &gbuffer.albedo);
    file.add_vectors("visibility", RGB, &irradiance);
    file.add_geometry(&gbuffer);
    file.add_plane("level", "Y", vec![-1.0; 777]);
    file
}

#[test]
fn all_layers_and_the_metadata_come_back_bit_for_bit() {
    let path = folder("round-trip").join("image.exr");
    let written = sample();
    written.clone().write(&path).unwrap();
    let back = ExrFile::read(&path).unwrap();
    assert_eq!(back, ExrFile { path: path.clone(), ..written });
    let names: Vec<&str> = back.channels.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        [
            "B",
            "G",
            "R",
            "albedo.B",
            "albedo.G",
            "albedo.R",
            "depth.Z",
            "irradiance.B",
            "irradiance.G",
            "irradiance.R",
            "level.Y",
            "normal.X",
            "normal.Y",
            "normal.Z",
            "position.X",
            "position.Y",
            "position.Z",
            "radiance.B",
            "radiance.G",
            "radiance.R",
            "visibility.B",
            "visibility.G",
            "visibility.R",
        ]
    );
    let radiance = back.vectors("radiance", RGB).unwrap();
    assert_eq!(
        radiance[9],
        Vec3::new(9.0, 0.5, 3.0) * Vec3::new(0.1, 0.5, 0.009) * std::f32::consts::FRAC_1_PI
    );
    // Programs that know no layers show the radiance.
    assert_eq!(back.layer(DEFAULT_LAYER).unwrap(), radiance);
    assert_eq!(back.layer("normal").unwrap(), back.vectors("normal", XYZ).unwrap());
    assert_eq!(back.layer("level").unwrap()[0], Vec3::splat(-1.0));
    // Nothing else is left in the folder: the temporary file has become the image.
    assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
}

#[test]
fn equal_images_are_equal_files() {
    let folder = folder("equal");
    let (a, b) = (folder.join("a.exr"), folder.join("b.exr"));
    sample().write(&a).unwrap();
    sample().write(&b).unwrap();
    assert!(fs::read(a).unwrap() == fs::read(b).unwrap());
}

/// A part of 3 × 2 pixels at `position`, all of one value.
fn part(
    name: Option<&str>,
    channels: &[&str],
    value: f32,
    position: (i32, i32),
) -> exr::prelude::Layer<exr::prelude::AnyChannels<exr::prelude::FlatSamples>> {
    use exr::prelude::*;
    let channel = |name: &&str| AnyChannel::new(*name, FlatSamples::F32(vec![value; 6]));
    let channels = AnyChannels::sort(channels.iter().map(channel).collect());
    let attributes = LayerAttributes {
        layer_name: name.map(Text::from),
        layer_position: Vec2(position.0, position.1),
        ..LayerAttributes::default()
    };
    Layer::new((3, 2), attributes, Encoding::FAST_LOSSLESS, channels)
}

#[test]
fn files_that_others_wrote_in_several_parts_are_read_by_layer() {
    use exr::prelude::*;
    let path = folder("parts").join("parts.exr");
    let layers: Layers<_> = SmallVec::from_vec(vec![
        part(Some("mask"), &["V"], 9.0, (1, 1)),
        part(Some("irradiance"), &RGB, 2.0, (0, 0)),
        part(Some("albedo"), &RGB, 0.5, (0, 0)),
        part(Some("all"), &["normal.X", "normal.Y", "normal.Z"], 0.25, (0, 0)),
    ]);
    let size = IntegerBounds::from_dimensions((3, 2));
    Image::from_layers(ImageAttributes::new(size), layers).write().to_file(&path).unwrap();
    let file = ExrFile::read(&path).unwrap();
    assert_eq!(file.vectors("irradiance", RGB).unwrap(), [Vec3::splat(2.0); 6]);
    assert_eq!(file.layer("normal").unwrap(), [Vec3::splat(0.25); 6]);
    assert_eq!(file.metadata, serde_json::Value::Null);
    // No part is without a name: the first that has colours is what programs show.
    assert_eq!(file.shown_layer, "irradiance");
    let message = file.layer("mask").unwrap_err().to_string();
    assert!(message.ends_with("part `mask` of another data window, not read"), "{message}");
}

#[test]
fn windows_and_crops_are_where_the_file_says() {
    use exr::prelude::*;
    let path = folder("windows").join("crop.exr");
    let size = IntegerBounds::new((-4, 0), (20, 10));
    let mut layer = part(None, &RGB, 0.0, (-2, 1));
    for channel in &mut layer.channel_data.list {
        channel.sample_data = FlatSamples::F32((0..6).map(|value| value as f32).collect());
    }
    Image::new(ImageAttributes::new(size), layer).write().to_file(&path).unwrap();
    let file = ExrFile::read(&path).unwrap();
    assert_eq!(file.window(), Window { x: -2, y: 1, width: 3, height: 2 });
    assert_eq!(file.display, Window { x: -4, y: 0, width: 20, height: 10 });
    let inner = Window { x: -1, y: 2, width: 2, height: 1 };
    assert!(file.window().contains(&inner) && !inner.contains(&file.window()));
    assert_eq!(file.crop(&file.channels["R"], &inner), [4.0, 5.0]);
}

#[test]
fn every_number_format_compression_and_tiling_gives_the_same_values() {
    use exr::prelude::*;
    let path = folder("kinds").join("image.exr");
    let whole: Vec<u32> = (0..64 * 48).map(|pixel| pixel % 1000).collect();
    let formats = [
        FlatSamples::F16(whole.iter().map(|&value| f16::from_f32(value as f32)).collect()),
        FlatSamples::F32(whole.iter().map(|&value| value as f32).collect()),
        FlatSamples::U32(whole.clone()),
    ];
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
    ];
    for samples in formats {
        for (compression, blocks) in compressions.into_iter().flat_map(|compression| {
            [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 16))].map(|blocks| (compression, blocks))
        }) {
            let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
            let channels = AnyChannels::sort(smallvec([AnyChannel::new("Y", samples.clone())]));
            let layer = Layer::new((64, 48), LayerAttributes::default(), encoding, channels);
            Image::from_layer(layer).write().to_file(&path).unwrap();
            let read = ExrFile::read(&path).unwrap().plane(DEFAULT_LAYER, "Y").unwrap().to_vec();
            // Integers below 2048 are exact in all of them.
            assert!(
                read.iter().zip(&whole).all(|(&read, &value)| read == value as f32),
                "{compression} {blocks:?}"
            );
        }
    }
}

/// A list of one channel.
fn smallvec<T>(list: [T; 1]) -> exr::prelude::SmallVec<[T; 4]> {
    list.into_iter().collect()
}

#[test]
fn a_missing_layer_is_named_with_those_there_are() {
    let path = folder("missing").join("image.exr");
    let mut file = ExrFile::new(1, 1, json!(null));
    file.add_plane("depth", "Z", vec![1.0]);
    file.write(&path).unwrap();
    let error = ExrFile::read(&path).unwrap().layer("irradiance").unwrap_err();
    assert!(matches!(&error, ReadError::Layer { layer, .. } if layer == "layer `irradiance`"));
    let message = error.to_string();
    assert!(
        message.ends_with("image.exr has no layer `irradiance` with channels R, G, B; it has depth.Z"),
        "{message}"
    );
}

#[test]
fn a_channel_of_the_wrong_size_is_refused_and_nothing_is_written() {
    let path = folder("size").join("image.exr");
    let mut file = ExrFile::new(2, 2, json!(null));
    file.add_plane("depth", "Z", vec![1.0; 3]);
    assert_eq!(
        file.write(&path).unwrap_err().source.to_string(),
        "channel depth.Z has 3 values for 4 pixels"
    );
    assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 0);
}

#[test]
fn foreign_and_missing_files_are_told_apart() {
    let folder = folder("foreign");
    assert!(matches!(ExrFile::read(&folder.join("none.exr")), Err(ReadError::Open { .. })));
    let text = folder.join("text.exr");
    fs::write(&text, "not an image").unwrap();
    assert!(matches!(ExrFile::read(&text), Err(ReadError::Format { .. })));
    fs::write(&text, "").unwrap();
    assert!(matches!(ExrFile::read(&text), Err(ReadError::Format { .. })));
    // Endless devices end.
    if cfg!(target_os = "linux") {
        assert!(matches!(ExrFile::read("/dev/zero".as_ref()), Err(ReadError::Format { .. })));
    }
}

#[test]
fn sizes_that_no_memory_holds_are_refused_before_they_are_read() {
    let path = folder("huge").join("image.exr");
    let mut small = ExrFile::new(5, 3, json!(null));
    small.add_plane("depth", "Z", vec![1.0; 15]);
    small.write(&path).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    // The data window's last column and row, which stand behind the attribute's name, type and size.
    let name = b"dataWindow\0box2i\0\x10\0\0\0";
    let place = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len();
    bytes[place + 8..place + 16].copy_from_slice(&[0xff, 0xff, 0xff, 0x1f, 0xff, 0xff, 0xff, 0x1f]);
    fs::write(&path, bytes).unwrap();
    let error = ExrFile::read(&path).unwrap_err();
    assert!(matches!(error, ReadError::Memory { .. } | ReadError::Format { .. }), "{error}");
}

#[test]
fn a_truncated_or_damaged_file_never_passes_for_the_image_and_never_panics() {
    let folder = folder("damaged");
    let path = folder.join("image.exr");
    let whole = sample();
    whole.write(&path).unwrap();
    let bytes = fs::read(&path).unwrap();
    for length in (0..bytes.len()).step_by(bytes.len() / 97).chain([bytes.len() - 1]) {
        fs::write(&path, &bytes[..length]).unwrap();
        assert!(
            matches!(ExrFile::read(&path), Err(ReadError::Format { .. })),
            "cut off after {length} bytes"
        );
    }
    // A flipped bit may go unnoticed in a pixel, but must not bring the program down.
    for place in (0..bytes.len()).step_by(bytes.len() / 199) {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x55;
        fs::write(&path, &damaged).unwrap();
        let _ = ExrFile::read(&path);
    }
}
