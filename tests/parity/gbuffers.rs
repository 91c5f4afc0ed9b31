//! What pixels see.

use halflight::gbuffer::NO_PRIMITIVE;
use halflight::glam::Vec3;
use halflight::irradiance::Shading;

use crate::device::Bench;
use crate::scenes::{SCENES, Twins, full};

/// Compares a rasterized G-buffer; returns how many pixels see another triangle, or how one of the others is off.
pub(crate) fn compare(bench: &Bench, twins: &Twins) -> Result<usize, String> {
    let gbuffer = twins.cpu.gbuffer();
    let position: Vec<[f32; 4]> = bench.read(twins.gpu.position());
    let normal: Vec<[u32; 4]> = bench.read(twins.gpu.normal());
    let mut others = 0;
    for pixel in 0..gbuffer.pixels() {
        let [x, y, z, triangle] = normal[pixel];
        if triangle != gbuffer.primitive[pixel] {
            others += 1;
            continue;
        }
        let expected = gbuffer.normal[pixel];
        if Vec3::from_array([x, y, z].map(f32::from_bits)) != expected {
            return Err(format!("pixel {pixel}: another normal than {expected}"));
        }
        let [x, y, z, depth] = position[pixel];
        if triangle == NO_PRIMITIVE {
            assert!(depth < 0.0 && !gbuffer.is_receiver(pixel));
            continue;
        }
        // Corners are mixed by quotients of products that cancel where a triangle is small in the view or seen at a
        // glancing angle: a hundred units in the last place of the scene's size.
        let slack = twins.stage.bvh.diagonal() * 100.0 / (1 << 24) as f32;
        let off = (Vec3::new(x, y, z) - gbuffer.position[pixel]).length();
        let deep = (depth - gbuffer.depth[pixel]).abs();
        let fits = off < slack && deep < slack;
        if !fits {
            return Err(format!("pixel {pixel}: off by {off} m, in depth by {deep} m, of {slack}"));
        }
    }
    Ok(others)
}

#[test]
fn pixels_see_the_same_triangles() {
    let Some(bench) = Bench::open() else { return };
    for scene in SCENES {
        let twins = Twins::render(&bench, scene, &full(160, 120, Shading::Ratio), false);
        let others = compare(&bench, &twins).unwrap_or_else(|off| panic!("{scene}: {off}"));
        // Rasterization rounds corners to 1/256 of a pixel: pixel centres that lie as near to an outline see the other side
        // of it. Every pixel but few is farther from all outlines.
        assert!(others * 200 < 160 * 120, "{scene}: {others}");
    }
}
