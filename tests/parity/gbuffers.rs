//! What pixels see.

use halflight::gbuffer::NO_PRIMITIVE;
use halflight::glam::Vec3;
use halflight::irradiance::Shading;

use crate::device::Bench;
use crate::scenes::{SCENES, Twins, full};

#[test]
fn pixels_see_the_same_triangles() {
    let Some(bench) = Bench::open() else { return };
    for scene in SCENES {
        let twins = Twins::render(&bench, scene, &full(160, 120, Shading::Ratio), false);
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
            assert_eq!(Vec3::from_array([x, y, z].map(f32::from_bits)), expected, "{scene} pixel {pixel}");
            let [x, y, z, depth] = position[pixel];
            if triangle == NO_PRIMITIVE {
                assert!(depth < 0.0 && !gbuffer.is_receiver(pixel));
                continue;
            }
            // Corners are mixed by quotients of products that cancel where a triangle is small in the view or seen at a
            // glancing angle: a hundred units in the last place of the scene's size.
            let slack = gbuffer.scene_size * 100.0 / (1 << 24) as f32;
            let off = (Vec3::new(x, y, z) - gbuffer.position[pixel]).length();
            assert!(off < slack, "{scene} pixel {pixel}: {off} m of {slack}");
            let off = (depth - gbuffer.depth[pixel]).abs();
            assert!(off < slack, "{scene} pixel {pixel}: depth off by {off} m of {slack}");
        }
        // Rasterization rounds corners to 1/256 of a pixel: pixel centres that lie as near to an outline see the other side
        // of it. Every pixel but few is farther from all outlines.
        assert!(others * 200 < gbuffer.pixels(), "{scene}: {others}");
    }
}
