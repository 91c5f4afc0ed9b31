//! Invariants of all generators: counts, determinism, valid geometry, solids wound outwards, clear errors.

use std::collections::{HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};

use glam::{Vec2, Vec3};
use halflight_core::light::LightFrame;
use halflight_core::scene::Mesh;

use super::bars::{bar, rod};
use super::builder::Builder;
use super::columns::{Detail, baluster, pot};
use super::shapes::{arch, groin_vault, rectangle, swept, tube, vault_section};
use super::{generate, names};

fn mesh(name: &str, parameters: &str) -> Mesh {
    generate(name, parameters.parse().unwrap()).unwrap()
}

fn message(name: &str, parameters: &str) -> String {
    generate(name, parameters.parse().unwrap()).unwrap_err().to_string()
}

fn bits(p: Vec3) -> [u32; 3] {
    // Adding zero turns -0 into 0, an equal position.
    (p + 0.0).to_array().map(f32::to_bits)
}

fn hash(mesh: &Mesh) -> u64 {
    let mut hasher = DefaultHasher::new();
    mesh.positions.iter().chain(&mesh.normals).for_each(|&p| bits(p).hash(&mut hasher));
    (&mesh.triangles, &mesh.material_ids).hash(&mut hasher);
    hasher.finish()
}

/// Reason for which a mesh cannot be rendered, or none.
fn fault(mesh: &Mesh) -> Option<String> {
    if let Err(error) = mesh.validate() {
        return Some(error.to_string());
    }
    let mut seen = HashSet::new();
    for index in 0..mesh.triangle_count() {
        let corners = mesh.corners(index);
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        // The builder drops what is flatter than 1e-5 of its longest side; parts are then moved, which rounds
        // coordinates up to 100 m to 4e-6 m, so that the thinnest may come out a little flatter.
        if (b - a).cross(c - a).length() <= 2e-6 * longest {
            return Some(format!("triangle {index} has no area: {corners:?}"));
        }
        let mut key = corners.map(bits);
        key.sort_unstable();
        if !seen.insert(key) {
            return Some(format!("triangle {index} is there twice: {corners:?}"));
        }
    }
    // Normalising in single precision is off by a few units in the last place.
    let bad = mesh.normals.iter().position(|n| (n.length() - 1.0).abs() > 1e-5)?;
    Some(format!("normal {bad} is {}", mesh.normals[bad]))
}

/// Volume inside a closed mesh, positive when it is wound outwards.
fn volume(mesh: &Mesh) -> f32 {
    (0..mesh.triangle_count()).map(|i| mesh.corners(i)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

#[test]
fn triangle_counts_are_like_the_papers() {
    // Sponza 66,454, Sibenik 75,284, and the scenes of Wang 2017, section 4: within 3 %, which no timing
    // would notice.
    for (name, expected) in [
        ("atrium", 66_454.0),
        ("nave", 75_284.0),
        ("tree", 367_000.0),
        ("tower", 514_000.0),
        ("toys", 263_000.0),
        ("coaster", 1_096_000.0),
        ("church", 240_000.0),
    ] {
        let count = mesh(name, "").triangle_count() as f32;
        assert!((count / expected - 1.0).abs() < 0.03, "{name} has {count} triangles instead of {expected}");
    }
    for triangles in [1_000, 1_001, 25_000, 99_999, 300_000] {
        let count = mesh("hairball", &format!("triangles = {triangles}")).triangle_count();
        // One more ring of a three-sided tube is six triangles.
        assert!(triangles - count < 6, "{count} triangles instead of {triangles}");
    }
    // The last bar, the last toy, the last ring of both rails: at most a hundredth of the smallest mesh.
    for (name, counts) in [
        ("tower", [10_000, 31_000, 100_000, 3_000_000]),
        ("toys", [10_000, 31_000, 100_000, 3_000_000]),
        ("coaster", [100_000, 200_000, 500_000, 3_000_000]),
        ("soup", [100, 1_001, 31_000, 300_000]),
    ] {
        for triangles in counts {
            let count = mesh(name, &format!("triangles = {triangles}")).triangle_count();
            assert!(count.abs_diff(triangles) <= 100, "{name}: {count} triangles instead of {triangles}");
        }
    }
}

#[test]
fn every_mesh_is_valid_and_the_same_each_time() {
    for &name in names() {
        let first = mesh(name, "");
        assert_eq!(fault(&first), None, "{name}");
        assert_eq!(hash(&first), hash(&mesh(name, "")), "{name}");
    }
    for (name, parameters) in [
        ("atrium", "detail = 0.25"),
        ("atrium", "detail = 2"),
        ("nave", "detail = 0.25"),
        ("nave", "detail = 2"),
        ("hairball", "triangles = 1000\nthickness = 0.1"),
        ("tree", "leaves = 0"),
        ("tower", "triangles = 10000"),
        ("toys", "triangles = 10000"),
        ("toys", "seed = 2"),
        ("coaster", "triangles = 100000"),
        ("church", "detail = 0.25"),
        ("church", "detail = 2"),
        ("soup", "triangles = 100"),
        ("soup", "triangles = 300000\nseed = 2"),
        ("railing", "bars = 2\nlength = 0.5\nthickness = 0.2"),
        ("contact", "width = 0.001\nheight = 100"),
        ("garden", "leaves = 20"),
        ("garden", "seed = 2"),
        ("living-room", "seed = 2"),
    ] {
        let other = mesh(name, parameters);
        assert_eq!(fault(&other), None, "{name} with {parameters}");
        assert_ne!(hash(&other), hash(&mesh(name, "")), "{name} with {parameters}");
    }
    assert_ne!(hash(&mesh("hairball", "seed = 1")), hash(&mesh("hairball", "seed = 2")));
}

/// Number of edges with more triangles on one side than on the other; the floor at y = 0 is left out.
fn open_edges(mesh: &Mesh) -> usize {
    let mut balance: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
    for corners in (0..mesh.triangle_count()).map(|i| mesh.corners(i)) {
        if corners.iter().all(|p| p.y == 0.0) {
            continue;
        }
        let [a, b, c] = corners.map(bits);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (key, sign) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
            *balance.entry(key).or_default() += sign;
        }
    }
    balance.values().filter(|&&balance| balance != 0).count()
}

#[test]
fn every_part_is_closed() {
    for (name, parameters) in [
        ("tower", "triangles = 10000"),
        ("tower", "triangles = 100000"),
        ("toys", "triangles = 10000"),
        ("toys", ""),
        ("coaster", "triangles = 100000"),
    ] {
        let mut mesh = mesh(name, parameters);
        assert_eq!(open_edges(&mesh), 0, "{name} with {parameters}");
        mesh.triangles.pop();
        mesh.material_ids.pop();
        assert_eq!(open_edges(&mesh), 3, "{name} with {parameters}");
    }
}

#[test]
fn faults_are_noticed() {
    let good = mesh("contact", "");
    let mut flat = good.clone();
    flat.triangles[3][1] = flat.triangles[3][0];
    assert!(fault(&flat).unwrap().contains("no area"));
    let mut twice = good.clone();
    twice.triangles[4] = twice.triangles[5];
    assert!(fault(&twice).unwrap().contains("twice"));
    let mut long = good;
    long.normals[2] *= 1.1;
    assert!(fault(&long).unwrap().contains("normal 2"));
}

#[test]
fn solids_are_closed_and_wound_outwards() {
    let close = |found: f32, expected: f32, tolerance: f32| {
        assert!((found / expected - 1.0).abs() < tolerance, "volume {found} instead of {expected}");
    };
    let mut block = Builder::new();
    block.block(Vec3::new(3.0, -1.0, 2.0), Vec3::new(2.0, 3.0, 4.0));
    // Rounding only.
    close(volume(&block.finish(&[])), 24.0, 1e-5);

    let mut slanting = Builder::new();
    bar(&mut slanting, [Vec3::ZERO, Vec3::new(2.0, 1.0, 2.0)], Vec3::Y, [0.5, 0.2]);
    close(volume(&slanting.finish(&[])), 3.0 * 0.5 * 0.2, 1e-5);

    let mut round = Builder::new();
    rod(&mut round, [Vec3::ZERO, Vec3::new(2.0, 1.0, 2.0)], 0.5, 64);
    // A circle has 0.16 % more area than its inscribed 64-gon.
    close(volume(&round.finish(&[])), 3.0 * 0.25 * std::f32::consts::PI, 2e-3);

    let mut straight = Builder::new();
    let path = [(0.0, 0.0), (0.0, 0.5), (4.0, 0.5), (4.0, 0.0)].map(|(x, radius)| (Vec3::X * x, radius));
    tube(&mut straight, &path, 64);
    // A circle has 0.16 % more area than its inscribed 64-gon.
    close(volume(&straight.finish(&[])), 0.25 * std::f32::consts::PI * 4.0, 2e-3);

    let mut frame = Builder::new();
    let path =
        [[0.0, 0.0], [0.0, 3.0], [2.0, 3.0], [2.0, 0.0], [0.0, 0.0]].map(|[x, z]| Vec3::new(x, 0.0, z));
    swept(&mut frame, &rectangle(0.5, -0.1, 0.1), &path, Vec3::Y);
    // Mitred, the frame is as long as its middle line: 10 × 0.5 × 0.2. Rounding only.
    close(volume(&frame.finish(&[])), 1.0, 1e-5);

    // Turned shapes without a disc at the foot: it is at y = 0 and adds nothing to the sum.
    for part in [pot(1.0, 24.0, Detail(1.0)), baluster(1.0, Detail(1.0))] {
        assert!(volume(&part.finish(&[])) > 0.0);
    }
}

#[test]
fn leaves_of_the_garden_have_holes() {
    let garden = mesh("garden", "");
    let masked = (0..garden.triangle_count()).filter(|&index| garden.alpha_mask(index).is_some());
    assert_eq!(masked.count(), 2400);
    let solid: u32 = garden.alpha_masks[0].words().iter().map(|word| word.count_ones()).sum();
    let share = solid as f32 / (64.0 * 64.0);
    assert!((0.2..0.6).contains(&share), "{share} of a leaf is solid");
    assert!(garden.uvs.iter().all(|uv| uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all()));
}

#[test]
fn halls_stand_upright() {
    // A floor is seen from above and a vault from below, wherever the camera is.
    for name in names() {
        let mesh = mesh(name, "");
        let floor = (0..mesh.triangle_count())
            .map(|i| mesh.corners(i))
            .filter(|corners| corners.iter().all(|p| p.y == 0.0))
            .map(|[a, b, c]| (b - a).cross(c - a).normalize());
        let mut area = 0;
        for normal in floor {
            // Furniture has undersides that lie in the floor, as in most models of rooms.
            let upright =
                normal.y > 0.999 || ["furnished", "living-room"].contains(name) && normal.y < -0.999;
            assert!(upright, "{name} has a floor that faces {normal}");
            area += usize::from(normal.y > 0.0);
        }
        assert!(area > 0, "{name} has no floor");
    }
    let mut vault = Builder::new();
    groin_vault(&mut vault, Vec2::new(2.0, 3.0), 2.5, 8);
    assert!(vault.finish(&[]).normals.iter().all(|normal| normal.y < 1e-6 || *normal == Vec3::Y));
}

#[test]
fn all_kinds_are_furnished() {
    for kind in super::furnished::KINDS {
        let mut hashes = HashSet::new();
        for seed in 0..8 {
            let mesh = mesh("furnished", &format!("kind = '{kind}'\nseed = {seed}\nwalls = {}", seed % 5));
            assert_eq!(fault(&mesh), None, "{kind} {seed}");
            assert!(
                (100..40_000).contains(&mesh.triangle_count()),
                "{kind} {seed}: {}",
                mesh.triangle_count()
            );
            hashes.insert(hash(&mesh));
        }
        assert_eq!(hashes.len(), 8, "{kind}");
    }
    let error = message("furnished", "kind = 'kitchen'");
    assert!(
        error
            .starts_with("parameter `kind` of generator `furnished` is \"kitchen\", expected one of objects"),
        "{error}"
    );
}

#[test]
fn bundled_lights_face_what_the_camera_looks_at() {
    for (name, _) in crate::bundled() {
        let scene = crate::load_bundled(name).unwrap().scene;
        for light in &scene.lights {
            assert!(light.emits_towards(scene.camera.target), "{name}");
            // A light in a wall or a beam would be half dark: no geometry may cross it, so no corner of a
            // triangle may lie between its edges and within a hand's breadth of its plane.
            let (normal, LightFrame { origin, u, v }) = (light.normal(), light.frame());
            let near = scene.mesh.positions.iter().find(|&&p| {
                let from = p - origin;
                let along = |edge: Vec3| from.dot(edge) / edge.length_squared();
                from.dot(normal).abs() < 0.1 && [u, v].iter().all(|&edge| (0.0..=1.0).contains(&along(edge)))
            });
            assert_eq!(near, None, "{name}");
        }
    }
}

#[test]
fn arches_span_what_they_are_asked_to() {
    for (half, rise) in [(1.0, 1.0), (2.0, 3.0), (3.0, 1.0), (0.5, 5.0)] {
        let points = arch(half, rise, 6);
        // Rounding of the circle's sine and cosine.
        let tolerance = 1e-5 * (half + rise);
        assert!(points[0].distance(Vec2::new(-half, 0.0)) < tolerance);
        assert!(points[6].distance(Vec2::new(0.0, rise)) < tolerance);
        assert!(points[12].distance(Vec2::new(half, 0.0)) < tolerance);
        assert!(points.windows(2).all(|pair| pair[0].x < pair[1].x));
        let section = vault_section(Vec2::new(half, 0.5 * half), rise, 6);
        assert!(section.iter().zip(&points).all(|(a, b)| (a.x * half - b.x).abs() < tolerance && a.y == b.y));
    }
}

#[test]
fn wrong_parameters_are_refused() {
    assert_eq!(
        message("castle", ""),
        "unknown generator `castle`; known are atrium, church, coaster, contact, furnished, gallery, garden, hairball, \
         half-plane, living-room, nave, open-floor, railing, soup, tower, toys, tree"
    );
    assert_eq!(
        message("hairball", "triangels = 5"),
        "generator `hairball` has no parameter `triangels`; it has triangles, thickness, seed"
    );
    assert_eq!(
        message("hairball", "triangles = 999"),
        "parameter `triangles` of generator `hairball` is 999, expected a whole number from 1000 to 2850000"
    );
    assert_eq!(
        message("hairball", "triangles = -1"),
        "parameter `triangles` of generator `hairball` is -1, expected a whole number from 1000 to 2850000"
    );
    assert_eq!(
        message("atrium", "detail = \"fine\""),
        "parameter `detail` of generator `atrium` is \"fine\", expected a number from 0.25 to 4"
    );
    for value in ["nan", "inf", "1e300", "-1", "true", "[1]"] {
        assert!(
            message("nave", &format!("detail = {value}")).contains("expected a number from 0.25 to 4"),
            "{value}"
        );
    }
    // The bars may not close the gap between the rails.
    assert!(message("railing", "height = 0.5\nthickness = 0.2").contains("from 0.0001 to 0.1"));
}
