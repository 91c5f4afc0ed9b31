//! Shape of the lights: the one file here that reads their edges. Its twin in shaders is `shared/light.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use halflight_core::light::{AreaLight, Extent, LightFrame, Shape};
use halflight_cpu::voxel::{Frustum, turned};

use crate::frame::Frame;

/// Twin of `TurnedLight` in `shaders/visibility/voxel_space.wgsl`: a light in the coordinates of voxels.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct TurnedLight {
    pub(crate) corner: [f32; 4],
    pub(crate) u: [f32; 4],
    pub(crate) v: [f32; 4],
    pub(crate) normal: [f32; 4],
}

impl TurnedLight {
    /// Returns a light in the coordinates of a frustum.
    pub(crate) fn new(frustum: &Frustum, light: &AreaLight) -> Self {
        let LightFrame { origin, u, v } = turned(frustum, light).frame();
        let normal = frustum.turn(light.normal().as_dvec3()).as_vec3();
        let [corner, u, v, normal] = [origin, u, v, normal].map(|v| v.extend(0.0).to_array());
        Self { corner, u, v, normal }
    }
}

/// Outline of a sphere, whose places for corners hold those of a tetrahedron around it, then its centre and radius.
const SPHERE: u32 = 2;

impl Frame {
    /// Returns the uniform of one light.
    pub(crate) fn with_light(self, number: u32, light: &AreaLight) -> Self {
        let LightFrame { origin, u, v } = light.frame();
        let (mut outline, mut corners, mut sides) = (0, [[0.0; 4]; 12], [[0.0; 4]; 12]);
        match &light.shape {
            Shape::Parallelogram(_) => {}
            Shape::Ellipse(_) => outline = 1,
            Shape::Sphere(sphere) => {
                outline = SPHERE;
                for (place, corner) in corners.iter_mut().zip(light.corners()) {
                    *place = corner.extend(0.0).to_array();
                }
                corners[4] = sphere.centre.extend(sphere.radius).to_array();
            }
            Shape::Polygon(polygon) => {
                outline = polygon.corners().len() as u32;
                for (place, &corner) in corners.iter_mut().zip(polygon.corners()) {
                    // Differences in double precision: corners far from the origin lie close together.
                    let from = (corner.as_dvec3() - origin.as_dvec3()).as_vec3();
                    *place = from.extend(0.0).to_array();
                }
            }
        }
        if let Extent::Polygon(found) = light.extent() {
            for (place, side) in sides.iter_mut().zip(found.coefficients()) {
                *place = side.extend(0.0).to_array();
            }
        }
        Self {
            outline: [outline, 0, 0, 0],
            outline_corners: corners,
            outline_sides: sides,
            light_corner: origin.to_array(),
            light_area: light.frame_area(),
            light_u: u.to_array(),
            light_v: v.to_array(),
            light_cross: light.vector_area().to_array(),
            light_normal: light.normal().to_array(),
            two_sided: u32::from(light.two_sided),
            radiance: light.radiance.to_array(),
            mean_radiance: light.radiance.extend(0.0).to_array(),
            light: number,
            ..self
        }
    }
}

/// Returns the depth of the deepest point of any light along a direction, seen from `eye`.
pub(crate) fn deepest(lights: &[AreaLight], eye: Vec3, forward: Vec3) -> f32 {
    let corners = lights.iter().flat_map(AreaLight::corners);
    corners.map(|point| forward.dot(point - eye)).fold(f32::NEG_INFINITY, f32::max)
}

/// Returns the number of sides that lights shine to: 2 where any of them is two-sided.
pub(crate) fn sides(lights: &[AreaLight]) -> u32 {
    if lights.iter().any(|light| light.two_sided) { 2 } else { 1 }
}
