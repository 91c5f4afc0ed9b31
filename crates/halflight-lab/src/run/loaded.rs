//! Scenes of an experiment, with their changes.

use std::path::Path;

use anyhow::{Context as _, Result, anyhow};
use halflight_core::scene::Scene;
use halflight_cpu::prepared::PreparedScene;
use halflight_scene::Animation;

use super::progress::Progress;
use crate::experiment::{SceneChoice, plan};

/// Scene of an experiment.
pub(super) struct Loaded {
    /// Label of the scene.
    pub(super) name: String,
    /// Scene as the file has it, with its BVH.
    pub(super) prepared: PreparedScene,
    /// Animation of the scene, if it has one.
    pub(super) animation: Option<Animation>,
}

impl Loaded {
    pub(super) fn new(choice: &SceneChoice, progress: &Progress) -> Result<Self> {
        let loaded = if choice.parameters.is_empty() {
            halflight_scene::resolve(&choice.name)?
        } else {
            with_parameters(choice)?
        };
        let name = plan::scene_label(choice);
        for warning in &loaded.report.warnings {
            progress.say(&format!("{name}: {warning}"));
        }
        let halflight_scene::Loaded { scene, animation, .. } = loaded;
        let prepared = PreparedScene::new(scene).with_context(|| format!("scene {name}"))?;
        Ok(Self { name, prepared, animation })
    }

    /// Returns the scene with its lights scaled about their middles.
    pub(super) fn lit(&self, scale: f32) -> Result<PreparedScene> {
        if scale == 1.0 {
            return Ok(self.prepared.clone());
        }
        let scene = self.prepared.scene();
        let lights = scene.lights.iter().map(|light| light.scaled(scale)).collect();
        Ok(self.prepared.moved(Scene { lights, ..scene.clone() })?)
    }
}

/// Loads a scene whose generators get other parameters.
fn with_parameters(choice: &SceneChoice) -> Result<halflight_scene::Loaded> {
    let fault = |message: &str| anyhow!("scene {}: {message}", choice.name);
    let path = Path::new(&choice.name);
    let bundled = halflight_scene::bundled().iter().find(|(name, _)| *name == choice.name);
    let text = match bundled {
        Some((_, text)) => (*text).to_string(),
        None => fs_err::read_to_string(path)?,
    };
    let mut table: toml::Table = text.parse().map_err(|source: toml::de::Error| fault(source.message()))?;
    let meshes = table.get_mut("mesh").and_then(toml::Value::as_array_mut);
    let generated = meshes.into_iter().flatten().filter_map(toml::Value::as_table_mut);
    let mut changed = 0;
    for mesh in generated.filter(|mesh| mesh.contains_key("generator")) {
        mesh.extend(choice.parameters.clone());
        changed += 1;
    }
    if changed == 0 {
        return Err(fault("has parameters, but the scene has no generator to take them"));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(halflight_scene::parse(&table.to_string(), &format!("{}, changed", choice.name), folder)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_reach_the_generator() {
        let mut choice = SceneChoice {
            name: "hairball".to_string(),
            parameters: "triangles = 2000".parse().unwrap(),
            reference_samples: None,
            repetitions: None,
        };
        assert!(with_parameters(&choice).unwrap().scene.mesh.triangle_count() < 4000);
        choice.parameters = "triangle = 2000".parse().unwrap();
        let fault = with_parameters(&choice).unwrap_err().to_string();
        assert!(fault.contains("hairball, changed") && fault.contains("`triangle`"), "{fault}");
    }

    #[test]
    fn lights_are_scaled_about_their_middles() {
        let loaded = halflight_scene::resolve("contact").unwrap();
        let prepared = PreparedScene::new(loaded.scene).unwrap();
        let loaded = Loaded { name: String::new(), prepared, animation: None };
        let lights = |scale| loaded.lit(scale).unwrap().scene().lights[0];
        let (before, after) = (lights(1.0), lights(2.0));
        // Coordinates of a few metres, each a sum of four: a few units in the last place.
        assert!((before.centre() - after.centre()).length() < 1e-5);
        assert!((after.area() / before.area() - 4.0).abs() < 1e-5);
    }
}
