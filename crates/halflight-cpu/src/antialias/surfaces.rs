//! Comparison of surface points that are about a pixel from each other.

use glam::Vec3;
use halflight_core::frame::Frame;
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};
use halflight_core::scene::Mesh;

use crate::tangent_plane::{DiscontinuityLimits, SurfacePoint, TangentPlanes};

/// Cosine between the shading normals of one surface's points: 8°. On either side of an edge that turns by less, the light differs by a seventh
/// of itself at most where it falls in at 45°, which is no stair that the eye follows.
const TURN: f32 = 0.99;

/// Difference of albedo, in any channel, above which two materials are seen to differ: half a step of an 8-bit picture at middle grey.
const COLOUR: f32 = 1.0 / 256.0;

/// Surface point as a pixel or a sub-sample sees it.
#[derive(Clone, Copy)]
pub(super) struct Seen {
    pub(super) triangle: u32,
    point: SurfacePoint,
    shading: Vec3,
    albedo: Vec3,
}

impl Seen {
    /// Reads an entry of a G-buffer.
    #[inline]
    pub(super) fn new(gbuffer: &GBuffer, entry: usize) -> Self {
        Self {
            triangle: gbuffer.primitive[entry],
            point: SurfacePoint::new(gbuffer, entry),
            shading: gbuffer.shading_normals()[entry],
            albedo: gbuffer.albedo[entry],
        }
    }
}

/// Comparison of surface points in one frame.
pub(super) struct Surfaces<'a> {
    planes: TangentPlanes<'a>,
    mesh: &'a Mesh,
}

impl<'a> Surfaces<'a> {
    pub(super) fn new(frame: &Frame<'a>) -> Self {
        let planes = TangentPlanes::new(frame, &DiscontinuityLimits::default());
        Self { planes, mesh: &frame.scene.mesh }
    }

    /// True if two points lie on one surface, over which a visible fraction may be carried: one triangle, or two without a surface
    /// discontinuity or an edge between them. Points of the background are of one surface.
    #[inline]
    pub(super) fn are_one(&self, a: &Seen, b: &Seen) -> bool {
        if a.triangle == b.triangle {
            return true;
        }
        let receivers = a.triangle != NO_PRIMITIVE && b.triangle != NO_PRIMITIVE;
        receivers && a.shading.dot(b.shading) >= TURN && !self.planes.parts(&a.point, &b.point)
    }

    /// True if no edge can be seen between two points: they lie on one surface, of one material or of two that look the same there.
    #[inline]
    pub(super) fn look_alike(&self, a: &Seen, b: &Seen) -> bool {
        a.triangle == b.triangle || self.are_one(a, b) && !self.colours_differ(a, b)
    }

    /// True if two points have different materials of different albedo. Textures alone make no edge.
    fn colours_differ(&self, a: &Seen, b: &Seen) -> bool {
        let material = |seen: &Seen| self.mesh.material_ids.get(seen.triangle as usize);
        material(a) != material(b) && (a.albedo - b.albedo).abs().max_element() > COLOUR
    }
}
