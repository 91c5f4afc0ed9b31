//! References: the truth where it is known, less noise with more samples, and stopped runs that go on.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail their test")]

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use glam::Vec3;
use halflight_core::frame::{LightSampling, Sharing};
use halflight_core::gbuffer::GBuffer;
use halflight_core::scene::Scene;
use halflight_cpu::config::{PipelineConfig, RefinerConfig};
use halflight_cpu::gbuffer;
use halflight_cpu::prepared::PreparedScene;
use halflight_cpu::unshadowed::unshadowed;
use halflight_lab::reference::{PASS, Reference, ReferenceConfig, ReferenceError, reference};
use halflight_metrics::{Image, PENUMBRA, grain};

const SIZE: (u32, u32) = (48, 36);

fn folder(test: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("reference-{test}"));
    let _ = fs::remove_dir_all(&folder);
    folder
}

fn scene(name: &str) -> PreparedScene {
    PreparedScene::new(halflight_scene::load_bundled(name).unwrap().scene).unwrap()
}

fn config(samples: u32) -> ReferenceConfig {
    ReferenceConfig { width: SIZE.0, height: SIZE.1, samples, ..ReferenceConfig::default() }
}

fn uncached(name: &str, samples: u32) -> Reference {
    let scene = scene(name);
    reference(&scene, &config(samples), None, &mut |_, _| {}).unwrap()
}

#[test]
fn open_floor_is_the_analytic_irradiance_without_noise() {
    let scene = scene("open-floor");
    let found = reference(&scene, &config(1), None, &mut |_, _| {}).unwrap();
    let mut seen = GBuffer::default();
    gbuffer::trace(scene.bvh(), scene.scene(), SIZE.0, SIZE.1, &mut seen);
    let expected: Vec<Vec3> = (0..seen.pixels())
        .map(|pixel| {
            let Some(receiver) = seen.receiver(pixel) else { return Vec3::ZERO };
            let lights = scene.scene().lights.iter();
            lights.map(|light| light.radiance * unshadowed(light, receiver.origin, receiver.normal)).sum()
        })
        .collect();
    // Nothing is occluded: ΣgV and Σg are the same number, so the fraction is 1 and no rounding is left.
    assert_eq!(found.irradiance, expected);
    assert_eq!((found.noise_nmse2, found.samples), (0.0, 2 * PASS));
    let lit = |pixel: usize| if expected[pixel] == Vec3::ZERO { 0.0 } else { 1.0 };
    assert_eq!(found.visibility, (0..seen.pixels()).map(lit).collect::<Vec<f32>>());
}

#[test]
fn visible_fractions_are_those_of_an_image_with_as_many_samples() {
    let scene = scene("contact");
    let found = reference(&scene, &config(4096), None, &mut |_, _| {}).unwrap();
    let sampling = LightSampling { count: 4096, sharing: Sharing::Receiver, ..LightSampling::default() };
    let per_pixel =
        PipelineConfig { refiner: RefinerConfig::PerPixel, sampling, ..PipelineConfig::default() };
    let builder = per_pixel.builder(&scene).size(SIZE.0, SIZE.1).layers(true);
    let mut pipeline = builder.build().unwrap();
    let image = pipeline.render().unwrap();
    let partly = found.visibility.iter().filter(|part| PENUMBRA.contains(*part)).count();
    assert!(partly > 50, "{partly}");
    for (pixel, (found, expected)) in found.visibility.iter().zip(&image.visibility).enumerate() {
        // Stratified samples on a straight edge: the fraction of one stratum of 64 a side, in each of two images.
        assert!((found - expected).abs() < 2.0 / 64.0, "{pixel}: {found} {expected}");
    }
}

#[test]
fn a_stopped_reference_goes_on_bit_for_bit() {
    let scene = scene("contact");
    let folder = folder("stopped");
    // Stopped the hard way, after six of eight passes; the state was last saved after four.
    let stopped = std::panic::catch_unwind(|| {
        reference(&scene, &config(8 * PASS), Some(&folder), &mut |done, _| {
            assert!(done < 6 * PASS, "stopped on purpose");
        })
    });
    assert!(stopped.is_err());
    let mut calls = Vec::new();
    let whole = reference(&scene, &config(8 * PASS), Some(&folder), &mut |done, total| {
        calls.push((done / PASS, total / PASS));
    });
    assert_eq!(calls, [(4, 8), (5, 8), (6, 8), (7, 8), (8, 8)]);
    assert_eq!(whole.unwrap(), uncached("contact", 8 * PASS));
}

#[test]
fn more_samples_continue_and_fewer_are_answered_from_the_cache() {
    let scene = scene("contact");
    let folder = folder("continued");
    let start = |samples| {
        let mut first = None;
        let found = reference(&scene, &config(samples), Some(&folder), &mut |done, _| {
            first.get_or_insert(done);
        });
        (first.unwrap() / PASS, found.unwrap())
    };
    let (from, few) = start(2 * PASS);
    assert_eq!((from, few.samples), (0, 2 * PASS));
    let (from, more) = start(6 * PASS);
    assert_eq!(from, 2);
    assert_eq!(more, uncached("contact", 6 * PASS));
    let (_, again) = start(2 * PASS);
    assert_eq!(again, more);
}

#[test]
fn noise_falls_with_samples_and_is_what_another_seed_shows() {
    let (few, many) = (uncached("contact", 2 * PASS), uncached("contact", 8 * PASS));
    // Four times the passes leave a quarter of the variance. Each estimate is a sum over the few hundred pixels of the
    // penumbra and uncertain by some ten per cent; between 2.5 and 6.5 lies well outside that.
    let ratio = few.noise_nmse2 / many.noise_nmse2;
    assert!((2.5..6.5).contains(&ratio), "{ratio}");
    let [coarse, fine] = [&few, &many].map(|found| found.noise_grain.unwrap());
    // Half of the deviation, in a percentile of a few hundred pixels.
    assert!((1.4..2.9).contains(&(coarse / fine)), "{coarse} {fine}");
    // The estimate is true: two references of different seeds differ by twice the noise of one.
    let scene = scene("contact");
    let other = ReferenceConfig { seed: 7, ..config(2 * PASS) };
    let other = reference(&scene, &other, None, &mut |_, _| {}).unwrap();
    let squares = |a: &[Vec3], b: &[Vec3]| -> f64 {
        a.iter().zip(b).map(|(a, b)| f64::from((*a - *b).length_squared())).sum()
    };
    let zero = vec![Vec3::ZERO; few.irradiance.len()];
    let view = |found: &Reference| -> f64 {
        let image = |pixels| Image::new(SIZE.0, SIZE.1, pixels).unwrap();
        let reference = image(&found.irradiance).with_visible_fractions(&found.visibility).unwrap();
        grain(image(&other.irradiance), reference).unwrap().unwrap()
    };
    // Errors of equal size add up to √2 of them.
    let seen = view(&few) / (2.0f64.sqrt() * few.noise_grain.unwrap());
    assert!((0.6..1.6).contains(&seen), "{seen}");
    let difference = squares(&few.irradiance, &other.irradiance) / squares(&few.irradiance, &zero);
    let expected = few.noise_nmse2 + other.noise_nmse2;
    // Both sides are such sums again.
    assert!((0.6..1.6).contains(&(difference / expected)), "{difference:e}, {expected:e} expected");
}

#[test]
fn several_lights_add_up() {
    let one = scene("contact");
    let mut both = one.scene().clone();
    let light = both.lights[0];
    both.lights.push(light.moved(Vec3::new(1.0, 0.0, 0.5)));
    let mut second = both.clone();
    second.lights.remove(0);
    let mean = |scene: &Scene| {
        let scene = one.moved(scene.clone()).unwrap();
        let found = reference(&scene, &config(4 * PASS), None, &mut |_, _| {}).unwrap();
        found.irradiance.iter().map(|value| value.as_dvec3()).sum::<glam::DVec3>().x
    };
    let (sum, whole) = (mean(one.scene()) + mean(&second), mean(&both));
    // The second light has other random samples when it comes second: its noise, averaged over all pixels, is left.
    assert!((sum / whole - 1.0).abs() < 1e-4, "{sum} {whole}");
}

#[test]
fn another_scene_size_or_seed_has_a_state_of_its_own() {
    let folder = folder("keys");
    let contact = scene("contact");
    let run = |scene: &Scene, config: &ReferenceConfig| {
        let mut first = None;
        reference(&contact.moved(scene.clone()).unwrap(), config, Some(&folder), &mut |done, _| {
            first.get_or_insert(done);
        })
        .unwrap();
        assert_eq!(first, Some(0), "a state was taken over from another image");
    };
    let base = config(1);
    run(contact.scene(), &base);
    run(contact.scene(), &ReferenceConfig { width: 47, ..base });
    run(contact.scene(), &ReferenceConfig { seed: 1, ..base });
    let mut moved = contact.scene().clone();
    moved.camera.eye.x += 1e-3;
    run(&moved, &base);
    let mut brighter = contact.scene().clone();
    brighter.lights[0].radiance.z *= 2.0;
    run(&brighter, &base);
    let mut other = contact.scene().clone();
    Arc::make_mut(&mut other.mesh).positions[0].y += 1e-3;
    run(&other, &base);
    let mut smooth = contact.scene().clone();
    let mesh = Arc::make_mut(&mut smooth.mesh);
    mesh.normals = mesh.positions.iter().map(|position| position.normalize_or_zero()).collect();
    run(&smooth, &base);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 7);
}

#[test]
fn a_damaged_state_is_refused_by_name() {
    let scene = scene("contact");
    let folder = folder("damaged");
    let run = || reference(&scene, &config(1), Some(&folder), &mut |_, _| {});
    run().unwrap();
    let path = fs::read_dir(&folder).unwrap().next().unwrap().unwrap().path();
    let bytes = fs::read(&path).unwrap();
    let mut flipped = bytes.clone();
    flipped[bytes.len() / 2] ^= 1;
    for damaged in [&bytes[..bytes.len() - 8], &bytes[..20], &[], &flipped] {
        fs::write(&path, damaged).unwrap();
        let error = run().unwrap_err();
        assert!(matches!(&error, ReferenceError::State { path: found, .. } if *found == path), "{error}");
    }
    fs::write(&path, &bytes).unwrap();
    assert!(run().is_ok());
}

#[test]
fn what_cannot_be_rendered_is_refused() {
    let scene = scene("contact");
    let fault = |config| reference(&scene, &config, None, &mut |_, _| {}).unwrap_err();
    assert!(matches!(fault(config(0)), ReferenceError::Samples(0)));
    assert!(matches!(fault(ReferenceConfig { width: 0, ..config(1) }), ReferenceError::Pipeline(_)));
    let large = ReferenceConfig { width: 32_768, height: 32_768, ..config(1) };
    assert!(
        halflight_image::memory::available().is_none() || matches!(fault(large), ReferenceError::Memory(_))
    );
}

#[test]
fn an_image_that_no_light_reaches_is_black_and_has_no_noise() {
    let scene = scene("contact");
    let black = |change: &dyn Fn(&mut Scene)| {
        let mut changed = scene.scene().clone();
        change(&mut changed);
        let found = reference(&scene.moved(changed).unwrap(), &config(1), None, &mut |_, _| {}).unwrap();
        assert!(found.irradiance.iter().all(|&value| value == Vec3::ZERO));
        assert_eq!((found.noise_nmse2, found.noise_flicker, found.noise_grain), (0.0, 0.0, None));
    };
    black(&|scene| scene.lights[0] = scene.lights[0].reversed());
    black(&|scene| scene.camera.target = scene.camera.eye + Vec3::new(0.0, 1.0, 0.1));
}

#[test]
fn light_that_only_one_half_has_met_is_all_noise() {
    // A lid under the light with a gap so narrow that few light samples are seen through it.
    let scene = scene("contact");
    let mut lid = scene.scene().clone();
    let (low, high) = lid.mesh.bounds().unwrap();
    let corner = lid.lights[0].corners()[0];
    let (y, gap) = (corner.y - 0.01, corner.x + 0.5);
    for (from, to) in [(low.x * 9.0, gap), (gap + 1e-3, high.x * 9.0)] {
        let start = lid.mesh.positions.len() as u32;
        let corners = [(from, low.z * 9.0), (from, high.z * 9.0), (to, high.z * 9.0), (to, low.z * 9.0)];
        let mesh = Arc::make_mut(&mut lid.mesh);
        mesh.positions.extend(corners.map(|(x, z)| Vec3::new(x, y, z)));
        mesh.uvs.extend([glam::Vec2::ZERO; 4]);
        mesh.triangles.extend([[start, start + 1, start + 2], [start, start + 2, start + 3]]);
        mesh.material_ids.extend([0; 2]);
    }
    let lid = PreparedScene::new(lid).unwrap();
    let mut one_sided = 0;
    for seed in 0..40 {
        let config = ReferenceConfig { width: 2, height: 2, seed, ..config(1) };
        let found = reference(&lid, &config, None, &mut |_, _| {}).unwrap();
        let lit = found.irradiance.iter().any(|&value| value != Vec3::ZERO);
        assert!(found.noise_nmse2.is_finite() && lit == (found.noise_nmse2 > 0.0), "{seed}: {found:?}");
        // The mean of light and no light is off by itself: an NMSE₂ of 1, but for the weights of the samples.
        one_sided += u32::from((0.8..1.25).contains(&found.noise_nmse2));
    }
    assert!(one_sided > 0, "no seed had light in one half alone");
}
