//! Cameras of scene files and of their animations.

use glam::Vec3;
use halflight_core::scene::Camera;

use crate::error::SceneError;
use crate::section::{Found, Section};

/// Reads a camera; missing values are those of `before`.
pub(crate) fn read_view(section: &mut Section<'_>, before: Option<&Camera>) -> Result<Camera, SceneError> {
    let line = section.line;
    let was = |value: fn(&Camera) -> Vec3| before.map(|camera| Found { value: value(camera), line });
    let eye = section.vector("eye")?.or_else(|| was(|camera| camera.eye));
    let eye = section.require("eye", "[0, 1, 5]", eye)?.value;
    let target = section.vector("target")?.or_else(|| was(|camera| camera.target));
    let target = section.require("target", "[0, 1, 0]", target)?;
    let up = section.vector("up")?.or_else(|| was(|camera| camera.up));
    let up = up.unwrap_or(Found { value: Vec3::Y, line });
    let fov = section.number("fov_y_deg")?;
    let fov = fov.or_else(|| before.map(|camera| Found { value: camera.fov_y_deg, line }));
    let fov = section.require("fov_y_deg", "45", fov)?;
    if fov.value <= 0.0 || fov.value >= 180.0 {
        let message = format!("fov_y_deg is {}, expected degrees above 0 and below 180", fov.value);
        return Err(section.fault(fov.line, message));
    }
    let view = (target.value.as_dvec3() - eye.as_dvec3()).normalize_or_zero();
    if view == glam::DVec3::ZERO {
        return Err(
            section.fault(target.line, "target is the same point as eye; expected a point to look at")
        );
    }
    // Sine of the angle to the view: below this limit, single precision does not define the up direction.
    let up_direction = up.value.as_dvec3().normalize_or_zero();
    if up_direction.cross(view).length() < 1e-4 {
        let message = "up is zero or along the line from eye to target; expected a direction across it";
        return Err(section.fault(up.line, message));
    }
    let camera =
        Camera { eye, target: target.value, up: up.value, fov_y_deg: fov.value, ..Camera::default() };
    Ok(camera)
}
