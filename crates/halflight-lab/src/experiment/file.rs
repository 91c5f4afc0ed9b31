//! Experiment files: bundled or at a path, with errors that name file, line and key.

use std::path::Path;

use anyhow::{Result, anyhow, bail};

use super::schema::Experiment;
use super::{bundled, check};

impl Experiment {
    /// Reads an experiment. `file` is its name in errors and, without folder and ending, the experiment's name.
    ///
    /// # Errors
    /// Text that is not TOML, keys that are unknown or missing, values out of range; each with its place.
    pub fn parse(text: &str, file: &str) -> Result<Self> {
        let mut experiment: Self = toml::from_str(text).map_err(|fault| {
            let line = fault.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            anyhow!("{file}, line {line}: {}", fault.message().lines().collect::<Vec<_>>().join(", "))
        })?;
        experiment.name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        check::check(&experiment).map_err(|message| anyhow!("{file}: {message}"))?;
        Ok(experiment)
    }

    /// Reads the bundled experiment of a name, or else the file at a path.
    ///
    /// # Errors
    /// Neither exists, the file cannot be read, or it does not parse.
    pub fn resolve(name: &str) -> Result<Self> {
        if let Some(text) = bundled::text(name) {
            return Self::parse(text, &format!("{name}.toml"));
        }
        if !Path::new(name).is_file() {
            let bundled: Vec<&str> = bundled::EXPERIMENTS.iter().map(|&(name, _)| name).collect();
            bail!(
                "there is no experiment `{name}`; bundled are {}, or give the path of a .toml file",
                bundled.join(", ")
            );
        }
        Self::parse(&fs_err::read_to_string(name)?, name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = r#"
        title = "t"
        description = "d"
        size = [64, 48]
        repetitions = 1
        [reference]
        samples = 64
        seed = 1
        [[scene]]
        name = "contact"
        [[grid]]
        refiners = [{ name = "per-pixel" }]
        upsamplers = ["bilinear"]
        shadings = ["ratio"]
        samples = [4]
    "#;

    fn fault(text: &str) -> String {
        Experiment::parse(text, "small.toml").unwrap_err().to_string()
    }

    #[test]
    fn a_small_one_parses() {
        let experiment = Experiment::parse(SMALL, "folder/small.toml").unwrap();
        assert_eq!(experiment.name, "small");
        assert_eq!((experiment.light_scales, experiment.sizes), (vec![1.0], vec![[64, 48]]));
        let several = SMALL.replace("[64, 48]", "[[64, 48], [128, 96]]");
        let mut experiment = Experiment::parse(&several, "small.toml").unwrap();
        assert_eq!(experiment.sizes, [[64, 48], [128, 96]]);
        experiment.make_quick();
        assert_eq!(experiment.sizes, [[16, 12], [32, 24]]);
    }

    #[test]
    fn faults_name_file_line_and_key() {
        let unknown = fault(&SMALL.replace("repetitions", "repetition"));
        assert!(unknown.starts_with("small.toml, line 5: unknown field `repetition`"), "{unknown}");
        let unknown = fault(&SMALL.replace("\"per-pixel\" }", "\"per-pixel\", level = 3 }"));
        assert!(
            unknown.contains("small.toml: grid 1: refiner `per-pixel` has no constant `level`"),
            "{unknown}"
        );
        let unknown = fault(&SMALL.replace("\"ratio\"", "\"ration\""));
        assert!(unknown.contains("line 14") && unknown.contains("ration"), "{unknown}");
        let same = fault(&SMALL.replace("seed = 1", "seed = 0"));
        assert!(same.contains("reference.seed is 0"), "{same}");
        let empty = fault(&SMALL.replace("[4]", "[]"));
        assert!(empty.contains("grid 1: samples is empty"), "{empty}");
        let size = fault(&SMALL.replace("[64, 48]", "[64]"));
        assert!(size.contains("line 4") && size.contains("a list of such pairs"), "{size}");
        let with = |line: &str| fault(&SMALL.replace("repetitions = 1", &format!("repetitions = 1\n{line}")));
        let sweep = with("sweep = \"resolution\"");
        assert!(sweep.contains("no row sets this constant"), "{sweep}");
        let front = with("front_page = true");
        assert!(front.contains("no row is the lattice at quality good"), "{front}");
        let backend = with("equal_time = \"rays\"");
        assert!(backend.contains("`rays`") && backend.contains("bvh, raster4d"), "{backend}");
        for (keys, expected) in [
            ("frames = 1, step = 0.1", "flicker.frames is 1, expected at least 2"),
            ("frames = 2, step = 0", "flicker.step is 0, expected seconds above 0"),
            ("frames = 2", "missing field `step`"),
        ] {
            let frames = with(&format!("flicker = {{ {keys} }}"));
            assert!(frames.contains(expected), "{frames}");
            let frames = with(&format!("path = {{ {keys} }}"));
            assert!(frames.contains(&expected.replace("flicker", "path")), "{frames}");
        }
        let count = fault(&SMALL.replace("[4]", "[5000]"));
        assert!(count.contains("5000 light samples"), "{count}");
    }

    #[test]
    fn an_unknown_name_lists_the_bundled_ones() {
        let fault = Experiment::resolve("defualt").unwrap_err().to_string();
        assert!(fault.contains("`defualt`") && fault.contains("koa-table1"), "{fault}");
    }
}
