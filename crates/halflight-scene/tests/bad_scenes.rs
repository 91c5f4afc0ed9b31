//! Faulty scene files, each with its message.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "helpers of tests")]

mod common;

use common::Folder;

const GOOD: &str = r#"description = "a triangle"

[camera]
eye = [0, 1, 5]
target = [0, 0, 0]
up = [0, 1, 0]
fov_y_deg = 45

[[light]]
corner = [0, 3, 0]
edge_u = [1, 0, 0]
edge_v = [0, 0, 1]
radiance = [1, 1, 1]
two_sided = false

[[mesh]]
file = "good.obj"
transform = { translate = [0, 1, 0], rotate_deg = [0, 90, 0], scale = 2 }
albedo = [0.5, 0.5, 0.5]
"#;

/// Text to replace in the valid file, and its replacement.
const BAD: &[(&str, &str)] = &[
    ("[camera]\n", "[camera\n"),
    ("eye = [0, 1, 5]", "eye = [0, 1, 5"),
    ("description = \"a triangle\"", "description = 7"),
    ("description", "title"),
    ("[camera]\neye = [0, 1, 5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nfov_y_deg = 45\n", ""),
    ("eye = [0, 1, 5]\n", ""),
    ("eye = [0, 1, 5]", "eye = [0, 1]"),
    ("eye = [0, 1, 5]", "eye = [0, nan, 5]"),
    ("eye = [0, 1, 5]", "eye = [0, 1e40, 5]"),
    ("eye = [0, 1, 5]", "eye = \"0 1 5\""),
    ("eye = [0, 1, 5]", "eye = [0, 0, 0]"),
    ("up = [0, 1, 0]", "up = [0, -2, -10]"),
    ("up = [0, 1, 0]", "up = [0, 0, 0]"),
    ("fov_y_deg = 45", "fov_y_deg = 180"),
    ("fov_y_deg = 45", "fov_y_deg = -1"),
    ("fov_y_deg = 45", "fov_y_deg = \"wide\""),
    ("fov_y_deg = 45", "fov = 45"),
    ("fov_y_deg = 45", "fov_y_deg = 45\nfov_y_deg = 46"),
    ("[[light]]", "[light]"),
    ("[[light]]", "[[lamp]]"),
    ("edge_v = [0, 0, 1]", "edge_v = [2, 0, 0]"),
    ("edge_v = [0, 0, 1]", "edge_v = [0, 0, 0]"),
    ("edge_v = [0, 0, 1]\n", ""),
    ("radiance = [1, 1, 1]", "radiance = [1, -1, 1]"),
    ("radiance = [1, 1, 1]", "radiance = [inf, 1, 1]"),
    ("two_sided = false", "two_sided = \"no\""),
    ("two_sided = false", "twosided = true"),
    (
        "[[light]]\ncorner = [0, 3, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [1, 1, 1]\ntwo_sided = false\n",
        "",
    ),
    (
        "[[mesh]]\nfile = \"good.obj\"\ntransform = { translate = [0, 1, 0], rotate_deg = [0, 90, 0], scale = 2 }\nalbedo = [0.5, 0.5, 0.5]\n",
        "",
    ),
    ("file = \"good.obj\"\n", ""),
    ("file = \"good.obj\"", "file = 3"),
    ("file = \"good.obj\"", "fiel = \"good.obj\""),
    ("file = \"good.obj\"", "file = \"missing.obj\""),
    ("file = \"good.obj\"", "file = \"good.fbx\""),
    ("file = \"good.obj\"", "file = \"flat.obj\""),
    ("file = \"good.obj\"", "file = \"good.obj\"\ngenerator = \"contact\""),
    ("file = \"good.obj\"", "generator = \"cathedral\""),
    ("file = \"good.obj\"", "generator = \"contact\"\n\ncolour = 1"),
    ("scale = 2", "scale = 0"),
    ("scale = 2", "scale = [1, 0, 1]"),
    ("scale = 2", "scale = [1, 2]"),
    ("scale = 2", "size = 2"),
    ("rotate_deg = [0, 90, 0]", "rotate_deg = 90"),
    ("translate = [0, 1, 0]", "translate = [0, 3e38, 0], translate_ = 1"),
    ("transform = {", "transform = [1] #"),
    ("scale = 2", "scale = 3e38"),
    ("albedo = [0.5, 0.5, 0.5]", "albedo = [0.5, 0.5, 1.5]"),
    ("albedo = [0.5, 0.5, 0.5]", "albedo = 0x7f"),
    ("albedo = [0.5, 0.5, 0.5]", "smooth = true"),
    ("albedo = [0.5, 0.5, 0.5]", "smooth = \"yes\""),
    ("albedo = [0.5, 0.5, 0.5]", "smooth = \"on\"\ncrease_deg = 200"),
    ("albedo = [0.5, 0.5, 0.5]", "crease_deg = 30"),
    ("albedo = [0.5, 0.5, 0.5]", "alpha = \"map_Kd\""),
    ("albedo = [0.5, 0.5, 0.5]", "alpha = 1"),
    ("albedo = [0.5, 0.5, 0.5]", "alpha_cutoff = 1.5"),
    ("albedo = [0.5, 0.5, 0.5]", "alpha_cutoff = -0.1"),
    ("albedo = [0.5, 0.5, 0.5]", "alpha = \"none\"\nalpha_cutoff = 0.5"),
    ("albedo = [0.5, 0.5, 0.5]", "albedo = [0.5, 0.5, 0.5]\nalpha = \"none\""),
    ("file = \"good.obj\"", "generator = \"contact\"\nalpha_cutoff = 0.5"),
];

/// Appended to the valid file.
const ANIMATION: &str = r#"
[animation.camera]
keys = [{ time = 1, eye = [0, 1, 4] }, { time = 2.5, target = [1, 0, 0] }]

[[animation.light]]
light = 0
axis = [0, 1, 1]
pivot = [0, 3, 0]
keys = [{ time = 2, translate = [0, 0, 1], rotate_deg = 90 }]

[[animation.mesh]]
mesh = 0
keys = [{ time = 3, rotate_deg = 45 }]
sway = { amplitude = [0.5, 0, 0], period = 4, foot = 1 }
"#;

const BAD_ANIMATIONS: &[(&str, &str)] = &[
    (ANIMATION, "\n[[animation]]\n"),
    (ANIMATION, "\n[animation]\n"),
    ("[animation.camera]", "[animation.cam]"),
    (
        "[animation.camera]\nkeys = [{ time = 1, eye = [0, 1, 4] }, { time = 2.5, target = [1, 0, 0] }]",
        "[animation.camera]",
    ),
    ("{ time = 1, eye = [0, 1, 4] }, { time = 2.5, target = [1, 0, 0] }", ""),
    ("keys = [{ time = 1, eye = [0, 1, 4] }, { time = 2.5, target = [1, 0, 0] }]", "keys = { time = 1 }"),
    ("{ time = 1, eye = [0, 1, 4] }", "1"),
    ("time = 1, eye", "tim = 1, eye"),
    ("time = 1, eye", "eye"),
    ("time = 1, eye", "time = 0, eye"),
    ("time = 1, eye", "time = \"1 s\", eye"),
    ("time = 2.5", "time = 1"),
    ("eye = [0, 1, 4]", "eye = [0, 0, 0]"),
    ("eye = [0, 1, 4]", "fov_y_deg = 0"),
    ("eye = [0, 1, 4]", "up = [0, 1, 5]"),
    ("[[animation.light]]", "[animation.light]"),
    ("light = 0\n", "light = 1\n"),
    ("light = 0\n", "light = 0.5\n"),
    ("light = 0\n", "lamp = 0\n"),
    ("axis = [0, 1, 1]", "axis = [0, 0, 0]"),
    ("pivot = [0, 3, 0]", "pivot = 3"),
    ("rotate_deg = 90 }", "rotate_deg = [0, 90, 0] }"),
    ("translate = [0, 0, 1]", "move = [0, 0, 1]"),
    ("translate = [0, 0, 1]", "translate = [3.4e38, 0, 0]"),
    ("keys = [{ time = 2, translate = [0, 0, 1], rotate_deg = 90 }]\n", ""),
    ("[[animation.mesh]]", "[[animation.light]]\nkeys = [{ time = 3 }]\n\n[[animation.mesh]]"),
    ("amplitude = [0.5, 0, 0]", "amplitude = [0.5, 0.1, 0]"),
    ("amplitude = [0.5, 0, 0]", "amplitude = [3.4e38, 0, 0]"),
    ("amplitude = [0.5, 0, 0], ", ""),
    ("period = 4", "period = 0"),
    ("period = 4, ", ""),
    ("foot = 1", "foot = 11"),
    ("foot = 1", "root = 1"),
    ("sway = {", "sway = [1] #"),
];

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("good.obj", "v 0 0 0\nv 1 0 0\nv 0 5 0\nf 1 2 3\n");
    folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    folder
}

/// All replacements, each with the message that it makes.
fn messages(folder: &Folder, good: &str, bad: &[(&str, &str)]) -> String {
    folder.load_text(good).expect("without a change the file is good");
    let mut messages = String::new();
    for (find, replace) in bad {
        assert!(good.contains(find), "{find}");
        let message = folder.load_text(&good.replacen(find, replace, 1)).expect_err(replace);
        let shown = if replace.is_empty() { format!("(without) {find}") } else { (*replace).to_string() };
        // Lists of known generators and parameters are cut off.
        let message = message.split_inclusive(" known are ").next().unwrap();
        let message = message.split_inclusive(" it has ").next().unwrap();
        messages.push_str(&format!("{}\n    {message}\n", shown.trim_end().replace('\n', " / ")));
    }
    messages
}

#[test]
fn every_fault_has_a_message_with_its_line() {
    insta::assert_snapshot!(messages(&folder("bad_scenes"), GOOD, BAD));
}

#[test]
fn every_fault_of_an_animation_has_a_message_with_its_line() {
    let good = format!("{GOOD}{ANIMATION}");
    insta::assert_snapshot!(messages(&folder("bad_animations"), &good, BAD_ANIMATIONS));
}

#[test]
fn with_several_lights_an_animation_says_which() {
    let light = GOOD.find("[[light]]").unwrap()..GOOD.find("[[mesh]]").unwrap();
    let good = format!("{GOOD}\n{}{ANIMATION}", &GOOD[light]);
    let folder = folder("which_light");
    folder.load_text(&good).expect("the light is named");
    let message = folder.load_text(&good.replacen("light = 0\n", "", 1)).expect_err("it is not");
    assert!(
        message.contains("[[animation.light]] has no `light`; write for example: light = 0"),
        "{message}"
    );
}

#[test]
fn a_scene_that_is_nowhere_is_said_so() {
    let message = halflight_scene::resolve("no-such-scene").unwrap_err().to_string();
    assert!(message.starts_with("there is no scene `no-such-scene`: neither a file"), "{message}");
    assert!(halflight_scene::load_bundled("../atrium").is_err());
    let message = halflight_scene::load("no/such.toml".as_ref()).unwrap_err().to_string();
    assert!(message.starts_with("cannot read no/such.toml: "), "{message}");
}
