//! Specular passes of a setting, timed and measured against converged lobes.

use std::f32::consts::PI;
use std::path::Path;

use anyhow::{Context as _, Result, anyhow, bail};
use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_image::picture;
use halflight_metrics::{Image, halves_noise, nmse2, write_png};

use super::loaded::Loaded;
use super::progress::Progress;
use super::timing::median;
use crate::experiment::Experiment;
use crate::experiment::plan::{self, Setting};
use crate::phong::{DISCARDED, LobeVisibility, NOT_RENDERED, Surfaces, truth};
use crate::results::{Provenance, SpecularRow};

/// Colours of pixels in discarded fragments, and of matte surfaces.
const COLORS: [[u8; 3]; 2] = [[96, 16, 16], [60, 60, 64]];

/// Converged image and the NMSE₂ that its noise makes.
struct Converged {
    radiance: Vec<Vec3>,
    noise: f64,
}

/// Renders and measures all specular passes in a setting, and writes their pictures.
pub(super) fn measure(
    experiment: &Experiment,
    out: &Path,
    setting: &Setting,
    loaded: &Loaded,
    provenance: &Provenance,
    progress: &Progress,
) -> Result<Vec<SpecularRow>> {
    let folder = out.join("pictures").join(&setting.slug);
    fs_err::create_dir_all(&folder)?;
    let scene = loaded.lit(setting.light_scale)?;
    let mut surfaces = Surfaces::new(&scene, setting.size, experiment.seed);
    let [width, height] = setting.size;
    let glossy: Vec<bool> = surfaces
        .gbuffer()
        .specular
        .iter()
        .enumerate()
        .map(|(pixel, surface)| surfaces.gbuffer().is_receiver(pixel) && !surface.is_matte())
        .collect();
    if !glossy.contains(&true) {
        bail!("{}: specular needs a scene with glossy surfaces, and none is seen", setting.label);
    }
    let compared = |found: &[Vec3], expected: &[Vec3]| -> Result<f64> {
        Ok(nmse2(masked(found, setting.size, &glossy)?, masked(expected, setting.size, &glossy)?)?)
    };
    let count = experiment.reference_of(setting).samples.div_ceil(2);
    let seed = experiment.reference.seed;
    let converged = |visibility| -> Result<Converged> {
        progress.now(format!("{}: converged lobes, 2 × {count} directions a pixel", setting.label));
        let halves = [seed, seed.wrapping_add(1)].map(|seed| truth(&surfaces, count, visibility, seed));
        let [first, second] = halves;
        let (first, second) = (first?, second?);
        let radiance: Vec<Vec3> = first.iter().zip(&second).map(|(a, b)| (*a + *b) * 0.5).collect();
        if radiance.iter().all(|value| *value == Vec3::ZERO) {
            bail!("{}: no glossy surface reflects a light", setting.label);
        }
        let noise =
            halves_noise(masked(&first, setting.size, &glossy)?, masked(&second, setting.size, &glossy)?)?;
        Ok(Converged { radiance, noise })
    };
    let (open, seen) = (converged(LobeVisibility::None)?, converged(LobeVisibility::Binary)?);
    write_png(&folder.join("specular-reference.png"), width, height, &tone_mapped(&seen.radiance))?;
    let mut rows = Vec::new();
    for choice in plan::specular(experiment).map_err(|message| anyhow!("{message}"))? {
        progress.now(format!("{}: {}", setting.label, choice.label));
        let mut times = Vec::new();
        let mut frame = surfaces.render(&choice.config).with_context(|| choice.label.clone())?;
        for _ in 0..experiment.repetitions_of(setting.scene) {
            frame = surfaces.render(&choice.config)?;
            times.push(frame.ms);
        }
        let own = if choice.config.visibility == LobeVisibility::None { &open } else { &seen };
        let row = SpecularRow {
            setting: setting.slug.clone(),
            slug: choice.slug(),
            experiment: experiment.name.clone(),
            scene: loaded.name.clone(),
            size: setting.size,
            label: choice.label.clone(),
            glossy: frame.glossy * scene.scene().lights.len() as u64,
            discarded: frame.discarded,
            rendered: frame.rendered.to_vec(),
            sampled: frame.sampled,
            rays: frame.rays,
            ms: median(times),
            nmse2: compared(&frame.radiance, &own.radiance)?,
            nmse2_visible: compared(&frame.radiance, &seen.radiance)?,
            noise: [own.noise, seen.noise],
            threads: provenance.threads,
            commit: provenance.commit.clone(),
            machine: provenance.machine.clone(),
        };
        let [image, map] = row.pictures().map(|file| folder.join(file));
        write_png(&image, width, height, &tone_mapped(&frame.radiance))?;
        write_png(&map, width, height, &level_map(&frame.levels, surfaces.gbuffer()))?;
        rows.push(row);
    }
    Ok(rows)
}

/// Returns pixels as an image of glossy surfaces to compare.
fn masked<'a>(pixels: &'a [Vec3], [width, height]: [u32; 2], glossy: &'a [bool]) -> Result<Image<'a>> {
    Ok(Image::new(width, height, pixels)?.with_mask(glossy)?)
}

/// Returns radiance as the camera sees it.
fn tone_mapped(radiance: &[Vec3]) -> Vec<[u8; 3]> {
    picture::image(radiance, &vec![Vec3::splat(PI); radiance.len()], picture::EXPOSURE)
}

/// Returns the levels of the fragments in the colours of all fragment maps.
fn level_map(levels: &[u8], gbuffer: &GBuffer) -> Vec<[u8; 3]> {
    let mut map = picture::level_map(levels, gbuffer);
    for (pixel, &level) in levels.iter().enumerate() {
        match level {
            DISCARDED => map[pixel] = COLORS[0],
            NOT_RENDERED if gbuffer.is_receiver(pixel) => map[pixel] = COLORS[1],
            _ => {}
        }
    }
    map
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXPERIMENT: &str = r#"
        title = "t"
        description = "d"
        size = [48, 36]
        repetitions = 1
        reference = { samples = 512, seed = 7 }
        scene = [{ name = "gallery" }]
        specular = [{ name = "nichols", spacing = 16, geometry = { depth = 9, curvature = 9 }, coarsest_level = [0, 4] }, { name = "nichols", visibility = "none" }]
        [[grid]]
        refiners = [{ name = "per-pixel" }]
        upsamplers = ["bilinear"]
        shadings = ["ratio"]
        samples = [4]
    "#;

    fn rows(scene: &str) -> Result<Vec<SpecularRow>> {
        let folder = tempfile::tempdir().unwrap();
        let mut experiment = Experiment::parse(EXPERIMENT, "tiny.toml").unwrap();
        experiment.set_scenes(&[scene.to_string()]);
        let settings = plan::settings(&experiment);
        let loaded = Loaded::new(&experiment.scenes[0], &Progress::hidden()).unwrap();
        let provenance = Provenance::default();
        let rows =
            measure(&experiment, folder.path(), &settings[0], &loaded, &provenance, &Progress::hidden())?;
        for file in rows.iter().flat_map(SpecularRow::pictures) {
            assert!(folder.path().join("pictures/gallery").join(file).is_file());
        }
        Ok(rows)
    }

    #[test]
    fn passes_are_measured_against_converged_lobes() {
        let rows = rows("gallery").unwrap();
        let [pixels, fragments, open] = &rows[..] else { panic!("{} rows", rows.len()) };
        for row in &rows {
            let rendered: u64 = row.rendered.iter().sum();
            assert!(row.discarded > 0 && row.discarded < row.glossy && rendered > 0, "{row:?}");
            assert!(row.nmse2 < 0.5 && row.ms > 0.0 && row.noise[0] < 0.01, "{row:?}");
        }
        assert!(pixels.rendered[0] + pixels.discarded == pixels.glossy);
        assert!(fragments.rendered.iter().skip(1).any(|&count| count > 0));
        assert!(open.rays == 0 && pixels.rays > 0 && open.nmse2_visible > open.nmse2);
        let table = crate::results::specular::table(&rows);
        assert_eq!((table.lines.len(), table.lines[0].cells.len()), (3, table.columns.len()));
    }

    #[test]
    fn matte_scenes_are_refused() {
        let fault = rows("contact").unwrap_err().to_string();
        assert!(fault.contains("contact: specular needs a scene with glossy surfaces"), "{fault}");
    }
}
