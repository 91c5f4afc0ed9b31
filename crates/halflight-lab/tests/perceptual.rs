//! Perceptual errors of real renders in a known order: a ball above a floor, at two error targets and with many samples.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail their test")]

use std::f32::consts::PI;
use std::fmt::Write as _;

use glam::Vec3;
use halflight_core::frame::{LightSampling, Sharing};
use halflight_cpu::config::{PipelineConfig, RefinerConfig};
use halflight_cpu::prepared::PreparedScene;
use halflight_cpu::refine::LatticeConfig;
use halflight_lab::reference::{ReferenceConfig, receivers, reference, seen};
use halflight_metrics::{Comparison, Image, compare};

const SIZE: [u32; 2] = [200, 150];

const SCENE: &str = r#"
[camera]
eye = [1.6, 1.9, 2.6]
target = [0.2, 0.35, 0.0]
up = [0, 1, 0]
fov_y_deg = 42.0
[[light]]
corner = [-1.9, 3.0, -0.6]
edge_u = [1.2, 0, 0]
edge_v = [0, 0, 1.2]
radiance = [22, 22, 22]
two_sided = false
[[mesh]]
file = "ball.obj"
"#;

/// A ball of 16 × 8 facets above a floor, as an OBJ file.
fn ball() -> String {
    const AROUND: usize = 16;
    const DOWN: usize = 8;
    let mut text = String::new();
    for ring in 0..=DOWN {
        for place in 0..AROUND {
            let (down, around) = (PI * ring as f32 / DOWN as f32, 2.0 * PI * place as f32 / AROUND as f32);
            let direction = Vec3::new(down.sin() * around.cos(), down.cos(), down.sin() * around.sin());
            let Vec3 { x, y, z } = 0.5 * direction + 0.8 * Vec3::Y;
            writeln!(text, "v {x} {y} {z}").unwrap();
        }
    }
    text += "v -4 0 -4\nv -4 0 4\nv 4 0 4\nv 4 0 -4\n";
    for ring in 0..DOWN {
        for place in 0..AROUND {
            let [a, b] = [place, (place + 1) % AROUND].map(|place| 1 + ring * AROUND + place);
            let (c, d) = (a + AROUND, b + AROUND);
            // Triangles at the poles have no area on one side.
            if ring > 0 {
                writeln!(text, "f {a} {b} {c}").unwrap();
            }
            if ring + 1 < DOWN {
                writeln!(text, "f {b} {d} {c}").unwrap();
            }
        }
    }
    let floor = 1 + (DOWN + 1) * AROUND;
    writeln!(text, "f {floor} {} {} {}", floor + 1, floor + 2, floor + 3).unwrap();
    text
}

fn scene() -> PreparedScene {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("ball.obj"), ball()).unwrap();
    let path = folder.path().join("ball.toml");
    std::fs::write(&path, SCENE).unwrap();
    PreparedScene::new(halflight_scene::resolve(&path.to_string_lossy()).unwrap().scene).unwrap()
}

fn target(target: f32) -> PipelineConfig {
    let refiner = RefinerConfig::Lattice(LatticeConfig { target, ..LatticeConfig::default() });
    PipelineConfig { refiner, ..PipelineConfig::default() }
}

#[test]
fn flip_and_grain_rank_renders_as_the_eye_does() {
    let scene = scene();
    let [width, height] = SIZE;
    let config = ReferenceConfig { width, height, samples: 4096, ..ReferenceConfig::default() };
    let truth = reference(&scene, &config, None, &mut |_, _| {}).unwrap();
    let mask = receivers(&seen(&scene, SIZE));
    let many = LightSampling { count: 1024, sharing: Sharing::Receiver, ..LightSampling::default() };
    let per_pixel =
        PipelineConfig { refiner: RefinerConfig::PerPixel, sampling: many, ..PipelineConfig::default() };
    let errors = [target(1e-4), target(1e-5), per_pixel].map(|config| -> Comparison {
        let mut pipeline = config.builder(&scene).size(width, height).build().unwrap();
        let image = &pipeline.render().unwrap().irradiance;
        let view = |pixels| Image::new(width, height, pixels).unwrap().with_mask(&mask).unwrap();
        let reference = view(&truth.irradiance).with_visible_fractions(&truth.visibility).unwrap();
        compare(view(image), reference).unwrap()
    });
    // Half as much again and more: what tells the three apart is not chance.
    let ranked = |of: fn(&Comparison) -> f64| errors.windows(2).all(|pair| of(&pair[0]) > 1.5 * of(&pair[1]));
    assert!(ranked(|errors| errors.flip_p99), "{errors:#?}");
    assert!(ranked(|errors| errors.grain.unwrap()), "{errors:#?}");
}
