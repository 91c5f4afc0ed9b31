//! Outputs: links, pipes, standard output, devices, and files that must not be lost.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "helpers of tests fail their test")]

use std::fs::{self, File};
use std::io::Read;
use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
use std::thread;

use common::{Place, failed};

mod common;

const SMALL: &str = "render contact --size 16x12";

/// Every option of an output, in a command that takes it.
const OUTPUTS: [&str; 7] = [
    "render contact --size 16x12 --out",
    "render contact --size 16x12 --png",
    "render contact --size 16x12 --fragment-map",
    "render contact --size 16x12 --visibility voxel --refiner per-pixel --voxel-error-map",
    "render contact --size 16x12 --stats",
    "reference contact --size 16x12 --samples 1 --cache state --out",
    "compare image.exr truth.exr --error-map",
];

/// A folder with images to compare.
fn place(test: &str) -> Place {
    let place = Place::new(test);
    place.good("render contact --size 16x12 --refiner per-pixel --samples 4 --out image.exr");
    place.good("render contact --size 16x12 --refiner per-pixel --samples 64 --out truth.exr");
    place
}

/// Tells whether bytes are of the kind that the option asks for.
fn is_right(option: &str, bytes: &[u8]) -> bool {
    match option {
        option if option.ends_with("--out") => bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]),
        option if option.ends_with("--stats") => bytes.starts_with(b"{") && bytes.ends_with(b"}\n"),
        _ => bytes.starts_with(b"\x89PNG"),
    }
}

#[test]
fn every_output_goes_through_links_into_pipes_and_to_standard_output() {
    let place = place("every-output");
    fs::create_dir(place.path("store")).unwrap();
    for option in OUTPUTS {
        fs::write(place.path("store/a"), "before").unwrap();
        fs::set_permissions(place.path("store/a"), fs::Permissions::from_mode(0o600)).unwrap();
        let _ = fs::remove_file(place.path("link"));
        symlink("store/a", place.path("link")).unwrap();
        place.good(&format!("{option} link"));
        assert!(fs::symlink_metadata(place.path("link")).unwrap().is_symlink(), "{option}");
        assert!(is_right(option, &fs::read(place.path("store/a")).unwrap()), "{option}");
        assert_eq!(fs::metadata(place.path("store/a")).unwrap().permissions().mode() & 0o777, 0o600);

        assert!(place.shell("rm -f pipe; mkfifo pipe").status.success());
        let path = place.path("pipe");
        let reader = thread::spawn(move || {
            let mut read = Vec::new();
            File::open(path).unwrap().read_to_end(&mut read).unwrap();
            read
        });
        place.good(&format!("{option} pipe"));
        assert!(is_right(option, &reader.join().unwrap()), "{option}");
        assert!(fs::metadata(place.path("pipe")).unwrap().file_type().is_fifo(), "{option}");

        for standard in ["-", "/dev/stdout"] {
            let output = place.run(&format!("{option} {standard}"));
            assert!(output.status.success() && is_right(option, &output.stdout), "{option} {standard}");
        }
        place.good(&format!("{option} /dev/null"));
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    }
    assert_eq!(place.files(), ["image.exr", "link", "pipe", "state", "store", "truth.exr"]);
}

#[test]
fn every_output_that_cannot_be_written_is_an_error_in_words() {
    let place = place("no-output");
    fs::create_dir(place.path("folder")).unwrap();
    for option in OUTPUTS {
        for (path, words) in [
            ("folder", "cannot write folder: it is a folder"),
            ("none/a", "there is no folder none"),
            ("truth.exr/a", "Not a directory"),
            ("", "a value is required|the path names no file"),
        ] {
            let message = place.bad(&format!("{option} {path}"));
            assert!(words.split('|').any(|words| message.contains(words)), "{option} {path}: {message}");
        }
        if cfg!(target_os = "linux") {
            let message = place.bad(&format!("{option} /dev/full"));
            assert!(message.contains("cannot write /dev/full: No space left"), "{option}: {message}");
            let message = failed(option, &place.shell(&format!("\"$H\" {option} - > /dev/full")));
            assert!(message.contains("No space left"), "{option}: {message}");
        }
    }
    let message = place.bad("reference contact --size 16x12 --cache truth.exr --out a.exr");
    assert!(message.contains("truth.exr"), "{message}");
    assert_eq!(place.files(), ["folder", "image.exr", "state", "truth.exr"]);
}

#[test]
fn what_is_there_survives_a_full_disk() {
    let place = Place::new("full-disk");
    fs::write(place.path("plain.exr"), "before").unwrap();
    fs::write(place.path("hard.exr"), vec![7; 300_000]).unwrap();
    fs::hard_link(place.path("hard.exr"), place.path("twin.exr")).unwrap();
    for name in ["plain.exr", "hard.exr", "new.exr"] {
        // The limit, of 4 or 8 KiB, stands for a disk that is full.
        let output = place.shell(&format!("ulimit -f 8; \"$H\" {SMALL} --out {name}"));
        let message = failed(name, &output);
        assert!(message.contains(&format!("cannot write {name}")), "{message}");
    }
    assert_eq!(fs::read(place.path("plain.exr")).unwrap(), b"before");
    assert_eq!(fs::read(place.path("twin.exr")).unwrap(), vec![7; 300_000]);
    assert_eq!(place.files(), ["hard.exr", "plain.exr", "twin.exr"]);
}

#[test]
fn outputs_do_not_overwrite_each_other_or_what_is_read() {
    let place = place("overwriting");
    let scene = "[camera]\neye = [0, 3, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\nfov_y_deg = 50\n[[light]]\n\
        corner = [-0.5, 2, -0.5]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [10, 10, 10]\n\
        texture = \"screen.png\"\n[[mesh]]\nfile = \"floor.obj\"\n";
    let floor = "mtllib floor.mtl\nusemtl wood\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3 4\n";
    fs::create_dir(place.path("sub")).unwrap();
    fs::write(place.path("sub/scene.toml"), scene).unwrap();
    fs::write(place.path("sub/floor.obj"), floor).unwrap();
    fs::write(place.path("sub/floor.mtl"), "newmtl wood\nmap_Kd wood.png\n").unwrap();
    place.good("render contact --size 8x8 --refiner per-pixel --samples 4 --png sub/screen.png");
    fs::copy(place.path("sub/screen.png"), place.path("sub/wood.png")).unwrap();
    fs::write(place.path("seed.toml"), "seed = 1\n").unwrap();
    symlink("sub/floor.obj", place.path("link")).unwrap();
    let before = place.files();
    for (arguments, words) in [
        (&*format!("{SMALL} --out a --png a"), "--out and --png both write to a"),
        (&format!("{SMALL} --png a --stats ./sub/../a"), "--png and --stats both write to ./sub/../a"),
        (&format!("{SMALL} --png - --out -"), "--out and --png both write to standard output"),
        (&format!("{SMALL} --png - --stats /dev/stdout"), "--png and --stats both write to standard output"),
        ("render sub/scene.toml --png sub/scene.toml", "--png would overwrite sub/scene.toml"),
        ("render sub/scene.toml --png sub/floor.obj", "would overwrite sub/floor.obj"),
        ("render sub/scene.toml --png sub/screen.png", "--png would overwrite sub/screen.png"),
        ("render sub/scene.toml --png sub/wood.png", "--png would overwrite sub/wood.png"),
        ("render sub/scene.toml --stats sub/floor.mtl", "--stats would overwrite sub/floor.mtl"),
        ("render sub/scene.toml --fragment-map link", "would overwrite sub/floor.obj"),
        ("render contact --config seed.toml --stats seed.toml", "would overwrite seed.toml"),
        ("reference sub/scene.toml --out sub/floor.obj", "--out would overwrite sub/floor.obj"),
        ("compare image.exr truth.exr --error-map truth.exr", "--error-map would overwrite truth.exr"),
        ("compare image.exr truth.exr --error-map ./image.exr", "would overwrite image.exr"),
        ("compare image.exr truth.exr --error-map - --json", "both write to standard output"),
    ] {
        let message = place.bad(arguments);
        assert!(message.contains(words), "{arguments}: {message}");
    }
    assert_eq!(place.files(), before);
    assert_eq!(fs::read_to_string(place.path("sub/floor.obj")).unwrap(), floor);
    // Devices keep nothing that could be lost.
    place.good(&format!("{SMALL} --png /dev/null --out /dev/null"));
}

#[test]
fn pipes_take_all_frames_of_an_animation() {
    let place = Place::new("frame-stream");
    let count = |bytes: &[u8]| bytes.windows(4).filter(|window| window == b"\x89PNG").count();
    let frames = "render nave --size 16x12 --refiner per-pixel --samples 4 --frames 3 --png";
    let output = place.run(&format!("{frames} -"));
    assert_eq!(count(&output.stdout), 3, "{}", String::from_utf8_lossy(&output.stderr));
    let output = place.shell(&format!("mkfifo pipe; cat pipe & \"$H\" {frames} pipe; wait"));
    assert_eq!(count(&output.stdout), 3, "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(place.files(), ["pipe"]);
}

#[test]
fn figures_make_way_for_a_picture_on_standard_output() {
    let place = place("figures");
    let output = place.run("compare image.exr truth.exr --error-map -");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.stdout.starts_with(b"\x89PNG") && said.contains("nmse2"), "{said}");
}
