//! Constants of refiners and backends, as experiment files write them.

use halflight_cpu::config::{Named, RefinerConfig};
use halflight_cpu::refine::Quality;
use itertools::Itertools as _;
use serde::{Deserialize as _, Deserializer};
use serde_json::Value;

/// Stage with its constants, and the constants that were set, as text for tables.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Choice<T> {
    /// Configuration of the stage.
    pub(super) stage: T,
    /// `constant=value` of the constants that the file sets, separated by `;`.
    pub(super) parameters: String,
}

/// Expands `{ name = "…", constant = value or [values], … }` into every combination of the values.
///
/// # Errors
/// An unknown stage or constant, or a value of the wrong type, by name.
pub(super) fn expand<T: Named>(table: &toml::Table) -> Result<Vec<Choice<T>>, String> {
    let stage = T::STAGE;
    let names = T::NAMES.join(", ");
    let name = match table.get("name") {
        Some(toml::Value::String(name)) => name.as_str(),
        _ => {
            return Err(format!("a {stage} has no name, expected one of {names}"));
        }
    };
    let Some(default) = T::named(name) else {
        return Err(format!("unknown {stage} `{name}`, expected one of {names}"));
    };
    let default = serde_json::to_value(default).map_err(|fault| fault.to_string())?;
    let mut axes = Vec::new();
    let name = format!("{stage} `{name}`");
    flatten(&name, table, "", &default, &mut axes)?;
    if axes.is_empty() {
        let stage = serde_json::from_value(default).map_err(|fault| format!("{name}: {fault}"))?;
        return Ok(vec![Choice { stage, parameters: String::new() }]);
    }
    let settings = axes.iter().map(|(path, values)| values.iter().map(move |value| (path.as_str(), value)));
    let choice = |settings: Vec<(&str, &Value)>| {
        let said = |(path, value): &(&str, &Value)| format!("{}={value}", path[1..].replace('/', "."));
        let parameters = settings.iter().map(said).join(";");
        let mut config = default.clone();
        for (path, value) in settings {
            if let Some(place) = config.pointer_mut(path) {
                *place = value.clone();
            }
        }
        let stage =
            serde_json::from_value(config).map_err(|fault| format!("{name} with {parameters}: {fault}"))?;
        Ok(Choice { stage, parameters })
    };
    settings.multi_cartesian_product().map(choice).collect()
}

/// Expands all tables of a list.
///
/// # Errors
/// As [`expand`].
pub(super) fn expand_all<T: Named>(tables: &[toml::Table]) -> Result<Vec<Choice<T>>, String> {
    tables.iter().map(expand).flatten_ok().collect()
}

/// Lists the constants that `table` sets, as JSON pointers, with their values.
fn flatten(
    name: &str,
    table: &toml::Table,
    prefix: &str,
    default: &Value,
    axes: &mut Vec<(String, Vec<Value>)>,
) -> Result<(), String> {
    for (key, value) in table {
        if prefix.is_empty() && key == "name" {
            continue;
        }
        let path = format!("{prefix}/{key}");
        if default.pointer(&path).is_none() {
            return Err(format!("{name} has no constant `{key}`{}", known(default, prefix)));
        }
        match value {
            toml::Value::Table(inner) => flatten(name, inner, &path, default, axes)?,
            toml::Value::Array(values) if values.is_empty() => {
                return Err(format!("{name}: the sweep of `{key}` is empty"));
            }
            toml::Value::Array(values) => {
                let values = values.iter().map(json).collect::<Result<_, _>>()?;
                axes.push((path, values));
            }
            single => axes.push((path, vec![json(single)?])),
        }
    }
    Ok(())
}

fn json(value: &toml::Value) -> Result<Value, String> {
    serde_json::to_value(value).map_err(|fault| fault.to_string())
}

fn known(default: &Value, prefix: &str) -> String {
    let keys = default
        .pointer(prefix)
        .and_then(Value::as_object)
        .map(|object| object.keys().filter(|key| *key != "name").map(String::as_str).collect::<Vec<_>>());
    match keys {
        Some(keys) if !keys.is_empty() => format!(", it has {}", keys.join(", ")),
        _ => ", it has none".to_string(),
    }
}

/// Returns the value of a constant in a row's parameters and the parameters without it; `None` where they do not set it to a
/// number.
pub fn parameter(parameters: &str, constant: &str) -> Option<(f64, String)> {
    let (mine, others): (Vec<&str>, Vec<&str>) = parameters
        .split(';')
        .partition(|part| part.split_once('=').is_some_and(|(name, _)| name == constant));
    let [(_, value)] = mine.iter().filter_map(|part| part.split_once('=')).collect::<Vec<_>>()[..] else {
        return None;
    };
    Some((value.parse().ok()?, others.join(";")))
}

/// Returns the quality that a lattice row's parameters amount to; `None` where they set other bounds, or anything else.
pub fn quality(parameters: &str) -> Option<Quality> {
    let (target, others) = parameter(parameters, "target")?;
    let (visible, others) = parameter(&others, "visible_error")?;
    let is = |quality: &Quality| {
        let lattice = quality.lattice();
        (lattice.target, lattice.visible_error) == (target as f32, visible as f32)
    };
    Quality::ALL.into_iter().find(is).filter(|_| others.is_empty())
}

/// Reads the name of a refiner from a stored row; a former name gives the name of today.
pub(crate) fn refiner_name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    let name = String::deserialize(deserializer)?;
    Ok(RefinerConfig::named(&name).map_or(name, |refiner| refiner.name().to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_is_found_among_others() {
        let found = |parameters| parameter(parameters, "resolution");
        assert_eq!(found("resolution=128"), Some((128.0, String::new())));
        assert_eq!(found("bias=2;resolution=64;x={\"a\":1}"), Some((64.0, "bias=2;x={\"a\":1}".to_string())));
        for other in ["", "depth_bits=128", "resolution=fine", "x.resolution=3"] {
            assert_eq!(found(other), None, "{other}");
        }
    }

    #[test]
    fn qualities_are_known_by_their_bounds() {
        for known in Quality::ALL {
            let config = known.lattice();
            let text = format!(
                "name = 'lattice'\ntarget = {}\nvisible_error = {}",
                config.target, config.visible_error
            );
            assert_eq!(quality(&expanded(&text).unwrap()[0].parameters), Some(known));
        }
        for other in [
            "",
            "target=0.0001",
            "target=0.0003;visible_error=0.04",
            "certify=true;target=0.0001;visible_error=0.04",
        ] {
            assert_eq!(quality(other), None, "{other}");
        }
    }

    fn expanded(text: &str) -> Result<Vec<Choice<RefinerConfig>>, String> {
        expand(&toml::from_str(text).unwrap())
    }

    #[test]
    fn lists_are_sweeps_and_are_crossed() {
        let choices = expanded(
            "name = 'sfvt-gass'\nfine_threshold = [1, 2, 4]\ngeometry = { depth = [0.1, 0.2] }\ninclusive = true",
        )
        .unwrap();
        assert_eq!(choices.len(), 6);
        let RefinerConfig::SfvtGass(last) = choices[5].stage else { panic!("not the refiner asked for") };
        assert_eq!((last.fine_threshold, last.geometry.depth, last.inclusive), (4, 0.2, true));
        assert_eq!(choices[5].parameters, "fine_threshold=4;geometry.depth=0.2;inclusive=true");
    }

    #[test]
    fn former_names_are_read() {
        assert_eq!(expanded("name = 'full'").unwrap()[0].stage, RefinerConfig::PerPixel);
    }

    #[test]
    fn optional_constants_can_be_set() {
        let choices = expanded("name = 'nichols'\nirradiance_threshold = 0.5").unwrap();
        let RefinerConfig::Nichols(config) = choices[0].stage else { panic!("not the refiner asked for") };
        assert_eq!(config.irradiance_threshold, Some(0.5));
    }

    #[test]
    fn faults_say_what_there_is() {
        let fault = expanded("name = 'nichol'").unwrap_err();
        assert!(fault.contains("`nichol`") && fault.contains("sfvt-gass"), "{fault}");
        let fault = expanded("name = 'nichols'\nthreshold = 1").unwrap_err();
        assert!(fault.contains("`threshold`") && fault.contains("visibility_threshold"), "{fault}");
        let fault = expanded("name = 'nichols'\nincremental = 3").unwrap_err();
        assert!(fault.contains("incremental=3"), "{fault}");
    }
}
