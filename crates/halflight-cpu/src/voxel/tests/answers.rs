//! Visibility masks of whole images.

use super::*;
use crate::bvh::tests::meshes::hall;

const ROOF: (Vec3, Vec3) = (Vec3::new(-2.0, 1.0, -2.0), Vec3::new(2.0, 1.3, 2.0));

/// Receivers on the floor, well under the roof.
fn below_roof(p: Vec3) -> bool {
    p.y.abs() < 1e-3 && p.x.abs() < 0.8 && p.z.abs() < 0.8
}

fn on_floor(p: Vec3) -> bool {
    p.y.abs() < 1e-3 && p.x.abs() < 3.5 && p.z.abs() < 3.5
}

fn both() -> impl Iterator<Item = VoxelConfig> {
    // Steps thicken rays by a slice on either side, and therefore need a larger bias.
    [(Traversal::Dda, 1.0, 0), (Traversal::Steps { count: 48 }, 2.5, 1)]
        .into_iter()
        .map(|(traversal, bias, thickness)| VoxelConfig { traversal, bias, thickness, ..EXACT })
}

#[test]
fn a_roof_blocks_and_without_it_all_is_free() {
    let (roofed, open) = (Stage::new(floor_with(&[ROOF]), 80, 60), Stage::new(floor_with(&[]), 80, 60));
    for config in both() {
        let questions = roofed.questions(below_roof);
        let (seen, wanted) = visible(&roofed.answered(&mut roofed.prepared(config), &questions));
        assert!(questions.len() > 20 && wanted > 1000);
        assert_eq!(seen, 0, "{config:?}");
        let questions = open.questions(on_floor);
        let (seen, wanted) = visible(&open.answered(&mut open.prepared(config), &questions));
        assert!(questions.len() > 500);
        assert_eq!(seen, wanted, "{config:?}");
        // A false bit is noticed: a column of voxels in the middle of the image.
        let voxels = open.prepared(config);
        for texel in 60..68 {
            voxels.grid.set(texel, 60, 0, 127);
        }
        voxels.grid.build_levels();
        let mut voxels = voxels;
        assert!(visible(&open.answered(&mut voxels, &questions)).0 < wanted, "{config:?}");
        // A missing bit is noticed as well.
        let questions = roofed.questions(below_roof);
        let mut voxels = roofed.prepared(config);
        voxels.grid.clear();
        assert!(visible(&roofed.answered(&mut voxels, &questions)).0 > 0, "{config:?}");
    }
}

#[test]
fn masks_of_a_hall_are_mostly_those_of_ray_tracing() {
    let camera = Camera {
        eye: Vec3::new(3.0, 1.7, 15.0),
        target: Vec3::new(4.5, 1.5, 4.0),
        up: Vec3::Y,
        fov_y_deg: 60.0,
        ..Camera::default()
    };
    let stage = Stage::new(Scene { camera, ..scene(&hall(), lamp(Vec3::new(4.0, 2.8, 8.0), 1.0)) }, 64, 48);
    let questions = stage.questions(|_| true);
    let exact = stage.exact(&questions);
    let config = VoxelConfig { resolution: 512, depth_bits: 512, ..EXACT };
    let differing = |found: &MaskBatch| {
        let bits =
            |query: usize| (exact.visible(query)[0] ^ found.visible(query)[0]) & exact.wanted(query)[0];
        (0..exact.len()).map(|query| bits(query).count_ones()).sum::<u32>() as f32
    };
    let wanted = visible(&exact).1 as f32;
    // Empirical thresholds: fine voxels must be far better than no shadows, and than coarse voxels.
    let fine = differing(&stage.answered(&mut stage.prepared(config), &questions)) / wanted;
    let coarse = VoxelConfig { resolution: 32, depth_bits: 32, ..config };
    let coarse = differing(&stage.answered(&mut stage.prepared(coarse), &questions)) / wanted;
    let none = differing(&stage.answered(&mut Voxels::new(config).unwrap(), &questions)) / wanted;
    assert!(fine < 0.15 && fine < coarse * 0.5 && fine < none * 0.5, "{fine} {coarse} {none}");
}

#[test]
fn leaving_out_empty_space_changes_nothing() {
    let stage =
        Stage::new(floor_with(&[ROOF, (Vec3::new(-3.0, 0.0, 1.0), Vec3::new(-2.5, 2.0, 1.1))]), 80, 60);
    let questions = stage.questions(|_| true);
    for config in both() {
        let voxels = stage.prepared(config);
        let course = voxels.course(stage.frame().light(0)).unwrap();
        let mut voxels = stage.prepared(config);
        let found = stage.answered(&mut voxels, &questions);
        let (mut bits, mut different) = (0, 0);
        for query in 0..questions.len() {
            let asked = questions.queries()[query];
            for sample in 0..64 {
                if questions.wanted(query)[0] >> sample & 1 == 1 {
                    let position = stage.frame().pattern.position(sample, asked.key);
                    let stopped = course.stopper(asked.origin, asked.normal, position).is_some();
                    bits += 1;
                    different += u32::from(stopped == (found.visible(query)[0] >> sample & 1 == 1));
                }
            }
        }
        // Rays that begin halfway round differently: they may pass a voxel's corner on the other side.
        assert!(bits > 50_000 && different * 10_000 < bits, "{different} of {bits}, {config:?}");
    }
}

#[test]
fn occluders_out_of_view_let_light_through() {
    let mut scene = floor_with(&[ROOF]);
    // Looking down below the roof.
    scene.camera = Camera { eye: Vec3::new(0.0, 0.8, 3.0), target: Vec3::new(0.0, 0.0, 0.9), ..scene.camera };
    scene.camera.fov_y_deg = 25.0;
    let stage = Stage::new(scene, 60, 60);
    let questions = stage.questions(below_roof);
    assert!(questions.len() > 100);
    for config in both() {
        let (seen, wanted) = visible(&stage.answered(&mut stage.prepared(config), &questions));
        assert_eq!((seen, visible(&stage.exact(&questions)).0), (wanted, 0), "{config:?}");
    }
}

#[test]
fn answers_do_not_depend_on_threads_or_instruction_sets() {
    let stage = Stage::new(floor_with(&[ROOF]), 80, 60);
    let questions = stage.questions(|_| true);
    for config in both() {
        let answers = |threads: usize, isa: Isa| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut voxels = stage.prepared(config).with_isa(isa);
                let batch = stage.answered(&mut voxels, &questions);
                let masks: Vec<u64> = (0..batch.len()).map(|query| batch.visible(query)[0]).collect();
                (voxels.grid.to_words(), masks)
            })
        };
        let expected = answers(1, Isa::BASELINE);
        for isa in Isa::available() {
            for threads in [1, 2, 8] {
                assert!(answers(threads, isa) == expected, "{threads} threads, {isa:?}, {config:?}");
            }
        }
    }
}

#[test]
fn a_frame_leaves_nothing_for_the_next() {
    let (roofed, open) = (Stage::new(floor_with(&[ROOF]), 80, 60), Stage::new(floor_with(&[]), 64, 64));
    let mut voxels = roofed.prepared(EXACT);
    let bytes = voxels.bytes();
    voxels.prepare(&open.frame());
    assert_eq!(voxels.grid.to_words(), open.prepared(EXACT).grid.to_words());
    assert_eq!(voxels.bytes(), bytes);
    // 128 x 128 x 128 bits, and a third more for coarser levels.
    assert!((128 * 128 * 16..128 * 128 * 16 * 3 / 2).contains(&bytes));
}

#[test]
fn without_receivers_all_is_visible() {
    let stage = Stage::new(floor_with(&[ROOF]), 80, 60);
    let questions = stage.questions(below_roof);
    let mut nothing = Stage::new(floor_with(&[]), 4, 4);
    nothing.gbuffer.reset(4, 4);
    nothing.gbuffer.depth.fill(f32::INFINITY);
    let mut voxels = stage.prepared(EXACT);
    voxels.prepare(&nothing.frame());
    for mut voxels in [voxels, Voxels::new(EXACT).unwrap()] {
        let (seen, wanted) = visible(&stage.answered(&mut voxels, &questions));
        assert_eq!(seen, wanted);
    }
}

#[test]
fn constants_out_of_range_are_refused() {
    let good = VoxelConfig::default();
    let steps = |count| VoxelConfig { traversal: Traversal::Steps { count }, ..good };
    for config in [
        good,
        VoxelConfig { resolution: 32, depth_bits: 512, ..good },
        VoxelConfig { resolution: 1024, depth_bits: 32, bias: 0.0, ..good },
        steps(1),
    ] {
        assert!(config.validate().is_ok(), "{config:?}");
    }
    for (config, error, told) in [
        (VoxelConfig { resolution: 31, ..good }, VoxelError::Resolution(31), "32 to 1024"),
        (VoxelConfig { resolution: 1025, ..good }, VoxelError::Resolution(1025), "32 to 1024"),
        (VoxelConfig { depth_bits: 0, ..good }, VoxelError::DepthBits(0), "32 to 512"),
        (VoxelConfig { depth_bits: 513, ..good }, VoxelError::DepthBits(513), "32 to 512"),
        (steps(0), VoxelError::Steps(0), "1 to 1024"),
        (VoxelConfig { thickness: 65, ..good }, VoxelError::Thickness(65), "0 to 64"),
        (VoxelConfig { bias: -0.5, ..good }, VoxelError::Bias(-0.5), "0 to 64"),
    ] {
        assert_eq!(Voxels::new(config).unwrap_err(), error);
        assert!(error.to_string().contains(told), "{error}");
    }
    assert!(Voxels::new(VoxelConfig { bias: f32::NAN, ..good }).is_err());
}
