//! Tests of the sums over cells against quadrature in double precision.

use glam::{DVec3, Vec3};
use halflight_core::light::{AreaLight, LightFrame};
use halflight_core::specular::SurfaceSpecular;

use super::cells::{Cells, Emitter, Outline};
use super::lobe::Lobe;

/// Integral of GGX over a light of unit radiance, without Fresnel term and with Schlick's weight: the midpoint rule over `side` · `side`
/// points of the light's frame, in double precision.
fn quadrature(light: &AreaLight, normal: Vec3, view: Vec3, roughness: f32, side: usize) -> [f64; 2] {
    let (normal, view) = (normal.as_dvec3(), view.as_dvec3());
    let alpha = f64::from(roughness * roughness);
    let LightFrame { origin, u, v } = light.frame();
    let (origin, u, v) = (origin.as_dvec3(), u.as_dvec3(), v.as_dvec3());
    let area = u.cross(v);
    let extent = light.extent();
    let mut sums = [0.0; 2];
    for index in 0..side * side {
        let (x, y) = ((index % side) as f64 + 0.5, (index / side) as f64 + 0.5);
        let (x, y) = (x / side as f64, y / side as f64);
        if !extent.contains(glam::Vec2::new(x as f32, y as f32)) {
            continue;
        }
        let to: DVec3 = origin + u * x + v * y;
        let direction = to.normalize();
        let (incidence, cosine) = (normal.dot(direction), normal.dot(view));
        let solid = -direction.dot(area) / to.length_squared();
        if incidence <= 0.0 || solid <= 0.0 {
            continue;
        }
        let half = (view + direction).normalize();
        let along = normal.dot(half);
        let spread = along * along * (alpha * alpha - 1.0) + 1.0;
        let distribution = alpha * alpha / (std::f64::consts::PI * spread * spread);
        let g1 = |cosine: f64| {
            2.0 * cosine / (cosine + (alpha * alpha + (1.0 - alpha * alpha) * cosine * cosine).sqrt())
        };
        let value = distribution * g1(incidence) * g1(cosine) / (4.0 * cosine) * solid;
        let grazing = (1.0 - view.dot(half)).powi(5);
        sums[0] += value * (1.0 - grazing);
        sums[1] += value * grazing;
    }
    sums.map(|sum| sum / (side * side) as f64)
}

fn of_cells(light: &AreaLight, normal: Vec3, view: Vec3, roughness: f32) -> ([f64; 2], usize) {
    let surface = SurfaceSpecular { f0: Vec3::ONE, roughness };
    let lobe = Lobe::new(normal, view, &surface);
    let outline = Outline::new(light);
    let emitter = Emitter::new(light, &outline, None, Vec3::ZERO).unwrap();
    let mut cells = Cells::default();
    let shares = cells.part(&emitter, &lobe);
    ([f64::from(shares.normal.x), f64::from(shares.grazing.x)], cells.all.len())
}

fn view(degrees: f32) -> Vec3 {
    Vec3::new(-degrees.to_radians().sin(), degrees.to_radians().cos(), 0.0)
}

/// Lights before a receiver at the origin: where a view of 45° is mirrored, beside that, across the horizon, near by, and shaped.
fn lights() -> Vec<(&'static str, AreaLight)> {
    let down = |x: f32, y: f32, z: f32, size: f32| {
        let corner = Vec3::new(x - 0.5 * size, y, z - 0.5 * size);
        AreaLight::parallelogram(corner, Vec3::X * size, Vec3::Z * size, Vec3::ONE)
    };
    let wall = AreaLight::parallelogram(Vec3::new(2.0, -1.0, -1.0), Vec3::Z * 2.0, Vec3::Y * 3.0, Vec3::ONE);
    let corners = [[1.0, -1.0], [2.5, -0.5], [2.5, 0.8], [1.2, 1.0]].map(|[x, z]| Vec3::new(x, 2.0, z));
    vec![
        ("mirrored", down(2.0, 2.0, 0.0, 1.5)),
        ("beside", down(0.3, 2.0, 0.9, 1.0)),
        ("wall", wall),
        ("near", down(0.1, 0.1, 0.0, 1.0)),
        ("disk", AreaLight::disk(Vec3::new(1.8, 2.0, 0.2), Vec3::NEG_Y, 0.7, Vec3::ONE)),
        ("polygon", AreaLight::polygon(&corners, Vec3::ONE).unwrap()),
    ]
}

/// Largest difference of both sums, as parts of all that a lobe may reflect, which is 1.
fn difference(light: &AreaLight, view: Vec3, roughness: f32, found: [f64; 2]) -> f64 {
    let expected = quadrature(light, Vec3::Y, view, roughness, if roughness < 0.15 { 1000 } else { 400 });
    (0..2).map(|sum| (found[sum] - expected[sum]).abs()).fold(0.0, f64::max)
}

#[test]
fn cells_give_the_integral_over_every_shape() {
    for roughness in [0.1f32, 0.2, 0.3, 0.6, 1.0] {
        for degrees in [0.0, 45.0, 75.0, 85.0] {
            for (name, light) in lights() {
                let view = view(degrees);
                let (found, cells) = of_cells(&light, Vec3::Y, view, roughness);
                let difference = difference(&light, view, roughness, found);
                // A quarter of a step of an 8-bit picture where all of the lobe meets the light; a step at grazing angles, where narrow
                // lobes are widest along the plane of incidence.
                let bound = if degrees > 80.0 { 4e-3 } else { 1e-3 };
                assert!(difference < bound, "{roughness} {degrees} {name}: {found:?} {difference:e}");
                assert!(cells < 1500, "{roughness} {degrees} {name}: {cells}");
            }
        }
    }
}

#[test]
fn the_quadrature_rejects_another_roughness() {
    let (_, light) = lights()[0];
    let (found, _) = of_cells(&light, Vec3::Y, view(45.0), 0.3);
    assert!(difference(&light, view(45.0), 0.31, found) > 1e-2);
}

/// A smooth surface shows the light as a mirror would: all or nothing of its radiance.
#[test]
fn smooth_surfaces_mirror_the_light() {
    let (_, light) = lights()[0];
    for (degrees, expected) in [(45.0, 1.0), (30.0, 0.0), (60.0, 0.0)] {
        let ([normal, grazing], cells) = of_cells(&light, Vec3::Y, view(degrees), 0.0);
        assert!((normal + grazing - expected).abs() < 1e-3, "{degrees}: {normal} {grazing} {cells}");
    }
}

/// A lobe that stands alone before the light's edge sees the part of it that lies on the light's side: half where its middle meets the edge.
#[test]
fn half_of_a_narrow_lobe_passes_an_edge_that_it_is_aimed_at() {
    let light = AreaLight::parallelogram(Vec3::new(2.0, 2.0, -5.0), Vec3::X * 5.0, Vec3::Z * 10.0, Vec3::ONE);
    let ([normal, grazing], _) = of_cells(&light, Vec3::Y, view(45.0), 0.05);
    assert!((normal + grazing - 0.5).abs() < 5e-3, "{normal} {grazing}");
}
