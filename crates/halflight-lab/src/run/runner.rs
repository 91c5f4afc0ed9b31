//! Renders, times and measures the rows of an experiment.

use std::path::PathBuf;

use anyhow::{Result, anyhow};
use halflight_image::memory;
use halflight_metrics::write_png;

use super::bench::Bench;
use super::device::Device;
use super::loaded::Loaded;
use super::progress::Progress;
use super::state::{Header, State};
use super::truth::Truth;
use super::{flicker, indirect, path, specular};
use crate::experiment::Experiment;
use crate::experiment::plan::{self, Row, Setting};
use crate::results::{Along, Outcome, Provenance, pictures};

/// Folders of an experiment's files.
#[derive(Clone, Debug)]
pub struct Places {
    /// Folder of the experiment's own files.
    pub out: PathBuf,
    /// Folder of references, which experiments share.
    pub references: PathBuf,
}

/// Runs what is left to run of an experiment. `each` is called whenever a setting is complete, with all rows so far.
///
/// # Errors
/// A scene cannot be loaded, a row not be rendered, a file not be written.
pub fn run(
    experiment: &Experiment,
    places: &Places,
    device: &Device,
    provenance: &Provenance,
    mut each: impl FnMut(&Outcome) -> Result<()>,
) -> Result<Outcome> {
    let (settings, rows) = plan::plan(experiment)?;
    if matches!(device, Device::Cpu) {
        for setting in &settings {
            check_memory(setting, rows.iter())?;
        }
    }
    fs_err::create_dir_all(&places.out)?;
    let mut state = State::open(&places.out.join("state.jsonl"), &Header::new(experiment, provenance)?)?;
    let here = |setting: &Setting| -> Vec<Row> {
        let scene = &experiment.scenes[setting.scene];
        rows.iter().filter(|row| row.is_in(scene)).map(|row| row.sized(setting.size)).collect()
    };
    let progress = Progress::new(settings.iter().map(|setting| here(setting).len() as u64).sum(), 0);
    if let Some(aside) = state.set_aside() {
        progress.say(&format!(
            "{} lines of another version of the experiment or program, or that cannot be read, are set aside in {}",
            aside.lines,
            aside.copy.display()
        ));
    }
    let mut loaded: Option<(usize, Loaded)> = None;
    for setting in &settings {
        let mine = here(setting);
        let folder = places.out.join("pictures").join(&setting.slug);
        let whole = |row: &&Row| {
            let finished = state.row(&setting.slug, &row.slug());
            finished.is_some_and(|row| {
                pictures(row, experiment).iter().all(|(_, file)| folder.join(file).is_file())
            })
        };
        let left: Vec<&Row> = mine.iter().filter(|row| !whole(row)).collect();
        progress.advance((mine.len() - left.len()) as u64);
        if left.is_empty() {
            continue;
        }
        fs_err::create_dir_all(&folder)?;
        let scene = match loaded.take() {
            Some((scene, loaded)) if scene == setting.scene => loaded,
            _ => {
                progress.now(format!("{}: loading", setting.label));
                Loaded::new(&experiment.scenes[setting.scene], &progress)?
            }
        };
        let truth = Truth::new(experiment, &places.references, setting, &scene, &progress)?;
        let [width, height] = setting.size;
        let picture = truth.picture(&truth.reference.irradiance);
        write_png(&folder.join("reference.png"), width, height, &picture)?;
        let light = flicker::Light::Direct;
        let frames =
            flicker::measure(light, experiment, &places.references, setting, &scene, &left, &progress)?;
        let work = match &experiment.path {
            Some(choice) => path::measure(experiment, choice, setting, &scene, &left, &progress)?,
            None => vec![Vec::new(); left.len()],
        };
        let along = frames.into_iter().zip(work).map(|(errors, work)| Along { errors, work });
        let left: Vec<(&Row, Along)> = left.into_iter().zip(along).collect();
        let bench =
            Bench { experiment, device, provenance, setting, scene: &scene, truth: &truth, folder: &folder };
        bench.run(&left, &mut state, &progress)?;
        loaded = Some((setting.scene, scene));
        each(&outcome(&settings, &rows, &state, provenance))?;
    }
    let mut passes = Vec::new();
    if !plan::specular(experiment).map_err(|message| anyhow!("{}: {message}", experiment.name))?.is_empty() {
        for setting in &settings {
            let scene = Loaded::new(&experiment.scenes[setting.scene], &progress)?;
            passes.extend(specular::measure(
                experiment,
                &places.out,
                setting,
                &scene,
                provenance,
                &progress,
            )?);
        }
    }
    let mut reflected = Vec::new();
    if !experiment.indirect.is_empty() {
        for setting in &settings {
            let scene = Loaded::new(&experiment.scenes[setting.scene], &progress)?;
            let Places { out, references } = places;
            let rows =
                indirect::measure(experiment, out, references, setting, &scene, provenance, &progress)?;
            reflected.extend(rows);
        }
    }
    progress.finish();
    let outcome =
        Outcome { specular: passes, indirect: reflected, ..outcome(&settings, &rows, &state, provenance) };
    each(&outcome)?;
    Ok(outcome)
}

/// Refuses sizes whose images do not fit into memory, before anything is rendered.
fn check_memory<'a>(setting: &Setting, rows: impl Iterator<Item = &'a Row>) -> Result<()> {
    let most = rows.map(|row| row.sized(setting.size).bytes_needed()).max().unwrap_or(0);
    let [width, height] = setting.size;
    memory::check(format!("{}: an image of {width}x{height} pixels", setting.label), most)
        .map_err(|fault| anyhow!("{fault}; choose a smaller --size"))
}

fn outcome(settings: &[Setting], rows: &[Row], state: &State, provenance: &Provenance) -> Outcome {
    let pairs = settings.iter().flat_map(|setting| rows.iter().map(move |row| (setting, row)));
    let finished = pairs.filter_map(|(setting, row)| state.row(&setting.slug, &row.slug()).cloned());
    Outcome {
        settings: settings.to_vec(),
        rows: finished.collect(),
        specular: Vec::new(),
        indirect: Vec::new(),
        provenance: provenance.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TINY: &str = r#"
        title = "tiny"
        description = "two rows, two sizes of light"
        size = [48, 36]
        repetitions = 2
        rivals = [{ name = "pcss", resolution = 64 }, { name = "filtered", samples = 2 }]
        light_scales = [1, 2]
        squared_error_factor = 9
        [reference]
        samples = 512
        seed = 9
        [[scene]]
        name = "contact"
        [[grid]]
        refiners = [{ name = "sfvt-gass" }, { name = "per-pixel" }]
        upsamplers = ["bilinear"]
        shadings = ["ratio"]
        samples = [16]
        [paper]
        source = "none"
        differs = "everything"
        reference_samples = 16
    "#;

    fn finish(places: &Places) -> Outcome {
        let experiment = Experiment::parse(TINY, "tiny.toml").unwrap();
        let provenance = Provenance { threads: 1, program: 1, ..Provenance::default() };
        run(&experiment, places, &Device::Cpu, &provenance, |_| Ok(())).unwrap()
    }

    #[test]
    fn a_run_measures_every_row_and_goes_on_where_it_was() {
        let root = tempfile::tempdir().unwrap();
        let places = Places { out: root.path().join("out"), references: root.path().join("references") };
        let whole = finish(&places);
        assert_eq!(whole.rows.len(), 8);
        let refiners: Vec<&str> = whole.rows[..4].iter().map(|row| row.record.refiner.as_str()).collect();
        assert_eq!(refiners, ["sfvt-gass", "per-pixel", "pcss", "filtered"]);
        for row in &whole.rows {
            let record = &row.record;
            // Shadow maps take no shadow rays, and no fragments.
            let mapped = record.visibility == "shadow-map";
            assert!(record.total_ms > 0.0 && (record.rays > 0 && record.fragments > 0) != mapped);
            assert!(record.grain.is_some() && (record.prepare_ms > 0.0 || !mapped));
            assert!(record.nmse2 > 0.0 && record.nmse2 < 0.05, "{}: {}", row.label, record.nmse2);
            // Its reference has as few samples as the row itself: farther from it than from the converged one.
            assert!(row.paper.unwrap().nmse > record.nmse);
        }
        // Two twice as long edges make four times the light, but no other row.
        assert!(whole.rows[4].record.sse > whole.rows[0].record.sse);

        // As if it had been stopped after the first row.
        let state = places.out.join("state.jsonl");
        let text = std::fs::read_to_string(&state).unwrap();
        let kept: String = text.split_inclusive('\n').take(2).collect();
        std::fs::write(&state, kept).unwrap();
        let resumed = finish(&places);
        assert_eq!(resumed.rows.len(), 8);
        assert_eq!(resumed.rows[0], whole.rows[0]);
        for (again, before) in resumed.rows.iter().zip(&whole.rows) {
            assert_eq!((again.record.sse, again.record.rays), (before.record.sse, before.record.rays));
        }
    }
}
