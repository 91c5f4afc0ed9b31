//! Renders soft shadows from area lights, from as few shadow rays as the image needs, by stages that can be exchanged.
//!
#![doc = include_str!("picture.md")]
//!
//! Light is direct, surfaces are diffuse, lights are plain or textured parallelograms, disks, ellipses, convex
//! polygons and spheres. A frame comes down to an error target or a
//! [`Quality`](config::Quality) ([`PipelineConfig`](config::PipelineConfig)) instead of a number of samples.
//!
//! # Example
//!
#![cfg_attr(feature = "scene-files", doc = "```")]
#![cfg_attr(not(feature = "scene-files"), doc = "```ignore")]
//! use halflight::{pipeline::Pipeline, prepared::PreparedScene};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A scene of a file or of your own arrays, and the BVH over its triangles.
//! let scene = PreparedScene::new(halflight::scene_file::load_bundled("contact")?.scene)?;
//! let mut pipeline = Pipeline::builder(&scene).size(96, 64).build()?;
//! let before = pipeline.render()?.irradiance.clone();
//!
//! // The light moves; nothing that grows with the mesh is copied or built.
//! let mut lights = scene.scene().lights.clone();
//! lights[0] = lights[0].moved([1.0, 0.0, 0.0].into());
//! pipeline.set_lights(&lights)?;
//!
//! // One RGB value a pixel, W/m², row by row from the top left.
//! let image = pipeline.render()?;
//! let (x, y) = (48, 32);
//! let middle = image.irradiance[y * image.width as usize + x];
//! println!("{middle} W/m² from {} rays in {:.1} ms", image.stats.rays.total, image.stats.total_ms);
//! assert!(middle.is_finite() && image.irradiance != before);
//! # Ok(())
//! # }
//! ```
//!
//! # Types
//!
//! | purpose | type | module |
//! | --- | --- | --- |
//! | geometry, lights and camera | [`Scene`](scene::Scene), [`Mesh`](scene::Mesh), [`AreaLight`](light::AreaLight), [`Camera`](camera::Camera) | [`scene`], [`light`], [`camera`] |
//! | scenes from files | [`load`](scene_file::load), [`load_bundled`](scene_file::load_bundled), [`Animation`](scene_file::Animation) | [`scene_file`] |
//! | a scene with its BVH | [`PreparedScene`](prepared::PreparedScene) | [`prepared`] |
//! | rendering on the CPU | [`Pipeline`](pipeline::Pipeline), [`Image`](pipeline::Image) | [`pipeline`] |
//! | stages by name, with their constants | [`PipelineConfig`](config::PipelineConfig) | [`config`] |
//! | number and placement of light samples | [`LightSampling`](frame::LightSampling), [`PatternKind`](pattern::PatternKind) | [`frame`], [`pattern`] |
//! | surfaces drawn by another renderer | [`GBuffer::from_surfaces`](gbuffer::GBuffer::from_surfaces), [`Pipeline::render_gbuffer`](pipeline::Pipeline::render_gbuffer) | [`gbuffer`] |
//! | times and counts | [`FrameStats`](stats::FrameStats) | [`stats`] |
//! | stages of your own | [`Refiner`](stages::Refiner), [`Visibility`](stages::Visibility), [`Upsampler`](stages::Upsampler) | [`stages`], [`fragment`], [`mask`], [`values`] |
//! | certified regions, from a backend of your own | [`Certificate`](certificate::Certificate), [`Region`](certificate::Region) | [`certificate`] |
//! | OpenEXR files, pictures and maps | [`ExrFile`](image::ExrFile), [`picture`](image::picture) | [`image`] |
//! | error of an image, PNG files | [`compare`](metrics::compare), [`write_png`](metrics::write_png) | [`metrics`] |
//! | rendering on a wgpu device | [`Renderer`](gpu::Renderer) | [`gpu`] |
//! | vectors | [`Vec3`](glam::Vec3), [`Mat4`](glam::Mat4) | [`glam`] |
//!
//! The stages that come with the crate are in [`refine`], [`bvh`], [`beam`], [`raster4d`], [`voxel`] and [`upsample`]; all other
//! modules of the CPU are in [`cpu`].
//!
//! # Data flow
//!
//! ```text
//! scene + camera + lights
//!    │ gbuffer        position, normal, depth, albedo and triangle of what each pixel sees
//!    │ pyramid        mip chain of geometry discontinuities
//!    ▼
//! refine ◄──────────► visibility      coarse to fine: fragments and their light masks
//!    │ fragments
//!    ▼
//! irradiance         visible fraction F (or irradiance E) of every sample
//!    ▼
//! upsample           F at every pixel
//!    ▼
//! compose            F × unshadowed irradiance × radiance, summed over the lights
//!    ▼
//! antialias          pixels at edges: the mean over sub-samples, where it is asked for
//! ```
//!
//! Fragments are found for one light after another. No data of earlier frames is used.
//!
//! # Features
//!
//! | feature | default | adds | module |
//! | --- | --- | --- | --- |
//! | `scene-files` | yes | scene files, OBJ, PLY, generators, bundled scenes | [`scene_file`] |
//! | `metrics` | yes | error measures, error maps, PNG files | [`metrics`] |
//! | `image` | yes | OpenEXR files, pictures, false-colour maps; turns `metrics` on | [`image`] |
//! | `gpu` | no | the stages as compute passes of wgpu, on your device | [`gpu`] |
//!
//! Without features the crate renders scenes of your own arrays on the CPU.
//!
//! # Units and coordinate space
//!
//! | quantity | unit and convention |
//! | --- | --- |
//! | positions | metres, world space, right-handed; scene files and generators have y up; absolute values below 1e8 |
//! | depth | metres along the view direction |
//! | radiance of lights | W/m²/sr, linear RGB |
//! | irradiance | W/m², linear RGB; outgoing radiance is albedo/π · irradiance |
//! | pixels | row by row from the top left; pixel (x, y) has index y · width + x and is sampled at its centre |
//! | matrices | those of [`glam`]; [`Camera::from_matrices`](camera::Camera::from_matrices) takes right-handed views along −z |
//! | times | milliseconds |
//!
//! # Determinism
//!
//! Scene, configuration, [seed](pipeline::PipelineBuilder::seed) and
//! [frame number](pipeline::Pipeline::set_frame_index) determine a frame on the CPU bit for bit, on any number of threads and with
//! any instruction set. Frames with other numbers have other light samples. A GPU agrees with the CPU to within rounding.
//!
//! # Errors
//!
//! Constructors and setters check what they are given and return typed errors that name the light, vertex, pixel or stage at
//! fault: [`PipelineError`](pipeline::PipelineError), [`BvhError`](bvh::BvhError), [`CameraError`](camera::CameraError),
//! [`GBufferError`](gbuffer::GBufferError), [`SceneError`](scene_file::SceneError), [`GpuError`](gpu::GpuError). A setter that
//! fails changes nothing. A pipeline that was built renders without panics; a stage from outside whose fragments are
//! inconsistent gives an error. Lights that lie in a surface's plane are reported by
//! [`Pipeline::flush_lights`](pipeline::Pipeline::flush_lights). Errors and statistics are `#[non_exhaustive]`; configurations are
//! open to `..Default::default()`.
// Links to modules of features that are off lead nowhere.
#![cfg_attr(
    not(all(feature = "gpu", feature = "image", feature = "scene-files")),
    allow(rustdoc::broken_intra_doc_links)
)]

pub use halflight_core::glam;
pub use halflight_core::{
    alpha, camera, certificate, fragment, frame, gbuffer, hash, light, light_texture, mask, pattern, pyramid,
    scene, stages, stats, subpixel, values,
};
pub use halflight_cpu as cpu;
pub use halflight_cpu::{
    beam, bvh, config, flush, indirect, irradiance, pipeline, prepared, raster4d, rays, refine, unshadowed,
    upsample, voxel,
};
#[cfg(feature = "gpu")]
pub use halflight_gpu as gpu;
#[cfg(feature = "image")]
pub use halflight_image as image;
#[cfg(feature = "metrics")]
pub use halflight_metrics as metrics;
#[cfg(feature = "scene-files")]
pub use halflight_scene as scene_file;
