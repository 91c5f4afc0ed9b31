//! Pinhole cameras, and the primary rays that they send through an image.

use glam::{DVec3, Mat4, Vec2, Vec3};

use crate::limits::MAX_COORDINATE;

/// A pinhole camera in world space, metres.
///
/// Given by eye and target ([`Camera::default`] and the fields), or by the matrices of a renderer
/// ([`Camera::from_matrices`]), which may be off-centre or jittered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Eye point, world space.
    pub eye: Vec3,
    /// Point on the view axis, which meets the middle of the image where `shift` is zero.
    pub target: Vec3,
    /// Direction roughly up; need not be unit or orthogonal to the view.
    pub up: Vec3,
    /// Full vertical angle of view in degrees, 0 < fov < 180.
    pub fov_y_deg: f32,
    /// Width of the view divided by its height; that of the image where there is none, so that pixels are square.
    pub aspect: Option<f32>,
    /// Position of the image's middle relative to the view axis, in halves of the view's width (right) and height (up); zero for
    /// a centred view. A jitter by one pixel to the right is (2 / width, 0).
    pub shift: Vec2,
}

impl Default for Camera {
    fn default() -> Self {
        Self::look_at(Vec3::new(0.0, 1.0, 5.0), Vec3::ZERO, Vec3::Y, 45.0)
    }
}

/// Reasons why a camera cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CameraError {
    /// A value is NaN or infinite.
    #[error("the camera cannot be used: a value is not finite")]
    NotFinite,
    /// Single precision cannot work with distances so large.
    #[error(
        "the camera cannot be used: eye or target lies {MAX_COORDINATE:e} m or more from the origin: scale the scene down"
    )]
    TooFar,
    /// The camera has no direction.
    #[error("the camera cannot be used: eye and target are the same point")]
    NoDirection,
    /// The camera has no upward direction.
    #[error("the camera cannot be used: up is zero or points along the view")]
    NoUp,
    /// The angle of view is out of range.
    #[error("the camera cannot be used: fov_y_deg must lie between 0 and 180")]
    FieldOfView,
    /// The ratio of width and height is not positive.
    #[error("the camera cannot be used: aspect must be above 0")]
    Aspect,
    /// A view matrix does more than rotate and move.
    #[error(
        "the camera cannot be used: its view matrix must rotate and move only, without scale, shear or mirroring"
    )]
    NotRigid,
    /// A projection matrix is not a perspective.
    #[error(
        "the camera cannot be used: its projection matrix must be a perspective that looks along -z with x right and y up \
         (clip.w = -z)"
    )]
    NotPerspective,
}

impl Camera {
    /// Returns a centred camera at `eye` that looks at `target`, with square pixels.
    pub const fn look_at(eye: Vec3, target: Vec3, up: Vec3, fov_y_deg: f32) -> Self {
        Self { eye, target, up, fov_y_deg, aspect: None, shift: Vec2::ZERO }
    }

    /// Returns the camera of a renderer's matrices, both right-handed with the view along −z, x right and y up, as
    /// OpenGL, Direct3D and wgpu programs build them. Depth mapping (0 … 1, −1 … 1, reversed, infinite) does not matter.
    ///
    /// `world_from_view` is the camera's place in the world (the inverse of the view matrix), `clip_from_view` the projection.
    /// Sideways terms of the projection become [`Camera::shift`], its ratio of scales [`Camera::aspect`].
    ///
    /// # Errors
    /// `world_from_view` is not rigid, or `clip_from_view` not a perspective of that kind.
    pub fn from_matrices(world_from_view: Mat4, clip_from_view: Mat4) -> Result<Self, CameraError> {
        if !(world_from_view.is_finite() && clip_from_view.is_finite()) {
            return Err(CameraError::NotFinite);
        }
        let [right, up, back, eye] =
            [world_from_view.x_axis, world_from_view.y_axis, world_from_view.z_axis, world_from_view.w_axis];
        let axes = [right, up, back].map(|axis| axis.truncate().as_dvec3());
        let [right, up, back] = axes;
        let unit = |axis: DVec3| (axis.length() - 1.0).abs() < 1e-3;
        let across = |a: DVec3, b: DVec3| a.dot(b).abs() < 1e-3;
        let rigid = axes.into_iter().all(unit)
            && across(right, up)
            && across(up, back)
            && across(back, right)
            && right.cross(up).dot(back) > 0.0
            && world_from_view.row(3).abs_diff_eq(glam::Vec4::W, 1e-6);
        if !rigid {
            return Err(CameraError::NotRigid);
        }
        let [x, y, w] = [0, 1, 3].map(|row| clip_from_view.row(row));
        let perspective = w.abs_diff_eq(-glam::Vec4::Z, 1e-6)
            && x.x > 0.0
            && y.y > 0.0
            && x.y == 0.0
            && y.x == 0.0
            && x.w == 0.0
            && y.w == 0.0;
        if !perspective {
            return Err(CameraError::NotPerspective);
        }
        let eye = eye.truncate();
        // As far away as the eye from the origin, so that the direction keeps its precision when `target` is rounded.
        let reach = eye.abs().max_element().max(1.0);
        let camera = Self {
            eye,
            target: (eye.as_dvec3() - back * f64::from(reach)).as_vec3(),
            up: up.as_vec3(),
            fov_y_deg: (2.0 * (1.0 / f64::from(y.y)).atan().to_degrees()) as f32,
            aspect: Some(y.y / x.x),
            shift: Vec2::new(x.z, y.z),
        };
        camera.validate()?;
        Ok(camera)
    }

    /// Checks that the camera looks somewhere.
    ///
    /// # Errors
    /// The first fault found.
    pub fn validate(&self) -> Result<(), CameraError> {
        let view = self.target - self.eye;
        let finite = [self.eye, self.target, self.up].iter().all(|v| v.is_finite()) && self.shift.is_finite();
        if !finite {
            return Err(CameraError::NotFinite);
        }
        if self.eye.abs().max(self.target.abs()).max_element() >= MAX_COORDINATE {
            return Err(CameraError::TooFar);
        }
        if view.length_squared() == 0.0 {
            return Err(CameraError::NoDirection);
        }
        if view.normalize_or_zero().cross(self.up.normalize_or_zero()).length_squared() < 1e-12 {
            return Err(CameraError::NoUp);
        }
        if !(self.fov_y_deg > 0.0 && self.fov_y_deg < 180.0) {
            return Err(CameraError::FieldOfView);
        }
        match self.aspect {
            Some(aspect) if !(aspect > 0.0 && aspect.is_finite()) => Err(CameraError::Aspect),
            _ => Ok(()),
        }
    }
}

/// Primary rays of a camera through the pixels of an image, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Origin of the rays.
    pub eye: Vec3,
    /// Unit direction of view, along which depth is measured.
    pub forward: DVec3,
    /// Direction through the top left corner of the image, one unit along the view direction.
    pub corner: DVec3,
    /// One pixel to the right.
    pub right: DVec3,
    /// One pixel down.
    pub down: DVec3,
}

impl View {
    /// Returns the rays of a camera for an image of this size. A camera without a direction gets one.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let [eye, target, up] = [camera.eye, camera.target, camera.up].map(Vec3::as_dvec3);
        let forward = (target - eye).normalize_or(DVec3::NEG_Z);
        let right = forward.cross(up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = right.cross(forward);
        let half_height = (f64::from(camera.fov_y_deg).to_radians() * 0.5).tan();
        let half_width = match camera.aspect {
            Some(aspect) => half_height * f64::from(aspect),
            None => half_height * f64::from(width) / f64::from(height),
        };
        let shift = camera.shift.as_dvec2();
        Self {
            eye: camera.eye,
            forward,
            corner: forward - right * (half_width * (1.0 - shift.x)) + up * (half_height * (1.0 + shift.y)),
            right: right * (2.0 * half_width / f64::from(width)),
            down: up * (-2.0 * half_height / f64::from(height)),
        }
    }

    /// Returns the direction through a pixel's centre, one unit along the view direction.
    #[inline(always)]
    pub fn direction(&self, x: usize, y: usize) -> Vec3 {
        self.through(x as f64 + 0.5, y as f64 + 0.5)
    }

    /// Returns the direction through a point of the image, in pixels from its top left corner, one unit along the view direction.
    #[inline(always)]
    pub fn through(&self, x: f64, y: f64) -> Vec3 {
        (self.corner + self.right * x + self.down * y).as_vec3()
    }
}

#[cfg(test)]
mod tests {
    use glam::camera::rh::proj::{directx, opengl};
    use glam::camera::rh::view::look_at_mat4;

    use super::*;

    #[test]
    fn matrices_give_the_rays_of_the_same_camera() {
        let (width, height) = (320, 200);
        let camera = Camera {
            eye: Vec3::new(1200.0, 3.0, -40.0),
            target: Vec3::new(1201.0, 2.0, -44.0),
            fov_y_deg: 50.0,
            ..Camera::default()
        };
        let view = look_at_mat4(camera.eye, camera.target, camera.up);
        let aspect = width as f32 / height as f32;
        let fov = camera.fov_y_deg.to_radians();
        let projections = [
            directx::perspective(fov, aspect, 0.1, 100.0),
            opengl::perspective(fov, aspect, 0.1, 100.0),
            directx::perspective_infinite_reverse(fov, aspect, 0.1),
        ];
        for projection in projections {
            let found = Camera::from_matrices(view.inverse(), projection).unwrap();
            let (found, expected) = (View::new(&found, width, height), View::new(&camera, width, height));
            for (x, y) in [(0, 0), (319, 0), (17, 199), (160, 100)] {
                let (found, expected) = (found.direction(x, y), expected.direction(x, y));
                assert!(found.distance(expected) < 1e-4, "{found} {expected}");
            }
        }
    }

    #[test]
    fn jitter_and_windows_shift_the_rays() {
        let (width, height) = (64, 48);
        let mut projection = directx::perspective(1.0, 64.0 / 48.0, 0.1, 100.0);
        let plain = View::new(&Camera::from_matrices(Mat4::IDENTITY, projection).unwrap(), width, height);
        // A pixel to the right and one up, as a renderer writes it.
        (projection.z_axis.x, projection.z_axis.y) = (2.0 / 64.0, 2.0 / 48.0);
        let moved = View::new(&Camera::from_matrices(Mat4::IDENTITY, projection).unwrap(), width, height);
        assert!(moved.direction(10, 10).distance(plain.direction(11, 9)) < 1e-6);
        // The point at the middle of the image is the one that the projection puts there.
        let ahead = plain.forward + (moved.corner + moved.right * 32.0 + moved.down * 24.0 - plain.forward);
        let clip = projection * ahead.as_vec3().extend(1.0);
        assert!((clip.x / clip.w).abs() < 1e-6 && (clip.y / clip.w).abs() < 1e-6, "{clip}");
    }

    #[test]
    fn matrices_that_are_no_camera_are_refused() {
        let perspective = directx::perspective(1.0, 1.5, 0.1, 100.0);
        let of = |view, projection| Camera::from_matrices(view, projection).err();
        assert_eq!(of(Mat4::IDENTITY, perspective), None);
        assert_eq!(of(Mat4::from_scale(Vec3::splat(2.0)), perspective), Some(CameraError::NotRigid));
        assert_eq!(of(Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)), perspective), Some(CameraError::NotRigid));
        let flat = directx::orthographic(-1.0, 1.0, -1.0, 1.0, 0.1, 10.0);
        assert_eq!(of(Mat4::IDENTITY, flat), Some(CameraError::NotPerspective));
        let left = glam::camera::lh::proj::directx::perspective(1.0, 1.5, 0.1, 100.0);
        assert_eq!(of(Mat4::IDENTITY, left), Some(CameraError::NotPerspective));
        assert_eq!(of(Mat4::IDENTITY * f32::NAN, perspective), Some(CameraError::NotFinite));
        let far = Mat4::from_translation(Vec3::X * 2e8);
        assert_eq!(of(far, perspective), Some(CameraError::TooFar));
    }

    #[test]
    fn cameras_that_look_nowhere_are_refused() {
        let bad = [
            (Camera { target: Camera::default().eye, ..Camera::default() }, CameraError::NoDirection),
            (Camera { up: Vec3::ZERO, ..Camera::default() }, CameraError::NoUp),
            (Camera { fov_y_deg: 180.0, ..Camera::default() }, CameraError::FieldOfView),
            (Camera { aspect: Some(-1.0), ..Camera::default() }, CameraError::Aspect),
            (Camera { shift: Vec2::NAN, ..Camera::default() }, CameraError::NotFinite),
        ];
        for (camera, fault) in bad {
            assert_eq!(camera.validate(), Err(fault));
        }
    }
}
