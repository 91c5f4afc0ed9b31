//! Voxels that a ray tests.

use std::collections::BTreeSet;

use glam::DVec3;

use super::*;

const RUN: Run = Run::WHOLE;

/// Kernel that collects all voxels that a ray tests.
struct Visits<'a> {
    frustum: &'a Frustum,
    traversal: Traversal,
    thickness: u32,
    origin: DVec3,
    end: DVec3,
}

impl Kernel for Visits<'_> {
    type Output = BTreeSet<[usize; 3]>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let mut visits = BTreeSet::new();
        let ends = self.end.as_vec3().to_array().map(|along| [along; LANES]);
        let rays = Rays { origin: self.origin.as_vec3(), ends: &ends };
        let (measures, side) = (Measures::new(self.frustum), self.frustum.side);
        let ask = |lane: usize, texel: usize, from: usize, to: usize| {
            assert_eq!(lane, 5);
            for slice in from.min(to)..=from.max(to) {
                visits.insert([texel % side, texel / side, slice]);
            }
            false
        };
        march::march::<S::Wide>(self.traversal, self.thickness, &measures, &rays, RUN, 1 << 5, ask);
        visits
    }
}

fn frustum(side: usize, bits: usize) -> Frustum {
    let camera = Camera {
        eye: Vec3::new(1.0, 2.0, 3.0),
        target: Vec3::ZERO,
        up: Vec3::Y,
        fov_y_deg: 60.0,
        ..Camera::default()
    };
    Frustum::new(&camera, 1.3, (1.0, 8.0), side, bits)
}

/// Random segment, mostly in the frustum, in homogeneous coordinates.
fn segment(frustum: &Frustum, numbers: &mut Numbers) -> [DVec3; 2] {
    [(), ()].map(|()| {
        let mut along = || f64::from(numbers.next()) * 1.2 - 0.1;
        let (x, y) = (along(), along());
        let depth = f64::from(frustum.near + (frustum.far - frustum.near) * along() as f32);
        DVec3::new(x * frustum.side as f64, y * frustum.side as f64, 1.0) * depth
    })
}

/// Bound on the error of a ray in single precision, in voxels, for grids of at most 200 texels: 200 units in
/// the last place, 2^-23 of it each, over some ten operations.
const ROUNDING: f64 = 1e-3;

/// True if a segment passes a voxel enlarged by [`ROUNDING`]: clipped against its six planes, exactly.
fn passes(frustum: &Frustum, [a, b]: [DVec3; 2], [column, row, slice]: [usize; 3]) -> bool {
    let slices = |p: DVec3| (p.z - f64::from(frustum.near)) * frustum.slices();
    let side = |p: DVec3| {
        let border = |at: usize| (at as f64 - ROUNDING, (at + 1) as f64 + ROUNDING);
        let ((left, right), (top, bottom), (low, high)) = (border(column), border(row), border(slice));
        [
            p.x - left * p.z,
            right * p.z - p.x,
            p.y - top * p.z,
            bottom * p.z - p.y,
            slices(p) - low,
            high - slices(p),
        ]
    };
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for (first, second) in side(a).into_iter().zip(side(b)) {
        let at = first / (first - second);
        match (first < 0.0, second < 0.0) {
            (true, true) => return false,
            (true, false) => enter = enter.max(at),
            (false, true) => leave = leave.min(at),
            (false, false) => {}
        }
    }
    enter <= leave
}

/// True if a point is nearer than [`ROUNDING`] to a border between voxels or of the grid.
fn on_border(frustum: &Frustum, p: DVec3) -> bool {
    let slice = (p.z - f64::from(frustum.near)) * frustum.slices();
    [p.x / p.z, p.y / p.z, slice].iter().any(|at| (at - at.round()).abs() < ROUNDING)
}

#[test]
fn exact_traversal_visits_what_dense_sampling_finds_and_nothing_else() {
    for (side, bits) in [(32, 32), (75, 130), (128, 128), (200, 512)] {
        let frustum = frustum(side, bits);
        let mut numbers = Numbers::new(bits as u32);
        let mut found = 0;
        for _ in 0..150 {
            let [origin, end] = segment(&frustum, &mut numbers);
            let kernel =
                || Visits { frustum: &frustum, traversal: Traversal::Dda, thickness: 7, origin, end };
            let visits = Isa::BASELINE.run(kernel());
            for isa in Isa::available() {
                assert_eq!(isa.run(kernel()), visits, "{isa:?}");
            }
            for sample in 0..4000 {
                let p = origin.lerp(end, f64::from(sample) / 3999.0);
                if let Some(voxel) = frustum.voxel(p).filter(|_| !on_border(&frustum, p)) {
                    found += 1;
                    assert!(visits.contains(&voxel), "{voxel:?} of {origin} to {end}");
                }
            }
            for &voxel in &visits {
                assert!(passes(&frustum, [origin, end], voxel), "{voxel:?} of {origin} to {end}");
            }
        }
        assert!(found > 100_000, "{found}");
    }
}

#[test]
fn steps_ask_at_equal_distances_and_about_neighbouring_slices() {
    let frustum = frustum(64, 64);
    let mut numbers = Numbers::new(3);
    for _ in 0..100 {
        let [origin, end] = segment(&frustum, &mut numbers);
        let traversal = Traversal::Steps { count: 10 };
        let visits = Isa::best().run(Visits { frustum: &frustum, traversal, thickness: 2, origin, end });
        let mut expected = BTreeSet::new();
        let mut sure = true;
        for sample in 0..10 {
            let p = origin.lerp(end, (f64::from(sample) + 0.5) / 10.0);
            sure &= !on_border(&frustum, p);
            if let Some([x, y, z]) = frustum.voxel(p) {
                expected.extend((z.saturating_sub(2)..=(z + 2).min(63)).map(|slice| [x, y, slice]));
            }
        }
        assert!(!sure || visits == expected, "{visits:?} {expected:?}");
    }
}

#[test]
fn rays_outside_the_grid_ask_nothing() {
    let frustum = frustum(64, 64);
    let inside = DVec3::new(32.0, 32.0, 1.0) * 4.0;
    for (origin, end) in [
        // Right of the image, behind the eye, beyond the last slice, and through the eye.
        (DVec3::new(65.0, 3.0, 1.0) * 2.0, DVec3::new(66.0, 50.0, 1.0) * 5.0),
        (-inside, -inside * 2.0),
        (inside * 2.5, inside * 9.0),
        (DVec3::ZERO, DVec3::ZERO),
    ] {
        for traversal in [Traversal::Dda, Traversal::Steps { count: 64 }] {
            let kernel = Visits { frustum: &frustum, traversal, thickness: 0, origin, end };
            assert!(Isa::best().run(kernel).is_empty(), "{traversal:?} {origin}");
        }
    }
}
