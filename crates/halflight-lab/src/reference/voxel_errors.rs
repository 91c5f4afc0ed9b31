//! Errors of voxel marching against ray tracing over a whole image, by cause (Nichols10 §4.3).

use std::sync::Arc;

use halflight_core::fragment::Fragments;
use halflight_core::frame::{Frame, LightSampling};
use halflight_core::gbuffer::GBuffer;
use halflight_core::mask::MaskBatch;
use halflight_core::pyramid::Pyramid;
use halflight_core::stages::{Refiner, Visibility};
use halflight_cpu::bvh::Bvh;
use halflight_cpu::pipeline::PipelineError;
use halflight_cpu::prepared::PreparedScene;
use halflight_cpu::rays::BvhRays;
use halflight_cpu::refine::PerPixel;
use halflight_cpu::voxel::error_map::{VoxelErrorCounts, segments, voxel_error_map};
use halflight_cpu::voxel::{VoxelConfig, Voxels};

use halflight_cpu::requests::Requests;

/// Difference of visible fractions from ray tracing's beyond which a receiver is off.
pub const OFF: f32 = 0.1;

/// Failures of voxel marching.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Failures {
    /// Receivers that are off, by cause, all lights together.
    pub counts: VoxelErrorCounts,
    /// Mean visible fraction that receivers lose, 0 … 1; those that lose nothing count as 0.
    pub false_shadow: f64,
    /// Mean visible fraction that receivers gain, 0 … 1.
    pub false_light: f64,
    /// Failure map of the last light, sRGB, row by row from the top left; see
    /// [`VoxelErrorMap::image`](halflight_cpu::voxel::error_map::VoxelErrorMap::image).
    pub image: Vec<[u8; 3]>,
}

impl Failures {
    /// Returns the share of the receivers that are off.
    pub fn off_share(&self) -> f64 {
        self.counts.failures() as f64 / self.counts.receivers.max(1) as f64
    }
}

/// Compares voxels with rays at each pixel of frame 0 and for each light, with equal light samples.
///
/// # Errors
/// The number of samples or a constant of the voxels is out of range.
pub fn failures(
    scene: &PreparedScene,
    gbuffer: &GBuffer,
    config: VoxelConfig,
    sampling: LightSampling,
    seed: u32,
) -> Result<Failures, PipelineError> {
    let (scene, bvh) = (scene.scene(), scene.bvh());
    let pyramid = Pyramid::default();
    let frame = Frame {
        scene,
        gbuffer,
        pyramid: &pyramid,
        pattern: sampling.pattern()?,
        sharing: sampling.sharing,
        index: 0,
        seed,
    };
    let (mut voxels, mut rays) = (Voxels::new(config)?, BvhRays::new(Arc::clone(bvh)));
    voxels.prepare(&frame);
    let mut found = Failures::default();
    let (mut darker, mut brighter) = (0.0, 0.0);
    for light in 0..scene.lights.len() as u32 {
        let (exact, approximate) =
            (answers(&frame, light, bvh, &mut rays), answers(&frame, light, bvh, &mut voxels));
        // `PerPixel` asks about all of the image in one batch.
        let (exact, approximate) = (exact.batch(0), approximate.batch(0));
        let map = voxel_error_map(&frame, &voxels, exact, approximate, OFF, &segments(bvh));
        add(&mut found.counts, &map.counts);
        found.image = map.image;
        for query in 0..exact.len() {
            let gained = fraction(approximate, query) - fraction(exact, query);
            darker += (-gained).max(0.0);
            brighter += gained.max(0.0);
        }
    }
    let receivers = found.counts.receivers.max(1) as f64;
    (found.false_shadow, found.false_light) = (darker / receivers, brighter / receivers);
    Ok(found)
}

/// Returns the masks of every pixel, in one batch.
fn answers(frame: &Frame, light: u32, bvh: &Bvh, visibility: &mut dyn Visibility) -> Fragments {
    let mut fragments = Fragments::default();
    fragments.reset(frame.gbuffer.width, frame.gbuffer.height, light);
    let mut culled = Requests::new(visibility, bvh);
    PerPixel::default().refine(frame, light, &mut culled, &mut fragments);
    fragments
}

/// Returns the share of the wanted samples that a receiver sees; 0 of none.
fn fraction(batch: &MaskBatch, query: usize) -> f64 {
    let (mut seen, mut wanted) = (0, 0);
    for (visible, want) in batch.visible(query).iter().zip(batch.wanted(query)) {
        seen += (visible & want).count_ones();
        wanted += want.count_ones();
    }
    f64::from(seen) / f64::from(wanted.max(1))
}

fn add(sum: &mut VoxelErrorCounts, more: &VoxelErrorCounts) {
    let VoxelErrorCounts { receivers, self_occlusion, thickness, out_of_view, missed } = more;
    sum.receivers += receivers;
    sum.self_occlusion += self_occlusion;
    sum.thickness += thickness;
    sum.out_of_view += out_of_view;
    sum.missed += missed;
}

#[cfg(test)]
mod tests {
    use halflight_core::pattern::PatternKind;
    use halflight_cpu::voxel::Traversal;

    use super::*;

    fn of(config: VoxelConfig, lights: usize) -> Failures {
        let mut scene = halflight_scene::resolve("contact").unwrap().scene;
        scene.lights = scene.lights.repeat(lights);
        let scene = PreparedScene::new(scene).unwrap();
        let seen = super::super::seen(&scene, [80, 60]);
        let sampling = LightSampling { count: 16, kind: PatternKind::Grid, ..LightSampling::default() };
        failures(&scene, &seen, config, sampling, 0).unwrap()
    }

    #[test]
    fn errors_are_split_by_sign() {
        // Not pushed off their surfaces, receivers shade themselves, which outweighs all else; pushed off by far, none
        // does, and many rise above the shadow.
        let every = VoxelConfig { traversal: Traversal::Dda, ..VoxelConfig::default() };
        let low = of(VoxelConfig { bias: 0.0, ..every }, 1);
        assert!(low.false_shadow > 10.0 * low.false_light && low.off_share() > 0.5, "{:?}", low.counts);
        let high = of(VoxelConfig { bias: 40.0, ..every }, 1);
        assert!(high.false_light > 10.0 * low.false_light, "{} after {}", high.false_light, low.false_light);
        assert!(high.counts.self_occlusion == 0 && high.counts.missed > 0, "{:?}", high.counts);
        assert_eq!(high.image.len(), 80 * 60);
    }

    #[test]
    fn lights_are_counted_together() {
        let (one, two) = (of(VoxelConfig::default(), 1), of(VoxelConfig::default(), 2));
        assert!(one.counts.failures() > 0);
        assert_eq!(two.counts.receivers, 2 * one.counts.receivers);
        // A grid of samples is the same for all lights.
        assert_eq!((two.false_shadow, two.off_share()), (one.false_shadow, one.off_share()));
    }
}
