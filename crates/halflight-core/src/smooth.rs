//! Smooth surfaces that vertex normals imply: shading normals, and where shadow rays start so that facets do not cut the light off.

use glam::{DVec3, Vec3};

use crate::scene::Mesh;

/// Cosine between a vertex normal and the facet's above which they count as one: a thousandth of a radian.
const FLAT: f32 = 0.999_999_5;

/// Part of the distance to the planes of the vertex normals by which a point moves: a point in the middle of a circle's chord comes to
/// lie on the circle.
const RISE: f64 = 0.5;

/// Triangle with a shading normal at each corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothTriangle {
    /// Unit shading normals of the corners, world space, all on one side of the facet.
    pub normals: [Vec3; 3],
}

/// Returns true if any triangle of a mesh is smooth.
pub fn is_smooth(mesh: &Mesh) -> bool {
    let smooth = |triangle| {
        let [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
        let facet = (b - a).cross(c - a).normalize_or_zero().as_vec3();
        SmoothTriangle::new(mesh, triangle, facet).is_some()
    };
    !mesh.normals.is_empty() && (0..mesh.triangle_count()).any(smooth)
}

impl SmoothTriangle {
    /// Returns the smooth triangle that `mesh` has at index `triangle`, on the side of the facet's unit normal `facet`; `None` for a flat
    /// one.
    ///
    /// Normals of files may point to either side, so they are turned together to the side of `facet`. A triangle is flat if one of its
    /// vertices has no normal, or one that is not finite or still points away from the facet, and if all three are the facet's.
    pub fn new(mesh: &Mesh, triangle: usize, facet: Vec3) -> Option<Self> {
        if mesh.normals.is_empty() {
            return None;
        }
        let normals =
            mesh.triangles[triangle].map(|vertex| mesh.normals[vertex as usize].normalize_or_zero());
        let side = (normals[0] + normals[1] + normals[2]).dot(facet);
        let normals = if side < 0.0 { normals.map(|normal| -normal) } else { normals };
        let cosines = normals.map(|normal| normal.dot(facet));
        let smooth =
            cosines.iter().all(|&cosine| cosine > 0.0) && cosines.iter().any(|&cosine| cosine < FLAT);
        smooth.then_some(Self { normals })
    }

    /// Returns the triangle on the other side of its facet.
    #[must_use]
    pub fn reversed(self) -> Self {
        Self { normals: self.normals.map(|normal| -normal) }
    }

    /// Returns the point of the smooth surface above `point`, world space, and the unit shading normal there. `weights` are the
    /// barycentric weights of the corners.
    ///
    /// The point moves towards the planes through the corners across their normals, by half of its distance to each, weighted as the
    /// corners are; it never moves into the facet (Hanika 2021, "Hacking the Shadow Terminator", Ray Tracing Gems II, chapter 4, which takes the
    /// whole distance; half of it leads to the circle through the corners).
    pub fn surface(&self, corners: [Vec3; 3], weights: [f32; 3], point: DVec3) -> (DVec3, Vec3) {
        let (mut moved, mut shading) = (point, Vec3::ZERO);
        for ((corner, normal), weight) in corners.into_iter().zip(self.normals).zip(weights) {
            let below = (point - corner.as_dvec3()).dot(normal.as_dvec3()).min(0.0);
            moved -= normal.as_dvec3() * (RISE * f64::from(weight) * below);
            shading += normal * weight;
        }
        (moved, shading.normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];

    fn mesh(normals: &[Vec3]) -> Mesh {
        Mesh {
            positions: CORNERS.to_vec(),
            normals: normals.to_vec(),
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        }
    }

    #[test]
    fn only_usable_normals_make_a_triangle_smooth() {
        let facet = Vec3::ONE.normalize();
        let of = |normals: &[Vec3]| SmoothTriangle::new(&mesh(normals), 0, facet);
        let smooth = of(&CORNERS).expect("smooth");
        assert_eq!(smooth.normals, CORNERS);
        // The winding, and the side that is seen, do not matter.
        assert_eq!(of(&CORNERS.map(|normal| -normal)), Some(smooth));
        let behind = SmoothTriangle::new(&mesh(&CORNERS), 0, -facet);
        assert_eq!(behind, Some(smooth.reversed()));
        // Lengths do not matter.
        assert_eq!(of(&CORNERS.map(|normal| normal * 4.0)), Some(smooth));
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[facet; 3]), None);
        for bad in [Vec3::ZERO, Vec3::NAN, -facet, Vec3::new(1.0, -1.0, 0.0)] {
            assert_eq!(of(&[Vec3::X, Vec3::Y, bad]), None, "{bad}");
        }
    }

    #[test]
    fn points_move_to_the_sphere_through_the_corners() {
        let facet = Vec3::ONE.normalize();
        // A triangle of a sphere around the origin, narrow as tessellations are.
        let corners = CORNERS.map(|corner| (corner + 4.0 * facet).normalize());
        let smooth =
            SmoothTriangle::new(&Mesh { positions: corners.to_vec(), ..mesh(&corners) }, 0, facet).unwrap();
        for weights in [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.25, 0.25, 0.5], [0.2, 0.7, 0.1]] {
            let point: Vec3 = corners.into_iter().zip(weights).map(|(corner, weight)| corner * weight).sum();
            let (moved, shading) = smooth.surface(corners, weights, point.as_dvec3());
            let depth = 1.0 - point.as_dvec3().length();
            assert!(
                (moved.length() - 1.0).abs() <= 0.05 * depth + 1e-6,
                "{weights:?} {depth} {}",
                moved.length()
            );
            assert!(shading.abs_diff_eq(point.normalize(), 2e-3), "{weights:?}");
        }
    }

    #[test]
    fn hollows_do_not_move() {
        let facet = Vec3::ONE.normalize();
        let centre = Vec3::ONE;
        let normals = CORNERS.map(|corner| (centre * 2.0 - corner).normalize());
        let smooth = SmoothTriangle::new(&mesh(&normals), 0, facet).unwrap();
        let point = Vec3::splat(1.0 / 3.0).as_dvec3();
        assert_eq!(smooth.surface(CORNERS, [1.0 / 3.0; 3], point).0, point);
    }
}
