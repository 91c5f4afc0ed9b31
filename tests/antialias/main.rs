//! Antialiasing: against frames of shifted cameras, and against frames without it.

#![allow(clippy::unwrap_used)]

use halflight::camera::Camera;
use halflight::config::{PipelineConfig, RefinerConfig};
use halflight::gbuffer::GBuffer;
use halflight::glam::{Vec2, Vec3};
use halflight::image::picture;
use halflight::irradiance::Shading;
use halflight::metrics::{Image, nmse2};
use halflight::pipeline::{self, Pipeline, PipelineError};
use halflight::scene::Scene;
use halflight::subpixel;
use halflight_tests::{Stage, blocker_over_floor, square_light};

const WIDTH: u32 = 160;
const HEIGHT: u32 = 120;

fn config(antialias: u32) -> PipelineConfig {
    PipelineConfig { width: WIDTH, height: HEIGHT, antialias, ..PipelineConfig::default() }
}

/// Stage seen by a camera that is shifted by a part of a pixel.
fn shifted(stage: &Stage, offset: Vec2) -> Stage {
    let camera = subpixel::shifted(&stage.scene.camera, offset, WIDTH, HEIGHT);
    let scene = Scene { camera, ..Scene::clone(&stage.scene) };
    Stage { prepared: stage.prepared.moved(scene).unwrap(), ..stage.clone() }
}

/// Radiance of an image and its G-buffer.
fn rendered(stage: &Stage, config: &PipelineConfig, frame: u32) -> (pipeline::Image, GBuffer, Vec<Vec3>) {
    let mut pipeline = config.builder(&stage.prepared).build().unwrap();
    pipeline.set_frame_index(frame);
    let image = pipeline.render().unwrap().clone();
    let gbuffer = pipeline.gbuffer().clone();
    let radiance = match config.antialias {
        1 => picture::radiance(&image.irradiance, &gbuffer.albedo),
        _ => image.radiance.clone(),
    };
    (image, gbuffer, radiance)
}

/// Mean of the radiance over `count` sub-samples of every pixel, each with shadow rays of its own.
fn every_sub_sample(stage: &Stage, count: u32) -> Vec<Vec3> {
    let config = PipelineConfig { refiner: RefinerConfig::PerPixel, ..config(1) };
    let mut mean = vec![Vec3::ZERO; (WIDTH * HEIGHT) as usize];
    for (frame, &offset) in (1000..).zip(subpixel::offsets(count).unwrap()) {
        let (_, _, radiance) = rendered(&shifted(stage, offset), &config, frame);
        mean.iter_mut().zip(radiance).for_each(|(mean, radiance)| *mean += radiance / count as f32);
    }
    mean
}

fn error(image: &[Vec3], reference: &[Vec3]) -> f64 {
    let view = |pixels| Image::new(WIDTH, HEIGHT, pixels).unwrap();
    nmse2(view(image), view(reference)).unwrap()
}

/// Mean absolute difference of two images.
fn difference(a: &[Vec3], b: &[Vec3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().element_sum()).sum::<f32>() / a.len() as f32
}

#[test]
fn edges_are_those_of_frames_in_which_every_sub_sample_is_traced() {
    for (name, times) in [("contact", 8.0), ("toys", 4.0), ("atrium", 6.0)] {
        let stage = Stage::bundled(name).unwrap();
        let reference = every_sub_sample(&stage, 8);
        let [without, with] = [1, 8].map(|count| error(&rendered(&stage, &config(count), 0).2, &reference));
        println!("{name}: {without:.2e} without, {with:.2e} with");
        assert!(with * times < without, "{name}: {with} {without}");
    }
}

#[test]
fn pixels_of_one_surface_are_left_as_they_are() {
    for stage in [Stage::bundled("contact").unwrap(), Stage::new(blocker_over_floor()).unwrap()] {
        let (plain, _, plain_radiance) = rendered(&stage, &config(1), 0);
        assert!(plain.radiance.is_empty());
        let (image, gbuffer, radiance) = rendered(&stage, &config(8), 0);
        let counts = image.stats.antialias;
        let changed = |pixel: &usize| {
            image.irradiance[*pixel] != plain.irradiance[*pixel] || radiance[*pixel] != plain_radiance[*pixel]
        };
        let changed: Vec<usize> = (0..gbuffer.pixels()).filter(changed).collect();
        assert!(!changed.is_empty() && changed.len() as u64 <= counts.resolved_pixels);
        assert!(
            counts.resolved_pixels < counts.edge_pixels && counts.edge_pixels * 4 < gbuffer.pixels() as u64
        );
        // Every one of them sees something else than one of its neighbours.
        for pixel in changed {
            let (x, y) = (pixel as u32 % WIDTH, pixel as u32 / WIDTH);
            let near = (y.saturating_sub(1)..=(y + 1).min(HEIGHT - 1))
                .flat_map(|y| (x.saturating_sub(1)..=(x + 1).min(WIDTH - 1)).map(move |x| (x, y)));
            let differs = |(x, y)| gbuffer.primitive[gbuffer.index(x, y)] != gbuffer.primitive[pixel];
            assert!(near.into_iter().any(differs), "({x}, {y})");
        }
    }
}

#[test]
fn images_do_not_depend_on_the_number_of_threads() {
    let stage = Stage::bundled("toys").unwrap();
    for antialias in [4, 16] {
        let render = |threads: usize| {
            let builder = config(antialias).builder(&stage.prepared);
            builder.threads(threads).build().unwrap().render().unwrap().clone()
        };
        let (one, many) = (render(1), render(5));
        assert_eq!(one.radiance, many.radiance);
        assert_eq!(one.irradiance, many.irradiance);
        assert_eq!(one.stats.antialias, many.stats.antialias);
    }
}

#[test]
fn shifts_by_parts_of_a_pixel_change_less() {
    for name in ["contact", "atrium"] {
        let stage = Stage::bundled(name).unwrap();
        let change = |antialias: u32| {
            let frames: Vec<Vec<Vec3>> = (0..4)
                .map(|step| shifted(&stage, Vec2::new(0.25, 0.125) * step as f32))
                .map(|stage| rendered(&stage, &config(antialias), 0).2)
                .collect();
            // A smooth change goes the same way in both halves of two steps; what flickers does not.
            let jump = |three: &[Vec<Vec3>]| {
                let middle: Vec<Vec3> =
                    three[0].iter().zip(&three[2]).map(|(before, after)| (*before + *after) * 0.5).collect();
                difference(&three[1], &middle)
            };
            frames.windows(3).map(jump).sum::<f32>()
        };
        let [without, with] = [1, 8].map(change);
        println!("{name}: {without:.2e} without, {with:.2e} with");
        // The rest is mostly the noise of shadows.
        assert!(with * 1.4 < without, "{name}: {with} {without}");
    }
}

#[test]
fn several_lights_cameras_and_shadings() {
    let mut scene = blocker_over_floor();
    scene.lights.push(square_light(Vec3::new(1.5, 3.0, 0.5), 0.5));
    let stage = Stage::new(scene).unwrap();
    let ratio = rendered(&stage, &config(8), 0).2;
    let sampled = rendered(&stage, &PipelineConfig { shading: Shading::Sampled, ..config(8) }, 0).2;
    assert!(error(&sampled, &ratio) < 2e-3, "{}", error(&sampled, &ratio));
    // Lights add up, at edges too.
    let mut pipeline = config(8).builder(&stage.prepared).build().unwrap();
    let mut sum = vec![Vec3::ZERO; ratio.len()];
    for light in &stage.scene.lights {
        pipeline.set_lights(std::slice::from_ref(light)).unwrap();
        pipeline.set_frame_index(0);
        let image = pipeline.render().unwrap();
        sum.iter_mut().zip(&image.radiance).for_each(|(sum, radiance)| *sum += *radiance);
    }
    assert!(error(&sum, &ratio) < 1e-3, "{}", error(&sum, &ratio));
    // Nothing of one view goes into the next.
    let camera = Camera { eye: Vec3::new(-3.0, 2.0, 3.0), ..stage.scene.camera };
    pipeline.set_lights(&stage.scene.lights).unwrap();
    pipeline.set_camera(camera).unwrap();
    pipeline.set_frame_index(0);
    let moved = pipeline.render().unwrap().radiance.clone();
    let scene = Scene { camera, ..Scene::clone(&stage.scene) };
    let fresh = Stage { prepared: stage.prepared.moved(scene).unwrap(), ..stage.clone() };
    assert_eq!(moved, rendered(&fresh, &config(8), 0).2);
}

#[test]
fn numbers_and_g_buffers_that_cannot_be_are_refused() {
    let stage = Stage::new(blocker_over_floor()).unwrap();
    for antialias in [0, 2, 9, 32] {
        let fault = config(antialias).builder(&stage.prepared).build().err().unwrap();
        assert!(fault.to_string().contains("choose 1 (no antialiasing), 4, 8 or 16"), "{fault}");
    }
    let (_, gbuffer, _) = rendered(&stage, &config(1), 0);
    let mut pipeline = config(4).builder(&stage.prepared).build().unwrap();
    let fault = pipeline.render_gbuffer(&gbuffer).err().unwrap();
    assert!(matches!(fault, PipelineError::GivenSubSamples), "{fault}");
    let mut pipeline = Pipeline::builder(&stage.prepared).size(WIDTH, HEIGHT).build().unwrap();
    assert!(pipeline.render_gbuffer(&gbuffer).unwrap().radiance.is_empty());
}
