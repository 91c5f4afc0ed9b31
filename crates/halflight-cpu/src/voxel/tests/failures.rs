//! Causes of wrong pixels.

use super::error_map::{Cause, VoxelErrorCounts, VoxelErrorMap, segments, voxel_error_map};
use super::*;

const ROOF: (Vec3, Vec3) = (Vec3::new(-1.0, 1.0, -1.0), Vec3::new(1.0, 1.02, 1.0));

fn map(stage: &Stage, config: VoxelConfig, threshold: f32) -> VoxelErrorMap {
    let mut voxels = stage.prepared(config);
    let questions = stage.questions(|_| true);
    let (exact, found) = (stage.exact(&questions), stage.answered(&mut voxels, &questions));
    let blocked = segments(&stage.bvh);
    let map = voxel_error_map(&stage.frame(), &voxels, &exact, &found, threshold, &blocked);
    assert_eq!(map.image.len(), stage.gbuffer.pixels());
    for cause in Cause::ALL {
        let painted = map.image.iter().filter(|&&pixel| pixel == cause.color()).count();
        assert_eq!(painted as u64, map.counts.of(cause), "{cause:?}");
    }
    map
}

#[test]
fn equal_masks_have_no_failures() {
    let stage = Stage::new(floor_with(&[ROOF]), 64, 48);
    let questions = stage.questions(|_| true);
    let exact = stage.exact(&questions);
    let voxels = stage.prepared(EXACT);
    let same = voxel_error_map(&stage.frame(), &voxels, &exact, &exact, 0.0, &segments(&stage.bvh));
    assert_eq!(same.counts.failures(), 0);
    assert!(same.counts.receivers > 500);
    // No fraction differs by more than 1.
    assert_eq!(map(&stage, EXACT, 1.0).counts.failures(), 0);
}

#[test]
fn without_bias_receivers_shade_themselves() {
    let stage = Stage::new(floor_with(&[]), 64, 48);
    let bare = map(&stage, VoxelConfig { bias: 0.0, ..EXACT }, 0.1).counts;
    assert!(bare.self_occlusion > bare.receivers / 2, "{bare:?}");
    assert_eq!(bare.failures(), bare.self_occlusion, "there is nothing else: {bare:?}");
    let biased = map(&stage, EXACT, 0.1).counts;
    assert!(biased.self_occlusion * 10 < bare.self_occlusion, "{biased:?}");
}

#[test]
fn thin_roofs_shade_too_much_and_contacts_too_little() {
    let stage = Stage::new(floor_with(&[ROOF]), 64, 48);
    let coarse = VoxelConfig { resolution: 32, depth_bits: 32, ..EXACT };
    let counts = map(&stage, coarse, 0.1).counts;
    assert!(counts.thickness > 10 && counts.out_of_view == 0, "{counts:?}");
    // Offset by many voxels, rays start above a low step and lose its shadow.
    let step = (Vec3::new(-3.0, 0.0, 2.0), Vec3::new(3.0, 0.3, 2.2));
    let stage = Stage::new(floor_with(&[step]), 128, 96);
    let counts = map(&stage, VoxelConfig { bias: 20.0, ..EXACT }, 0.1).counts;
    assert!(counts.missed > 10 && counts.out_of_view == 0, "{counts:?}");
}

#[test]
fn blockers_outside_the_grid_are_told_apart() {
    let mut scene = floor_with(&[(Vec3::new(-2.0, 1.0, -2.0), Vec3::new(2.0, 1.3, 2.0))]);
    scene.camera = Camera { eye: Vec3::new(0.0, 0.8, 3.0), target: Vec3::new(0.0, 0.0, 0.9), ..scene.camera };
    scene.camera.fov_y_deg = 25.0;
    let counts = map(&Stage::new(scene, 60, 60), EXACT, 0.1).counts;
    assert!(counts.out_of_view > 1000, "{counts:?}");
    assert_eq!(
        counts,
        VoxelErrorCounts { receivers: counts.receivers, out_of_view: counts.failures(), ..counts }
    );
}
