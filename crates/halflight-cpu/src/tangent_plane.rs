//! Tangent-plane test: decides if one surface point lies above another's tangent plane.
//!
//! A point above another's tangent plane can shadow it at close range, or lies across a depth discontinuity
//! from it; a point below can do neither. A visible fraction may therefore be interpolated over convex
//! surfaces, however curved, and not over concave creases and depth discontinuities. Grooves along sharp
//! convex edges are finer than pixels; callers that must not miss them use [`TangentPlanes::turns`].

use glam::Vec3;
use halflight_core::frame::Frame;
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};
use serde::{Deserialize, Serialize};

use crate::multiversion::multiversion;

/// Number of pixel pairs that are tested together.
pub(crate) const RUN: usize = 16;

/// Limits on the elevation of either point above the other's tangent plane, beyond which nothing is
/// interpolated between them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DiscontinuityLimits {
    /// Elevation in degrees: 10. A concave crease of 20° is then a surface discontinuity from every
    /// direction, and one of 10° may be one. Flatter concavities have no contact shadow that interpolation
    /// could lose.
    pub crease_deg: f32,
    /// Height, in footprints of a pixel at the nearer one's depth, for pixels that are neighbours, and in
    /// proportion to the distance for others: 1. On a floor seen at a glancing angle, depth discontinuities
    /// have almost no elevation.
    pub step_px: f32,
}

impl Default for DiscontinuityLimits {
    fn default() -> Self {
        Self { crease_deg: 10.0, step_px: 1.0 }
    }
}

/// Point of a surface, with its tangent plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfacePoint {
    /// Start of its shadow rays, world space.
    pub(crate) position: Vec3,
    /// Geometric unit normal.
    pub(crate) normal: Vec3,
    /// Distance along the view direction, metres.
    pub(crate) depth: f32,
}

impl SurfacePoint {
    /// Point that an entry of a G-buffer sees; the entry must be a receiver.
    #[inline]
    pub(crate) fn new(gbuffer: &GBuffer, entry: usize) -> Self {
        let GBuffer { position, normal, depth, .. } = gbuffer;
        Self { position: position[entry], normal: normal[entry], depth: depth[entry] }
    }
}

/// Tangent-plane tests between pixels of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TangentPlanes<'a> {
    gbuffer: &'a GBuffer,
    sine: f32,
    footprint: f32,
}

impl<'a> TangentPlanes<'a> {
    pub(crate) fn new(frame: &Frame<'a>, limits: &DiscontinuityLimits) -> Self {
        let half_angle = frame.scene.camera.fov_y_deg.to_radians() * 0.5;
        Self {
            gbuffer: frame.gbuffer,
            sine: limits.crease_deg.to_radians().sin(),
            footprint: limits.step_px * 2.0 * half_angle.tan() / frame.gbuffer.height.max(1) as f32,
        }
    }

    /// True if the pixel sees geometry.
    #[inline]
    pub(crate) fn is_receiver(&self, pixel: usize) -> bool {
        self.gbuffer.is_receiver(pixel)
    }

    /// Triangle that all given pixels see, if it is one and the same, or all see nothing.
    #[inline]
    pub(crate) fn triangle(&self, pixels: &[usize]) -> Option<u32> {
        let first = self.gbuffer.primitive[pixels[0]];
        pixels.iter().all(|&pixel| self.gbuffer.primitive[pixel] == first).then_some(first)
    }

    /// True if there is a surface discontinuity between two pixels that are `apart` columns or rows from each
    /// other.
    #[inline]
    pub(crate) fn is_discontinuity(&self, a: usize, b: usize, apart: u32) -> bool {
        let primitive = &self.gbuffer.primitive;
        // Both pixels see one triangle, or both see nothing.
        primitive[a] != primitive[b] && self.compare(a, b, apart).is_none_or(Elevations::is_discontinuity)
    }

    /// True if two pixels lie on one plane or nearly so, by the tangent planes of both.
    #[inline]
    pub(crate) fn is_level(&self, a: usize, b: usize, apart: u32) -> bool {
        let primitive = &self.gbuffer.primitive;
        primitive[a] == primitive[b] || self.compare(a, b, apart).is_some_and(Elevations::is_level)
    }

    /// Elevations of two pixels on different triangles above each other's tangent planes; `None` where one of
    /// them sees nothing.
    #[inline]
    fn compare(&self, a: usize, b: usize, apart: u32) -> Option<Elevations> {
        if !self.gbuffer.is_receiver(a) || !self.gbuffer.is_receiver(b) {
            return None;
        }
        Some(self.elevations(&SurfacePoint::new(self.gbuffer, a), &SurfacePoint::new(self.gbuffer, b), apart))
    }

    /// Elevations of two surface points, `apart` pixels from each other, above each other's tangent planes.
    #[inline]
    fn elevations(&self, a: &SurfacePoint, b: &SurfacePoint, apart: u32) -> Elevations {
        let between = b.position - a.position;
        let (above_a, above_b) = (a.normal.dot(between), -b.normal.dot(between));
        let step = self.footprint * a.depth.min(b.depth) * apart as f32;
        let rounding = a.position.abs().max_element() * ROUNDING;
        let limit = (self.sine * between.length()).min(step) + rounding;
        Elevations { above_a, above_b, limit, step: step + rounding }
    }

    /// True if there is a surface discontinuity between two surface points that are about a pixel from each other.
    #[inline]
    pub(crate) fn parts(&self, a: &SurfacePoint, b: &SurfacePoint) -> bool {
        self.elevations(a, b, 1).is_discontinuity()
    }

    /// Pairs that may have a discontinuity, out of up to [`RUN`] pairs of neighbours (a, b), (a + 1, b + 1)
    /// and so on.
    #[inline]
    pub(crate) fn suspects(&self, a: usize, b: usize, count: usize, edge: f32) -> Suspects {
        match (Run::new(self.gbuffer, a), Run::new(self.gbuffer, b)) {
            (Some(a), Some(b)) if count >= RUN => suspects(self, a, b, edge),
            _ => Suspects { steps: 0, others: (1 << count) - 1 },
        }
    }

    /// Classifies two neighbours: by the discontinuity between them, and by the possibility that one shadows
    /// the other from a light nearby.
    ///
    /// Across a depth discontinuity of many pixels, neither side has information about the other. Elsewhere a
    /// surface shadows its neighbour only if some of the light is behind its plane, or if it occludes the
    /// light itself.
    #[inline]
    pub(crate) fn between(&self, light: &LightCorners, a: usize, b: usize) -> Between {
        let primitive = &self.gbuffer.primitive;
        if primitive[a] == primitive[b] {
            return Between::Nothing;
        }
        let Some(elevations) = self.compare(a, b, 1) else { return Between::Step };
        if !elevations.is_discontinuity() {
            return Between::Nothing;
        }
        if elevations.above_a.max(elevations.above_b) > FAR_STEP_PX * elevations.step {
            return Between::Step;
        }
        match (self.side(light, a), self.side(light, b)) {
            (Side::Unlit, Side::Unlit) => Between::Step,
            // Two sides of a crease that both have all of the light in front of them.
            (Side::Lit, Side::Lit) if elevations.above_a > 0.0 && elevations.above_b > 0.0 => Between::Step,
            (Side::Lit, Side::Lit) if !self.hides(light, a, b) && !self.hides(light, b, a) => Between::Step,
            _ => Between::Shade,
        }
    }

    /// True if the normals of two pixels on different triangles have a cosine below `edge`.
    #[inline]
    pub(crate) fn turns(&self, a: usize, b: usize, edge: f32) -> bool {
        let GBuffer { primitive, normal, .. } = self.gbuffer;
        primitive[a] != primitive[b] && normal[a].dot(normal[b]) < edge
    }

    /// Side of a pixel's horizon, by its shading normal, on which the light lies.
    #[inline]
    pub(crate) fn side(&self, light: &LightCorners, pixel: usize) -> Side {
        let (position, normal) = (self.gbuffer.position[pixel], self.gbuffer.shading_normals()[pixel]);
        // All corners are compared, since any of them may be decisive.
        let (mut lit, mut unlit) = (true, true);
        for corner in light.0 {
            let height = normal.dot(corner - position);
            lit &= height > 0.0;
            unlit &= height <= 0.0;
        }
        if lit {
            Side::Lit
        } else if unlit {
            Side::Unlit
        } else {
            Side::Both
        }
    }

    /// True if the surface at `other`, seen from `pixel`, is higher than some of the light in that direction.
    #[inline]
    fn hides(&self, light: &LightCorners, pixel: usize, other: usize) -> bool {
        let GBuffer { position, normal, .. } = self.gbuffer;
        let (from, up) = (position[pixel], normal[pixel]);
        let there = position[other] - from;
        let height = up.dot(there);
        let along = there - up * height;
        let nearest = along.length_squared() * NEAREST;
        let mut hides = false;
        for corner in light.0 {
            let to = corner - from;
            let forth = along.dot(to);
            // Slopes: height over |along|, and up·to over forth/|along|.
            hides |= (height > 0.0) & (forth > 0.0) & (height * forth >= up.dot(to) * nearest);
        }
        hides
    }
}

/// Masks of pairs of neighbours, lowest bit first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Suspects {
    /// Pairs for which [`TangentPlanes::between`] returns a depth discontinuity.
    pub(crate) steps: u32,
    /// Pairs that need [`TangentPlanes::between`] and [`TangentPlanes::turns`]; all other pairs have no
    /// discontinuity.
    pub(crate) others: u32,
}

multiversion! {
    /// Tests [`RUN`] pairs.
    fn suspects(planes: &TangentPlanes, a: Run, b: Run, edge: f32) -> Suspects {
        let mut differ = 0;
        for lane in 0..RUN {
            differ |= a.seen[lane] ^ b.seen[lane];
        }
        // Most runs lie on one triangle.
        if differ == 0 {
            return Suspects::default();
        }
        let (from, to, up_a, up_b) = (components(a.position), components(b.position), components(a.normal), components(b.normal));
        let (mut steps, mut others) = ([0u32; RUN], [0u32; RUN]);
        for lane in 0..RUN {
            let (x, y, z) = (to[0][lane] - from[0][lane], to[1][lane] - from[1][lane], to[2][lane] - from[2][lane]);
            let above_a = up_a[0][lane] * x + up_a[1][lane] * y + up_a[2][lane] * z;
            let above_b = -(up_b[0][lane] * x + up_b[1][lane] * y + up_b[2][lane] * z);
            let largest = from[0][lane].abs().max(from[1][lane].abs()).max(from[2][lane].abs());
            let rounding = largest * ROUNDING;
            let step = planes.footprint * a.depth[lane].min(b.depth[lane]);
            let limit = (planes.sine * (x * x + y * y + z * z).sqrt()).min(step) + rounding;
            let turn = up_a[0][lane] * up_b[0][lane] + up_a[1][lane] * up_b[1][lane] + up_a[2][lane] * up_b[2][lane];
            let (one, other) = (a.seen[lane], b.seen[lane]);
            let blind = (one == NO_PRIMITIVE) | (other == NO_PRIMITIVE);
            let far = above_a.max(above_b) > FAR_STEP_PX * (step + rounding);
            let within = (above_a <= limit) & (above_b <= limit);
            let step = (one != other) & (blind | far & !within);
            steps[lane] = u32::from(step) << lane;
            others[lane] = u32::from((one != other) & !step & (!within | (turn < edge))) << lane;
        }
        let mut all = Suspects::default();
        for lane in 0..RUN {
            all.steps |= steps[lane];
            all.others |= others[lane];
        }
        all
    }
}

/// Consecutive pixels of a row.
#[derive(Clone, Copy)]
struct Run<'a> {
    position: &'a [Vec3; RUN],
    normal: &'a [Vec3; RUN],
    depth: &'a [f32; RUN],
    /// Triangles that the pixels see.
    seen: &'a [u32; RUN],
}

impl<'a> Run<'a> {
    /// Run from `first` on; `None` where too few pixels are left.
    #[inline]
    fn new(gbuffer: &'a GBuffer, first: usize) -> Option<Self> {
        let GBuffer { position, normal, depth, primitive, .. } = gbuffer;
        Some(Self {
            position: position.get(first..)?.first_chunk()?,
            normal: normal.get(first..)?.first_chunk()?,
            depth: depth.get(first..)?.first_chunk()?,
            seen: primitive.get(first..)?.first_chunk()?,
        })
    }
}

/// Coordinates of vectors, one array per axis.
#[inline(always)]
fn components(vectors: &[Vec3; RUN]) -> [[f32; RUN]; 3] {
    let mut planes = [[0.0; RUN]; 3];
    for lane in 0..RUN {
        planes[0][lane] = vectors[lane].x;
        planes[1][lane] = vectors[lane].y;
        planes[2][lane] = vectors[lane].z;
    }
    planes
}

/// Rounding error of positions, relative to the largest coordinate: far from the origin, single precision is
/// coarser than a pixel.
const ROUNDING: f32 = 8.0 * f32::EPSILON;

/// Assumed position of an occluder between two neighbouring pixels, as a fraction of their distance: it may
/// begin anywhere between them.
const NEAREST: f32 = 0.05;

/// Height in pixels above which a depth discontinuity separates unrelated surfaces: the shadow of the nearer
/// one falls elsewhere. Lower ones may be ledges; with 8 pixels, a hall had a quarter more error.
const FAR_STEP_PX: f32 = 32.0;

/// Corners of the light for which shadows are tested.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightCorners(pub(crate) [Vec3; 4]);

/// Relation of two neighbouring pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Between {
    /// One surface.
    Nothing,
    /// Two surfaces, or one and the background, that do not shadow each other there.
    Step,
    /// Two surfaces that may shadow each other where they meet.
    Shade,
}

/// Position of the light relative to a tangent plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// In front.
    Lit,
    /// Behind.
    Unlit,
    /// On both sides.
    Both,
}

/// Heights above each other's tangent planes, metres.
#[derive(Clone, Copy)]
struct Elevations {
    above_a: f32,
    above_b: f32,
    /// Height above which there is a surface discontinuity.
    limit: f32,
    /// Footprint of a pixel.
    step: f32,
}

impl Elevations {
    #[inline]
    fn is_discontinuity(self) -> bool {
        // NaN counts as a discontinuity.
        self.above_a > self.limit || self.above_b > self.limit || (self.above_a + self.above_b).is_nan()
    }

    #[inline]
    fn is_level(self) -> bool {
        self.above_a.abs() <= self.limit && self.above_b.abs() <= self.limit
    }
}

#[cfg(test)]
mod tests {
    use halflight_core::frame::Sharing;
    use halflight_core::hash;
    use halflight_core::pattern::{Pattern, PatternKind};
    use halflight_core::pyramid::Pyramid;
    use halflight_core::scene::Scene;

    use super::*;

    /// True if two neighbouring pixels are separated by a discontinuity: a point of a floor, and one a
    /// pixel's footprint to its right and `up` footprints above it, whose normal leans to the right by `lean`
    /// degrees.
    fn parted(up: f32, lean: f32, edit: impl Fn(&mut GBuffer)) -> bool {
        compared(up, lean, edit, |planes| {
            assert_eq!(planes.is_discontinuity(0, 1, 1), planes.is_discontinuity(1, 0, 1));
            planes.is_discontinuity(0, 1, 1)
        })
    }

    /// Result of a test for these two pixels.
    fn compared<T>(
        up: f32,
        lean: f32,
        edit: impl Fn(&mut GBuffer),
        ask: impl FnOnce(&TangentPlanes) -> T,
    ) -> T {
        let scene = Scene::default();
        let footprint = 2.0 * (scene.camera.fov_y_deg.to_radians() * 0.5).tan();
        let mut gbuffer = GBuffer::default();
        gbuffer.reset(2, 1);
        gbuffer.depth.fill(1.0);
        gbuffer.primitive.copy_from_slice(&[0, 1]);
        gbuffer.position[1] = Vec3::new(1.0, up, 0.0) * footprint;
        let lean = lean.to_radians();
        gbuffer.normal.copy_from_slice(&[Vec3::Y, Vec3::new(lean.sin(), lean.cos(), 0.0)]);
        edit(&mut gbuffer);
        let frame = Frame {
            scene: &scene,
            gbuffer: &gbuffer,
            pyramid: &Pyramid::default(),
            pattern: Pattern { kind: PatternKind::Grid, columns: 1, rows: 1 },
            sharing: Sharing::Frame,
            index: 0,
            seed: 0,
        };
        ask(&TangentPlanes::new(&frame, &DiscontinuityLimits::default()))
    }

    #[test]
    fn convex_surfaces_are_one_and_creases_and_steps_part() {
        let as_is = |_: &mut GBuffer| {};
        assert!(!parted(0.0, 0.0, as_is));
        // Front edge of a table, and a sphere.
        assert!(!parted(-1.0, 80.0, as_is));
        assert!(!parted(-0.1, 12.0, as_is));
        // Wall on the floor, and a slight concavity.
        assert!(parted(1.0, -80.0, as_is));
        assert!(!parted(0.05, -6.0, as_is));
        // Depth discontinuities upwards and downwards, and one too low to matter.
        assert!(parted(2.0, 0.0, as_is) && parted(-2.0, 0.0, as_is));
        assert!(!parted(0.1, 0.0, as_is));
        // At a glancing angle a depth discontinuity has a height but no elevation.
        let glancing = |up: f32| parted(up, 0.0, |gbuffer| gbuffer.position[1].x *= 30.0);
        assert!(glancing(1.5) && !glancing(0.5));
    }

    #[test]
    fn edges_turn_by_their_angle() {
        let turns =
            |lean: f32| compared(-1.0, lean, |_| {}, |planes| planes.turns(0, 1, 40f32.to_radians().cos()));
        assert!(turns(41.0) && !turns(39.0) && !turns(0.0));
        // Within a triangle, normals are those of a smooth surface.
        let smooth = |gbuffer: &mut GBuffer| gbuffer.primitive.fill(7);
        assert!(!compared(-1.0, 80.0, smooth, |planes| planes.turns(0, 1, 0.8)));
    }

    #[test]
    fn runs_are_looked_at_like_pairs() {
        let number = |seed: u32, at: usize| hash::unit_pair(hash::mix(seed ^ hash::mix(at as u32))).0;
        let (mut steps, mut others, mut nothing) = (0, 0, 0);
        for seed in 0..400 {
            let fill = |gbuffer: &mut GBuffer| {
                gbuffer.reset(RUN as u32, 2);
                for at in 0..2 * RUN {
                    let turn: f32 = 0.6 * (number(seed, 8 * at) - 0.5);
                    gbuffer.normal[at] = Vec3::new(turn.sin(), turn.cos(), 0.0);
                    let up = 0.03 * (number(seed, 8 * at + 1) - 0.5).powi(5);
                    gbuffer.position[at] =
                        Vec3::new(0.002 * (at % RUN) as f32, up, 0.002 * (at / RUN) as f32);
                    gbuffer.depth[at] = 1.0 + number(seed, 8 * at + 2);
                    gbuffer.primitive[at] = (3.0 * number(seed, 8 * at + 3)) as u32;
                    match (20.0 * number(seed, 8 * at + 4)) as u32 {
                        0 => gbuffer.primitive[at] = NO_PRIMITIVE,
                        1 => gbuffer.position[at].y = f32::NAN,
                        2 => gbuffer.normal[at] = -gbuffer.normal[at],
                        3 => gbuffer.position[at].y = 1.0,
                        _ => {}
                    }
                }
            };
            let light =
                LightCorners([Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::Z].map(|side| side + 2.0 * Vec3::Y));
            let edge = [-2.0, 0.98][seed as usize % 2];
            compared(0.0, 0.0, fill, |planes| {
                let all = planes.suspects(0, RUN, RUN, edge);
                assert_eq!(all.steps & all.others, 0);
                for lane in 0..RUN {
                    let (a, b) = (lane, RUN + lane);
                    let found = (planes.between(&light, a, b), planes.turns(a, b, edge));
                    if all.steps >> lane & 1 != 0 {
                        steps += 1;
                        assert_eq!(found.0, Between::Step);
                    } else if all.others >> lane & 1 != 0 {
                        others += 1;
                        assert_ne!(found, (Between::Nothing, false));
                    } else {
                        nothing += 1;
                        assert_eq!(found, (Between::Nothing, false));
                    }
                }
                // Runs shorter than [`RUN`] need all tests, and so do those at the end of the image.
                assert_eq!(planes.suspects(0, RUN, 3, edge), Suspects { steps: 0, others: 7 });
                assert_eq!(planes.suspects(RUN + 1, RUN + 2, RUN - 1, edge).others, (1 << (RUN - 1)) - 1);
            });
        }
        assert!(steps > 500 && others > 500 && nothing > 500, "{steps} {others} {nothing}");
    }

    #[test]
    fn triangles_are_one_and_nothing_is_apart() {
        assert!(!parted(2.0, 0.0, |gbuffer| gbuffer.primitive.fill(7)));
        assert!(!parted(2.0, 0.0, |gbuffer| gbuffer.primitive.fill(NO_PRIMITIVE)));
        assert!(parted(0.0, 0.0, |gbuffer| gbuffer.primitive[1] = NO_PRIMITIVE));
        assert!(parted(0.0, 0.0, |gbuffer| gbuffer.normal[0] = Vec3::NAN));
    }
}
