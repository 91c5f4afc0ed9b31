//! Sizes and numbers that cannot work, and frames that no light reaches.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail their test")]

use std::fs;

use common::{Place, failed};

mod common;

#[test]
fn absurd_numbers_are_refused_or_lowered() {
    let place = Place::new("absurd");
    for (arguments, words) in [
        ("render contact --size 40000x10", "40000x10 pixels cannot be rendered"),
        ("render contact --size 4294967295x4294967295", "both sides must be 1 to 32768"),
        ("render contact --size 99999999999x10", "expected WIDTHxHEIGHT"),
        ("reference contact --size 40000x10 --out r.exr", "both sides must be 1 to 32768"),
        ("reference contact --samples 4294967295 --out r.exr", "1 to 1073741824"),
        ("render contact --samples 4294967295", "1 to 4096"),
        ("render nave --frames 4294967295", "4294967295 frames are more than 1000000: render them in parts"),
        ("render contact --threads 0", "--threads"),
        ("render contact --threads 100000", "--threads"),
    ] {
        let message = place.bad(arguments);
        assert!(message.contains(words), "{arguments}: {message}");
    }
    assert_eq!(place.files(), [""; 0]);
    let output = place.run("render contact --size 16x12 --threads 10000");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.contains("threads are used instead of 10000"), "{said}");
}

/// Limits of the address space, which the sanitizers of other systems would not survive.
#[cfg(target_os = "linux")]
#[test]
fn images_that_do_not_fit_into_memory_are_refused_with_their_size() {
    let place = Place::new("memory");
    place.good("render contact --size 16x12 --out small.exr");
    for (arguments, words) in [
        (
            "render contact --size 20000x20000 --png a.png",
            "an image of 20000x20000 pixels (lattice) takes about",
        ),
        (
            "render contact --size 3000x3000 --refiner per-pixel --samples 4096 --png a.png",
            "3000x3000 pixels (per-pixel)",
        ),
        ("reference contact --size 20000x20000 --samples 1 --out a.exr", "a reference of 20000x20000 pixels"),
    ] {
        let output = place.shell(&format!("ulimit -v 3145728; \"$H\" {arguments}"));
        let message = failed(arguments, &output);
        assert_eq!(output.status.code(), Some(1));
        assert!(message.contains(words) && message.contains("can be had"), "{arguments}: {message}");
    }
    // Wherever memory ends, the program ends in words.
    for megabytes in [60, 100, 200, 400] {
        let arguments = "render contact --size 1500x1500 --refiner per-pixel --samples 4096 --png a.png";
        let output = place.shell(&format!("ulimit -v {}; \"$H\" {arguments}", megabytes * 1000));
        assert_eq!(failed(arguments, &output).lines().filter(|line| line.starts_with("error: ")).count(), 1);
    }
    assert_eq!(place.files(), ["small.exr"]);
}

#[test]
fn a_frame_that_no_light_reaches_is_black_and_said_to_be() {
    let place = Place::new("unlit");
    let scene = |light: &str| {
        let text = format!(
            "[camera]\neye = [0, 1.5, 4]\ntarget = [0, 0.5, 0]\nfov_y_deg = 45\n[[light]]\n{light}\n[[mesh]]\n\
             generator = \"contact\"\n"
        );
        fs::write(place.path("scene.toml"), text).unwrap();
    };
    for (light, words) in [
        (
            "corner = [0, 3, 0]\nedge_u = [0, 0, 1]\nedge_v = [1, 0, 0]\nradiance = [9, 9, 9]",
            "swap edge_u and edge_v",
        ),
        (
            "corner = [0, 3, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [0, 0, 0]",
            "has no radiance",
        ),
    ] {
        scene(light);
        for command in [
            "render scene.toml --size 16x12 --out a.exr",
            "reference scene.toml --size 16x12 --samples 1 --out a.exr",
        ] {
            let output = place.run(command);
            let said = String::from_utf8(output.stderr).unwrap();
            assert!(output.status.success(), "{command}: {said}");
            let warning = "warning: no light reaches any visible surface: light 0 ";
            assert!(said.contains(warning) && said.contains(words), "{command}: {said}");
        }
        let message = place.bad("compare a.exr a.exr --layer irradiance");
        assert!(message.contains("zero at every pixel"), "{message}");
    }
}
