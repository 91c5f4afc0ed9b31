//! The program as a user meets it: exit codes, messages, files.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail their test")]

use std::fs;
use std::process::{Command, Stdio};

use common::{Place, json};
use halflight_cpu::config::PipelineConfig;
use serde_json::Value;

mod common;

/// Outcome of a stage that GPUs have not got; without a driver it does not get that far.
const DEVICE: &str = "on the GPU|no graphics adapter";

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

const SMALL: &str = "render contact --size 48x36";

#[test]
fn an_error_to_come_down_to_and_certificates_are_reported() {
    let place = Place::new("targets");
    place.good(&format!("{SMALL} --error 1e-4 --certify --png a.png --stats s.json"));
    let stats = json(&place.path("s.json"));
    assert_eq!(stats["config"]["refiner"]["name"], "lattice");
    assert_eq!(stats["config"]["upsampler"]["name"], "lattice");
    let expected = stats["expected_nmse2"].as_f64().unwrap();
    assert!(expected > 0.0 && expected < 1e-2, "{expected}");
    let counts = stats["certified"].as_object().unwrap().values().map(|count| count.as_u64().unwrap());
    let certified: Vec<u64> = counts.collect();
    assert!(certified.iter().sum::<u64>() > 1000 && certified.iter().filter(|&&count| count > 0).count() > 1);
    for (options, words) in [
        ("--error 0", "above 0"),
        ("--error 2", "less than 1"),
        ("--error 1e-4 --samples 16", "--samples"),
        ("--certify --refiner per-pixel", "--refiner"),
        ("--certify --visibility voxel", "certifies nothing"),
    ] {
        let message = place.bad(&format!("{SMALL} {options} --png b.png"));
        assert!(message.contains(words), "{options}: {message}");
    }
}

#[test]
fn render_writes_what_it_is_asked_for_and_nothing_else() {
    let place = Place::new("render");
    place.good(&format!("{SMALL} --out a.exr --png a.png --fragment-map f.png --stats s.json"));
    assert_eq!(place.files(), ["a.exr", "a.png", "f.png", "s.json"]);

    let stats = json(&place.path("s.json"));
    let mut names = keys(&stats);
    names.sort_unstable();
    assert_eq!(
        names,
        [
            "antialias",
            "build_ms",
            "certified",
            "config",
            "expected_nmse2",
            "fragments",
            "indirect",
            "peak_bytes",
            "rays",
            "stages_ms",
            "total_ms",
            "visibility"
        ]
    );
    assert_eq!(
        (&stats["config"]["width"], &stats["config"]["refiner"]["name"]),
        (&48.into(), &"lattice".into())
    );
    let mut stages = keys(&stats["stages_ms"]);
    stages.sort_unstable();
    assert_eq!(
        stages,
        [
            "antialias",
            "certify",
            "compose",
            "gbuffer",
            "indirect",
            "irradiance",
            "pyramid",
            "refine",
            "specular",
            "upsample",
            "visibility"
        ]
    );
    let mut rays = keys(&stats["rays"]);
    rays.sort_unstable();
    assert_eq!(rays, ["final", "indirect", "refine", "skipped", "specular", "total"]);
    let count = |key: &str| stats["rays"][key].as_u64().unwrap();
    assert_eq!(count("total"), count("refine") + count("final") + count("specular"));
    // The scene is matte, and indirect light was not asked for.
    assert_eq!((count("specular"), count("indirect")), (0, 0));
    let levels = stats["fragments"]["per_level"].as_array().unwrap();
    let total: u64 = levels.iter().map(|count| count.as_u64().unwrap()).sum();
    assert_eq!(stats["fragments"]["total"].as_u64(), Some(total));
    let cells = stats["fragments"]["cells"].as_array().unwrap();
    assert!(
        cells[1..].iter().any(|count| count.as_u64().unwrap() > 0),
        "the lattice has cells above one pixel: {cells:?}"
    );
    assert!(
        total > 0 && stats["peak_bytes"].as_u64().unwrap() > 0 && stats["total_ms"].as_f64().unwrap() > 0.0
    );

    let image = halflight_image::ExrFile::read(&place.path("a.exr")).unwrap();
    assert_eq!((image.width, image.height, image.channels.len()), (48, 36, 23));
    assert_eq!(image.metadata["config"], stats["config"]);
    assert_eq!(image.metadata["scene"], "contact");
    // Some light arrives, all of it finite, and the level of every pixel that sees something is known.
    let irradiance = image.layer("irradiance").unwrap();
    assert!(irradiance.iter().all(|value| value.is_finite()) && irradiance.iter().any(|value| value.x > 0.0));
    let (depth, level) = (image.plane("depth", "Z").unwrap(), image.plane("level", "Y").unwrap());
    assert!(depth.iter().zip(level).all(|(depth, &level)| depth.is_finite() == (level >= 0.0)));
}

#[test]
fn failure_maps_say_where_voxels_are_wrong_and_why() {
    let place = Place::new("failures");
    let voxels = "render contact --size 96x72 --visibility voxel";
    place.good(&format!("{voxels} --refiner per-pixel --voxel-error-map f.png --stats s.json"));
    assert_eq!(place.files(), ["f.png", "s.json"]);
    let failures = &json(&place.path("s.json"))["voxel_failures"];
    let count = |key: &str| failures[key].as_u64().unwrap();
    let causes: u64 = ["self_occlusion", "thickness", "out_of_view", "missed"].map(count).iter().sum();
    assert_eq!(count("failures"), causes);
    // Around the box the grid is too coarse for some receivers, and most of the floor is open.
    assert!(causes > 0 && causes < count("receivers") / 2 && count("receivers") < 96 * 72, "{failures}");
    // Without a bias many receivers shade themselves, with one of a voxel few.
    let bare = "--set visibility.bias=0";
    place.good(&format!("{voxels} --refiner per-pixel {bare} --voxel-error-map f.png --stats bare.json"));
    let bare = json(&place.path("bare.json"))["voxel_failures"]["self_occlusion"].as_u64().unwrap();
    assert!(bare > 10 * count("self_occlusion"), "{bare} of {failures}");

    let message = place.bad(&format!("{voxels} --voxel-error-map g.png"));
    assert!(message.contains("lattice") && message.contains("--refiner per-pixel"), "{message}");
    let message = place.bad("render contact --refiner per-pixel --voxel-error-map g.png");
    assert!(message.contains("auto") && message.contains("--visibility voxel"), "{message}");
    assert!(!place.path("g.png").exists());
}

#[test]
fn without_an_output_option_the_picture_gets_the_name_of_the_scene() {
    let place = Place::new("default");
    place.good(SMALL);
    assert_eq!(place.files(), ["contact.png"]);
}

/// A box that is carried up, sways and turns over a floor, under a light and a camera that move as well.
const MOVING: &str = r#"
[camera]
eye = [0.5, 1.6, 3.2]
target = [0, 0.4, 0]
fov_y_deg = 45

[[light]]
corner = [-0.5, 3, -0.5]
edge_u = [1, 0, 0]
edge_v = [0, 0, 1]
radiance = [10, 10, 10]

[[mesh]]
generator = "contact"

[[mesh]]
generator = "contact"
transform = { scale = 0.5, translate = [0, 0.6, 0.8] }

[animation.camera]
keys = [{ time = 1, eye = [1.0, 1.6, 3.0] }]

[[animation.light]]
keys = [{ time = 1, translate = [1, 0, 0], rotate_deg = 40 }]

[[animation.mesh]]
mesh = 1
keys = [{ time = 1, translate = [0, 0.5, 0], rotate_deg = 90 }]
sway = { amplitude = [0.3, 0, 0.2], period = 2 }
"#;

#[test]
fn a_frame_is_the_same_by_itself_and_among_others() {
    let place = Place::new("frames");
    fs::create_dir(place.path("one")).unwrap();
    fs::write(place.path("moving.toml"), MOVING).unwrap();
    let read = |name: &str| halflight_image::ExrFile::read(&place.path(name)).unwrap();
    // Raster4d keeps bins, voxels keep a grid: nothing of them may be left over from the frame before.
    for options in ["", "--visibility beam --refiner lattice", "--visibility raster4d", "--visibility voxel"]
    {
        let moving = format!("render moving.toml --size 48x36 --fps 4 {options}");
        place.good(&format!("{moving} --frames 4 --out all.exr --stats all.json"));
        place.good(&format!("{moving} --frames 3..4 --out one/k.exr"));
        let (frame, alone) = (read("all-0003.exr"), read("one/k-0003.exr"));
        assert!(frame.channels == alone.channels && frame.metadata == alone.metadata, "{options}");
        assert_eq!(frame.metadata["moment"], serde_json::json!({ "frame": 3, "time_s": 0.75 }));
        let stats = json(&place.path("all-0003.json"));
        assert!(stats["frame"] == 3 && stats["time_s"] == 0.75 && stats["move_ms"].as_f64().unwrap() > 0.0);
        // Frame 0 is the scene as it stands, and things do move.
        place.good(&format!("render moving.toml --size 48x36 {options} --out still.exr"));
        assert!(read("all-0000.exr").channels == read("still.exr").channels, "{options}");
        assert!(read("all-0001.exr").channels != read("still.exr").channels, "{options}");
    }
    let names = ["all-0000.exr", "all-0000.json", "all-0001.exr", "all-0001.json", "all-0002.exr"];
    assert_eq!(place.files()[..5], names);
}

#[test]
fn frames_are_numbered_before_the_ending() {
    let place = Place::new("numbers");
    fs::write(place.path("moving.toml"), MOVING).unwrap();
    let said = place.run("render moving.toml --size 16x12 --frames 2");
    let said = String::from_utf8(said.stderr).unwrap();
    assert_eq!(place.files(), ["moving-0000.png", "moving-0001.png", "moving.toml"]);
    assert!(
        said.contains("frame 1, 0.042 s: ") && said.contains("wrote moving-0000.png to moving-0001.png"),
        "{said}"
    );
    place.good("render moving.toml --size 16x12 --frames 99999..100000 --fps 10 --fragment-map a.b.png");
    assert!(place.path("a.b-99999.png").is_file());
    assert!(place.good("info moving.toml").contains("animation  camera, 1 light, 1 mesh; last key at 1 s"));
}

#[test]
fn the_image_does_not_depend_on_the_threads_and_does_on_the_seed() {
    let place = Place::new("threads");
    for (threads, seed, name) in [(1, 0, "a.exr"), (3, 0, "b.exr"), (1, 1, "c.exr")] {
        place.good(&format!("{SMALL} --threads {threads} --seed {seed} --out {name}"));
    }
    let channels = |name: &str| halflight_image::ExrFile::read(&place.path(name)).unwrap().channels;
    assert!(channels("a.exr") == channels("b.exr"));
    assert!(channels("a.exr") != channels("c.exr"));
}

#[test]
fn a_configuration_is_printed_read_back_and_overridden() {
    let place = Place::new("config");
    let printed = place.good(
        "render --refiner nichols --upsampler delaunay --shading sampled --samples 16 --pattern grid \
         --sharing frame --seed 9 --size 48x36 --set refiner.visibility_threshold=0.25 --print-config",
    );
    for line in [
        "width = 48",
        "name = \"delaunay\"",
        "shading = \"sampled\"",
        "seed = 9",
        "name = \"nichols\"",
        "visibility_threshold = 0.25",
        "count = 16",
        "kind = \"grid\"",
        "sharing = \"frame\"",
    ] {
        assert!(printed.lines().any(|found| found == line), "{line} is not in\n{printed}");
    }
    fs::write(place.path("all.toml"), &printed).unwrap();
    assert_eq!(place.good("render --config all.toml --print-config"), printed);
    // A part is enough, in TOML or JSON; what a refiner's file says is kept where the option names the same refiner.
    fs::write(place.path("part.json"), r#"{"refiner": {"name": "nichols", "interleaved": true}, "seed": 3}"#)
        .unwrap();
    let both = place.good("render --config part.json --refiner nichols --seed 4 --print-config");
    assert!(both.contains("interleaved = true") && both.contains("seed = 4"), "{both}");
    place.good("render contact --config all.toml --stats s.json");
    assert_eq!(json(&place.path("s.json"))["config"]["refiner"]["visibility_threshold"], 0.25);
}

#[test]
fn a_refiner_brings_its_upsampler_and_samples_end_the_error_target() {
    let place = Place::new("defaults");
    let printed = |arguments: &str| place.good(&format!("render {arguments} --print-config"));
    let plain = printed("");
    let library: PipelineConfig = toml::from_str(&plain).unwrap();
    // The program antialiases at this quality.
    assert_eq!(library, PipelineConfig { antialias: 8, ..PipelineConfig::default() });
    assert!(plain.contains("target = 0.0001") || plain.contains("target = 9.99"), "{plain}");
    for (arguments, upsampler) in [
        ("--refiner sfvt-gass", "rbf-robust"),
        ("--refiner nichols", "rbf-robust"),
        ("--set refiner.name=nichols", "rbf-robust"),
        ("--refiner per-pixel", "bilinear"),
        ("--refiner lattice", "lattice"),
        ("--refiner per-pixel --upsampler delaunay", "delaunay"),
        ("--upsampler delaunay --set refiner.name=per-pixel", "delaunay"),
    ] {
        let found = printed(arguments);
        assert!(found.contains(&format!("[upsampler]\nname = \"{upsampler}\"")), "{arguments}:\n{found}");
    }
    fs::write(place.path("chosen.toml"), "upsampler = \"rbf-fixed\"\n").unwrap();
    assert!(
        printed("--config chosen.toml --refiner per-pixel").contains("[upsampler]\nname = \"rbf-fixed\"")
    );
    // Options keep what a file has chosen.
    fs::write(place.path("half.toml"), "[refiner]\ntarget = 0.5\nerror = 0.25\n").unwrap();
    for arguments in ["--certify", "--refiner lattice", "--samples 16"] {
        let found = printed(&format!("--config half.toml {arguments}"));
        assert!(found.contains("target = 0.5") && found.contains("error = 0.25"), "{arguments}:\n{found}");
    }
    assert!(printed("--certify").contains("target = 0.0\n"));
    // Samples or stages that are asked for end the default target.
    for arguments in ["--samples 16", "--set sampling.count=16", "--refiner lattice", "--shading sampled"] {
        let found = printed(arguments);
        assert!(found.contains("target = 0.0\n"), "{arguments}:\n{found}");
    }
    // Names of version 0.1.
    let old = printed("--set refiner.rise.crease_deg=12");
    assert!(
        old.contains("crease_deg = 12.0") && old == printed("--set refiner.discontinuity.crease_deg=12"),
        "{old}"
    );
    fs::write(place.path("full.toml"), "[refiner]\nname = \"full\"\n").unwrap();
    for arguments in ["--refiner full", "--set refiner.name=full", "--config full.toml"] {
        assert_eq!(printed(arguments), printed("--refiner per-pixel"), "{arguments}");
    }
    place.good("render contact --size 16x12 --visibility voxel --refiner per-pixel --failure-map old.png");
    assert!(place.path("old.png").exists());
    fs::write(place.path("seed.toml"), "seed = 3\n").unwrap();
    fs::write(place.path("target.toml"), "[refiner]\ntarget = 0.5\n[sampling]\ncount = 16\n").unwrap();
    assert!(!printed("--config seed.toml").contains("target = 0.0\n"));
    assert!(printed("--config target.toml --samples 25").contains("target = 0.5"));
}

#[test]
fn wrong_input_is_refused_in_words() {
    let place = Place::new("wrong");
    fs::write(place.path("bad.toml"), "seed = 1\n[refiner]\nname = \"sfvt-gass\"\ncoarse = 2\n").unwrap();
    fs::write(place.path("torn.toml"), "seed = \n").unwrap();
    fs::write(place.path("scene.toml"), "[camera]\neye = [0, 0, 0]\n").unwrap();
    fs::write(place.path("text.exr"), "not an image").unwrap();
    for (arguments, expected) in [
        ("render nowhere", "no scene `nowhere`"),
        ("render nowhere", "atrium, nave"),
        ("render scene.toml", "scene.toml:1"),
        ("render contact --size 0x10", "0x10 pixels"),
        ("render contact --size big", "expected WIDTHxHEIGHT"),
        ("render contact --samples 0", "1 to 4096"),
        ("render contact --samples 5000", "5000 light samples"),
        ("render contact --threads 0", "--threads"),
        ("render contact --refiner best", "[possible values: nichols, sfvt-gass, per-pixel, lattice]"),
        ("render contact --upsampler best", "rbf-robust"),
        ("render contact --colour red", "'--colour'"),
        ("render contact --exposure=-1", "number above 0"),
        ("render nave --frames 0", "expected a number of frames, such as 48"),
        ("render nave --frames 5..5", "or a range A..B, such as 10..20"),
        ("render nave --frames 3 --fps 0", "frames a second from 0.001"),
        ("render nave --fps 12", "--frames"),
        ("render contact --frames 2", "contact has no [animation]"),
        ("render nave --frames 2 --device gpu", "--frames and --voxel-error-map are for the CPU"),
        ("render contact --device tpu", "[possible values: cpu, gpu]"),
        ("render contact --device gpu --upsampler delaunay --refiner nichols", DEVICE),
        ("render", "<SCENE>"),
        ("render contact --config none.toml", "none.toml"),
        ("render contact --config bad.toml", "bad.toml: unknown key coarse of refiner, expected one of"),
        ("render contact --config torn.toml", "line 1"),
        ("render contact --set seed=lots", "--set seed=lots: seed is \"lots\": "),
        ("render contact --set refiner.name=best", "nichols, sfvt-gass, per-pixel"),
        ("render contact --set refiner=per-pixel", "refiner is \"per-pixel\", expected a table"),
        ("render contact --set seed", "expected KEY=VALUE"),
        (
            "render contact --size 48x36 --png no/such/folder.png",
            "no/such/folder.png: there is no folder no/such",
        ),
        ("info nowhere", "no scene `nowhere`"),
        ("reference contact --samples 0 --out r.exr", "0 samples"),
        ("reference contact", "--out"),
        ("compare none.exr none.exr", "cannot read none.exr"),
        ("compare text.exr text.exr", "text.exr is not a complete OpenEXR image"),
        ("unknown", "unknown"),
    ] {
        let message = place.bad(arguments);
        assert!(expected.split('|').any(|one| message.contains(one)), "{arguments}: {message}");
    }
    // Nothing was written on the way.
    assert_eq!(place.files(), ["bad.toml", "scene.toml", "text.exr", "torn.toml"]);
}

#[test]
fn graphics_devices_render_what_the_processor_does() {
    let place = Place::new("device");
    let small = "render contact --size 48x36 --refiner per-pixel --samples 16 --visibility bvh";
    let output =
        place.run(&format!("{small} --device gpu --out gpu.exr --fragment-map f.png --stats s.json"));
    if !output.status.success() {
        let message = String::from_utf8(output.stderr).unwrap();
        let required = std::env::var_os("HALFLIGHT_REQUIRE_GPU").is_some_and(|value| value == "1");
        assert!(message.contains("no graphics adapter") && !required, "{message}");
        eprintln!("skipped: {message}");
        return;
    }
    assert!(json(&place.path("s.json"))["rays"]["final"].as_u64().unwrap() > 1000);
    place.good(&format!("{small} --out cpu.exr"));
    let error: Value = serde_json::from_str(&place.good("compare gpu.exr cpu.exr --json")).unwrap();
    // Pixels whose centre lies within rounding of an edge may see another triangle: a few of 1,728 here.
    assert!(error["nmse2"].as_f64().unwrap() < 1e-4, "{error}");
    // Each is held against itself: voxels are approximate, and 4D rasterization has samples in rows.
    for backend in ["voxel", "raster4d"] {
        let small = small.replace("bvh", backend);
        place.good(&format!("{small} --device gpu --out one.exr"));
        place.good(&format!("{small} --out two.exr"));
        let error: Value = serde_json::from_str(&place.good("compare one.exr two.exr --json")).unwrap();
        assert!(error["nmse2"].as_f64().unwrap() < 1e-4, "{backend}: {error}");
    }
    // Defaults, but for validation: GPUs validate nothing.
    for device in ["gpu", "cpu"] {
        let plain = format!(
            "render contact --size 96x72 --device {device} --error 1e-4 --set refiner.validate=false"
        );
        place.good(&format!("{plain} --out {device}-plain.exr --stats {device}.json"));
    }
    let expected = ["gpu.json", "cpu.json"].map(|name| json(&place.path(name))["expected_nmse2"].as_f64());
    // Rasterized surfaces differ by pixels at outlines, of which an image as small as this has many.
    let [Some(found), Some(expected)] = expected else { panic!("{expected:?}") };
    assert!(found > 0.8 * expected && found < 1.25 * expected, "{found} {expected}");
    let error: Value =
        serde_json::from_str(&place.good("compare gpu-plain.exr cpu-plain.exr --json")).unwrap();
    assert!(error["nmse2"].as_f64().unwrap() < 1e-3, "{error}");
    place.good(&format!("{small} --seed 3 --out other.exr"));
    let other: Value = serde_json::from_str(&place.good("compare other.exr cpu.exr --json")).unwrap();
    assert!(other["nmse2"].as_f64().unwrap() > 1e-4, "{other}");
}

#[test]
fn compare_knows_equal_images_from_different_ones() {
    let place = Place::new("compare");
    place.good(&format!("{SMALL} --refiner per-pixel --out truth.exr"));
    place.good(&format!("{SMALL} --refiner per-pixel --samples 4 --seed 1 --out noisy.exr"));
    place.good("render contact --size 47x36 --out narrow.exr");
    let errors = |arguments: &str| -> Value { serde_json::from_str(&place.good(arguments)).unwrap() };

    let same = errors("compare truth.exr truth.exr --json");
    let mut names = keys(&same);
    names.sort_unstable();
    let known =
        ["flip", "flip_p99", "grain", "max", "nmse", "nmse2", "psnr", "relmse", "rmse", "sse", "ssim"];
    assert_eq!(names, known);
    assert_eq!((&same["sse"], &same["psnr"], &same["ssim"]), (&0.0.into(), &Value::Null, &1.0.into()));
    assert_eq!((&same["flip_p99"], &same["grain"]), (&0.0.into(), &0.0.into()));
    let noisy = errors("compare noisy.exr truth.exr --json --error-map error.png");
    assert!(noisy["nmse2"].as_f64().unwrap() > 0.0 && noisy["ssim"].as_f64().unwrap() < 1.0);
    assert!(place.path("error.png").is_file());
    let table = place.good("compare noisy.exr truth.exr");
    assert_eq!(table.lines().count(), known.len(), "{table}");
    let grain = table.lines().find_map(|line| line.strip_prefix("grain ")).unwrap();
    assert!(grain.trim().parse::<f64>().unwrap() > 0.0, "{table}");
    // Geometry is the same whatever the number of samples.
    assert_eq!(errors("compare noisy.exr truth.exr --layer normal --json")["sse"], 0.0);

    let message = place.bad("compare narrow.exr truth.exr");
    assert!(message.contains("47×36 against 48×36"), "{message}");
    let message = place.bad("compare noisy.exr truth.exr --layer specular");
    assert!(message.contains("no layer `specular`") && message.contains("irradiance.R"), "{message}");
}

#[test]
fn reference_says_its_noise_and_goes_on_where_it_was() {
    let place = Place::new("reference");
    place.good("reference contact --size 48x36 --samples 512 --out few.exr");
    place.good("reference contact --size 48x36 --samples 1024 --out more.exr");
    place.good("reference contact --size 48x36 --samples 1024 --cache other --out fresh.exr");
    let read = |name: &str| halflight_image::ExrFile::read(&place.path(name)).unwrap();
    let (few, more, fresh) = (read("few.exr"), read("more.exr"), read("fresh.exr"));
    assert!(more.channels == fresh.channels && few.channels != more.channels);
    assert_eq!(few.metadata["reference"]["samples"], 512);
    let noise = |file: &halflight_image::ExrFile| file.metadata["reference"]["noise_nmse2"].as_f64().unwrap();
    assert!(noise(&few) > noise(&more) && noise(&more) > 0.0);
    // An image of the pipeline can be set against it.
    place.good(&format!("{SMALL} --out image.exr"));
    place.good("compare image.exr more.exr");
}

#[test]
fn scenes_info_help_and_completions_are_printed() {
    let place = Place::new("print");
    let scenes = place.good("scenes");
    assert_eq!(scenes.lines().count(), halflight_scene::bundled().len());
    // A name and what the scene's file says about it.
    assert!(scenes.lines().all(|line| line.split_whitespace().count() >= 3), "{scenes}");
    let info = place.good("info contact");
    for word in ["triangles", "bounds", "light 0", "materials", "textures", "BVH", "warnings   0"] {
        assert!(info.contains(word), "{word} is not in\n{info}");
    }
    // A lamp in the ceiling's plane, of an emissive face and by a [[light]].
    fs::write(
        place.path("lamp.obj"),
        "mtllib lamp.mtl\nv -2 2 -2\nv 2 2 -2\nv 2 2 2\nv -2 2 2\nv -1 2 -1\nv 1 2 -1\nv 1 2 1\nv -1 2 1\n\
         usemtl ceiling\nf 1 2 3 4\nusemtl lamp\nf 5 6 7 8\n",
    )
    .unwrap();
    fs::write(place.path("lamp.mtl"), "newmtl ceiling\nKd 0.5\nnewmtl lamp\nKe 9\n").unwrap();
    let camera = "[camera]\neye = [0, 0, 3]\ntarget = [0, 1, 0]\nfov_y_deg = 50\n";
    let light =
        "[[light]]\ncorner = [-9, 3, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [1, 1, 1]\n";
    let mesh = "[[mesh]]\nfile = \"lamp.obj\"\nemissive = \"lights\"\n";
    fs::write(place.path("lamp.toml"), format!("{camera}{light}{mesh}")).unwrap();
    let info = place.good("info lamp.toml");
    let lights: Vec<&str> = info.lines().filter(|line| line.starts_with("light ")).collect();
    assert_eq!(lights.len(), 2, "{info}");
    assert!(!lights[0].contains("visible") && !lights[0].contains("flush"), "{info}");
    assert!(lights[1].contains(", visible") && lights[1].contains(", flush with 4 triangles"), "{info}");
    assert!(info.contains("warnings   1"), "{info}");
    assert!(place.good("--help").contains("Examples:"));
    assert!(place.good("render --help").contains("SCENE.png"));
    assert!(place.good("completions bash").contains("fragment-map"));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let place = Place::new("pipe");
    let mut child = Command::new(env!("CARGO_BIN_EXE_halflight"))
        .args(["completions", "zsh"])
        .current_dir(place.path(""))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}
