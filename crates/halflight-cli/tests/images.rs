//! `compare` on images of other programs, on parts of pictures, and on what is no image.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail their test")]

use std::fs;

use common::Place;
use exr::prelude::*;
use serde_json::Value;

mod common;

/// A picture of 8 × 6 pixels with different values everywhere, times `factor`.
fn value(x: usize, y: usize, channel: usize, factor: f32) -> f32 {
    factor * (0.25 + x as f32 / 8.0 + y as f32 / 16.0 + channel as f32 / 2.0)
}

/// A layer with channels of these names whose data window begins at `from`.
fn layer(
    names: &[&str],
    from: (i32, i32),
    size: (usize, usize),
    factor: f32,
) -> Layer<AnyChannels<FlatSamples>> {
    let channel = |(number, name): (usize, &&str)| {
        let pixels = (0..size.0 * size.1).map(|pixel| (pixel % size.0, pixel / size.0));
        let values = pixels.map(|(x, y)| value(x + from.0 as usize, y + from.1 as usize, number % 3, factor));
        AnyChannel::new(*name, FlatSamples::F32(values.collect()))
    };
    let channels = AnyChannels::sort(names.iter().enumerate().map(channel).collect());
    let attributes = LayerAttributes { layer_position: Vec2(from.0, from.1), ..LayerAttributes::default() };
    Layer::new(size, attributes, Encoding::FAST_LOSSLESS, channels)
}

/// Writes one layer with a display window of 8 × 6 pixels.
fn write(place: &Place, name: &str, layer: Layer<AnyChannels<FlatSamples>>) {
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((8, 6)));
    Image::new(attributes, layer).write().to_file(place.path(name)).unwrap();
}

fn whole(names: &[&str], factor: f32) -> Layer<AnyChannels<FlatSamples>> {
    layer(names, (0, 0), (8, 6), factor)
}

/// NMSE₂ of a comparison that must succeed, and what was said of it.
fn compared(place: &Place, arguments: &str) -> (f64, String) {
    let output = place.run(&format!("compare {arguments} --json"));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments}: {said}");
    let figures: Value = serde_json::from_slice(&output.stdout).unwrap();
    (figures["nmse2"].as_f64().unwrap(), said)
}

#[test]
fn plain_images_are_compared_and_irradiance_comes_first() {
    let place = Place::new("plain-images");
    const RGB: [&str; 3] = ["R", "G", "B"];
    const BOTH: [&str; 6] = ["irradiance.R", "irradiance.G", "irradiance.B", "R", "G", "B"];
    write(&place, "rgb.exr", whole(&RGB, 1.0));
    write(&place, "rgba.exr", whole(&["R", "G", "B", "A"], 1.1));
    write(&place, "both.exr", whole(&BOTH, 1.1));
    write(&place, "twice.exr", whole(&BOTH, 1.0));
    write(&place, "grey.exr", whole(&["Y"], 1.1));
    write(&place, "gray.exr", whole(&["Y"], 1.0));
    for (arguments, layer) in [
        ("rgba.exr rgb.exr", "compared: default layer\n"),
        ("both.exr rgb.exr", "compared: default layer\n"),
        ("both.exr twice.exr", "compared: layer `irradiance`\n"),
        ("grey.exr gray.exr", "compared: default layer\n"),
    ] {
        let (error, said) = compared(&place, arguments);
        // 1.1 times the reference, but for rounding.
        assert!((error - 0.01).abs() < 1e-6 && said == layer, "{arguments}: {error} {said}");
    }
    write(&place, "other.exr", whole(&["R", "G", "normal.X"], 1.0));
    let message = place.bad("compare other.exr rgb.exr");
    assert!(
        message.contains("other.exr has no default layer with channels R, G, B; it has G, R, normal.X"),
        "{message}"
    );
    let message = place.bad("compare both.exr rgb.exr --layer irradiance");
    assert!(message.contains("rgb.exr has no layer `irradiance`"), "{message}");
    // Files that the program writes can be set against another program's picture of it.
    place.good("render contact --size 8x6 --out own.exr");
    let (error, _) = compared(&place, "own.exr own.exr --layer radiance");
    assert_eq!(error, 0.0);
    assert!(compared(&place, "own.exr rgb.exr").1.starts_with("compared: default layer"));
}

#[test]
fn penumbrae_are_those_of_the_reference() {
    const BOTH: [&str; 6] = ["R", "G", "B", "visibility.R", "visibility.G", "visibility.B"];
    let place = Place::new("penumbrae");
    write(&place, "plain.exr", whole(&["R", "G", "B"], 1.0));
    write(&place, "penumbra.exr", whole(&BOTH, 0.25));
    write(&place, "lit.exr", whole(&BOTH, 4.0));
    for (arguments, grain, words) in [
        ("plain.exr penumbra.exr", true, ""),
        ("penumbra.exr plain.exr", false, "no grain: the reference has no layer `visibility`"),
        ("plain.exr lit.exr", false, "no grain: no pixel of the reference lies in a penumbra"),
    ] {
        let output = place.run(&format!("compare {arguments}"));
        let (table, said) =
            [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap()).into();
        assert_eq!(!table.contains("grain     -\n"), grain, "{arguments}: {table}");
        assert!(said.contains(words) && said.contains("no grain") != grain, "{arguments}: {said}");
        let json: Value = serde_json::from_str(&place.good(&format!("compare {arguments} --json"))).unwrap();
        assert_eq!(json["grain"].is_number(), grain, "{json}");
    }
    // Files of the program tell the visible fractions themselves.
    place.good("reference contact --size 48x36 --samples 512 --out truth.exr");
    place.good("render contact --size 48x36 --refiner per-pixel --samples 16 --out noisy.exr");
    place.good("render contact --size 48x36 --refiner per-pixel --samples 1024 --out smooth.exr");
    let [noisy, smooth] = ["noisy", "smooth"].map(|image| -> f64 {
        let json = place.good(&format!("compare {image}.exr truth.exr --json"));
        serde_json::from_str::<Value>(&json).unwrap()["grain"].as_f64().unwrap()
    });
    assert!(noisy > 3.0 * smooth && smooth > 0.0, "{noisy} {smooth}");
}

#[test]
fn pixels_are_compared_where_they_lie() {
    let place = Place::new("windows");
    const RGB: [&str; 3] = ["R", "G", "B"];
    write(&place, "whole.exr", whole(&RGB, 1.0));
    write(&place, "crop.exr", layer(&RGB, (2, 1), (5, 4), 1.0));
    let (error, said) = compared(&place, "crop.exr whole.exr");
    assert_eq!(
        (error, &*said),
        (0.0, "compared: default layer; 5×4 pixels from (2, 1), which both files have\n")
    );
    assert_eq!(compared(&place, "whole.exr crop.exr").0, 0.0);
    // Equal numbers in another place.
    let mut moved = layer(&RGB, (2, 1), (5, 4), 1.0);
    moved.attributes.layer_position = Vec2(3, 1);
    write(&place, "moved.exr", moved);
    assert!(compared(&place, "moved.exr whole.exr").0 > 0.0);
    let message = place.bad("compare moved.exr crop.exr");
    assert!(
        message.contains("neither lies inside the other: 5×4 pixels from (3, 1) against 5×4 pixels"),
        "{message}"
    );
    // Pixels are named by the coordinates that the windows are given in.
    let mut broken = layer(&RGB, (2, 1), (5, 4), 1.0);
    if let FlatSamples::F32(values) = &mut broken.channel_data.list[0].sample_data {
        values[7] = f32::NAN;
    }
    write(&place, "broken.exr", broken);
    let message = place.bad("compare broken.exr whole.exr");
    assert!(message.contains("pixel (4, 2) of the image is not finite"), "{message}");
    // Pictures of different sizes are no parts of each other.
    let small = layer(&RGB, (0, 0), (5, 4), 1.0);
    Image::from_layer(small).write().to_file(place.path("small.exr")).unwrap();
    let message = place.bad("compare small.exr whole.exr");
    assert!(message.contains("differ in size: 5×4 against 8×6"), "{message}");
}

#[test]
fn what_is_no_openexr_image_is_told_by_its_kind() {
    let place = Place::new("no-images");
    place.good("render contact --size 8x6 --png a.png");
    fs::write(place.path("text"), "not an image").unwrap();
    fs::write(place.path("empty"), "").unwrap();
    for (file, words) in [
        ("a.png", "a.png is not a complete OpenEXR image: it is a PNG picture"),
        ("text", "it does not begin as such files do"),
        ("empty", "it is empty"),
        (".", "cannot read ."),
    ] {
        let message = place.bad(&format!("compare {file} {file}"));
        assert!(message.contains(words), "{file}: {message}");
    }
}

/// Lamps before the sky and pixels that only partly see a surface are light that reaches the camera, though their centres see no surface.
#[test]
fn lamps_and_mixed_pixels_count_in_the_radiance_alone() {
    use halflight_core::glam::Vec3;
    use halflight_image::ExrFile;
    let place = Place::new("lamps");
    // A surface, a lamp, a mixed pixel that the image lacks, and sky.
    let write = |name: &str, lamp: f32, mixed: f32| {
        let grey = |values: [f32; 4]| values.map(Vec3::splat);
        let mut file = ExrFile::new(4, 1, Value::Null);
        file.add_resolved_light(&grey([2.0, 0.0, 9.0, 0.0]), &grey([1.0, lamp, mixed, 0.0]));
        file.add_parts(&[], &[], &grey([0.0, lamp, 0.0, 0.0]));
        file.add_plane("depth", "Z", vec![1.0, f32::INFINITY, f32::INFINITY, f32::INFINITY]);
        file.write(&place.path(name)).unwrap();
    };
    write("truth.exr", 3.0, 0.5);
    write("no-lamp.exr", 0.0, 0.5);
    write("no-edge.exr", 3.0, 0.0);
    // Squared errors over the squares of the surface, the lamp and the mixed pixel.
    let whole = 1.0 + 9.0 + 0.25;
    for (image, layer, expected) in [
        ("no-lamp.exr", "radiance", 9.0 / whole),
        ("no-edge.exr", "radiance", 0.25 / whole),
        ("no-lamp.exr", "emission", 1.0),
        // Of surfaces: the first pixel alone.
        ("no-lamp.exr", "irradiance", 0.0),
        ("no-edge.exr", "irradiance", 0.0),
        ("truth.exr", "radiance", 0.0),
    ] {
        let (found, _) = compared(&place, &format!("{image} truth.exr --layer {layer}"));
        // Values are in single precision.
        assert!((found - expected).abs() < 1e-6, "{image} {layer}: {found} {expected}");
        let (back, _) = compared(&place, &format!("truth.exr {image} --layer irradiance"));
        assert_eq!(back, 0.0);
    }
    // Light that the reference lacks counts as well, relative to the surface and the mixed pixel.
    let (found, _) = compared(&place, "truth.exr no-lamp.exr --layer radiance");
    assert!((found - 9.0 / 1.25).abs() < 1e-5, "{found}");
}
