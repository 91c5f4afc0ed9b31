//! Disks, ellipses and polygons against closed forms, quadrature and lights that they are made of.

use std::f64::consts::{PI, TAU};

use halflight::config::{Named, PipelineConfig, RefinerConfig, VisibilityConfig};
use halflight::frame::LightSampling;
use halflight::glam::{DVec3, Vec3};
use halflight::irradiance::Shading;
use halflight::light::{AreaLight, Extent};
use halflight::pattern::PatternKind;
use halflight::refine::Quality;
use halflight::scene::Scene;
use halflight::unshadowed::unshadowed;
use halflight_tests::{Stage, nmse2};

/// Projected solid angle of a disk of radius `r` at height `h`, for a receiver that faces its plane at `d` from its axis.
fn parallel(r: f64, h: f64, d: f64) -> f64 {
    let (square, whole) = (h * h + d * d, h * h + d * d + r * r);
    0.5 * PI * (1.0 - (square - r * r) / (whole * whole - 4.0 * r * r * d * d).sqrt())
}

/// Projected solid angle of the disk for a receiver that faces its axis, in a plane perpendicular to the disk's, with all of it above its horizon.
fn perpendicular(r: f64, h: f64, d: f64) -> f64 {
    let whole = h * h + d * d + r * r;
    0.5 * PI * (h / d) * (whole / (whole * whole - 4.0 * r * r * d * d).sqrt() - 1.0)
}

#[test]
fn disks_have_their_closed_forms() {
    for (r, h, d) in [
        (1.0, 2.0, 0.0),
        (1.0, 0.5, 0.3),
        (1.0, 0.05, 0.2),
        (1.0, 0.02, 0.99),
        (0.2, 3.0, 4.0),
        (0.01, 5.0, 1.0),
        (2.0, 0.3, 2.5),
        (1e-3, 100.0, 30.0),
    ] {
        let centre = Vec3::new(0.25, h as f32, -1.5);
        let light = AreaLight::disk(centre, -Vec3::Y, r as f32, Vec3::ONE);
        let point = Vec3::new(0.25 + d as f32, 0.0, -1.5);
        let exact = parallel(r, h, d);
        let found = f64::from(unshadowed(&light, point, Vec3::Y));
        assert!((found / exact - 1.0).abs() < 1e-4, "parallel {r} {h} {d}: {found} {exact}");
        assert_eq!(unshadowed(&light, point, -Vec3::Y), 0.0);
        assert_eq!(unshadowed(&light.reversed(), point, Vec3::Y), 0.0);
        assert_eq!(f64::from(unshadowed(&light.reversed().two_sided(), point, Vec3::Y)), found);
        if d > r {
            let exact = perpendicular(r, h, d);
            let found = f64::from(unshadowed(&light, point, -Vec3::X));
            assert!((found / exact - 1.0).abs() < 1e-4, "perpendicular {r} {h} {d}: {found} {exact}");
        }
    }
}

/// Sum over many small parts of an ellipse, in polar coordinates.
fn quadrature(centre: DVec3, a: DVec3, b: DVec3, origin: DVec3, normal: DVec3) -> f64 {
    let (rings, spokes) = (1500, 1500);
    let facing = a.cross(b);
    let mut sum = 0.0;
    for ring in 0..rings {
        let radius = (f64::from(ring) + 0.5) / f64::from(rings);
        for spoke in 0..spokes {
            let (sine, cosine) = (TAU * (f64::from(spoke) + 0.5) / f64::from(spokes)).sin_cos();
            let to = centre + (a * cosine + b * sine) * radius - origin;
            let terms = normal.dot(to).max(0.0) * (-facing.dot(to)).max(0.0);
            sum += radius * terms / to.length_squared().powi(2);
        }
    }
    sum * TAU / (f64::from(rings) * f64::from(spokes))
}

#[test]
fn ellipses_across_the_horizon_agree_with_quadrature() {
    let centre = Vec3::new(0.5, 1.0, -0.5);
    let (a, b) = (Vec3::new(0.8, 0.1, 0.0), Vec3::new(0.2, -0.3, 0.5));
    let light = AreaLight::ellipse(centre, b, a, Vec3::ONE);
    for (origin, normal) in [
        (Vec3::new(0.3, 0.2, 0.4), Vec3::Y),
        (Vec3::new(0.3, 0.6, 0.2), Vec3::new(0.6, 0.0, -0.8)),
        (Vec3::new(-1.0, 0.4, 0.5), Vec3::new(0.8, 0.6, 0.0)),
        (Vec3::new(0.9, 0.7, -0.2), Vec3::new(0.0, 0.6, 0.8)),
        (Vec3::new(0.9, 0.9, 0.3), Vec3::new(-0.6, 0.0, 0.8)),
    ] {
        let exact =
            quadrature(centre.as_dvec3(), b.as_dvec3(), a.as_dvec3(), origin.as_dvec3(), normal.as_dvec3());
        let turned =
            quadrature(centre.as_dvec3(), a.as_dvec3(), b.as_dvec3(), origin.as_dvec3(), normal.as_dvec3());
        let two_sided = f64::from(unshadowed(&light.two_sided(), origin, normal));
        assert!(
            (two_sided - exact.max(turned)).abs() < 2e-5 * (1.0 + exact),
            "{origin}: {two_sided} {exact} {turned}"
        );
        assert!((f64::from(unshadowed(&light, origin, normal)) - exact).abs() < 2e-5 * (1.0 + exact));
    }
}

#[test]
fn triangles_add_up_to_a_parallelogram() {
    let (corner, u, v) = (Vec3::new(-0.5, 2.0, -0.5), Vec3::new(1.0, 0.0, 0.2), Vec3::new(0.3, 0.2, 1.0));
    let whole = AreaLight::parallelogram(corner, u, v, Vec3::ONE);
    let one = AreaLight::polygon(&[corner, corner + u, corner + u + v], Vec3::ONE).unwrap();
    let other = AreaLight::polygon(&[corner, corner + u + v, corner + v], Vec3::ONE).unwrap();
    for (origin, normal) in [
        (Vec3::ZERO, Vec3::Y),
        (Vec3::new(3.0, 0.0, 1.0), Vec3::Y),
        (Vec3::new(0.2, 1.0, 0.1), Vec3::new(0.8, 0.6, 0.0)),
        (Vec3::new(0.2, 1.7, 0.1), Vec3::new(1.0, 0.0, 0.0)),
    ] {
        let sum = unshadowed(&one, origin, normal) + unshadowed(&other, origin, normal);
        let expected = unshadowed(&whole, origin, normal);
        assert!(expected > 0.0 && (sum / expected - 1.0).abs() < 1e-4, "{origin}: {sum} {expected}");
    }
}

fn contact(lights: Vec<AreaLight>) -> Stage {
    let plain = Stage::bundled("contact").unwrap();
    Stage::new(Scene { lights, ..Scene::clone(&plain.scene) }).unwrap()
}

fn config(refiner: RefinerConfig, samples: u32) -> PipelineConfig {
    PipelineConfig {
        width: 96,
        height: 72,
        refiner,
        visibility: VisibilityConfig::Auto,
        sampling: LightSampling { count: samples, ..LightSampling::default() },
        ..PipelineConfig::default()
    }
}

const CENTRE: Vec3 = Vec3::new(-1.85, 3.0, -0.15);
const RADIUS: f32 = 0.75;
const RADIANCE: Vec3 = Vec3::new(22.0, 20.0, 18.0);

fn disk() -> AreaLight {
    AreaLight::disk(CENTRE, -Vec3::Y, RADIUS, RADIANCE)
}

/// The disk in strips.
fn strips() -> Vec<AreaLight> {
    let count = 32;
    let strip = |index: i32| {
        let (low, high) =
            (index as f32 / count as f32 * 2.0 - 1.0, (index + 1) as f32 / count as f32 * 2.0 - 1.0);
        // The chord that gives the strip its area.
        let area = |x: f32| 0.5 * (x * (1.0 - x * x).max(0.0).sqrt() + x.asin());
        let half = (area(high) - area(low)) / (high - low);
        let corner = CENTRE + Vec3::new(low * RADIUS, 0.0, -half * RADIUS);
        AreaLight::parallelogram(
            corner,
            Vec3::X * ((high - low) * RADIUS),
            Vec3::Z * (2.0 * half * RADIUS),
            RADIANCE,
        )
    };
    (0..count).map(strip).collect()
}

#[test]
fn shadows_of_a_disk_are_those_of_its_strips() {
    let reference = contact(strips()).render(&config(RefinerConfig::PerPixel, 256)).unwrap();
    let stage = contact(vec![disk()]);
    let lattice = |quality: Quality| RefinerConfig::Lattice(quality.lattice());
    for (refiner, samples, most) in [
        (RefinerConfig::PerPixel, 4096, 1e-5),
        (RefinerConfig::PerPixel, 64, 5e-4),
        (lattice(Quality::Good), 64, 1e-4),
        (lattice(Quality::Final), 64, 1.5e-5),
    ] {
        let found = nmse2(&stage.render(&config(refiner, samples)).unwrap(), &reference);
        assert!(found < most, "{refiner:?} {samples}: {found:e}");
    }
    let sampled = PipelineConfig { shading: Shading::Sampled, ..config(RefinerConfig::PerPixel, 4096) };
    let found = nmse2(&stage.render(&sampled).unwrap(), &reference);
    assert!(found < 2e-5, "sampled: {found:e}");
    // The square around the disk is another light.
    let frame = disk().frame();
    let square = contact(vec![AreaLight::parallelogram(frame.origin, frame.u, frame.v, RADIANCE)]);
    assert!(nmse2(&square.render(&config(RefinerConfig::PerPixel, 64)).unwrap(), &reference) > 1e-2);
}

#[test]
fn a_polygon_of_four_corners_is_a_parallelogram() {
    let lamp = Stage::bundled("contact").unwrap().scene.lights[0];
    let [a, b, c, d] = lamp.corners();
    let (edge, far) = ((b - a) * 0.5, c - d);
    // One more corner on a side changes nothing.
    let polygon = AreaLight::polygon(&[a, a + edge, b, d + far, d], lamp.radiance).unwrap();
    assert!(matches!(polygon.extent(), Extent::Polygon(sides) if sides.coefficients().len() == 5));
    let reference = contact(vec![lamp]).render(&config(RefinerConfig::PerPixel, 4096)).unwrap();
    let found = contact(vec![polygon]).render(&config(RefinerConfig::PerPixel, 4096)).unwrap();
    assert!(nmse2(&found, &reference) < 2e-6, "{:e}", nmse2(&found, &reference));
}

#[test]
fn exact_backends_agree_bit_for_bit_on_every_shape() {
    let hexagon: Vec<Vec3> = (0..6)
        .map(|k| (TAU as f32 * k as f32 / 6.0).sin_cos())
        .map(|(sine, cosine)| CENTRE + Vec3::new(RADIUS * sine, 0.0, RADIUS * cosine))
        .collect();
    let hexagon = AreaLight::polygon(&hexagon, RADIANCE).unwrap();
    let stage = contact(vec![disk(), hexagon.two_sided().moved(Vec3::new(4.0, -0.5, 0.0))]);
    let image = |visibility: &str| {
        let config = PipelineConfig {
            visibility: VisibilityConfig::named(visibility).unwrap(),
            sampling: LightSampling { count: 64, kind: PatternKind::ShiftedRows, ..LightSampling::default() },
            ..config(RefinerConfig::PerPixel, 64)
        };
        stage.render(&config).unwrap().irradiance
    };
    let rays = image("bvh");
    for visibility in ["beam", "auto", "raster4d"] {
        assert_eq!(image(visibility), rays, "{visibility}");
    }
}
