//! PLY files of many programs.

mod common;

use common::Folder;
use glam::{Vec2, Vec3};
use halflight_core::scene::{Material, Mesh};
use image::{Rgb, RgbImage};

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";
const INDICES: &str = "property list uchar int vertex_indices\n";
/// Four corners of the unit square in the plane z = 0.
const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

fn ascii(header: &str, data: &str) -> String {
    format!("ply\nformat ascii 1.0\n{header}end_header\n{data}")
}

/// The four corners with additional header lines.
fn square(header: &str, data: &str) -> String {
    ascii(&format!("element vertex 4\n{XYZ}{header}"), &format!("{SQUARE}{data}"))
}

fn area(mesh: &Mesh) -> f32 {
    let twice = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).dot(Vec3::Z);
    (0..mesh.triangle_count()).map(|triangle| twice(mesh.corners(triangle)) / 2.0).sum()
}

#[test]
fn elements_come_in_any_order_with_others_between() {
    let folder = Folder::new("ply_order");
    let vertices = format!("element vertex 4\n{XYZ}");
    let faces = format!("element face 1\n{INDICES}");
    let other = "element edge 2\nproperty int from\nproperty list ushort float more\n";
    let more = "5 0\n7 3 1.5 nan 2\n";
    for (header, data) in [
        (format!("{faces}{vertices}"), format!("4 0 1 2 3\n{SQUARE}")),
        (format!("{other}{faces}{vertices}"), format!("{more}4 0 1 2 3\n{SQUARE}")),
        (format!("{faces}{other}{vertices}"), format!("4 0 1 2 3\n{more}{SQUARE}")),
        (format!("{vertices}{faces}{other}"), format!("{SQUARE}4 0 1 2 3\n{more}")),
        (format!("{vertices}{faces}{faces}"), format!("{SQUARE}3 0 1 2\n3 2 3 0")),
        (
            format!("\ncomment a \\\n  {vertices}\nobj_info b\n{faces}"),
            format!("\n\n{SQUARE} 4\n0 1\t2 3 # the end"),
        ),
    ] {
        let loaded = folder.load_mesh("a.ply", ascii(&header, &data)).expect(&header);
        assert_eq!(area(&loaded.scene.mesh), 1.0, "{header}");
        assert!(loaded.report.warnings.is_empty(), "{header}: {:?}", loaded.report.warnings);
    }
}

#[test]
fn strips_are_turned_by_turns_and_end_at_minus_one() {
    let folder = Folder::new("ply_strips");
    let strips = "element tristrips 1\nproperty list int int vertex_indices\n";
    let cases = [
        (strips.to_string(), "4 0 1 3 2\n", 1.0, 2),
        (strips.to_string(), "8 0 1 3 2 -1 0 1 3\n", 1.5, 3),
        // A leading -1, two in a row, a strip too short; the next strip starts unflipped again.
        (strips.to_string(), "11 -1 0 1 -1 -1 0 1 3 -1 1 2\n", 0.5, 1),
        (strips.to_string(), "9 0 1 3 -1 1 2 3 -1 0\n", 1.0, 2),
        // Repeated corners join strips; each of them flips the following triangles.
        (strips.to_string(), "7 0 1 3 3 3 1 2\n", 1.0, 2),
        (strips.to_string(), "8 0 1 3 3 1 1 2 3\n", 0.0, 2),
        (strips.replace("int int", "uchar uint"), "7 0 1 3 4294967295 1 2 3\n", 1.0, 2),
        (strips.replace("int int", "ushort uchar"), "7 0 1 3 255 1 2 3\n", 1.0, 2),
        (strips.replace("tristrips 1", "tristrips 2"), "3 0 1 3\n3 1 2 3\n", 1.0, 2),
        (format!("{strips}element face 1\n{INDICES}"), "3 0 1 3\n3 1 2 3\n", 1.0, 2),
    ];
    for (header, data, expected, count) in cases {
        let loaded = folder.load_mesh("a.ply", square(&header, data)).expect(data);
        let mesh = loaded.scene.mesh;
        assert_eq!((area(&mesh), mesh.triangle_count()), (expected, count), "{header}{data}");
        assert_eq!((loaded.report.zero_area_dropped(), loaded.report.warnings.len()), (0, 0), "{data}");
    }
}

#[test]
fn numbers_are_of_any_type_and_either_byte_order() {
    let folder = Folder::new("ply_types");
    // Types of coordinates, of list lengths and of indices; how one number is written in little endian.
    type Write = fn(i64) -> Vec<u8>;
    let types: [(&str, Write); 12] = [
        ("char", |n| (n as i8).to_le_bytes().to_vec()),
        ("uchar", |n| (n as u8).to_le_bytes().to_vec()),
        ("short", |n| (n as i16).to_le_bytes().to_vec()),
        ("ushort", |n| (n as u16).to_le_bytes().to_vec()),
        ("int", |n| (n as i32).to_le_bytes().to_vec()),
        ("uint", |n| (n as u32).to_le_bytes().to_vec()),
        ("int8", |n| (n as i8).to_le_bytes().to_vec()),
        ("uint16", |n| (n as u16).to_le_bytes().to_vec()),
        ("int64", |n| n.to_le_bytes().to_vec()),
        ("uint64", |n| n.to_le_bytes().to_vec()),
        ("float32", |n| (n as f32).to_le_bytes().to_vec()),
        ("double", |n| (n as f64).to_le_bytes().to_vec()),
    ];
    let corners: [i64; 12] = [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0];
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for shift in 0..types.len() {
            let of = |at: usize| types[(at + shift) % types.len()];
            let (coordinate, count, index, other) = (of(0), of(3), of(5), of(7));
            if ["float32", "double"].contains(&index.0) {
                continue;
            }
            let (c, n, i, o) = (coordinate.0, count.0, index.0, other.0);
            let header = format!(
                "ply\nformat {format} 1.0\nelement vertex 4\nproperty {c} x\nproperty {c} y\nproperty {c} z\n\
                 element extra 2\nproperty list {n} {o} a\nproperty {o} b\nproperty list {n} {i} c\n\
                 element face 1\nproperty {o} flag\nproperty list {n} {i} vertex_index\nproperty list {n} {o} more\n\
                 end_header\n"
            );
            let mut bytes = header.into_bytes();
            let mut put = |(_, write): (&str, Write), number: i64| match format {
                "ascii" => bytes.extend(format!("{number} ").into_bytes()),
                "binary_little_endian" => bytes.extend(write(number)),
                _ => bytes.extend(write(number).iter().rev()),
            };
            corners.iter().for_each(|&number| put(coordinate, number));
            for _ in 0..2 {
                for (kind, number) in [(count, 2), (other, 7), (other, 8), (other, 9), (count, 1), (index, 3)]
                {
                    put(kind, number);
                }
            }
            put(other, 1);
            put(count, 4);
            (0..4).for_each(|number| put(index, number));
            put(count, 0);
            let whole = bytes.len();
            let loaded =
                folder.load_mesh("a.ply", &bytes).unwrap_or_else(|fault| panic!("{format} {shift}: {fault}"));
            assert_eq!(area(&loaded.scene.mesh), 1.0, "{format} {shift}");
            if format == "ascii" {
                continue;
            }
            // Cut anywhere in its data, the file ends too early.
            let data = bytes.windows(11).position(|end| end == b"end_header\n").unwrap() + 11;
            for end in (data..whole).step_by(5).chain([whole - 1]) {
                let fault = folder.load_mesh("a.ply", &bytes[..end]).unwrap_err();
                assert!(fault.contains("the file ends here, expected "), "{format} {shift}: {fault}");
            }
        }
    }
}

#[test]
fn data_may_begin_with_the_byte_of_a_line_end() {
    let folder = Folder::new("ply_line_ends");
    for end in ["\n", "\r\n", "\r"] {
        // A first coordinate whose first byte is 10.
        let x = f32::from_le_bytes([10, 0, 0, 0]);
        let header = format!("element vertex 3\n{XYZ}element face 1\n{INDICES}");
        let header = ascii(&header, "").replace("ascii", "binary_little_endian").replace('\n', end);
        let mut bytes = header.into_bytes();
        bytes.extend(
            [x, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|number| number.to_le_bytes()),
        );
        bytes.push(3);
        bytes.extend((0..3).flat_map(i32::to_le_bytes));
        let mesh = folder.load_mesh("a.ply", bytes).unwrap().scene.mesh;
        assert_eq!(mesh.corners(0), [Vec3::new(x, 0.0, 0.0), Vec3::X, Vec3::Y], "{end:?}");
    }
}

#[test]
fn colours_of_faces_are_materials() {
    let folder = Folder::new("ply_colours");
    let faces =
        |properties: &str, rows: &str| square(&format!("element face 3\n{INDICES}{properties}"), rows);
    let colours =
        |kind: &str| ["red", "green", "blue"].map(|name| format!("property {kind} {name}\n")).concat();
    // sRGB 128 by hand (IEC 61966-2-1), to seven digits.
    let half = Vec3::new(1.0, 0.215_860_5, 0.0);
    for (properties, rows, expected) in [
        (colours("uchar"), "3 0 1 2 255 128 0\n3 0 2 3 0 0 0\n3 1 2 3 255 128 0\n", half),
        (colours("int"), "3 0 1 2 255 128 0\n3 0 2 3 -5 0 0\n3 1 2 3 300 128 0\n", half),
        (colours("ushort"), "3 0 1 2 65535 32896 0\n3 0 2 3 0 0 0\n3 1 2 3 65535 32896 0\n", half),
        (
            colours("float"),
            "3 0 1 2 1 0.25 0\n3 0 2 3 nan -1 0\n3 1 2 3 2 0.25 0\n",
            Vec3::new(1.0, 0.25, 0.0),
        ),
    ] {
        let loaded = folder.load_mesh("a.ply", faces(&properties, rows)).expect(rows);
        assert!(loaded.report.warnings.is_empty(), "{:?}", loaded.report.warnings);
        let mesh = loaded.scene.mesh;
        let albedo = |at: usize| mesh.materials[mesh.material_ids[at] as usize].albedo;
        let found = [albedo(0), albedo(1), albedo(2)];
        let expected = [expected, Vec3::ZERO, expected];
        assert!(found.iter().zip(expected).all(|(a, b)| a.abs_diff_eq(b, 1e-6)), "{properties}: {found:?}");
        // An albedo in the scene file replaces them, without warnings.
        let mesh = folder.load("[[mesh]]\nfile = \"a.ply\"\nalbedo = [0.5, 0.5, 0.5]\n").unwrap().scene.mesh;
        assert_eq!(mesh.materials, [Material { albedo: Vec3::splat(0.5), ..Material::default() }]);
    }
    let alpha = format!("{}property uchar alpha\n", colours("uchar"));
    let rows = "3 0 1 2 1 1 1 255\n3 0 2 3 1 1 1 254\n3 1 2 3 1 1 1 255\n";
    let warnings = folder.load_mesh("a.ply", faces(&alpha, rows)).unwrap().report.warnings;
    assert_eq!(warnings, ["a.ply: transparency is not supported; all is opaque"]);
    let vertices = format!("element vertex 4\n{XYZ}{}element face 1\n{INDICES}", colours("float"));
    let text = ascii(&vertices, "0 0 0 1 0 0\n1 0 0 1 0 0\n1 1 0 1 0 0\n0 1 0 1 0 0\n4 0 1 2 3\n");
    let loaded = folder.load_mesh("a.ply", text).unwrap();
    assert_eq!(loaded.report.warnings, ["a.ply: vertex colours are not used; give the mesh an albedo"]);
    let loaded = folder.load("[[mesh]]\nfile = \"a.ply\"\nalbedo = [0.5, 0.5, 0.5]\n").unwrap();
    assert!(loaded.report.warnings.is_empty());
}

#[test]
fn texture_coordinates_of_vertices_and_corners_are_used() {
    let folder = Folder::new("ply_textures");
    RgbImage::from_pixel(1, 1, Rgb([255, 0, 0])).save(folder.0.join("red one.png")).unwrap();
    RgbImage::from_pixel(1, 1, Rgb([0, 255, 0])).save(folder.0.join("green.png")).unwrap();
    let texture = "comment TextureFile red one.png\n";
    let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vec2::from_array);
    let at = |mesh: &Mesh| {
        // Texture coordinates are positions here.
        mesh.positions.iter().zip(&mesh.uvs).all(|(position, &uv)| position.truncate() == uv)
    };
    for [u, v] in [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]] {
        let header = format!(
            "{texture}element vertex 4\n{XYZ}property float {u}\nproperty float {v}\nelement face 1\n{INDICES}"
        );
        let text = ascii(&header, "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3\n");
        let loaded = folder.load_mesh("a.ply", &text).expect(u);
        assert!(loaded.report.warnings.is_empty(), "{:?}", loaded.report.warnings);
        let mesh = loaded.scene.mesh;
        assert!(at(&mesh) && mesh.uvs == uvs, "{u}");
        assert_eq!(
            mesh.materials[mesh.material_ids[0] as usize],
            Material { albedo: Vec3::ONE, texture: Some(0), ..Material::default() }
        );
        // Without a texture they are kept, without warnings.
        let loaded = folder.load_mesh("a.ply", text.replace(texture, "")).expect(u);
        assert!(at(&loaded.scene.mesh) && loaded.report.warnings.is_empty());
        assert_eq!(loaded.scene.mesh.materials[0].texture, None);
    }
    // Corners: one vertex for every pair of a position and texture coordinates.
    let header = format!("element face 2\n{INDICES}property list uchar float texcoord\n");
    let text = format!("3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 6 0 0 1 1 0.5 1\n{}", "");
    let text = square(&header, &text).replace("format ascii 1.0\n", &format!("format ascii 1.0\n{texture}"));
    let mesh = folder.load_mesh("a.ply", &text).unwrap().scene.mesh;
    let corner = |triangle: usize, corner: usize| mesh.uvs[mesh.triangles[triangle][corner] as usize];
    assert_eq!((mesh.positions.len(), corner(0, 2), corner(1, 2)), (4, Vec2::ONE, Vec2::new(0.5, 1.0)));
    assert_eq!(mesh.materials[mesh.material_ids[1] as usize].texture, Some(0));
    let apart = folder.load_mesh("a.ply", text.replace("6 0 0 1 1 0.5 1", "6 0 0.5 1 1 0.5 1")).unwrap();
    assert_eq!(apart.scene.mesh.positions.len(), 5);
    // Several textures by number, colours beside them, lists that do not fit.
    let header = format!(
        "{texture}comment TextureFile \"green.png\"\nelement vertex 4\n{XYZ}element face 3\n{INDICES}\
         property list uchar float texcoord\nproperty int texnumber\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    );
    let rows = "3 0 1 2 6 0 0 1 0 1 1 1 255 255 255\n3 0 2 3 0 0 255 0 0\n3 1 2 3 2 nan 0 -1 0 0 255\n";
    let loaded = folder.load_mesh("a.ply", ascii(&header, &format!("{SQUARE}{rows}"))).unwrap();
    let warning = "a.ply: lists `texcoord` of another length than two numbers a corner are left out: 1";
    assert_eq!(loaded.report.warnings, [warning]);
    let mesh = loaded.scene.mesh;
    let material = |at: usize| mesh.materials[mesh.material_ids[at] as usize].clone();
    let green = mesh.textures.iter().position(|texture| texture.texels[0][1] == 255).unwrap() as u32;
    assert_eq!(material(0), Material { albedo: Vec3::ONE, texture: Some(green), ..Material::default() });
    assert_eq!(material(1), Material { albedo: Vec3::X, texture: Some(1 - green), ..Material::default() });
    assert_eq!(material(2), Material { albedo: Vec3::Z, ..Material::default() });
    // Properties that cannot be used are reported.
    let square =
        |header: &str| square(header, "4 0 1 2 3\n").replace("ascii 1.0\n", &format!("ascii 1.0\n{texture}"));
    let plain = square(&format!("element face 1\n{INDICES}"));
    let warnings = folder.load_mesh("a.ply", plain).unwrap().report.warnings;
    assert_eq!(warnings, ["a.ply: the texture is not used, since there are no texture coordinates"]);
}
