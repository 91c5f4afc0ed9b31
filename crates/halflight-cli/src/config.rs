//! Configuration of a pipeline from a file, options and single settings, each laid over those before.

use std::path::Path;

use halflight_core::frame::LightSampling;
use halflight_cpu::config::{
    IndirectConfig, Named, PipelineConfig, Quality, RefinerConfig, UpsamplerConfig, VisibilityConfig,
};
use serde_json::{Map, Value, json};

use crate::args::Choices;

/// Keys of version 0.1 that are still read, and their names now.
const OLD_KEYS: &[(&str, &str)] = &[("rise", "discontinuity")];

/// Returns a key's name today.
fn todays(key: &str) -> &str {
    OLD_KEYS.iter().find(|(old, _)| *old == key).map_or(key, |(_, new)| new)
}

/// Returns the configuration that the options make.
///
/// # Errors
/// A message that names the file or option, and the key.
pub(crate) fn configure(choices: &Choices) -> Result<PipelineConfig, String> {
    let mut config = Layered::new()?;
    if let Some(path) = &choices.config {
        let within = |message: String| format!("{}: {message}", path.display());
        config.lay(&read(path).map_err(within)?).map_err(within)?;
    }
    if contradicts_target(choices) {
        config.leave_target();
    }
    config.lay(&options(choices))?;
    for setting in &choices.settings {
        let within = |message: String| format!("--set {setting}: {message}");
        config.lay(&parse_setting(setting).map_err(within)?).map_err(within)?;
    }
    let antialias_chosen = config.antialias;
    let mut config = config.finish()?;
    // GPUs render a frame for each sub-sample.
    if let RefinerConfig::Lattice(lattice) = config.refiner
        && lattice.target > 0.0
        && !antialias_chosen
        && choices.device == "cpu"
    {
        let has = |quality: &Quality| quality.lattice().visible_error == lattice.visible_error;
        config.antialias = Quality::ALL.into_iter().find(has).map_or(1, Quality::antialias);
    }
    if let RefinerConfig::Lattice(lattice) = config.refiner
        && lattice.certify
        && !config.visibility.certifies()
    {
        let name = config.visibility.name();
        return Err(format!(
            "visibility.name is {name}, which certifies nothing: to certify takes bvh, beam or auto"
        ));
    }
    Ok(config)
}

/// Returns the options as the keys that they stand for.
fn options(choices: &Choices) -> Value {
    let mut keys = Map::new();
    let mut put = |key: &str, value: Option<Value>| {
        if let Some(value) = value {
            keys.insert(key.to_owned(), value);
        }
    };
    let text = |option: &Option<String>| option.as_ref().map(|value| json!(value));
    put("width", choices.size.map(|(width, _)| json!(width)));
    put("height", choices.size.map(|(_, height)| json!(height)));
    let quality = choices.quality.as_deref().and_then(|name| name.parse::<Quality>().ok());
    let lattice = choices.error.is_some() || quality.is_some() || choices.certify;
    let mut refiner = choices.refiner.as_ref().map(|name| json!({ "name": name }));
    if lattice {
        refiner = Some(json!({ "name": "lattice", "certify": choices.certify }));
    }
    if let (Some(refiner), Some(error)) = (&mut refiner, choices.error) {
        refiner["target"] = json!(error);
    }
    if let (Some(refiner), Some(quality)) = (&mut refiner, quality) {
        let lattice = quality.lattice();
        (refiner["target"], refiner["visible_error"]) = (json!(lattice.target), json!(lattice.visible_error));
    }
    put("refiner", refiner);
    put("visibility", choices.visibility.as_ref().map(|name| json!({ "name": name })));
    put("upsampler", if lattice { Some(json!("lattice")) } else { text(&choices.upsampler) });
    put("shading", if lattice { Some(json!("ratio")) } else { text(&choices.shading) });
    put("indirect", text(&choices.indirect));
    put("seed", choices.seed.map(|seed| json!(seed)));
    put("antialias", choices.antialias.map(|count| json!(count)));
    // Some backends need samples in rows.
    let usual = LightSampling::default();
    let backend = choices.visibility.as_deref().and_then(VisibilityConfig::named);
    let rows = backend.map(|backend| backend.fit(usual).kind).filter(|&kind| kind != usual.kind);
    let rows = rows.map(|kind| json!(kind));
    let sampling = [
        ("count", choices.samples.map(|samples| json!(samples))),
        ("kind", text(&choices.pattern).or(rows)),
        ("sharing", text(&choices.sharing)),
    ];
    let sampling: Map<String, Value> =
        sampling.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?))).collect();
    put("sampling", Some(Value::Object(sampling)));
    Value::Object(keys)
}

/// Returns whether stages are chosen that the default error target does not go with.
fn contradicts_target(choices: &Choices) -> bool {
    let Choices { upsampler, shading, pattern, .. } = choices;
    let backend = choices.visibility.as_deref().and_then(VisibilityConfig::named).unwrap_or_default();
    !backend.certifies() || [upsampler, shading, pattern].into_iter().any(Option::is_some)
}

/// Reads a configuration file: JSON by its ending, TOML otherwise.
fn read(path: &Path) -> Result<Value, String> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json")) {
        return serde_json::from_str(&text).map_err(|error| error.to_string());
    }
    toml::from_str(&text).map_err(|error| error.to_string().trim_end().to_owned())
}

/// Parses `refiner.coarse_threshold=4` as `{"refiner": {"coarse_threshold": 4}}`. Values that are no JSON are text.
fn parse_setting(setting: &str) -> Result<Value, String> {
    let (key, value) = setting.split_once('=').ok_or("expected KEY=VALUE")?;
    let value = serde_json::from_str(value.trim()).unwrap_or_else(|_| json!(value.trim()));
    Ok(key.trim().rsplit('.').fold(value, |value, key| json!({ key: value })))
}

/// Keys of a configuration while layers are laid over it.
struct Layered {
    keys: Value,
    /// Set once a layer has chosen an upsampler.
    upsampler: bool,
    target: bool,
    /// Set once a layer has chosen a number of sub-samples.
    antialias: bool,
}

impl Layered {
    fn new() -> Result<Self, String> {
        let keys = serde_json::to_value(PipelineConfig::default()).map_err(|error| error.to_string())?;
        Ok(Self { keys, upsampler: false, target: false, antialias: false })
    }

    /// Lays `layer` over the keys so far. Every key is tried as soon as it is set, so that a fault has its name. A refiner brings
    /// the upsampler that fits it, and it or a number of light samples ends the default error target, unless these are chosen.
    fn lay(&mut self, layer: &Value) -> Result<(), String> {
        let mut layer = layer.clone();
        // A name alone stands for the stage with its default constants.
        for stage in [UpsamplerConfig::STAGE, IndirectConfig::STAGE] {
            if let Some(stage) = layer.get_mut(stage)
                && stage.is_string()
            {
                *stage = json!({ "name": stage });
            }
        }
        let layer = &layer;
        self.upsampler |= layer.get("upsampler").is_some();
        self.antialias |= layer.get("antialias").is_some();
        let target = layer.pointer("/refiner/target").is_some();
        self.target |= target;
        // A target alone bounds NMSE₂ and nothing else.
        if target
            && layer.pointer("/refiner/visible_error").is_none()
            && let Some(bound) = self.keys.pointer_mut("/refiner/visible_error")
        {
            *bound = json!(0.0);
        }
        if self.choose::<RefinerConfig>(layer)? && !self.upsampler {
            let upsampler = self.finish()?.refiner.upsampler();
            self.keys["upsampler"] = serde_json::to_value(upsampler).map_err(|error| error.to_string())?;
        }
        self.choose::<UpsamplerConfig>(layer)?;
        self.choose::<VisibilityConfig>(layer)?;
        self.choose::<IndirectConfig>(layer)?;
        if ["/refiner/name", "/sampling/count"].iter().any(|key| layer.pointer(key).is_some()) {
            self.leave_target();
        }
        self.lay_at("", layer)
    }

    /// Ends the default error target.
    fn leave_target(&mut self) {
        if !self.target
            && let Some(target) = self.keys.pointer_mut("/refiner/target")
        {
            *target = json!(0.0);
        }
    }

    /// Takes another stage if `layer` names one: its keys are others, so that its name comes first. Returns whether it did.
    fn choose<T: Named>(&mut self, layer: &Value) -> Result<bool, String> {
        let pointer = format!("/{}/name", T::STAGE);
        let Some(name) = layer.pointer(&pointer).filter(|&name| self.keys.pointer(&pointer) != Some(name))
        else {
            return Ok(false);
        };
        let stage = name
            .as_str()
            .and_then(T::named)
            .ok_or_else(|| format!("{}.name is {name}, expected one of {}", T::STAGE, T::NAMES.join(", ")))?;
        self.keys[T::STAGE] = serde_json::to_value(stage).map_err(|error| error.to_string())?;
        Ok(true)
    }

    fn lay_at(&mut self, pointer: &str, layer: &Value) -> Result<(), String> {
        let name = pointer.trim_start_matches('/').replace('/', ".");
        let known = self.keys.pointer(pointer).and_then(Value::as_object);
        let known = known.map(|known| known.keys().cloned().collect::<Vec<_>>());
        match (known, layer) {
            (Some(known), Value::Object(layer)) => {
                for (key, value) in layer {
                    let key = if known.contains(key) { key } else { todays(key) };
                    if !known.iter().any(|known| known == key) {
                        let of = if name.is_empty() { "" } else { " of " };
                        return Err(format!(
                            "unknown key {key}{of}{name}, expected one of {}",
                            known.join(", ")
                        ));
                    }
                    self.lay_at(&format!("{pointer}/{key}"), value)?;
                }
                Ok(())
            }
            (Some(known), _) => {
                Err(format!("{name} is {layer}, expected a table with keys {}", known.join(", ")))
            }
            (None, value) => {
                if let Some(known) = self.keys.pointer_mut(pointer) {
                    *known = value.clone();
                }
                self.finish().map(|_| ()).map_err(|error| format!("{name} is {value}: {error}"))
            }
        }
    }

    fn finish(&self) -> Result<PipelineConfig, String> {
        serde_json::from_value(self.keys.clone()).map_err(|error| error.to_string())
    }
}
