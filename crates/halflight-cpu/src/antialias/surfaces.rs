//! Comparison of surface points that are about a pixel from each other.

use glam::Vec3;
use halflight_core::frame::Frame;
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};
use halflight_core::scene::Mesh;
use halflight_core::specular::SurfaceSpecular;

use crate::tangent_plane::{DiscontinuityLimits, SurfacePoint, TangentPlanes};

/// Cosine between the normals of one surface's points, where one of them lies on a flat triangle: 8°. On either side of an edge that turns by
/// less, light that falls in at 45° differs by a seventh of itself at most.
const TURN: f32 = 0.99;

/// Cosine between the shading normals of one surface's points where both lie on smooth triangles: 30°. The light of a smooth surface has no
/// steps, however much it bends within a pixel; creases between smooth parts turn by more.
const BEND: f32 = 0.866;

/// Difference of albedo, in any channel, above which two materials are seen to differ: half a step of an 8-bit picture at middle grey.
const COLOUR: f32 = 1.0 / 256.0;

/// Surface point that a pixel or a sub-sample sees: an entry of a G-buffer.
#[derive(Clone, Copy)]
pub(super) struct Seen<'a> {
    pub(super) gbuffer: &'a GBuffer,
    pub(super) entry: usize,
}

impl Seen<'_> {
    /// Triangle, or [`NO_PRIMITIVE`].
    #[inline]
    pub(super) fn triangle(self) -> u32 {
        self.gbuffer.primitive[self.entry]
    }

    /// Start of shadow rays and shading normal.
    #[inline]
    pub(super) fn receiver(self) -> (Vec3, Vec3) {
        (self.gbuffer.position[self.entry], self.gbuffer.shading_normals()[self.entry])
    }

    /// True if the shading normal is not that of the facet.
    #[inline]
    fn is_smooth(self) -> bool {
        !self.gbuffer.shading.is_empty()
            && self.gbuffer.shading[self.entry] != self.gbuffer.normal[self.entry]
    }

    #[inline]
    fn point(self) -> SurfacePoint {
        SurfacePoint::new(self.gbuffer, self.entry)
    }

    /// Specular reflection; none in scenes without glossy surfaces.
    #[inline]
    fn specular(self) -> Option<SurfaceSpecular> {
        self.gbuffer.specular.get(self.entry).copied()
    }

    #[inline]
    pub(super) fn albedo(self) -> Vec3 {
        self.gbuffer.albedo[self.entry]
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
    pub(super) fn are_one(&self, a: Seen, b: Seen) -> bool {
        if a.triangle() == b.triangle() {
            return true;
        }
        let receivers = a.triangle() != NO_PRIMITIVE && b.triangle() != NO_PRIMITIVE;
        receivers && !Self::turns(a, b) && !self.planes.parts(&a.point(), &b.point())
    }

    /// True if there is an edge between two points.
    #[inline]
    fn turns(a: Seen, b: Seen) -> bool {
        let (normals, smooth) = ([a, b].map(|seen| seen.receiver().1), [a, b].map(Seen::is_smooth));
        normals[0].dot(normals[1]) < if smooth == [true; 2] { BEND } else { TURN }
    }

    /// True if no edge can be seen between two points: they lie on one surface, of one material or of two that look the same there.
    #[inline]
    pub(super) fn look_alike(&self, a: Seen, b: Seen) -> bool {
        a.triangle() == b.triangle() || self.are_one(a, b) && !self.colours_differ(a, b)
    }

    /// True if two points have different materials of different albedo. Textures alone make no edge.
    fn colours_differ(&self, a: Seen, b: Seen) -> bool {
        let material = |seen: Seen| self.mesh.material_ids.get(seen.triangle() as usize);
        let colours = (a.albedo() - b.albedo()).abs().max_element() > COLOUR;
        material(a) != material(b) && (colours || a.specular() != b.specular())
    }
}
