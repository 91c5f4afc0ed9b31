//! Indirect light against closed forms: a wall under even light is a lamp, walls that shut light out let none through.

use std::sync::Arc;

use halflight::config::{IndirectConfig, PipelineConfig, RefinerConfig, VisibilityConfig};
use halflight::glam::{Vec2, Vec3};
use halflight::indirect::{GatherConfig, LpvConfig};
use halflight::light::AreaLight;
use halflight::pipeline::Image;
use halflight::scene::{Camera, Material, Mesh, Scene};
use halflight::unshadowed::unshadowed;
use halflight::voxel::VoxelConfig;
use halflight_tests::Stage;

/// Rectangles by a corner, two edges and an albedo.
fn mesh(rectangles: &[(Vec3, Vec3, Vec3, f32)]) -> Mesh {
    let mut mesh = Mesh::default();
    for (number, &(corner, u, v, albedo)) in (0..).zip(rectangles) {
        mesh.positions.extend([corner, corner + u, corner + u + v, corner + v]);
        let first = 4 * number;
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.material_ids.extend([number; 2]);
        mesh.materials.push(Material { albedo: Vec3::splat(albedo), ..Material::default() });
    }
    mesh.uvs = vec![Vec2::ZERO; mesh.positions.len()];
    mesh
}

const ALBEDO: f32 = 0.6;

/// A black floor before a white wall that a distant lamp lights evenly.
fn wall() -> (Stage, AreaLight) {
    let (corner, u, v) = (Vec3::new(-1.0, 0.0, 0.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    let floor = (Vec3::new(-2.0, 0.0, 0.0), Vec3::X * 4.0, Vec3::Z * 4.0, 0.0);
    let lamp = AreaLight::parallelogram(
        Vec3::new(-50.0, 10.0, 1000.0),
        Vec3::X * 100.0,
        Vec3::Y * 100.0,
        Vec3::new(300.0, 200.0, 100.0),
    )
    .two_sided();
    let camera = Camera {
        eye: Vec3::new(0.0, 3.0, 3.0),
        target: Vec3::new(0.0, 0.0, 1.2),
        fov_y_deg: 50.0,
        ..Camera::default()
    };
    let mesh = mesh(&[(corner, u, v, ALBEDO), floor]);
    let stage =
        Stage::new(Scene { mesh: Arc::new(mesh), lights: vec![lamp], camera, ..Scene::default() }).unwrap();
    let lit = lamp.radiance * unshadowed(&lamp, Vec3::new(0.0, 1.0, 0.0), Vec3::Z);
    // The wall as a lamp: radiance albedo · E / π.
    let as_lamp = AreaLight::parallelogram(corner, u, v, lit * ALBEDO / std::f32::consts::PI).two_sided();
    (stage, as_lamp)
}

fn config(indirect: IndirectConfig) -> PipelineConfig {
    PipelineConfig {
        width: 96,
        height: 72,
        refiner: RefinerConfig::PerPixel,
        indirect,
        ..PipelineConfig::default()
    }
}

/// Image and, of each pixel that sees the floor, its place and index.
fn render(stage: &Stage, config: &PipelineConfig) -> (Image, Vec<(Vec3, usize)>) {
    let mut pipeline = config.builder(&stage.prepared).build().unwrap();
    let image = pipeline.render().unwrap().clone();
    let seen = pipeline.gbuffer();
    let floor = |&pixel: &usize| seen.is_receiver(pixel) && seen.normal[pixel].y > 0.9;
    let pixels = (0..seen.pixels()).filter(floor).map(|pixel| (seen.position[pixel], pixel)).collect();
    (image, pixels)
}

#[test]
fn a_wall_under_even_light_is_a_lamp() {
    let (stage, lamp) = wall();
    for (points, most) in [(1024, 0.1), (16_384, 0.035)] {
        let gather = GatherConfig { points, ..GatherConfig::default() };
        let (image, floor) = render(&stage, &config(IndirectConfig::Gather(gather)));
        assert!(floor.len() > 3000);
        let (mut worst, mut squares, mut total, mut peak) = (0.0f32, 0.0, 0.0, 0.0f32);
        for (place, pixel) in floor {
            let expected = lamp.radiance * unshadowed(&lamp, place, Vec3::Y);
            let error = image.indirect[pixel] - expected;
            worst = worst.max(error.length());
            peak = peak.max(expected.length());
            squares += error.length_squared();
            total += expected.length_squared();
        }
        let relative = (squares / total).sqrt();
        assert!(relative < most && worst < 4.0 * most * peak, "{points} points: {relative} {}", worst / peak);
    }
}

#[test]
fn no_light_passes_through_a_thin_wall() {
    // Two rooms of 4 × 3 × 4 m that share a wall of no thickness; the lamp is in the one, the camera in the other.
    let (x, y, z) = (Vec3::X, Vec3::Y * 3.0, Vec3::Z * 4.0);
    let low = Vec3::new(-4.0, 0.0, -2.0);
    let walls = [
        (low, x * 8.0, z),
        (low + y, x * 8.0, z),
        (low, x * 8.0, y),
        (low + z, x * 8.0, y),
        (low, y, z),
        (low + x * 8.0, y, z),
        (low + x * 4.0, y, z),
    ];
    let walls: Vec<_> = walls.into_iter().map(|(corner, u, v)| (corner, u, v, 0.7)).collect();
    let lamp =
        AreaLight::parallelogram(Vec3::new(-2.5, 2.9, -0.5), Vec3::X, Vec3::Z, Vec3::splat(10.0)).two_sided();
    let room = |eye: Vec3, target: Vec3| {
        let camera = Camera { eye, target, fov_y_deg: 70.0, ..Camera::default() };
        Stage::new(Scene { mesh: Arc::new(mesh(&walls)), lights: vec![lamp], camera, ..Scene::default() })
            .unwrap()
    };
    let dark = room(Vec3::new(3.5, 1.5, 0.0), Vec3::new(0.0, 1.2, 0.2));
    let (image, _) = render(&dark, &config(IndirectConfig::Gather(GatherConfig::default())));
    assert!(image.indirect.iter().all(|&light| light == Vec3::ZERO));
    assert!(image.stats.indirect.lit > 1000 && image.stats.indirect.gather_rays > 1000);
    // In the lit room light comes from everywhere.
    let lit = room(Vec3::new(-0.5, 1.5, 0.0), Vec3::new(-4.0, 1.2, 0.2));
    let (image, _) = render(&lit, &config(IndirectConfig::Gather(GatherConfig::default())));
    assert!(image.indirect.iter().all(|light| light.min_element() > 0.01));
}

#[test]
fn direct_light_does_not_know_of_indirect_light() {
    let stage = Stage::bundled("contact").unwrap();
    let without = stage.render(&config(IndirectConfig::None)).unwrap();
    assert!(without.indirect.is_empty() && without.radiance.is_empty());
    for indirect in
        [IndirectConfig::Lpv(LpvConfig::default()), IndirectConfig::Gather(GatherConfig::default())]
    {
        let with = stage.render(&config(indirect)).unwrap();
        assert_eq!(with.irradiance, without.irradiance);
        assert!(with.indirect.iter().any(|&light| light.min_element() > 0.0));
        let single =
            config(indirect).builder(&stage.prepared).threads(1).build().unwrap().render().unwrap().clone();
        assert_eq!(single.indirect, with.indirect);
        assert_eq!(single.radiance, with.radiance);
    }
}

#[test]
fn the_brightness_of_a_volume_does_not_depend_on_its_grid() {
    let (stage, _) = wall();
    let mean = |indirect: IndirectConfig| {
        let (image, floor) = render(&stage, &config(indirect));
        // A metre before the wall and beyond: nearer, the wall is not a cell away.
        let far = || floor.iter().filter(|(place, _)| place.z > 1.0);
        far().map(|&(_, pixel)| image.indirect[pixel].x).sum::<f32>() / far().count() as f32
    };
    // Light spreads as in a fog: it needs four times as many steps for twice as many cells.
    let lpv = |cells: u32, steps: u32| LpvConfig { cells, steps, blocking: false, ..LpvConfig::default() };
    let [coarse, fine] = [lpv(8, 16), lpv(16, 64)].map(|lpv| mean(IndirectConfig::Lpv(lpv)));
    assert!((fine / coarse - 1.0).abs() < 0.1, "{coarse} {fine}");
    // Then it is about as bright as it should be.
    let right = mean(IndirectConfig::Gather(GatherConfig::default()));
    assert!((fine / right - 1.0).abs() < 0.2, "{fine} {right}");
}

#[test]
fn antialiased_radiance_has_indirect_light_in_it() {
    let stage = Stage::bundled("contact").unwrap();
    let indirect = IndirectConfig::Gather(GatherConfig::default());
    let config = PipelineConfig { antialias: 8, ..config(indirect) };
    let mut pipeline = config.builder(&stage.prepared).build().unwrap();
    let image = pipeline.render().unwrap().clone();
    let albedo = &pipeline.gbuffer().albedo;
    let of_centre = |pixel: usize| {
        albedo[pixel] * (image.irradiance[pixel] + image.indirect[pixel]) * std::f32::consts::FRAC_1_PI
    };
    let whole = (0..albedo.len()).filter(|&pixel| image.radiance[pixel].abs_diff_eq(of_centre(pixel), 1e-5));
    let whole = whole.count();
    assert!(whole > albedo.len() / 2 && whole < albedo.len(), "{whole} of {}", albedo.len());
    // Mixed pixels lie between what is around them: none lacks the indirect light.
    let dark = PipelineConfig { indirect: IndirectConfig::None, ..config };
    let dark = dark.builder(&stage.prepared).build().unwrap().render().unwrap().clone();
    let brighter = (0..albedo.len()).filter(|&pixel| image.radiance[pixel].x > dark.radiance[pixel].x);
    let lit = (0..albedo.len()).filter(|&pixel| image.indirect[pixel].x > 1e-4 && albedo[pixel].x > 0.0);
    assert!(brighter.count() >= lit.count());
}

#[test]
fn an_approximate_backend_is_refused() {
    let stage = Stage::bundled("contact").unwrap();
    let voxels = VisibilityConfig::Voxel(VoxelConfig::default());
    let config =
        PipelineConfig { visibility: voxels, ..config(IndirectConfig::Gather(GatherConfig::default())) };
    let Err(fault) = config.builder(&stage.prepared).build() else { panic!("voxels were taken") };
    assert!(fault.to_string().contains("choose bvh, beam, auto or raster4d"), "{fault}");
}

#[test]
fn frames_do_not_depend_on_those_before() {
    let (stage, _) = wall();
    let moved = |shift: f32| {
        let mut scene = stage.prepared.scene().clone();
        Arc::make_mut(&mut scene.mesh).positions[2].y += shift;
        stage.prepared.moved(scene).unwrap()
    };
    let config = config(IndirectConfig::Gather(GatherConfig { points: 1024, ..GatherConfig::default() }));
    let mut pipeline = config.builder(&stage.prepared).build().unwrap();
    for shift in [0.0, 0.5, -0.3] {
        let scene = moved(shift);
        pipeline.set_scene(&scene, config.visibility.stage(scene.bvh()).unwrap()).unwrap();
        pipeline.set_frame_index(0);
        let after = pipeline.render().unwrap().indirect.clone();
        let alone = config.builder(&scene).build().unwrap().render().unwrap().indirect.clone();
        assert!(after == alone, "{shift}");
        assert!(shift == 0.0 || pipeline.image().stats.indirect.points > 100);
    }
}
