//! `--indirect`: layers that add up, references of one reflection, and refusals.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail their test")]

use std::f32::consts::FRAC_1_PI;
use std::fs;

use common::{Place, json};
use halflight_core::glam::Vec3;
use halflight_image::{ExrFile, INDIRECT, INDIRECT_IRRADIANCE};

mod common;

const SMALL: &str = "render contact --size 48x36 --antialias 1";

fn read(place: &Place, name: &str) -> ExrFile {
    ExrFile::read(&place.path(name)).unwrap()
}

#[test]
fn direct_and_indirect_light_add_up_to_the_radiance() {
    let place = Place::new("indirect-layers");
    place.good(&format!("{SMALL} --out plain.exr"));
    let plain = read(&place, "plain.exr");
    assert!(plain.layer(INDIRECT).is_err() && plain.layer("direct").is_err());
    for method in ["lpv", "gather"] {
        place.good(&format!("{SMALL} --indirect {method} --out image.exr --stats stats.json"));
        let image = read(&place, "image.exr");
        let [radiance, direct, indirect, irradiance, albedo] =
            ["radiance", "direct", INDIRECT, INDIRECT_IRRADIANCE, "albedo"]
                .map(|layer| image.layer(layer).unwrap());
        assert!(indirect.iter().any(|light| light.max_element() > 0.0), "{method}");
        for pixel in 0..radiance.len() {
            // Two roundings of sums and products.
            let bound = 1e-6 * radiance[pixel].max_element();
            assert!(
                (direct[pixel] + indirect[pixel]).abs_diff_eq(radiance[pixel], bound),
                "{method}: {pixel}"
            );
            let reflected = irradiance[pixel] * albedo[pixel] * FRAC_1_PI;
            assert!(reflected.abs_diff_eq(indirect[pixel], bound), "{method}: {pixel}");
        }
        // Direct light is not touched.
        assert_eq!(image.layer("irradiance").unwrap(), plain.layer("irradiance").unwrap());
        let stats = json(&place.path("stats.json"));
        assert_eq!(stats["config"]["indirect"]["name"], method);
        assert!(stats["indirect"]["points"].as_u64().unwrap() > 0);
        let rays = |key: &str| stats["rays"][key].as_u64().unwrap();
        assert_eq!(rays("indirect"), {
            let counts = &stats["indirect"];
            counts["light_rays"].as_u64().unwrap() + counts["gather_rays"].as_u64().unwrap()
        });
        assert!(rays("total") > rays("indirect") && rays("indirect") > 0);
    }
}

#[test]
fn references_of_one_reflection_are_what_images_are_compared_with() {
    let place = Place::new("indirect-reference");
    place.good("reference contact --size 48x36 --indirect --samples 63 --out truth.exr");
    let truth = read(&place, "truth.exr");
    assert_eq!(truth.metadata["reference"]["rays"], 64);
    let noise = truth.metadata["reference"]["noise_nmse2"].as_f64().unwrap();
    assert!(noise > 0.0 && noise < 1.0, "{noise}");
    let light = truth.layer(INDIRECT_IRRADIANCE).unwrap();
    assert!(light.iter().any(|&value| value != Vec3::ZERO) && light.iter().all(|value| value.is_finite()));
    // A stopped run goes on from its state.
    place.good("reference contact --size 48x36 --indirect --samples 128 --out more.exr");
    let more = read(&place, "more.exr").metadata["reference"]["noise_nmse2"].as_f64().unwrap();
    assert!(more < noise, "{more} {noise}");
    place.good(&format!("{SMALL} --indirect gather --out image.exr"));
    let said = place.run("compare image.exr truth.exr --json");
    assert!(said.status.success());
    let words = String::from_utf8(said.stderr).unwrap();
    assert!(words.contains("compared: layer `indirect_irradiance`"), "{words}");
}

#[test]
fn constants_are_keys_of_the_configuration() {
    let place = Place::new("indirect-keys");
    let printed = |arguments: &str| place.good(&format!("render {arguments} --print-config"));
    assert!(printed("").contains("[indirect]\nname = \"none\""));
    let chosen = printed("--indirect gather --set indirect.points=500");
    assert!(chosen.contains("[indirect]\nname = \"gather\"") && chosen.contains("points = 500"), "{chosen}");
    fs::write(place.path("all.toml"), &chosen).unwrap();
    assert_eq!(printed("--config all.toml"), chosen);
    assert_eq!(printed("--config all.toml --indirect gather"), chosen);
    assert_eq!(printed("--config all.toml --indirect none"), printed(""));
    fs::write(place.path("name.toml"), "indirect = \"lpv\"\n").unwrap();
    assert_eq!(printed("--config name.toml"), printed("--indirect lpv"));
    for (arguments, words) in [
        ("render contact --indirect radiosity", "[possible values: none, lpv, gather]"),
        ("render contact --set indirect.name=radiosity", "none, lpv, gather"),
        ("render contact --set indirect.points=3", "unknown key points of indirect"),
        (
            "render contact --indirect gather --set indirect.point=3",
            "unknown key point of indirect, expected one of",
        ),
        ("render contact --indirect lpv --device gpu", "leave out --device, or choose --indirect none"),
        (
            "render contact --config name.toml --device gpu",
            "indirect light (lpv) is computed on the CPU only",
        ),
        ("reference contact --indirect --antialias 4 --out r.exr", "--antialias"),
        ("reference contact --indirect --samples 0 --out r.exr", "0 samples"),
    ] {
        let message = place.bad(arguments);
        assert!(message.contains(words), "{arguments}: {message}");
    }
}
