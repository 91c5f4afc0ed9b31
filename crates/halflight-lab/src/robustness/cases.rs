//! Cases: small scenes, each with one difficulty.

use glam::Vec3;
use halflight_core::alpha::AlphaMask;
use halflight_core::light::AreaLight;
use halflight_core::light_texture::LightTexture;
use halflight_core::scene::Scene;

use super::scenes::{Set, parallelogram, square_light};

/// Name of the case that all methods should find easy, and that the others are compared with.
pub const EASY: &str = "easy";

/// Width and height of most cases, pixels.
const SIZE: [u32; 2] = [128, 96];

/// Steps of the camera in [`Case::scenes`] where it moves, each this share of a pixel.
const STEP: f32 = 0.25;

/// Scene, or several that are seen one after the other, and the reference of their pictures.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name in tables and files.
    pub name: &'static str,
    /// Difficulty of the case, in a few words.
    pub title: &'static str,
    /// Image width and height, pixels.
    pub size: [u32; 2],
    /// Scene, or several, whose pictures are compared by how they change from one to the next.
    pub scenes: Vec<Scene>,
    /// Scene whose pictures must be equal, and whose reference is taken; `None` for the scene itself.
    pub like: Option<Scene>,
    /// Set for images that are too large for all methods.
    pub large: bool,
}

impl Case {
    fn new(name: &'static str, title: &'static str, set: Set) -> Self {
        Self { name, title, size: SIZE, scenes: vec![set.0], like: None, large: false }
    }

    /// Returns the easy scene at a size, seen at `fov_y_deg` degrees: wide images of few rows would see all of the horizon.
    fn sized(name: &'static str, title: &'static str, size: [u32; 2], fov_y_deg: f32) -> Self {
        let mut set = Set::blocker();
        // On the edge of the shadow, so that a single pixel has something to show.
        (set.0.camera.target, set.0.camera.fov_y_deg) = (Vec3::new(1.2, 0.0, 0.3), fov_y_deg);
        Self { size, ..Self::new(name, title, set) }
    }

    fn placed(name: &'static str, title: &'static str, scale: f32, offset: Vec3) -> Self {
        Self { like: Some(Set::blocker().0), ..Self::new(name, title, Set::blocker().placed(scale, offset)) }
    }
}

/// Returns all cases, the easy one first.
pub fn all() -> Vec<Case> {
    let mut cases = vec![
        Case::new(EASY, "a blocker over a floor: umbra, penumbra, open floor", Set::blocker()),
        Case::new("flat-field", "an open floor from above: must stay as flat as it is", flat_field()),
    ];
    cases.extend(thin());
    cases.extend(close());
    cases.extend(lights());
    cases.extend(spheres());
    cases.extend(images());
    cases.extend(places());
    cases.extend(sizes());
    cases
}

fn flat_field() -> Set {
    let camera = |set: Set| set.seen(Vec3::new(0.0, 9.0, 0.01), Vec3::ZERO);
    camera(Set::floor().light(square_light(Vec3::new(0.0, 10.0, 0.0), 2.0)))
}

/// Returns cases of receivers and occluders thinner than fragments, cells and voxels.
fn thin() -> [Case; 8] {
    // A pixel of the usual camera is 4 cm on the middle of the floor across the view and 8 cm along it.
    let mut strips = Set::bare();
    for index in 0..16 {
        let z = -3.0 + 0.3 * index as f32;
        strips = strips.quad(Vec3::new(-4.0, 0.0, z), Vec3::Z * 0.09, Vec3::X * 8.0);
    }
    let strips = strips.quad(Vec3::new(-0.7, 1.0, -0.7), Vec3::Z * 1.4, Vec3::X * 1.4);
    let line = Set::bare()
        .quad(Vec3::new(-4.0, 0.0, 0.0), Vec3::Z * 0.11, Vec3::X * 8.0)
        .quad(Vec3::new(-0.5, 1.0, -0.5), Vec3::Z, Vec3::X)
        .seen(Vec3::new(0.0, 3.0, 5.0), Vec3::ZERO);
    let mut stairs = Set::bare();
    for index in 0..24 {
        let (y, z) = (0.1 * index as f32, 1.8 - 0.15 * index as f32);
        stairs = stairs.quad(Vec3::new(-3.0, y - 0.1, z), Vec3::X * 6.0, Vec3::Y * 0.1).quad(
            Vec3::new(-3.0, y, z - 0.15),
            Vec3::Z * 0.15,
            Vec3::X * 6.0,
        );
    }
    let stairs = stairs
        .quad(Vec3::new(-0.6, 3.0, -1.0), Vec3::Z * 0.8, Vec3::X * 1.2)
        .light(square_light(Vec3::new(0.0, 6.0, 0.5), 1.0))
        .seen(Vec3::new(0.5, 3.5, 6.0), Vec3::new(0.0, 1.0, 0.0));
    let mut wires = Set::floor();
    for index in 0..12 {
        let z = -1.2 + 0.2 * index as f32;
        wires = wires.block(Vec3::new(-2.0, 1.0, z), Vec3::new(2.0, 1.008, z + 0.008));
    }
    let small_light = square_light(Vec3::new(0.0, 4.0, 0.0), 0.1);
    let mut railing = Set::floor();
    for index in 0..24 {
        let x = -1.8 + 0.15 * index as f32;
        railing = railing.block(Vec3::new(x, 0.1, 0.0), Vec3::new(x + 0.02, 1.0, 0.02));
    }
    let railing = railing
        .block(Vec3::new(-1.9, 0.08, -0.01), Vec3::new(1.8, 0.12, 0.03))
        .block(Vec3::new(-1.9, 1.0, -0.01), Vec3::new(1.8, 1.04, 0.03))
        .light(parallelogram(Vec3::new(0.0, 3.0, -3.0), Vec3::X * 1.2, Vec3::new(0.0, 0.5, 0.5)));
    let slit = Set::floor()
        .quad(Vec3::new(-6.0, 1.0, -6.0), Vec3::Z * 12.0, Vec3::X * 5.92)
        .quad(Vec3::new(0.08, 1.0, -6.0), Vec3::Z * 12.0, Vec3::X * 6.0)
        .seen(Vec3::new(0.2, 0.8, 2.5), Vec3::new(0.0, 0.0, 0.0));
    let mut blinds = Set::floor();
    for index in 0..40 {
        let x = -2.0 + 0.1 * index as f32;
        blinds = blinds.quad(Vec3::new(x, 1.2, -1.0), Vec3::Z * 2.0, Vec3::X * 0.06);
    }
    let small_shadow = Set::floor()
        .quad(Vec3::new(-0.15, 1.0, -0.15), Vec3::Z * 0.3, Vec3::X * 0.3)
        .light(square_light(Vec3::new(0.0, 4.0, 0.0), 0.5))
        .seen(Vec3::new(0.5, 3.0, 5.0), Vec3::new(0.0, 0.2, 0.0));
    [
        Case::new("small-shadow", "a shadow smaller than a coarse fragment, on an open floor", small_shadow),
        Case::new("strips", "receivers one pixel wide, with sky between them", strips),
        Case::new("line", "all receivers in one line of pixels: samples without an area", line),
        Case::new("stairs", "treads and risers a few pixels wide", stairs),
        Case::new("wires", "wires of 8 mm strung across a small light", wires.light(small_light)),
        Case::new("railing", "bars thinner than their penumbrae", railing),
        Case::new("slit", "two large occluders with a slit of 16 cm between them", slit),
        Case::new("blinds", "slats as wide as the gaps between them: half light everywhere", blinds),
    ]
}

/// Returns cases of contact, acne, leaks and occluders out of view.
fn close() -> [Case; 7] {
    let contact = Set::floor()
        .block(Vec3::new(-0.5, -0.01, -0.5), Vec3::new(0.5, 1.0, 0.5))
        .light(square_light(Vec3::new(-1.5, 3.0, -1.0), 1.0))
        .seen(Vec3::new(2.0, 1.5, 2.5), Vec3::new(0.4, 0.1, 0.3));
    let crease = Set::floor()
        .quad(Vec3::new(-5.0, 0.0, -1.0), Vec3::X * 10.0, Vec3::Y * 4.0)
        .quad(Vec3::new(-1.0, 0.0, -5.0), Vec3::Y * 4.0, Vec3::Z * 10.0)
        .block(Vec3::new(-0.98, 0.0, -0.98), Vec3::new(-0.5, 0.5, -0.5))
        .light(square_light(Vec3::new(-0.4, 3.0, 1.5), 0.8))
        .seen(Vec3::new(1.2, 1.2, 0.2), Vec3::new(-0.8, 0.2, -0.8));
    let acne = Set::bare()
        .quad(Vec3::new(-100.0, 0.0, -200.0), Vec3::Z * 210.0, Vec3::X * 200.0)
        .block(Vec3::new(-1.0, 0.0, -4.0), Vec3::new(-0.5, 1.5, -3.5))
        .light(square_light(Vec3::new(2.0, 5.0, -4.0), 1.0))
        .seen(Vec3::new(0.0, 1.6, 4.0), Vec3::new(0.0, 0.6, -4.0));
    let wall = Set::floor()
        .quad(Vec3::new(0.0, 0.0, -5.0), Vec3::Y * 3.0, Vec3::Z * 10.0)
        .light(square_light(Vec3::new(0.6, 2.5, 0.0), 1.0))
        .seen(Vec3::new(-1.5, 4.5, 5.0), Vec3::new(-0.5, 0.0, 0.0));
    let room = Set::floor()
        .quad(Vec3::new(-3.0, 2.0, -3.0), Vec3::Z * 6.0, Vec3::X * 6.0)
        .quad(Vec3::new(-3.0, 0.0, -3.0), Vec3::X * 6.0, Vec3::Y * 2.0)
        .quad(Vec3::new(-3.0, 0.0, -3.0), Vec3::Y * 2.0, Vec3::Z * 6.0)
        .quad(Vec3::new(3.0, 0.0, -3.0), Vec3::Z * 6.0, Vec3::Y * 2.0)
        .quad(Vec3::new(-3.0, 0.0, 3.0), Vec3::Y * 2.0, Vec3::X * 6.0)
        .seen(Vec3::new(0.0, 1.2, 2.5), Vec3::new(0.0, 0.4, -1.0));
    let out_of_view = Set::floor()
        .block(Vec3::new(-0.4, 2.4, -0.4), Vec3::new(0.4, 2.8, 0.4))
        .seen(Vec3::new(0.3, 1.5, 3.0), Vec3::new(0.0, 0.0, 0.0));
    let behind_the_eye = Set::floor()
        .block(Vec3::new(-1.0, 0.0, 4.0), Vec3::new(1.0, 2.4, 4.4))
        .light(square_light(Vec3::new(0.0, 4.0, 6.0), 1.0))
        .seen(Vec3::new(0.0, 2.0, 3.0), Vec3::new(0.0, 0.0, 0.0));
    [
        Case::new("contact", "a box on the floor: its shadow begins where they touch", contact),
        Case::new("crease", "a small box in a corner: three creases and a contact", crease),
        Case::new("acne", "a floor to the horizon, its voxels long and low", acne),
        Case::new("thin-wall", "a wall without thickness close to the light", wall),
        Case::new("leaks", "a closed room with the light outside: no light at all", room),
        Case::new("out-of-view", "the occluder is above the picture", out_of_view),
        Case::new("behind-the-eye", "occluder and light are behind the camera", behind_the_eye),
    ]
}

/// Returns cases of lights in awkward places and of awkward sizes, and receivers seen or lit at a glancing angle.
fn lights() -> [Case; 11] {
    let blocker_under = |light| Set::blocker().light(light);
    let posts_under = |light| {
        let post = |x, z| (Vec3::new(x, -0.01, z), Vec3::new(x + 0.3, 0.6, z + 0.3));
        let (front, side) = (post(-0.3, 0.2), post(0.5, -0.5));
        Set::floor().block(front.0, front.1).block(side.0, side.1).light(light)
    };
    let up = Vec3::Y;
    let tilted = parallelogram(Vec3::new(0.0, 0.0, -0.4), Vec3::new(0.7, 0.7, 0.0), Vec3::Z);
    let standing = parallelogram(Vec3::new(0.0, 1.5, -1.5), Vec3::X * 1.5, up);
    let upright = parallelogram(Vec3::new(0.0, 0.5, -0.8), Vec3::X, up);
    let below = parallelogram(Vec3::new(0.0, -2.0, 0.0), Vec3::Z, Vec3::X);
    let edge_on = parallelogram(Vec3::new(0.0, 2.0, 0.0), Vec3::Z, -up);
    let in_plane = Set::floor()
        .quad(Vec3::new(-3.0, 0.0, -1.5), Vec3::X * 6.0, up * 3.0)
        .block(Vec3::new(-0.8, 0.0, -0.8), Vec3::new(-0.3, 1.2, -0.3))
        .light(parallelogram(Vec3::new(0.0, 2.2, -1.5), Vec3::X, up));
    let glancing = Set::blocker().seen(Vec3::new(0.3, 0.12, 6.0), Vec3::new(0.0, 0.1, 0.0));
    let low_sun = Set::floor()
        .block(Vec3::new(-0.3, 0.0, -0.3), Vec3::new(0.3, 0.2, 0.3))
        .light(parallelogram(Vec3::new(-6.0, 0.5, 0.0), -Vec3::Z, up * 0.8));
    [
        Case::new("touching", "an upright light that stands on the floor", posts_under(upright)),
        Case::new("crossing", "the light passes through the floor", posts_under(tilted)),
        Case::new("behind", "the light shines from below the floor: no light at all", blocker_under(below)),
        Case::new(
            "inside",
            "the light is cut by the box that it lights",
            Set::floor()
                .block(Vec3::new(0.0, 0.0, -0.3), Vec3::new(0.6, 1.4, 0.3))
                .light(square_light(Vec3::new(0.0, 1.2, 0.0), 1.0)),
        ),
        Case::new(
            "edge-on",
            "an upright light whose plane cuts the blocker and the picture",
            blocker_under(edge_on),
        ),
        Case::new(
            "standing",
            "an upright light that looks at the camera, half of the floor behind it",
            blocker_under(standing),
        ),
        Case::new("in-plane", "a wall in the plane of the light", in_plane),
        Case::new(
            "small",
            "sides of 1/100: a point light, hard shadows",
            blocker_under(square_light(Vec3::new(0.0, 4.0, 0.0), 0.01)),
        ),
        Case::new(
            "large",
            "sides of 100 times: the whole sky",
            blocker_under(square_light(Vec3::new(0.0, 4.0, 0.0), 100.0)),
        ),
        Case::new("glancing", "the floor seen from 12 cm above it", glancing),
        Case::new("low-sun", "the floor lit from half a metre above it", low_sun),
    ]
}

/// Returns cases of sphere lights: around all receivers, around some, and cut by what they light.
fn spheres() -> [Case; 3] {
    let sphere = |centre, radius| AreaLight::sphere(centre, radius, Vec3::new(10.0, 9.0, 8.0));
    let post = |set: Set| set.block(Vec3::new(0.9, -0.01, -0.2), Vec3::new(1.2, 0.8, 0.1));
    let in_floor = post(Set::floor()).light(sphere(Vec3::new(0.0, 0.2, 0.0), 0.6));
    let on_stick = Set::floor()
        .block(Vec3::new(-0.05, 0.0, -0.05), Vec3::new(0.05, 1.0, 0.05))
        .light(sphere(Vec3::new(0.0, 1.0, 0.0), 0.25));
    let around = Set::blocker().light(sphere(Vec3::Y, 40.0));
    [
        Case::new("sphere-around", "a sphere light around everything: no shadow at all", around),
        Case::new(
            "sphere-in-floor",
            "a sphere light half in the floor: receivers inside it and outside",
            in_floor,
        ),
        Case::new("sphere-on-stick", "a sphere light on a post that ends in its middle", on_stick),
    ]
}

/// Returns cases of lights with textures, of disks, and of occluders with alpha masks.
fn images() -> Vec<Case> {
    let wire = || Set::floor().block(Vec3::new(-2.0, 1.0, -0.02), Vec3::new(2.0, 1.04, 0.02));
    let texels = |bright: Option<usize>| (0..64).map(move |at| if bright == Some(at) { 64.0 } else { 0.0 });
    let screen = |set: Set, bright| {
        let texture = LightTexture::new(8, 8, texels(bright).map(Vec3::splat).collect());
        // A light without its texture would be another case.
        texture.ok().map(|texture| set.textured(texture))
    };
    let disk = |normal| AreaLight::disk(Vec3::new(0.0, 2.0, 0.0), normal, 0.7, Vec3::splat(10.0));
    // Chequers of alphas just below and at a cutoff of one half.
    let alpha = (0..16u8).map(|at| 127 + (at + at / 4) % 2).collect::<Vec<_>>();
    let chequers = AlphaMask::new(4, 4, alpha.into_iter(), 0.5);
    let leaf = chequers
        .ok()
        .map(|mask| Set::floor().quad(Vec3::new(-0.8, 1.0, -0.8), Vec3::Z * 1.6, Vec3::X * 1.6).masked(mask));
    [
        screen(wire(), Some(27))
            .map(|set| ("bright-texel", "one bright texel of a black light behind a wire", set)),
        screen(Set::blocker(), None)
            .map(|set| ("black-texture", "a light with a black texture: no light at all", set)),
        Some((
            "disk-edge-on",
            "a disk whose plane cuts the blocker and the picture",
            Set::blocker().light(disk(Vec3::X)),
        )),
        leaf.map(|set| ("alpha-half", "an occluder of alphas 127 and 128 at a cutoff of one half", set)),
    ]
    .into_iter()
    .flatten()
    .map(|(name, title, set)| Case::new(name, title, set))
    .collect()
}

/// Returns the easy scene in other units and elsewhere, and a camera that creeps.
fn places() -> [Case; 6] {
    let steps = (0..5).map(|step| {
        let mut set = Set::blocker();
        let camera = &mut set.0.camera;
        let distance = camera.eye.distance(camera.target);
        let pixel = 2.0 * distance * (camera.fov_y_deg.to_radians() * 0.5).tan() / SIZE[1] as f32;
        let sideways = (camera.target - camera.eye).cross(camera.up).normalize_or_zero();
        camera.target += sideways * (STEP * pixel * step as f32);
        set.0
    });
    [
        Case::placed("scale-1e-3", "millimetres taken for metres", 1e-3, Vec3::ZERO),
        Case::placed("scale-1e2", "a hundred times as large", 1e2, Vec3::ZERO),
        Case::placed("scale-1e4", "ten thousand times as large", 1e4, Vec3::ZERO),
        Case::placed("moved-1e3", "1 km from the origin", 1.0, Vec3::splat(1e3)),
        Case::placed(
            "moved-1e5",
            "100 km from the origin, where coordinates are 8 mm apart",
            1.0,
            Vec3::splat(1e5),
        ),
        Case {
            scenes: steps.collect(),
            ..Case::new("steps", "the camera turns by a quarter of a pixel at a time", Set::blocker())
        },
    ]
}

fn sizes() -> [Case; 6] {
    [
        Case::sized("1x1", "an image of a single pixel", [1, 1], 0.5),
        Case::sized("1x97", "a single column", [1, 97], 50.0),
        Case::sized("97x1", "a single row", [97, 1], 0.7),
        Case::sized("2x2", "four pixels", [2, 2], 1.0),
        Case::sized("127x129", "one short of and one beyond the coarsest fragment", [127, 129], 50.0),
        Case {
            large: true,
            ..Case::sized("1279x961", "one short of and one beyond the papers' size", [1279, 961], 50.0)
        },
    ]
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn names_differ_and_the_easy_one_is_first() {
        let cases = all();
        let names: BTreeSet<&str> = cases.iter().map(|case| case.name).collect();
        assert_eq!((names.len(), cases[0].name), (cases.len(), EASY));
        // Textures and masks are what they were made of.
        assert_eq!(images().len(), 4);
    }

    #[test]
    fn every_mesh_is_valid_and_without_degenerate_triangles() {
        for case in all() {
            for scene in &case.scenes {
                scene.mesh.validate().unwrap();
                let area = |index| {
                    let [a, b, c] = scene.mesh.corners(index);
                    (b - a).cross(c - a).length()
                };
                assert!((0..scene.mesh.triangle_count()).all(|index| area(index) > 0.0), "{}", case.name);
            }
        }
    }
}
