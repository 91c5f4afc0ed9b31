//! Parts of cases: quads and boxes, a light and a camera.

use glam::{Vec2, Vec3};
use halflight_core::alpha::AlphaMask;
use halflight_core::light::AreaLight;
use halflight_core::light_texture::LightTexture;
use halflight_core::scene::{Camera, Material, Mesh, Scene};
use std::sync::Arc;

/// Scene of flat quads under one light, y up, metres. All depart from the easy one: a floor of
/// 20 × 20 m, a light of 1 × 1 m that shines down from 4 m, seen from 2 m above the floor.
#[derive(Clone, Debug)]
pub(super) struct Set(pub(super) Scene);

impl Set {
    /// Returns light and camera, and nothing to see.
    pub(super) fn bare() -> Self {
        Self(Scene {
            mesh: Arc::new(Mesh { materials: vec![Material::default()], ..Mesh::default() }),
            lights: vec![square_light(Vec3::new(0.0, 4.0, 0.0), 1.0)],
            camera: Camera {
                eye: Vec3::new(0.625, 2.0, 3.25),
                target: Vec3::new(0.0, 0.25, 0.0),
                up: Vec3::Y,
                fov_y_deg: 50.0,
                ..Camera::default()
            },
            ..Scene::default()
        })
    }

    /// Returns the open floor.
    pub(super) fn floor() -> Self {
        Self::bare().quad(Vec3::new(-10.0, 0.0, -10.0), Vec3::Z * 20.0, Vec3::X * 20.0)
    }

    /// Returns the floor with a box of 1.5 × 0.5 × 1.5 m a metre above it: umbra, penumbra and open floor. All coordinates are
    /// multiples of 1/128 m, so that they stay what they are 100 km from the origin.
    pub(super) fn blocker() -> Self {
        Self::floor().block(Vec3::new(-0.75, 1.0, -0.75), Vec3::new(0.75, 1.5, 0.75))
    }

    /// Adds the parallelogram at a corner; its normal is along `u × v`.
    pub(super) fn quad(mut self, corner: Vec3, u: Vec3, v: Vec3) -> Self {
        let mesh = Arc::make_mut(&mut self.0.mesh);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([corner, corner + u, corner + u + v, corner + v]);
        mesh.normals.extend([u.cross(v).normalize_or_zero(); 4]);
        mesh.uvs.extend([Vec2::ZERO; 4]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.material_ids.extend([0, 0]);
        self
    }

    /// Adds a box between two corners.
    pub(super) fn block(self, low: Vec3, high: Vec3) -> Self {
        let Vec3 { x, y, z } = high - low;
        let (x, y, z) = (Vec3::X * x, Vec3::Y * y, Vec3::Z * z);
        self.quad(low, x, z)
            .quad(low, z, y)
            .quad(low, y, x)
            .quad(high, -z, -x)
            .quad(high, -y, -z)
            .quad(high, -x, -y)
    }

    /// Replaces the light.
    pub(super) fn light(mut self, light: AreaLight) -> Self {
        self.0.lights = vec![light];
        self
    }

    /// Gives the light a texture.
    pub(super) fn textured(mut self, texture: LightTexture) -> Self {
        self.0.lights.iter_mut().for_each(|light| *light = light.textured(0));
        self.0.light_textures = vec![Arc::new(texture)];
        self
    }

    /// Gives the quad that was added last an alpha mask that covers it once.
    pub(super) fn masked(mut self, mask: AlphaMask) -> Self {
        let mesh = Arc::make_mut(&mut self.0.mesh);
        mesh.alpha_masks = vec![mask];
        mesh.materials.push(Material { alpha_mask: Some(0), ..Material::default() });
        let material = mesh.materials.len() as u32 - 1;
        mesh.material_ids.iter_mut().rev().take(2).for_each(|id| *id = material);
        let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        mesh.uvs.iter_mut().rev().zip(corners.into_iter().rev()).for_each(|(uv, corner)| *uv = corner);
        self
    }

    /// Turns the camera to look from one point to another.
    pub(super) fn seen(mut self, eye: Vec3, target: Vec3) -> Self {
        (self.0.camera.eye, self.0.camera.target) = (eye, target);
        self
    }

    /// Scales and moves the scene. Irradiance does not change.
    pub(super) fn placed(mut self, scale: f32, offset: Vec3) -> Self {
        let scene = &mut self.0;
        let placed = |point: Vec3| point * scale + offset;
        let place = |point: &mut Vec3| *point = placed(*point);
        Arc::make_mut(&mut scene.mesh).positions.iter_mut().for_each(place);
        for light in &mut scene.lights {
            *light = light.transformed(placed, |direction| direction * scale);
        }
        place(&mut scene.camera.eye);
        place(&mut scene.camera.target);
        self
    }
}

/// Returns a square light that shines down, centred at a point.
pub(super) fn square_light(centre: Vec3, side: f32) -> AreaLight {
    parallelogram(centre, Vec3::X * side, Vec3::Z * side)
}

/// Returns a light about a point that shines along `u × v`.
pub(super) fn parallelogram(centre: Vec3, u: Vec3, v: Vec3) -> AreaLight {
    AreaLight::parallelogram(centre - (u + v) * 0.5, u, v, Vec3::new(10.0, 9.0, 8.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_closed_and_turn_outwards() {
        let mesh = Set::bare().block(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0)).0.mesh;
        assert_eq!(mesh.triangle_count(), 12);
        let volume: f32 = (0..12)
            .map(|index| {
                let [a, b, c] = mesh.corners(index);
                a.cross(b).dot(c) / 6.0
            })
            .sum();
        // Divergence theorem; small integers are exact.
        assert_eq!(volume, 6.0);
    }

    #[test]
    fn the_light_shines_down() {
        assert_eq!(square_light(Vec3::Y, 2.0).normal(), -Vec3::Y);
    }
}
