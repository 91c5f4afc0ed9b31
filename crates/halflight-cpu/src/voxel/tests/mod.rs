//! Voxel marching on synthetic scenes.

mod answers;
mod failures;
mod grids;
mod rays;

use glam::Vec3;
use halflight_core::frame::{Frame, Sharing};
use halflight_core::gbuffer::GBuffer;
use halflight_core::hash;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::pyramid::Pyramid;
use halflight_core::scene::{Camera, Scene};
use halflight_core::stages::Visibility;

use super::*;
use crate::bvh::Bvh;
use crate::bvh::tests::meshes::{cuboid, lamp, scene};
use crate::rays::BvhRays;

/// Grid of the paper with exact traversal.
const EXACT: VoxelConfig =
    VoxelConfig { resolution: 128, depth_bits: 128, traversal: Traversal::Dda, thickness: 0, bias: 1.0 };

/// Reproducible pseudo-random numbers in 0 … 1.
struct Numbers {
    seed: u32,
    index: u32,
}

impl Numbers {
    fn new(seed: u32) -> Self {
        Self { seed, index: 0 }
    }

    fn next(&mut self) -> f32 {
        self.index += 1;
        hash::unit_pair(hash::sample_bits(self.seed, self.index)).0
    }

    /// Point in the cube from `-half` to `half`.
    fn point(&mut self, half: f32) -> Vec3 {
        (Vec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0) * half
    }
}

/// Scene with its image.
struct Stage {
    scene: Scene,
    bvh: std::sync::Arc<Bvh>,
    gbuffer: GBuffer,
    pyramid: Pyramid,
}

impl Stage {
    fn new(scene: Scene, width: u32, height: u32) -> Self {
        let bvh = std::sync::Arc::new(Bvh::build(&scene.mesh).unwrap());
        let mut gbuffer = GBuffer::default();
        crate::gbuffer::trace(&bvh, &scene, width, height, &mut gbuffer);
        Self { scene, bvh, gbuffer, pyramid: Pyramid::default() }
    }

    fn frame(&self) -> Frame<'_> {
        Frame {
            scene: &self.scene,
            gbuffer: &self.gbuffer,
            pyramid: &self.pyramid,
            pattern: Pattern::with_count(PatternKind::Jittered, 64).unwrap(),
            sharing: Sharing::Receiver,
            index: 0,
            seed: 0,
        }
    }

    fn prepared(&self, config: VoxelConfig) -> Voxels {
        let mut voxels = Voxels::new(config).unwrap();
        voxels.prepare(&self.frame());
        voxels
    }

    /// Batch of a query at every receiver that `asked` accepts, culled below the horizons, without masks.
    fn questions(&self, asked: impl Fn(Vec3) -> bool) -> MaskBatch {
        let frame = self.frame();
        let mut batch = MaskBatch::default();
        batch.reset(0, frame.pattern, Purpose::Final);
        for pixel in 0..self.gbuffer.pixels() {
            let Some(receiver) = self.gbuffer.receiver(pixel) else { continue };
            if asked(self.gbuffer.position[pixel]) {
                let pixel = pixel as u32;
                batch.push(receiver.origin, receiver.normal, pixel, frame.key(0, pixel, pixel), None);
            }
        }
        crate::horizon::cull(frame.light(0), &mut batch);
        batch
    }

    fn answered(&self, backend: &mut dyn Visibility, questions: &MaskBatch) -> MaskBatch {
        let mut batch = questions.clone();
        backend.masks(&self.frame(), &mut batch);
        batch
    }

    fn exact(&self, questions: &MaskBatch) -> MaskBatch {
        self.answered(&mut BvhRays::new(std::sync::Arc::clone(&self.bvh)), questions)
    }
}

/// Number of wanted samples that are visible, and of all wanted samples.
fn visible(batch: &MaskBatch) -> (u32, u32) {
    (0..batch.len()).fold((0, 0), |(visible, wanted), query| {
        let asked = batch.wanted(query)[0];
        (visible + (batch.visible(query)[0] & asked).count_ones(), wanted + asked.count_ones())
    })
}

/// Floor from -4 to 4 seen from above, a light over it, and blockers between them.
fn floor_with(blockers: &[(Vec3, Vec3)]) -> Scene {
    let mut corners = cuboid(Vec3::new(-4.0, -0.5, -4.0), Vec3::new(4.0, 0.0, 4.0));
    for &(low, high) in blockers {
        corners.extend(cuboid(low, high));
    }
    let camera = Camera {
        eye: Vec3::new(0.0, 3.0, 9.0),
        target: Vec3::new(0.0, 0.5, 0.0),
        up: Vec3::Y,
        fov_y_deg: 50.0,
        ..Camera::default()
    };
    Scene { camera, ..scene(&corners, lamp(Vec3::new(0.0, 2.5, 0.0), 0.5)) }
}
