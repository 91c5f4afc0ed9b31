//! Attacks on the certificates of beams that a group of receivers sees all of the light, or nothing.
//!
//! Each attack is a scene of a few triangles made to be missed (wires, specks, slivers, triangles that touch the hull of
//! group and light in one point, lie in its faces or nearly cover the light) and a group of receivers. All masks are
//! compared with brute force, those that were certified and those that were not.

mod cases;

use std::ops::AddAssign;
use std::sync::Arc;

use halflight_core::frame::{Frame, Sharing};
use halflight_core::gbuffer::GBuffer;
use halflight_core::mask::MaskBatch;
use halflight_core::pyramid::Pyramid;
use halflight_core::scene::Scene;
use halflight_core::stages::Visibility;
use halflight_cpu::beam::Beam;
use halflight_cpu::brute_force::BruteForce;
use halflight_cpu::bvh::{Bvh, BvhError};
use rayon::prelude::*;
use serde::Serialize;

use cases::Cases;

/// Number of attacks that are made at a time.
const ROUND: u32 = 256;

/// Outcome of attacks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Outcome {
    /// Groups that were asked about.
    pub groups: u64,
    /// Groups about which something was certified.
    pub certified: u64,
    /// Receivers that were certified to see all of the light.
    pub lit: u64,
    /// Receivers that were certified to see nothing of it.
    pub umbra: u64,
    /// Receivers about which something was certified, times the triangles of their scene.
    pub cases: u64,
    /// Pairs of a receiver and a light sample that were compared with brute force.
    pub pairs: u64,
    /// Pairs about which the backend was wrong.
    pub different: u64,
    /// Number of the first attack that broke a certificate.
    pub broken: Option<u32>,
}

impl Outcome {
    /// Columns of the table.
    pub const COLUMNS: [&str; 8] =
        ["groups", "certified", "lit", "umbra", "cases", "pairs", "different", "broken"];
}

impl AddAssign for Outcome {
    fn add_assign(&mut self, other: Self) {
        let Self { groups, certified, lit, umbra, cases, pairs, different, broken } = other;
        self.groups += groups;
        self.certified += certified;
        self.lit += lit;
        self.umbra += umbra;
        self.cases += cases;
        self.pairs += pairs;
        self.different += different;
        self.broken = self.broken.or(broken);
    }
}

/// Attacks beams until they have certified so many cases. `progress` is told how many more there are.
///
/// # Errors
/// A BVH cannot be built over a scene made here.
pub fn attack(cases: u64, seed: u32, progress: impl FnMut(u64)) -> Result<Outcome, BvhError> {
    attack_backend(cases, seed, &|bvh| Box::new(Beam::new(bvh)), progress)
}

/// Attacks another backend, whose statistics count its certificates, as [`attack`] does.
///
/// # Errors
/// A BVH cannot be built over a scene made here.
pub fn attack_backend(
    cases: u64,
    seed: u32,
    backend: &(dyn Fn(Arc<Bvh>) -> Box<dyn Visibility> + Sync),
    mut progress: impl FnMut(u64),
) -> Result<Outcome, BvhError> {
    let (source, mut all) = (Cases::new(seed), Outcome::default());
    let mut first = 0;
    // A backend that certifies nothing is given up on.
    while all.cases < cases && all.groups < 16 * u64::from(ROUND) + cases / 16 {
        let round: Result<Vec<_>, _> =
            (first..first + ROUND).into_par_iter().map(|index| one(&source, index, backend)).collect();
        let before = all.cases;
        round?.into_iter().for_each(|outcome| all += outcome);
        progress(all.cases - before);
        first += ROUND;
    }
    Ok(all)
}

fn one(
    source: &Cases,
    index: u32,
    backend: &dyn Fn(Arc<Bvh>) -> Box<dyn Visibility>,
) -> Result<Outcome, BvhError> {
    let (scene, mut batch) = source.case(index);
    let mut backend = backend(Arc::new(Bvh::build(&scene.mesh)?));
    let found = answer(backend.as_mut(), &scene, &mut batch);
    let truth = answer(&mut BruteForce, &scene, &mut batch);
    let wanted = batch.parts().wanted;
    let pairs = wanted.iter().map(|word| u64::from(word.count_ones())).sum();
    let differing = found.iter().zip(&truth).zip(wanted).map(|((a, b), wanted)| (a ^ b) & wanted);
    let different = differing.map(|word| u64::from(word.count_ones())).sum();
    let stats = backend.stats();
    let certified = stats.lit + stats.umbra;
    Ok(Outcome {
        groups: 1,
        certified: u64::from(certified > 0),
        lit: stats.lit,
        umbra: stats.umbra,
        cases: certified * scene.mesh.triangle_count() as u64,
        pairs,
        different,
        broken: (different > 0).then_some(index),
    })
}

fn answer(backend: &mut dyn Visibility, scene: &Scene, batch: &mut MaskBatch) -> Vec<u64> {
    let (gbuffer, pyramid, pattern) = (GBuffer::default(), Pyramid::default(), batch.pattern());
    let frame = Frame {
        scene,
        gbuffer: &gbuffer,
        pyramid: &pyramid,
        pattern,
        sharing: Sharing::Receiver,
        index: 0,
        seed: 0,
    };
    backend.prepare(&frame);
    backend.masks(&frame, batch);
    batch.parts().visible.to_vec()
}

#[cfg(test)]
mod tests {
    use halflight_core::stats::VisibilityStats;

    use super::*;

    #[test]
    fn beams_prove_nothing_that_is_wrong() {
        let outcome = attack(40_000, 7, |_| {}).unwrap();
        assert_eq!((outcome.different, outcome.broken), (0, None), "{outcome:?}");
        // Both certificates must be common, and neither everywhere, or the attacks are idle.
        assert!(outcome.lit > 1000 && outcome.umbra > 1000, "{outcome:?}");
        assert!(outcome.certified < outcome.groups * 3 / 4, "{outcome:?}");
        assert_eq!(attack(40_000, 7, |_| {}).unwrap(), outcome);
    }

    /// Says that everything is lit, and that it has certified so.
    struct Careless(VisibilityStats);

    impl Visibility for Careless {
        fn masks(&mut self, _: &Frame, batch: &mut MaskBatch) {
            self.0.lit += batch.len() as u64;
            let parts = batch.parts();
            parts.visible.copy_from_slice(parts.wanted);
        }

        fn stats(&self) -> VisibilityStats {
            self.0
        }
    }

    /// The truth about triangles that are smaller by a few units in the last place.
    struct Shrunk;

    impl Visibility for Shrunk {
        fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
            let mut scene = frame.scene.clone();
            for corners in Arc::make_mut(&mut scene.mesh).positions.chunks_mut(3) {
                let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
                corners.iter_mut().for_each(|corner| *corner += (middle - *corner) * 5e-7);
            }
            BruteForce.masks(&Frame { scene: &scene, ..*frame }, batch);
        }
    }

    #[test]
    fn wrong_proofs_are_noticed() {
        let outcome =
            attack_backend(1, 7, &|_| Box::new(Careless(VisibilityStats::default())), |_| {}).unwrap();
        assert!(outcome.different > outcome.pairs / 10 && outcome.broken.is_some(), "{outcome:?}");
        // Attacks aim well enough for that.
        let outcome = attack_backend(1, 7, &|_| Box::new(Shrunk), |_| {}).unwrap();
        assert!(outcome.different > 10 && outcome.different < outcome.pairs / 10, "{outcome:?}");
    }
}
