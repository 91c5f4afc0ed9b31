//! Lights that are flush with geometry: it does not hide them; geometry clearly in front of them does.

use halflight::bvh::Bvh;
use halflight::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig};
use halflight::flush::separate_lights;
use halflight::frame::LightSampling;
use halflight::glam::{DQuat, DVec3, Vec3};
use halflight::pattern::PatternKind;
use halflight::scene::Camera;
use halflight::unshadowed::unshadowed;
use halflight_tests::{Room, Stage, nmse2};
use std::sync::Arc;

fn config(visibility: &str, refiner: RefinerConfig, upsampler: UpsamplerConfig) -> PipelineConfig {
    let visibility = VisibilityConfig::named(visibility).unwrap();
    // 4D rasterization takes samples in rows.
    let sampling = LightSampling { kind: PatternKind::ShiftedRows, ..LightSampling::default() };
    PipelineConfig {
        width: 32,
        height: 24,
        refiner,
        upsampler,
        visibility,
        sampling,
        ..PipelineConfig::default()
    }
}

/// Least and greatest fraction of the unshadowed light that the floor gets.
pub(crate) fn shares(stage: &Stage, config: &PipelineConfig) -> (f32, f32) {
    let mut pipeline = config.builder(&stage.prepared).build().unwrap();
    let image = pipeline.render().unwrap().clone();
    let (mut range, mut count) = ((f32::INFINITY, f32::NEG_INFINITY), 0);
    for pixel in 0..image.irradiance.len() {
        let Some(receiver) = pipeline.gbuffer().receiver(pixel) else { continue };
        let all: f32 = stage
            .scene
            .lights
            .iter()
            .map(|light| unshadowed(light, receiver.origin, receiver.normal) * light.radiance.x)
            .sum();
        let share = image.irradiance[pixel].x / all;
        range = (range.0.min(share), range.1.max(share));
        count += 1;
    }
    assert!(count > 100, "{count}");
    range
}

/// Every exact backend with the per-pixel refiner, and the default.
pub(crate) fn methods() -> Vec<(&'static str, PipelineConfig)> {
    let per_pixel =
        |name| (name, config(name, RefinerConfig::PerPixel, UpsamplerConfig::Lattice(Default::default())));
    let mut methods: Vec<_> = ["bvh", "raster4d", "beam", "auto"].map(per_pixel).to_vec();
    methods.push(("default", PipelineConfig { width: 32, height: 24, ..PipelineConfig::default() }));
    methods
}

#[test]
fn lamps_in_ceilings_shine_at_every_height_and_in_every_position() {
    let turn = DQuat::from_axis_angle(DVec3::new(0.2, -0.4, 0.9).normalize(), 0.8);
    let places = [
        (DQuat::IDENTITY, DVec3::ZERO),
        (turn, DVec3::ZERO),
        (DQuat::IDENTITY, DVec3::new(900.0, 50.0, -300.0)),
        (turn, DVec3::new(900.0, 50.0, -300.0)),
    ];
    for (turn, shift) in places {
        for step in 0..12 {
            for two_sided in [false, true] {
                let room = Room {
                    turn,
                    shift,
                    height: 2.2 + 0.073 * f64::from(step),
                    two_sided,
                    // Cover of the lamp's own size every other time, else a ceiling.
                    cover: if step % 2 == 0 { 8.0 } else { 1.0 },
                    ..Room::default()
                };
                let stage = Stage::new(room.scene()).unwrap();
                for (name, config) in methods() {
                    let (low, high) = shares(&stage, &config);
                    // Far from the origin single precision moves the light by 2⁻¹⁴ of its height.
                    assert!(low > 0.999 && high < 1.001, "{name}, {room:?}: {low} to {high}");
                }
            }
        }
    }
}

#[test]
fn plates_before_a_lamp_hide_it() {
    for shift in [DVec3::ZERO, DVec3::new(-100.0, 3.0, 20.0)] {
        for (gap, two_sided) in [(1e-3, false), (1e-3, true), (5e-3, false)] {
            let room = Room { shift, cover: 1.5, gap, two_sided, ..Room::default() };
            let stage = Stage::new(room.scene()).unwrap();
            for (name, config) in methods() {
                assert_eq!(shares(&stage, &config), (0.0, 0.0), "{name}, {room:?}");
            }
        }
    }
}

#[test]
fn lights_and_triangles_are_named() {
    let mut scene = Room { cover: 8.0, ..Room::default() }.scene();
    scene.lights.insert(0, scene.lights[0].transformed(|_| Vec3::new(0.3, 1.0, 0.2), |d| d));
    let bvh = Bvh::build(&scene.mesh).unwrap();
    for bvh in [Some(&bvh), None] {
        let (lights, flush) = separate_lights(&scene, bvh);
        // Triangles 0 and 1 are the floor.
        assert_eq!((flush.len(), flush[0].light, &flush[0].triangles[..]), (1, 1, &[2, 3][..]));
        assert!(flush[0].moved > 0.0 && flush[0].moved < 1e-5, "{flush:?}");
        assert_eq!((lights.len(), lights[0]), (2, scene.lights[0]));
        let text = flush[0].to_string();
        assert!(text.starts_with("light 1 lies in the plane of triangles 2, 3 up to rounding"), "{text}");
    }
    // Beside the light, below it and across its plane.
    for (corner, u, v) in [
        (Vec3::new(0.5001, 2.5, -4.0), Vec3::X, Vec3::Z * 8.0),
        (Vec3::new(-4.0, 2.499, -4.0), Vec3::X * 8.0, Vec3::Z * 8.0),
        (Vec3::new(-4.0, 2.0, -0.1), Vec3::X * 8.0, Vec3::Y),
        (Vec3::new(-4.0, 2.5, -4.0), Vec3::new(8.0, 0.001, 0.0), Vec3::Z * 8.0),
    ] {
        scene.mesh = Arc::new(halflight_tests::quads(&[(corner, u, v)]));
        assert!(separate_lights(&scene, None).1.is_empty(), "{corner}");
    }
}

#[test]
fn both_sides_of_a_light_in_a_surface_shine() {
    // A two-sided light in a slab between two floors, and the same without the slab.
    let mut scene = Room { height: 2.0, cover: 1.0, two_sided: true, ..Room::default() }.scene();
    let mesh = Arc::make_mut(&mut scene.mesh);
    let corners = [(-4.0, -4.0), (-4.0, 4.0), (4.0, 4.0), (4.0, -4.0)];
    mesh.positions.extend(corners.map(|(x, z)| Vec3::new(x, 4.0, z)));
    mesh.uvs.extend([halflight::glam::Vec2::ZERO; 4]);
    let first = mesh.positions.len() as u32 - 4;
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    mesh.material_ids.extend([0, 0]);
    scene.camera = Camera {
        eye: Vec3::new(0.0, 2.2, 8.0),
        target: Vec3::new(0.0, 2.0, 0.0),
        up: Vec3::Y,
        fov_y_deg: 60.0,
        ..Camera::default()
    };
    let mut open = scene.clone();
    Arc::make_mut(&mut open.mesh).triangles.drain(2..4);
    Arc::make_mut(&mut open.mesh).material_ids.drain(2..4);
    let [with, without] = [scene, open].map(|scene| {
        let stage = Stage::new(scene).unwrap();
        stage
            .render(&config("bvh", RefinerConfig::PerPixel, UpsamplerConfig::Lattice(Default::default())))
            .unwrap()
    });
    let lit = without.irradiance.iter().filter(|e| e.x > 0.0).count();
    assert!(lit > 200, "{lit}");
    assert!(nmse2(&with, &without) < 1e-6);
}
