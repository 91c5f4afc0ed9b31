//! Pictures that a renderer draws into textures, against those of the program.

use std::sync::Arc;

use halflight::glam::Vec3;
use halflight::image::picture;
use halflight::irradiance::Shading;
use halflight::light::AreaLight;
use halflight::metrics::tone_map;
use halflight::scene::{Scene, Specular};
use halflight_gpu::{Inputs, Renderer, wgpu};
use halflight_tests::{Stage, blocker_over_floor};

use crate::device::Bench;
use crate::scenes::{bundled, per_pixel};

/// Rows of 64 texels of 4 bytes are 256 bytes, which copies to buffers need.
const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;

/// Bytes of a texture that a renderer has drawn the last frame into. Rows must be multiples of 256 bytes.
pub(crate) fn presented(bench: &Bench, renderer: &mut Renderer, format: wgpu::TextureFormat) -> Vec<u8> {
    let device = &bench.gpu.device;
    let (width, height) = renderer.size();
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let row = width * format.block_copy_size(None).unwrap();
    let copy = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    renderer.present(&mut encoder, &view, format).unwrap();
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &copy, layout };
    encoder.copy_texture_to_buffer(target.as_image_copy(), to, size);
    bench.gpu.queue.submit([encoder.finish()]);
    bench.read(&copy)
}

/// A coloured and textured room, glossy toys, a lamp that is seen, and both.
fn scenes() -> Vec<(&'static str, Scene)> {
    let glossy = |scene: &Scene| {
        let mut scene = scene.clone();
        for material in &mut Arc::make_mut(&mut scene.mesh).materials {
            material.specular = Some(Specular { roughness: 0.3, ..Specular::default() });
        }
        scene
    };
    let lamp = AreaLight::sphere(Vec3::new(0.4, 0.9, 0.2), 0.3, Vec3::new(0.8, 0.4, 0.1)).visible();
    let toys = Scene::clone(&bundled("few toys").scene);
    let floor = Scene { lights: vec![lamp], ..blocker_over_floor() };
    let both = glossy(&floor);
    vec![("matte", toys.clone()), ("glossy", glossy(&toys)), ("lamp", floor), ("glossy and lamp", both)]
}

#[test]
fn pictures_are_those_of_the_program() {
    let Some(bench) = Bench::open() else { return };
    for (name, scene) in scenes() {
        let stage = Stage::new(scene).unwrap();
        let mut gpu = bench.renderer(&stage.scene, &per_pixel(WIDTH, HEIGHT, Shading::Ratio)).unwrap();
        bench.render(&mut gpu, &Inputs::default());
        let (image, gbuffer) = bench.gpu.download(&gpu).unwrap();
        let radiance = match image.radiance.is_empty() {
            true => picture::radiance(&image.irradiance, &gbuffer.albedo),
            false => image.radiance.clone(),
        };
        let found = presented(&bench, &mut gpu, wgpu::TextureFormat::Rgba32Float);
        for (found, expected) in bytemuck::cast_slice::<u8, [f32; 4]>(&found).iter().zip(&radiance) {
            let off = (Vec3::new(found[0], found[1], found[2]) - *expected).abs();
            // Products in another order.
            assert!(off.cmple(1e-6 * *expected).all(), "{name}: {found:?} {expected}");
        }
        let expected = tone_map(&radiance, picture::EXPOSURE);
        let irradiance = tone_map(&image.irradiance, picture::EXPOSURE);
        for format in [
            wgpu::TextureFormat::Rgba8UnormSrgb,
            wgpu::TextureFormat::Rgba8Unorm,
            wgpu::TextureFormat::Bgra8Unorm,
        ] {
            let found = presented(&bench, &mut gpu, format);
            let channel = |texel: usize, axis: usize| {
                let turned = format == wgpu::TextureFormat::Bgra8Unorm;
                found[4 * texel + if turned { 2 - axis } else { axis }]
            };
            let off = |expected: &[[u8; 3]]| {
                let pixel = |(pixel, rgb): (usize, &[u8; 3])| {
                    (0..3).map(|axis| channel(pixel, axis).abs_diff(rgb[axis])).max().unwrap_or(0)
                };
                expected.iter().enumerate().map(pixel).max().unwrap_or(0)
            };
            // Devices round and encode a little differently.
            assert!(off(&expected) <= 1, "{name} {format:?}: {}", off(&expected));
            // A picture of the irradiance is another one.
            assert!(off(&irradiance) > 20, "{name} {format:?}");
        }
    }
}

/// A renderer whose lights change between visible and not draws the right picture each time.
#[test]
fn pictures_follow_the_lights() {
    let Some(bench) = Bench::open() else { return };
    let stage = Stage::new(blocker_over_floor()).unwrap();
    let mut gpu = bench.renderer(&stage.scene, &per_pixel(WIDTH, HEIGHT, Shading::Ratio)).unwrap();
    let lamp = AreaLight::sphere(Vec3::new(0.4, 0.9, 0.2), 0.3, Vec3::new(0.8, 0.4, 0.1));
    let mut shown = |light: AreaLight| {
        gpu.set_lights(&[light]).unwrap();
        bench.render(&mut gpu, &Inputs::default());
        presented(&bench, &mut gpu, wgpu::TextureFormat::Rgba8UnormSrgb)
    };
    let (dark, seen, again) = (shown(lamp), shown(lamp.visible()), shown(lamp));
    assert_eq!(dark, again);
    let lit = dark.chunks(4).zip(seen.chunks(4)).filter(|(dark, seen)| dark != seen).count();
    assert!((20..WIDTH as usize * HEIGHT as usize / 2).contains(&lit), "{lit}");
}
