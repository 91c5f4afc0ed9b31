//! Lights, cameras and vertices that move: images are those of a renderer made for the changed scene.

use halflight::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig};
use halflight::frame::LightSampling;
use halflight::glam::Vec3;
use halflight::irradiance::Shading;
use halflight::light::AreaLight;
use halflight::pattern::PatternKind;
use halflight::refine::LatticeConfig;
use halflight::scene::{Camera, Mesh, Scene};
use halflight_gpu::{GpuError, Inputs, Renderer};
use halflight_tests::{Room, blocker_over_floor};

use crate::device::Bench;
use crate::scenes::{bundled, per_pixel};

/// Configurations that together have every stage whose buffers or constants could depend on lights or vertices.
pub(crate) fn configs() -> Vec<PipelineConfig> {
    let named = |refiner: &str, visibility: &str| {
        let mut refiner = RefinerConfig::named(refiner).unwrap();
        let mut upsampler = UpsamplerConfig::RbfRobust(Default::default());
        if let RefinerConfig::Lattice(lattice) = &mut refiner {
            *lattice = LatticeConfig { target: 1e-3, ..LatticeConfig::default() };
            upsampler = UpsamplerConfig::Lattice(Default::default());
        }
        let visibility = VisibilityConfig::named(visibility).unwrap();
        let sampling = LightSampling { kind: PatternKind::ShiftedRows, ..LightSampling::default() };
        PipelineConfig { refiner, upsampler, visibility, sampling, ..per_pixel(48, 36, Shading::Ratio) }
    };
    vec![
        named("lattice", "bvh"),
        named("nichols", "beam"),
        named("per-pixel", "raster4d"),
        named("sfvt-gass", "voxel"),
    ]
}

pub(crate) fn image(bench: &Bench, renderer: &mut Renderer) -> Vec<[u32; 4]> {
    bench.render(renderer, &Inputs::default());
    bench.read(renderer.image())
}

/// Checks that a renderer shows a scene as one that is made for it does; returns the image.
pub(crate) fn check(
    bench: &Bench,
    renderer: &mut Renderer,
    scene: &Scene,
    config: &PipelineConfig,
) -> Vec<[u32; 4]> {
    let mut anew = bench.renderer(scene, config).unwrap();
    let (found, expected) = (image(bench, renderer), image(bench, &mut anew));
    let others = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
    assert_eq!(others, 0, "{} {}", config.refiner.name(), config.visibility.name());
    assert_eq!(renderer.flush_lights(), anew.flush_lights());
    found
}

/// The scene's light moved and dimmed, beside a two-sided one.
fn two_lights(light: AreaLight) -> Vec<AreaLight> {
    let first = AreaLight { radiance: light.radiance * 0.5, ..light.moved(Vec3::Y * -0.2) };
    let frame = light.frame();
    let corner = frame.origin + Vec3::new(0.4, -0.3, 0.1);
    let second = AreaLight::parallelogram(corner, frame.u * 0.5, frame.v, light.radiance).two_sided();
    vec![first, second]
}

#[test]
fn moved_lights_and_cameras_are_those_of_a_new_renderer() {
    let Some(bench) = Bench::open() else { return };
    for config in configs() {
        let mut scene: Scene = Scene::clone(&bundled("few toys").scene);
        let light = scene.lights[0];
        scene.lights = vec![light];
        let mut renderer = bench.renderer(&scene, &config).unwrap();
        let first = image(&bench, &mut renderer);
        scene.lights = two_lights(light);
        renderer.set_lights(&scene.lights).unwrap();
        assert!(check(&bench, &mut renderer, &scene, &config) != first);
        // Fewer lights leave buffers larger than they need to be.
        renderer.set_lights(&[light]).unwrap();
        assert!(image(&bench, &mut renderer) == first);
        scene.lights = vec![light];
        scene.camera = Camera { eye: scene.camera.eye + Vec3::new(0.2, 0.3, 0.1), ..scene.camera };
        renderer.set_camera(scene.camera).unwrap();
        renderer.resize(38, 46).unwrap();
        check(&bench, &mut renderer, &scene, &PipelineConfig { width: 38, height: 46, ..config });
    }
}

#[test]
fn lights_become_flush_and_stop_to_be() {
    let Some(bench) = Bench::open() else { return };
    for two_sided in [false, true] {
        let mut scene = Room { two_sided, ..Room::default() }.scene();
        let flush = scene.lights.clone();
        let config = per_pixel(32, 24, Shading::Ratio);
        let away: Vec<AreaLight> = flush.iter().map(|light| light.moved(Vec3::Y * -0.3)).collect();
        scene.lights = away.clone();
        let mut renderer = bench.renderer(&scene, &config).unwrap();
        assert_eq!(renderer.flush_lights().len(), 0);
        for (lights, count) in [(flush, 1), (away, 0)] {
            scene.lights = lights;
            renderer.set_lights(&scene.lights).unwrap();
            check(&bench, &mut renderer, &scene, &config);
            assert_eq!(renderer.flush_lights().len(), count, "{two_sided}");
        }
    }
}

/// Grows everything around the origin, unevenly.
pub(crate) fn moved(p: Vec3) -> Vec3 {
    let wave = Vec3::new((p.y * 7.0).sin(), 0.2 * (p.z * 5.0).cos(), (p.x * 3.0).sin());
    p * (1.0 + 0.05 * p.length()) + wave * 0.02
}

#[test]
fn moved_vertices_are_those_of_a_new_renderer() {
    let Some(bench) = Bench::open() else { return };
    for config in configs() {
        let stage =
            if config.visibility == VisibilityConfig::Bvh { bundled("tree") } else { bundled("few toys") };
        let mut scene: Scene = Scene::clone(&stage.scene);
        let mut renderer = bench.renderer(&scene, &config).unwrap();
        let first = image(&bench, &mut renderer);
        let mut mesh = Mesh::clone(&scene.mesh);
        mesh.positions.iter_mut().for_each(|p| *p = moved(*p));
        let changed = with_mesh(&scene, mesh);
        let still = std::mem::replace(&mut scene, changed);
        update(&bench, &mut renderer, &scene.mesh.positions).unwrap();
        assert!(check(&bench, &mut renderer, &scene, &config) != first);
        update(&bench, &mut renderer, &still.mesh.positions).unwrap();
        assert!(image(&bench, &mut renderer) == first);
    }
}

fn with_mesh(scene: &Scene, mesh: Mesh) -> Scene {
    Scene { mesh: std::sync::Arc::new(mesh), ..scene.clone() }
}

pub(crate) fn update(bench: &Bench, renderer: &mut Renderer, positions: &[Vec3]) -> Result<(), GpuError> {
    let mut encoder = bench.gpu.device.create_command_encoder(&Default::default());
    let updated = renderer.update_geometry(&mut encoder, positions);
    bench.gpu.queue.submit([encoder.finish()]);
    updated
}

#[test]
fn changes_that_cannot_be_made_leave_the_renderer_as_it_was() {
    let Some(bench) = Bench::open() else { return };
    let scene = blocker_over_floor();
    for config in configs().split_off(2) {
        let mut renderer = bench.renderer(&scene, &config).unwrap();
        let expected = image(&bench, &mut renderer);
        let light = scene.lights[0];
        let edge = light.frame().u;
        let flat = AreaLight::parallelogram(light.frame().origin, edge, edge, light.radiance);
        let faulty = AreaLight { radiance: Vec3::new(1.0, f32::NAN, 1.0), ..light };
        for (lights, word) in [(vec![], "light"), (vec![light, flat], "light 1"), (vec![faulty], "light 0")] {
            let error = renderer.set_lights(&lights).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
            assert_eq!(image(&bench, &mut renderer), expected, "{error}");
        }
        let blind = Camera { target: scene.camera.eye, ..scene.camera };
        assert!(renderer.set_camera(blind).unwrap_err().to_string().contains("eye and target"));
        assert_eq!(image(&bench, &mut renderer), expected);
        let mut positions = scene.mesh.positions.clone();
        let few = update(&bench, &mut renderer, &positions[1..]).unwrap_err();
        let count = positions.len();
        assert!(
            matches!(few, GpuError::Vertices { found, expected } if found + 1 == expected && expected == count)
        );
        positions[5].y = f32::INFINITY;
        let error = update(&bench, &mut renderer, &positions).unwrap_err().to_string();
        assert!(error.contains("vertex 5"), "{error}");
        positions[5].y = 1e9;
        let error = update(&bench, &mut renderer, &positions).unwrap_err().to_string();
        assert!(error.contains("vertex 5"), "{error}");
        assert_eq!(image(&bench, &mut renderer), expected);
    }
}

#[test]
fn lights_without_room_are_refused() {
    let Some(bench) = Bench::open() else { return };
    let limits = halflight_gpu::wgpu::Limits {
        max_storage_buffer_binding_size: 1 << 20,
        max_buffer_size: 1 << 20,
        ..halflight_gpu::required_limits()
    };
    let bench = bench.limited(limits);
    let scene = blocker_over_floor();
    let mut renderer = bench.renderer(&scene, &per_pixel(64, 48, Shading::Ratio)).unwrap();
    let expected = image(&bench, &mut renderer);
    // Uniforms of 512 bytes.
    let error = renderer.set_lights(&vec![scene.lights[0]; 4096]).unwrap_err();
    assert!(matches!(error, GpuError::TooLarge { unit: "bytes", .. }), "{error}");
    assert_eq!(image(&bench, &mut renderer), expected);
}

#[test]
fn moving_lights_and_cameras_creates_nothing_that_grows_with_the_mesh() {
    let Some(bench) = Bench::open() else { return };
    // Backends with buffers of their own for triangles and lights.
    for config in configs().split_off(2) {
        let created = |scene: &Scene| {
            let mut renderer = bench.renderer(scene, &config).unwrap();
            image(&bench, &mut renderer);
            let before = renderer.bytes_created();
            image(&bench, &mut renderer);
            let plain = renderer.bytes_created();
            let light = scene.lights[0];
            renderer.set_lights(&[light.moved(Vec3::X * 0.1)]).unwrap();
            renderer.set_camera(Camera { fov_y_deg: 30.0, ..scene.camera }).unwrap();
            assert_eq!(renderer.bytes_created(), plain);
            image(&bench, &mut renderer);
            (before, plain - before, renderer.bytes_created() - plain)
        };
        let mut small = blocker_over_floor();
        small.lights.truncate(1);
        let mut large: Scene = Scene::clone(&bundled("few toys").scene);
        large.lights.truncate(1);
        let [(start, frame, moved), (others_start, others_frame, others_moved)] =
            [small, large].map(|scene| created(&scene));
        assert!(start < others_start, "what is made at first grows with the mesh");
        assert_eq!([frame, moved, others_frame], [others_frame, others_moved, frame]);
        assert_eq!(frame, moved, "uniforms of a frame alone");
    }
}
