//! Material libraries as programs write them: supported statements, and warnings about the rest.

#![allow(clippy::panic, reason = "helpers of tests fail their test")]

mod common;

use common::Folder;
use glam::{Vec2, Vec3};
use halflight_core::scene::Mesh;
use image::{Rgb, RgbImage};

const RED: Vec3 = Vec3::new(0.9, 0.1, 0.1);
const GREY: Vec3 = Vec3::splat(0.8);
const FACE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n";

fn albedo(mesh: &Mesh, triangle: usize) -> Vec3 {
    mesh.materials[mesh.material_ids[triangle] as usize].albedo
}

/// The colour of the first face, and the warnings, of a file that uses `red` of a library.
fn red(folder: &Folder, library: &str) -> (Vec3, Vec<String>) {
    folder.write("a.mtl", library);
    let obj = format!("mtllib a.mtl\nusemtl red\n{FACE}");
    let loaded = folder.load_mesh("a.obj", obj).unwrap_or_else(|fault| panic!("{library}: {fault}"));
    (albedo(&loaded.scene.mesh, 0), loaded.report.warnings)
}

#[test]
fn a_bad_line_costs_itself() {
    let folder = Folder::new("bad_lines");
    let left_out = "; the line is left out";
    // A library, the albedo of `red`, and the warning.
    let cases: [(&str, Vec3, String); 16] = [
        ("newmtl red\nKd 0.9 0.1 0.1 # brick\n", RED, String::new()),
        ("newmtl red\nKd 0.9 0.1 0.1#brick\nillum 2 # 4\nd 1 # 0.5\n", RED, String::new()),
        ("  newmtl\tred\n\tkd\t0.9\t0.1 \\\n0.1\n", RED, String::new()),
        (
            "newmtl red\nKd 0.9 0.1 0.1 1.0\n",
            RED,
            "a.mtl: `Kd 0.9 0.1 0.1 1.0` on line 2 has more than three numbers; the rest is not used".into(),
        ),
        (
            "newmtl red\nKd 0.9 0.1 0.1 red\n",
            RED,
            "a.mtl: `Kd 0.9 0.1 0.1 red` on line 2 has more than three numbers; the rest is not used".into(),
        ),
        ("newmtl red\nKd 0.5\n", Vec3::splat(0.5), String::new()),
        (
            "newmtl red\nKd 0.9 0.1 0.1\nKd 0.5 0.5\n",
            RED,
            format!("a.mtl:3: `Kd 0.5 0.5`, expected one or three finite numbers{left_out}"),
        ),
        ("newmtl red\nKd\n", GREY, format!("a.mtl:2: `Kd `, expected one or three finite numbers{left_out}")),
        (
            "newmtl red\nKd 1 2 red\n",
            GREY,
            format!("a.mtl:2: `Kd 1 2 red`, expected one or three finite numbers{left_out}"),
        ),
        (
            "newmtl red\nKd nan 0 0\nKd 1.#QNAN 0 0\nKd 0,9 0,1 0,1\n",
            GREY,
            "a.mtl:2: `Kd nan 0 0`, expected one or three finite numbers; 3 such lines are left out".into(),
        ),
        (
            "newmtl red\nKd 0.9 0.1 0.1\nmap_Kd\n",
            RED,
            format!("a.mtl:3: map_Kd without a file; expected: map_Kd FILE{left_out}"),
        ),
        (
            "newmtl red\nKd 0.9 0.1 0.1\nmap_Kd -s 1 1 # none\n",
            RED,
            format!("a.mtl:3: map_Kd without a file; expected: map_Kd FILE{left_out}"),
        ),
        (
            "Kd 1 1 1\nnewmtl red\nKd 0.9 0.1 0.1\n",
            RED,
            format!("a.mtl:1: a statement before the first newmtl{left_out}"),
        ),
        ("newmtl\nKd 0.2\nnewmtl red\nKd 0.9 0.1 0.1\n", RED, String::new()),
        ("newmtl red\nKd 0.2\nnewmtl red\nKd 0.9 0.1 0.1\n", RED, String::new()),
        ("", GREY, "a.obj: material `red` on line 2 is not defined; grey is used instead".into()),
    ];
    for (library, colour, warning) in cases {
        let warnings = if warning.is_empty() { vec![] } else { vec![warning] };
        assert_eq!(red(&folder, library), (colour, warnings), "{library}");
    }
}

#[test]
fn glass_is_said_to_be_opaque_however_it_is_written() {
    let folder = Folder::new("glass");
    let opaque = "a.mtl: transparency is not supported; all is opaque";
    for glass in [
        "d 0.2",
        "d -halo 0.2",
        "D 0.2",
        "Tr 0.8",
        "Tf 0.1 0.1 0.1\nillum 4",
        "illum 6\nTf 0.9",
        "illum 7",
        "illum 9",
        "illum 5\nTf 1 1 1",
        "illum 8\nTf spectral a.rfl",
        "Tf xyz 1 1 1\nillum 4 # glass",
    ] {
        for library in
            [format!("newmtl red\n{glass}\n"), format!("newmtl red\nnewmtl glass\n{glass}\nnewmtl b\n")]
        {
            assert_eq!(red(&folder, &library).1, [opaque], "{library}");
        }
    }
    for solid in ["d 1", "d -halo 1.0", "Tr 0", "Tf 1 1 1\nillum 2", "illum 5", "illum 8\nTf 0 0 0", "illum"]
    {
        let library = format!("newmtl red\n{solid}\nnewmtl b\nillum 2\n");
        assert!(red(&folder, &library).1.is_empty(), "{library}");
    }
}

#[test]
fn names_are_found_with_comments_and_quotation_marks_wherever_the_library_stands() {
    let folder = Folder::new("names");
    folder.write(
        "red.mtl",
        "newmtl red # brick\nKd 0.9 0.1 0.1\nnewmtl red #1\nKd 0 1 0\nnewmtl \"two words\"\nKd 0 0 1\n",
    );
    folder.write("two words.mtl", "newmtl red\nKd 0.9 0.1 0.1\n");
    folder.write("other.mtl", "newmtl red\nKd 1 1 1\n");
    folder.write("nameless.mtl", "newmtl\nKd 0 1 0\nnewmtl red\nKd 0.9 0.1 0.1\n");
    // Text before and behind the face, and the face's colour.
    let cases = [
        ("mtllib red.mtl\nusemtl red\n", "", RED),
        ("usemtl red\nmtllib red.mtl\n", "", RED),
        ("usemtl red\n", "mtllib red.mtl\n", RED),
        ("usemtl red # here\n", "mtllib red.mtl # there\n", RED),
        ("usemtl red# here\n", "mtllib red.mtl\n", GREY),
        ("usemtl \"red\"\n", "mtllib \"red.mtl\"\n", RED),
        ("usemtl\tred #1 \n", "mtllib red.mtl\n", Vec3::Y),
        ("usemtl red #1 # here\n", "mtllib red.mtl\n", Vec3::Y),
        ("usemtl two words\n", "mtllib RED.MTL\n", Vec3::Z),
        ("usemtl \"two words\"# here\n", "mtllib red.mtl\n", GREY),
        ("usemtl 'two words' # here\n", "mtllib C:\\models\\red.mtl\n", Vec3::Z),
        ("usemtl red\n", "mtllib two words.mtl\n", RED),
        ("usemtl red\n", "mtllib red.mtl\nmtllib red.mtl\n", RED),
        ("mtllib other.mtl red.mtl\nusemtl red\n", "", Vec3::ONE),
        ("mtllib other.mtl\nusemtl red\n", "mtllib two words.mtl\nusemtl red\nf 1 2 3\n", Vec3::ONE),
        ("mtllib other.mtl\nmtllib two words.mtl\nusemtl red\n", "", RED),
        ("mtllib \"two words.mtl\" other.mtl\nusemtl red\n", "", RED),
        ("mtllib nameless.mtl\n", "", GREY),
        ("mtllib nameless.mtl\nusemtl\n", "", Vec3::Y),
        ("mtllib red.mtl\nusemtl red\nusemtl\n", "", GREY),
        ("mtllib red.mtl\nusemtl red\nusemtl # none\n", "", GREY),
        ("usemtl\n", "", GREY),
    ];
    for (before, behind, colour) in cases {
        let text = format!("{before}{FACE}{behind}");
        let loaded = folder.load_mesh("a.obj", &text).expect(&text);
        assert_eq!(albedo(&loaded.scene.mesh, 0), colour, "{text}");
        // Names that fall back to grey are reported.
        let undefined = before.contains('#') && colour == GREY && !before.contains("none");
        assert_eq!(
            loaded.report.warnings.len(),
            usize::from(undefined),
            "{text}: {:?}",
            loaded.report.warnings
        );
    }
    // One warning for many names, and none where their library may be missing.
    let many: String = (0..100).map(|at| format!("usemtl q{}\nf 1 2 3\n", at % 50)).collect();
    let loaded = folder.load_mesh("a.obj", format!("{FACE}usemtl red\n{many}mtllib red.mtl\n")).unwrap();
    let warning = "a.obj: 50 materials are not defined, the first is `q0` on line 9; grey is used instead";
    assert_eq!(loaded.report.warnings, [warning]);
    let loaded = folder.load_mesh("a.obj", format!("{FACE}{many}mtllib gone.mtl\n")).unwrap();
    assert_eq!(
        loaded.report.warnings,
        ["a.obj: material library `gone.mtl` is missing in .; grey is used instead"]
    );
}

#[test]
fn textures_are_found_by_all_forms_of_their_names_and_placed_by_their_options() {
    let folder = Folder::new("map_options");
    let image = RgbImage::from_pixel(1, 1, Rgb([255; 3]));
    for name in ["t.png", "two words.png", "t #1.png", "\"q\".png", "-s.png"] {
        image.save(folder.0.join(name)).unwrap();
    }
    // Arguments of map_Kd, the texture coordinates of the corner (1, 1), and the options reported as not
    // supported.
    let cases: [(&str, [f32; 2], &[&str]); 26] = [
        ("t.png", [1.0, 1.0], &[]),
        ("t.png # brick", [1.0, 1.0], &[]),
        ("\"t.png\"", [1.0, 1.0], &[]),
        ("\"two words.png\" # brick", [1.0, 1.0], &[]),
        ("t #1.png", [1.0, 1.0], &[]),
        ("\"q\".png", [1.0, 1.0], &[]),
        ("-s.png", [1.0, 1.0], &[]),
        ("-s 2 3 1 t.png", [2.0, 3.0], &[]),
        ("-s 2 t.png", [2.0, 1.0], &[]),
        ("-s 2 3 two words.png", [2.0, 3.0], &[]),
        ("-o 0.5 -0.25 0 t.png", [1.5, 0.75], &[]),
        ("-o -1 t.png", [0.0, 1.0], &[]),
        ("-o 0.5 0.25 -s 2 4 t.png", [2.5, 4.25], &[]),
        ("-s 2 4 1 -o 0.5 0.25 0 \"t.png\"", [2.5, 4.25], &[]),
        ("-S 2 2 1 T.PNG", [2.0, 2.0], &[]),
        ("t.png -s 2 3 1 # brick", [2.0, 3.0], &[]),
        ("two words.png -o 1 0 0 -s 2 3 1", [3.0, 3.0], &[]),
        ("-clamp on -s 2 2 t.png", [2.0, 2.0], &["-clamp"]),
        ("-clamp off -blendu on -blendv on -cc off -mm 0 1 -t 0 0 0 -bm 2 t.png", [1.0, 1.0], &[]),
        ("-blendu off -blendv off t.png", [1.0, 1.0], &["-blendu", "-blendv"]),
        ("-mm 0.5 2 t.png", [1.0, 1.0], &["-mm"]),
        ("-t 0.1 0.1 t.png", [1.0, 1.0], &["-t"]),
        ("-texres 256 -cc on t.png", [1.0, 1.0], &["-texres", "-cc"]),
        ("-imfchan m -boost 1 t.png", [1.0, 1.0], &["-imfchan", "-boost"]),
        ("-s nan 1 1 t.png", [1.0, 1.0], &["-s"]),
        ("-s 1e30 1 -o 1 t.png", [1e30, 1.0], &[]),
    ];
    for (arguments, uv, ignored) in cases {
        folder.write("a.mtl", format!("newmtl a\nmap_Kd {arguments}\nnewmtl b\n"));
        let obj = format!("mtllib a.mtl\n{FACE}usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 2/2 3/3\n");
        let loaded = folder.load_mesh("a.obj", obj).expect(arguments);
        let warnings =
            ignored.iter().map(|option| format!("a.mtl: option {option} of map_Kd is not supported"));
        assert_eq!(loaded.report.warnings, warnings.collect::<Vec<_>>(), "{arguments}");
        let mesh = loaded.scene.mesh;
        let at = |triangle: usize| mesh.uvs[mesh.triangles[triangle][2] as usize];
        // The faces of other materials share corners and keep theirs.
        assert_eq!([at(0), at(1), at(2)], [Vec2::ONE, Vec2::from_array(uv), Vec2::ONE], "{arguments}");
        assert_eq!(mesh.materials[mesh.material_ids[1] as usize].texture, Some(0), "{arguments}");
    }
    folder.write("a.mtl", "newmtl red\nKd 0.9 0.1 0.1\nmap_Kd -s 2 2 1 \"gone.png\" # brick\n");
    let (colour, warnings) =
        red(&folder, "newmtl red\nKd 0.9 0.1 0.1\nmap_Kd -s 2 2 1 \"gone.png\" # brick\n");
    assert_eq!(
        (colour, warnings),
        (RED, vec!["a.mtl:3: texture `gone.png` is missing in .; its colour is used alone".into()])
    );
}

#[test]
fn textures_take_four_bytes_a_texel_of_whatever_kind_they_are() {
    let folder = Folder::new("texture_kinds");
    folder.write("a.mtl", "newmtl red\nmap_Kd a.png\n");
    let load = || folder.load_mesh("a.obj", format!("mtllib a.mtl\nusemtl red\n{FACE}")).unwrap();
    let kinds = [
        (image::DynamicImage::new_luma8(3, 2), [7, 7, 7, 255]),
        (image::DynamicImage::new_luma_a8(3, 2), [7, 7, 7, 200]),
        (image::DynamicImage::new_rgb8(3, 2), [7, 8, 9, 255]),
        (image::DynamicImage::new_rgba8(3, 2), [7, 8, 9, 200]),
        (image::DynamicImage::new_luma16(3, 2), [7, 7, 7, 255]),
        (image::DynamicImage::new_luma_a16(3, 2), [7, 7, 7, 200]),
        (image::DynamicImage::new_rgb16(3, 2), [7, 8, 9, 255]),
        (image::DynamicImage::new_rgba16(3, 2), [7, 8, 9, 200]),
    ];
    for (kind, expected) in kinds {
        let colour = kind.color();
        let mut bytes = vec![0; kind.as_bytes().len()];
        let channels = usize::from(colour.channel_count());
        for (at, texel) in bytes.chunks_exact_mut(usize::from(colour.bytes_per_pixel())).enumerate() {
            let whole = if channels < 3 { [7, 200, 0, 0] } else { [7, 8, 9, 200] };
            // The second texel is black, so that none is mixed up with another.
            let values = whole.map(|value: u8| if at == 1 { 0 } else { value });
            for (channel, value) in
                texel.chunks_exact_mut(usize::from(colour.bytes_per_pixel()) / channels).zip(values)
            {
                channel.fill(value);
            }
        }
        image::save_buffer(folder.0.join("a.png"), &bytes, 3, 2, colour).unwrap();
        let loaded = load();
        let texels = &loaded.scene.mesh.textures[0].texels;
        assert_eq!((texels.len(), texels[0], texels[5]), (6, expected, expected), "{colour:?}");
        assert_eq!(texels[1][..3], [0; 3], "{colour:?}");
        assert_eq!(loaded.report.warnings.len(), usize::from(expected[3] != 255), "{colour:?}");
    }
    // An image of more texels than allowed: the header of a BMP file with its size.
    let mut head = b"BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0".to_vec();
    head.extend([20_000u32, 20_000].iter().flat_map(|side| side.to_le_bytes()));
    head.extend([1, 0, 24, 0]);
    head.extend([0; 24]);
    folder.write("a.png", head);
    let warning = "a.mtl:2: texture a.png cannot be read (20000 x 20000 texels, more than the limit of 268435456, 16384 x 16384); \
                   its colour is used alone";
    assert_eq!(load().report.warnings, [warning]);
}
