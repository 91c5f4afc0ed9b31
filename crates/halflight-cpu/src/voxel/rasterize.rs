//! Conservative rasterization of triangles into the grid: every voxel that a triangle touches is set.
//!
//! A triangle is clipped to the frustum in homogeneous coordinates, projected, and cut into the rows of the
//! grid and each strip into texels; the depth range of each part gives the slices to set. This needs neither
//! a plane nor an area: triangles that are thin, seen edge-on or crossing the eye's plane are no special
//! cases.

use glam::DVec3;
use halflight_core::scene::Mesh;
use rayon::prelude::*;

use super::frustum::Frustum;
use super::grid::Grid;

/// Most corners of a clipped triangle: three, and one more for each plane that may cut one off, six of the
/// frustum and four of a texel.
const CORNERS: usize = 13;

/// Margin of a voxel beyond its border, in voxels: far more than rounding moves a point on the border.
const SLACK: f64 = 1e-6;

/// Number of triangles that one task takes.
const CHUNK: usize = 256;

/// Convex polygon, possibly without area.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [DVec3; CORNERS],
    count: usize,
}

impl Polygon {
    const EMPTY: Self = Self { corners: [DVec3::ZERO; CORNERS], count: 0 };

    fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    fn push(&mut self, corner: DVec3) {
        // Rounding can make a polygon slightly concave and cut off more corners than there are planes; a
        // corner that is dropped then lies within rounding of its neighbours.
        if self.count < CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// Part where `side` is not negative; `side` is affine.
    #[inline(always)]
    fn clip(&self, side: impl Fn(DVec3) -> f64) -> Self {
        let mut out = Self::EMPTY;
        let Some(&last) = self.corners().last() else { return out };
        let (mut before, mut before_side) = (last, side(last));
        for &corner in self.corners() {
            let corner_side = side(corner);
            if (before_side < 0.0) != (corner_side < 0.0) {
                out.push(before + (corner - before) * (before_side / (before_side - corner_side)));
            }
            if corner_side >= 0.0 {
                out.push(corner);
            }
            (before, before_side) = (corner, corner_side);
        }
        out
    }

    /// Part between two values of a coordinate.
    #[inline(always)]
    fn between(&self, axis: usize, low: f64, high: f64) -> Self {
        self.clip(|p| p[axis] - low).clip(|p| high - p[axis])
    }

    /// Least and greatest value of a coordinate.
    #[inline(always)]
    fn range(&self, axis: usize) -> (f64, f64) {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        self.corners().iter().fold(ends, |(low, high), p| (low.min(p[axis]), high.max(p[axis])))
    }
}

/// Sets every voxel that a triangle of the mesh without an alpha mask touches. OR is commutative, so the result does not depend on
/// the number of threads.
pub(super) fn rasterize(grid: &Grid, frustum: &Frustum, mesh: &Mesh) {
    mesh.triangles.par_chunks(CHUNK).enumerate().for_each(|(chunk, triangles)| {
        for (number, triangle) in triangles.iter().enumerate() {
            if mesh.alpha_mask(chunk * CHUNK + number).is_some() {
                continue;
            }
            let corners = triangle.map(|vertex| frustum.place(mesh.positions[vertex as usize]));
            triangle_into(grid, frustum, corners);
        }
    });
}

/// Sets the voxels that one triangle, given in homogeneous coordinates, touches.
fn triangle_into(grid: &Grid, frustum: &Frustum, corners: [DVec3; 3]) {
    let Some(mut polygon) = clip_to(frustum, corners) else { return };
    for corner in &mut polygon.corners[..polygon.count] {
        let inverse = 1.0 / corner.z;
        *corner = DVec3::new(corner.x * inverse, corner.y * inverse, inverse);
    }
    let (top, bottom) = texels(polygon.range(1), frustum.side);
    for row in top..=bottom {
        let strip = if top == bottom {
            polygon
        } else {
            polygon.between(1, row as f64 - SLACK, (row + 1) as f64 + SLACK)
        };
        if strip.count == 0 {
            continue;
        }
        let (left, right) = texels(strip.range(0), frustum.side);
        for column in left..=right {
            let piece = if left == right {
                strip
            } else {
                strip.between(0, column as f64 - SLACK, (column + 1) as f64 + SLACK)
            };
            if piece.count > 0 {
                let (low, high) = slices(frustum, piece.range(2));
                grid.set(column, row, low, high);
            }
        }
    }
}

/// Part of a triangle inside the frustum, or `None`.
fn clip_to(frustum: &Frustum, corners: [DVec3; 3]) -> Option<Polygon> {
    let outside = corners.map(|corner| {
        frustum
            .sides(corner)
            .iter()
            .enumerate()
            .fold(0u32, |bits, (plane, &s)| bits | u32::from(s < 0.0) << plane)
    });
    if outside[0] & outside[1] & outside[2] != 0 {
        return None;
    }
    let mut polygon = Polygon::EMPTY;
    for corner in corners {
        polygon.push(corner);
    }
    let crossed = outside[0] | outside[1] | outside[2];
    for plane in 0..6 {
        if crossed >> plane & 1 == 1 {
            polygon = polygon.clip(|p| frustum.sides(p)[plane]);
        }
    }
    (polygon.count > 0).then_some(polygon)
}

/// First and last texel that an interval touches.
fn texels((low, high): (f64, f64), side: usize) -> (usize, usize) {
    let last = side - 1;
    (((low - SLACK) as usize).min(last), ((high + SLACK) as usize).min(last))
}

/// First and last slice that an interval of 1 / depth touches.
#[inline(always)]
fn slices(frustum: &Frustum, (low, high): (f64, f64)) -> (usize, usize) {
    let slice = |inverse: f64| (1.0 / inverse - f64::from(frustum.near)) * frustum.slices();
    let last = frustum.bits - 1;
    (((slice(high) - SLACK) as usize).min(last), ((slice(low) + SLACK) as usize).min(last))
}
