//! Reference for exact backends: every wanted sample against every triangle, in exact arithmetic.

use glam::Vec3;
use halflight_core::frame::Frame;
use halflight_core::light::AreaLight;
use halflight_core::mask::MaskBatch;
use halflight_core::scene::Mesh;
use halflight_core::stages::{UnsupportedLight, Visibility};
use rayon::prelude::*;

use crate::occluder::{exact, is_solid};

/// Exact visibility without a BVH, a filter or a bounding box: tests every wanted sample against every
/// triangle by exact predicates (Shewchuk 1997), alpha-masked ones included. Far too slow for images.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BruteForce;

impl Visibility for BruteForce {
    fn supports_light(&self, _light: &AreaLight) -> Result<(), UnsupportedLight> {
        Ok(())
    }

    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        let (pattern, words) = (batch.pattern(), batch.words());
        if words == 0 {
            return;
        }
        let (light, mesh) = (*frame.light(batch.light()), &frame.scene.mesh);
        let parts = batch.parts();
        let slots = parts.wanted.par_chunks(words).zip(parts.visible.par_chunks_mut(words));
        parts.queries.par_iter().zip(slots).for_each(|(query, (wanted, visible))| {
            let light = light.seen_from(query.origin);
            for (word, (&wanted, visible)) in wanted.iter().zip(visible).enumerate() {
                *visible = 0;
                for bit in (0..64).filter(|bit| wanted >> bit & 1 != 0) {
                    let end = light.point(pattern.position(word * 64 + bit, query.key));
                    let mut triangles = 0..mesh.triangle_count();
                    let hidden = triangles.any(|triangle| hides(mesh, triangle, query.origin, end));
                    *visible |= u64::from(!hidden) << bit;
                }
            }
        });
    }
}

/// True if the open segment from `origin` to `end` meets a closed triangle of a mesh in a single point, which is solid by
/// the triangle's alpha mask where it has one. A triangle whose plane contains an end of the segment is not met.
pub fn hides(mesh: &Mesh, triangle: usize, origin: Vec3, end: Vec3) -> bool {
    let d = || end.as_dvec3() - origin.as_dvec3();
    exact::meets(origin, end, mesh.corners(triangle)) && is_solid(mesh, triangle as u32, origin, d())
}

#[cfg(test)]
mod tests {
    use halflight_core::pattern::{Pattern, PatternKind};

    use super::*;
    use crate::bvh::tests::meshes::{answer, ask, lamp, scene};

    #[test]
    fn half_a_light_behind_a_sheet() {
        // Seen from the origin, the sheet at half the light's height ends at the light's centre. No sample of
        // an even grid lies there.
        let sheet = [Vec3::new(0.0, 1.0, -9.0), Vec3::new(0.0, 1.0, 9.0), Vec3::new(9.0, 1.0, 0.0)];
        let scene = scene(&[sheet], lamp(Vec3::Y * 2.0, 1.0));
        let pattern = Pattern::with_count(PatternKind::Grid, 64).unwrap();
        let mut batch = ask(&[Vec3::ZERO, Vec3::NEG_X * 9.0], pattern, false);
        let found = answer(&mut BruteForce, &scene, &mut batch);
        assert_eq!(found, [0x0f0f_0f0f_0f0f_0f0f, u64::MAX]);
        // Bits that are not wanted stay 0.
        let mut batch = ask(&[Vec3::ZERO], pattern, true);
        let wanted = batch.wanted(0)[0];
        assert_eq!(answer(&mut BruteForce, &scene, &mut batch), [wanted & 0x0f0f_0f0f_0f0f_0f0f]);
        assert_eq!(batch.visible(0), [wanted & 0x0f0f_0f0f_0f0f_0f0f]);
    }
}
