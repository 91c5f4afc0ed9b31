//! Specular reflection in awkward cases: roughness 0 and 1, views at grazing angles, a bright texel behind a wire.

use anyhow::{Context as _, Result, bail};
use glam::Vec3;
use halflight_core::light_texture::LightTexture;
use halflight_core::scene::{Scene, Specular};
use halflight_cpu::config::{Named as _, PipelineConfig, Quality, RefinerConfig};
use halflight_cpu::prepared::PreparedScene;
use halflight_metrics::{Image, nmse2};
use std::sync::Arc;

use super::indirect::{Verdict, chosen};
use super::judge::sound;
use super::scenes::{Set, parallelogram, square_light};
use crate::reference::{ReferenceConfig, receivers, reference, seen};
use crate::results::{Provenance, Table};
use crate::run::Progress;

/// Start of the names of these cases.
pub const PREFIX: &str = "gloss-";

/// Width and height, pixels.
const SIZE: [u32; 2] = [96, 72];

/// Rays of each lobe of the references.
const RAYS: u32 = 4096;

/// Case: a floor and what is said, seen by every refiner.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name in tables.
    pub name: &'static str,
    /// Difficulty, in a few words.
    pub title: &'static str,
    scene: Scene,
}

/// Refiner in a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the case.
    pub case: &'static str,
    /// Difficulty of the case.
    pub title: &'static str,
    /// Name of the refiner; the lattice is at quality `good`, the others have 64 light samples.
    pub refiner: &'static str,
    /// Verdict.
    pub verdict: Verdict,
    /// √NMSE₂ of the radiance.
    pub error: f64,
    /// Largest specular radiance, W/m²/sr.
    pub brightest: f32,
}

/// Returns all cases.
pub fn cases() -> Vec<Case> {
    let metal = |roughness: f32| Specular { roughness, metallic: 1.0, ..Specular::default() };
    let coat = |roughness: f32| Specular { roughness, ..Specular::default() };
    let case = |name, title, mut set: Set, specular| {
        Arc::make_mut(&mut set.0.mesh).materials.iter_mut().for_each(|material| {
            (material.albedo, material.specular) = (Vec3::ONE, Some(specular));
        });
        Case { name, title, scene: set.0 }
    };
    // The light stands upright at the end of the floor, so that it is seen in it.
    let upright = parallelogram(Vec3::new(0.0, 1.2, -2.5), Vec3::X * 2.0, Vec3::Y * 1.0);
    let boxed = || Set::floor().block(Vec3::new(-0.75, 0.0, -1.5), Vec3::new(0.0, 0.5, -1.0)).light(upright);
    let along = |set: Set| set.seen(Vec3::new(0.0, 0.06, 4.0), Vec3::new(0.0, 0.0, 0.0));
    let mut texels = vec![Vec3::splat(0.01); 64 * 32];
    texels[20 * 64 + 37] = Vec3::splat(40.0);
    let texture = LightTexture::new(64, 32, texels);
    let wire = Set::floor().block(Vec3::new(-2.0, 0.6, -1.0), Vec3::new(2.0, 0.63, -0.97)).light(upright);
    let mut cases = vec![
        case("gloss-mirror", "a metal of roughness 0", boxed(), metal(0.0)),
        case("gloss-chalk", "a metal of roughness 1", boxed(), metal(1.0)),
        case(
            "gloss-grazing",
            "a coated floor of roughness 0.3, seen from 6 cm above it",
            along(boxed()),
            coat(0.3),
        ),
        case("gloss-grazing-smooth", "the same, roughness 0.05", along(boxed()), coat(0.05)),
        case(
            "gloss-overhead",
            "a metal of roughness 0.3 under a light that it reflects upwards",
            Set::blocker().light(square_light(Vec3::new(0.0, 4.0, 0.0), 1.0)),
            metal(0.3),
        ),
    ];
    if let Ok(texture) = texture {
        let set = wire.textured(texture);
        cases.push(case("gloss-texel", "one bright texel behind a wire, roughness 0.1", set, metal(0.1)));
    }
    cases
}

/// Renders and judges all cases, or the one of a name.
///
/// # Errors
/// No case has the name, a reference cannot be rendered, or a picture is not finite or negative.
pub fn run(name: Option<&str>, progress: &Progress) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for case in &chosen(cases(), name, |case| case.name)? {
        progress.now(case.name);
        rows.extend(judged(case, SIZE, RAYS)?);
    }
    Ok(rows)
}

/// Renders and judges all refiners in a case.
fn judged(case: &Case, [width, height]: [u32; 2], rays: u32) -> Result<Vec<Row>> {
    let scene = PreparedScene::new(case.scene.clone()).with_context(|| format!("scene {}", case.name))?;
    let config = ReferenceConfig { width, height, samples: rays, ..ReferenceConfig::default() };
    let truth = reference(&scene, &config, None, &mut |_, _| {})?.radiance;
    let mask = receivers(&seen(&scene, [width, height]));
    let refiners = RefinerConfig::all().into_iter().map(|refiner| match refiner {
        RefinerConfig::Lattice(_) => RefinerConfig::Lattice(Quality::Good.lattice()),
        other => other,
    });
    refiners
        .map(|refiner| {
            let named = || format!("{}, {}", case.name, refiner.name());
            let upsampler = refiner.upsampler();
            let config = PipelineConfig { width, height, refiner, upsampler, ..PipelineConfig::default() };
            let mut pipeline = config.builder(&scene).build().with_context(named)?;
            let image = pipeline.render().with_context(named)?;
            for layer in [&image.radiance, &image.specular] {
                if let Err(fault) = sound(layer, width) {
                    bail!("{}: {fault}", named());
                }
            }
            let view =
                |pixels| -> Result<Image<'_>> { Ok(Image::new(width, height, pixels)?.with_mask(&mask)?) };
            let error = nmse2(view(&image.radiance)?, view(&truth)?).with_context(named)?.sqrt();
            let verdict = Verdict::of_error(error);
            let brightest = image.specular.iter().map(|light| light.max_element()).fold(0.0, f32::max);
            let &Case { name, title, .. } = case;
            Ok(Row { case: name, title, refiner: refiner.name(), verdict, error, brightest })
        })
        .collect()
}

/// Returns a table with a line for each row.
pub fn table(rows: &[Row], provenance: &Provenance) -> Table {
    let line = |row: &Row| {
        [
            row.case.to_string(),
            row.title.to_string(),
            row.refiner.to_string(),
            row.verdict.to_string(),
            format!("{:.4}", row.error),
            format!("{:.4}", row.brightest),
            provenance.commit.clone(),
            provenance.machine.clone(),
        ]
    };
    let columns =
        ["case", "difficulty", "refiner", "verdict", "relative_error", "brightest", "commit", "machine"];
    Table::new(columns, rows.iter().map(line))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(name: &str) -> Vec<Row> {
        let case = cases().into_iter().find(|case| case.name == name).unwrap();
        judged(&case, [48, 36], 1024).unwrap()
    }

    #[test]
    fn a_mirror_shows_the_light_as_bright_as_it_is() {
        for row in rows("gloss-mirror") {
            // Reflectance 1 at every angle; the light's largest channel is 10.
            assert!((row.brightest - 10.0).abs() < 0.1, "{row:?}");
            assert_ne!(row.verdict, Verdict::Fails, "{row:?}");
        }
    }

    #[test]
    fn every_refiner_renders_every_case() {
        let refiners = RefinerConfig::all().len();
        for case in cases() {
            let rows = rows(case.name);
            assert!(rows.len() == refiners && case.name.starts_with(PREFIX));
            let exact = rows.iter().find(|row| row.refiner == "per-pixel").unwrap();
            assert!(exact.verdict == Verdict::Pass && exact.brightest > 0.01, "{exact:?}");
            assert_eq!(table(&rows, &Provenance::default()).lines.len(), refiners);
        }
        let fault = run(Some("gloss-nothing"), &Progress::hidden()).unwrap_err().to_string();
        assert!(fault.contains("`gloss-nothing`"), "{fault}");
    }
}
