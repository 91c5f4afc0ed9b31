//! Primary hits compared with brute force over all triangles in double precision.
//!
//! Each triangle is asked about every pixel whose centre may see it: those in the rectangle around its corners' projections,
//! or all of them where it reaches behind the eye. Nothing is shared with the renderer but the pixels' directions.

use glam::{DVec2, DVec3, Vec3, Vec3Swizzles as _};
use halflight_core::alpha::AlphaMask;
use halflight_core::camera::View;
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};
use halflight_core::scene::Scene;
use rayon::prelude::*;
use serde::Serialize;

/// Number of rows that a task compares.
const BAND: usize = 8;

/// Relative difference of depths below which they are ties: far more than the rounding of a G-buffer's depth, 2⁻²⁴.
const TIE: f64 = 1e-6;

/// Comparison of a G-buffer with brute force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PrimaryAgreement {
    /// Number of pixels that were compared.
    pub pixels: u64,
    /// Number of pixels where another triangle is certainly nearer, by more than a millionth of its distance, or where the triangle seen
    /// is certainly not on the pixel's ray.
    pub different: u64,
    /// Number of pixels whose ray passes so near an edge that double precision cannot tell on which side.
    pub open: u64,
}

/// Distance from the border of a texel, in texels, within which double precision may take its neighbour: weights of corners are
/// wrong by some 10⁻⁹ where rays graze a triangle, and textures repeat some hundred times at most.
const TEXEL: f64 = 1e-6;

/// Triangle and the pixels that may see it.
struct Candidate<'a> {
    index: u32,
    corners: [DVec3; 3],
    /// Alpha mask and texture coordinates of the corners.
    alpha: Option<(&'a AlphaMask, [DVec2; 3])>,
    /// First and last column and row.
    columns: [usize; 2],
    rows: [usize; 2],
}

/// Side on which a ray passes a triangle.
enum Passes {
    Outside,
    Inside(f64),
    /// Within rounding of an edge, of the eye or of a plane seen edge-on.
    Unknown,
}

/// Compares the triangle at each pixel's centre with brute force. `seen` must be the scene's own G-buffer.
pub fn check(scene: &Scene, seen: &GBuffer) -> PrimaryAgreement {
    let view = View::new(&scene.camera, seen.width, seen.height);
    let (width, height) = (seen.width as usize, seen.height as usize);
    let mesh = &scene.mesh;
    let candidate = |index: usize| {
        let uvs = mesh.triangles[index].map(|vertex| mesh.uvs[vertex as usize].as_dvec2());
        let alpha = mesh.alpha_mask(index).map(|mask| (mask, uvs));
        Candidate::new(mesh.corners(index), index as u32, alpha, &view, [width, height])
    };
    let candidates: Vec<Candidate> =
        (0..scene.mesh.triangle_count()).into_par_iter().filter_map(candidate).collect();
    let band = |top: usize| {
        let rows = [top, (top + BAND).min(height) - 1];
        compare_band(&candidates, seen, &view, rows, width)
    };
    let bands = (0..height).into_par_iter().step_by(BAND).map(band);
    bands.reduce(PrimaryAgreement::default, |a, b| PrimaryAgreement {
        pixels: a.pixels + b.pixels,
        different: a.different + b.different,
        open: a.open + b.open,
    })
}

impl<'a> Candidate<'a> {
    fn new(
        corners: [Vec3; 3],
        index: u32,
        alpha: Option<(&'a AlphaMask, [DVec2; 3])>,
        view: &View,
        size: [usize; 2],
    ) -> Option<Self> {
        let corners = corners.map(Vec3::as_dvec3);
        let [width, height] = size.map(|pixels| pixels as f64);
        let ahead = view.corner + view.right * (width * 0.5) + view.down * (height * 0.5);
        let seen = corners.map(|corner| corner - view.eye.as_dvec3());
        let depths = seen.map(|point| point.dot(ahead) / ahead.length_squared());
        let largest = seen.iter().fold(0.0, |most: f64, point| most.max(point.abs().max_element()));
        if depths.iter().all(|&depth| depth < -largest * 1e-9) {
            return None;
        }
        let all = Self { index, corners, alpha, columns: [0, size[0] - 1], rows: [0, size[1] - 1] };
        if depths.iter().any(|&depth| depth < largest * 1e-9) {
            return Some(all);
        }
        // A pixel more on each side than the corners' places.
        let range = |axis: DVec3, count: usize| {
            let place =
                |at: usize| (seen[at] / depths[at] - view.corner).dot(axis) / axis.length_squared() - 0.5;
            let places = [place(0), place(1), place(2)];
            let low = places.iter().copied().fold(f64::INFINITY, f64::min).floor() - 1.0;
            let high = places.iter().copied().fold(f64::NEG_INFINITY, f64::max).ceil() + 1.0;
            let inside = high >= 0.0 && low <= count as f64 - 1.0;
            inside.then(|| [low.max(0.0) as usize, high.min(count as f64 - 1.0) as usize])
        };
        Some(Self { columns: range(view.right, size[0])?, rows: range(view.down, size[1])?, ..all })
    }

    /// Returns where a ray from the eye passes the triangle, with twice the error that its products may have.
    fn passes(&self, eye: DVec3, d: DVec3) -> Passes {
        let [a, b, c] = self.corners.map(|corner| corner - eye);
        let size = |p: DVec3, q: DVec3| {
            let [p, q, d] = [p, q, d].map(DVec3::abs);
            d.x * (p.y * q.z + p.z * q.y) + d.y * (p.z * q.x + p.x * q.z) + d.z * (p.x * q.y + p.y * q.x)
        };
        let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| (d.dot(p.cross(q)), size(p, q) * 1e-14));
        if sides.iter().any(|&(side, error)| side > error) && sides.iter().any(|&(side, error)| side < -error)
        {
            return Passes::Outside;
        }
        let along: f64 = sides.iter().map(|&(side, _)| side).sum();
        let sure = sides.iter().all(|&(side, error)| side.abs() > error);
        let (u, v) = (self.corners[1] - self.corners[0], self.corners[2] - self.corners[0]);
        let normal = u.cross(v);
        let spread = (u.abs() * v.abs().yzx() + u.abs().yzx() * v.abs()).yzx();
        let (distance, error) = (normal.dot(a), spread.dot(a.abs()) * 1e-15);
        if !sure || distance.abs() < error * 1e8 || along.abs() < spread.dot(d.abs()) * 1e-7 {
            return Passes::Unknown;
        }
        let t = distance / normal.dot(d);
        if t <= 0.0 {
            return Passes::Outside;
        }
        let Some((mask, [first, second, third])) = self.alpha else { return Passes::Inside(t) };
        // A corner's weight is the side of the edge across from it.
        let weight = |side: usize| sides[side].0 / along;
        let uv = first * weight(1) + second * weight(2) + third * weight(0);
        let texels = uv * DVec2::new(f64::from(mask.width()), f64::from(mask.height()));
        if (texels - texels.round()).abs().min_element() < TEXEL {
            return Passes::Unknown;
        }
        if mask.is_solid(uv) { Passes::Inside(t) } else { Passes::Outside }
    }
}

fn compare_band(
    candidates: &[Candidate<'_>],
    seen: &GBuffer,
    view: &View,
    rows: [usize; 2],
    width: usize,
) -> PrimaryAgreement {
    let eye = view.eye.as_dvec3();
    let count = (rows[1] + 1 - rows[0]) * width;
    // Pixels where brute force contradicts, cannot tell, or meets the triangle that is seen.
    let (mut different, mut open, mut met) = (vec![false; count], vec![false; count], vec![false; count]);
    for candidate in candidates {
        for y in candidate.rows[0].max(rows[0])..=candidate.rows[1].min(rows[1]) {
            for x in candidate.columns[0]..=candidate.columns[1] {
                let (pixel, slot) = (y * width + x, (y - rows[0]) * width + x);
                let is_seen = seen.primitive[pixel] == candidate.index;
                let depth = f64::from(seen.depth[pixel]);
                match candidate.passes(eye, view.direction(x, y).as_dvec3()) {
                    Passes::Outside => {}
                    Passes::Inside(t) => {
                        met[slot] |= is_seen;
                        let off = if is_seen { (t - depth).abs() } else { depth - t };
                        different[slot] |= off > TIE * t;
                    }
                    Passes::Unknown => {
                        met[slot] |= is_seen;
                        open[slot] = true;
                    }
                }
            }
        }
    }
    let slots = || (0..count).map(|slot| (rows[0] * width + slot, slot));
    // The triangle that is seen must be on the ray.
    let wrong = |&(pixel, slot): &(usize, usize)| {
        different[slot] || seen.primitive[pixel] != NO_PRIMITIVE && !met[slot]
    };
    PrimaryAgreement {
        pixels: count as u64,
        different: slots().filter(wrong).count() as u64,
        open: open.iter().filter(|&&open| open).count() as u64,
    }
}
