//! Lights, cameras, meshes and G-buffers that change between frames.

use std::sync::Arc;

use halflight::camera::{Camera, View};
use halflight::config::{PipelineConfig, VisibilityConfig};
use halflight::gbuffer::{GBuffer, GBufferError, SurfacePoints};
use halflight::glam::{Vec2, Vec3};
use halflight::light::AreaLight;
use halflight::pipeline::{Image, Pipeline, PipelineError};
use halflight::prepared::PreparedScene;
use halflight::scene::Scene;
use halflight_tests::Stage;

fn config(visibility: VisibilityConfig) -> PipelineConfig {
    PipelineConfig { width: 160, height: 120, visibility, ..PipelineConfig::default() }
}

fn lights(scene: &Scene) -> Vec<AreaLight> {
    let moved = |light: &AreaLight| light.moved(Vec3::new(0.3, -0.1, 0.2));
    scene.lights.iter().map(moved).chain(scene.lights.first().copied()).collect()
}

fn first_frame(scene: Scene, config: &PipelineConfig) -> Image {
    let mut pipeline = config.builder(&PreparedScene::new(scene).unwrap()).build().unwrap();
    pipeline.render().unwrap().clone()
}

/// The next frame of a pipeline is the first one of a new pipeline for the scene.
fn same(pipeline: &mut Pipeline, scene: Scene, config: &PipelineConfig) {
    pipeline.set_frame_index(0);
    let found = pipeline.render().unwrap().irradiance.clone();
    assert!(found == first_frame(scene, config).irradiance);
}

#[test]
fn moved_lights_and_cameras_give_the_image_of_a_new_pipeline() {
    let stage = Stage::bundled("toys").unwrap();
    for visibility in [VisibilityConfig::Auto, VisibilityConfig::Voxel(Default::default())] {
        let config = config(visibility);
        let mut pipeline = config.builder(&stage.prepared).build().unwrap();
        let before = pipeline.render().unwrap().irradiance.clone();
        let mut scene = stage.prepared.scene().clone();
        scene.lights = lights(&scene);
        pipeline.set_lights(&scene.lights).unwrap();
        same(&mut pipeline, scene.clone(), &config);
        assert!(pipeline.image().irradiance != before);
        scene.camera = Camera { eye: scene.camera.eye + Vec3::new(0.2, 0.3, 0.1), ..scene.camera };
        pipeline.set_camera(scene.camera).unwrap();
        same(&mut pipeline, scene.clone(), &config);
        // Geometry is shared all the while.
        assert!(Arc::ptr_eq(&scene.mesh, &stage.scene.mesh));
        // Lights and cameras that cannot be rendered leave the pipeline as it was.
        assert!(matches!(pipeline.set_lights(&[]), Err(PipelineError::NoLight)));
        let dark = AreaLight { radiance: -Vec3::ONE, ..scene.lights[0] };
        assert!(matches!(pipeline.set_lights(&[dark]), Err(PipelineError::Light(_))));
        let blind = Camera { target: scene.camera.eye, ..scene.camera };
        assert!(matches!(pipeline.set_camera(blind), Err(PipelineError::Camera(_))));
        same(&mut pipeline, scene, &config);
    }
}

#[test]
fn a_moved_mesh_gives_the_image_of_a_new_pipeline() {
    let stage = Stage::bundled("toys").unwrap();
    let config = config(VisibilityConfig::Auto);
    let mut pipeline = config.builder(&stage.prepared).build().unwrap();
    pipeline.render().unwrap();
    let mut scene = stage.prepared.scene().clone();
    Arc::make_mut(&mut scene.mesh).positions.iter_mut().for_each(|p| p.x += 0.1 * p.y * p.y);
    let prepared = stage.prepared.moved(scene.clone()).unwrap();
    pipeline.set_scene(&prepared, config.visibility.stage(prepared.bvh()).unwrap()).unwrap();
    same(&mut pipeline, scene, &config);
}

/// Off-centre views show what the middle of a larger view shows, for every backend that depends on the camera.
#[test]
fn a_shifted_view_is_a_part_of_a_larger_one() {
    let stage = Stage::bundled("atrium").unwrap();
    let refiner = halflight::config::RefinerConfig::PerPixel;
    let voxel = VisibilityConfig::Voxel(Default::default());
    for (visibility, most) in [(VisibilityConfig::Auto, 2e-3), (voxel, 2e-2)] {
        let large = PipelineConfig { refiner, upsampler: refiner.upsampler(), ..config(visibility) };
        let small = PipelineConfig { width: 80, height: 60, ..large };
        let mut pipeline = small.builder(&stage.prepared).build().unwrap();
        let whole = first_frame(stage.prepared.scene().clone(), &large);
        // The upper right quarter: half the angle's tangent, moved by half of the large view's half sizes.
        let camera = stage.scene.camera;
        let tangent = (camera.fov_y_deg.to_radians() * 0.5).tan() * 0.5;
        let quarter = Camera {
            fov_y_deg: 2.0 * tangent.atan().to_degrees(),
            aspect: Some(160.0 / 120.0),
            shift: Vec2::ONE,
            ..camera
        };
        pipeline.set_camera(quarter).unwrap();
        let part = pipeline.render().unwrap();
        // Relative squared difference to the part of the large view that begins at (left, top).
        let difference = |left: usize, top: usize| {
            let (mut error, mut energy) = (0.0, 0.0);
            for (pixel, &found) in part.irradiance.iter().enumerate() {
                let expected = whole.irradiance[(top + pixel / 80) * 160 + left + pixel % 80];
                error += f64::from((found - expected).length_squared());
                energy += f64::from(expected.length_squared());
            }
            error / energy
        };
        // Light samples differ; voxels are finer in a smaller view.
        assert!(difference(80, 0) < most, "{visibility:?}: {}", difference(80, 0));
        assert!(difference(80, 60) > 10.0 * most && difference(0, 0) > 10.0 * most, "{visibility:?}");
    }
}

#[test]
fn a_callers_gbuffer_gives_the_image_of_ones_own() {
    let stage = Stage::bundled("atrium").unwrap();
    let config = config(VisibilityConfig::Auto);
    let mut pipeline = config.builder(&stage.prepared).build().unwrap();
    let expected = pipeline.render().unwrap().irradiance.clone();
    let own = pipeline.gbuffer().clone();
    // Its own G-buffer, handed in: the same image, bit for bit.
    pipeline.set_frame_index(0);
    assert!(pipeline.render_gbuffer(&own).unwrap().irradiance == expected);
    // Depths and normals as another renderer would have drawn them, and half the albedo.
    let view = View::new(&stage.scene.camera, 160, 120);
    let points: Vec<Vec3> = (0..own.pixels())
        .map(|pixel| view.eye + view.direction(pixel % 160, pixel / 160) * own.depth[pixel].min(1e6))
        .collect();
    let albedo: Vec<Vec3> = own.albedo.iter().map(|albedo| *albedo * 0.5).collect();
    let camera = &stage.scene.camera;
    let energy: f64 = expected.iter().map(|value| f64::from(value.length_squared())).sum();
    for (points, albedo) in
        [(SurfacePoints::Positions(&points), None), (SurfacePoints::Depths(&own.depth), Some(&albedo[..]))]
    {
        let given = GBuffer::from_surfaces(camera, (160, 120), points, &own.normal, albedo).unwrap();
        let given = given.with_shading_normals(&own.shading).unwrap();
        pipeline.set_frame_index(0);
        let image = pipeline.render_gbuffer(&given).unwrap();
        let off = |(found, expected): (&Vec3, &Vec3)| f64::from((*found - *expected).length_squared());
        let error: f64 = image.irradiance.iter().zip(&expected).map(off).sum();
        assert!(error / energy < 1e-3, "{}", error / energy);
        let seen = (0..own.pixels()).filter(|&pixel| own.is_receiver(pixel)).count();
        assert_eq!((0..given.pixels()).filter(|&pixel| given.is_receiver(pixel)).count(), seen);
        assert_eq!(
            given.albedo[own.pixels() / 2],
            albedo.map_or(Vec3::ONE, |albedo| albedo[own.pixels() / 2])
        );
    }
    // Faults are refused, and the pipeline goes on.
    let mut smaller = own.clone();
    smaller.reset(80, 60);
    let size = pipeline.render_gbuffer(&smaller).unwrap_err();
    assert!(matches!(size, PipelineError::GBuffer(GBufferError::Size { found: (80, 60), .. })));
    let mut broken = own;
    broken.normal[160 * 60 + 80] = Vec3::NAN;
    let pixel = pipeline.render_gbuffer(&broken).unwrap_err();
    assert_eq!(pixel.to_string(), "the G-buffer's normal at pixel (80, 60) is not of length 1");
    pipeline.set_frame_index(0);
    assert!(pipeline.render().unwrap().irradiance == expected);
}
