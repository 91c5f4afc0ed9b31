use naga::TypeInner;

use super::permutations::{named, parsed};
use crate::frame::{Frame, GpuPattern};
use crate::light::TurnedLight;
use crate::masked::{MaskedHead, MaskedTriangle};
use crate::refine::Choice;
use crate::scene::GpuMaterial;
use crate::visibility::Space;

/// Checks members' offsets and the size of a structure against naga's.
macro_rules! check {
    ($module:expr, $name:literal, $kind:ty, $($member:ident),+) => {{
        let (members, span) = structure($module, $name);
        let expected = [$((stringify!($member), std::mem::offset_of!($kind, $member) as u32)),+];
        assert_eq!(members, expected.map(|(name, offset)| (name.to_owned(), offset)), $name);
        assert_eq!(span as usize, size_of::<$kind>(), $name);
    }};
}

fn structure(module: &naga::Module, name: &str) -> (Vec<(String, u32)>, u32) {
    let found = module.types.iter().find(|(_, kind)| kind.name.as_deref() == Some(name));
    let (_, kind) = found.unwrap_or_else(|| panic!("no structure {name}"));
    let TypeInner::Struct { members, span } = &kind.inner else { panic!("{name} is no structure") };
    (members.iter().map(|member| (member.name.clone().unwrap(), member.offset)).collect(), *span)
}

#[test]
fn structures_are_laid_out_alike() {
    let module = &parsed(&named("per-pixel")).0;
    check!(module, "Pattern", GpuPattern, kind, columns, rows, count, words, stride, scale);
    check!(
        module,
        "Frame",
        Frame,
        eye,
        width,
        corner,
        height,
        right,
        level,
        down,
        scene_size,
        light_corner,
        light_area,
        light_u,
        two_sided,
        light_v,
        light,
        light_cross,
        key,
        light_normal,
        sharing,
        radiance,
        capacity,
        pattern,
        depth_break,
        curvature_break,
        enough,
        coarsest,
        slots,
        split_above,
        gradient_above,
        depth_finest,
        surface,
        crease_sine,
        pixel_footprint,
        error,
        step_level,
        lights,
        sides,
        largest,
        shading,
        levels,
        outline,
        outline_corners,
        outline_sides,
        mean_radiance,
        texture,
        texture_size
    );
    check!(&parsed(&named("error target: choose")).0, "Choice", Choice, pattern, error, coarsest, every);
    let module = &parsed(&named("voxel: masks")).0;
    check!(module, "TurnedLight", TurnedLight, corner, u, v, normal);
    // Lights follow at once, as many as there are.
    let (members, _) = structure(module, "Space");
    let offsets: Vec<usize> = members.iter().map(|(_, offset)| *offset as usize).collect();
    let expected = [
        std::mem::offset_of!(Space, across),
        std::mem::offset_of!(Space, lights_deepest),
        std::mem::offset_of!(Space, down),
        std::mem::offset_of!(Space, texel_right),
        std::mem::offset_of!(Space, texel_up),
        std::mem::offset_of!(Space, forward),
        size_of::<Space>(),
    ];
    assert_eq!(offsets, expected);
    let (members, span) = structure(&parsed(&named("resolve")).0, "Material");
    // Its last eight bytes have no name in the shader.
    assert_eq!(members.len(), 3);
    assert_eq!(members[1].1 as usize, std::mem::offset_of!(GpuMaterial, texels));
    assert_eq!(members[2].1 as usize, std::mem::offset_of!(GpuMaterial, size));
    assert_eq!(span as usize, size_of::<GpuMaterial>());
    let module = &parsed(&named("hide")).0;
    let (members, _) = structure(module, "Masked");
    let offsets: Vec<usize> = members.iter().map(|(_, offset)| *offset as usize).collect();
    // Triangles follow at once.
    let expected = [
        std::mem::offset_of!(MaskedHead, root),
        std::mem::offset_of!(MaskedHead, first),
        size_of::<MaskedHead>(),
    ];
    assert_eq!(offsets, expected);
    check!(module, "MaskedTriangle", MaskedTriangle, a, b, c, size, texels);
}
