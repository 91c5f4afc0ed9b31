//! OBJ files of many programs: supported statements, and statements that are skipped.

mod common;

use common::Folder;
use glam::{DVec3, Vec3};
use halflight_core::scene::Mesh;

/// Four corners of the unit square in the plane z = 0.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn area(mesh: &Mesh) -> f32 {
    let twice = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).length();
    (0..mesh.triangle_count()).map(|triangle| twice(mesh.corners(triangle)) / 2.0).sum()
}

#[test]
fn indices_that_are_not_defined_are_left_out_and_said() {
    let folder = Folder::new("undefined_indices");
    let uvs = "indices of texture coordinates that are not defined are left out, such as";
    let normals = "indices of normals that are not defined are left out, such as";
    // Text behind the square, and the warnings. The computed normal is +z, the given one -z.
    let cases: [(&str, f32, &[String]); 10] = [
        ("f 1//1 2//1 3//1 4//1\n", 1.0, &[format!("{normals} 1 on line 5")]),
        ("f 1/4 2/3 3/2 4/1\n", 1.0, &[format!("{uvs} 4 on line 5")]),
        ("f 1/-1 2/-1 3/-1 4/-1\n", 1.0, &[format!("{uvs} -1 on line 5")]),
        ("vn 0 0 -1\nf 1//-2 2//-2 3//-2 4//-2\n", 1.0, &[format!("{normals} -2 on line 6")]),
        ("f 1/1/1 2/1/1 3/1/1 4/1/1\nvt 0 0\n", 1.0, &[format!("{normals} 1 on line 5")]),
        (
            "f 1/0/0 2/0/0 3/0/0 4/0/0\n",
            1.0,
            &[format!("{uvs} 0 on line 5"), format!("{normals} 0 on line 5")],
        ),
        (
            "vn 0.6 0 -0.8\nf 1//9000000000 2//2 3//2 4//2\n",
            1.0,
            &[format!("{normals} 9000000000 on line 6")],
        ),
        // Definitions may follow; empty parts are none; extra white space does no harm.
        ("f 1//1 2//1 3//1 4//1\nvn 0.6 0 -0.8\n", -0.8, &[]),
        ("f 1/ 2/ 3/ 4/\nf\t1//  2//\t3// 4//\n", 1.0, &[]),
        ("vn 0.6 0 -0.8\nfo +1//+1 2//1 3//1 4//1\n", -0.8, &[]),
    ];
    for (text, z, warnings) in cases {
        let loaded = folder.load_mesh("a.obj", format!("{SQUARE}{text}")).expect(text);
        let warned: Vec<_> = warnings.iter().map(|warning| format!("a.obj: {warning}")).collect();
        assert_eq!(loaded.report.warnings, warned, "{text}");
        // Flat meshes have no normals.
        let normals = &loaded.scene.mesh.normals;
        assert!(normals.iter().all(|normal| normal.z == z) && normals.is_empty() == (z == 1.0), "{text}");
        assert!(loaded.scene.mesh.uvs.iter().all(|uv| *uv == glam::Vec2::ZERO), "{text}");
    }
    // Vertices may follow, too; a corner with an undefined normal gets a computed one.
    let text = format!("f 1//1 2//1 3//7\nvn 0 0.6 0.8\n{SQUARE}");
    let mesh = folder.load_mesh("a.obj", text).unwrap().scene.mesh;
    let given = Vec3::new(0.0, 0.6, 0.8);
    assert_eq!(mesh.normals, [given, given, Vec3::Z]);
}

#[test]
fn numbers_that_are_not_finite_do_no_more_harm_than_they_must() {
    let folder = Folder::new("not_finite");
    let words = ["nan", "-inf", "-1.#IND00", "1.#QNAN0", "1.#INF", "-nan(ind)", "1e999"];
    for word in words {
        // Normals are computed.
        let text = format!("{SQUARE}vn {word} {word} {word}\nf 1//1 2//1 3//1 4//1\n");
        let loaded = folder.load_mesh("a.obj", text).expect(word);
        assert!(loaded.scene.mesh.normals.is_empty(), "{word}");
        assert!(loaded.report.warnings.is_empty(), "{word}");
        // Texture coordinates are 0, which matters only to a texture.
        let text = format!("{SQUARE}vt {word} 1\nf 1/1 2/1 3/1 4/1\n");
        let loaded = folder.load_mesh("a.obj", text).expect(word);
        assert!(loaded.scene.mesh.uvs.iter().all(|&uv| uv == glam::Vec2::ZERO), "{word}");
        assert!(loaded.report.warnings.is_empty(), "{word}: {:?}", loaded.report.warnings);
        // Positions are undefined; the other faces are complete.
        let loaded = folder.load_mesh("a.obj", format!("{SQUARE}v {word} 0 0\nf 1 2 3 4\n")).expect(word);
        assert_eq!((area(&loaded.scene.mesh), loaded.report.warnings.len()), (1.0, 0), "{word}");
        let text = format!("v 0 0 {word}\n{SQUARE}f 1 2 3\nf 2 3 4 5\nf 4 5 1\n");
        let loaded = folder.load_mesh("a.obj", text).expect(word);
        let warning =
            "a.obj: faces with a position that is not finite are left out: 2, the first by that of line 1";
        assert_eq!((area(&loaded.scene.mesh), loaded.report.warnings), (1.0, vec![warning.to_string()]));
    }
    let image = image::RgbImage::new(1, 1);
    image.save(folder.0.join("a.png")).unwrap();
    folder.write("a.mtl", "newmtl a\nmap_Kd a.png\n");
    let text = format!("mtllib a.mtl\n{SQUARE}vt 0 0\nvt nan 0\nvt 0 inf\nusemtl a\nf 1/1 2/2 3/1\n");
    let warnings = folder.load_mesh("a.obj", text).unwrap().report.warnings;
    assert_eq!(warnings, ["a.obj: texture coordinates that are not finite are taken as 0, first on line 7"]);
}

#[test]
fn comments_colours_and_long_statements_are_read_over() {
    let folder = Folder::new("statements");
    for text in [
        "v 0 0 0# corner\nv 1 0 0 1 # w\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0 0.5\nf 1 2 3 #1 2\nf 1#a 2 3\n",
        "v 0 0 0\nv 1 0 0 # in C:\\\nv 1 1 0\n# path \\\nf 1 2 \\\n\\\n\\\n 3\n",
        "\n\n  v 0 0 0\n\tv +1.0e0 0.0 -0\nv 1. 1 .0\np 1\nl 1 2\nfoo bar\nf 1 2 3\n\x1a",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3 \\",
        "v 0 0 0 1 0\nv 1 0 0 0 1\nv 1 1 0 0.1 0.2 0.3 1\nf -3 -2 -1\n",
    ] {
        let loaded = folder.load_mesh("a.obj", text).expect(text);
        assert_eq!(loaded.scene.mesh.corners(0), [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)], "{text}");
    }
    // A face over as many lines as it has corners, longer than what is read at once, between others.
    let long = 200_000;
    let mut text = SQUARE.repeat(2);
    text.push_str("f 1 2 3\nf 4 3 \\\n 2 1 ");
    text.push_str(&"\\\n 1              ".repeat(long));
    text.push_str("\nf 5 6 7\nf 1 2 9\n");
    let fault = folder.load_mesh("a.obj", text).unwrap_err();
    let line = 8 + 1 + 2 + long + 2;
    assert!(fault.starts_with(&format!("a.obj:{line}: face refers to vertex 9, but 8")), "{fault}");
}

#[test]
fn indices_that_count_back_hold_wherever_a_file_is_cut() {
    // Some megabytes: several blocks of several chunks, each cut somewhere between these lines.
    let count = 60_000;
    let mut text = String::new();
    for at in 0..count {
        text.push_str(&format!("v {at} 0 0\nv {at} 1 0\nv {at} 0 1\nvt {at} 0.5\nf -3/-1 -2/-1 -1/-1\n"));
    }
    let folder = Folder::new("counting_back");
    let mesh = folder.load_mesh("a.obj", &text).unwrap().scene.mesh;
    assert_eq!(mesh.triangle_count(), count);
    for at in 0..count {
        let x = at as f32;
        assert_eq!(mesh.corners(at).map(|corner| corner.x), [x; 3]);
        assert!(mesh.triangles[at].iter().all(|&vertex| mesh.uvs[vertex as usize].x == x));
    }
    text.push_str("\nf -1 -2 -180001\n");
    let fault = folder.load_mesh("a.obj", &text).unwrap_err();
    let expected = "a.obj:300002: face refers to vertex -180001, but 180000 are defined";
    assert!(fault.starts_with(expected), "{fault}");
}

#[test]
fn coordinates_are_rounded_once_after_the_transform() {
    let folder = Folder::new("double");
    let corner = DVec3::new(448_259.35, 5_411_932.68, 123.4567891);
    let offsets = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::new(0.0, 1.0, 0.1)];
    let lines = |prefix: &str| -> String {
        let line = |offset: &DVec3| {
            let DVec3 { x, y, z } = corner + *offset;
            format!("{prefix}{x:.7} {y:.7} {z:.7}\n")
        };
        offsets.iter().map(line).collect()
    };
    folder.write("a.obj", format!("{}f 1 2 3 4\n", lines("v ")));
    let header = |kind: &str, format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 4\nproperty {kind} x\nproperty {kind} y\nproperty {kind} z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    folder.write("a.ply", format!("{}{}4 0 1 2 3\n", header("float", "ascii"), lines("")));
    let mut binary = header("double", "binary_little_endian").into_bytes();
    binary.extend(offsets.iter().flat_map(|offset| (corner + *offset).to_array()).flat_map(f64::to_le_bytes));
    binary.push(4);
    binary.extend((0..4).flat_map(i32::to_le_bytes));
    folder.write("b.ply", binary);
    for file in ["a.obj", "a.ply", "b.ply"] {
        let mesh = format!(
            "[[mesh]]\nfile = \"{file}\"\ntransform = {{ translate = [-448259.35, -5411932.68, -123.4567891] }}\n"
        );
        let mesh = folder.load(&mesh).unwrap().scene.mesh;
        for (position, offset) in mesh.positions.iter().zip(offsets) {
            // Seven decimals of the file, and double precision at five million.
            assert!(position.as_dvec3().abs_diff_eq(offset, 1e-6), "{file}: {position} {offset}");
        }
    }
}

#[test]
fn a_vertex_of_many_faces_gets_smooth_normals_and_keeps_its_creases() {
    let folder = Folder::new("valence");
    // Cones of so many sides about their tip: a flat one, which is smooth there, and a steep one, where a
    // face takes the mean of those within 65°.
    for (sides, height) in [(100, 0.1f32), (1000, 0.1), (100, 5.0), (1000, 5.0)] {
        let ring = (0..sides).map(|side| (side as f32 / sides as f32 * std::f32::consts::TAU).sin_cos());
        let mut text = format!("v 0 {height} 0\n");
        text.extend(ring.map(|(sine, cosine)| format!("v {cosine} 0 {sine}\n")));
        text.extend((0..sides).map(|side| format!("f 1 {} {}\n", 2 + (side + 1) % sides, 2 + side)));
        let loaded = folder.load_smooth("a.obj", text).unwrap();
        let mesh = loaded.scene.mesh;
        assert_eq!(loaded.report.normals_computed(), mesh.positions.len());
        for triangle in &mesh.triangles {
            let tip = triangle.map(|vertex| vertex as usize)[0];
            assert_eq!(mesh.positions[tip], Vec3::Y * height);
            let corners = triangle.map(|vertex| mesh.positions[vertex as usize]);
            let face = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            let expected = if height < 1.0 { Vec3::Y } else { face };
            // Faces within a cell of 6° share a normal, and the mean of a round sector is its middle, except
            // for the curvature.
            assert!(mesh.normals[tip].dot(expected) > 0.97, "{sides} {height}: {} {face}", mesh.normals[tip]);
        }
    }
}
