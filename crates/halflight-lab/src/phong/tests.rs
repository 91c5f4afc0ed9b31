//! Lobes, grids and variance where the answer is known, and the whole pass against converged lobes.

use glam::Vec3;
use halflight_core::specular::SurfaceSpecular;
use halflight_cpu::prepared::PreparedScene;

use super::gather::Grid;
use super::lobe::Lobe;
use super::variance::{blurred, visible};
use super::*;

fn scene(text: &str) -> PreparedScene {
    PreparedScene::new(halflight_scene::parse(text, "floor.toml", ".".as_ref()).unwrap().scene).unwrap()
}

/// A glossy floor under a light, with a box on it where `generator` is `contact`.
fn floor(generator: &str, roughness: f32, keys: &str) -> PreparedScene {
    scene(&format!(
        "[camera]\neye = [0, 2, 6]\ntarget = [0, 0.5, 0]\nfov_y_deg = 45\n\
         [[light]]\ncorner = [-1, 1, -3]\nedge_u = [0, 1.5, 0]\nedge_v = [2, 0, 0]\nradiance = [10, 10, 10]\ntwo_sided = true\n{keys}\n\
         [[mesh]]\ngenerator = \"{generator}\"\nroughness = {roughness}\nreflectance = [0.5, 0.5, 0.5]\n"
    ))
}

const SIZE: [u32; 2] = [96, 72];

/// Relative difference of two images: root of squares over root of squares.
fn difference(found: &[Vec3], expected: &[Vec3]) -> f32 {
    let squares = |values: &mut dyn Iterator<Item = Vec3>| values.map(Vec3::length_squared).sum::<f32>();
    let off = squares(&mut found.iter().zip(expected).map(|(a, b)| *a - *b));
    (off / squares(&mut expected.iter().copied())).sqrt()
}

fn pixels(change: impl Fn(&mut PhongConfig)) -> PhongConfig {
    let mut config =
        PhongConfig { coarsest_level: 0, visibility: LobeVisibility::None, ..PhongConfig::default() };
    change(&mut config);
    config
}

#[test]
fn lobes_are_normalised() {
    let view = Vec3::new(0.3, 0.8, 0.1).normalize();
    for roughness in [0.2, 0.4, 0.7] {
        let lobe = Lobe::new(Vec3::Y, view, &SurfaceSpecular { f0: Vec3::ONE, roughness });
        // Midpoints of rings and spokes around the mirrored direction.
        let (right, up) = lobe.mirrored.any_orthonormal_pair();
        let (rings, spokes) = (4000, 64);
        let mut sum = 0.0f64;
        for ring in 0..rings {
            let angle = (ring as f32 + 0.5) / rings as f32 * std::f32::consts::FRAC_PI_2;
            for spoke in 0..spokes {
                let (s, c) = ((spoke as f32 + 0.5) / spokes as f32 * std::f32::consts::TAU).sin_cos();
                let to = lobe.mirrored * angle.cos() + (right * c + up * s) * angle.sin();
                let part = angle.sin() * std::f32::consts::FRAC_PI_2 * std::f32::consts::TAU;
                sum += f64::from(lobe.reflected(to) * part / (rings * spokes) as f32);
            }
        }
        // The mirrored direction's cosine stands for those of the whole lobe: for narrow lobes all but exactly; the widest one loses at the horizon.
        let off = sum as f32 / lobe.whole() - 1.0;
        assert!(off.abs() < if roughness > 0.5 { 0.2 } else { 0.03 }, "{roughness}: {off}");
        let edge = (lobe.mirrored + right * lobe.reach(0.1)).normalize();
        assert!((lobe.power(edge) - 0.1).abs() < 1e-3);
    }
}

#[test]
fn variance_of_two_distances_is_the_share_of_the_far_one() {
    assert_eq!(visible(1.0, 1.0, 1e-6), 1.0);
    // All are hidden at one distance: only the least variance is left.
    assert!(visible(0.4, 0.16, 1e-6) < 1e-5);
    for share in [0.25f32, 0.5, 0.75] {
        let (mean, square) = (share + (1.0 - share) * 0.4, share + (1.0 - share) * 0.16);
        assert!((visible(mean, square, 1e-6) - share).abs() < 1e-4, "{share}");
    }
    let grid = |part: f32| Grid { light: vec![Vec3::ONE; 2], parts: vec![part, -1.0] };
    let seen = blurred([grid(1.0), grid(0.4)].iter(), 2, 1e-6);
    // The second sample was never traced and takes what the first one has.
    assert!((seen[0] - 0.5).abs() < 1e-4 && seen[1] == seen[0], "{seen:?}");
}

#[test]
fn light_samples_and_grids_reflect_what_the_lobe_does() {
    for (roughness, few, bound) in [
        // A wide lobe by 1,024 light samples; narrow ones by grids of 8 × 8, whose directions at the edge of the light are in or out: a tenth of a lobe there, where
        // half of it is seen.
        (0.6, 0, 0.03),
        (0.3, 5000, 0.2),
        (0.2, 5000, 0.2),
    ] {
        for keys in ["", "texture_generator = \"checkerboard\"\ntexture_stretch = true"] {
            let scene = floor("open-floor", roughness, keys);
            let mut surfaces = Surfaces::new(&scene, SIZE, 0);
            let expected = truth(&surfaces, 4096, LobeVisibility::None, 1).unwrap();
            let config = pixels(|config| {
                (config.samples, config.few, config.grid, config.lobe_edge) = (1024, few, 8, 0.03);
            });
            let found = surfaces.render(&config).unwrap();
            let off = difference(&found.radiance, &expected);
            assert!(off < bound, "{roughness} {keys}: {off}");
            assert_eq!(found.sampled > 0, few > 0);
        }
    }
}

#[test]
fn few_light_samples_show_themselves_and_grids_do_not() {
    let scene = floor("open-floor", 0.1, "");
    let mut surfaces = Surfaces::new(&scene, SIZE, 0);
    let expected = truth(&surfaces, 1024, LobeVisibility::None, 1).unwrap();
    let mut off = |few| {
        let config = pixels(|config| config.few = few);
        difference(&surfaces.render(&config).unwrap().radiance, &expected)
    };
    let (dots, smooth) = (off(0), off(9));
    assert!(dots > 2.0 * smooth && smooth < 0.25, "{dots} {smooth}");
}

#[test]
fn what_is_discarded_is_dark() {
    let scene = floor("open-floor", 0.3, "");
    let mut surfaces = Surfaces::new(&scene, SIZE, 0);
    let all = surfaces.render(&pixels(|config| config.cull = false)).unwrap();
    let peak = all.radiance.iter().map(|v| v.x).fold(0.0, f32::max);
    let mut lost = |cull_outline| {
        let culled = surfaces.render(&pixels(|config| config.cull_outline = cull_outline)).unwrap();
        assert!(culled.discarded * 3 > culled.glossy && all.discarded == 0, "{}", culled.discarded);
        assert!(culled.rendered[0] + culled.discarded == culled.glossy && all.rendered[0] == all.glossy);
        let pairs = culled.radiance.iter().zip(&all.radiance).filter(|(kept, whole)| kept != whole);
        pairs.map(|(kept, whole)| (whole.x - kept.x) / peak).fold(0.0, f32::max)
    };
    // (R·L)ⁿ is below a hundredth everywhere on the light. Towards the corners alone it says nothing of the middles of the edges.
    let (outline, corners) = (lost(true), lost(false));
    assert!(outline < 0.03 && corners > 0.1, "{outline} {corners}");
}

#[test]
fn lobes_narrower_than_fragments_split_them() {
    // Pixels of a fragment that is not discarded, in the mean.
    let size = |roughness: f32, spacing: f32| {
        let scene = floor("open-floor", roughness, "");
        let config = PhongConfig { spacing, visibility: LobeVisibility::None, ..PhongConfig::default() };
        let found = Surfaces::new(&scene, SIZE, 0).render(&config).unwrap();
        (found.glossy - found.discarded) as f32 / found.rendered.iter().sum::<u64>() as f32
    };
    let (wide, narrow, unchecked) = (size(0.6, 0.25), size(0.2, 0.25), size(0.2, 0.0));
    assert!(wide > 2.0 * narrow && unchecked > 4.0 * narrow && narrow < 2.0, "{wide} {narrow} {unchecked}");
}

#[test]
fn shadows_of_the_variance_are_those_of_exact_visibility() {
    let scene = floor("contact", 0.3, "");
    let mut surfaces = Surfaces::new(&scene, SIZE, 0);
    let expected = truth(&surfaces, 1024, LobeVisibility::Binary, 1).unwrap();
    let mut rendered = |visibility, blur, interleaved| {
        let config = pixels(|config| {
            (config.visibility, config.few) = (visibility, 5000);
            (config.blur, config.interleaved) = (blur, interleaved);
        });
        surfaces.render(&config).unwrap().radiance
    };
    let none = difference(&rendered(LobeVisibility::None, 0, false), &expected);
    let binary = rendered(LobeVisibility::Binary, 0, false);
    // Without a blur there is no variance: samples are seen or not, but for one of 25.
    let sharp = difference(&rendered(LobeVisibility::Variance, 0, false), &binary);
    let off = difference(&binary, &expected);
    assert!(sharp < 0.1 && off < 0.4 && none > 4.0 * off, "{sharp} {off} {none}");
    // The blur goes over two pixels, across edges as well; what it mixes is far less than what shadows take away.
    let blurred = difference(&rendered(LobeVisibility::Variance, 2, true), &expected);
    assert!(none > 3.0 * blurred, "{none} {blurred}");
}

#[test]
fn threads_do_not_matter_and_constants_are_checked() {
    let scene = floor("contact", 0.3, "");
    let rendered = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Surfaces::new(&scene, SIZE, 0).render(&PhongConfig::default()).unwrap().radiance)
    };
    assert_eq!(rendered(1), rendered(3));
    PhongConfig::default().check().unwrap();
    for (config, words) in [
        (PhongConfig { grid: 9, ..PhongConfig::default() }, "grid = 9: expected 1 to 8"),
        (PhongConfig { samples: 0, ..PhongConfig::default() }, "samples = 0: expected 1 to 4096"),
        (PhongConfig { lobe_edge: 1.0, ..PhongConfig::default() }, "lobe_edge = 1"),
        (PhongConfig { least_variance: f32::NAN, ..PhongConfig::default() }, "least_variance = NaN"),
    ] {
        let fault = config.check().unwrap_err();
        assert!(fault.contains(words), "{fault}");
    }
}
