//! Shadows that pass between the corners of cells: with certificates none is missed.

use halflight::config::{PipelineConfig, RefinerConfig, UpsamplerConfig};
use halflight::frame::{LightSampling, Sharing};
use halflight::glam::Vec3;
use halflight::pattern::PatternKind;
use halflight::pipeline::Image;
use halflight::refine::LatticeConfig;
use halflight::scene::Scene;
use halflight_tests::{Stage, blocker_over_floor, quads, square_light};
use std::sync::Arc;

/// Floor seen from above, with occluders below a light.
fn over_floor(things: &[(Vec3, Vec3, Vec3)], light: f32) -> Scene {
    let mut all = vec![(Vec3::new(-10.0, 0.0, -10.0), Vec3::Z * 20.0, Vec3::X * 20.0)];
    all.extend_from_slice(things);
    Scene {
        mesh: Arc::new(quads(&all)),
        lights: vec![square_light(Vec3::new(0.0, 4.0, 0.0), light)],
        ..blocker_over_floor()
    }
}

/// Wires strung under the light, thin for the lattice but not for the pixels.
fn wires() -> Scene {
    let wire = |x: f32| (Vec3::new(x, 0.3, -4.0), Vec3::Z * 8.0, Vec3::X * 0.03);
    over_floor(&[wire(-1.03), wire(-0.41), wire(0.33), wire(1.11)], 0.05)
}

/// Two large occluders with a slit between them.
fn slit() -> Scene {
    let sheet = |x: f32| (Vec3::new(x, 3.5, -6.0), Vec3::Z * 12.0, Vec3::X * 6.0);
    over_floor(&[sheet(-6.004), sheet(0.004)], 0.01)
}

/// Number of pixels whose visible fraction differs by more than a quarter from the per-pixel image with the
/// same samples, and the fraction of receivers that were not traced.
fn missed(stage: &Stage, certify: bool) -> (usize, f64) {
    let render = |refiner: RefinerConfig| -> Image {
        let config = PipelineConfig {
            width: 192,
            height: 144,
            refiner,
            upsampler: UpsamplerConfig::Lattice(Default::default()),
            sampling: LightSampling { count: 64, kind: PatternKind::Jittered, sharing: Sharing::Receiver },
            ..PipelineConfig::default()
        };
        let builder = config.builder(&stage.prepared);
        builder.layers(true).build().unwrap().render().unwrap().clone()
    };
    let truth = render(RefinerConfig::PerPixel);
    let image = render(RefinerConfig::Lattice(LatticeConfig { certify, ..LatticeConfig::default() }));
    let off = image.visibility.iter().zip(&truth.visibility).filter(|(a, b)| (*a - *b).abs() > 0.25);
    let spared = 1.0 - image.stats.fragments.total as f64 / truth.stats.fragments.total as f64;
    (off.count(), spared)
}

#[test]
fn with_proofs_no_thin_shadow_is_missed() {
    let hairball = Stage::bundled("hairball").unwrap();
    let railing = Stage::bundled("railing").unwrap();
    let (wires, slit) = (Stage::new(wires()).unwrap(), Stage::new(slit()).unwrap());
    for (name, stage) in [("wires", wires), ("slit", slit), ("railing", railing), ("hairball", hairball)] {
        let (missed_without, _) = missed(&stage, false);
        let (missed_with, spared) = missed(&stage, true);
        println!(
            "{name}: {missed_without} missed without certificates, {missed_with} with them, {spared:.2} spared"
        );
        assert_eq!(missed_with, 0, "{name}");
        assert!(spared > 0.05, "{name}: all was traced");
        // Without certificates, wires must be missed, or the test has no power; the slit is found at a corner
        // and followed.
        assert!(name != "wires" || missed_without > 10, "{missed_without}");
    }
}
