//! Scenes do not depend on the encoding and the line ends of their files.

#![allow(clippy::panic, reason = "helpers of tests fail their test")]

mod common;

use common::{Folder, HEAD};
use glam::Vec3;
use halflight_core::scene::{Mesh, Scene};

const BOM: &str = "\u{feff}";
const OBJ: &str = "mtllib größe.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0.5 0.25\nvn 0.6 0 0.8\nusemtl größe\n\
                   f 1/1/1 2/1/1 \\\n3/1/1\nf 1/-1 -2/1 -1/1\n";
const MTL: &str = "newmtl größe\nKd 0.9 0.1 0.2\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const MESHES: &str = "[[mesh]]\nfile = \"a.obj\"\n\n[[mesh]]\nfile = \"a.ply\"\n";

/// Attributes of every triangle's corners, and its albedo.
fn triangles(mesh: &Mesh) -> Vec<(Vec<[f32; 8]>, Vec3)> {
    let normal = |vertex: usize| mesh.normals.get(vertex).copied().unwrap_or_default();
    let corner = |&vertex: &u32| {
        let vertex = vertex as usize;
        let ([x, y, z], [nx, ny, nz]) = (mesh.positions[vertex].to_array(), normal(vertex).to_array());
        [x, y, z, nx, ny, nz, mesh.uvs[vertex].x, mesh.uvs[vertex].y]
    };
    let albedo = |at: usize| mesh.materials[mesh.material_ids[at] as usize].albedo;
    let corners = mesh.triangles.iter().map(|triangle| triangle.iter().map(corner).collect());
    corners.enumerate().map(|(at, corners)| (corners, albedo(at))).collect()
}

/// Encodings of a text, with their names.
fn ways(text: &str) -> Vec<(&'static str, Vec<u8>)> {
    let utf16 =
        |text: &str, unit: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(unit).collect::<Vec<u8>>();
    let marked = format!("{BOM}{text}");
    vec![
        ("as it is", text.into()),
        ("byte order mark", marked.clone().into()),
        ("CR LF", text.replace('\n', "\r\n").into()),
        ("CR", text.replace('\n', "\r").into()),
        ("byte order mark and CR", marked.replace('\n', "\r").into()),
        ("UTF-16, little endian", utf16(&marked, u16::to_le_bytes)),
        ("UTF-16, big endian", utf16(&marked, u16::to_be_bytes)),
        ("UTF-16 and CR LF", utf16(&marked.replace('\n', "\r\n"), u16::to_le_bytes)),
        ("UTF-16 without a mark", utf16(text, u16::to_le_bytes)),
        ("end-of-file mark", format!("{text}\x1a").into()),
        ("NUL at the end", format!("{text}\0\0\0").into()),
        ("no line end", text.trim_end().into()),
    ]
}

/// Encodings of a mesh file, in which white space at line ends is harmless too.
fn mesh_ways(text: &str) -> Vec<(&'static str, Vec<u8>)> {
    let mut ways = ways(text);
    ways.push(("white space", text.replace('\n', " \t\n\t ").into()));
    ways.push(("CR CR LF", text.replace('\n', "\r\r\n").into()));
    ways
}

fn load(folder: &Folder, what: &str) -> Scene {
    let loaded = folder.load(MESHES).unwrap_or_else(|fault| panic!("{what}: {fault}"));
    assert!(loaded.report.warnings.is_empty(), "{what}: {:?}", loaded.report.warnings);
    loaded.scene
}

#[test]
fn meshes_and_materials_are_the_same_in_every_encoding() {
    let folder = Folder::new("encodings");
    let plain = [("a.obj", OBJ), ("größe.mtl", MTL), ("a.ply", PLY)];
    for (name, text) in plain {
        folder.write(name, text);
    }
    let expected = triangles(&load(&folder, "plain").mesh);
    assert_eq!(expected.len(), 3);
    assert_eq!([expected[0].1, expected[2].1], [Vec3::new(0.9, 0.1, 0.2), Vec3::splat(0.8)]);
    for (name, text) in plain {
        for (what, bytes) in mesh_ways(text) {
            // Lines of the joined statement, and values of a row, must not be separated by empty lines.
            if what == "CR CR LF" && name == "a.obj" {
                continue;
            }
            folder.write(name, bytes);
            assert_eq!(triangles(&load(&folder, what).mesh), expected, "{name}: {what}");
        }
        folder.write(name, text);
    }
    // Concatenated files have byte order marks inside.
    folder.write(
        "a.obj",
        OBJ.replace("v 1 1 0", &format!("{BOM}v 1 1 0")).replace("usemtl", &format!("{BOM}usemtl")),
    );
    folder.write("größe.mtl", format!("newmtl a\nKd 1\n{BOM}{MTL}"));
    assert_eq!(triangles(&load(&folder, "joined").mesh), expected);
}

#[test]
fn scene_files_are_the_same_in_every_encoding() {
    let folder = Folder::new("scene_encodings");
    folder.write("größe.ply", PLY);
    let text = format!("{HEAD}[[mesh]]\nfile = \"größe.ply\"\n");
    for (what, bytes) in ways(&text) {
        folder.write("scene.toml", bytes);
        let loaded = halflight_scene::load(&folder.0.join("scene.toml"));
        let loaded = loaded.unwrap_or_else(|fault| panic!("{what}: {fault}"));
        assert_eq!(loaded.report.triangles(), 1, "{what}");
    }
    folder.write("scene.toml", [text.as_bytes(), b"# gr\xf6\xdfe\n"].concat());
    let fault = halflight_scene::load(&folder.0.join("scene.toml")).unwrap_err().to_string();
    assert!(fault.ends_with("scene.toml:14: not valid TOML: the text is not UTF-8"), "{fault}");
}

#[test]
fn names_that_are_no_utf_8_are_told_apart() {
    let folder = Folder::new("latin_1");
    folder.write("a.mtl", b"newmtl gr\xfcn\nKd 0 1 0\nnewmtl gr\xf6n\nKd 1 0 0\n");
    let obj = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl gr\xfcn\nf 1 2 3\n";
    let loaded = folder.load_mesh("a.obj", obj).unwrap();
    assert_eq!(triangles(&loaded.scene.mesh)[0].1, Vec3::Y);
}
