//! Closed meshes are watertight, and no surface shadows itself, at any scale and far from the origin.

use std::sync::Arc;

use glam::{DQuat, DVec3, Vec3};
use halflight_core::gbuffer::{GBuffer, receiver_origin};
use halflight_core::light::AreaLight;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::scene::{Camera, Scene};

use super::meshes::{Numbers, answer, cuboid, lamp, mesh, scene, sphere};
use crate::bvh::Bvh;
use crate::bvh::packet::{Packet, RAYS};
use crate::bvh::stack::Stacks;
use crate::gbuffer;
use crate::rays::BvhRays;
use crate::simd::{Isa, Kernel, Simd};

/// Up to 64 segments from an origin: occlusion by a packet and one by one.
struct Segments<'a> {
    bvh: &'a Bvh,
    origin: Vec3,
    ends: &'a [Vec3],
}

impl Kernel for Segments<'_> {
    type Output = (u64, u64);

    #[inline(always)]
    fn run<S: Simd>(self) -> (u64, u64) {
        let (mut packet, mut stacks) = (Packet::new(), Stacks::new());
        for (ray, end) in self.ends.iter().enumerate() {
            for (axis, ends) in packet.ends_mut().iter_mut().enumerate() {
                ends[ray] = end[axis];
            }
        }
        packet.set_ends::<S>(self.origin, self.ends.len());
        let together = self.bvh.occluded::<S>(&packet, &mut stacks);
        let mut single = 0;
        for ray in 0..packet.count {
            let end = packet.end(ray);
            single |= u64::from(self.bvh.occludes::<S>(0, self.origin, end, &mut stacks.single)) << ray;
        }
        (together, single)
    }
}

/// Number of segments from inside a closed mesh through its corners and edges that are not occluded.
fn leaks(bvh: &Bvh, closed: &[[Vec3; 3]]) -> usize {
    let mut numbers = Numbers(5);
    let mut leaks = 0;
    for isa in Isa::available() {
        for _ in 0..20 {
            let origin = numbers.point() * 0.4;
            let through: Vec<Vec3> = closed
                .iter()
                .flat_map(|&[a, b, c]| {
                    let along = [0.5, numbers.next(), numbers.next() * 1e-3];
                    [a, a.lerp(b, along[0]), b.lerp(c, along[1]), c.lerp(a, along[2])]
                })
                .collect();
            for points in through.chunks(RAYS) {
                let ends: Vec<Vec3> = points.iter().map(|&p| origin + (p - origin) * 2.0).collect();
                let (together, single) = isa.run(Segments { bvh, origin, ends: &ends });
                assert_eq!(together, single, "{isa:?}");
                leaks += ends.len() - together.count_ones() as usize;
            }
        }
    }
    leaks
}

#[test]
fn rays_through_edges_and_corners_of_closed_meshes_are_stopped() {
    for closed in [sphere(24), cuboid(Vec3::splat(-0.9), Vec3::splat(0.8))] {
        assert_eq!(leaks(&Bvh::build(&mesh(&closed)).unwrap(), &closed), 0);
        // A mesh with a hole must not pass.
        assert!(leaks(&Bvh::build(&mesh(&closed[1..])).unwrap(), &closed) > 0);
        // A BVH that was refitted to the mesh from other positions must pass.
        let elsewhere: Vec<[Vec3; 3]> = closed
            .iter()
            .map(|corners| corners.map(|p| Vec3::new(p.y * 9.0, 0.1 * p.x - p.y * p.z, p.z)))
            .collect();
        let mut moved = Bvh::build(&mesh(&elsewhere)).unwrap();
        moved.refit(&mesh(&closed)).unwrap();
        assert_eq!(leaks(&moved, &closed), 0);
    }
}

/// Scene after scaling and translation.
fn placed(mut scene: Scene, scale: f32, shift: Vec3) -> Scene {
    let place = |p: Vec3| p * scale + shift;
    Arc::make_mut(&mut scene.mesh).positions.iter_mut().for_each(|p| *p = place(*p));
    for light in &mut scene.lights {
        *light = light.transformed(place, |direction| direction * scale);
    }
    scene.camera.eye = place(scene.camera.eye);
    scene.camera.target = place(scene.camera.target);
    scene
}

/// Scales and translations that must not change the outcome. Scenes of a few units are still resolved at 1e5,
/// tiny ones are not.
fn placements() -> impl Iterator<Item = (f32, Vec3)> {
    let far = Vec3::new(1e5, -1e5, 1e5);
    [(1e-3, Vec3::ZERO), (1.0, Vec3::ZERO), (1e4, Vec3::ZERO), (1.0, far), (1e2, far)].into_iter()
}

/// Traces the scene. Returns the number of receivers for which `counts` holds, and how many of their samples
/// that are at least `sine` above the receiver's horizon are visible and not visible.
fn shadows(scene: &Scene, sine: f32, counts: impl Fn(Vec3) -> bool) -> (usize, u64, u64) {
    let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
    let mut pixels = GBuffer::default();
    gbuffer::trace(&bvh, scene, 61, 47, &mut pixels);
    let pattern = Pattern::with_count(PatternKind::Jittered, 64).unwrap();
    let mut batch = MaskBatch::default();
    batch.reset(0, pattern, Purpose::Refine);
    for pixel in 0..pixels.pixels() {
        let Some(receiver) = pixels.receiver(pixel).filter(|receiver| counts(receiver.origin)) else {
            continue;
        };
        let above = |&sample: &usize| {
            let d = scene.lights[0].point(pattern.position(sample, pixel as u32)) - receiver.origin;
            d.normalize().dot(receiver.normal) > sine
        };
        let subset = (0..64).filter(above).fold(0, |bits, sample| bits | 1u64 << sample);
        batch.push(receiver.origin, receiver.normal, pixel as u32, pixel as u32, Some(&[subset]));
    }
    let visible = answer(&mut BvhRays::new(bvh), scene, &mut batch);
    let wanted: u64 = (0..batch.len()).map(|query| u64::from(batch.wanted(query)[0].count_ones())).sum();
    let visible: u64 = visible.iter().map(|bits| u64::from(bits.count_ones())).sum();
    (batch.len(), visible, wanted - visible)
}

#[test]
fn open_floors_and_convex_bodies_do_not_shadow_themselves() {
    let floor = [
        [Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0],
        [Vec3::Z * 4.0, Vec3::new(4.0, 0.0, 4.0), Vec3::X * 4.0],
    ];
    let camera =
        Camera { eye: Vec3::new(0.5, 2.5, 6.0), target: Vec3::new(2.0, 0.0, 2.0), ..Camera::default() };
    let floor = Scene { camera, ..scene(&floor, lamp(Vec3::new(2.0, 3.0, 2.0), 1.0)) };
    let light = lamp(Vec3::new(1.0, 3.0, 2.0), 1.0);
    let camera = Camera { eye: Vec3::new(0.5, 2.0, 3.0), target: Vec3::ZERO, ..Camera::default() };
    let round = Scene { camera, ..scene(&sphere(24), light) };
    let edged = Scene { camera, ..scene(&cuboid(Vec3::splat(-0.8), Vec3::splat(0.8)), light) };
    for (scale, shift) in placements() {
        for (name, scene) in [("floor", &floor), ("sphere", &round), ("box", &edged)] {
            let scene = placed(scene.clone(), scale, shift);
            // Far away, corners are rounded to 1/128, so that neighbouring facets of the sphere, 0.13 across,
            // may tilt by 0.06 against each other and are no longer convex.
            let (receivers, visible, shadowed) =
                shadows(&scene, if shift == Vec3::ZERO { 1e-3 } else { 0.1 }, |_| true);
            assert!(receivers > 200 && visible > 2000, "{name} {scale} {shift}: {receivers}, {visible}");
            assert_eq!(shadowed, 0, "{name} scaled by {scale}, moved by {shift}, of {visible}");
        }
    }
}

#[test]
fn closed_boxes_let_nothing_in() {
    let closed = cuboid(Vec3::splat(-1.0), Vec3::splat(1.0));
    let light = lamp(Vec3::Y * 1.5, 3.0);
    let camera = Camera {
        eye: Vec3::new(0.3, 0.2, 0.8),
        target: Vec3::new(-0.2, -0.1, 0.0),
        up: Vec3::Y,
        fov_y_deg: 120.0,
        ..Camera::default()
    };
    for (scale, shift) in placements() {
        let scene = placed(Scene { camera, ..scene(&closed, light) }, scale, shift);
        // Far away, positions next to a wall are rounded onto it, and a receiver in the wall is not inside.
        let (low, high) = scene.mesh.bounds().unwrap();
        let inside = |origin: Vec3| origin.cmpgt(low).all() && origin.cmplt(high).all();
        // All samples, those below the horizon as well.
        let (receivers, visible, shadowed) = shadows(&scene, -1.0, inside);
        assert!(
            receivers > if scale == 1.0 && shift != Vec3::ZERO { 2700 } else { 61 * 47 - 1 },
            "{receivers}"
        );
        assert_eq!(visible, 0, "scaled by {scale}, moved by {shift}, of {shadowed}");
    }
}

/// Points of `list` in double precision; rotated about an oblique axis if `turned`.
fn turned(turned: bool, list: &[DVec3]) -> Vec<DVec3> {
    let turn = DQuat::from_axis_angle(DVec3::new(0.3, 0.9, -0.4).normalize(), 1.1);
    list.iter().map(|&point| if turned { turn * point } else { point }).collect()
}

/// Number of visible samples among 64 of a light 3 m above a square ground. The receiver is the point of the
/// ground's first triangle with these barycentric weights; a sheet lies `gap` above it, if given.
fn visible_below_sheet(half: f64, weights: DVec3, shift: DVec3, turn: bool, gap: Option<f64>) -> u32 {
    let square = |middle: DVec3, half: f64| {
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
            .map(|(x, z)| middle + DVec3::new(x, 0.0, z) * half)
    };
    let plane = |points: [DVec3; 4]| {
        let [a, b, c, d] = <[Vec3; 4]>::try_from(
            turned(turn, &points).iter().map(|&p| (p + shift).as_vec3()).collect::<Vec<_>>(),
        )
        .unwrap();
        [[a, b, c], [a, c, d]]
    };
    // The sheet and the light lie over the point.
    let ground = square(DVec3::ZERO, half);
    let middle = ground[0] * weights.x + ground[1] * weights.y + ground[2] * weights.z;
    let mut mesh_corners = plane(ground).to_vec();
    let corners = mesh_corners[0].map(Vec3::as_dvec3);
    mesh_corners.extend(gap.map(|gap| plane(square(middle + DVec3::Y * gap, 1.0))).into_iter().flatten());
    let [lamp, ..] = plane(square(middle + DVec3::Y * 3.0, 0.5))[0];
    let edges = turned(turn, &[DVec3::X, DVec3::Z]);
    let (u, v) = (edges[0].as_vec3(), edges[1].as_vec3());
    let light = AreaLight::parallelogram(lamp, u, v, Vec3::ONE).two_sided();
    let scene = scene(&mesh_corners, light);
    let point = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize().as_vec3();
    let extent = 2.0 * half as f32;
    let mut batch = MaskBatch::default();
    batch.reset(0, Pattern::with_count(PatternKind::Jittered, 64).unwrap(), Purpose::Refine);
    batch.push(receiver_origin(point, normal, extent), normal, 0, 7, None);
    answer(&mut BvhRays::new(Arc::new(Bvh::build(&scene.mesh).unwrap())), &scene, &mut batch)[0].count_ones()
}

#[test]
fn sheets_shade_the_ground_right_below_them() {
    let weights = [DVec3::new(0.5, 0.001, 0.499), DVec3::new(0.4, 0.3, 0.3), DVec3::new(0.01, 0.98, 0.01)];
    for half in [2.0, 100.0, 2500.0] {
        for shift in
            [DVec3::ZERO, DVec3::new(1.0, 7.0, -3.0), DVec3::new(1e3, -2e3, 500.0), DVec3::splat(1e5)]
        {
            for (weights, turn) in weights.into_iter().flat_map(|w| [(w, false), (w, true)]) {
                let corner = |x: f64, z: f64| turned(turn, &[DVec3::new(x, 0.0, z) * half])[0] + shift;
                let middle = corner(-1.0, -1.0) * weights.x
                    + corner(-1.0, 1.0) * weights.y
                    + corner(1.0, 1.0) * weights.z;
                // Room for the sheet's own corners, a metre away and rounded themselves.
                let largest = (middle.abs().max_element() + 2.0) as f32;
                let gap = f64::from(largest.next_up() - largest) * 34.0;
                let case = format!("ground of {half}, at {middle}, turned: {turn}");
                assert_eq!(visible_below_sheet(half, weights, shift, turn, None), 64, "{case}");
                assert_eq!(
                    visible_below_sheet(half, weights, shift, turn, Some(gap)),
                    0,
                    "{case}, gap {gap}"
                );
            }
        }
    }
}
