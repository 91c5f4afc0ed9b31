//! Faulty OBJ, MTL and PLY files, each with its message.

mod common;

use common::Folder;

const BAD_OBJ: &[&str] = &[
    "",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\n",
    "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n",
    "v 0 0 0\nv 1 0 -inf\nv 0 1 0\nf 1 2 3\n",
    "v 0 0 0\nv 1 0 1e39\nv 0 1 0\nf 1 2 3\n",
    "v 0 0 0\nv 1 0 1 0\nv 0 1 0\nf 1 2 3\n",
    "v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n",
    "v 0 0 0\nv 1 0 x\nv 0 1 0\nf 1 2 3\n",
    "v 0 0 0\nv 1 0 \\\n0,5\nv 0 1 0\nf 1 2 3\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 4\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 -3 -2\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 three\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4000000000\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf -3 2 -9000000000\n",
    "v 0 0 0\nv 1 0 0\nf -2 -1 -3\nv 0 1 0\nf 1 2 3\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/x 2/1 3/1\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1, 2, 3\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1/1 2 3\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf /1 2 3\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 1\nf 1 2 3\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt\nf 1 2 3\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n",
];

#[test]
fn every_faulty_obj_has_a_message_with_its_line() {
    let folder = Folder::new("bad_obj");
    let mut messages = String::new();
    for text in BAD_OBJ {
        let message = folder.load_mesh("bad.obj", text).expect_err(text);
        messages.push_str(&format!("{text:?}\n    {message}\n"));
    }
    let message = folder.load_mesh("bad.obj", b"v 0 0 \xff\n").unwrap_err();
    messages.push_str(&format!("(not text)\n    {message}\n"));
    insta::assert_snapshot!(messages);
}

const VERTICES: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const FACES: &str = "element face 1\nproperty list uchar int vertex_indices\n";

#[test]
fn every_faulty_ply_has_a_message_with_its_element() {
    let ascii = |header: &str, data: &str| format!("ply\nformat ascii 1.0\n{header}end_header\n{data}");
    let both = format!("{VERTICES}{FACES}");
    let bad = [
        ("empty", String::new()),
        ("no magic", "PLY\n".to_string()),
        ("no format", format!("ply\n{both}end_header\n")),
        ("unknown format", format!("ply\nformat binary 1.0\n{both}end_header\n")),
        ("unknown type", ascii("element vertex 1\nproperty half x\n", "0\n")),
        ("bad count", ascii("element vertex many\nproperty float x\n", "0\n")),
        ("header without end", format!("ply\nformat ascii 1.0\n{both}")),
        ("no z", ascii("element vertex 1\nproperty float x\nproperty float y\n", "0 0\n")),
        ("x is a list", ascii(&VERTICES.replace("float x", "list uchar float x"), "1 0 0 0\n")),
        ("no properties", ascii("element nothing 99999999999\n", "")),
        ("no faces", ascii(VERTICES, "0 0 0\n1 0 0\n0 1 0\n")),
        (
            "faces first, index too large",
            ascii(&format!("{FACES}{VERTICES}"), "3 0 1 3\n0 0 0\n1 0 0\n0 1 0\n"),
        ),
        (
            "faces without a list",
            ascii(&both.replace("vertex_indices", "corners"), "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        ),
        (
            "strips without a list",
            ascii(
                &format!("{VERTICES}element tristrips 1\nproperty int length\n"),
                "0 0 0\n1 0 0\n0 1 0\n3\n",
            ),
        ),
        (
            "strip beyond the vertices",
            ascii(
                &format!("{VERTICES}element tristrips 1\nproperty list int int vertex_indices\n"),
                "0 0 0\n1 0 0\n0 1 0\n4 0 1 2 3\n",
            ),
        ),
        ("nan", ascii(&both, "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n")),
        ("too large", ascii(&both, "0 0 0\n1 0 0\n0 1 1e39\n3 0 1 2\n")),
        ("not a number", ascii(&both, "0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n")),
        ("index too large", ascii(&both, "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n")),
        ("index negative", ascii(&both, "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n")),
        (
            "index not whole",
            ascii(&both.replace("uchar int", "uchar float"), "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        ),
        ("index with a part", ascii(&both, "0 0 0\n1 0 0\n0 1 0\n3 0 1 1.5\n")),
        (
            "list of half a corner",
            ascii(&both.replace("uchar int", "float int"), "0 0 0\n1 0 0\n0 1 0\n2.5 0 1 2\n"),
        ),
        (
            "endless list",
            ascii(&both.replace("uchar int", "uint int"), "0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n"),
        ),
        ("negative list", ascii(&both.replace("uchar int", "char int"), "0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n")),
        ("vertices end early", ascii(&both, "0 0 0\n1 0 0\n")),
        ("faces end early", ascii(&both, "0 0 0\n1 0 0\n0 1 0\n3 0 1")),
        (
            "more vertices than there can be",
            ascii(&both.replace("vertex 3", "vertex 99999999999"), "0 0 0\n"),
        ),
        ("a property too early", ascii(&format!("property int x\n{both}"), "")),
        ("an unknown line", ascii(&format!("elements vertex 3\n{both}"), "")),
        ("faces of two corners", ascii(&both, "0 0 0\n1 0 0\n0 1 0\n2 0 1\n")),
        (
            "binary ends early",
            format!("ply\nformat binary_little_endian 1.0\n{both}end_header\n{}", "\0".repeat(35)),
        ),
    ];
    let folder = Folder::new("bad_ply");
    let mut messages = String::new();
    for (what, text) in bad {
        let message = folder.load_mesh("bad.ply", text).expect_err(what);
        messages.push_str(&format!("{what}\n    {message}\n"));
    }
    insta::assert_snapshot!(messages);
}
