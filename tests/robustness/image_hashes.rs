//! Regression test of images, bit for bit: hashes of every combination of stages.
//!
//! Hashes are specific to one platform's mathematical functions. `HALFLIGHT_WRITE_HASHES=1` rewrites the
//! file, for changes that are meant to change images.

use std::fmt::Write as _;
use std::path::Path;

use halflight::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig};
use halflight::frame::LightSampling;
use halflight::glam::Vec3;
use halflight::irradiance::Shading;
use halflight::pattern::PatternKind;
use halflight::refine::LatticeConfig;
use halflight_tests::Stage;

const SCENES: [&str; 5] = ["atrium", "church", "railing", "toys", "contact"];
/// Image sizes, and number of threads for each.
const SIZES: [(u32, u32, usize); 2] = [(64, 48, 1), (45, 37, 8)];

/// FNV-1a over the bits of an image.
fn hash(mut state: u64, image: &[Vec3]) -> u64 {
    for byte in image.iter().flat_map(Vec3::to_array).flat_map(|value| value.to_bits().to_le_bytes()) {
        state = (state ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    }
    state
}

/// Hashes of a scene, one per size, refiner and backend, over all upsamplers and shadings.
fn hashes(scene: &str) -> String {
    let mut table = String::new();
    let mut refiners: Vec<(&str, RefinerConfig)> =
        RefinerConfig::NAMES.iter().map(|&name| (name, RefinerConfig::named(name).unwrap())).collect();
    let target = LatticeConfig { target: 1e-3, ..LatticeConfig::default() };
    refiners.push(("lattice-target", RefinerConfig::Lattice(target)));
    let stage = Stage::bundled(scene).unwrap();
    for (width, height, threads) in SIZES {
        for &(name, refiner) in &refiners {
            for visibility in VisibilityConfig::NAMES {
                // Patterns in rows, the only ones that 4D rasterization supports.
                let rows = *visibility == "raster4d";
                let kind = if rows { PatternKind::ShiftedRows } else { PatternKind::Jittered };
                let mut state = 0xcbf2_9ce4_8422_2325;
                for upsampler in UpsamplerConfig::all() {
                    for shading in [Shading::Sampled, Shading::Ratio] {
                        let config = PipelineConfig {
                            width,
                            height,
                            refiner,
                            visibility: VisibilityConfig::named(visibility).unwrap(),
                            upsampler,
                            shading,
                            sampling: LightSampling { kind, ..LightSampling::default() },
                            ..PipelineConfig::default()
                        };
                        let builder = config.builder(&stage.prepared).threads(threads);
                        state = hash(state, &builder.build().unwrap().render().unwrap().irradiance);
                    }
                }
                writeln!(table, "{scene} {width}x{height} {name} {visibility} {state:016x}").unwrap();
            }
        }
    }
    table
}

#[test]
#[cfg_attr(not(all(target_os = "linux", target_arch = "x86_64")), ignore = "hashes are of x86-64 Linux")]
fn images_of_all_combinations_are_unchanged() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robustness/image_hashes.txt");
    let found: String = std::thread::scope(|scope| {
        let tables = SCENES.map(|scene| scope.spawn(move || hashes(scene)));
        tables.into_iter().map(|table| table.join().unwrap()).collect()
    });
    if std::env::var_os("HALFLIGHT_WRITE_HASHES").is_some() {
        std::fs::write(&file, &found).unwrap();
    }
    let expected = std::fs::read_to_string(&file).unwrap();
    let changed: Vec<&str> =
        found.lines().zip(expected.lines()).filter(|(a, b)| a != b).map(|(a, _)| a).collect();
    assert!(changed.is_empty(), "{} changed: {changed:#?}", changed.len());
    assert_eq!(found.lines().count(), expected.lines().count());
}
