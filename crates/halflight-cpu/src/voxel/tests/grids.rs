//! Voxels that rasterization sets.

use glam::DVec3;

use super::*;
use crate::bvh::tests::meshes::mesh;

const CAMERA: Camera = Camera::look_at(Vec3::new(0.3, 0.2, 4.0), Vec3::new(0.0, -0.1, 0.0), Vec3::Y, 55.0);

fn filled(frustum: &Frustum, triangles: &[[Vec3; 3]]) -> Grid {
    let grid = Grid::new(frustum.side, frustum.bits);
    rasterize::rasterize(&grid, frustum, &mesh(triangles));
    grid.build_levels();
    grid
}

fn is_set(grid: &Grid, [column, row, slice]: [usize; 3]) -> bool {
    grid.meets(row * grid.side() + column, slice, slice)
}

fn set_voxels(grid: &Grid) -> Vec<[usize; 3]> {
    let voxels =
        (0..grid.side() * grid.side()).flat_map(|texel| (0..grid.bits()).map(move |slice| (texel, slice)));
    voxels
        .map(|(texel, slice)| [texel % grid.side(), texel / grid.side(), slice])
        .filter(|&voxel| is_set(grid, voxel))
        .collect()
}

/// Number of points on triangles that lie in the grid, at random and on the triangles' borders, and number of
/// those in unset voxels.
fn unset(frustum: &Frustum, grid: &Grid, triangles: &[[Vec3; 3]], samples: usize) -> (usize, usize) {
    let mut numbers = Numbers::new(9);
    let (mut inside, mut unset) = (0, 0);
    for corners in triangles {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        for sample in 0..samples {
            let u = f64::from(numbers.next());
            let v = if sample % 2 == 0 { 0.0 } else { f64::from(numbers.next()) * (1.0 - u) };
            let point: DVec3 = a + (b - a) * u + (c - a) * v;
            if let Some(voxel) = frustum.voxel(frustum.turn(point - frustum.eye.as_dvec3())) {
                inside += 1;
                unset += usize::from(!is_set(grid, voxel));
            }
        }
    }
    (inside, unset)
}

#[test]
fn triangles_set_every_voxel_they_touch_however_thin() {
    for (side, bits) in [(32, 32), (67, 100), (128, 128), (200, 512)] {
        let frustum = Frustum::new(&CAMERA, 1.5, (0.8, 7.0), side, bits);
        let mut numbers = Numbers::new(side as u32);
        // From needles of a micrometre to triangles that are larger than the view and reach behind the eye.
        let triangles: Vec<[Vec3; 3]> = (0..400)
            .map(|index| {
                let (at, long) = (numbers.point(2.0), numbers.point(10f32.powi(index % 4 - 2)));
                let wide = numbers.point(10f32.powi(index % 7 - 6));
                [at, at + long, at + long * 0.5 + wide]
            })
            .collect();
        let grid = filled(&frustum, &triangles);
        let (inside, missed) = unset(&frustum, &grid, &triangles, 100);
        assert!(inside > 10_000, "{side}: {inside} points say something");
        assert_eq!(missed, 0, "{side}x{bits}");
        // The check can fail: half the triangles leave voxels of the other half unset.
        let (_, missed) = unset(&frustum, &filled(&frustum, &triangles[..200]), &triangles, 100);
        assert!(missed > 1000, "{side}: {missed}");
    }
}

#[test]
fn voxels_that_nothing_touches_stay_unset() {
    let frustum = Frustum::new(&CAMERA, 1.5, (0.8, 7.0), 64, 64);
    let mut numbers = Numbers::new(4);
    for _ in 0..40 {
        let corners = [numbers.point(2.0), numbers.point(2.0), numbers.point(2.0)];
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let grid = filled(&frustum, &[corners]);
        let (low, high) =
            (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
        for voxel in set_voxels(&grid) {
            let points = frustum.corners(voxel);
            // Single precision places corners within 1e-5 of a scene of ten metres. A texel's slices are the
            // depth range of the triangle in the texel, not of its plane in each voxel: one voxel more is
            // correct where the triangle is steep in the texel.
            let sides = points.map(|p| normal.dot(p - corners[0]));
            let touches = sides.iter().any(|&s| s < 1e-5) && sides.iter().any(|&s| s > -1e-5);
            let apart = |axis: usize| {
                points.iter().all(|p| p[axis] < low[axis] - 1e-5)
                    || points.iter().all(|p| p[axis] > high[axis] + 1e-5)
            };
            assert!(touches || sides.iter().all(|s| s.abs() < 2.0 * frustum.width_along(points[7], normal)));
            assert!(!(apart(0) || apart(1) || apart(2)), "{voxel:?}");
        }
    }
}

#[test]
fn a_wall_that_faces_the_camera_is_one_slice_thick() {
    let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 90.0);
    let frustum = Frustum::new(&camera, 1.0, (1.0, 9.0), 64, 64);
    // At depth 4.05 the image is 8.1 wide: 64 texels, slices of an eighth of a metre.
    let at = |x: f32, y: f32| Vec3::new(x, y, -4.05);
    let texel = 8.1 / 64.0;
    let (left, right) = (-texel * 3.5, texel * 4.5);
    let grid = filled(
        &frustum,
        &[
            [at(left, left), at(right, left), at(right, right)],
            [at(left, left), at(right, right), at(left, right)],
        ],
    );
    let voxels = set_voxels(&grid);
    assert_eq!(voxels.len(), 9 * 9);
    assert!(voxels.iter().all(|&[x, y, z]| (28..=36).contains(&x) && (27..=35).contains(&y) && z == 24));
}

#[test]
fn coarse_levels_never_call_a_box_empty_that_is_not() {
    let frustum = Frustum::new(&CAMERA, 1.0, (0.8, 7.0), 75, 130);
    let mut numbers = Numbers::new(2);
    let triangles: Vec<_> =
        (0..20).map(|_| [numbers.point(1.0), numbers.point(1.0), numbers.point(1.0)]).collect();
    let grid = filled(&frustum, &triangles);
    let voxels = set_voxels(&grid);
    let (mut empty, mut full) = (0, 0);
    for _ in 0..2000 {
        let mut low = [0; 3];
        let mut high = [0; 3];
        for axis in 0..3 {
            let size = if axis == 2 { 130 } else { 75 };
            low[axis] = (numbers.next() * size as f32) as usize;
            high[axis] = (low[axis] + (numbers.next() * numbers.next() * 40.0) as usize).min(size - 1);
        }
        let holds = |voxel: &[usize; 3]| (0..3).all(|axis| (low[axis]..=high[axis]).contains(&voxel[axis]));
        if grid.is_empty(low, high) {
            empty += 1;
            assert!(!voxels.iter().any(holds), "{low:?} {high:?}");
        } else {
            full += 1;
        }
    }
    assert!(empty > 200 && full > 200, "{empty} {full}");
}

#[test]
fn triangles_through_the_eye_and_odd_cameras_are_no_trouble() {
    let mut numbers = Numbers::new(5);
    let mut triangles: Vec<[Vec3; 3]> = (0..100)
        .map(|_| [CAMERA.eye + numbers.point(1.0), CAMERA.eye - numbers.point(5.0), numbers.point(1e6)])
        .collect();
    triangles.push([CAMERA.eye; 3]);
    triangles.push([CAMERA.eye, CAMERA.eye + Vec3::X, CAMERA.target]);
    triangles.push([Vec3::splat(9e11), Vec3::splat(-9e11), Vec3::new(9e11, -9e11, 0.0)]);
    let odd = [
        CAMERA,
        Camera { target: CAMERA.eye, ..CAMERA },
        Camera { up: Vec3::ZERO, ..CAMERA },
        Camera { fov_y_deg: 179.9, ..CAMERA },
        Camera { eye: Vec3::NAN, ..CAMERA },
    ];
    for camera in odd {
        let frustum = Frustum::new(&camera, 1.0, (0.5, 100.0), 64, 64);
        let grid = filled(&frustum, &triangles);
        if camera == CAMERA {
            assert_eq!(unset(&frustum, &grid, &triangles[..100], 200).1, 0);
        }
    }
}
