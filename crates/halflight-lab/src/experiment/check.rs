//! Validation of experiments beyond their syntax.

use halflight_core::subpixel;
use halflight_cpu::config::{Named, RefinerConfig, VisibilityConfig};
use halflight_cpu::refine::Quality;

use super::constants::parameter;
use super::plan;
use super::schema::{AnimationFrames, Experiment};

/// Returns what is wrong with an experiment, with its key and what would be right.
pub(super) fn check(experiment: &Experiment) -> Result<(), String> {
    if experiment.sizes.as_flattened().contains(&0) {
        return Err("size is 0 wide or high, expected at least [1, 1]".to_string());
    }
    if experiment.repetitions == 0 || experiment.scenes.iter().any(|scene| scene.repetitions == Some(0)) {
        return Err("repetitions is 0, expected at least 1".to_string());
    }
    if experiment.reference.seed == experiment.seed {
        return Err(format!(
            "reference.seed is {}, the rows' own: choose another, or the reference would contain their samples",
            experiment.seed
        ));
    }
    subpixel::offsets(experiment.antialias).map_err(|fault| format!("antialias: {fault}"))?;
    if let Some(scale) = experiment.light_scales.iter().find(|scale| !(**scale > 0.0 && scale.is_finite())) {
        return Err(format!("light_scales has {scale}, expected positive numbers"));
    }
    if !(experiment.error_scale > 0.0 && experiment.error_scale.is_finite()) {
        return Err(format!(
            "error_scale is {}, expected a positive share of the peak",
            experiment.error_scale
        ));
    }
    if let Some(target) = experiment.equal_error.iter().find(|target| !(**target > 0.0 && target.is_finite()))
    {
        return Err(format!("equal_error has {target}, expected positive NMSE₂ targets"));
    }
    for (table, choice) in [("flicker", experiment.flicker), ("path", experiment.path)] {
        let Some(AnimationFrames { frames, step }) = choice else { continue };
        if frames < 2 {
            return Err(format!("{table}.frames is {frames}, expected at least 2"));
        }
        if !(step > 0.0 && step.is_finite()) {
            return Err(format!("{table}.step is {step}, expected seconds above 0"));
        }
    }
    let empty = |list: &str| Err(format!("{list} is empty, expected at least one entry"));
    if experiment.sizes.is_empty() {
        return empty("size");
    }
    if experiment.light_scales.is_empty() {
        return empty("light_scales");
    }
    if experiment.scenes.is_empty() {
        return empty("scene");
    }
    if experiment.grids.is_empty() {
        return empty("grid");
    }
    for (number, grid) in (1..).zip(&experiment.grids) {
        let lists = [
            ("refiners", grid.refiners.len()),
            ("visibilities", grid.visibilities.len()),
            ("upsamplers", grid.upsamplers.len()),
            ("shadings", grid.shadings.len()),
            ("samples", grid.samples.len()),
            ("patterns", grid.patterns.len()),
            ("sharings", grid.sharings.len()),
        ];
        if let Some((list, _)) = lists.iter().find(|(_, length)| *length == 0) {
            return empty(&format!("grid {number}: {list}"));
        }
        let known = |name: &&String| experiment.scenes.iter().any(|scene| scene.name == **name);
        if let Some(name) = grid.except.iter().find(|name| !known(name)) {
            return Err(format!("grid {number}: except has `{name}`, which is no scene of the experiment"));
        }
    }
    if let Some(name) = &experiment.equal_time
        && VisibilityConfig::named(name).is_none()
    {
        let known = VisibilityConfig::NAMES.join(", ");
        return Err(format!("equal_time is `{name}`, expected a visibility backend: {known}"));
    }
    plan::specular(experiment)?;
    plan::indirect(experiment)?;
    let rows = plan::rows(experiment)?;
    let good = RefinerConfig::Lattice(Quality::Good.lattice());
    if experiment.front_page && !rows.iter().any(|row| row.config.refiner == good) {
        return Err("front_page is true, but no row is the lattice at quality good".to_string());
    }
    if let Some(constant) = &experiment.sweep
        && !rows.iter().any(|row| parameter(&row.parameters, constant).is_some())
    {
        return Err(format!("sweep is `{constant}`, but no row sets this constant to a number"));
    }
    Ok(())
}
