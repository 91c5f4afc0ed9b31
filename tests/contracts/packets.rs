//! Packets give the masks of rays traced one by one, on the bundled scenes, for any subset of wanted samples.

use halflight::frame::Frame;
use halflight::glam::Vec3;
use halflight::hash;
use halflight::mask::{MaskBatch, Purpose};
use halflight::pattern::{Pattern, PatternKind};
use halflight::pyramid::Pyramid;
use halflight::rays::BvhRays;
use halflight::refine::PerPixel;
use halflight::stages::Visibility;
use halflight_tests::Stage;

/// Number of differing wanted bits, and of all wanted bits, of a batch answered by two backends.
fn differences(
    frame: &Frame,
    batch: &mut MaskBatch,
    a: &mut dyn Visibility,
    b: &mut dyn Visibility,
) -> (u64, u64) {
    a.masks(frame, batch);
    let first: Vec<u64> = (0..batch.len()).flat_map(|query| batch.visible(query).to_vec()).collect();
    let wanted: Vec<u64> = (0..batch.len()).flat_map(|query| batch.wanted(query).to_vec()).collect();
    b.masks(frame, batch);
    let second = (0..batch.len()).flat_map(|query| batch.visible(query).to_vec());
    let (mut different, mut total) = (0, 0);
    for ((a, b), wanted) in first.iter().zip(second).zip(&wanted) {
        different += u64::from(((a ^ b) & wanted).count_ones());
        total += u64::from(wanted.count_ones());
    }
    (different, total)
}

#[test]
fn packets_equal_single_rays_on_three_scenes() {
    let mut rays = 0;
    for name in ["atrium", "nave", "hairball"] {
        let stage = Stage::bundled(name).unwrap();
        let mut pipeline = stage.builder().size(96, 72).refiner(PerPixel::default()).build().unwrap();
        pipeline.render().unwrap();
        let gbuffer = pipeline.gbuffer();
        let full = Pattern { kind: PatternKind::Jittered, columns: 8, rows: 8 };
        let pyramid = Pyramid::default();
        let sharing = halflight::frame::Sharing::Receiver;
        let frame = Frame {
            scene: &stage.scene,
            gbuffer,
            pyramid: &pyramid,
            pattern: full,
            sharing,
            index: 0,
            seed: 0,
        };
        let mut packets = BvhRays::new(stage.bvh.clone());
        let mut single = BvhRays::single_rays(stage.bvh.clone());
        for (pattern, subset) in [
            (full, None),
            (Pattern { kind: PatternKind::Grid, columns: 4, rows: 4 }, None),
            (full, Some(0x0000_1000_0020_0401u64)),
            (Pattern { kind: PatternKind::ShiftedRows, columns: 16, rows: 8 }, None),
        ] {
            let mut batch = MaskBatch::default();
            batch.reset(0, pattern, Purpose::Final);
            for pixel in 0..gbuffer.pixels() {
                if let Some(receiver) = gbuffer.receiver(pixel) {
                    let subset = subset.map(|word| [word.rotate_left(hash::mix(pixel as u32) & 63)]);
                    let subset = subset.as_ref().map(<[u64; 1]>::as_slice);
                    batch.push(
                        receiver.origin,
                        receiver.normal,
                        pixel as u32,
                        hash::mix(pixel as u32),
                        subset,
                    );
                }
            }
            let (different, total) = differences(&frame, &mut batch, &mut packets, &mut single);
            assert_eq!(different, 0, "{name} {pattern:?}: of {total} rays");
            rays += total;
        }
    }
    assert!(rays >= 1_000_000, "only {rays} rays");
}

/// Backend with one wrong sample in one query.
struct Wrong(BvhRays);

impl Visibility for Wrong {
    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        self.0.masks(frame, batch);
        let (_, _, visible) = batch.slots_mut();
        visible[0] ^= 1;
    }
}

#[test]
fn the_comparison_notices_one_wrong_bit() {
    let stage = Stage::bundled("contact").unwrap();
    let mut pipeline = stage.builder().size(8, 8).refiner(PerPixel::default()).build().unwrap();
    pipeline.render().unwrap();
    let gbuffer = pipeline.gbuffer();
    let pattern = Pattern { kind: PatternKind::Grid, columns: 4, rows: 4 };
    let (pyramid, sharing) = (Pyramid::default(), halflight::frame::Sharing::Frame);
    let frame =
        Frame { scene: &stage.scene, gbuffer, pyramid: &pyramid, pattern, sharing, index: 0, seed: 0 };
    let mut batch = MaskBatch::default();
    batch.reset(0, pattern, Purpose::Final);
    let receiver = (0..gbuffer.pixels()).find_map(|pixel| gbuffer.receiver(pixel)).unwrap();
    batch.push(receiver.origin, Vec3::Y, 0, 0, None);
    let rays = || BvhRays::new(stage.bvh.clone());
    assert_eq!(differences(&frame, &mut batch, &mut rays(), &mut Wrong(rays())).0, 1);
}
