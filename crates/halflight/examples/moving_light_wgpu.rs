//! A light that moves over a scene, on a wgpu device of this program's own: 8 frames, 8 pictures.
//!
//! `cargo run -p halflight --features gpu --example moving_light_wgpu [FOLDER]` compiles the stages once; every frame sets the
//! light and records.

use std::error::Error;
use std::path::PathBuf;

use halflight::config::PipelineConfig;
use halflight::glam::Vec3;
use halflight::gpu::{Gpu, Inputs, Renderer, wgpu};
use halflight::light::AreaLight;
use halflight::{metrics, scene_file};

/// Frames, and how far the light moves from each to the next.
const FRAMES: u32 = 8;
const STEP: Vec3 = Vec3::new(0.15, 0.0, 0.05);

/// Opens a device with WebGPU's limits. An engine has its own.
fn open() -> Result<Gpu, Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))?;
    Ok(Gpu { adapter, device, queue })
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map_or_else(PathBuf::new, PathBuf::from);
    let scene = scene_file::load_bundled("toys")?.scene;
    let config = PipelineConfig { width: 480, height: 320, ..PipelineConfig::default() };
    let gpu = open()?;
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &scene, &config)?;
    let rgb = |[r, g, b, _]: [f32; 4]| Vec3::new(r, g, b);
    for frame in 0..FRAMES {
        let moved = |light: &AreaLight| light.moved(STEP * frame as f32);
        let lights: Vec<AreaLight> = scene.lights.iter().map(moved).collect();
        renderer.set_lights(&lights)?;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.record(&mut encoder, &Inputs { frame, ..Inputs::default() })?;
        gpu.queue.submit([encoder.finish()]);

        // An engine shows the image on the device, by `Renderer::present` or a shader of its own.
        let irradiance: Vec<[f32; 4]> = gpu.read(renderer.image())?;
        let albedos: Vec<[f32; 4]> = gpu.read(renderer.albedo())?;
        let lit = irradiance.into_iter().zip(albedos).map(|(e, a)| rgb(e) * rgb(a));
        let picture = folder.join(format!("moving_light_{frame}.png"));
        let shown = metrics::tone_map(&lit.collect::<Vec<Vec3>>(), 0.3);
        metrics::write_png(&picture, config.width, config.height, &shown)?;
        println!("{}", picture.display());
    }
    Ok(())
}
