//! Parity of G-buffers.

use halflight::gbuffer::NO_PRIMITIVE;
use halflight::glam::{Vec2, Vec3};
use halflight::irradiance::Shading;
use halflight::scene::{Material, Scene, Texture};
use halflight_tests::{Stage, blocker_over_floor};
use std::sync::Arc;

use crate::device::Bench;
use crate::scenes::{SCENES, Twins, per_pixel};

/// Compares a rasterized G-buffer; returns the number of pixels with another triangle, or the fault of one of
/// the others.
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
        // Hits are interpolated by quotients of products that cancel where a triangle is small in the view or
        // seen at a glancing angle: a hundred units in the last place of the scene's size.
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
        let twins = Twins::render(&bench, scene, &per_pixel(160, 120, Shading::Ratio), false);
        let others = compare(&bench, &twins).unwrap_or_else(|off| panic!("{scene}: {off}"));
        // Rasterization rounds corners to 1/256 of a pixel: pixel centres that are as near to an outline may
        // see its other side. Almost all pixels are farther from all outlines.
        assert!(others * 200 < 160 * 120, "{scene}: {others}");
    }
}

#[test]
fn textures_are_decoded_and_placed_alike() {
    let Some(bench) = Bench::open() else { return };
    // All values of a channel on the floor, repeated, and another texture behind it on the blocker.
    let texel = |index: u32| [index as u8, 255 - index as u8, (index * 7) as u8, 9];
    let texture = |width, height: u32, first: u32| Texture {
        width,
        height,
        texels: (first..first + width * height).map(texel).collect(),
    };
    let mut scene: Scene = blocker_over_floor();
    let mesh = Arc::make_mut(&mut scene.mesh);
    mesh.textures = vec![texture(32, 8, 0), texture(3, 2, 100)];
    mesh.materials = vec![
        Material { albedo: Vec3::ONE, texture: Some(0), ..Material::default() },
        Material { albedo: Vec3::new(0.5, 1.0, 0.25), texture: Some(1), ..Material::default() },
    ];
    mesh.material_ids = vec![0, 0, 1, 1];
    let place = |position: &Vec3| Vec2::new(position.x * 0.13, position.z * 0.21 - 7.3);
    mesh.uvs = mesh.positions.iter().map(place).collect();
    let config = per_pixel(160, 120, Shading::Ratio);
    let mut twins = Twins::of(&bench, Stage::new(scene).unwrap(), &config, false);
    // A unit in the last place of a texture coordinate of 8, times 32 texels from black to white.
    assert!(albedo_off(&bench, &twins) < 1e-3);
    twins.alter(&bench, &config, ["resolve", "linear(channels >> 8u)", "linear(channels)"]);
    assert!(albedo_off(&bench, &twins) > 0.1);
}

/// Largest difference of albedos where both sides see one triangle.
fn albedo_off(bench: &Bench, twins: &Twins) -> f32 {
    let found: Vec<[f32; 4]> = bench.read(twins.gpu.albedo());
    let normal: Vec<[u32; 4]> = bench.read(twins.gpu.normal());
    let gbuffer = twins.cpu.gbuffer();
    let seen: Vec<usize> = (0..gbuffer.pixels())
        .filter(|&pixel| {
            gbuffer.primitive[pixel] != NO_PRIMITIVE && normal[pixel][3] == gbuffer.primitive[pixel]
        })
        .collect();
    assert!(seen.len() > gbuffer.pixels() / 2);
    let off = |pixel: usize| {
        let [r, g, b, _] = found[pixel];
        (Vec3::new(r, g, b) - gbuffer.albedo[pixel]).abs().max_element()
    };
    seen.into_iter().map(off).fold(0.0, f32::max)
}
