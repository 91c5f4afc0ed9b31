//! View frustum that a grid covers, and the grid's coordinates.

use glam::{DVec3, Vec3};
use halflight_core::frame::Frame;
use halflight_core::scene::Camera;

/// View frustum between two depths, divided into texels and slices.
///
/// A point's homogeneous coordinates are (X, Y, depth), linear in its world-space position: X / depth and Y /
/// depth are its position in the image in texels, right and down from the top left corner. Slices have equal
/// depth, so the third coordinate of the grid is linear in depth. A straight line in the world is straight in
/// the image, and 1 / depth is linear along that image.
#[derive(Clone, Copy, Debug)]
pub struct Frustum {
    /// Position of the camera, world space.
    pub eye: Vec3,
    /// Vectors whose products with a vector are its X, Y and depth.
    pub rows: [DVec3; 3],
    /// World-space size of a texel at depth 1: right and up.
    pub texel: [Vec3; 2],
    /// Unit direction of view.
    pub forward: Vec3,
    /// Direction through the middle of the image, one unit along the view direction.
    pub centre: Vec3,
    /// Depth at which the frustum begins, metres.
    pub near: f32,
    /// Depth at which the frustum ends, metres.
    pub far: f32,
    /// Texels per side.
    pub side: usize,
    /// Number of slices.
    pub bits: usize,
}

impl Frustum {
    /// Frustum through an image of `aspect` = width / height.
    pub fn new(camera: &Camera, aspect: f32, (near, far): (f32, f32), side: usize, bits: usize) -> Self {
        let forward = (camera.target - camera.eye).normalize_or(Vec3::NEG_Z);
        let right =
            forward.cross(camera.up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = right.cross(forward);
        let half_height = (camera.fov_y_deg.to_radians() * 0.5).tan();
        let half_width = half_height * camera.aspect.unwrap_or(aspect);
        let shift = camera.shift;
        let texels = side as f64;
        let depth = forward.as_dvec3();
        let across = |axis: Vec3, half: f32, shift: f32| {
            (axis.as_dvec3() / f64::from(half) + depth * (1.0 - f64::from(shift))) * (0.5 * texels)
        };
        Self {
            eye: camera.eye,
            rows: [across(right, half_width, shift.x), across(-up, half_height, -shift.y), depth],
            texel: [right * (2.0 * half_width / side as f32), up * (2.0 * half_height / side as f32)],
            forward,
            centre: forward + right * (half_width * shift.x) + up * (half_height * shift.y),
            near,
            far,
            side,
            bits,
        }
    }

    /// Homogeneous coordinates of a vector, in double precision.
    pub fn turn(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.rows[0].dot(v), self.rows[1].dot(v), self.rows[2].dot(v))
    }

    /// Homogeneous coordinates of a point, in double precision.
    pub fn place(&self, point: Vec3) -> DVec3 {
        self.turn(point.as_dvec3() - self.eye.as_dvec3())
    }

    /// Slices per metre of depth.
    pub fn slices(&self) -> f64 {
        self.bits as f64 / (f64::from(self.far) - f64::from(self.near))
    }

    /// True if homogeneous coordinates lie in the grid, borders included.
    pub(super) fn holds(&self, p: DVec3) -> bool {
        self.sides(p).iter().all(|&side| side >= 0.0)
    }

    /// Voxel with these homogeneous coordinates: column, row and slice.
    pub(super) fn voxel(&self, p: DVec3) -> Option<[usize; 3]> {
        if !self.holds(p) {
            return None;
        }
        let texel = |along: f64| ((along / p.z) as usize).min(self.side - 1);
        let slice = ((p.z - f64::from(self.near)) * self.slices()) as usize;
        Some([texel(p.x), texel(p.y), slice.min(self.bits - 1)])
    }

    /// Eight corners of a voxel, world space.
    pub(super) fn corners(&self, [column, row, slice]: [usize; 3]) -> [Vec3; 8] {
        let middle = self.side as f32 * 0.5;
        std::array::from_fn(|corner| {
            let along = |axis: usize, at: usize| (at + (corner >> axis & 1)) as f32;
            let (x, y) = (along(0, column) - middle, along(1, row) - middle);
            let depth = self.near + along(2, slice) * (self.far - self.near) / self.bits as f32;
            self.eye + (self.centre + self.texel[0] * x - self.texel[1] * y) * depth
        })
    }

    /// Part of a segment that lies in the grid.
    pub(super) fn part(&self, from: Vec3, to: Vec3) -> Option<(Vec3, Vec3)> {
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for (first, second) in self.sides(self.place(from)).into_iter().zip(self.sides(self.place(to))) {
            let at = first / (first - second);
            match (first < 0.0, second < 0.0) {
                (true, true) => return None,
                (true, false) => enter = enter.max(at),
                (false, true) => leave = leave.min(at),
                (false, false) => {}
            }
        }
        (enter < leave).then(|| (from.lerp(to, enter as f32), from.lerp(to, leave as f32)))
    }

    /// Signed distances, each in its own unit, of homogeneous coordinates to the grid's six sides: negative
    /// outside.
    #[inline(always)]
    pub(super) fn sides(&self, p: DVec3) -> [f64; 6] {
        let widest = self.side as f64 * p.z;
        [p.z - f64::from(self.near), f64::from(self.far) - p.z, p.x, widest - p.x, p.y, widest - p.y]
    }

    /// Width of a voxel around `point` along a unit vector: no point of the voxel is farther than this from a
    /// plane with this normal that touches the voxel. Points in front of the grid or behind it are treated as
    /// on its border.
    pub fn width_along(&self, point: Vec3, normal: Vec3) -> f32 {
        let seen = point - self.eye;
        let depth = self.forward.dot(seen).max(self.near);
        let across = normal.dot(self.texel[0]).abs() + normal.dot(self.texel[1]).abs();
        let along = normal.dot(seen / depth).abs();
        across * depth.min(self.far) + along * (self.far - self.near) / self.bits as f32
    }
}

/// Depth range of the grid, or `None` where the image has no receiver.
///
/// The near end is the depth of the nearest receiver: geometry nearer and in view would itself be the nearest
/// receiver, unless it is so thin that it falls between pixel centres. The far end is the depth of the
/// farthest receiver or, where it is deeper, of the deepest corner of a light, since no shadow ray goes
/// farther; but never beyond the last triangle.
pub(super) fn depth_range(frame: &Frame) -> Option<(f32, f32)> {
    let depths = frame.gbuffer.depth.iter().filter(|depth| depth.is_finite());
    let (mut near, mut far) =
        depths.fold((f32::INFINITY, 0.0f32), |(near, far), &depth| (near.min(depth), far.max(depth)));
    if near > far {
        return None;
    }
    let camera = &frame.scene.camera;
    let forward = (camera.target - camera.eye).normalize_or(Vec3::NEG_Z);
    let deepest = |points: &[Vec3]| {
        points.iter().map(|&p| forward.dot(p - camera.eye)).fold(f32::NEG_INFINITY, f32::max)
    };
    let lights = frame.scene.lights.iter().map(|light| deepest(&light.corners()));
    let lights = lights.fold(f32::NEG_INFINITY, f32::max);
    if lights > far {
        far = far.max(lights.min(deepest(&frame.scene.mesh.positions)));
    }
    // Margin for rounding. A wall that faces the camera has no depth extent, and slices much thinner than a
    // unit in the last place of its depth could not be distinguished.
    far *= 1.0 + 1e-4;
    near = (near * (1.0 - 1e-4)).clamp(far * 1e-5, far * (1.0 - 1.0 / 64.0));
    (near < far && far.is_finite()).then_some((near, far))
}
