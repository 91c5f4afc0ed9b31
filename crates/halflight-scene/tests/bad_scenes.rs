//! Faulty scene files, each with its message.

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

/// What to replace in the good file, and by what.
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
];

#[test]
fn every_fault_has_a_message_with_its_line() {
    let folder = Folder::new("bad_scenes");
    folder.write("good.obj", "v 0 0 0\nv 1 0 0\nv 0 5 0\nf 1 2 3\n");
    folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    folder.load_text(GOOD).expect("without a change the file is good");
    let mut messages = String::new();
    for (find, replace) in BAD {
        assert!(GOOD.contains(find), "{find}");
        let message = folder.load_text(&GOOD.replacen(find, replace, 1)).expect_err(replace);
        let shown = if replace.is_empty() { format!("(without) {find}") } else { (*replace).to_string() };
        // Which generators and parameters there are is not this test's business.
        let message = message.split_inclusive(" known are ").next().unwrap();
        let message = message.split_inclusive(" it has ").next().unwrap();
        messages.push_str(&format!("{}\n    {message}\n", shown.trim_end().replace('\n', " / ")));
    }
    insta::assert_snapshot!(messages);
}

#[test]
fn a_scene_that_is_nowhere_is_said_so() {
    let message = halflight_scene::resolve("no-such-scene").unwrap_err().to_string();
    assert!(message.starts_with("there is no scene `no-such-scene`: neither a file"), "{message}");
    assert!(halflight_scene::load_bundled("../atrium").is_err());
    let message = halflight_scene::load("no/such.toml".as_ref()).unwrap_err().to_string();
    assert!(message.starts_with("cannot read no/such.toml: "), "{message}");
}
