//! Placing a mesh in the world.

use glam::{DMat3, DVec3, EulerRot, Vec3};
use halflight_core::scene::Mesh;

/// Scale, then rotation, then translation, from mesh space to world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Transform {
    pub(crate) translate: Vec3,
    /// Degrees about x, then y, then z, counter-clockwise as seen from the tip of the axis.
    pub(crate) rotate_deg: Vec3,
    /// Factor along each axis of the mesh; not zero. A negative product mirrors.
    pub(crate) scale: Vec3,
}

impl Default for Transform {
    fn default() -> Self {
        Self { translate: Vec3::ZERO, rotate_deg: Vec3::ZERO, scale: Vec3::ONE }
    }
}

impl Transform {
    /// Rotation times scale, in double precision so that a far translation is rounded only once.
    fn linear(&self) -> DMat3 {
        let angles = self.rotate_deg.as_dvec3().map(f64::to_radians);
        // x first, z last: the matrix product reads from right to left.
        let rotation = DMat3::from_euler(EulerRot::ZYX, angles.z, angles.y, angles.x);
        rotation * DMat3::from_diagonal(self.scale.as_dvec3())
    }

    /// Moves `mesh` to world space. Normals go by the inverse transpose and stay unit (zero stays zero,
    /// "to be computed"); a mirrored mesh has its triangles turned, so that they face outwards as before.
    pub(crate) fn apply(&self, mesh: &mut Mesh) {
        if *self == Self::default() {
            return;
        }
        let linear = self.linear();
        let translate = self.translate.as_dvec3();
        for position in &mut mesh.positions {
            *position = (linear * position.as_dvec3() + translate).as_vec3();
        }
        let normal_matrix = linear.inverse().transpose();
        for normal in &mut mesh.normals {
            *normal = (normal_matrix * normal.as_dvec3()).try_normalize().unwrap_or(DVec3::ZERO).as_vec3();
        }
        if linear.determinant() < 0.0 {
            for triangle in &mut mesh.triangles {
                triangle.swap(1, 2);
            }
        }
    }
}
