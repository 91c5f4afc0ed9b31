//! Backends are held against each other and against brute force, and a wrong bit is reported.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail their test")]

use std::path::Path;
use std::sync::Arc;

use halflight_core::frame::Frame;
use halflight_core::mask::MaskBatch;
use halflight_core::scene::Scene;
use halflight_core::stages::Visibility;
use halflight_cpu::bvh::Bvh;
use halflight_cpu::rays::BvhRays;
use halflight_lab::exactness::{Agreement, Backend, Settings, backends, check};

const SETTINGS: Settings = Settings { pairs: 30_000, brute_force: 3_000, seed: 1 };

fn soup() -> (Scene, Arc<Bvh>) {
    let text = halflight_scene::bundled().iter().find(|(name, _)| *name == "soup").unwrap().1;
    let text = text.replace("triangles = 100000", "triangles = 2000");
    let scene = halflight_scene::parse(&text, "soup.toml", Path::new("")).unwrap().scene;
    assert_eq!(scene.mesh.triangle_count(), 2000);
    let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
    (scene, bvh)
}

fn run(backends: &mut [Backend]) -> Vec<Agreement> {
    let (scene, bvh) = soup();
    check(&scene, &bvh, backends, &SETTINGS, |_| {}).unwrap()
}

#[test]
fn exact_backends_agree_on_a_soup() {
    let (scene, bvh) = soup();
    let mut told = 0;
    let found = check(&scene, &bvh, &mut backends(&bvh).unwrap(), &SETTINGS, |pairs| told += pairs).unwrap();
    let names: Vec<_> = found.iter().map(|agreement| agreement.name).collect();
    assert_eq!(names, ["raster4d", "beam", "auto", "brute force"]);
    assert!(found.iter().all(|agreement| agreement.different == 0), "{found:?}");
    assert!(found[0].pairs >= SETTINGS.pairs && found[3].pairs >= SETTINGS.brute_force, "{found:?}");
    // Jittered samples are for rays and beams only.
    assert!(found[1].pairs > found[0].pairs && found[2].pairs == found[1].pairs);
    assert_eq!(told, found.iter().map(|agreement| agreement.pairs).sum::<u64>());
}

#[test]
fn exact_backends_agree_on_alpha_masks() {
    let scene = halflight_scene::load_bundled("garden").unwrap().scene;
    let bvh = Arc::new(Bvh::build(&scene.mesh).unwrap());
    let found = check(&scene, &bvh, &mut backends(&bvh).unwrap(), &SETTINGS, |_| {}).unwrap();
    assert!(found.iter().all(|agreement| agreement.different == 0), "{found:?}");
    // Brute force notices when the leaves are solid for all backends.
    let mut solid = scene.clone();
    let mesh = Arc::make_mut(&mut solid.mesh);
    mesh.materials.iter_mut().for_each(|material| material.alpha_mask = None);
    let bvh = Arc::new(Bvh::build(&solid.mesh).unwrap());
    let pair = ["known", "same"].map(|name| (name, BvhRays::new(bvh.clone())));
    let mut pair = pair.map(|(name, rays)| Backend { name, visibility: Box::new(rays) });
    let found = check(&scene, &bvh, &mut pair, &SETTINGS, |_| {}).unwrap();
    assert!(found[0].different == 0 && found[1].different > 0, "{found:?}");
}

/// Says the opposite about one wanted sample of each batch, or about all.
struct Wrong {
    rays: BvhRays,
    all: bool,
}

impl Visibility for Wrong {
    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        self.rays.masks(frame, batch);
        let parts = batch.parts();
        for (&wanted, visible) in parts.wanted.iter().zip(parts.visible) {
            if self.all {
                *visible ^= wanted;
            } else if wanted != 0 {
                *visible ^= 1 << wanted.trailing_zeros();
                break;
            }
        }
    }
}

#[test]
fn wrong_bits_are_reported() {
    let (_, bvh) = soup();
    let rays = BvhRays::new(bvh);
    let right = || Backend { name: "bvh", visibility: Box::new(rays.clone()) };
    let wrong = |all| Backend { name: "wrong", visibility: Box::new(Wrong { rays: rays.clone(), all }) };
    let found = run(&mut [right(), wrong(false)]);
    // One bit for each of three patterns and of few images.
    assert!((3..=15).contains(&found[0].different) && found[0].different.is_multiple_of(3), "{found:?}");
    assert_eq!(found[1].different, 0, "{found:?}");
    // Brute force notices when all agree on what is wrong.
    let found = run(&mut [wrong(true), wrong(true)]);
    assert_eq!(found[0].different, 0, "{found:?}");
    assert_eq!(found[1].different, found[1].pairs, "{found:?}");
}

#[test]
fn a_view_without_light_is_refused() {
    let (mut scene, bvh) = soup();
    scene.lights[0] = scene.lights[0].transformed(|p| p.with_y(-1.0), |d| d);
    let fault = check(&scene, &bvh, &mut backends(&bvh).unwrap(), &SETTINGS, |_| {}).unwrap_err();
    assert!(fault.to_string().starts_with("nothing in view faces the light"), "{fault}");
}
