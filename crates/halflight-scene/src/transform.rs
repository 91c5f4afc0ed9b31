//! Transform of a mesh to world space.

use glam::{DMat3, DVec3, EulerRot};
use halflight_core::scene::Mesh;

use crate::model::ModelMesh;

/// Scale, then rotation, then translation, from model space to world space. Computed in double precision;
/// positions are rounded once, at the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Transform {
    pub(crate) translate: DVec3,
    /// Angles in degrees about x, then y, then z, counter-clockwise as seen from the tip of the axis.
    pub(crate) rotate_deg: DVec3,
    /// Factor along each axis of the mesh; not zero. A negative product mirrors.
    pub(crate) scale: DVec3,
}

impl Default for Transform {
    fn default() -> Self {
        Self { translate: DVec3::ZERO, rotate_deg: DVec3::ZERO, scale: DVec3::ONE }
    }
}

impl Transform {
    /// Rotation times scale.
    fn linear(&self) -> DMat3 {
        let angles = self.rotate_deg.map(f64::to_radians);
        // x first, z last: the matrix product reads from right to left.
        let rotation = DMat3::from_euler(EulerRot::ZYX, angles.z, angles.y, angles.x);
        rotation * DMat3::from_diagonal(self.scale)
    }

    /// Moves a mesh of a file to world space.
    pub(crate) fn place(&self, mesh: ModelMesh) -> Mesh {
        let linear = self.linear();
        let place = |&position: &DVec3| (linear * position + self.translate).as_vec3();
        let positions = if *self == Self::default() {
            mesh.positions.iter().map(|position| position.as_vec3()).collect()
        } else {
            mesh.positions.iter().map(place).collect()
        };
        let mut mesh = mesh.into_mesh(positions);
        self.turn(&mut mesh);
        mesh
    }

    /// Moves a mesh of single precision to world space.
    pub(crate) fn apply(&self, mesh: &mut Mesh) {
        if *self == Self::default() {
            return;
        }
        let linear = self.linear();
        for position in &mut mesh.positions {
            *position = (linear * position.as_dvec3() + self.translate).as_vec3();
        }
        self.turn(mesh);
    }

    /// Transforms normals by the inverse transpose, renormalised (zero stays zero, "to be computed"), and
    /// flips the triangles of a mirrored mesh, so that they still face outwards.
    fn turn(&self, mesh: &mut Mesh) {
        if *self == Self::default() {
            return;
        }
        let normal_matrix = self.linear().inverse().transpose();
        for normal in &mut mesh.normals {
            *normal = (normal_matrix * normal.as_dvec3()).try_normalize().unwrap_or(DVec3::ZERO).as_vec3();
        }
        if self.scale.is_negative_bitmask().count_ones() % 2 == 1 {
            for triangle in &mut mesh.triangles {
                triangle.swap(1, 2);
            }
        }
    }
}
