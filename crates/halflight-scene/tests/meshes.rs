//! Valid OBJ and PLY files, and the meshes that they give.

mod common;

use common::Folder;
use glam::Vec3;
use halflight_core::scene::Mesh;
use halflight_scene::MeshReport;

/// Four corners of the unit square in the plane z = 0, as OBJ.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn area(mesh: &Mesh) -> f32 {
    let twice = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).length();
    (0..mesh.triangle_count()).map(|triangle| twice(mesh.corners(triangle)) / 2.0).sum()
}

/// The unit normals of all triangles.
fn facet_normals(mesh: &Mesh) -> Vec<Vec3> {
    let normal = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).normalize();
    (0..mesh.triangle_count()).map(|triangle| normal(mesh.corners(triangle))).collect()
}

#[test]
fn a_full_obj_keeps_positions_texture_coordinates_and_normals() {
    let text = "# comment \\\nv 0 0 0 # corner\nv 2 0 0 2\n\tv 1 1 \\\n0\nvt 0.25 0.5\nvt 1\nvn 0 3 4\r\n\
                s off\no thing\ng part\nl 1 2 3\np 1\nf 1/1/1 2/2/-1 -1/1/1\n";
    let loaded = Folder::new("full_obj").load_mesh("a.obj", text).unwrap();
    let mesh = loaded.scene.mesh;
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)]);
    assert_eq!(
        mesh.uvs.iter().map(glam::Vec2::to_array).collect::<Vec<_>>(),
        [[0.25, 0.5], [1.0, 0.0], [0.25, 0.5]]
    );
    // 3-4-5: the length is exact, so that the quotient is the nearest float.
    assert!(
        mesh.normals.iter().all(|normal| normal.abs_diff_eq(Vec3::new(0.0, 0.6, 0.8), 1e-7)),
        "{:?}",
        mesh.normals
    );
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    let report = MeshReport { source: "a.obj".into(), triangles: 1, ..MeshReport::default() };
    assert_eq!(loaded.report.meshes, [report]);
    assert!(loaded.report.warnings.is_empty(), "{:?}", loaded.report.warnings);
}

#[test]
fn faces_that_differ_in_what_they_name_stay_in_step() {
    // tobj alone would give the second face's texture coordinates to the wrong vertices.
    let text = format!(
        "{SQUARE}vt 0.5 0.5\nvn 0.6 0 -0.8\nf 1 2 3\nf 1/1/1 3/1/1 4/1/1\nf 1/1 2 3\nf 1//1 2//1 3//1\n"
    );
    let mesh = Folder::new("mixed_faces").load_mesh("a.obj", text).unwrap().scene.mesh;
    let seen: Vec<(f32, f32)> = mesh
        .triangles
        .iter()
        .map(|[vertex, ..]| *vertex as usize)
        .map(|vertex| (mesh.uvs[vertex].x, mesh.normals[vertex].z))
        .collect();
    // Computed normals face +z, the given one away from it.
    assert_eq!(seen, [(0.0, 1.0), (0.5, -0.8), (0.0, 1.0), (0.0, -0.8)]);
}

#[test]
fn polygons_are_triangulated_whatever_their_shape() {
    let folder = Folder::new("polygons");
    // A quadrilateral, a pentagon, and a U, whose fan would cover its notch: areas 1, 5 and 7.
    let outlines: [(&[[f32; 2]], usize, f32); 3] = [
        (&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 2, 1.0),
        (&[[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [2.0, 2.0], [0.0, 2.0]], 3, 5.0),
        (
            &[[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [2.0, 3.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]],
            6,
            7.0,
        ),
    ];
    for (outline, triangles, expected) in outlines {
        let count = outline.len();
        let list =
            |first: usize| (first..first + count).map(|at| at.to_string()).collect::<Vec<_>>().join(" ");
        let lines = |prefix: &str| -> String {
            outline.iter().map(|[x, y]| format!("{prefix}{x} {y} 0\n")).collect()
        };
        let obj = format!("{}f {}\n", lines("v "), list(1));
        let ply = format!(
            "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_index\nend_header\n{}{count} {}",
            lines(""),
            list(0)
        );
        for (name, text) in [("a.obj", obj), ("a.ply", ply)] {
            let loaded = folder.load_mesh(name, text).unwrap();
            assert_eq!(loaded.report.meshes[0].triangles, triangles, "{name}");
            // Small whole numbers: exact in single precision.
            assert_eq!(area(&loaded.scene.mesh), expected, "{name}");
            assert!(facet_normals(&loaded.scene.mesh).iter().all(|&normal| normal == Vec3::Z), "{name}");
        }
    }
}

#[test]
fn triangles_without_an_area_are_dropped_and_counted() {
    let text = format!(
        "{SQUARE}v 0.5 0.5 0\nv 0 0 0\nv 9 9 9\nf 1 2 3\nf 1 1 2\nf 1 5 3\nf 1 6 2\nf 1 7 7\nf 1 3 4\n"
    );
    let loaded = Folder::new("zero_area").load_mesh("a.obj", text).unwrap();
    assert_eq!((loaded.report.triangles(), loaded.report.zero_area_dropped()), (2, 4));
    // Vertices that only they used are gone as well, and do not stretch the bounds.
    assert_eq!(loaded.scene.mesh.bounds(), Some((Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0))));
    // Thin is not flat: a bar of a tenth of a millimetre by ten metres stays, far from the origin too.
    let thin = "v 1000 0 0\nv 1010 0 0\nv 1010 0.0001 0\nf 1 2 3\n";
    let loaded = Folder::new("thin").load_mesh("a.obj", thin).unwrap();
    assert_eq!((loaded.report.triangles(), loaded.report.zero_area_dropped()), (1, 0));
}

#[test]
fn computed_normals_are_smooth_over_flat_angles_and_sharp_over_edges() {
    let folder = Folder::new("normals");
    // A cube of eight shared vertices: every face keeps its own normal, each vertex is split in three.
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let loaded = folder.load_smooth("a.obj", cube).unwrap();
    assert_eq!((loaded.scene.mesh.positions.len(), loaded.report.normals_computed()), (24, 24));
    // All of it is flat, so that no normals are kept.
    assert!(loaded.scene.mesh.normals.is_empty());
    // Without creases, the corners of the cube are those of a ball.
    let entry = "[[mesh]]\nfile = \"a.obj\"\nsmooth = \"on\"\ncrease_deg = 100\n";
    let mesh = folder.load(entry).unwrap().scene.mesh;
    for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
        assert!(normal.dot((*position - Vec3::splat(0.5)).normalize()) > 0.95, "{position} {normal}");
    }
    assert_eq!(mesh.positions.len(), 8);
    // A ridge of 28° between two squares is smooth, also across a seam of texture coordinates.
    let ridge = "v -4 0 0\nv 0 1 0\nv 4 0 0\nv -4 0 4\nv 0 1 4\nv 4 0 4\nvt 0 0\nvt 1 1\n\
                 f 1/1 4/1 5/1 2/1\nf 2/2 5/2 6/2 3/2\n";
    let mesh = folder.load_smooth("a.obj", ridge).unwrap().scene.mesh;
    assert_eq!(mesh.positions.len(), 8);
    for (position, normal) in
        mesh.positions.iter().zip(&mesh.normals).filter(|(position, _)| position.x == 0.0)
    {
        // The mean of two mirrored vectors: only its last bits can differ.
        assert!(normal.abs_diff_eq(Vec3::Y, 1e-6), "{position} {normal}");
    }
    // The given normals stay, the one that is not a number is computed.
    let partly = format!("{SQUARE}vn 0 0.6 0.8\nvn nan 0 0\nf 1//1 2//1 3//2\n");
    let loaded = folder.load_smooth("a.obj", partly).unwrap();
    let given = Vec3::new(0.0, 0.6, 0.8);
    assert_eq!(loaded.scene.mesh.normals, [given, given, Vec3::Z]);
    assert_eq!(loaded.report.normals_computed(), 1);
}

/// A tetrahedron with normals, an unused property, element and list.
fn tetrahedron(format: &str) -> Vec<u8> {
    let header = format!(
        "ply\nformat {format} 1.0\ncomment made by hand\nelement vertex 4\nproperty double x\nproperty float y\n\
         property float z\nproperty uchar quality\nproperty float nx\nproperty float ny\nproperty float nz\n\
         element edge 1\nproperty int from\nproperty list ushort short more\n\
         element face 4\nproperty uchar flag\nproperty list uchar uint vertex_indices\nend_header\n"
    );
    let points = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = [[0u32, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    if format == "ascii" {
        let points = points.map(|[x, y, z]| format!("{x} {y} {z} 7 0 2 0\n")).concat();
        let faces = faces.map(|[a, b, c]| format!("1 3 {a} {b} {c}\n")).concat();
        return format!("{header}{points}5 2 -1 -2\n{faces}").trim_end().into();
    }
    // Little endian bytes of each number, turned round for big endian.
    let put = |out: &mut Vec<u8>, bytes: &[u8]| {
        let mut bytes = bytes.to_vec();
        if format == "binary_big_endian" {
            bytes.reverse();
        }
        out.extend(bytes);
    };
    let mut out = header.into_bytes();
    for [x, y, z] in points {
        put(&mut out, &f64::from(x).to_le_bytes());
        put(&mut out, &y.to_le_bytes());
        put(&mut out, &z.to_le_bytes());
        out.push(7);
        [0.0f32, 2.0, 0.0].iter().for_each(|number| put(&mut out, &number.to_le_bytes()));
    }
    put(&mut out, &5i32.to_le_bytes());
    put(&mut out, &2u16.to_le_bytes());
    [-1i16, -2].iter().for_each(|number| put(&mut out, &number.to_le_bytes()));
    for face in faces {
        out.extend([1, 3]);
        face.iter().for_each(|index| put(&mut out, &index.to_le_bytes()));
    }
    out
}

#[test]
fn the_three_kinds_of_ply_give_the_same_mesh() {
    let folder = Folder::new("ply");
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let loaded = folder.load_mesh("a.ply", tetrahedron(format)).unwrap();
        let mesh = loaded.scene.mesh;
        assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z], "{format}");
        assert_eq!(mesh.triangles, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], "{format}");
        assert_eq!(mesh.normals, [Vec3::Y; 4], "{format}");
        assert!(loaded.report.warnings.is_empty(), "{format}: {:?}", loaded.report.warnings);
    }
}

#[test]
fn what_is_left_out_is_said_once() {
    let folder = Folder::new("warnings");
    folder.write(
        "a.obj",
        "mtllib gone.mtl\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nusemtl a\nf 1 2\nf 1 2 3\n",
    );
    folder.write(
        "b.obj",
        "mtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl c\nf 1 2 3\nusemtl a\nf 1 2 3\ncurv 0 1 1 2\n",
    );
    folder.write(
        "b.mtl",
        "newmtl a\nKd 2 0.5 0\nKe 1 1 1\nd 0.5\nmap_d a.png\nbump a.png\nmap_Kd gone.png\n\
         newmtl b\nKd 0.2\nTr 0.5\nmap_Kd gone.png\nd 0.1\nKd spectral x.rfl\n",
    );
    folder.write("c.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 9\n1 0 0 9\n0 1 0 9\n3 0 1 2\n");
    let both = "[[mesh]]\nfile = \"a.obj\"\n\n[[mesh]]\nfile = \"b.obj\"\n\n[[mesh]]\nfile = \"c.ply\"\n\n";
    let warnings = folder.load(&both.repeat(2)).unwrap().report.warnings;
    insta::assert_snapshot!(warnings.join("\n"));
}

#[test]
fn long_meshes_are_cut_into_pieces_without_a_seam() {
    // More faces than one piece holds, on a bent strip: the result must not show where the cuts are.
    let count = 70_000;
    let mut text = String::new();
    for at in 0..=count {
        let angle = at as f32 * 1e-4;
        text.push_str(&format!("v {} {} 0\nv {} {} 1\n", angle.cos(), angle.sin(), angle.cos(), angle.sin()));
    }
    for at in 0..count {
        let first = at * 2 + 1;
        text.push_str(&format!("f {} {} {} {}\n", first, first + 1, first + 3, first + 2));
    }
    let loaded = Folder::new("pieces").load_mesh("a.obj", text).unwrap();
    let mesh = loaded.scene.mesh;
    assert_eq!(mesh.triangle_count(), 2 * count);
    for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
        // Twice the angle between neighbouring quads, 1e-4, and the rounding of edges of 1e-4 at radius 1
        // (6e-8 each).
        let radial = Vec3::new(position.x, position.y, 0.0);
        assert!(normal.dot(radial).abs() > 1.0 - 1e-5, "{position} {normal}");
    }
}
